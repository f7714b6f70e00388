//! The laws that mobilities and their roots obey, as checks, for those of one's own (feature `laws`).
//!
//! ```
//! use zimm_brownian::{Diagonal, FreeDraining, mobility_laws as laws};
//! use zimm_core::{Clock, DVec3, Open, Particles, System};
//!
//! let particles = Particles::new(vec![DVec3::ZERO, DVec3::X, DVec3::new(0.3, 2.0, 0.0)])?;
//! let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
//! let mut mobility = FreeDraining::new(4.0)?;
//! laws::check_mobility(&mut mobility, &system, 1e-14);
//! laws::has_no_divergence(&mut mobility, &system, 1e-3, 1e-14);
//! laws::check_root(&mut Diagonal, &mut mobility, &system, 1e-12);
//! laws::noise_has_the_covariance(&mut Diagonal, &mut mobility, &system, 10_000);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A law panics where it does not hold. Forces and noise are drawn at fixed addresses, so a check comes out the same
//! every time. Matrices are made column by column: these are checks for some tens of beads.

use crate::{Entries, Mobility, Root, White};
use faer::prelude::Solve;
use faer::{Mat, Side};
use std::f64::consts::FRAC_1_SQRT_2;
use std::ops::Range;
use zimm_core::noise::{Domain, Noise};
use zimm_core::{Boundary, DMat3, DVec3, Frame, MobilityError, Now, System};

/// All laws of a mobility but those that have functions of their own, to a relative error.
///
/// # Panics
/// If one does not hold.
pub fn check_mobility<B: Boundary, M: Mobility<B>>(
    mobility: &mut M,
    system: &System<B>,
    error: f64,
) {
    is_linear_and_adds(mobility, system, error);
    is_symmetric(mobility, system, error);
    is_positive(mobility, system, error);
    is_the_same_everywhere(mobility, system, error);
}

/// All laws of a root that draws by bead, to a relative error.
///
/// # Panics
/// If one does not hold.
pub fn check_root<B: Boundary, M: Mobility<B>, R: Root<B, M>>(
    root: &mut R,
    mobility: &mut M,
    system: &System<B>,
    error: f64,
) {
    scales_and_adds(root, mobility, system, error);
    squares_to_the_mobility(root, mobility, system, error);
}

/// M (2 F - 3 G) = 2 M F - 3 M G, and products are added to what is there.
///
/// # Panics
/// If not, to a relative error.
pub fn is_linear_and_adds<B: Boundary, M: Mobility<B>>(
    mobility: &mut M,
    system: &System<B>,
    error: f64,
) {
    bind(mobility, &system.frame());
    let (f, g) = (forces(system, 1), forces(system, 2));
    let sum: Vec<DVec3> = f.iter().zip(&g).map(|(f, g)| 2.0 * *f - 3.0 * *g).collect();
    let whole = product(mobility, &sum);
    let mut parts = product(mobility, &f);
    for (part, f) in parts.iter_mut().zip(&f) {
        *part = 2.0 * *part + *f;
    }
    let minus: Vec<DVec3> = g.iter().map(|g| -3.0 * *g).collect();
    mobility.apply(&minus, &mut parts);
    for (part, f) in parts.iter_mut().zip(&f) {
        *part -= *f;
    }
    let apart = distance(&whole, &parts) / (norm(&whole) + norm(&f));
    assert!(
        apart <= error,
        "M (2 F - 3 G) is {apart:e} off 2 M F - 3 M G"
    );
}

/// F . M G = G . M F.
///
/// # Panics
/// If not, to a relative error.
pub fn is_symmetric<B: Boundary, M: Mobility<B>>(mobility: &mut M, system: &System<B>, error: f64) {
    bind(mobility, &system.frame());
    for k in 0..4 {
        let (f, g) = (forces(system, 2 * k), forces(system, 2 * k + 1));
        let (mf, mg) = (product(mobility, &f), product(mobility, &g));
        let apart = (dot(&f, &mg) - dot(&g, &mf)).abs() / (norm(&f) * norm(&mg));
        assert!(apart <= error, "F . M G is {apart:e} off G . M F");
    }
}

/// F . M F is not below zero.
///
/// # Panics
/// If it is, by more than a relative error.
pub fn is_positive<B: Boundary, M: Mobility<B>>(mobility: &mut M, system: &System<B>, error: f64) {
    bind(mobility, &system.frame());
    let matrix = matrix(mobility, system.particles.len());
    let (values, _) = eigen(&matrix);
    let (least, most) = (values[0], values[values.len() - 1]);
    assert!(
        least >= -error * most,
        "an eigenvalue is {least:e}, the greatest {most:e}"
    );
}

