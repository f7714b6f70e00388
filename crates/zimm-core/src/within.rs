//! Pairs within molecules.

use crate::neighbours::not_finite;
use crate::{Boundary, Frame, ListError, Molecules, Neighbours, Row};
use glam::DVec3;

/// Every pair of beads of the same molecule, and no other: excluded volume of isolated chains, in open space or in a
/// cell.
///
/// A molecule in a cell is put together along its bonds, each by its nearest image, so its pairs are at the distances
/// that they have in the molecule: right whatever images the beads are in, and however large the molecule. A bead
/// never meets an image of its own molecule. As long as a molecule is smaller than half the cell these distances are
/// those of the nearest images.
///
/// There is no list: all N (N - 1) / 2 pairs of a molecule of N beads are looked at each time, and any cutoff will do.
///
/// ```
/// # use zimm_core::{Central, Clock, DVec3, ForceField, Molecules, Now, Open, Pair, PairForce, Pairwise, Particles, System, WithinMolecules};
/// # struct Repulsion;
/// # impl PairForce for Repulsion {
/// #     fn cutoff(&self) -> f64 { 2.0 }
/// #     fn force(&self, pair: &Pair, _: &Now) -> Central { Central::conservative(2.0 - pair.r2.sqrt()) }
/// # }
/// // Two dumbbells in the same place do not see each other.
/// let particles = Particles::new(vec![DVec3::ZERO, DVec3::X, DVec3::ZERO, DVec3::Y])?;
/// let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
/// let dumbbells = Molecules::linear(0, 2, 2)?;
/// let mut field = Pairwise::new(Repulsion, WithinMolecules::new(dumbbells));
/// let mut forces = vec![DVec3::ZERO; 4];
/// field.accumulate(&system.frame(), &mut forces, &mut ())?;
/// assert_eq!(forces, [-DVec3::X, DVec3::X, -DVec3::Y, DVec3::Y]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct WithinMolecules {
    molecules: Molecules,
    /// Identities at which blocks of work begin and end.
    cuts: Vec<u32>,
    /// Places in the order of identities.
    order: Vec<u32>,
    positions: Vec<DVec3>,
    /// 0, 1, 2, ...: what rows are slices of.
    identities: Vec<u32>,
}

impl WithinMolecules {
    /// The pairs within these molecules.
    pub fn new(molecules: Molecules) -> Self {
        Self {
            molecules,
            cuts: cuts(&molecules),
            order: Vec::new(),
            positions: Vec::new(),
            identities: Vec::new(),
        }
    }
}

/// Cuts rows into blocks of about as many pairs each.
fn cuts(molecules: &Molecules) -> Vec<u32> {
    const PAIRS: u64 = 1 << 14;
    let (count, beads) = (u64::from(molecules.count()), u64::from(molecules.beads()));
    let work = count * (beads * (beads - 1) / 2);
    let blocks = (work / PAIRS).clamp(1, 16);
    let identities = molecules.identities();
    let mut cuts = vec![identities.start];
    let mut done = 0;
    for (identity, bead) in identities.clone().zip((0..beads).cycle()) {
        done += beads - 1 - bead;
        if done * blocks >= work * cuts.len() as u64 && (cuts.len() as u64) < blocks {
            cuts.push(identity + 1);
        }
    }
    cuts.push(identities.end);
    cuts
}

impl<B: Boundary> Neighbours<B> for WithinMolecules {
    fn refresh(&mut self, frame: &Frame<'_, B>, cutoff: f64) -> Result<bool, ListError> {
        let (reach, particles) = (frame.boundary.reach(), frame.len());
        if !(cutoff >= 0.0) {
            return Err(ListError::Cutoff {
                cutoff,
                images: 2.0 * reach,
                most: f64::INFINITY,
            });
        }
        let end = self.molecules.identities().end;
        if end as usize > particles {
            return Err(ListError::NoSuchParticle {
                identity: end - 1,
                particles,
            });
        }
        if let Some(particle) = frame.positions.iter().position(|r| !r.is_finite()) {
            return Err(not_finite(particle, frame.positions[particle]));
        }
        let changed = self.order.len() != particles || !frame.is_in_order(&self.order);
        if changed {
            self.identities = (0..particles as u32).collect();
            self.order = places(frame);
        }
        self.positions.clear();
        let in_order = self.order.iter().map(|&place| frame.positions[place as usize]);
        self.positions.extend(in_order);
        if frame.boundary.cell().is_some() {
            self.put_together(frame.boundary, reach)?;
        }
        Ok(changed)
    }

    fn order(&self) -> &[u32] {
        &self.order
    }

    fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    fn blocks(&self) -> usize {
        self.cuts.len() - 1
    }

    fn visit(&self, block: usize, mut each: impl FnMut(Row<'_>)) {
        todo!()
    }
}
