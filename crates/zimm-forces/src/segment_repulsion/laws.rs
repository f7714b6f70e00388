//! Laws of repulsion between segments.

use crate::length::length;
use zimm_core::ParameterError;

/// A repulsion between two segments as a function of their distance: one formula.
///
/// Closest approach, images, lists and stress are the business of [`SegmentRepulsion`](crate::SegmentRepulsion), which
/// never asks for distances below [`smallest`](Self::smallest), nor at or beyond [`cutoff`](Self::cutoff).
///
/// ```
/// use zimm_forces::SegmentForce;
///
/// /// U = (k / 3) (1 - D)^3: no jump in the force or its slope at the cutoff.
/// struct Cubic {
///     stiffness: f64,
/// }
///
/// impl SegmentForce for Cubic {
///     fn cutoff(&self) -> f64 {
///         1.0
///     }
///
///     fn force(&self, distance: f64) -> f64 {
///         self.stiffness * (1.0 - distance) * (1.0 - distance)
///     }
///
///     fn energy(&self, distance: f64) -> f64 {
///         self.force(distance) * (1.0 - distance) / 3.0
///     }
/// }
///
/// let law = Cubic { stiffness: 12.0 };
/// assert_eq!((law.force(0.5), law.energy(0.5)), (3.0, 0.5));
/// ```
pub trait SegmentForce: Sync {
    /// Range of the law.
    fn cutoff(&self) -> f64;

    /// Force at a distance, positive when repulsive.
    fn force(&self, distance: f64) -> f64;

    /// Potential energy at a distance, zero at the cutoff.
    fn energy(&self, distance: f64) -> f64;

    /// The smallest distance: differences below it do not show in the force, which so has no jump where segments cross
    /// or lie parallel. Zero resolves everything, at the price of such jumps.
    ///
    /// The default is Clarke's 0.001 r_c if the cutoff is his r_c / 3.
    fn smallest(&self) -> f64 {
        3e-3 * self.cutoff()
    }
}

/// No force: the null law.
impl SegmentForce for () {
    #[inline(always)]
    fn cutoff(&self) -> f64 {
        0.0
    }

    #[inline(always)]
    fn force(&self, _: f64) -> f64 {
        0.0
    }

    #[inline(always)]
    fn energy(&self, _: f64) -> f64 {
        0.0
    }
}

/// F = 3 a (1 - 3 D / r_c) up to the cutoff r_c / 3, U = (a r_c / 2) (1 - 3 D / r_c)^2.
///
/// Nine times as steep as the repulsion a (1 - r / r_c) of DPD beads. With a = 18.75 two segments cross over a barrier
/// of 9.4 kT. Pan and Manke, Int. J. Mod. Phys. B 17, 231 (2003); Clarke, PhD thesis, MIT (2008), equation 5.5.
///
/// ```
/// use zimm_forces::{PanManke, SegmentForce};
///
/// let law = PanManke::new(18.75, 1.0)?;
/// assert!((law.force(0.1) - 39.375).abs() < 1e-13);
/// assert!((law.energy(0.1) - 4.59375).abs() < 1e-14);
/// # Ok::<(), zimm_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PanManke {
    repulsion: f64,
    cutoff: f64,
}

impl PanManke {
    /// The repulsion `a` (a force) and the range `r_c` (a length) of the beads.
    ///
    /// # Errors
    /// If `repulsion` is not finite or below zero, or `range` is not between 1e-100 and 1e100.
    pub fn new(repulsion: f64, range: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            repulsion: ParameterError::non_negative("repulsion", repulsion)?,
            cutoff: length("range", range)? / 3.0,
        })
    }
}

impl SegmentForce for PanManke {
    #[inline(always)]
    fn cutoff(&self) -> f64 {
        self.cutoff
    }

    #[inline(always)]
    fn force(&self, distance: f64) -> f64 {
        3.0 * self.repulsion * (1.0 - distance / self.cutoff)
    }