/// No place is special: moving all particles by the same vector changes nothing.
///
/// # Panics
/// If not, to a relative error.
pub fn is_the_same_everywhere<B: Boundary, M: Mobility<B>>(
    mobility: &mut M,
    system: &System<B>,
    error: f64,
) {
    let f = forces(system, 1);
    bind(mobility, &system.frame());
    let here = product(mobility, &f);
    let by = DVec3::new(0.3, -1.7, 2.9);
    let elsewhere = moved(system, |_| by);
    bind(mobility, &elsewhere.frame());
    let there = product(mobility, &f);
    let apart = distance(&here, &there) / norm(&here);
    assert!(apart <= error, "moved by {by}, M F is {apart:e} off");
}

/// Entries are what products are made of, and vanish between runs.
///
/// # Panics
/// If not, to a relative error.
pub fn has_its_entries<B: Boundary, M: Entries<B>>(
    mobility: &mut M,
    system: &System<B>,
    error: f64,
) {
    bind(mobility, &system.frame());
    let len = system.particles.len();
    let runs = mobility.runs();
    assert!(
        runs.iter().cloned().flatten().eq(0..len),
        "runs {runs:?} of {len} beads"
    );
    let matrix = matrix(mobility, len);
    let scale = (0..3 * len).map(|k| matrix[(k, k)]).fold(0.0, f64::max);
    for run in &runs {
        for (i, j) in (0..len).flat_map(|i| run.clone().map(move |j| (i, j))) {
            let block = DMat3::from_cols_array(&std::array::from_fn(|k| {
                matrix[(3 * i + k % 3, 3 * j + k / 3)]
            }));
            let entry = if run.contains(&i) {
                mobility.entry(i, j)
            } else {
                DMat3::ZERO
            };
            let apart = (entry - block).to_cols_array().map(f64::abs);
            let worst = apart.into_iter().fold(0.0, f64::max) / scale;
            assert!(
                worst <= error,
                "entry {i}, {j} is {worst:e} off the product: {entry}, {block}"
            );
        }
    }
}

/// The divergence vanishes: the sum over j of the derivatives of M_ij with respect to r_j. Central differences over
/// `step` either way; products are taken to be good to a relative `error`.
///
/// # Panics
/// If not, to 1e-5 of the sizes of the derivatives, and to what the error of products makes of it.
pub fn has_no_divergence<B: Boundary, M: Mobility<B>>(
    mobility: &mut M,
    system: &System<B>,
    step: f64,
    error: f64,
) {
    let len = system.particles.len();
    let (mut sum, mut scale, mut size) = (vec![DVec3::ZERO; len], 0.0, 0.0_f64);
    for (j, axis) in (0..len).flat_map(|j| DMat3::IDENTITY.to_cols_array_2d().map(|axis| (j, axis)))
    {
        let axis = DVec3::from_array(axis);
        let mut unit = vec![DVec3::ZERO; len];
        unit[j] = axis;
        let [ahead, behind] = [step, -step].map(|by| {
            let there = moved(system, |k| if k == j { by * axis } else { DVec3::ZERO });
            bind(mobility, &there.frame());
            product(mobility, &unit)
        });
        size = size.max(norm(&ahead));
        for (sum, (a, b)) in sum.iter_mut().zip(ahead.iter().zip(&behind)) {
            let derivative = (*a - *b) / (2.0 * step);
            *sum += derivative;
            scale += derivative.length();
        }
    }
    let found = norm(&sum);
    let bound = 1e-5 * scale + error * size * 3.0 * len as f64 / step;
    assert!(
        found <= bound,
        "the divergence is {found:e}, beyond {bound:e}"
    );
}

/// Displacements are added, and in proportion to the scale.
///
/// # Panics
/// If not, to a relative error.
pub fn scales_and_adds<B: Boundary, M: Mobility<B>, R: Root<B, M>>(
    root: &mut R,
    mobility: &mut M,
    system: &System<B>,
    error: f64,
) {
    bind(mobility, &system.frame());
    let frame = system.frame();
    let there = forces(system, 3);
    let now = moment(0);
    let mut draw = |scale: f64, start: &[DVec3]| {
        let mut displacements = start.to_vec();
        add(
            root,
            mobility,
            &White::new(now, &frame),
            scale,
            &mut displacements,
        );
        displacements
    };
    let once = draw(1.0, &vec![DVec3::ZERO; frame.len()]);
    let more = draw(-2.5, &there);
    let expected: Vec<DVec3> = there
        .iter()
        .zip(&once)
        .map(|(r, x)| *r - 2.5 * *x)
        .collect();
    let apart = distance(&more, &expected) / norm(&once);
    assert!(apart <= 5.0 * error, "2.5 times the noise is {apart:e} off");
}

