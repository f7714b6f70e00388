//! The sum over pairs.

use super::cells::{Cells, Pairs};
use super::{Kernel, Plan};
use crate::rpy::block;
use std::ops::Range;
use zimm_core::{DMat3, DVec3, Lattice, each_block};

/// Pairs that are evaluated together.
const WIDTH: usize = 16;

/// The sum over all pairs of images within a range of what is left to pairs.
#[derive(Clone, Debug)]
pub(crate) struct Near {
    kernel: Kernel,
    cells: Cells,
    kept: bool,
    blocks: Vec<Block>,
    /// Forces in the order of cells, and the first ones again.
    forces: Vec<[f64; 4]>,
    sums: Vec<[f64; 4]>,
    arch: pulp::Arch,
}

/// The pairs of a range of beads, and the velocities that they make.
#[derive(Clone, Debug, Default)]
struct Block {
    beads: Range<usize>,
    /// The bead from which on partners are counted.
    start: usize,
    pairs: Pairs,
    /// B of A I + B rr of each pair; A is kept with the separation.
    dyads: Vec<f64>,
    /// Of the beads from there on, and round the end of the column, as far as partners go.
    velocities: Vec<[f64; 4]>,
}

impl Near {
    /// With the pairs kept from one configuration to the next, or looked up in every product.
    pub(crate) fn new(kept: bool) -> Self {
        Self {
            kernel: Kernel::default(),
            cells: Cells::default(),
            kept,
            blocks: Vec::new(),
            forces: Vec::new(),
            sums: Vec::new(),
            arch: pulp::Arch::new(),
        }
    }

    /// Both parts of the split that was bound last.
    pub(crate) fn kernel(&self) -> &Kernel {
        &self.kernel
    }

    /// Number of pairs, each counted once; zero if they are not kept.
    pub(crate) fn pairs(&self) -> usize {
        self.blocks.iter().map(|block| block.pairs.len()).sum()
    }

    pub(crate) fn bind(&mut self, plan: Plan, lattice: &Lattice, positions: &[DVec3]) {
        /// Enough for threads to share.
        const BLOCKS: usize = 8;
        const LEAST: usize = 256;
        if *self.kernel.plan() != plan {
            self.kernel = Kernel::new(plan);
        }
        self.cells.sort(lattice, positions, plan.range);
        let beads = positions.len();
        let count = (beads / LEAST).clamp(1, BLOCKS);
        self.blocks.resize_with(count, Block::default);
        let Self {
            kernel,
            cells,
            kept,
            blocks,
            arch,
            ..
        } = self;
        each_block(blocks, |b, block| {
            block.beads = b * beads / count..(b + 1) * beads / count;
            let [start, company] = cells.company(&block.beads);
            block.start = start;
            block.velocities.resize(company, [0.0; 4]);
            if *kept {
                arch.dispatch(Fill {
                    block,
                    cells,
                    kernel,
                });
            }
        });
    }

    /// Adds the velocities, in units of the mobility of a bead alone.
    pub(crate) fn apply(&mut self, forces: &[DVec3], velocities: &mut [DVec3]) {
        let Self {
            kernel,
            cells,
            kept,
            blocks,
            forces: sorted,
            sums,
            arch,
        } = self;
        let ends = blocks.iter().map(|b| b.start + b.velocities.len());
        let again = ends.max().unwrap_or(0).saturating_sub(cells.order.len());
        let order = cells.order.iter().chain(&cells.order[..again]);
        sorted.clear();
        sorted.extend(order.map(|&place| padded(forces[place as usize])));
        each_block(blocks, |_, block| {
            arch.dispatch(Multiply {
                block,
                cells,
                kernel,
                kept: *kept,
                forces: sorted,
            });
        });
        let own = kernel.alone();
        sums.clear();
        let alone = sorted[..cells.order.len()].iter();
        sums.extend(alone.map(|force| force.map(|f| own * f)));
        for block in &*blocks {
            let (before, from) = sums.split_at_mut(block.start);
            for (sum, velocity) in from.iter_mut().chain(before).zip(&block.velocities) {
                for (sum, velocity) in sum.iter_mut().zip(velocity) {
                    *sum += velocity;
                }
            }
        }
        for (&place, &[x, y, z, _]) in cells.order.iter().zip(&*sums) {
            velocities[place as usize] += DVec3::new(x, y, z);
        }
    }

