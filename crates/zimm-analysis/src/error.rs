//! Why a measurement or an average has no answer.

use thiserror::Error;
use zimm_core::{ListError, ParameterError, Topology};

/// Why a measurement or an average has no answer. It is never a NaN instead.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum AnalysisError {
    /// A column that the scene does not keep.
    #[error("this needs the column `{column}`, which the scene does not keep")]
    MissingColumn {
        /// The column.
        column: &'static str,
    },
    /// Too little to say anything.
    #[error("{found} {what} are too few; at least {needed} are needed")]
    TooFew {
        /// What there is too little of.
        what: &'static str,
        /// How many there are.
        found: u64,
        /// How many it takes.
        needed: u64,
    },
    /// A sample, or a quantity of a frame, that is not finite.
    #[error("{what} of sample {sample} is not finite")]
    NotFinite {
        /// The quantity.
        what: &'static str,
        /// Number of the first such sample, from zero; of a frame, its step.
        sample: u64,
    },
    /// A sample of another length than those before it.
    #[error("sample {sample} has {found} entries; {expected} were expected")]
    Length {
        /// Number of the first such sample, from zero.
        sample: u64,
        /// Its length.
        found: usize,
        /// The length expected.
        expected: usize,
    },
    /// Something to divide by that cannot be told from zero.
    #[error("what to divide by is {mean} with an error of at least {error}: too close to zero")]
    Denominator {
        /// Its mean.
        mean: f64,
        /// The lower bound of its standard error.
        error: f64,
    },
    /// A run that drifts throughout its first half or longer.
    #[error("{samples} samples have not settled: the run is too short for its transient")]
    NotSettled {
        /// How many samples there are.
        samples: u64,
    },
    /// A molecule names a particle that does not exist.
    #[error("molecule {molecule} names particle {identity}, but there are {particles}")]
    NoSuchParticle {
        /// Index of the molecule.
        molecule: usize,
        /// The identity it names.
        identity: u32,
        /// Number of particles.
        particles: usize,
    },
    /// A bond so long that its nearest image is ambiguous, so that the chain cannot be unwrapped.
    #[error(
        "particles {i} and {j} of molecule {molecule} are {length} apart; the cell resolves bonds below {reach}"
    )]
    BeyondCell {
        /// Index of the molecule.
        molecule: usize,
        /// Identity of the first bead.
        i: u32,
        /// Identity of the second bead.
        j: u32,
        /// Distance of the nearest images.
        length: f64,
        /// Half the shortest lattice vector.
        reach: f64,
    },
    /// A particle or molecule that moved so far between two measurements that its way is ambiguous.
    #[error(
        "particle (or molecule) {particle} moved by {distance} between two measurements; at most {most} can be followed"
    )]
    TooFar {
        /// Identity of the particle, or index of the molecule.
        particle: usize,
        /// How far its nearest image moved.
        distance: f64,
        /// A quarter of the shortest lattice vector.
        most: f64,
    },
    /// A direction along which the cell does not repeat with the period given.
    #[error(
        "a lattice vector spans {periods} periods of {period} along the axis; it must be a whole number"
    )]
    NotPeriodic {
        /// The period given.
        period: f64,
        /// How many of them a lattice vector spans.
        periods: f64,
    },
    /// Molecules of another topology than what is measured makes sense for.
    #[error("this is for linear molecules; these are {topology:?}")]
    NotLinear {
        /// How their beads are joined.
        topology: Topology,
    },
    /// The source of pairs failed.
    #[error(transparent)]
    List(#[from] ListError),
    /// A parameter out of range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
}
