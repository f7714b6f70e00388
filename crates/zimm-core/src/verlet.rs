//! The Verlet list: candidate pairs from cells, kept while no pair can have been missed.

use crate::neighbours::{cutoff_fits, not_finite};
use crate::{
    Frame, Lattice, ListError, Neighbours, ParameterError, Periodic, Row, parallel::each_block,
};
use glam::{DMat3, DVec3, IVec2, IVec3, Vec3Swizzles};
use std::ops::Range;

/// A half list of all pairs closer than cutoff + skin, made from cells and kept while it is sure to hold every pair
/// within the cutoff.
///
/// Cells are cut in fractional coordinates by the perpendicular widths of the reduced cell, so one list serves every
/// parallelepiped. The list moves with the flow: with F the deformation since it was made, s its least singular value
/// and d1, d2 the two largest displacements relative to F, it is good while
///
/// ```text
/// s (cutoff + skin) - d1 - d2 >= cutoff
/// ```
///
/// because a pair outside the list was at least cutoff + skin apart. Neither streaming nor a change of basis makes a
/// list invalid by itself.
///
/// Open space has no cells to cut, so this does not compile ([`AllPairs`](crate::AllPairs) serves there):
///
/// ```compile_fail,E0277
/// use zimm_core::{Clock, DVec3, ForceField, Open, Pairwise, Particles, System, VerletList};
///
/// let particles = Particles::new(vec![DVec3::ZERO, DVec3::X])?;
/// let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
/// let mut field = Pairwise::new((), VerletList::new(0.3)?);
/// field.accumulate(&system.frame(), &mut [DVec3::ZERO; 2], &mut ())?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct VerletList {
    skin: f64,
    made: Option<Made>,
    builds: u64,
    order: Vec<u32>,
    reference: Vec<DVec3>,
    positions: Vec<DVec3>,
    shifts: Vec<DVec3>,
    blocks: Vec<Block>,
    sorting: Sorting,
}

/// When and for what a list was made.
#[derive(Clone, Debug)]
struct Made {
    time: f64,
    cutoff: f64,
    shifts: Vec<DVec3>,
}

#[derive(Clone, Debug, Default)]
struct Block {
    rows: Vec<Entry>,
    js: Vec<u32>,
    used: usize,
}

/// A row: candidates `js[start..end]` of the block.
#[derive(Clone, Copy, Debug)]
struct Entry {
    i: u32,
    shift: u32,
    start: u32,
    end: u32,
}

