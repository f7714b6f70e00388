//! The Verlet list: candidate pairs from cells, kept while no pair can have been missed.

mod cells;
mod lanes;
mod search;
mod tuner;

use crate::neighbours::{cutoff_fits, not_finite};
use crate::{
    Frame, ListError, Neighbours, ParameterError, Periodic, Row, System,
    parallel::{each_block, for_each_chunk, for_each_chunk_of},
};
use cells::{Grid, Run, Sorting};
use glam::{DMat3, DVec3};
use lanes::Packing;
use search::{Around, Search};
use std::{ops::Range, sync::Mutex};
use tuner::Tuner;

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
    tuner: Option<Tuner>,
    made: Option<Made>,
    builds: u64,
    order: Vec<u32>,
    reference: Vec<DVec3>,
    positions: Vec<DVec3>,
    shifts: Vec<DVec3>,
    blocks: Vec<Block>,
    sorting: Sorting,
}

/// The thickest skin, in units of the cutoff.
const THICKEST: f64 = 2.0;

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
    runs: Vec<Run>,
    around: Vec<Around>,
    groups: usize,
}

/// A row: candidates `js[start..end]` of the block.
#[derive(Clone, Copy, Debug)]
struct Entry {
    i: u32,
    shift: u32,
    start: u32,
    end: u32,
}

/// The two largest squared displacements.
#[derive(Clone, Copy, Debug, Default)]
struct Furthest {
    squares: [f64; 2],
    is_nan: bool,
}

impl Furthest {
    /// What is not known: no list is good then.
    const NOWHERE: Self = Self {
        squares: [f64::INFINITY; 2],
        is_nan: true,
    };

    #[inline(always)]
    fn hear(&mut self, square: f64) {
        self.is_nan |= square.is_nan();
        if square > self.squares[1] {
            let [first, _] = self.squares;
            self.squares = [first.max(square), first.min(square)];
        }
    }

    fn join(&mut self, other: Self) {
        self.is_nan |= other.is_nan;
        for square in other.squares {
            self.hear(square);
        }
    }

    /// By how much two particles can at most have come nearer to each other.
    fn of_two(self) -> f64 {
        if self.is_nan {
            return f64::INFINITY;
        }
        self.squares[0].sqrt() + self.squares[1].sqrt()
    }
}

impl VerletList {
    /// A list that looks `skin` further than the cutoff, at most three times as far. A thin skin is made anew often, a
    /// thick one holds many pairs that do not interact; the result is the same for all.
    ///
    /// # Errors
    /// If `skin` is below zero.
    pub fn new(skin: f64) -> Result<Self, ParameterError> {
        let skin = ParameterError::non_negative("skin", skin)?;
        Ok(Self::with(skin, None))
    }

    /// A list that chooses its skin from how fast particles move, anew whenever it is made, so that making it and
    /// looking at its candidates together cost least. The choice depends on the trajectory alone, and is the same on any
    /// machine.
    ///
    /// ```
    /// # use zimm_core::VerletList;
    /// let list = VerletList::tuned();
    /// assert_eq!(list.builds(), 0);
    /// ```
    pub fn tuned() -> Self {
        Self::with(0.0, Some(Tuner::default()))
    }

    fn with(skin: f64, tuner: Option<Tuner>) -> Self {
        Self {
            skin,
            tuner,
            made: None,
            builds: 0,
            order: Vec::new(),
            reference: Vec::new(),
            positions: Vec::new(),
            shifts: Vec::new(),
            blocks: Vec::new(),
            sorting: Sorting::default(),
        }
    }

    /// How much further than the cutoff the list looks.
    pub fn skin(&self) -> f64 {
        self.skin
    }

    /// How often the list has been made.
    pub fn builds(&self) -> u64 {
        self.builds
    }

    /// Number of pairs in the list.
    pub fn candidates(&self) -> usize {
        self.blocks.iter().map(|block| block.used).sum()
    }

    /// How far the list looks.
    fn range(&self, cutoff: f64) -> f64 {
        cutoff + self.skin.min(THICKEST * cutoff)
    }

