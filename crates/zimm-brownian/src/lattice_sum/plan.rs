//! How far pairs go and how far waves, from the error asked for.

use zimm_core::{Lattice, MobilityError};

/// A split of the sum into pairs and waves: a pure function of the volume and the shortest vector of a lattice, the
/// number of beads, their radius and the error asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Plan {
    pub(crate) radius: f64,
    /// The range of pairs.
    pub(crate) range: f64,
    /// The product of the range and the largest wave number.
    pub(crate) sharpness: f64,
    /// How well kernels are to be evaluated.
    pub(crate) error: f64,
}

impl Plan {
    /// The split that leaves a root-mean-square error of at most `error`, for independent forces and relative to the
    /// velocity of one bead pulled alone in the cell.
    ///
    /// Pairs cost as range^3, waves as sharpness^3 / range^3, so the least cost is at a range that goes with the root of
    /// the sharpness. `balance` is that range in mean distances between beads, over the root. Whether both parts are to
    /// be `positive` matters for large beads: their range is shorter if only the sum is.
    ///
    /// # Errors
    /// If beads are larger than three times the shortest lattice vector: of a mobility that is averaged over so many
    /// images nothing is left.
    pub(crate) fn new(
        lattice: &Lattice,
        beads: usize,
        radius: f64,
        error: f64,
        balance: f64,
        positive: bool,
    ) -> Result<Self, MobilityError> {
        const MOST: f64 = 3.0;
        let found = radius / lattice.shortest();
        if found > MOST {
            return Err(MobilityError::Cell {
                radius,
                quantity: "radius over the shortest lattice vector",
                found,
                allowed: "at most 3",
            });
        }
        let volume = steady(lattice.volume());
        let apart = libm::cbrt(volume / beads.max(1) as f64);
        let wanted = |c: f64| balance * c.sqrt() * apart;
        let least = |c| radius * least_range(c, positive);
        Ok(Self::at(volume, beads, radius, error, wanted, least))
    }

    /// The split at a range that is wanted, or the least, for a sharpness.
    fn at(
        volume: f64,
        beads: usize,
        radius: f64,
        error: f64,
        wanted: impl Fn(f64) -> f64,
        least: impl Fn(f64) -> f64,
    ) -> Self {
        /// Errors of different beads add up at random; those of a bead's own images by shells of up to 48, on the whole
        /// as those of so many beads do.
        const SHELL: usize = 32;
        /// Pairs do not go farther than this share of the cell, but for large beads: where many shells are in range,
        /// errors of a bead's own images add up.
        const SHARE: f64 = 0.6;
        /// Sums of so many numbers cannot do better.
        const ROUNDING: f64 = 1e-14;
        let edge = libm::cbrt(volume);
        let density = beads.max(SHELL) as f64 / volume;
        let error = (error * own(radius / edge)).max(ROUNDING);
        let mut sharpness = sharpness_of(error);
        let mut reach = 0.0;
        for _ in 0..6 {
            reach = wanted(sharpness).min(SHARE * edge).max(least(sharpness));
            sharpness = sharpness_of(error / (radius * (reach * density).sqrt()));
        }
        Self {
            radius,
            range: reach.max(least(sharpness)),
            sharpness,
            error,
        }
    }

    /// The largest wave number.
    pub(crate) fn edge(&self) -> f64 {
        self.sharpness / self.range
    }
}

/// A volume rounded to a fraction of a per cent, so that the rounding of a cell that flows does not show in the plan.
fn steady(volume: f64) -> f64 {
    const STEPS: f64 = 256.0;
    libm::exp2((libm::log2(volume) * STEPS).round() / STEPS)
}

/// The velocity of one bead alone in a cube, relative to that in open space (Hasimoto 1959), until it fills the cube:
/// beads that overlap with their images move more slowly, down to a hundredth.
fn own(x: f64) -> f64 {
    if x < 0.4 {
        1.0 - 2.837 * x + 4.189 * x * x * x
    } else {
        0.01
    }
}

/// The product of range and largest wave number for which the pair part beyond its range is `tail`: the root mean
/// square over all space, in units of a r^(1/2), within a factor of 1.5 from 0.1 to 1e-12.
pub(crate) fn sharpness_of(tail: f64) -> f64 {
    let mut c = 10.0_f64;
    for _ in 0..60 {
        c = (libm::log(2.65 / tail) + 1.3 * libm::log(c)).max(5.0);
    }
    c
}

/// The least range in radii. That of parts that need not be positive has to reach beyond contact, where the mobility of
/// two beads has another formula.
fn least_range(sharpness: f64, positive: bool) -> f64 {
    const BAND: f64 = 6.0;
    const BEYOND: f64 = 2.5;
    if positive {
        sharpness / widest_band(sharpness)
    } else {
        (sharpness / BAND).max(BEYOND)
    }
}

/// The largest product of wave number and radius for which both parts are positive, from a scan of sharpnesses from 5
/// to 40.
pub(super) fn widest_band(sharpness: f64) -> f64 {
    3.0 - 12.0 / (sharpness * sharpness)
}