impl VerletList {
    /// A list that looks `skin` further than the cutoff, at most three times as far. A thin skin is made anew often, a
    /// thick one holds many pairs that do not interact; the result is the same for all.
    ///
    /// # Errors
    /// If `skin` is below zero.
    pub fn new(skin: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            skin: ParameterError::non_negative("skin", skin)?,
            made: None,
            builds: 0,
            order: Vec::new(),
            reference: Vec::new(),
            positions: Vec::new(),
            shifts: Vec::new(),
            blocks: Vec::new(),
            sorting: Sorting::default(),
        })
    }

    /// How often the list has been made.
    pub fn builds(&self) -> u64 {
        self.builds
    }

    /// Number of pairs in the list.
    pub fn candidates(&self) -> usize {
        self.blocks.iter().map(|block| block.js.len()).sum()
    }

    /// How far the list looks.
    fn range(&self, cutoff: f64) -> f64 {
        cutoff + self.skin.min(2.0 * cutoff)
    }

    /// Brings positions and shifts of an existing list to now; false if a pair may have been missed.
    fn follow<B: Periodic>(&mut self, frame: &Frame<'_, B>, cutoff: f64) -> bool {
        let Some(made) = &self.made else { return false };
        if made.cutoff != cutoff || self.order.len() != frame.len() {
            return false;
        }
        let carry = frame.boundary.carry(made.time, frame.now.time);
        let lattice = frame.boundary.lattice();
        let mut largest = [0.0_f64; 2];
        let mut sum = 0.0;
        for ((here, &reference), &place) in self
            .positions
            .iter_mut()
            .zip(&self.reference)
            .zip(&self.order)
        {
            let carried = if B::FLOWS {
                carry * reference
            } else {
                reference
            };
            let moved = lattice.rounded(frame.positions[place as usize] - carried);
            *here = carried + moved;
            let d2 = moved.length_squared();
            sum += d2;
            if d2 > largest[1] {
                largest = if d2 > largest[0] {
                    [d2, largest[0]]
                } else {
                    [largest[0], d2]
                };
            }
        }
        if B::FLOWS {
            for (now, &then) in self.shifts.iter_mut().zip(&made.shifts) {
                *now = carry * then;
            }
        }
        let stretch = if B::FLOWS {
            least_singular_value(carry)
        } else {
            1.0
        };
        let clear = stretch * self.range(cutoff) - largest[0].sqrt() - largest[1].sqrt();
        sum.is_finite() && clear >= cutoff
    }

    fn make<B: Periodic>(&mut self, frame: &Frame<'_, B>, cutoff: f64) -> Result<(), ListError> {
        self.made = None;
        if let Some(particle) = frame.positions.iter().position(|r| !r.is_finite()) {
            return Err(not_finite(particle, frame.positions[particle]));
        }
        let grid = Grid::new(frame.boundary.lattice(), self.range(cutoff), frame.len());
        self.sorting.sort(&grid, frame.positions);
        self.order.clone_from(&self.sorting.order);
        self.reference.clone_from(&self.sorting.sorted);
        self.positions.clone_from(&self.sorting.sorted);
        let shifts = grid.shifts();
        self.shifts.clone_from(&shifts);
        self.blocks
            .resize_with(number_of_blocks(frame.len()), Block::default);
        let (count, sorting) = (self.blocks.len(), &self.sorting);
        let arch = pulp::Arch::new();
        each_block(&mut self.blocks, |b, block| {
            let range = block_range(b, count, sorting.order.len());
            arch.dispatch(Search {
                grid: &grid,
                sorting,
                range,
                block,
            });
        });
        self.builds += 1;
        self.made = Some(Made {
            time: frame.now.time,
            cutoff,
            shifts,
        });
        Ok(())
    }
}

impl<B: Periodic> Neighbours<B> for VerletList {
    fn refresh(&mut self, frame: &Frame<'_, B>, cutoff: f64) -> Result<bool, ListError> {
        cutoff_fits(frame.boundary, cutoff)?;
        if self.follow(frame, cutoff) {
            return Ok(false);
        }
        self.make(frame, cutoff)?;
        Ok(true)
    }

    fn order(&self) -> &[u32] {
        &self.order
    }

    fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    fn blocks(&self) -> usize {
        self.blocks.len()
    }

    #[inline(always)]
    fn visit(&self, block: usize, mut each: impl FnMut(Row<'_>)) {
        let block = &self.blocks[block];
        for row in &block.rows {
            each(Row {
                i: row.i,
                shift: self.shifts[row.shift as usize],
                js: &block.js[row.start as usize..row.end as usize],
            });
        }
    }

    fn forget(&mut self) {
        self.made = None;
    }
}

fn number_of_blocks(particles: usize) -> usize {
    (particles / 3000).clamp(1, 16)
}

fn block_range(block: usize, blocks: usize, particles: usize) -> Range<usize> {
    block * particles / blocks..(block + 1) * particles / blocks
}

/// The least factor by which a deformation scales any length.
fn least_singular_value(f: DMat3) -> f64 {
    let m = f.transpose() * f;
    let mean = (m.x_axis.x + m.y_axis.y + m.z_axis.z) / 3.0;
    let d = m - DMat3::from_diagonal(DVec3::splat(mean));
    let square = d.x_axis.length_squared() + d.y_axis.length_squared() + d.z_axis.length_squared();
    let p = (square / 6.0).sqrt();
    if p < 1e-150 {
        return mean.max(0.0).sqrt();
    }
    let cosine = (d.determinant() / (2.0 * p * p * p)).clamp(-1.0, 1.0);
    let angle = libm::acos(cosine) / 3.0;
    let least = mean + 2.0 * p * libm::cos(angle + 2.0 * std::f64::consts::FRAC_PI_3);
    least.max(0.0).sqrt()
}

/// Cells in fractional coordinates. The last axis is cut finely: cells along it lie next to each other in memory, so
/// a particle's candidates in one column of cells are one range.
#[derive(Clone, Debug)]
struct Grid {
    basis: DMat3,
    inverse: DMat3,
    cells: IVec3,
    reach: IVec3,
    images: IVec3,
    range: f64,
}

impl Grid {
    fn new(lattice: &Lattice, range: f64, particles: usize) -> Self {
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
            range,
        }
    }

