//! The friction of DPD.

use super::{Range, Weight};
use zimm_core::{Central, Now, Pair, PairForce, ParameterError, Reads};

/// F/r of the friction; `w` is the weight of the noise, whose square is that of the friction.
#[inline(always)]
pub(super) fn formula(gamma: f64, w: f64, rv: f64, inverse: f64) -> f64 {
    // r.v / r first: it is bounded by the speed, however close the particles.
    -gamma * (w * w) * (rv * inverse * inverse)
}

/// The friction of DPD alone: F = -gamma w_D (r_ij . v_ij) / r, w_D = (1 - r / r_c)^s.
///
/// Without [`DpdRandom`](super::DpdRandom) of the same `gamma`, weight and cutoff it only cools. Espanol and Warren,
/// Europhys. Lett. 30, 191 (1995).
///
/// ```
/// use zimm_core::{Now, Pair, PairForce};
/// use zimm_forces::{DpdDissipative, Quadratic};
///
/// let law = DpdDissipative::new(4.0, Quadratic, 1.0)?;
/// let parting = Pair { r2: 0.25, rv: 0.5, ..Pair::default() };
/// let passing = Pair { r2: 0.25, rv: 0.0, ..Pair::default() };
/// assert_eq!(law.force(&parting, &Now::default()).total(), -2.0);
/// assert_eq!(law.force(&passing, &Now::default()).total(), 0.0);
/// # Ok::<(), zimm_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DpdDissipative<W = super::Quadratic> {
    gamma: f64,
    weight: W,
    range: Range,
}

impl<W: Weight> DpdDissipative<W> {
    /// Friction `gamma` (mass over time) up to `cutoff`.
    ///
    /// # Errors
    /// If `gamma` is not finite or below zero, or `cutoff` is not between 1e-100 and 1e100.
    pub fn new(gamma: f64, weight: W, cutoff: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            gamma: ParameterError::non_negative("gamma", gamma)?,
            weight,
            range: Range::new(cutoff)?,
        })
    }
}

impl<W: Weight> PairForce for DpdDissipative<W> {
    const READS: Reads = Reads {
        velocity: true,
        ..Reads::NOTHING
    };

    #[inline(always)]
    fn cutoff(&self) -> f64 {
        self.range.cutoff()
    }

    #[inline(always)]
    fn force(&self, pair: &Pair, _: &Now) -> Central {
        let (overlap, inverse) = self.range.look(pair.r2);
        let w = self.weight.of_noise(overlap);
        Central::dissipative(formula(self.gamma, w, pair.rv, inverse))
    }
}
