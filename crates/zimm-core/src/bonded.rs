//! Springs and their driver.

use crate::{Boundary, ForceError, ForceField, Frame, Item, Reads, Tally};
use glam::DVec3;

/// A spring between two beads: one formula.
///
/// ```
/// use zimm_core::BondForce;
///
/// /// F = -H Q.
/// struct Hooke {
///     stiffness: f64,
/// }
///
/// impl BondForce for Hooke {
///     fn force(&self, _: f64) -> f64 {
///         -self.stiffness
///     }
///
///     fn energy(&self, r2: f64) -> f64 {
///         0.5 * self.stiffness * r2
///     }
/// }
///
/// let spring = Hooke { stiffness: 2.0 };
/// assert_eq!((spring.force(9.0), spring.energy(9.0)), (-2.0, 9.0));
/// ```
pub trait BondForce: Sync {
    /// Force on the first bead divided by the length, negative when attractive, at a squared length.
    fn force(&self, r2: f64) -> f64;

    /// Potential energy at a squared length.
    fn energy(&self, r2: f64) -> f64;

    /// The length at which the law ends. Reaching it is an error of the driver, so the law need not look.
    fn limit(&self) -> f64 {
        f64::INFINITY
    }
}

/// No force: the null spring.
impl BondForce for () {
    #[inline(always)]
    fn force(&self, _: f64) -> f64 {
        0.0
    }

    #[inline(always)]
    fn energy(&self, _: f64) -> f64 {
        0.0
    }
}

macro_rules! sum_of_springs {
    ($($law:ident . $n:tt),+) => {
        impl<$($law: BondForce),+> BondForce for ($($law,)+) {
            #[inline(always)]
            fn force(&self, r2: f64) -> f64 {
                0.0 $(+ self.$n.force(r2))+
            }

            #[inline(always)]
            fn energy(&self, r2: f64) -> f64 {
                0.0 $(+ self.$n.energy(r2))+
            }

            #[inline(always)]
            fn limit(&self) -> f64 {
                f64::INFINITY$(.min(self.$n.limit()))+
            }
        }
    };
}
sum_of_springs!(A.0);
sum_of_springs!(A.0, B.1);
sum_of_springs!(A.0, B.1, C.2);

/// Bonded forces: a spring law and the pairs of identities that it joins. Bonds go by the nearest image.
///
/// A law between any two particles is no spring, so this does not compile:
///
/// ```compile_fail,E0277
/// # use zimm_core::{Bonded, Central, Clock, DVec3, ForceField, Now, Open, Pair, PairForce, Particles, System};
/// struct Repulsion;
///
/// impl PairForce for Repulsion {
///     fn cutoff(&self) -> f64 {
///         1.0
///     }
///
///     fn force(&self, _: &Pair, _: &Now) -> Central {
///         Central::conservative(1.0)
///     }
/// }
///
/// let system = System::new(Open, Particles::new(vec![])?, Clock::new(0.01, 1.0, 1)?);
/// let mut field = Bonded::new(Repulsion, vec![[0, 1]]);
/// field.accumulate(&system.frame(), &mut [], &mut ())?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Bonded<S> {
    spring: S,
    bonds: Vec<[u32; 2]>,
}

impl<S> Bonded<S> {
    /// The same spring along every bond.
    pub fn new(spring: S, bonds: Vec<[u32; 2]>) -> Self {
        Self { spring, bonds }
    }

    /// The spring law.
    pub fn spring(&self) -> &S {
        &self.spring
    }

    /// The identities joined.
    pub fn bonds(&self) -> &[[u32; 2]] {
        &self.bonds
    }
}

impl<B: Boundary, S: BondForce> ForceField<B> for Bonded<S> {
    const READS: Reads = Reads::NOTHING;
    const CONSERVES_MOMENTUM: bool = true;

    fn accumulate<T: Tally>(
        &mut self,
        frame: &Frame<'_, B>,
        forces: &mut [DVec3],
        tally: &mut T,
    ) -> Result<(), ForceError> {
        let (limit, reach) = (self.spring.limit(), frame.boundary.reach());
        let particles = frame.len();
        for (bond, &[i, j]) in self.bonds.iter().enumerate() {
            let missing = |identity| ForceError::NoSuchParticle {
                bond,
                identity,
                particles,
            };
            let first = frame.place(i).ok_or_else(|| missing(i))?;
            let second = frame.place(j).ok_or_else(|| missing(j))?;
            let r = frame
                .boundary
                .min_image(frame.positions[first] - frame.positions[second]);
            let r2 = r.length_squared();
            let shorter_than = |length: f64| r2 < length * length;
            if !shorter_than(limit) {
                return Err(ForceError::Overstretched {
                    bond,
                    i,
                    j,
                    length: r2.sqrt(),
                    limit,
                });
            }
            if !shorter_than(reach) {
                return Err(ForceError::BeyondCell {
                    bond,
                    i,
                    j,
                    length: r2.sqrt(),
                    reach,
                });
            }
            let force = self.spring.force(r2) * r;
            forces[first] += force;
            forces[second] -= force;
            let at = frame.positions[first];
            tally.hear(Item::Spring, at, r, force, &|| self.spring.energy(r2));
        }
        Ok(())
    }
}