    fn number_of_cells(&self) -> usize {
        self.cells.as_i64vec3().element_product() as usize
    }

    /// The cell of a position, and the position in the primary cell.
    #[inline(always)]
    fn locate(&self, r: DVec3) -> (IVec3, DVec3) {
        let s = self.inverse * r;
        let n = crate::lattice::round(s);
        let cell = ((s - n + 0.5) * self.cells.as_dvec3()).as_ivec3();
        (cell.clamp(IVec3::ZERO, self.cells - 1), r - self.basis * n)
    }

    #[inline(always)]
    fn index(&self, cell: IVec3) -> usize {
        ((cell.x as usize * self.cells.y as usize) + cell.y as usize) * self.cells.z as usize
            + cell.z as usize
    }

    /// Where the lattice vector that belongs to an image stands in the table of shifts.
    fn shift_index(&self, image: IVec3) -> u32 {
        let side = 2 * self.images + 1;
        let n = image + self.images;
        ((n.x * side.y + n.y) * side.z + n.z) as u32
    }

    /// The columns in reach of one column, each unordered pair of columns once, its own first.
    fn half_space_of_columns(&self, own: IVec2, columns: &mut Vec<Column>) {
        columns.clear();
        for da in 0..=self.reach.x {
            let first = if da == 0 { 0 } else { -self.reach.y };
            for db in first..=self.reach.y {
                let (a, image_a) = wrap_cell(own.x + da, self.cells.x);
                let (b, image_b) = wrap_cell(own.y + db, self.cells.y);
                columns.push(Column {
                    first_cell: self.index(IVec3::new(a, b, 0)),
                    image: IVec3::new(image_a, image_b, 0),
                    own: da == 0 && db == 0,
                });
            }
        }
    }

    /// What to add to the first particle when the second is seen in each image.
    fn shifts(&self) -> Vec<DVec3> {
        let mut table = Vec::new();
        for a in -self.images.x..=self.images.x {
            for b in -self.images.y..=self.images.y {
                for c in -self.images.z..=self.images.z {
                    table.push(self.basis * -IVec3::new(a, b, c).as_dvec3());
                }
            }
        }
        table
    }
}

/// Particles sorted along cells.
#[derive(Clone, Debug, Default)]
struct Sorting {
    cells: Vec<IVec3>,
    folded: Vec<DVec3>,
    starts: Vec<u32>,
    order: Vec<u32>,
    sorted: Vec<DVec3>,
    sorted_cells: Vec<IVec3>,
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
}

impl Sorting {
    fn sort(&mut self, grid: &Grid, positions: &[DVec3]) {
        let n = positions.len();
        self.cells.clear();
        self.folded.clear();
        self.starts.clear();
        self.starts.resize(grid.number_of_cells() + 1, 0);
        for &r in positions {
            let (cell, folded) = grid.locate(r);
            self.cells.push(cell);
            self.folded.push(folded);
            self.starts[grid.index(cell) + 1] += 1;
        }
        for c in 1..self.starts.len() {
            self.starts[c] += self.starts[c - 1];
        }
        self.order.resize(n, 0);
        self.sorted.resize(n, DVec3::ZERO);
        self.sorted_cells.resize(n, IVec3::ZERO);
        for column in [&mut self.x, &mut self.y, &mut self.z] {
            column.resize(n, 0.0);
        }
        for (place, (&cell, &r)) in self.cells.iter().zip(&self.folded).enumerate() {
            let start = &mut self.starts[grid.index(cell)];
            let k = *start as usize;
            *start += 1;
            self.order[k] = place as u32;
            self.sorted[k] = r;
            self.sorted_cells[k] = cell;
            (self.x[k], self.y[k], self.z[k]) = (r.x, r.y, r.z);
        }
        self.starts.rotate_right(1);
        self.starts[0] = 0;
    }
}

