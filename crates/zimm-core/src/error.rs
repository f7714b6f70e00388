//! Errors are values with numbers in them: which particle or bond, what was found, what was allowed.

use thiserror::Error;

/// A parameter outside the range in which a law or a scheme exists.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[error("{name} is {found}, but must be {allowed}")]
pub struct ParameterError {
    /// The parameter.
    pub name: &'static str,
    /// The value given.
    pub found: f64,
    /// The range allowed, in words.
    pub allowed: &'static str,
}

impl ParameterError {
    /// Builds the error; for laws and schemes outside this family.
    pub fn new(name: &'static str, found: f64, allowed: &'static str) -> Self {
        Self {
            name,
            found,
            allowed,
        }
    }

    /// `value` if it is finite and above zero.
    pub fn positive(name: &'static str, value: f64) -> Result<f64, Self> {
        Self::check(name, value, value > 0.0, "finite and above zero")
    }

    /// `value` if it is finite and not below zero.
    pub fn non_negative(name: &'static str, value: f64) -> Result<f64, Self> {
        Self::check(name, value, value >= 0.0, "finite and not below zero")
    }

    /// `value` if it is finite.
    pub fn finite(name: &'static str, value: f64) -> Result<f64, Self> {
        Self::check(name, value, true, "finite")
    }

    fn check(
        name: &'static str,
        value: f64,
        holds: bool,
        allowed: &'static str,
    ) -> Result<f64, Self> {
        if holds && value.is_finite() {
            Ok(value)
        } else {
            Err(Self::new(name, value, allowed))
        }
    }
}

/// Why a set of basis vectors is no lattice.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LatticeError {
    /// The basis spans no volume, or is not finite.
    #[error("the basis spans a volume of {volume}; it must be finite and above {least}")]
    Degenerate {
        /// Determinant of the basis.
        volume: f64,
        /// Smallest volume accepted for vectors of these lengths.
        least: f64,
    },
}

/// Why columns of particles do not fit together.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ParticleError {
    /// A column is neither empty nor as long as the positions.
    #[error("column `{column}` has {found} entries for {particles} particles")]
    Length {
        /// The column.
        column: &'static str,
        /// Its length.
        found: usize,
        /// Number of positions.
        particles: usize,
    },
    /// A position, velocity or force that is not finite.
    #[error("column `{column}` of particle {particle} is not finite: {value:?}")]
    NotFinite {
        /// The column.
        column: &'static str,
        /// The particle.
        particle: usize,
        /// What was found.
        value: [f64; 3],
    },
    /// A mass that is not above zero.
    #[error("the mass of particle {particle} is {mass}; it must be finite and above zero")]
    Mass {
        /// The particle.
        particle: usize,
        /// What was found.
        mass: f64,
    },
    /// Identities are not a permutation of 0..n.
    #[error(
        "identity {identity} of particle {particle} is out of range or occurs twice among {particles} particles"
    )]
    Identity {
        /// The particle.
        particle: usize,
        /// The identity found.
        identity: u32,
        /// Number of particles.
        particles: usize,
    },
    /// More particles than 32-bit identities can name.
    #[error("{particles} particles; at most {most} can be named")]
    TooMany {
        /// Number asked for.
        particles: usize,
        /// Number allowed.
        most: usize,
    },
}

/// Why no list of pairs can be made.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ListError {
    /// Two images of one particle would both be in range.
    #[error(
        "a cutoff of {cutoff} does not fit the cell: nearest images are {images} apart, so it must be between 0 and {most}"
    )]
    Cutoff {
        /// The cutoff asked for.
        cutoff: f64,
        /// Length of the shortest lattice vector.
        images: f64,
        /// The largest cutoff for this cell.
        most: f64,
    },
    /// A position that is not finite.
    #[error("the position of particle {particle} is not finite: {position:?}")]
    NotFinite {
        /// The particle.
        particle: usize,
        /// What was found.
        position: [f64; 3],
    },
    /// Molecules have beads that do not exist.
    #[error("molecules go up to identity {identity}, but there are {particles} particles")]
    NoSuchParticle {
        /// The last identity of the molecules.
        identity: u32,
        /// Number of particles.
        particles: usize,
    },
    /// A bond so long that its nearest image is ambiguous.
    #[error(
        "the bond between particles {i} and {j} is {length} long; the cell resolves bonds below {reach}"
    )]
    BeyondCell {
        /// Identity of its first bead.
        i: u32,
        /// Identity of its second bead.
        j: u32,
        /// Length found.
        length: f64,
        /// Half the shortest lattice vector.
        reach: f64,
    },
}

/// Why a force could not be evaluated.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ForceError {
    /// The neighbour source failed.
    #[error(transparent)]
    List(#[from] ListError),
    /// A spring at or beyond the length at which its law ends.
    #[error("bond {bond} between particles {i} and {j} is {length} long; its law ends at {limit}")]
    Overstretched {
        /// Index of the bond.
        bond: usize,
        /// Identity of its first bead.
        i: u32,
        /// Identity of its second bead.
        j: u32,
        /// Length found.
        length: f64,
        /// Length allowed.
        limit: f64,
    },
    /// A spring so long that its nearest image is ambiguous.
    #[error(
        "bond {bond} between particles {i} and {j} is {length} long; the cell resolves bonds below {reach}"
    )]
    BeyondCell {
        /// Index of the bond.
        bond: usize,
        /// Identity of its first bead.
        i: u32,
        /// Identity of its second bead.
        j: u32,
        /// Length found.
        length: f64,
        /// Half the shortest lattice vector.
        reach: f64,
    },
    /// A bond names a particle that does not exist.
    #[error("bond {bond} names particle {identity}, but there are {particles}")]
    NoSuchParticle {
        /// Index of the bond.
        bond: usize,
        /// The identity it names.
        identity: u32,
        /// Number of particles.
        particles: usize,
    },
    /// Particles that others are to balance are none or all of them.
    #[error("identities from {start} to below {end} are none or all of {particles} particles")]
    NoneOrAll {
        /// The first identity.
        start: u32,
        /// The first identity beyond.
        end: u32,
        /// Number of particles.
        particles: usize,
    },
}

