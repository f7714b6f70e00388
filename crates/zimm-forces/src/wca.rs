//! The repulsive part of the Lennard-Jones law.

use crate::length::length;
use zimm_core::{Central, Now, Pair, PairForce, ParameterError};

/// The Lennard-Jones law up to its minimum at r_c = 2^1/6 sigma, lifted by epsilon: hard beads, force and energy
/// without a jump.
///
/// ```text
/// U = 4 epsilon ((sigma / r)^12 - (sigma / r)^6) + epsilon = epsilon x^2      x = (r_c / r)^6 - 1 > 0
/// F = 24 epsilon (2 (sigma / r)^12 - (sigma / r)^6) / r = 12 epsilon x (1 + x) / r
/// ```
///
/// At distance zero both are infinite, which a stepper reports. Weeks, Chandler and Andersen, J. Chem. Phys. 54, 5237
/// (1971).
///
/// ```
/// use zimm_core::{Now, Pair, PairForce};
/// use zimm_forces::Wca;
///
/// let law = Wca::new(1.0, 1.0)?;
/// let pair = Pair { r2: 1.0, ..Pair::default() };
/// assert!((law.force(&pair, &Now::default()).total() - 24.0).abs() < 1e-13);
/// assert!((law.energy(&pair) - 1.0).abs() < 1e-14);
/// # Ok::<(), zimm_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wca {
    epsilon: f64,
    cutoff: f64,
}

const SIXTH_ROOT_OF_2: f64 = 1.122_462_048_309_373;

impl Wca {
    /// Strength `epsilon` (energy) and diameter `sigma` (length).
    ///
    /// # Errors
    /// If `epsilon` is not finite and above zero, or `sigma` is not between 1e-100 and 1e100.
    pub fn new(epsilon: f64, sigma: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            epsilon: ParameterError::positive("epsilon", epsilon)?,
            cutoff: SIXTH_ROOT_OF_2 * length("sigma", sigma)?,
        })
    }

    /// x = (r_c / r)^6 - 1, zero at and beyond the cutoff.
    #[inline(always)]
    fn excess(&self, r2: f64) -> f64 {
        let c2 = self.cutoff * self.cutoff / r2;
        (c2 * c2 * c2 - 1.0).max(0.0)
    }
}

impl PairForce for Wca {
    #[inline(always)]
    fn cutoff(&self) -> f64 {
        self.cutoff
    }

    #[inline(always)]
    fn force(&self, pair: &Pair, _: &Now) -> Central {
        let x = self.excess(pair.r2);
        Central::conservative(12.0 * self.epsilon * (x * (1.0 + x)) / pair.r2)
    }

    #[inline(always)]
    fn energy(&self, pair: &Pair) -> f64 {
        let x = self.excess(pair.r2);
        self.epsilon * x * x
    }
}
