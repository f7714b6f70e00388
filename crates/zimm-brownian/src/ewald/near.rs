//! The sum over pairs.

use super::cells::{Cells, LANES, Pairs};
use super::kernel::Kernel;
use super::series::WIDTH;
use crate::rpy::block;
use std::ops::Range;
use zimm_core::{DMat3, DVec3, Lattice, each_block};

/// The sum over all pairs of images within a cutoff of what is left to pairs.
#[derive(Clone, Debug)]
pub(crate) struct Near {
    kernel: Kernel,
    cells: Cells,
    kept: bool,
    blocks: Vec<Block>,
    forces: Vec<DVec3>,
    arch: pulp::Arch,
}

/// The pairs of a range of beads, and the velocities that they make.
#[derive(Clone, Debug, Default)]
struct Block {
    beads: Range<usize>,
    pairs: Pairs,
    /// A and B of A I + B rr of each pair.
    factors: [Vec<f64>; 2],
    velocities: Vec<DVec3>,
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
            arch: pulp::Arch::new(),
        }
    }

    pub(crate) fn set_kernel(&mut self, kernel: Kernel) {
        self.kernel = kernel;
    }

    pub(crate) fn bind(&mut self, lattice: &Lattice, positions: &[DVec3], cutoff: f64) {
        self.cells.sort(lattice, positions, cutoff);
        let beads = positions.len();
        let count = (beads / 256).clamp(1, 8);
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
            arch,
        } = self;
        sorted.clear();
        sorted.extend(cells.order.iter().map(|&place| forces[place as usize]));
        each_block(blocks, |_, block| {
            arch.dispatch(Multiply {
                block,
                cells,
                kernel,
                kept: *kept,
                forces: sorted,
            });
        });
        let own = kernel.own();
        for (k, &place) in cells.order.iter().enumerate() {
            let mut velocity = own * sorted[k];
            for block in &*blocks {
                velocity += block.velocities[k];
            }
            velocities[place as usize] += velocity;
        }
    }

    /// The 3 x 3 block of beads at the separation `r`, or of a bead and itself.
    pub(crate) fn entry(&self, lattice: &Lattice, r: DVec3, itself: bool) -> DMat3 {
        let mut sum = DMat3::ZERO;
        self.cells.images(lattice, r, |r| {
            if !(itself && r == DVec3::ZERO) {
                let [iso, dyad] = self.kernel.evaluate(&[r.length_squared(); WIDTH]);
                sum += block(r, [iso[0], dyad[0]]);
            }
        });
        if itself {
            sum += DMat3::from_diagonal(DVec3::splat(self.kernel.own()));
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
    forces: &'a [DVec3],
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
        self.pairs.fill(cells, beads);
        let len = self.pairs.len();
        let [x, y, z] = self.pairs.apart.each_mut().map(|column| &mut column[..len]);
        let [isos, dyads] = &mut self.factors;
        isos.resize(len, 0.0);
        dyads.resize(len, 0.0);
        let mut from = 0;
        while from < len {
            let to = (from + WIDTH).min(len);
            let mut r2 = [0.0; WIDTH];
            for (r2, k) in r2.iter_mut().zip(from..to) {
                let square = x[k] * x[k] + y[k] * y[k] + z[k] * z[k];
                *r2 = if square < f64::INFINITY { square } else { 0.0 };
            }
            let [iso, dyad] = kernel.evaluate(&r2);
            isos[from..to].copy_from_slice(&iso[..to - from]);
            dyads[from..to].copy_from_slice(&dyad[..to - from]);
            for k in from..to {
                if x[k] == f64::INFINITY {
                    (x[k], y[k], z[k], isos[k], dyads[k]) = (0.0, 0.0, 0.0, 0.0, 0.0);
                }
            }
            from = to;
        }
    }

    #[inline(always)]
    fn work(&mut self, cells: &Cells, kernel: &Kernel, kept: bool, forces: &[DVec3]) {
        const BEADS: usize = 32;
        self.velocities.clear();
        self.velocities.resize(forces.len(), DVec3::ZERO);
        if kept {
            self.multiply(forces);
            return;
        }
        let beads = self.beads.clone();
        for first in beads.clone().step_by(BEADS) {
            self.fill(cells, kernel, first..beads.end.min(first + BEADS));
            self.multiply(forces);
        }
    }

    #[inline(always)]
    fn multiply(&mut self, forces: &[DVec3]) {
        let [x, y, z] = &self.pairs.apart;
        let [isos, dyads] = &self.factors;
        let mut from = 0;
        for (k, &end) in self.pairs.ends.iter().enumerate() {
            let i = self.pairs.first + k;
            let force = forces[i];
            let mut sum = [[0.0; LANES]; 3];
            while from < end as usize {
                let lanes = from..from + LANES;
                let partners = &self.pairs.partners[lanes.clone()];
                let (x, y, z) = (&x[lanes.clone()], &y[lanes.clone()], &z[lanes.clone()]);
                let (iso, dyad) = (&isos[lanes.clone()], &dyads[lanes]);
                let mut f = [[0.0; LANES]; 3];
                for (l, &j) in partners.iter().enumerate() {
                    let force = forces[j as usize];
                    (f[0][l], f[1][l], f[2][l]) = (force.x, force.y, force.z);
                }
                let mut back = [[0.0; LANES]; 3];
                for l in 0..LANES {
                    let (x, y, z, iso, dyad) = (x[l], y[l], z[l], iso[l], dyad[l]);
                    let along = dyad * (x * f[0][l] + y * f[1][l] + z * f[2][l]);
                    sum[0][l] += iso * f[0][l] + along * x;
                    sum[1][l] += iso * f[1][l] + along * y;
                    sum[2][l] += iso * f[2][l] + along * z;
                    let along = dyad * (x * force.x + y * force.y + z * force.z);
                    back[0][l] = iso * force.x + along * x;
                    back[1][l] = iso * force.y + along * y;
                    back[2][l] = iso * force.z + along * z;
                }
                for (l, &j) in partners.iter().enumerate() {
                    self.velocities[j as usize] += DVec3::new(back[0][l], back[1][l], back[2][l]);
                }
                from += LANES;
            }
            self.velocities[i] += DVec3::from_array(sum.map(|lanes| lanes.iter().sum()));
        }
    }
}