    #[inline(always)]
    fn energy(&self, distance: f64) -> f64 {
        let x = 1.0 - distance / self.cutoff;
        1.5 * self.repulsion * self.cutoff * (x * x)
    }
}

/// F = A alpha exp(-alpha D) up to the cutoff, U = A (exp(-alpha D) - exp(-alpha D_c)).
///
/// The force is cut and not shifted: it jumps at the cutoff. Kumar and Larson, J. Chem. Phys. 114, 6937 (2001); Clarke,
/// PhD thesis, MIT (2008), equation 5.6, with A = 100 kT, alpha = 10 / r_c and a cutoff of r_c / 3. Taken literally
/// that is a barrier of 100 kT and a force of 1000 kT / r_c at contact; what the thesis shows (a weaker and shorter
/// repulsion than [`PanManke`]'s, segments that do come close) fits a force of 100 kT / r_c, for which there is
/// [`with_contact_force`](Self::with_contact_force).
///
/// ```
/// use zimm_forces::{KumarLarson, SegmentForce};
///
/// let literal = KumarLarson::new(100.0, 10.0, 1.0 / 3.0)?;
/// assert!((literal.force(0.1) - 367.879441171442).abs() < 1e-10);
/// assert!((literal.energy(0.1) - 33.2205447824190).abs() < 1e-9);
/// assert_eq!(KumarLarson::with_contact_force(1000.0, 10.0, 1.0 / 3.0)?, literal);
/// # Ok::<(), zimm_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KumarLarson {
    energy: f64,
    decay: f64,
    cutoff: f64,
    cutoff_energy: f64,
}

impl KumarLarson {
    /// The energy A of contact, the decay alpha (one over length) and the cutoff (a length).
    ///
    /// # Errors
    /// If `energy` is not finite or below zero, `decay` is not finite and above zero, or `cutoff` is not between 1e-100
    /// and 1e100.
    pub fn new(energy: f64, decay: f64, cutoff: f64) -> Result<Self, ParameterError> {
        let energy = ParameterError::non_negative("energy", energy)?;
        let decay = ParameterError::positive("decay", decay)?;
        let cutoff = length("cutoff", cutoff)?;
        Ok(Self {
            energy,
            decay,
            cutoff,
            cutoff_energy: energy * libm::exp(-decay * cutoff),
        })
    }

    /// The law whose force at contact, A alpha, is `force`.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_contact_force(force: f64, decay: f64, cutoff: f64) -> Result<Self, ParameterError> {
        let force = ParameterError::non_negative("force", force)?;
        let decay = ParameterError::positive("decay", decay)?;
        Self::new(force / decay, decay, cutoff)
    }
}

impl SegmentForce for KumarLarson {
    #[inline(always)]
    fn cutoff(&self) -> f64 {
        self.cutoff
    }

    #[inline(always)]
    fn force(&self, distance: f64) -> f64 {
        self.energy * self.decay * libm::exp(-self.decay * distance)
    }

    #[inline(always)]
    fn energy(&self, distance: f64) -> f64 {
        self.energy * libm::exp(-self.decay * distance) - self.cutoff_energy
    }
}

/// No force, but tallies hear of every pair of segments that comes within the range: what distances there are between
/// chains that pass through each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phantom {
    range: f64,
}

impl Phantom {
    /// Up to a range (a length).
    ///
    /// # Errors
    /// If `range` is not between 1e-100 and 1e100.
    pub fn new(range: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            range: length("range", range)?,
        })
    }
}

impl SegmentForce for Phantom {
    #[inline(always)]
    fn cutoff(&self) -> f64 {
        self.range
    }

    #[inline(always)]
    fn force(&self, _: f64) -> f64 {
        0.0
    }

    #[inline(always)]
    fn energy(&self, _: f64) -> f64 {
        0.0
    }

    #[inline(always)]
    fn smallest(&self) -> f64 {
        0.0
    }
}
