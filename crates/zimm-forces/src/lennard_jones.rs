//! The Lennard-Jones law.

use crate::length::length;
use zimm_core::{Central, Now, Pair, PairForce, ParameterError};

/// U = 4 epsilon ((sigma / r)^12 - (sigma / r)^6) - U_c up to the cutoff, with U_c such that U ends at zero.
///
/// The force, 24 epsilon (2 (sigma / r)^12 - (sigma / r)^6) / r, is cut and not shifted: it jumps at the cutoff. At
/// distance zero force and energy are infinite, which a stepper reports. Lennard-Jones, Proc. Phys. Soc. 43, 461
/// (1931).
///
/// ```
/// use zimm_core::{Now, Pair, PairForce};
/// use zimm_forces::LennardJones;
///
/// let law = LennardJones::new(1.0, 1.0, 2.5)?;
/// let pair = Pair { r2: 1.0, ..Pair::default() };
/// assert_eq!(law.force(&pair, &Now::default()).total(), 24.0);
/// assert!((law.energy(&pair) - 0.016316891136).abs() < 1e-12);
/// # Ok::<(), zimm_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LennardJones {
    epsilon: f64,
    sigma_squared: f64,
    cutoff: f64,
    cutoff_energy: f64,
}

impl LennardJones {
    /// Depth `epsilon` (energy) and diameter `sigma`, up to `cutoff` (lengths).
    ///
    /// # Errors
    /// If `epsilon` is not finite and above zero, a length is not between 1e-100 and 1e100, or the energy at
    /// the cutoff is not finite.
    pub fn new(epsilon: f64, sigma: f64, cutoff: f64) -> Result<Self, ParameterError> {
        let (sigma, cutoff) = (length("sigma", sigma)?, length("cutoff", cutoff)?);
        let mut law = Self {
            epsilon: ParameterError::positive("epsilon", epsilon)?,
            sigma_squared: sigma * sigma,
            cutoff,
            cutoff_energy: 0.0,
        };
        let cutoff_energy = law.whole_energy(cutoff * cutoff);
        law.cutoff_energy = ParameterError::finite("energy at the cutoff", cutoff_energy)?;
        Ok(law)
    }

    /// sigma^2 / r^2 and (sigma / r)^6.
    #[inline(always)]
    fn powers(&self, r2: f64) -> (f64, f64) {
        let s2 = self.sigma_squared / r2;
        (s2, s2 * s2 * s2)
    }

    #[inline(always)]
    fn whole_energy(&self, r2: f64) -> f64 {
        let (_, s6) = self.powers(r2);
        4.0 * self.epsilon * (s6 * (s6 - 1.0))
    }
}

impl PairForce for LennardJones {
    #[inline(always)]
    fn cutoff(&self) -> f64 {
        self.cutoff
    }

    #[inline(always)]
    fn force(&self, pair: &Pair, _: &Now) -> Central {
        let (s2, s6) = self.powers(pair.r2);
        let f = 24.0 * self.epsilon / self.sigma_squared * (s2 * s6 * (2.0 * s6 - 1.0));
        let within = pair.r2 < self.cutoff * self.cutoff;
        Central::conservative(if within { f } else { 0.0 })
    }

    #[inline(always)]
    fn energy(&self, pair: &Pair) -> f64 {
        let within = pair.r2 < self.cutoff * self.cutoff;
        if within {
            self.whole_energy(pair.r2) - self.cutoff_energy
        } else {
            0.0
        }
    }
}