/// Why a mobility or its square root could not be had.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MobilityError {
    /// Molecules that cannot be put together.
    #[error(transparent)]
    List(#[from] ListError),
    /// Beads so large that their periodic mobility has no meaning.
    #[error(
        "beads of radius {radius} do not fit the cell: {quantity} is {found}, but must be {allowed}"
    )]
    Cell {
        /// Radius of a bead.
        radius: f64,
        /// What is wrong.
        quantity: &'static str,
        /// Its value.
        found: f64,
        /// The range allowed, in words.
        allowed: &'static str,
    },
    /// A mobility that is not positive definite, to the accuracy that it is known with.
    #[error("the mobility is not positive definite: {quantity} is {found}")]
    NotPositive {
        /// The pivot, eigenvalue or quadratic form that tells.
        quantity: &'static str,
        /// Its value.
        found: f64,
    },
    /// An iteration that did not reach the error asked for.
    #[error(
        "the square root of the mobility reached a relative error of {reached} after {iterations} iterations; {asked} was asked for"
    )]
    NotConverged {
        /// Iterations made.
        iterations: usize,
        /// Relative error reached.
        reached: f64,
        /// Relative error asked for.
        asked: f64,
    },
    /// A position, force or velocity that is not finite.
    #[error("the {quantity} of particle {particle} is not finite: {value:?}")]
    NotFinite {
        /// What it is.
        quantity: &'static str,
        /// Index of the particle.
        particle: usize,
        /// What was found.
        value: [f64; 3],
    },
    /// A species for which no friction was given.
    #[error(
        "particle {particle} is of species {species}; frictions were given for {known} species"
    )]
    NoFriction {
        /// Index of the particle.
        particle: usize,
        /// Its species.
        species: u8,
        /// Number of frictions.
        known: usize,
    },
}

/// Why a step was not taken. The system is as it was after the last good step.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum StepError {
    /// A force could not be evaluated.
    #[error("step {step}: {source}")]
    Force {
        /// The step that failed.
        step: u64,
        /// The reason.
        source: ForceError,
    },
    /// The mobility or its square root could not be had.
    #[error("step {step}: {source}")]
    Mobility {
        /// The step that failed.
        step: u64,
        /// The reason.
        source: MobilityError,
    },
    /// The implicit equations of the step were not solved.
    #[error(
        "step {step}: the implicit equations reached a relative error of {reached} after {iterations} iterations; {asked} was asked for"
    )]
    NotSolved {
        /// The step that failed.
        step: u64,
        /// Iterations made.
        iterations: usize,
        /// Relative error reached.
        reached: f64,
        /// Relative error asked for.
        asked: f64,
    },
    /// A parameter of the scheme that does not go with the clock or the scene.
    #[error("step {step}: {source}")]
    Parameter {
        /// The step that failed.
        step: u64,
        /// The reason.
        source: ParameterError,
    },
    /// A particle would leave the step with a state that is not finite, or too large to be wrapped.
    #[error(
        "step {step}: the new state of particle {particle} is not finite or too large (force {force:?})"
    )]
    NotFinite {
        /// The step that failed.
        step: u64,
        /// Index of the particle.
        particle: usize,
        /// The force on it.
        force: [f64; 3],
    },
}

/// Why a checkpoint could not be written or read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// Input or output failed.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// The file does not begin as a checkpoint does.
    #[error("this is no zimm checkpoint: it begins with {found:?}")]
    Foreign {
        /// The first bytes.
        found: Vec<u8>,
    },
    /// The file is of a version that this build cannot read.
    #[error(
        "the {quantity} of the checkpoint is of version {found}; this build knows version {known}"
    )]
    Version {
        /// `layout` or `noise mapping`.
        quantity: &'static str,
        /// Version of the file.
        found: u32,
        /// Version of this build.
        known: u32,
    },
    /// The file ends early.
    #[error("the checkpoint ends after {found} bytes; {expected} were announced")]
    Truncated {
        /// Bytes present.
        found: u64,
        /// Bytes announced.
        expected: u64,
    },
    /// The bytes are not those that were written.
    #[error("the checkpoint is damaged: checksum {found:016x} instead of {expected:016x}")]
    Damaged {
        /// Checksum of the bytes present.
        found: u64,
        /// Checksum announced.
        expected: u64,
    },
    /// The boundary given is not the one that the run was made in.
    #[error(
        "the boundary differs from that of the checkpoint at time {time}: {quantity} is {found:?}, was {expected:?}"
    )]
    Boundary {
        /// Time of the checkpoint.
        time: f64,
        /// `cell` or `velocity gradient`.
        quantity: &'static str,
        /// Of the boundary given, column by column; empty for open space.
        found: Vec<f64>,
        /// Of the checkpoint.
        expected: Vec<f64>,
    },
    /// The columns do not fit together.
    #[error(transparent)]
    Particles(#[from] ParticleError),
    /// The clock of the checkpoint makes no sense.
    #[error(transparent)]
    Clock(#[from] ParameterError),
}
