//! The pair part of the sum: a sparse matrix.

use super::{plan::Plan, split::Kernel};
use std::ops::Range;
use zimm_core::{DVec3, IVec3, each_block};

/// Beads whose pairs one task finds and multiplies.
const ROWS: usize = 256;
/// Pairs that are evaluated together.
const LANES: usize = 8;

/// The pair part for one configuration, rows in the mesh's order. Both halves are kept, so that a row is summed by
/// itself; an image of a bead is a pair with itself.
#[derive(Clone, Debug, Default)]
pub(super) struct Near {
    alone: f64,
    positions: Vec<DVec3>,
    cells: Cells,
    blocks: Vec<Block>,
    arch: pulp::Arch,
}

/// Pairs of some rows: `f I + g r r` with r = (x, y, z).
#[derive(Clone, Debug, Default)]
struct Block {
    ends: Vec<u32>,
    js: Vec<u32>,
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
    f: Vec<f64>,
    g: Vec<f64>,
}

impl Near {
    /// Finds and evaluates all pairs within the range of the kernel, in whatever image.
    pub(super) fn bind(
        &mut self,
        plan: &Plan,
        kernel: &Kernel,
        positions: &[DVec3],
        order: &[u32],
    ) {
        self.alone = kernel.alone();
        self.positions.clear();
        let fold = |&place: &u32| {
            let s = plan.inverse * positions[place as usize];
            plan.basis * (s - s.floor())
        };
        self.positions.extend(order.iter().map(fold));
        self.cells.sort(plan, &self.positions);
        let blocks = self.positions.len().div_ceil(ROWS);
        self.blocks.resize_with(blocks, Block::default);
        let (cells, positions, arch) = (&self.cells, &self.positions, self.arch);
        each_block(&mut self.blocks, |k, block| {
            let first = k * ROWS;
            arch.dispatch(Find {
                plan,
                kernel,
                cells,
                first,
                positions: &positions[first..positions.len().min(first + ROWS)],
                block,
            });
        });
    }

    /// Number of pairs kept.
    pub(super) fn pairs(&self) -> usize {
        self.blocks.iter().map(|block| block.js.len()).sum()
    }

    /// Adds the velocities for forces, both in the mesh's order, of beads of a mobility of one alone.
    pub(super) fn apply(&self, forces: &[DVec3], velocities: &mut [DVec3]) {
        let mut chunks: Vec<&mut [DVec3]> = velocities.chunks_mut(ROWS).collect();
        each_block(&mut chunks, |k, velocities| {
            let Some(block) = self.blocks.get(k) else {
                return;
            };
            let own = &forces[k * ROWS..];
            let mut start = 0;
            for ((u, own), &end) in velocities.iter_mut().zip(own).zip(&block.ends) {
                let end = end as usize;
                *u += self.alone * *own + block.row(start, end, forces);
                start = end;
            }
        });
    }
}

impl Block {
    #[inline(always)]
    fn row(&self, start: usize, end: usize, forces: &[DVec3]) -> DVec3 {
        let range = start..end;
        let [x, y, z] = [&self.x, &self.y, &self.z].map(|column| &column[range.clone()]);
        let pairs = self.js[range.clone()].iter().zip(x).zip(y).zip(z);
        let kernels = self.f[range.clone()].iter().zip(&self.g[range]);
        let mut sum = DVec3::ZERO;
        for ((((&j, &x), &y), &z), (&f, &g)) in pairs.zip(kernels) {
            let (r, force) = (DVec3::new(x, y, z), forces[j as usize]);
            sum += f * force + g * r.dot(force) * r;
        }
        sum
    }

    fn clear(&mut self) {
        self.ends.clear();
        self.js.clear();
        for column in [
            &mut self.x,
            &mut self.y,
            &mut self.z,
            &mut self.f,
            &mut self.g,
        ] {
            column.clear();
        }
    }
}

/// Finds the pairs of some rows; `call` is compiled once for every instruction set and the best one runs.
struct Find<'a> {
    plan: &'a Plan,
    kernel: &'a Kernel,
    cells: &'a Cells,
    first: usize,
    positions: &'a [DVec3],
    block: &'a mut Block,
}

impl pulp::NullaryFnOnce for Find<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self {
            plan,
            kernel,
            cells,
            first,
            positions,
            block,
        } = self;
        block.clear();
        let mut found = Found::default();
        let most = kernel.range() * kernel.range();
        let (mut runs, mut cell) = (Vec::new(), IVec3::MIN);
        for (k, &r) in positions.iter().enumerate() {
            let own = (first + k) as u32;
            let here = cells.locate(plan, r);
            if here != cell {
                cell = here;
                cells.runs(plan, cell, &mut runs);
            }
            for (shift, run) in &runs {
                let here = r - *shift;
                found.count = 0;
                cells.collect(here, most, run.clone(), &mut found);
                let itself = *shift == DVec3::ZERO;
                for &at in &found.places[..found.count] {
                    let at = at as usize;
                    let j = cells.order[at];
                    if itself && j == own {
                        continue;
                    }
                    let [x, y, z] = &cells.columns;
                    block.js.push(j);
                    block.x.push(here.x - x[at]);
                    block.y.push(here.y - y[at]);
                    block.z.push(here.z - z[at]);
                }
            }
            block.ends.push(block.js.len() as u32);
        }
        let pairs = block.js.len();
        block.f.resize(pairs, 0.0);
        block.g.resize(pairs, 0.0);
        for start in (0..pairs).step_by(LANES) {
            let range = start..pairs.min(start + LANES);
            let mut r2 = [0.0; LANES];
            for (lane, k) in range.clone().enumerate() {
                let (x, y, z) = (block.x[k], block.y[k], block.z[k]);
                r2[lane] = x * x + y * y + z * z;
            }
            let (f, g) = kernel.pairs(&r2);
            let length = range.len();
            block.f[range.clone()].copy_from_slice(&f[..length]);
            block.g[range].copy_from_slice(&g[..length]);
        }
    }
}

