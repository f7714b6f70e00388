//! Which identities make up which molecule.

use crate::ParameterError;
use std::ops::Range;

/// Molecules of one kind, each a run of consecutive identities, one run after the other.
///
/// ```
/// use zimm_core::Molecules;
///
/// // Two trimers behind ten particles of solvent.
/// let molecules = Molecules::linear(10, 2, 3)?;
/// assert_eq!(molecules.bonds(), [[10, 11], [11, 12], [13, 14], [14, 15]]);
/// assert!(molecules.iter().eq([10..13, 13..16]));
/// # Ok::<(), zimm_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Molecules {
    first: u32,
    count: u32,
    beads: u32,
}

impl Molecules {
    /// Linear molecules of `beads` beads each, the first of which is the particle of identity `first`.
    ///
    /// # Errors
    /// If a molecule has no bead, or the last identity is not below 2^31.
    pub fn linear(first: u32, count: u32, beads: u32) -> Result<Self, ParameterError> {
        let end = u64::from(count) * u64::from(beads) + u64::from(first);
        if beads == 0 {
            Err(ParameterError::new("beads", 0.0, "at least 1"))
        } else if end > 1 << 31 {
            Err(ParameterError::new(
                "last identity",
                end as f64 - 1.0,
                "below 2^31",
            ))
        } else {
            Ok(Self {
                first,
                count,
                beads,
            })
        }
    }

    /// The identities of each molecule.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Range<u32>> + use<> {
        let Self {
            first,
            count,
            beads,
        } = *self;
        (0..count).map(move |molecule| {
            let start = first + molecule * beads;
            start..start + beads
        })
    }

    /// The pairs of identities that are joined: each bead and the next.
    pub fn bonds(&self) -> Vec<[u32; 2]> {
        self.iter()
            .flat_map(|beads| beads.clone().zip(beads.skip(1)))
            .map(|(bead, next)| [bead, next])
            .collect()
    }
}