/// B B^T = M, for roots that draw by bead, x = B z: B is found from as many noises as it has columns.
///
/// # Panics
/// If not, to a relative error of the root.
pub fn squares_to_the_mobility<B: Boundary, M: Mobility<B>, R: Root<B, M>>(
    root: &mut R,
    mobility: &mut M,
    system: &System<B>,
    error: f64,
) {
    let root = matrix_of_root(root, mobility, system);
    let matrix = matrix(mobility, system.particles.len());
    let apart = (&root * root.transpose() - &matrix).norm_l2() / matrix.norm_l2();
    // Noises are solved for, and squares are twice as far off.
    assert!(apart <= 20.0 * error, "B B^T is {apart:e} off M");
}

/// Displacements are normal numbers of covariance M. They are drawn `samples` times and brought to the eigenvectors
/// of M, in units of the roots of its eigenvalues; there
///
/// - each has zero mean and unit variance, and so have all together (chi-square),
/// - each has the normal distribution (Kolmogorov and Smirnov),
/// - no two are correlated,
/// - and there is none along eigenvectors of eigenvalue zero.
///
/// All bounds are such that a right root exceeds any of them with a probability of 1e-6. An amplitude that is wrong by
/// 4 / sqrt(3 N samples) shows: 0.3 % for 5 beads and 1e5 samples.
///
/// # Panics
/// If not.
pub fn noise_has_the_covariance<B: Boundary, M: Mobility<B>, R: Root<B, M>>(
    root: &mut R,
    mobility: &mut M,
    system: &System<B>,
    samples: u32,
) {
    const CHANCE: f64 = 1e-6;
    const ZERO: f64 = 1e-12;
    bind(mobility, &system.frame());
    let frame = system.frame();
    let (values, vectors) = eigen(&matrix(mobility, frame.len()));
    let most = values[values.len() - 1];
    let (dead, alive): (Vec<usize>, Vec<usize>) =
        (0..values.len()).partition(|k| values[*k] < ZERO * most);
    let modes = alive.len() as f64;
    let n = f64::from(samples);
    let mut drawn = vec![Vec::with_capacity(samples as usize); alive.len()];
    for sample in 0..samples {
        let white = White::new(moment(u64::from(sample)), &frame);
        let mut displacements = vec![DVec3::ZERO; frame.len()];
        add(root, mobility, &white, 1.0, &mut displacements);
        let x: Vec<f64> = displacements.iter().flat_map(|x| x.to_array()).collect();
        let share = |k: usize| (0..x.len()).map(|i| vectors[(i, k)] * x[i]).sum::<f64>();
        for (drawn, &k) in drawn.iter_mut().zip(&alive) {
            drawn.push(share(k) / values[k].sqrt());
        }
        for &k in &dead {
            let found = share(k).abs();
            assert!(
                found < 1e-3 * most.sqrt(),
                "{found:e} along an eigenvector of eigenvalue {:e}",
                values[k]
            );
        }
    }
    let squares: Vec<f64> = drawn
        .iter()
        .map(|y| y.iter().map(|y| y * y).sum())
        .collect();
    let normal = |tests: f64| (2.0 * libm::log(tests / CHANCE)).sqrt();
    let all = chi_square(squares.iter().sum(), n * modes);
    assert!(
        all.abs() < normal(1.0),
        "the sum of x . M^-1 x is off by {all} sigma"
    );
    for (y, (square, &k)) in drawn.iter().zip(squares.iter().zip(&alive)) {
        let value = values[k];
        let sigmas = chi_square(*square, n);
        assert!(
            sigmas.abs() < normal(modes),
            "eigenvalue {value:e}: the variance is off by {sigmas} sigma"
        );
        let mean = y.iter().sum::<f64>() / n.sqrt();
        assert!(
            mean.abs() < normal(modes),
            "eigenvalue {value:e}: the mean is off by {mean} sigma"
        );
        let distance = kolmogorov(y);
        let bound = (0.5 * libm::log(2.0 * modes / CHANCE)).sqrt();
        assert!(
            distance < bound,
            "eigenvalue {value:e}: not normal, {distance} beyond {bound}"
        );
    }
    for (a, first) in drawn.iter().enumerate() {
        for second in &drawn[..a] {
            let product: f64 = first.iter().zip(second).map(|(a, b)| a * b).sum();
            let sigmas = product / n.sqrt();
            let bound = normal(0.5 * modes * modes);
            assert!(
                sigmas.abs() < bound,
                "two modes are correlated by {sigmas} sigma"
            );
        }
    }
}

