//! The Verlet list: candidate pairs from cells, kept while no pair can have been missed.

mod cells;
mod lanes;
mod search;

use crate::neighbours::{cutoff_fits, not_finite};
use crate::{Frame, ListError, Neighbours, ParameterError, Periodic, Row, parallel::each_block};
use cells::{Grid, Run, Sorting};
use glam::{DMat3, DVec3};
use lanes::Packing;
use search::{Around, Search};
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
        self.blocks.iter().map(|block| block.used).sum()
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
        self.reference.clone_from(&self.sorting.positions);
        self.positions.clone_from(&self.sorting.positions);
        let shifts = grid.shifts();
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
