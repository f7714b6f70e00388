//! Molecules that lie across images, put together bead by bead.

use crate::AnalysisError;
use zimm_core::{Boundary, DVec3, Frame, Molecules};

/// Calls `each` with the places of every molecule's beads and with the beads, unwrapped from the first one along the
/// bonds by their nearest images: right whatever images the beads are in, however large the molecule, as long as each
/// bond is shorter than the cell resolves.
pub(crate) fn map_chains<B: Boundary, A>(
    frame: &Frame<'_, B>,
    molecules: &Molecules,
    mut each: impl FnMut(&[usize], &[DVec3]) -> A,
) -> Result<Vec<A>, AnalysisError> {
    let reach = frame.boundary.reach();
    let (mut places, mut beads) = (Vec::<usize>::new(), Vec::<DVec3>::new());
    let mut results = Vec::with_capacity(molecules.count() as usize);
    for (molecule, identities) in molecules.iter().enumerate() {
        places.clear();
        beads.clear();
        let start = identities.start;
        for identity in identities {
            let place = frame.place(identity).ok_or(AnalysisError::NoSuchParticle {
                molecule,
                identity,
                particles: frame.len(),
            })?;
            let mut bead = frame.positions[place];
            if let Some(parent) = molecules.parent(identity - start) {
                let before = parent as usize;
                let bond = (frame.boundary).min_image(bead - frame.positions[places[before]]);
                let length = bond.length();
                let resolved = length < reach;
                if !resolved {
                    return Err(AnalysisError::BeyondCell {
                        molecule,
                        i: start + parent,
                        j: identity,
                        length,
                        reach,
                    });
                }
                bead = beads[before] + bond;
            }
            places.push(place);
            beads.push(bead);
        }
        results.push(each(&places, &beads));
    }
    Ok(results)
}
