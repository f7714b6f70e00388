//! Repulsion between springs, so that chains do not pass through each other.

mod distance;
mod laws;
mod list;

pub use distance::Approach;
pub use laws::{KumarLarson, PanManke, Phantom, SegmentForce};

use crate::length;
use list::{Candidate, Meeting, SegmentList, Space};
use zimm_core::{
    Boundary, DVec3, ForceError, ForceField, Frame, Item, Neighbours, Reads, Tally, for_each_chunk,
};

/// Repulsion between bonds as straight segments, by their distance, without particles of its own.
///
/// With P_1, P_2 the middles of two segments, R_1, R_2 their spans and b the smallest distance of the law
/// ([`SegmentForce::smallest`]),
///
/// ```text
/// Delta^2 = min over s, t in [-1/2, 1/2] of |D|^2 + b^2 (1 + s^2 + t^2),    D = P_1 - P_2 + s R_1 - t R_2
/// force on segment 1 = F(Delta) D / Delta,    energy = U(Delta)
/// ```
///
/// It acts at the places of closest approach; the beads at the two ends of the first segment have the shares 1/2 - s
/// and 1/2 + s of it (the lever rule), those of the second 1/2 - t and 1/2 + t of its opposite. So force and torque
/// balance to rounding, and the forces on the beads are the gradient of the energy: the terms with b make the minimum
/// unique, and the places s and t drop out of the gradient. Tallies hear of D and the force as
/// [`Item::SpringRepulsion`]; the virial of the four beads is their product.
///
/// **Continuity.** The plain distance (b = 0) has a force that jumps: in direction where segments cross; in its share
/// between the beads where segments are parallel, collinear or without length, for there places of closest approach are
/// not unique and leap from end to end. With b the force is continuous in the positions of all beads wherever F is:
/// through a crossing it turns over a distance b, and from end to end of parallel segments it slides while one end
/// moves by b. Delta exceeds the distance by b to 1.3 b at contact and by less than 3 b^2 / 4D further out. With
/// Clarke's b of 0.001 r_c no usual time step resolves these turns; an energy that is to be conserved wants a b that
/// particles take several steps to cross.
///
/// Bonds go by their nearest image and must be shorter than half the distance of images. Segments interact in every
/// image in which they come within range, even twice around a small cell, and not if they share a bead. (A segment and
/// the image of one that it shares a bead with do interact.)
///
/// Pairs are found by any source that serves the boundary: a [`VerletList`](zimm_core::VerletList) in a cell,
/// [`AllPairs`](zimm_core::AllPairs) in open space. None is missed, however long segments are, and the cost is linear
/// in their number: long ones are looked up in several pieces about as long as the mean segment. The cell must have
/// room for half as much again as the cutoff.
///
/// Kumar and Larson, J. Chem. Phys. 114, 6937 (2001); Clarke, PhD thesis, MIT (2008), section 5.2. The lever rule is
/// that of Sirk, Sliozberg, Brennan, Lisal and Andzelm, J. Chem. Phys. 136, 134903 (2012).
///
/// ```
/// use zimm_core::{AllPairs, Clock, DVec3, ForceField, Open, Particles, System};
/// use zimm_forces::{PanManke, SegmentRepulsion};
///
/// // A bond along y, 0.1 above a quarter of a bond along x.
/// let beads = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.25, -0.5, 0.1), (0.25, 0.5, 0.1)];
/// let particles = Particles::new(beads.map(DVec3::from).to_vec())?;
/// let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
/// let law = PanManke::new(18.75, 1.0)?;
/// let mut repulsion = SegmentRepulsion::new(law, vec![[0, 1], [2, 3]], AllPairs::default());
/// let mut forces = vec![DVec3::ZERO; 4];
/// repulsion.accumulate(&system.frame(), &mut forces, &mut ())?;
///
/// // 39.375 up and down, on the lower bond in shares of 3 to 1.
/// let upwards = [-0.75, -0.25, 0.5, 0.5];
/// for (force, share) in forces.iter().zip(upwards) {
///     assert!((*force - 39.375 * share * DVec3::Z).length() < 0.01);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SegmentRepulsion<L, N> {
    law: L,
    bonds: Vec<[u32; 2]>,
    list: SegmentList<N>,
    /// What comes of each candidate.
    contacts: Vec<Option<Near>>,
}

