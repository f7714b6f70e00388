//! The finitely extensible spring of Warner.

use crate::length::length;
use zimm_core::{BondForce, ParameterError};

/// The finitely extensible spring: tension H Q / (1 - Q^2 / Q_0^2), U = -(H Q_0^2 / 2) ln(1 - Q^2 / Q_0^2).
///
/// The extensibility b = H Q_0^2 / kT says how far it is from Hookean; in equilibrium <Q^2> = 3 Q_0^2 / (b + 5). At the
/// limit Q_0 and beyond force and energy are infinite. Warner, Ind. Eng. Chem. Fundam. 11, 379 (1972); Fedosov,
/// Karniadakis and Caswell, J. Chem. Phys. 132, 144103 (2010), equation 8.
///
/// ```
/// use zimm_core::BondForce;
/// use zimm_forces::Fene;
///
/// let spring = Fene::with_extensibility(50.0, 5.0, 1.0)?;
/// assert_eq!((spring.stiffness(), spring.limit()), (2.0, 5.0));
///
/// // At half its limit a spring is a third stiffer than at rest.
/// assert!((spring.force(6.25) + 2.0 / 0.75).abs() < 1e-15);
/// assert!((spring.energy(6.25) - 7.192051811294521).abs() < 1e-14);
/// # Ok::<(), zimm_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fene {
    stiffness: f64,
    limit: f64,
}

impl Fene {
    /// Stiffness at rest H (force over length) and limit Q_0 (length).
    ///
    /// # Errors
    /// If `stiffness` is not finite and above zero, or `limit` is not between 1e-100 and 1e100.
    pub fn new(stiffness: f64, limit: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            stiffness: ParameterError::positive("stiffness", stiffness)?,
            limit: length("limit", limit)?,
        })
    }

    /// The spring of stiffness H = b kT / Q_0^2.
    ///
    /// # Errors
    /// If `b`, `kt` or the stiffness is not finite and above zero, or `limit` is not between 1e-100 and 1e100.
    pub fn with_extensibility(b: f64, limit: f64, kt: f64) -> Result<Self, ParameterError> {
        let b = ParameterError::positive("b", b)?;
        let kt = ParameterError::positive("kt", kt)?;
        let limit = length("limit", limit)?;
        Self::new(b * kt / (limit * limit), limit)
    }

    /// The extensibility b = H Q_0^2 / kT.
    pub fn extensibility(&self, kt: f64) -> f64 {
        self.stiffness * self.limit_squared() / kt
    }

    /// The stiffness at rest H.
    pub fn stiffness(&self) -> f64 {
        self.stiffness
    }

    #[inline(always)]
    fn limit_squared(&self) -> f64 {
        self.limit * self.limit
    }
}

impl BondForce for Fene {
    #[inline(always)]
    fn force(&self, r2: f64) -> f64 {
        let limit2 = self.limit_squared();
        // The difference before the quotient: exact near the limit, where 1 - Q^2 / Q_0^2 has lost its digits.
        -self.stiffness * (limit2 / (limit2 - r2.min(limit2)))
    }

    #[inline(always)]
    fn energy(&self, r2: f64) -> f64 {
        let limit2 = self.limit_squared();
        -0.5 * self.stiffness * limit2 * libm::log1p(-r2.min(limit2) / limit2)
    }

    #[inline(always)]
    fn limit(&self) -> f64 {
        self.limit
    }
}