    /// The 3 x 3 block of beads at the separation `r`, or of a bead and itself.
    pub(crate) fn entry(&self, lattice: &Lattice, r: DVec3, itself: bool) -> DMat3 {
        let mut sum = DMat3::ZERO;
        self.cells.images(lattice, r, |r| {
            if !(itself && r == DVec3::ZERO) {
                let [[iso], [dyad]] = self.kernel.pairs(&[r.length_squared()]);
                sum += block(r, [iso, dyad]);
            }
        });
        if itself {
            sum += DMat3::from_diagonal(DVec3::splat(self.kernel.alone()));
        }
        sum
    }
}

/// Finds and evaluates the pairs of a block; `call` is compiled once for every instruction set and the best one runs.
struct Fill<'a> {
    block: &'a mut Block,
    cells: &'a Cells,
    kernel: &'a Kernel,
}

impl pulp::NullaryFnOnce for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let beads = self.block.beads.clone();
        self.block.fill(self.cells, self.kernel, beads);
    }
}

/// The velocities that the pairs of a block make.
struct Multiply<'a> {
    block: &'a mut Block,
    cells: &'a Cells,
    kernel: &'a Kernel,
    kept: bool,
    forces: &'a [[f64; 4]],
}

impl pulp::NullaryFnOnce for Multiply<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self {
            block,
            cells,
            kernel,
            kept,
            forces,
        } = self;
        block.work(cells, kernel, kept, forces);
    }
}

impl Block {
    #[inline(always)]
    fn fill(&mut self, cells: &Cells, kernel: &Kernel, beads: Range<usize>) {
        self.pairs.fill(cells, self.start, beads);
        self.dyads.resize(self.pairs.len(), 0.0);
        let apart = self.pairs.apart_mut().chunks_mut(WIDTH);
        for (apart, dyads) in apart.zip(self.dyads.chunks_mut(WIDTH)) {
            let mut r2 = [0.0; WIDTH];
            for (r2, [x, y, z, _]) in r2.iter_mut().zip(&*apart) {
                *r2 = *x * *x + *y * *y + *z * *z;
            }
            let [iso, dyad] = kernel.pairs(&r2);
            for ((apart, iso), (to, dyad)) in
                apart.iter_mut().zip(iso).zip(dyads.iter_mut().zip(dyad))
            {
                (apart[3], *to) = (iso, dyad);
            }
        }
    }

    #[inline(always)]
    fn work(&mut self, cells: &Cells, kernel: &Kernel, kept: bool, forces: &[[f64; 4]]) {
        const BEADS: usize = 32;
        self.velocities.fill([0.0; 4]);
        let forces = &forces[self.start..];
        let (beads, start) = (self.beads.clone(), self.start);
        if kept {
            self.multiply(beads.start - start, forces);
            return;
        }
        for first in beads.clone().step_by(BEADS) {
            self.fill(cells, kernel, first..beads.end.min(first + BEADS));
            self.multiply(first - start, forces);
        }
    }

    /// Adds the velocities of the pairs that are there, of beads from a number on, counted as partners are.
    #[inline(always)]
    fn multiply(&mut self, first: usize, forces: &[[f64; 4]]) {
        let (partners, apart) = (self.pairs.partners(), self.pairs.apart());
        let mut from = 0;
        for (k, &end) in self.pairs.ends.iter().enumerate() {
            let run = from..end as usize;
            let (here, mut sum) = (forces[first + k], [0.0; 4]);
            let pairs = partners[run.clone()].iter().zip(&apart[run.clone()]);
            for ((&j, r), dyad) in pairs.zip(&self.dyads[run]) {
                let (there, iso) = (forces[j as usize], r[3]);
                let (from_there, from_here) = (dyad * dot(r, &there), dyad * dot(r, &here));
                let back = &mut self.velocities[j as usize];
                for c in 0..4 {
                    sum[c] += iso * there[c] + from_there * r[c];
                    back[c] += iso * here[c] + from_here * r[c];
                }
            }
            for (velocity, sum) in self.velocities[first + k].iter_mut().zip(sum) {
                *velocity += sum;
            }
            from = end as usize;
        }
    }
}

/// A vector with a fourth number that does not count, which is zero for forces: as wide as a register is.
#[inline(always)]
fn padded(v: DVec3) -> [f64; 4] {
    [v.x, v.y, v.z, 0.0]
}

#[inline(always)]
fn dot(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    (a[0] * b[0] + a[2] * b[2]) + (a[1] * b[1] + a[3] * b[3])
}