/// Places of beads in cells that are in range.
#[derive(Default)]
struct Found {
    places: Vec<u32>,
    count: usize,
}

/// Beads sorted into cells in fractional coordinates, those along the last basis vector next to each other in memory.
#[derive(Clone, Debug, Default)]
struct Cells {
    count: IVec3,
    reach: IVec3,
    starts: Vec<u32>,
    order: Vec<u32>,
    columns: [Vec<f64>; 3],
}

impl Cells {
    fn sort(&mut self, plan: &Plan, positions: &[DVec3]) {
        /// Cells in a range.
        const CUT: DVec3 = DVec3::new(1.0, 1.0, 4.0);
        let most = (2 * positions.len() + 64) as f64;
        let mut count = (plan.widths / plan.range * CUT).floor().max(DVec3::ONE);
        let wanted = count.element_product();
        if wanted > most {
            count = (count * libm::cbrt(most / wanted)).floor().max(DVec3::ONE);
        }
        let reach = (plan.range * count / plan.widths - 1e-9)
            .ceil()
            .max(DVec3::ONE);
        (self.count, self.reach) = (count.as_ivec3(), reach.as_ivec3());
        let cell = |r: &DVec3| self.index(self.locate(plan, *r));
        let mut starts = vec![0_u32; self.count.element_product() as usize + 1];
        let cells: Vec<usize> = positions.iter().map(cell).collect();
        for cell in &cells {
            starts[cell + 1] += 1;
        }
        for k in 1..starts.len() {
            starts[k] += starts[k - 1];
        }
        self.starts.clone_from(&starts);
        self.order.resize(positions.len(), 0);
        for column in &mut self.columns {
            column.resize(positions.len(), 0.0);
        }
        for (k, (cell, r)) in cells.iter().zip(positions).enumerate() {
            let at = starts[*cell] as usize;
            starts[*cell] += 1;
            self.order[at] = k as u32;
            for (c, column) in self.columns.iter_mut().enumerate() {
                column[at] = r[c];
            }
        }
    }

    /// Appends those of a run of beads that are closer than the root of `most`. Every one is written; only those
    /// within are kept.
    #[inline(always)]
    fn collect(&self, here: DVec3, most: f64, run: Range<usize>, found: &mut Found) {
        const RUN: usize = 32;
        let mut squares = [0.0; RUN];
        for start in run.clone().step_by(RUN) {
            let range = start..run.end.min(start + RUN);
            let [x, y, z] = &self.columns;
            let columns = x[range.clone()]
                .iter()
                .zip(&y[range.clone()])
                .zip(&z[range.clone()]);
            for (square, ((x, y), z)) in squares.iter_mut().zip(columns) {
                let (dx, dy, dz) = (here.x - x, here.y - y, here.z - z);
                *square = dx * dx + dy * dy + dz * dz;
            }
            if found.places.len() < found.count + RUN {
                found.places.resize(2 * found.count + RUN, 0);
            }
            let room = &mut found.places[found.count..found.count + RUN];
            let mut count = 0;
            for (at, &square) in range.zip(&squares) {
                room[count] = at as u32;
                count += (square < most) as usize;
            }
            found.count += count;
        }
    }

    #[inline(always)]
    fn locate(&self, plan: &Plan, r: DVec3) -> IVec3 {
        let cell = (plan.inverse * r * self.count.as_dvec3()).as_ivec3();
        cell.clamp(IVec3::ZERO, self.count - 1)
    }

    #[inline(always)]
    fn index(&self, cell: IVec3) -> usize {
        ((cell.x * self.count.y + cell.y) * self.count.z + cell.z) as usize
    }

    /// Runs of beads that may be in reach of those of a cell, each with its lattice vector.
    fn runs(&self, plan: &Plan, cell: IVec3, runs: &mut Vec<(DVec3, Range<usize>)>) {
        runs.clear();
        let count = self.count;
        let (low, high) = (cell - self.reach, cell + self.reach);
        for x in low.x..=high.x {
            for y in low.y..=high.y {
                let mut z = low.z;
                while z <= high.z {
                    let here = IVec3::new(x, y, z);
                    let image = here.div_euclid(count);
                    let cell = here - image * count;
                    let last = high.z.min(z - cell.z + count.z - 1);
                    let first = self.index(cell);
                    let after = first + (last - z) as usize + 1;
                    let run = self.starts[first] as usize..self.starts[after] as usize;
                    if !run.is_empty() {
                        runs.push((plan.basis * image.as_dvec3(), run));
                    }
                    z = last + 1;
                }
            }
        }
    }
}
