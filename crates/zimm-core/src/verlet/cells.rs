//! Particles sorted along cells.

use super::lanes::LANES;
use crate::{
    Lattice,
    parallel::{for_each_chunk, for_each_chunk_of},
};
use glam::{DMat3, DVec3, IVec3};

/// Cells in fractional coordinates. The last axis is cut finely: cells along it lie next to each other in memory, so
/// a particle's candidates in one column of cells are one range.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    basis: DMat3,
    inverse: DMat3,
    cells: IVec3,
    reach: IVec3,
    images: IVec3,
    /// How far the search looks, as a reciprocal.
    per_range: f64,
}

impl Grid {
    pub(super) fn new(lattice: &Lattice, range: f64, particles: usize) -> Self {
        const CUT: DVec3 = DVec3::new(1.0, 1.0, 4.0);
        let widths = lattice.widths();
        let most = (4 * particles + 64) as f64;
        let mut cells = (widths / range * CUT)
            .floor()
            .min(DVec3::splat(1e6))
            .max(DVec3::ONE);
        let wanted = cells.element_product();
        if wanted > most {
            cells = (cells * libm::cbrt(most / wanted)).floor().max(DVec3::ONE);
        }
        let reach = (range * cells / widths - 1e-9).ceil().max(DVec3::ONE);
        let images = (reach / cells).ceil() + 1.0;
        Self {
            basis: lattice.basis(),
            inverse: lattice.inverse(),
            cells: cells.as_ivec3(),
            reach: reach.as_ivec3(),
            images: images.as_ivec3(),
            per_range: range.recip(),
        }
    }

    fn number_of_cells(&self) -> usize {
        self.cells.as_i64vec3().element_product() as usize
    }

    #[inline(always)]
    fn locate(&self, r: DVec3) -> Located {
        let s = self.inverse * r;
        let n = crate::lattice::round(s);
        let cell = ((s - n + 0.5) * self.cells.as_dvec3()).as_ivec3();
        Located {
            cell: cell.clamp(IVec3::ZERO, self.cells - 1),
            position: r - self.basis * n,
        }
    }

    #[inline(always)]
    fn index(&self, cell: IVec3) -> usize {
        ((cell.x as usize * self.cells.y as usize) + cell.y as usize) * self.cells.z as usize
            + cell.z as usize
    }

    /// A position in units of the range, in single precision.
    #[inline(always)]
    pub(super) fn rounded(&self, r: DVec3) -> [f32; 3] {
        (r * self.per_range).to_array().map(|x| x as f32)
    }

    /// The squared distance of rounded positions, one of them in a neighbouring image, above which they are out of
    /// range for sure: each coordinate is off by half a unit in its last place.
    pub(super) fn limit(&self) -> f32 {
        let [a, b, c] = [self.basis.x_axis, self.basis.y_axis, self.basis.z_axis].map(DVec3::abs);
        let images = self.images.max_element() + 1;
        let furthest = f64::from(images) * (a + b + c).max_element() * self.per_range;
        let epsilon = f64::from(f32::EPSILON);
        (1.0 + 4.0 * epsilon * (1.0 + furthest)).powi(2) as f32
    }

    /// Where the lattice vector that belongs to an image stands in the table of shifts.
    pub(super) fn shift_index(&self, image: IVec3) -> u32 {
        let side = 2 * self.images + 1;
        let n = image + self.images;
        ((n.x * side.y + n.y) * side.z + n.z) as u32
    }

