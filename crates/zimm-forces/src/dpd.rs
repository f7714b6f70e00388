//! Dissipative particle dynamics.

mod coefficient;
mod conservative;
mod dissipative;
mod distribution;
mod estimates;
mod random;
mod range;
mod weight;

pub use coefficient::{Coefficient, SpeciesError, SpeciesMatrix};
pub use conservative::DpdConservative;
pub use dissipative::DpdDissipative;
pub use distribution::{Distribution, Normal, Uniform};
pub use random::DpdRandom;
pub use weight::{Power, Quadratic, SquareRoot, Weight};

use range::Range;
use zimm_core::{Central, Now, Pair, PairForce, ParameterError, Reads};

/// Dissipative particle dynamics: soft repulsion, and a thermostat that conserves momentum.
///
/// ```text
/// F_ij = [a_ij x - gamma w_D (e . v_ij) + (2 gamma kT / dt)^1/2 w_R theta_ij] e      x = 1 - r / r_c > 0
/// w_D = w_R^2 = x^s      theta_ij = theta_ji, mean 0, variance 1      e = r_ij / r
/// ```
///
/// Groot and Warren, J. Chem. Phys. 107, 4423 (1997); Fedosov, Karniadakis and Caswell, J. Chem. Phys. 132, 144103
/// (2010), equations 3 to 7. The strength of the noise is tied to the friction by Espanol and Warren, Europhys. Lett.
/// 30, 191 (1995); `kT` and `dt` are those of the clock, so a scene has one temperature and one time step.
///
/// The usual units are r_c = m = kT = 1. `a` is an energy over a length, `gamma` a mass over a time. Friction needs
/// velocities: the law is not for overdamped steppers.
///
/// ```
/// use zimm_core::{Now, Pair, PairForce};
/// use zimm_forces::Dpd;
///
/// let fluid = Dpd::new(25.0, 4.5)?;
/// assert_eq!(fluid.sigma(1.0), 3.0);
///
/// // Two particles half a cutoff apart that part at speed 2.
/// let pair = Pair { r2: 0.25, rv: 0.5 * 2.0, ..Pair::default() };
/// let force = fluid.force(&pair, &Now::default());
/// assert_eq!((0.5 * force.conservative, 0.5 * force.dissipative), (12.5, -2.25));
/// # Ok::<(), zimm_core::ParameterError>(())
/// ```
///
/// Mixtures, other ranges, weights and distributions:
///
/// ```
/// use zimm_forces::{Dpd, Normal, SpeciesMatrix, SquareRoot};
///
/// let repulsion = SpeciesMatrix::new([[25.0, 30.0], [30.0, 25.0]])?;
/// let mixture = Dpd::new(repulsion, 4.5)?
///     .with_cutoff(2.0)?
///     .with_weight(SquareRoot)
///     .with_distribution(Normal);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dpd<A = f64, W = Quadratic, N = Uniform> {
    a: A,
    gamma: f64,
    range: Range,
    weight: W,
    distribution: N,
}

impl<A: Coefficient> Dpd<A> {
    /// Repulsion `a` and friction `gamma`, with cutoff 1, quadratic weight and uniform noise.
    ///
    /// # Errors
    /// If `a` or `gamma` is not finite or below zero.
    pub fn new(a: A, gamma: f64) -> Result<Self, ParameterError> {
        a.check("a")?;
        Ok(Self {
            a,
            gamma: ParameterError::non_negative("gamma", gamma)?,
            range: Range::UNIT,
            weight: Quadratic,
            distribution: Uniform,
        })
    }
}

impl<A, W, N> Dpd<A, W, N> {
    /// The same law with another cutoff.
    ///
    /// # Errors
    /// If `cutoff` is not between 1e-100 and 1e100.
    pub fn with_cutoff(self, cutoff: f64) -> Result<Self, ParameterError> {
        let range = Range::new(cutoff)?;
        Ok(Self { range, ..self })
    }

    /// The same law with another weight of the friction.
    pub fn with_weight<V: Weight>(self, weight: V) -> Dpd<A, V, N> {
        Dpd {
            a: self.a,
            gamma: self.gamma,
            range: self.range,
            weight,
            distribution: self.distribution,
        }
    }

    /// The same law with another distribution of the noise.
    pub fn with_distribution<M: Distribution>(self, distribution: M) -> Dpd<A, W, M> {
        Dpd {
            a: self.a,
            gamma: self.gamma,
            range: self.range,
            weight: self.weight,
            distribution,
        }
    }
}

impl<A: Coefficient, W: Weight, N: Distribution> PairForce for Dpd<A, W, N> {
    const READS: Reads = DpdConservative::<A>::READS
        .or(DpdRandom::<W, N>::READS)
        .or(DpdDissipative::<W>::READS);

    #[inline(always)]
    fn cutoff(&self) -> f64 {
        self.range.cutoff()
    }

    #[inline(always)]
    fn force(&self, pair: &Pair, now: &Now) -> Central {
        let (overlap, inverse) = self.range.look(pair.r2);
        let w = self.weight.of_noise(overlap);
        let theta = self.distribution.draw(pair.noise);
        Central {
            conservative: conservative::formula(self.a.between(pair.species), overlap, inverse),
            dissipative: dissipative::formula(self.gamma, w, pair.rv, inverse),
            random: random::formula(self.gamma, now, w, theta, inverse),
        }
    }

    #[inline(always)]
    fn energy(&self, pair: &Pair) -> f64 {
        conservative::energy(self.a.between(pair.species), &self.range, pair.r2)
    }
}
