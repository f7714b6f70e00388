//! The linear spring with a natural length.

use crate::length::{distance, length};
use zimm_core::{BondForce, ParameterError};

/// The linear spring with a natural length: tension H (Q - l), U = H (Q - l)^2 / 2.
///
/// A stiff one is nearly a rod of length l. Fraenkel, J. Chem. Phys. 20, 642 (1952).
///
/// ```
/// use zimm_core::BondForce;
/// use zimm_forces::Fraenkel;
///
/// let spring = Fraenkel::new(8.0, 1.0)?;
/// assert_eq!((spring.force(4.0), spring.energy(4.0)), (-4.0, 4.0));
/// # Ok::<(), zimm_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fraenkel {
    stiffness: f64,
    natural_length: f64,
}

impl Fraenkel {
    /// Stiffness H (force over length) and natural length l.
    ///
    /// # Errors
    /// If `stiffness` is not finite and above zero, or `natural_length` is not between 1e-100 and 1e100.
    pub fn new(stiffness: f64, natural_length: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            stiffness: ParameterError::positive("stiffness", stiffness)?,
            natural_length: length("natural length", natural_length)?,
        })
    }
}

impl BondForce for Fraenkel {
    #[inline(always)]
    fn force(&self, r2: f64) -> f64 {
        let r = distance(r2);
        self.stiffness * ((self.natural_length - r) / r)
    }

    #[inline(always)]
    fn energy(&self, r2: f64) -> f64 {
        let stretch = r2.sqrt() - self.natural_length;
        0.5 * self.stiffness * (stretch * stretch)
    }
}