/// Two segments in range of each other.
#[derive(Clone, Copy, Debug)]
struct Near {
    beads: [[usize; 2]; 2],
    places: [f64; 2],
    at: DVec3,
    apart: DVec3,
    distance: f64,
    /// Over the distance.
    force: f64,
}

impl<L, N> SegmentRepulsion<L, N> {
    /// A law between the bonds that join these identities, from a source of pairs of points.
    pub fn new(law: L, bonds: Vec<[u32; 2]>, neighbours: N) -> Self {
        Self {
            law,
            bonds,
            list: SegmentList::new(neighbours),
            contacts: Vec::new(),
        }
    }

    /// The law.
    pub fn law(&self) -> &L {
        &self.law
    }

    /// The identities that the segments join.
    pub fn bonds(&self) -> &[[u32; 2]] {
        &self.bonds
    }

    /// The source of pairs.
    pub fn neighbours(&self) -> &N {
        self.list.source()
    }
}

impl<B, L, N> ForceField<B> for SegmentRepulsion<L, N>
where
    B: Boundary,
    L: SegmentForce,
    N: Neighbours<B>,
{
    const READS: Reads = Reads::NOTHING;
    const CONSERVES_MOMENTUM: bool = true;

    fn accumulate<T: Tally>(
        &mut self,
        frame: &Frame<'_, B>,
        forces: &mut [DVec3],
        tally: &mut T,
    ) -> Result<(), ForceError> {
        let cutoff = self.law.cutoff();
        self.list.refresh(frame, &self.bonds, cutoff)?;
        let (law, list, space) = (&self.law, &self.list, Space::new(frame.boundary));
        let candidates = list.candidates();
        self.contacts.resize(candidates.len(), None);
        for_each_chunk(&mut self.contacts, |start, chunk| {
            for (near, &candidate) in chunk.iter_mut().zip(&candidates[start..]) {
                *near = contact(law, list, &space, candidate);
            }
        });
        for near in self.contacts.iter().flatten() {
            let force = near.force * near.apart;
            for (beads, place, force) in [
                (near.beads[0], near.places[0], force),
                (near.beads[1], near.places[1], -force),
            ] {
                let share = (0.5 + place) * force;
                forces[beads[0]] += force - share;
                forces[beads[1]] += share;
            }
            tally.hear(Item::SpringRepulsion, near.at, near.apart, force, &|| {
                law.energy(near.distance)
            });
        }
        Ok(())
    }

    fn forget(&mut self) {
        self.list.forget();
    }
}

/// The closest approach of a candidate's segments, if it is in range and this candidate of theirs owns it.
#[inline(always)]
fn contact<B: Boundary, L: SegmentForce, N>(
    law: &L,
    list: &SegmentList<N>,
    space: &Space<'_, B>,
    candidate: Candidate,
) -> Option<Near> {
    let (cutoff, smallest) = (law.cutoff(), law.smallest());
    let Meeting { segments, middles } = list.meeting(candidate, space, cutoff)?;
    let [first, second] = segments.map(|segment| segment.span);
    let Approach { s, t, apart } = Approach::between(middles, first, second, smallest);
    let squared = apart.length_squared() + smallest * smallest * (1.0 + s * s + t * t);
    if squared < cutoff * cutoff && list.owns(candidate, [s, t]) {
        let distance = length::distance(squared);
        Some(Near {
            beads: segments.map(|segment| segment.beads),
            places: [s, t],
            at: segments[0].middle + s * first,
            apart,
            distance,
            force: law.force(distance) / distance,
        })
    } else {
        None
    }
}
