//! How friction and noise fade with distance.

use zimm_core::ParameterError;

/// The weight of DPD's friction and noise: w_D = w_R^2 = x^s of the overlap x = 1 - r / r_c.
///
/// Friction is always the square of what [`of_noise`](Self::of_noise) answers, so fluctuation and dissipation balance
/// whatever the weight.
pub trait Weight: Sync {
    /// The exponent s of the friction.
    fn exponent(&self) -> f64;

    /// The weight of the noise, w_R = x^(s/2), for an overlap from 0 to 1; zero at 0.
    fn of_noise(&self, overlap: f64) -> f64;
}

/// w_R = x, w_D = x^2: Groot and Warren's weight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quadratic;

impl Weight for Quadratic {
    fn exponent(&self) -> f64 {
        2.0
    }

    #[inline(always)]
    fn of_noise(&self, overlap: f64) -> f64 {
        overlap
    }
}

/// w_R = x^1/4, w_D = x^1/2: more friction at the same cutoff, hence a higher Schmidt number.
///
/// Fan, Phan-Thien, Chen, Wu and Ng, Phys. Fluids 18, 063102 (2006); Fedosov, Karniadakis and Caswell, J. Chem. Phys.
/// 132, 144103 (2010).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SquareRoot;

impl Weight for SquareRoot {
    fn exponent(&self) -> f64 {
        0.5
    }

    #[inline(always)]
    fn of_noise(&self, overlap: f64) -> f64 {
        overlap.sqrt().sqrt()
    }
}

/// w_R = x^(s/2), w_D = x^s, for any s above zero. Several times slower than the weights with a name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Power {
    half: f64,
}

impl Power {
    /// The weight of exponent `s`.
    ///
    /// # Errors
    /// If `s` is not finite and above zero.
    pub fn new(s: f64) -> Result<Self, ParameterError> {
        let half = 0.5 * ParameterError::positive("s", s)?;
        Ok(Self { half })
    }
}

impl Weight for Power {
    fn exponent(&self) -> f64 {
        2.0 * self.half
    }

    #[inline(always)]
    fn of_noise(&self, overlap: f64) -> f64 {
        libm::pow(overlap, self.half)
    }
}