    /// Brings positions and shifts of an existing list to now; false if a pair may have been missed.
    fn follow<B: Periodic>(&mut self, frame: &Frame<'_, B>, cutoff: f64) -> bool {
        let Some(made) = &self.made else { return false };
        if made.cutoff != cutoff || self.order.len() != frame.len() {
            return false;
        }
        let carry = frame.boundary.carry(made.time, frame.now.time);
        let lattice = frame.boundary.lattice();
        let furthest = Mutex::new(Furthest::default());
        let (reference, order) = (&self.reference, &self.order);
        for_each_chunk(&mut self.positions, |start, chunk| {
            let mut here = Furthest::default();
            // A loop of its own, so that many of the loads, which are all over memory, are under way at once.
            for (position, &place) in chunk.iter_mut().zip(&order[start..]) {
                *position = frame.positions[place as usize];
            }
            for (position, &reference) in chunk.iter_mut().zip(&reference[start..]) {
                let carried = if B::FLOWS {
                    carry * reference
                } else {
                    reference
                };
                let moved = lattice.rounded(*position - carried);
                *position = carried + moved;
                here.hear(moved.length_squared());
            }
            if let Ok(mut furthest) = furthest.lock() {
                furthest.join(here);
            }
        });
        let furthest = furthest.into_inner().unwrap_or(Furthest::NOWHERE);
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
        if let Some(tuner) = &mut self.tuner {
            let needed = (cutoff + furthest.of_two()) / stretch - cutoff;
            tuner.hear(needed, THICKEST * cutoff);
        }
        stretch * self.range(cutoff) - furthest.of_two() >= cutoff
    }

    fn make<B: Periodic>(&mut self, frame: &Frame<'_, B>, cutoff: f64) -> Result<(), ListError> {
        let mut shifts = self.made.take().map_or_else(Vec::new, |made| made.shifts);
        if let Some(particle) = frame.positions.iter().position(|r| !r.is_finite()) {
            return Err(not_finite(particle, frame.positions[particle]));
        }
        let lattice = frame.boundary.lattice();
        if let Some(tuner) = &mut self.tuner {
            self.skin = tuner.next(cutoff, lattice, frame.len());
        }
        let grid = Grid::new(lattice, self.range(cutoff), frame.len());
        self.sorting.sort(&grid, frame.positions);
        self.order.clone_from(&self.sorting.order);
        let sorted = &self.sorting.sorted;
        for column in [&mut self.reference, &mut self.positions] {
            column.resize(sorted.len(), DVec3::ZERO);
        }
        let columns = (&mut self.reference[..], &mut self.positions[..]);
        for_each_chunk_of(columns, |start, (reference, positions)| {
            for (r, sorted) in reference.iter_mut().zip(&sorted[start..]) {
                *r = sorted.position;
            }
            positions.copy_from_slice(reference);
        });
        grid.shifts(&mut shifts);
        self.shifts.clone_from(&shifts);
        self.blocks
            .resize_with(number_of_blocks(frame.len()), Block::default);
        let (count, sorting) = (self.blocks.len(), &self.sorting);
        let packing = Packing::new();
        each_block(&mut self.blocks, |b, block| {
            let places = block_range(b, count, sorting.order.len());
            packing.run(Search {
                grid: &grid,
                sorting,
                places,
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

impl<B: Periodic> System<B> {
    /// Puts particles that are close in space close in memory: in the order of small cells. Identities stay with their
    /// particles, places change.
    ///
    /// Worth a call every hundred steps or so in a large system, whose forces and lists then find what they read in the
    /// processor's caches. Sums over particles change their order, so call it at the same steps of runs that are
    /// to agree bit for bit.
    ///
    /// ```
    /// # use zimm_core::{Boundary, Clock, DVec3, IVec3, Lattice, Particles, Periodic, System};
    /// # #[derive(Clone)]
    /// # struct Brick(Lattice);
    /// # impl Boundary for Brick {
    /// #     fn min_image(&self, dr: DVec3) -> DVec3 { self.0.nearest(dr) }
    /// #     fn wrap(&self, r: DVec3) -> (DVec3, IVec3) { self.0.fold(r) }
    /// # }
    /// # impl Periodic for Brick {
    /// #     fn lattice(&self) -> &Lattice { &self.0 }
    /// # }
    /// let space = Brick(Lattice::brick(DVec3::splat(10.0))?);
    /// let particles = Particles::new(vec![4.0 * DVec3::Z, -4.0 * DVec3::Z])?;
    /// let mut system = System::new(space, particles, Clock::new(0.01, 1.0, 1)?);
    /// system.sort();
    /// assert_eq!(system.particles.positions(), [-4.0 * DVec3::Z, 4.0 * DVec3::Z]);
    /// assert_eq!(system.particles.ids(), [1, 0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn sort(&mut self) {
        const IN_A_CELL: f64 = 4.0;
        let lattice = self.boundary.lattice();
        let number = self.particles.len().max(1) as f64;
        let width = libm::cbrt(IN_A_CELL * lattice.volume() / number);
        let mut sorting = Sorting::default();
        let grid = Grid::new(lattice, width, self.particles.len());
        sorting.sort(&grid, self.particles.positions());
        self.particles.reorder(&sorting.order);
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
        if let Some(tuner) = &mut self.tuner {
            *tuner = Tuner::default();
        }
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