/// The search of one block of particles for their candidates; compiled once for every instruction set.
struct Search<'a> {
    grid: &'a Grid,
    sorting: &'a Sorting,
    range: Range<usize>,
    block: &'a mut Block,
}

impl pulp::NullaryFnOnce for Search<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.block.fill(self.grid, self.sorting, self.range);
    }
}

/// A column of cells along the last axis, as seen from a particle's own.
#[derive(Clone, Copy, Debug)]
struct Column {
    first_cell: usize,
    image: IVec3,
    own: bool,
}

impl Block {
    /// Finds the candidates of the particles in `range`: those of later cells in a half space of cells, so that each
    /// pair is found once.
    #[inline(always)]
    fn fill(&mut self, grid: &Grid, sorting: &Sorting, range: Range<usize>) {
        self.rows.clear();
        self.used = 0;
        let within = grid.shift_index(IVec3::ZERO);
        let mut columns = Vec::new();
        let mut across = Vec::new();
        let mut columns_of = IVec2::splat(-1);
        for i in range {
            let cell = sorting.sorted_cells[i];
            if cell.xy() != columns_of {
                columns_of = cell.xy();
                grid.half_space_of_columns(columns_of, &mut columns);
            }
            let start = self.used;
            across.clear();
            let highest = cell.z + grid.reach.z;
            for column in &columns {
                let lowest = if column.own {
                    cell.z
                } else {
                    cell.z - grid.reach.z
                };
                let mut c = lowest;
                while c <= highest {
                    let (wrapped, image_c) = wrap_cell(c, grid.cells.z);
                    let last = highest.min(c - wrapped + grid.cells.z - 1);
                    let from = sorting.starts[column.first_cell + wrapped as usize] as usize;
                    let to = sorting.starts[column.first_cell + (last - c + wrapped) as usize + 1]
                        as usize;
                    let from = if column.own && c == cell.z {
                        i + 1
                    } else {
                        from
                    };
                    let image = column.image.with_z(image_c);
                    if image == IVec3::ZERO {
                        self.gather(grid, sorting, i, DVec3::ZERO, from..to);
                    } else if from < to {
                        across.push((image, from..to));
                    }
                    c = last + 1;
                }
            }
            self.close_row(i, within, start);
            for (image, candidates) in across.drain(..) {
                let start = self.used;
                let shift = grid.basis * -image.as_dvec3();
                self.gather(grid, sorting, i, shift, candidates);
                self.close_row(i, grid.shift_index(image), start);
            }
        }
        self.js.truncate(self.used);
    }

    /// Appends the candidates in range. Every one is written; only those in range are kept.
    #[inline(always)]
    fn gather(
        &mut self,
        grid: &Grid,
        sorting: &Sorting,
        i: usize,
        shift: DVec3,
        candidates: Range<usize>,
    ) {
        const RUN: usize = 32;
        let here = sorting.sorted[i] + shift;
        let limit = grid.range * grid.range;
        let mut squares = [0.0; RUN];
        let mut from = candidates.start;
        while from < candidates.end {
            let to = candidates.end.min(from + RUN);
            let (x, y, z) = (
                &sorting.x[from..to],
                &sorting.y[from..to],
                &sorting.z[from..to],
            );
            for (((square, x), y), z) in squares.iter_mut().zip(x).zip(y).zip(z) {
                let (dx, dy, dz) = (here.x - x, here.y - y, here.z - z);
                *square = dx * dx + dy * dy + dz * dz;
            }
            if self.js.len() < self.used + RUN {
                self.js.resize(2 * self.js.len() + RUN, 0);
            }
            let room = &mut self.js[self.used..self.used + RUN];
            let mut found = 0;
            for (k, &square) in squares[..to - from].iter().enumerate() {
                room[found] = (from + k) as u32;
                found += (square < limit) as usize;
            }
            self.used += found;
            from = to;
        }
    }

    #[inline(always)]
    fn close_row(&mut self, i: usize, shift: u32, start: usize) {
        if self.used > start {
            self.rows.push(Entry {
                i: i as u32,
                shift,
                start: start as u32,
                end: self.used as u32,
            });
        }
    }
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
