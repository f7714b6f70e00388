use thiserror::Error;
use zimm_core::{ParameterError, ParticleError};

/// Why a frame could not be written, read back or put into a scene.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OutputError {
    /// Input or output failed.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// Columns that do not fit together, or are not finite.
    #[error(transparent)]
    Particles(#[from] ParticleError),
    /// A moment that no clock can show.
    #[error(transparent)]
    Clock(#[from] ParameterError),
    /// The file ends within a frame.
    #[error("the file ends after line {line}, with {found} of the {expected} particles of a frame")]
    Truncated {
        /// The last line.
        line: u64,
        /// Particles of the frame that are there.
        found: u64,
        /// Particles that were announced.
        expected: u64,
    },
    /// A row has too few or too many entries.
    #[error("line {line} has {found} entries; its frame announces {expected}: `{text}`")]
    Columns {
        /// The line.
        line: u64,
        /// Entries found.
        found: usize,
        /// Entries that the frame announces.
        expected: usize,
        /// How the line begins.
        text: String,
    },
    /// The description of a frame lacks something.
    #[error("line {line} describes a frame without `{name}`")]
    Missing {
        /// The line.
        line: u64,
        /// The key or column.
        name: &'static str,
    },
    /// An entry that is not what its place asks for.
    #[error("line {line}: {name} is `{found}`, but must be {allowed}")]
    Value {
        /// The line.
        line: u64,
        /// What stands there.
        name: &'static str,
        /// What was found, or how it begins.
        found: String,
        /// What is allowed, in words.
        allowed: &'static str,
    },
    /// The boundary given is not the one that the frame was written in.
    #[error(
        "the boundary differs from that of the frame at time {time}: {quantity} is {found:?}, was {expected:?}"
    )]
    Boundary {
        /// Time of the frame.
        time: f64,
        /// `cell` or `velocity gradient`.
        quantity: &'static str,
        /// Of the boundary given, column by column; empty for open space.
        found: Vec<f64>,
        /// Of the frame.
        expected: Vec<f64>,
    },
}
