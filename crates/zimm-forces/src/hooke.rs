//! The linear spring.

use zimm_core::{BondForce, ParameterError};

/// The linear spring: tension H Q, U = H Q^2 / 2.
///
/// The beads of Rouse's chain (J. Chem. Phys. 21, 1272, 1953). In equilibrium <Q^2> = 3 kT / H.
///
/// ```
/// use zimm_core::BondForce;
/// use zimm_forces::Hooke;
///
/// let spring = Hooke::new(3.0)?;
/// assert_eq!((spring.force(4.0), spring.energy(4.0)), (-3.0, 6.0));
/// # Ok::<(), zimm_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hooke {
    stiffness: f64,
}

impl Hooke {
    /// Stiffness H (force over length).
    ///
    /// # Errors
    /// If `stiffness` is not finite and above zero.
    pub fn new(stiffness: f64) -> Result<Self, ParameterError> {
        let stiffness = ParameterError::positive("stiffness", stiffness)?;
        Ok(Self { stiffness })
    }
}

impl BondForce for Hooke {
    #[inline(always)]
    fn force(&self, _: f64) -> f64 {
        -self.stiffness
    }

    #[inline(always)]
    fn energy(&self, r2: f64) -> f64 {
        0.5 * self.stiffness * r2
    }
}
