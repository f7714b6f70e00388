//! The search for candidates: distances in lanes of single precision, and those in range packed.

use super::{
    Block, Entry,
    cells::{Grid, Located, Run, Sorting},
    lanes::{LANES, Pack, Work},
};
use glam::{DVec3, IVec3};
use std::ops::Range;

/// The search of one block of particles, those with some places in the order of cells, for their candidates.
pub(super) struct Search<'a> {
    pub(super) grid: &'a Grid,
    pub(super) sorting: &'a Sorting,
    pub(super) places: Range<usize>,
    pub(super) block: &'a mut Block,
}

impl Work for Search<'_> {
    /// Finds the candidates of the particles: those of later cells in a half space of cells, so that each pair is found
    /// once.
    #[inline(always)]
    fn run(self, pack: impl Pack) {
        let Self {
            grid,
            sorting,
            places,
            block,
        } = self;
        let limit = grid.limit();
        block.rows.clear();
        block.used = 0;
        let mut seen_from = IVec3::splat(-1);
        for i in places {
            let Located { cell, position } = sorting.sorted[i];
            if cell != seen_from {
                seen_from = cell;
                block.look_around(grid, sorting, cell);
            }
            for (k, group) in block.around[..block.groups].iter().enumerate() {
                // The cell's own particles come first; those up to i have found i, or are i.
                let skip = if k == 0 { i + 1 - group.first() } else { 0 };
                let start = block.used;
                group.gather(
                    pack,
                    grid.rounded(position + group.shift),
                    limit,
                    skip,
                    &mut block.js,
                    &mut block.used,
                );
                if block.used > start {
                    block.rows.push(Entry {
                        i: i as u32,
                        shift: group.shift_index,
                        start: start as u32,
                        end: block.used as u32,
                    });
                }
            }
        }
    }
}

impl Block {
    /// Copies what is in reach of a cell, image by image.
    #[inline(always)]
    fn look_around(&mut self, grid: &Grid, sorting: &Sorting, cell: IVec3) {
        grid.half_space(cell, &sorting.starts, &mut self.runs);
        self.groups = 0;
        for runs in self.runs.chunk_by(|a, b| a.image == b.image) {
            if self.around.len() == self.groups {
                self.around.push(Around::default());
            }
            self.around[self.groups].copy(grid, sorting, runs);
            self.groups += 1;
        }
    }
}

/// The particles in reach of a cell that are seen in one image, with a margin of numbers that are nowhere.
#[derive(Clone, Debug, Default)]
pub(super) struct Around {
    shift_index: u32,
    shift: DVec3,
    len: usize,
    columns: [Vec<f32>; 3],
    numbers: Vec<u32>,
}

impl Around {
    /// Copies whole lanes, the last of a run with some that the next run, or the margin, is written over.
    #[inline(always)]
    fn copy(&mut self, grid: &Grid, sorting: &Sorting, runs: &[Run]) {
        let image = runs[0].image;
        self.shift_index = grid.shift_index(image);
        self.shift = grid.shift(image);
        let most = runs
            .iter()
            .map(|run| (run.to - run.from) as usize)
            .sum::<usize>()
            + 2 * LANES;
        if self.numbers.len() < most {
            self.numbers.resize(most, 0);
            for column in &mut self.columns {
                column.resize(most, 0.0);
            }
        }
        self.len = 0;
        for run in runs {
            let mut from = run.from as usize;
            let end = self.len + run.to as usize - from;
            while self.len < end {
                let [here, there] = [self.len, from].map(|start| start..start + LANES);
                for (column, all) in self.columns.iter_mut().zip(&sorting.rounded) {
                    column[here.clone()].copy_from_slice(&all[there.clone()]);
                }
                for (number, k) in self.numbers[here].iter_mut().zip(from as u32..) {
                    *number = k;
                }
                self.len += LANES;
                from += LANES;
            }
            self.len = end;
        }
        for column in &mut self.columns {
            column[self.len..self.len + LANES].fill(f32::NAN);
        }
    }

    /// The first of them in the order of cells.
    fn first(&self) -> usize {
        self.numbers[0] as usize
    }

    /// Appends those from `skip` on that are in range.
    #[inline(always)]
    fn gather(
        &self,
        pack: impl Pack,
        here: [f32; 3],
        limit: f32,
        skip: usize,
        js: &mut Vec<u32>,
        used: &mut usize,
    ) {
        if js.len() < *used + self.len + LANES {
            js.resize(2 * js.len() + self.len + LANES, 0);
        }
        let [x, y, z] = &self.columns;
        let mut next = skip;
        while next < self.len {
            let lanes = next..next + LANES;
            let (Some(x), Some(y), Some(z), Some(numbers), Some(room)) = (
                x[lanes.clone()].as_array(),
                y[lanes.clone()].as_array(),
                z[lanes.clone()].as_array(),
                self.numbers[lanes.clone()].as_array(),
                js[*used..*used + LANES].as_mut_array(),
            ) else {
                break;
            };
            *used += pack.near(here, limit, ([x, y, z], numbers), room);
            next += LANES;
        }
    }
}
