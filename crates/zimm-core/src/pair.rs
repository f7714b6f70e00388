//! Non-bonded laws: what a pair is, what a law reads, what it answers.

use crate::{Now, noise::Site};

/// What a law reads besides the separation. Known at compile time, so that what nobody reads is never loaded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reads {
    /// [`Pair::rv`].
    pub velocity: bool,
    /// [`Pair::noise`].
    pub noise: bool,
    /// [`Pair::species`].
    pub species: bool,
}

impl Reads {
    /// The separation only.
    pub const NOTHING: Self = Self {
        velocity: false,
        noise: false,
        species: false,
    };

    /// What either of two laws reads.
    pub const fn or(self, other: Self) -> Self {
        Self {
            velocity: self.velocity || other.velocity,
            noise: self.noise || other.noise,
            species: self.species || other.species,
        }
    }
}

/// One pair as a law sees it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pair {
    /// Squared distance of the nearest images.
    pub r2: f64,
    /// r_ij . v_ij, with v_ij the relative velocity in the laboratory (zero unless [`Reads::velocity`]).
    pub rv: f64,
    /// The pair's noise at this step (meaningless unless [`Reads::noise`]).
    pub noise: Site,
    /// Species of the two (zero unless [`Reads::species`]).
    pub species: [u8; 2],
}

/// A central force divided by the distance, in the items of the stress budget: the force on i is this times r_ij,
/// positive when repulsive.
///
/// Items that a law does not have are `-0.0`, the number whose addition an optimiser may drop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Central {
    /// Derived from a potential.
    pub conservative: f64,
    /// Friction.
    pub dissipative: f64,
    /// Noise.
    pub random: f64,
}

impl Central {
    /// No force.
    pub const ZERO: Self = Self {
        conservative: -0.0,
        dissipative: -0.0,
        random: -0.0,
    };

    /// F/r of a law with a potential.
    #[inline(always)]
    pub const fn conservative(f_over_r: f64) -> Self {
        Self {
            conservative: f_over_r,
            ..Self::ZERO
        }
    }

    /// F/r of friction.
    #[inline(always)]
    pub const fn dissipative(f_over_r: f64) -> Self {
        Self {
            dissipative: f_over_r,
            ..Self::ZERO
        }
    }

    /// F/r of noise.
    #[inline(always)]
    pub const fn random(f_over_r: f64) -> Self {
        Self {
            random: f_over_r,
            ..Self::ZERO
        }
    }

    /// All items together.
    #[inline(always)]
    pub fn total(self) -> f64 {
        self.conservative + self.dissipative + self.random
    }
}

impl std::ops::Add for Central {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            conservative: self.conservative + other.conservative,
            dissipative: self.dissipative + other.dissipative,
            random: self.random + other.random,
        }
    }
}

/// A non-bonded central law: one formula.
///
/// Loops, images, stress and neighbour lists are the driver's business ([`crate::Pairwise`]). The driver evaluates
/// many pairs at once in SIMD lanes, so a law that branches little runs several times faster; mark `force`
/// `#[inline(always)]` for the same reason.
///
/// The law must answer zero at and beyond [`cutoff`](Self::cutoff), and for every finite `r2` a finite number or an
/// infinity that means "never".
///
/// ```
/// use zimm_core::{Central, Now, Pair, PairForce};
///
/// /// U = (k/2) (1 - r)^2 for r < 1.
/// struct SoftSphere {
///     stiffness: f64,
/// }
///
/// impl PairForce for SoftSphere {
///     fn cutoff(&self) -> f64 {
///         1.0
///     }
///
///     #[inline(always)]
///     fn force(&self, pair: &Pair, _: &Now) -> Central {
///         let r = pair.r2.sqrt();
///         Central::conservative(self.stiffness * (1.0 - r).max(0.0) / r)
///     }
///
///     fn energy(&self, pair: &Pair) -> f64 {
///         0.5 * self.stiffness * (1.0 - pair.r2.sqrt()).max(0.0).powi(2)
///     }
/// }
///
/// let law = SoftSphere { stiffness: 25.0 };
/// let pair = Pair { r2: 0.25, ..Pair::default() };
/// assert_eq!(law.force(&pair, &Now::default()).total(), 25.0);
/// assert_eq!(law.energy(&pair), 3.125);
/// ```
pub trait PairForce: Sync {
    /// What the law reads besides the separation.
    const READS: Reads = Reads::NOTHING;

    /// Range of the law, above zero.
    fn cutoff(&self) -> f64;

    /// Force on the first particle divided by the distance.
    fn force(&self, pair: &Pair, now: &Now) -> Central;

    /// Potential energy of the pair, if there is one.
    fn energy(&self, _pair: &Pair) -> f64 {
        0.0
    }
}

/// No force: the null law.
impl PairForce for () {
    #[inline(always)]
    fn cutoff(&self) -> f64 {
        0.0
    }

    #[inline(always)]
    fn force(&self, _: &Pair, _: &Now) -> Central {
        Central::ZERO
    }
}

macro_rules! sum_of_laws {
    ($($law:ident . $n:tt),+) => {
        impl<$($law: PairForce),+> PairForce for ($($law,)+) {
            const READS: Reads = Reads::NOTHING$(.or($law::READS))+;

            #[inline(always)]
            fn cutoff(&self) -> f64 {
                0.0_f64$(.max(self.$n.cutoff()))+
            }

            #[inline(always)]
            fn force(&self, pair: &Pair, now: &Now) -> Central {
                Central::ZERO $(+ self.$n.force(pair, now))+
            }

            #[inline(always)]
            fn energy(&self, pair: &Pair) -> f64 {
                0.0 $(+ self.$n.energy(pair))+
            }
        }
    };
}
sum_of_laws!(A.0);
sum_of_laws!(A.0, B.1);
sum_of_laws!(A.0, B.1, C.2);
sum_of_laws!(A.0, B.1, C.2, D.3);