/// A mobility that is given by its matrix, and has nothing to do with positions: for trying roots out.
#[derive(Clone, Debug)]
pub struct Matrix {
    matrix: Mat<f64>,
}

impl Matrix {
    /// The mobility with this matrix, row after row; nothing if it is not square, of three rows a bead.
    pub fn new(rows: &[f64]) -> Option<Self> {
        let order = (1..).find(|order| order * order >= rows.len())?;
        let fits = order.is_multiple_of(3) && order * order == rows.len();
        fits.then(|| Self {
            matrix: Mat::from_fn(order, order, |i, j| rows[i * order + j]),
        })
    }

    /// A matrix with these eigenvalues and random eigenvectors, and its symmetric root; nothing if the number of
    /// eigenvalues is not three a bead.
    pub fn with_spectrum(values: &[f64], seed: u64) -> Option<(Self, Self)> {
        let order = values.len();
        let noise = Noise::new(seed, 0);
        let normal = |i: usize, j: usize| noise.site((i * order + j) as u32).normal(LAWS);
        let q = Mat::from_fn(order, order, normal).qr().compute_Q();
        let with = |power: fn(f64) -> f64| {
            let scaled = Mat::from_fn(order, order, |i, j| q[(i, j)] * power(values[j]));
            Self {
                matrix: &scaled * q.transpose(),
            }
        };
        order
            .is_multiple_of(3)
            .then(|| (with(|value| value), with(f64::sqrt)))
    }

    /// Number of beads.
    pub fn beads(&self) -> usize {
        self.matrix.nrows() / 3
    }
}

impl<B: Boundary> Mobility<B> for Matrix {
    fn bind(&mut self, _: &Frame<'_, B>) -> Result<(), MobilityError> {
        Ok(())
    }

    fn apply(&mut self, forces: &[DVec3], velocities: &mut [DVec3]) {
        let components = forces.iter().flat_map(|f| f.to_array());
        for (column, f) in self.matrix.col_iter().zip(components) {
            for (i, x) in column.iter().enumerate() {
                velocities[i / 3][i % 3] += x * f;
            }
        }
    }

    fn alone(&self, place: usize) -> f64 {
        self.matrix[(3 * place, 3 * place)]
    }
}

impl<B: Boundary> Entries<B> for Matrix {
    fn entry(&self, i: usize, j: usize) -> DMat3 {
        DMat3::from_cols_array(&std::array::from_fn(|k| {
            self.matrix[(3 * i + k % 3, 3 * j + k / 3)]
        }))
    }

    fn runs(&self) -> Vec<Range<usize>> {
        std::iter::once(0..self.beads()).collect()
    }
}

/// The matrix B of a root that draws by bead, x = B z, column after column.
///
/// # Panics
/// If the root cannot be had.
pub fn columns_of_root<B: Boundary, M: Mobility<B>, R: Root<B, M>>(
    root: &mut R,
    mobility: &mut M,
    system: &System<B>,
) -> Vec<f64> {
    let matrix = matrix_of_root(root, mobility, system);
    matrix
        .col_iter()
        .flat_map(|column| column.iter().copied().collect::<Vec<_>>())
        .collect()
}

const SEED: u64 = 271_828;
const LAWS: Domain = Domain::user(0x6c61_7773);

fn moment(step: u64) -> Now {
    Now {
        seed: SEED,
        step,
        ..Now::default()
    }
}

fn bind<B: Boundary, M: Mobility<B>>(mobility: &mut M, frame: &Frame<'_, B>) {
    let bound = mobility.bind(frame);
    assert!(bound.is_ok(), "{bound:?}");
}

fn add<B: Boundary, M: Mobility<B>, R: Root<B, M>>(
    root: &mut R,
    mobility: &mut M,
    white: &White<'_>,
    scale: f64,
    displacements: &mut [DVec3],
) {
    let added = root.add(mobility, white, scale, displacements);
    assert!(added.is_ok(), "{added:?}");
}

fn product<B: Boundary, M: Mobility<B>>(mobility: &mut M, forces: &[DVec3]) -> Vec<DVec3> {
    let mut velocities = vec![DVec3::ZERO; forces.len()];
    mobility.apply(forces, &mut velocities);
    velocities
}

