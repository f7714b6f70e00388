//! The soft repulsion of DPD.

use super::{Coefficient, Range};
use zimm_core::{Central, Now, Pair, PairForce, ParameterError, Reads};

/// F/r of the repulsion.
#[inline(always)]
pub(super) fn formula(a: f64, overlap: f64, inverse: f64) -> f64 {
    a * overlap * inverse
}

#[inline(always)]
pub(super) fn energy(a: f64, range: &Range, r2: f64) -> f64 {
    let (overlap, _) = range.look(r2);
    0.5 * a * range.cutoff() * overlap * overlap
}

/// The soft repulsion of DPD alone: F = a_ij (1 - r / r_c), U = (a_ij r_c / 2) (1 - r / r_c)^2.
///
/// For thermostats of another kind (Lowe-Andersen, Langevin). Groot and Warren, J. Chem. Phys. 107, 4423 (1997).
///
/// ```
/// use zimm_core::{Now, Pair, PairForce};
/// use zimm_forces::DpdConservative;
///
/// let law = DpdConservative::new(18.75, 2.0)?;
/// let pair = Pair { r2: 1.0, ..Pair::default() };
/// assert_eq!(law.force(&pair, &Now::default()).total(), 9.375);
/// assert_eq!(law.energy(&pair), 4.6875);
/// # Ok::<(), zimm_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DpdConservative<A = f64> {
    a: A,
    range: Range,
}

impl<A: Coefficient> DpdConservative<A> {
    /// Repulsion `a` (energy over length) up to `cutoff`.
    ///
    /// # Errors
    /// If `a` is not finite or below zero, or `cutoff` is not between 1e-100 and 1e100.
    pub fn new(a: A, cutoff: f64) -> Result<Self, ParameterError> {
        a.check("a")?;
        let range = Range::new(cutoff)?;
        Ok(Self { a, range })
    }
}

impl<A: Coefficient> PairForce for DpdConservative<A> {
    const READS: Reads = Reads {
        species: A::READS_SPECIES,
        ..Reads::NOTHING
    };

    #[inline(always)]
    fn cutoff(&self) -> f64 {
        self.range.cutoff()
    }

    #[inline(always)]
    fn force(&self, pair: &Pair, _: &Now) -> Central {
        let (overlap, inverse) = self.range.look(pair.r2);
        Central::conservative(formula(self.a.between(pair.species), overlap, inverse))
    }

    #[inline(always)]
    fn energy(&self, pair: &Pair) -> f64 {
        energy(self.a.between(pair.species), &self.range, pair.r2)
    }
}