    /// The runs of cells in reach of one cell, each unordered pair of cells once: the cell itself and what follows it
    /// in its column first. Those of the primary image come before those across a boundary.
    pub(super) fn half_space(&self, cell: IVec3, starts: &[u32], runs: &mut Vec<Run>) {
        runs.clear();
        let highest = cell.z + self.reach.z;
        for da in 0..=self.reach.x {
            let first = if da == 0 { 0 } else { -self.reach.y };
            for db in first..=self.reach.y {
                let (a, image_a) = wrap_cell(cell.x + da, self.cells.x);
                let (b, image_b) = wrap_cell(cell.y + db, self.cells.y);
                let column = self.index(IVec3::new(a, b, 0));
                let own = da == 0 && db == 0;
                let mut c = if own { cell.z } else { cell.z - self.reach.z };
                while c <= highest {
                    let (wrapped, image_c) = wrap_cell(c, self.cells.z);
                    let last = highest.min(c - wrapped + self.cells.z - 1);
                    let from = starts[column + wrapped as usize];
                    let to = starts[column + (last - c + wrapped) as usize + 1];
                    if from < to {
                        runs.push(Run {
                            image: IVec3::new(image_a, image_b, image_c),
                            from,
                            to,
                        });
                    }
                    c = last + 1;
                }
            }
        }
        runs.sort_by_key(|run| run.image != IVec3::ZERO);
    }

    /// What to add to the first particle when the second is seen in an image.
    pub(super) fn shift(&self, image: IVec3) -> DVec3 {
        self.basis * -image.as_dvec3()
    }

    /// What to add to the first particle when the second is seen in each image.
    pub(super) fn shifts(&self, table: &mut Vec<DVec3>) {
        table.clear();
        for a in -self.images.x..=self.images.x {
            for b in -self.images.y..=self.images.y {
                for c in -self.images.z..=self.images.z {
                    table.push(self.shift(IVec3::new(a, b, c)));
                }
            }
        }
    }
}

/// A position in the primary cell, and in which of the cells that it is cut into.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Located {
    pub(super) cell: IVec3,
    pub(super) position: DVec3,
}

/// Particles sorted along cells.
#[derive(Clone, Debug, Default)]
pub(super) struct Sorting {
    /// In the order of places.
    located: Vec<Located>,
    /// Where each cell starts, and the end of the last.
    pub(super) starts: Vec<u32>,
    /// The place of each particle in the system.
    pub(super) order: Vec<u32>,
    /// In the order of cells.
    pub(super) sorted: Vec<Located>,
    /// The positions again, by axis and rounded, with a margin.
    pub(super) rounded: [Vec<f32>; 3],
}

impl Sorting {
    pub(super) fn sort(&mut self, grid: &Grid, positions: &[DVec3]) {
        let n = positions.len();
        self.located.resize(n, Located::default());
        for_each_chunk(&mut self.located, |start, chunk| {
            for (located, &r) in chunk.iter_mut().zip(&positions[start..]) {
                *located = grid.locate(r);
            }
        });
        self.starts.clear();
        self.starts.resize(grid.number_of_cells() + 1, 0);
        for located in &self.located {
            self.starts[grid.index(located.cell) + 1] += 1;
        }
        for c in 1..self.starts.len() {
            self.starts[c] += self.starts[c - 1];
        }
        self.order.resize(n, 0);
        for (place, located) in (0..).zip(&self.located) {
            let start = &mut self.starts[grid.index(located.cell)];
            self.order[*start as usize] = place;
            *start += 1;
        }
        self.starts.rotate_right(1);
        self.starts[0] = 0;
        let (located, order) = (&self.located, &self.order);
        self.sorted.resize(n, Located::default());
        for column in &mut self.rounded {
            column.clear();
            column.resize(n + LANES, 0.0);
        }
        let [x, y, z] = self.rounded.each_mut().map(|column| &mut column[..n]);
        let columns = ((&mut self.sorted[..], x), (y, z));
        for_each_chunk_of(columns, |start, ((sorted, x), (y, z))| {
            for (k, &place) in order[start..start + sorted.len()].iter().enumerate() {
                sorted[k] = located[place as usize];
                [x[k], y[k], z[k]] = grid.rounded(sorted[k].position);
            }
        });
    }
}

/// Particles that lie in one row of cells, as seen from some cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub(super) image: IVec3,
    pub(super) from: u32,
    pub(super) to: u32,
}

/// A cell index in 0..cells and the image it was in.
#[inline(always)]
fn wrap_cell(index: i32, cells: i32) -> (i32, i32) {
    if (0..cells).contains(&index) {
        (index, 0)
    } else {
        (index.rem_euclid(cells), index.div_euclid(cells))
    }
}
