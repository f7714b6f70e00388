//! Chains that lie across images, put together bead by bead.

use crate::AnalysisError;
use zimm_core::{Boundary, DVec3, Frame, Molecules};

/// Calls `each` with the places of every molecule's beads and with the beads, unwrapped from the first one by the
/// nearest images of the bonds: right whatever images the beads are in, however long the chain, as long as each bond is
/// shorter than the cell resolves.
pub(crate) fn map_chains<B: Boundary, A>(
    frame: &Frame<'_, B>,
    molecules: &Molecules,
    mut each: impl FnMut(&[usize], &[DVec3]) -> A,
) -> Result<Vec<A>, AnalysisError> {
    let reach = frame.boundary.reach();
    let (mut places, mut beads) = (Vec::new(), Vec::<DVec3>::new());
    let mut results = Vec::with_capacity(molecules.iter().len());
    for (molecule, identities) in molecules.iter().enumerate() {
        places.clear();
        beads.clear();
        let mut before: Option<(u32, DVec3)> = None;
        for identity in identities {
            let place = frame.place(identity).ok_or(AnalysisError::NoSuchParticle {
                molecule,
                identity,
                particles: frame.len(),
            })?;
            let here = frame.positions[place];
            let unwrapped = match (before, beads.last()) {
                (Some((previous, there)), Some(bead)) => {
                    let bond = frame.boundary.min_image(here - there);
                    let length = bond.length();
                    let resolved = length < reach;
                    if !resolved {
                        let (i, j) = (previous, identity);
                        return Err(AnalysisError::BeyondCell {
                            molecule,
                            i,
                            j,
                            length,
                            reach,
                        });
                    }
                    bead + bond
                }
                _ => here,
            };
            places.push(place);
            beads.push(unwrapped);
            before = Some((identity, here));
        }
        results.push(each(&places, &beads));
    }
    Ok(results)
}
