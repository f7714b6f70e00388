//! Pairs within molecules.

use crate::neighbours::not_finite;
use crate::{Boundary, Frame, ListError, Molecules, Neighbours, Row};
use glam::DVec3;
use std::ops::Range;

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
    const MOST: u64 = 16;
    let (count, beads) = (u64::from(molecules.count()), u64::from(molecules.beads()));
    let work = count * (beads * (beads - 1) / 2);
    let blocks = (work / PAIRS).clamp(1, MOST);
    let Range { start, end } = molecules.identities();
    let mut cuts = vec![start];
    let mut done = 0;
    for (identity, bead) in (start..end).zip((0..beads).cycle()) {
        done += beads - 1 - bead;
        let begun = cuts.len() as u64;
        if begun < blocks && done * blocks >= begun * work {
            cuts.push(identity + 1);
        }
    }
    cuts.push(end);
    cuts
}

impl<B: Boundary> Neighbours<B> for WithinMolecules {
    fn refresh(&mut self, frame: &Frame<'_, B>, cutoff: f64) -> Result<bool, ListError> {
        let particles = frame.len();
        let most = f64::INFINITY;
        if !(0.0..=most).contains(&cutoff) {
            let images = 2.0 * frame.boundary.reach();
            return Err(ListError::Cutoff {
                cutoff,
                images,
                most,
            });
        }
        let end = self.molecules.identities().end;
        if end as usize > particles {
            let identity = end - 1;
            return Err(ListError::NoSuchParticle {
                identity,
                particles,
            });
        }
        if let Some(particle) = frame.positions.iter().position(|r| !r.is_finite()) {
            return Err(not_finite(particle, frame.positions[particle]));
        }
        let order = (0..particles as u32).filter_map(|identity| frame.place(identity));
        let order = order.map(|place| place as u32);
        let changed = !order.clone().eq(self.order.iter().copied());
        if changed {
            self.order = order.collect();
            self.identities = (0..particles as u32).collect();
        }
        self.positions.clear();
        let here = |&place: &u32| frame.positions[place as usize];
        self.positions.extend(self.order.iter().map(here));
        if frame.boundary.cell().is_some() {
            self.put_together(frame)?;
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

    #[inline(always)]
    fn visit(&self, block: usize, mut each: impl FnMut(Row<'_>)) {
        let (first, beads) = (self.molecules.identities().start, self.molecules.beads());
        for i in self.cuts[block]..self.cuts[block + 1] {
            let end = first + ((i - first) / beads + 1) * beads;
            if let Some(js @ [_, ..]) = self.identities.get(i as usize + 1..end as usize) {
                let shift = DVec3::ZERO;
                each(Row { i, shift, js });
            }
        }
    }
}

impl WithinMolecules {
    /// Puts each bead into the image that its bond leads to.
    fn put_together<B: Boundary>(&mut self, frame: &Frame<'_, B>) -> Result<(), ListError> {
        let reach = frame.boundary.reach();
        let here = |identity: u32| frame.positions[self.order[identity as usize] as usize];
        for beads in self.molecules.iter() {
            for j in beads.clone().skip(1) {
                let parent = self.molecules.parent(j - beads.start);
                let i = beads.start + parent.unwrap_or_default();
                let bond = frame.boundary.min_image(here(j) - here(i));
                let length = bond.length();
                let resolved = length < reach;
                if !resolved {
                    return Err(ListError::BeyondCell {
                        i,
                        j,
                        length,
                        reach,
                    });
                }
                self.positions[j as usize] = self.positions[i as usize] + bond;
            }
        }
        Ok(())
    }
}
