//! The worm-like chain as a spring.

use crate::length::length;
use zimm_core::{BondForce, ParameterError};

/// The spring of a worm-like chain, after Marko and Siggia: with q = Q / Q_0,
///
/// ```text
/// tension = (H Q_0 / 6) (4 q - 1 + 1 / (1 - q)^2)      U = (H Q^2 / 6) (2 + 1 / (1 - q))
/// ```
///
/// H is the stiffness at rest, as in the other springs, and Q_0 the contour length; there and beyond force and energy
/// are infinite. In terms of a persistence length P, H = 3 kT / (2 P Q_0) and the tension is
/// (kT / P) (1 / (4 (1 - q)^2) - 1/4 + q): [`with_persistence_length`](Self::with_persistence_length). The Kuhn length
/// is 2 P. Marko and Siggia, Macromolecules 28, 8759 (1995).
///
/// ```
/// use zimm_core::BondForce;
/// use zimm_forces::MarkoSiggia;
///
/// // At half its contour length the tension is 1.25 kT / P.
/// let dna = MarkoSiggia::with_persistence_length(0.05, 1.0, 1.0)?;
/// assert!((0.5 * dna.force(0.25) + 1.25 / 0.05).abs() < 1e-13);
/// assert!((dna.energy(0.25) - 0.25 / 0.05).abs() < 1e-14);
/// # Ok::<(), zimm_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarkoSiggia {
    stiffness: f64,
    limit: f64,
}

impl MarkoSiggia {
    /// Stiffness at rest H (force over length) and contour length Q_0.
    ///
    /// # Errors
    /// If `stiffness` is not finite and above zero, or `limit` is not between 1e-100 and 1e100.
    pub fn new(stiffness: f64, limit: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            stiffness: ParameterError::positive("stiffness", stiffness)?,
            limit: length("limit", limit)?,
        })
    }

    /// A chain of persistence length P and contour length Q_0 at thermal energy `kt`: H = 3 kT / (2 P Q_0).
    ///
    /// # Errors
    /// If `kt` or the stiffness is not finite and above zero, or a length is not between 1e-100 and 1e100.
    pub fn with_persistence_length(
        persistence: f64,
        contour: f64,
        kt: f64,
    ) -> Result<Self, ParameterError> {
        let kt = ParameterError::positive("kt", kt)?;
        let persistence = length("persistence length", persistence)?;
        let contour = length("contour length", contour)?;
        Self::new(1.5 * kt / (persistence * contour), contour)
    }

    /// The stiffness at rest H.
    pub fn stiffness(&self) -> f64 {
        self.stiffness
    }

    /// q, and 1 / (1 - q) = Q_0 (Q_0 + Q) / (Q_0^2 - Q^2): exact near the limit, where 1 - q has lost its digits.
    #[inline(always)]
    fn stretch(&self, r2: f64) -> (f64, f64) {
        let limit2 = self.limit * self.limit;
        let r2 = r2.min(limit2);
        let r = r2.sqrt();
        (
            r / self.limit,
            self.limit * (self.limit + r) / (limit2 - r2),
        )
    }
}

impl BondForce for MarkoSiggia {
    #[inline(always)]
    fn force(&self, r2: f64) -> f64 {
        // The tension divided by Q, with the Q taken out of the bracket so that nothing is left of 0 / 0 at rest.
        let (q, steep) = self.stretch(r2);
        -self.stiffness / 6.0 * (4.0 + (2.0 - q) * (steep * steep))
    }

    #[inline(always)]
    fn energy(&self, r2: f64) -> f64 {
        let (_, steep) = self.stretch(r2);
        self.stiffness / 6.0 * r2 * (2.0 + steep)
    }

    #[inline(always)]
    fn limit(&self) -> f64 {
        self.limit
    }
}
