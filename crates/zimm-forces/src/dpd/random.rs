//! The noise of DPD.

use super::{Distribution, Range, Weight};
use zimm_core::{Central, Now, Pair, PairForce, ParameterError, Reads};

/// F/r of the noise. The root is the same for all pairs of a step, and the compiler takes it out of the loop.
#[inline(always)]
pub(super) fn formula(gamma: f64, now: &Now, w: f64, theta: f64, inverse: f64) -> f64 {
    (2.0 * gamma * now.kt / now.dt).sqrt() * w * theta * inverse
}

/// The noise of DPD alone: F = (2 gamma kT / dt)^1/2 w_R theta_ij, w_R = (1 - r / r_c)^(s/2), with theta_ij = theta_ji
/// of mean zero and variance one.
///
/// It is given the friction that it balances; `kT` and `dt` are those of the clock. Without
/// [`DpdDissipative`](super::DpdDissipative) of the same `gamma`, weight and cutoff it only heats. Espanol and Warren,
/// Europhys. Lett. 30, 191 (1995).
///
/// ```
/// use zimm_core::{Now, Pair, PairForce, noise::{Domain, Noise}};
/// use zimm_forces::{DpdRandom, Quadratic, Uniform};
///
/// let law = DpdRandom::new(2.0, Quadratic, Uniform, 1.0)?;
/// let noise = Noise::new(1, 0);
/// let pair = Pair { r2: 0.25, noise: noise.site(0) + noise.site(1), ..Pair::default() };
/// let theta = pair.noise.uniform(Domain::DPD);
/// assert_eq!(law.force(&pair, &Now::default()).total(), 2.0 * theta);
/// assert_eq!(law.force(&Pair { r2: 1.0, ..pair }, &Now::default()).total(), 0.0);
/// # Ok::<(), zimm_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DpdRandom<W = super::Quadratic, N = super::Uniform> {
    gamma: f64,
    weight: W,
    distribution: N,
    range: Range,
}

impl<W: Weight, N: Distribution> DpdRandom<W, N> {
    /// Noise that balances a friction `gamma` (mass over time) up to `cutoff`.
    ///
    /// # Errors
    /// If `gamma` is not finite or below zero, or `cutoff` is not between 1e-100 and 1e100.
    pub fn new(
        gamma: f64,
        weight: W,
        distribution: N,
        cutoff: f64,
    ) -> Result<Self, ParameterError> {
        Ok(Self {
            gamma: ParameterError::non_negative("gamma", gamma)?,
            weight,
            distribution,
            range: Range::new(cutoff)?,
        })
    }
}

impl<W: Weight, N: Distribution> PairForce for DpdRandom<W, N> {
    const READS: Reads = Reads {
        noise: true,
        ..Reads::NOTHING
    };

    #[inline(always)]
    fn cutoff(&self) -> f64 {
        self.range.cutoff()
    }

    #[inline(always)]
    fn force(&self, pair: &Pair, now: &Now) -> Central {
        let (overlap, inverse) = self.range.look(pair.r2);
        let w = self.weight.of_noise(overlap);
        let theta = self.distribution.draw(pair.noise);
        Central::random(formula(self.gamma, now, w, theta, inverse))
    }
}
