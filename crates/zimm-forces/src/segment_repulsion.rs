//! Repulsion between springs, so that chains do not pass through each other.

mod batch;
mod distance;
mod laws;
mod list;

pub use distance::Approach;
pub use laws::{KumarLarson, PanManke, Phantom, SegmentForce};

use batch::{Batch, BlockOfWork, Pull, View};
use list::SegmentList;
use zimm_core::{
    Boundary, DVec3, ForceError, ForceField, Frame, Neighbours, Reads, Tally, each_block,
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
/// [`Item::SpringRepulsion`](zimm_core::Item::SpringRepulsion); the virial of the four beads is their product.
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
/// in their number: long ones are looked up in several pieces. The cell must have room for half as much again as the
/// cutoff.
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
    blocks: Vec<Scratch>,
    arch: pulp::Arch,
}

/// What one block of work needs: a batch of pairs, and pulls on pieces in the source's order.
#[derive(Clone, Debug, Default)]
struct Scratch {
    batch: Box<Batch>,
    pulls: Vec<Pull>,
    /// Chunks of `pulls` that this block adds to.
    touched: Vec<bool>,
}

/// Pulls of a block are zeroed and joined in chunks of this many pieces, those it touches only.
const CHUNK: usize = 64;

impl<L, N> SegmentRepulsion<L, N> {
    /// A law between the bonds that join these identities, from a source of pairs of points.
    pub fn new(law: L, bonds: Vec<[u32; 2]>, neighbours: N) -> Self {
        Self {
            law,
            bonds,
            list: SegmentList::new(neighbours),
            blocks: Vec::new(),
            arch: pulp::Arch::new(),
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
        &self.list.source
    }

    /// Adapts buffers to a new order.
    fn adapt<B: Boundary>(&mut self)
    where
        N: Neighbours<B>,
    {
        let source = &self.list.source;
        let (blocks, n) = (source.blocks(), source.order().len());
        self.blocks.resize_with(blocks, Scratch::default);
        each_block(&mut self.blocks, |block, scratch| {
            scratch.pulls.resize(n, Pull::default());
            scratch.touched.clear();
            scratch.touched.resize(n.div_ceil(CHUNK), false);
            source.visit(block, |row| {
                for &piece in row.js.iter().chain([&row.i]) {
                    scratch.touched[piece as usize / CHUNK] = true;
                }
            });
        });
    }
}

impl Scratch {
    /// The chunks of pulls that this block adds to, and where they begin.
    fn chunks(&mut self) -> impl Iterator<Item = (usize, &mut [Pull])> {
        let chunks = self.pulls.chunks_mut(CHUNK).zip(&self.touched);
        let chunks = (0..).step_by(CHUNK).zip(chunks);
        chunks.filter_map(|(start, (chunk, touched))| touched.then_some((start, chunk)))
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
        if self.list.refresh(frame, &self.bonds, self.law.cutoff())? {
            self.adapt::<B>();
        }
        let view = View::new(&self.law, &self.list, frame.boundary);
        let (source, arch) = (&self.list.source, self.arch);
        let blocks = self.blocks.iter_mut();
        let mut blocks: Vec<_> = blocks.map(|block| (block, tally.fresh())).collect();
        each_block(&mut blocks, |block, (scratch, heard)| {
            scratch
                .chunks()
                .for_each(|(_, chunk)| chunk.fill(Pull::default()));
            arch.dispatch(BlockOfWork::<B, L, N, T> {
                view: &view,
                source,
                block,
                batch: &mut scratch.batch,
                pulls: &mut scratch.pulls,
                heard,
                boundary: std::marker::PhantomData,
            });
        });
        for (scratch, heard) in blocks {
            tally.absorb(heard);
            for (start, chunk) in scratch.chunks() {
                for (piece, pull) in self.list.sorted[start..].iter().zip(chunk) {
                    let beads = self.list.segments[piece.segment as usize].beads;
                    forces[beads[0] as usize] += 0.5 * pull.force - pull.moment;
                    forces[beads[1] as usize] += 0.5 * pull.force + pull.moment;
                }
            }
        }
        Ok(())
    }

    fn forget(&mut self) {
        self.list.forget();
    }
}
