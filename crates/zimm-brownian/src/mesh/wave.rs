//! The wave part of the sum: a convolution on the mesh.

use super::window::Window;
use super::{
    grid::Grid,
    spectrum::{Lines, Spectrum},
};
use crate::{White, lattice_sum::Kernel, pieces::each_piece};
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex, num_complex::Complex64};
use rustfft::{Fft, FftPlanner};
use std::sync::Arc;
use zimm_core::Lattice;

/// Lines that are transformed together, so that whole cache lines are used.
const LINES: usize = 8;
/// Pieces of the mesh that threads share, each with room of its own to work in.
const PIECES: usize = 8;

/// Plans of transforms that were needed so far.
#[derive(Clone, Default)]
struct Plans {
    forward: Vec<Arc<dyn Fft<f64>>>,
    inverse: Vec<Arc<dyn Fft<f64>>>,
    real_forward: Vec<Arc<dyn RealToComplex<f64>>>,
    real_inverse: Vec<Arc<dyn ComplexToReal<f64>>>,
}

impl Plans {
    fn complex(&mut self, n: usize) -> [Arc<dyn Fft<f64>>; 2] {
        let known = self.forward.iter().position(|fft| fft.len() == n);
        let at = known.unwrap_or_else(|| {
            let mut planner = FftPlanner::new();
            self.forward.push(planner.plan_fft_forward(n));
            self.inverse.push(planner.plan_fft_inverse(n));
            self.forward.len() - 1
        });
        [self.forward[at].clone(), self.inverse[at].clone()]
    }

    fn real(&mut self, n: usize) -> (Arc<dyn RealToComplex<f64>>, Arc<dyn ComplexToReal<f64>>) {
        let known = self.real_forward.iter().position(|fft| fft.len() == n);
        let at = known.unwrap_or_else(|| {
            let mut planner = RealFftPlanner::new();
            self.real_forward.push(planner.plan_fft_forward(n));
            self.real_inverse.push(planner.plan_fft_inverse(n));
            self.real_forward.len() - 1
        });
        (self.real_forward[at].clone(), self.real_inverse[at].clone())
    }
}

/// The modes of a mesh: plane, row, component, mode along the last basis vector.
#[derive(Clone, Default)]
pub(super) struct Waves {
    plans: Plans,
    modes: Vec<Complex64>,
    /// Those that have been worked on, row by row: row, plane, component, mode.
    sheets: Vec<Complex64>,
    rooms: Vec<Room>,
    spectrum: Spectrum,
}

/// What a piece of work writes to by the way.
#[derive(Clone, Default)]
struct Room {
    row: Vec<f64>,
    plane: Vec<Complex64>,
    lines: Vec<Complex64>,
    scratch: Vec<Complex64>,
}

impl std::fmt::Debug for Waves {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut f = f.debug_struct("Waves");
        f.field("spectrum", &self.spectrum).finish_non_exhaustive()
    }
}

impl Waves {
    /// Fixes the modes.
    pub(super) fn bind(
        &mut self,
        points: [usize; 3],
        lattice: &Lattice,
        window: &Window,
        kernel: &Kernel,
    ) {
        let zero = Complex64::default();
        self.spectrum.bind(points, lattice, window, kernel);
        let ([n1, n2, n3], width) = (points, 3 * self.spectrum.half());
        self.modes.resize(n1 * n2 * width, zero);
        self.sheets.resize(n1 * n2 * width, zero);
        let (first, second) = (self.plans.complex(n1), self.plans.complex(n2));
        let (there, back) = self.plans.real(n3);
        let complex = first.iter().chain(&second);
        let complex = complex.map(|fft| fft.get_inplace_scratch_len());
        let real = there.get_scratch_len().max(back.get_scratch_len());
        let scratch = complex.fold(real, usize::max);
        self.rooms.resize_with(PIECES, Room::default);
        for room in &mut self.rooms {
            room.row.resize(n3, 0.0);
            room.plane.resize(n2 * width, zero);
            room.lines.resize(LINES * n2.max(3 * n1), zero);
            room.scratch.resize(scratch, zero);
        }
    }

