//! The wave part of the sum: a convolution on the mesh.

use super::{
    grid::Grid,
    spectrum::{Lines, Spectrum},
};
use crate::{White, lattice_sum::Kernel};
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex, num_complex::Complex64};
use rustfft::{Fft, FftPlanner};
use std::sync::Arc;
use zimm_core::each_block;

/// Lines that are transformed together, so that whole cache lines are used.
const LINES: usize = 8;

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
    spectrum: Spectrum,
}

impl std::fmt::Debug for Waves {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut f = f.debug_struct("Waves");
        f.field("spectrum", &self.spectrum).finish_non_exhaustive()
    }
}

impl Waves {
    /// Fixes the modes.
    pub(super) fn bind(&mut self, spectrum: Spectrum) {
        let [n1, n2, _] = spectrum.points();
        let modes = n1 * n2 * 3 * spectrum.half();
        self.modes.resize(modes, Complex64::default());
        self.spectrum = spectrum;
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
    fn forward(&mut self, grid: &mut Grid) {
        let ([_, n2, n3], half) = (self.spectrum.points(), self.spectrum.half());
        let (real, _) = self.plans.real(n3);
        let [along, _] = self.plans.complex(n2);
        let (row, plane) = (grid.row, grid.plane());
        let values = grid.values.chunks_mut(plane);
        let mut planes: Vec<_> = values.zip(self.modes.chunks_mut(n2 * 3 * half)).collect();
        each_block(&mut planes, |_, (values, modes)| {
            let mut scratch = real.make_scratch_vec();
            for (values, modes) in values.chunks_mut(row).zip(modes.chunks_mut(half)) {
                let (values, beyond) = values.split_at_mut(n3);
                for (value, beyond) in values.iter_mut().zip(beyond) {
                    *value += *beyond;
                }
                // Lengths fit, and that is all that could be wrong.
                let _ = real.process_with_scratch(values, modes, &mut scratch);
            }
            let mut rows: Vec<&mut [Complex64]> = modes.chunks_mut(3 * half).collect();
            transform_columns(&mut rows, along.as_ref());
        });
    }

    /// From modes in the planes of the mesh to values.
    fn inverse(&mut self, grid: &mut Grid) {
        let ([_, n2, n3], half) = (self.spectrum.points(), self.spectrum.half());
        let (_, real) = self.plans.real(n3);
        let [_, along] = self.plans.complex(n2);
        let (row, plane) = (grid.row, grid.plane());
        let values = grid.values.chunks_mut(plane);
        let mut planes: Vec<_> = values.zip(self.modes.chunks_mut(n2 * 3 * half)).collect();
        each_block(&mut planes, |_, (values, modes)| {
            let mut rows: Vec<&mut [Complex64]> = modes.chunks_mut(3 * half).collect();
            transform_columns(&mut rows, along.as_ref());
            let mut scratch = real.make_scratch_vec();
            for (values, modes) in values.chunks_mut(row).zip(modes.chunks_mut(half)) {
                let (values, beyond) = values.split_at_mut(n3);
                // What is imaginary here is rounding, or a wave too short to be kept.
                modes[0].im = 0.0;
                modes[half - 1].im = 0.0;
                let _ = real.process_with_scratch(modes, values, &mut scratch);
                for (beyond, value) in beyond.iter_mut().zip(values) {
                    *beyond = *value;
                }
            }
        });
    }

    /// Transforms across planes, works on the modes, and transforms back.
    fn middle(&mut self, forward: bool, work: &(dyn Fn(Lines<'_>) + Sync)) {
        let ([n1, n2, _], half) = (self.spectrum.points(), self.spectrum.half());
        let [there, back] = self.plans.complex(n1);
        let spectrum = &self.spectrum;
        let mut sheets: Vec<Vec<&mut [Complex64]>> = Vec::new();
        sheets.resize_with(n2, || Vec::with_capacity(n1));
        for plane in self.modes.chunks_mut(n2 * 3 * half) {
            for (sheet, row) in sheets.iter_mut().zip(plane.chunks_mut(3 * half)) {
                sheet.push(row);
            }
        }
        each_block(&mut sheets, |second, rows| {
            let zero = Complex64::default();
            let mut buffer = vec![zero; 3 * LINES * n1];
            let most = [&there, &back].map(|fft| fft.get_inplace_scratch_len());
            let mut scratch = vec![zero; most[0].max(most[1])];
            for third in (0..half).step_by(LINES) {
                let lines = LINES.min(half - third);
                let buffer = &mut buffer[..3 * lines * n1];
                if (third..third + lines).all(|third| spectrum.is_beyond(second, third)) {
                    for row in rows.iter_mut() {
                        for component in row.chunks_mut(half) {
                            component[third..third + lines].fill(zero);
                        }
                    }
                    continue;
                }
                if forward {
                    for (component, buffer) in buffer.chunks_mut(lines * n1).enumerate() {
                        load(rows, component * half + third, buffer);
                    }
                    there.process_with_scratch(buffer, &mut scratch);
                }
                work(Lines {
                    spectrum,
                    second,
                    third,
                    modes: buffer,
                });
                back.process_with_scratch(buffer, &mut scratch);
                for (component, buffer) in buffer.chunks(lines * n1).enumerate() {
                    store(buffer, rows, component * half + third);
                }
            }
        });
    }
}

/// Transforms every column of some rows.
fn transform_columns(rows: &mut [&mut [Complex64]], fft: &dyn Fft<f64>) {
    let zero = Complex64::default();
    let columns = rows.first().map_or(0, |row| row.len());
    let mut buffer = vec![zero; LINES * rows.len()];
    let mut scratch = vec![zero; fft.get_inplace_scratch_len()];
    for first in (0..columns).step_by(LINES) {
        let buffer = &mut buffer[..LINES.min(columns - first) * rows.len()];
        load(rows, first, buffer);
        fft.process_with_scratch(buffer, &mut scratch);
        store(buffer, rows, first);
    }
}

/// Copies as many columns as the buffer holds, from `first` on, one after the other.
fn load(rows: &[&mut [Complex64]], first: usize, buffer: &mut [Complex64]) {
    let lines = buffer.len() / rows.len();
    for (k, row) in rows.iter().enumerate() {
        for (line, &value) in row[first..first + lines].iter().enumerate() {
            buffer[line * rows.len() + k] = value;
        }
    }
}

/// Copies columns back.
fn store(buffer: &[Complex64], rows: &mut [&mut [Complex64]], first: usize) {
    let (length, lines) = (rows.len(), buffer.len() / rows.len());
    for (k, row) in rows.iter_mut().enumerate() {
        for (line, value) in row[first..first + lines].iter_mut().enumerate() {
            *value = buffer[line * length + k];
        }
    }
}