fn matrix<B: Boundary, M: Mobility<B>>(mobility: &mut M, len: usize) -> Mat<f64> {
    let mut matrix = Mat::zeros(3 * len, 3 * len);
    for j in 0..3 * len {
        let mut unit = vec![DVec3::ZERO; len];
        unit[j / 3][j % 3] = 1.0;
        for (i, x) in product(mobility, &unit)
            .iter()
            .flat_map(|u| u.to_array())
            .enumerate()
        {
            matrix[(i, j)] = x;
        }
    }
    matrix
}

fn matrix_of_root<B: Boundary, M: Mobility<B>, R: Root<B, M>>(
    root: &mut R,
    mobility: &mut M,
    system: &System<B>,
) -> Mat<f64> {
    let frame = system.frame();
    bind(mobility, &frame);
    let order = 3 * frame.len();
    let (mut noises, mut found) = (Mat::zeros(order, order), Mat::zeros(order, order));
    for s in 0..order {
        let white = White::new(moment(s as u64), &frame);
        let mut displacements = vec![DVec3::ZERO; frame.len()];
        add(root, mobility, &white, 1.0, &mut displacements);
        for (place, x) in displacements.iter().enumerate() {
            for axis in 0..3 {
                noises[(s, 3 * place + axis)] = white.bead(place)[axis];
                found[(s, 3 * place + axis)] = x[axis];
            }
        }
    }
    noises.full_piv_lu().solve(&found).transpose().to_owned()
}

/// Eigenvalues in rising order, and eigenvectors.
fn eigen(matrix: &Mat<f64>) -> (Vec<f64>, Mat<f64>) {
    let found = matrix.self_adjoint_eigen(Side::Lower);
    assert!(found.is_ok(), "no eigenvalues");
    found.map_or_else(
        |_| (Vec::new(), Mat::zeros(0, 0)),
        |found| {
            (
                found.S().column_vector().iter().copied().collect(),
                found.U().to_owned(),
            )
        },
    )
}

fn forces<B: Boundary>(system: &System<B>, which: u64) -> Vec<DVec3> {
    let noise = Noise::new(SEED, which);
    (0..system.particles.len() as u32)
        .map(|k| noise.site(k).normal3(LAWS))
        .collect()
}

/// The system with every particle moved by the vector for its place.
fn moved<B: Boundary>(system: &System<B>, by: impl Fn(usize) -> DVec3) -> System<B> {
    let mut particles = system.particles.clone();
    for (place, r) in particles.columns_mut().positions.iter_mut().enumerate() {
        *r += by(place);
    }
    System::new(system.boundary.clone(), particles, system.clock)
}

/// How many standard deviations a sum of `n` squares of normal numbers is off (Wilson and Hilferty 1931).
fn chi_square(sum: f64, n: f64) -> f64 {
    let width = 2.0 / (9.0 * n);
    ((sum / n).cbrt() - (1.0 - width)) / width.sqrt()
}

/// sqrt(n) times the greatest distance between the distribution of n numbers and the normal one.
fn kolmogorov(numbers: &[f64]) -> f64 {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    let apart = sorted.iter().enumerate().map(|(k, y)| {
        let below = 0.5 * libm::erfc(-y * FRAC_1_SQRT_2);
        (below - k as f64 / n).max((k + 1) as f64 / n - below)
    });
    n.sqrt() * apart.fold(0.0, f64::max)
}

fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

fn norm(a: &[DVec3]) -> f64 {
    dot(a, a).sqrt()
}

fn distance(a: &[DVec3], b: &[DVec3]) -> f64 {
    let square = |(a, b): (&DVec3, &DVec3)| a.distance_squared(*b);
    a.iter().zip(b).map(square).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    // Quantiles of chi-square at 5e-7 from either end, which is 4.8916 sigma, for 60, 2000 and 600000 degrees of
    // freedom (tables made with 40 digits).
    #[test]
    fn reference_quantiles_of_chi_square() {
        let quantiles = [
            (60.0, 20.690_756_170_2, 129.572_888_224, 0.06),
            (2e3, 1_705.760_859_35, 2_324.800_746_29, 1e-3),
            (6e5, 594_656.755_531, 605_373.815_274, 1e-4),
        ];
        for (n, low, high, error) in quantiles {
            assert!(
                (chi_square(low, n) + 4.8916).abs() < error,
                "{n}: {}",
                chi_square(low, n)
            );
            assert!(
                (chi_square(high, n) - 4.8916).abs() < error,
                "{n}: {}",
                chi_square(high, n)
            );
        }
    }
}