    /// Makes the mesh of forces one of velocities, for beads of a mobility of one alone.
    pub(super) fn convolve(&mut self, grid: &mut Grid, kernel: &Kernel) {
        self.forward(grid);
        self.middle(true, &|lines: Lines<'_>| lines.scale(kernel));
        self.inverse(grid);
    }

    /// Makes the mesh one of random velocities whose covariance is the wave part, for beads of a mobility of one alone.
    pub(super) fn draw(&mut self, grid: &mut Grid, kernel: &Kernel, white: &White<'_>) {
        self.middle(false, &|lines: Lines<'_>| lines.draw(kernel, white));
        self.inverse(grid);
    }

    /// From values to modes in the planes of the mesh.
    fn forward(&mut self, grid: &Grid) {
        let ([n1, n2, n3], half) = (self.spectrum.points(), self.spectrum.half());
        let (real, _) = self.plans.real(n3);
        let [along, _] = self.plans.complex(n2);
        let (size, planes) = (n2 * 3 * half, n1.div_ceil(PIECES));
        let (modes, rooms) = (&mut self.modes, &mut self.rooms);
        each_piece(modes, planes * size, rooms, |k, modes, room| {
            let values = grid.values[k * planes * grid.plane()..].chunks(grid.plane());
            for (values, modes) in values.zip(modes.chunks_mut(size)) {
                for (values, modes) in values.chunks(grid.row).zip(modes.chunks_mut(half)) {
                    let (values, beyond) = values.split_at(n3);
                    room.row.copy_from_slice(values);
                    for (value, beyond) in room.row.iter_mut().zip(beyond) {
                        *value += *beyond;
                    }
                    // Lengths fit, and that is all that could be wrong.
                    let _ = real.process_with_scratch(&mut room.row, modes, &mut room.scratch);
                }
                for first in (0..3 * half).step_by(LINES) {
                    let lines = LINES.min(3 * half - first);
                    let buffer = &mut room.lines[..lines * n2];
                    load(modes, first, 3 * half, lines, buffer);
                    along.process_with_scratch(buffer, &mut room.scratch);
                    store(buffer, modes, first, 3 * half, lines);
                }
            }
        });
    }

    /// From modes in sheets across the planes of the mesh to values.
    fn inverse(&mut self, grid: &mut Grid) {
        let ([n1, n2, n3], half) = (self.spectrum.points(), self.spectrum.half());
        let (_, real) = self.plans.real(n3);
        let [_, along] = self.plans.complex(n2);
        let (row, plane, planes) = (grid.row, grid.plane(), n1.div_ceil(PIECES));
        let (sheets, values) = (&self.sheets, &mut grid.values);
        each_piece(
            values,
            planes * plane,
            &mut self.rooms,
            |k, values, room| {
                for (values, at) in values.chunks_mut(plane).zip(k * planes..) {
                    for first in (0..3 * half).step_by(LINES) {
                        let lines = LINES.min(3 * half - first);
                        let buffer = &mut room.lines[..lines * n2];
                        load(sheets, at * 3 * half + first, n1 * 3 * half, lines, buffer);
                        along.process_with_scratch(buffer, &mut room.scratch);
                        store(buffer, &mut room.plane, first, 3 * half, lines);
                    }
                    for (values, modes) in values.chunks_mut(row).zip(room.plane.chunks_mut(half)) {
                        let (values, beyond) = values.split_at_mut(n3);
                        // What is imaginary here is rounding, or a wave too short to be kept.
                        modes[0].im = 0.0;
                        modes[half - 1].im = 0.0;
                        let _ = real.process_with_scratch(modes, values, &mut room.scratch);
                        for (beyond, value) in beyond.iter_mut().zip(values) {
                            *beyond = *value;
                        }
                    }
                }
            },
        );
    }

    /// Transforms across planes, works on the modes, and transforms back.
    fn middle(&mut self, forward: bool, work: &(dyn Fn(Lines<'_>) + Sync)) {
        let ([n1, n2, _], half) = (self.spectrum.points(), self.spectrum.half());
        let [there, back] = self.plans.complex(n1);
        let (size, count) = (n1 * 3 * half, n2.div_ceil(PIECES));
        let (modes, spectrum) = (&self.modes, &self.spectrum);
        let (sheets, rooms) = (&mut self.sheets, &mut self.rooms);
        each_piece(sheets, count * size, rooms, |k, sheets, room| {
            for (sheet, second) in sheets.chunks_mut(size).zip(k * count..) {
                for third in (0..half).step_by(LINES) {
                    let lines = LINES.min(half - third);
                    if (third..third + lines).all(|third| spectrum.is_beyond(second, third)) {
                        for row in sheet.chunks_mut(half) {
                            row[third..third + lines].fill(Complex64::default());
                        }
                        continue;
                    }
                    let buffer = &mut room.lines[..3 * lines * n1];
                    if forward {
                        for (component, buffer) in buffer.chunks_mut(lines * n1).enumerate() {
                            let first = (3 * second + component) * half + third;
                            load(modes, first, n2 * 3 * half, lines, buffer);
                        }
                        there.process_with_scratch(buffer, &mut room.scratch);
                    }
                    work(Lines {
                        spectrum,
                        second,
                        third,
                        modes: buffer,
                    });
                    back.process_with_scratch(buffer, &mut room.scratch);
                    for (component, buffer) in buffer.chunks(lines * n1).enumerate() {
                        store(buffer, sheet, component * half + third, 3 * half, lines);
                    }
                }
            }
        });
    }
}

/// Copies `lines` columns of rows that are `stride` apart, from `first` on, one after the other.
fn load(rows: &[Complex64], first: usize, stride: usize, lines: usize, columns: &mut [Complex64]) {
    let length = columns.len() / lines;
    let rows = rows[first..].chunks(stride).take(length);
    if lines == LINES {
        for (k, row) in rows.enumerate() {
            if let Some(row) = row.first_chunk::<LINES>() {
                for (line, value) in row.iter().enumerate() {
                    columns[line * length + k] = *value;
                }
            }
        }
    } else {
        for (k, row) in rows.enumerate() {
            for (line, value) in row[..lines].iter().enumerate() {
                columns[line * length + k] = *value;
            }
        }
    }
}

/// Copies columns back.
fn store(columns: &[Complex64], rows: &mut [Complex64], first: usize, stride: usize, lines: usize) {
    let length = columns.len() / lines;
    let rows = rows[first..].chunks_mut(stride).take(length);
    if lines == LINES {
        for (k, row) in rows.enumerate() {
            if let Some(row) = row.first_chunk_mut::<LINES>() {
                for (line, value) in row.iter_mut().enumerate() {
                    *value = columns[line * length + k];
                }
            }
        }
    } else {
        for (k, row) in rows.enumerate() {
            for (line, value) in row[..lines].iter_mut().enumerate() {
                *value = columns[line * length + k];
            }
        }
    }
}
