//! The mobility in a block Krylov space, its square root there, and how far that is from the root of the whole.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par, diag::Diag};

/// The symmetric block tridiagonal matrix T that the mobility is in its Krylov space, and what follows from it.
#[derive(Debug)]
pub(super) struct Projection {
    /// Where blocks begin, the next one included.
    starts: Vec<usize>,
    /// Entries on the diagonal and below.
    entries: Vec<(usize, usize, f64)>,
    /// The greatest of them.
    scale: f64,
    /// The white vectors in the first block.
    noise: Mat<f64>,
    values: Vec<f64>,
    /// The share of each eigenvector in each white vector.
    shares: Mat<f64>,
    vectors: Mat<f64>,
    floor: f64,
}

impl Projection {
    /// Begins with white vectors `noise` in a block of as many columns as that has rows.
    pub(super) fn new(noise: Mat<f64>) -> Self {
        Self {
            starts: vec![0, noise.nrows()],
            entries: Vec::new(),
            scale: 0.0,
            noise,
            values: Vec::new(),
            shares: Mat::new(),
            vectors: Mat::new(),
            floor: 0.0,
        }
    }

    /// Number of blocks.
    pub(super) fn blocks(&self) -> usize {
        self.starts.len() - 1
    }

    /// Where the block before the last one begins.
    pub(super) fn before(&self) -> usize {
        self.starts[self.starts.len().saturating_sub(3)]
    }

    /// Where the last block begins.
    pub(super) fn last(&self) -> usize {
        self.starts[self.starts.len() - 2]
    }

    /// The size of T.
    pub(super) fn scale(&self) -> f64 {
        self.scale
    }

    /// The last block on the diagonal.
    pub(super) fn set_diagonal(&mut self, block: MatRef<'_, f64>) {
        let last = self.last();
        for i in 0..block.nrows() {
            for j in 0..=i {
                let entry = 0.5 * (block[(i, j)] + block[(j, i)]);
                self.scale = self.scale.max(entry.abs());
                self.entries.push((last + i, last + j, entry));
            }
        }
    }

    /// The block below the last one, which makes another last one.
    pub(super) fn extend(&mut self, beside: &Mat<f64>) {
        let last = self.last();
        let next = last + beside.ncols();
        for i in 0..beside.nrows() {
            for j in 0..beside.ncols() {
                let entry = beside[(i, j)];
                self.scale = self.scale.max(entry.abs());
                self.entries.push((next + i, last + j, entry));
            }
        }
        self.starts.push(next + beside.nrows());
    }

    /// Decomposes T, below which `beside` comes next. Returns the greatest relative error of V T^(1/2) E_1 R that is to be
    /// expected for normal white vectors. Eigenvalues no farther than `accuracy` below zero are zero.
    ///
    /// With `M^(1/2) = 1/pi int (1 - s / (M + s)) s^(-1/2) ds` the error is D(M) V' exactly, where V' is the next block of
    /// the basis, B what is beside the last one, t_l the eigenvalues of T, and
    ///
    /// ```text
    /// D(t) = sum_l B last_l (first_l . R) / (sqrt(t) + sqrt(t_l))
    /// ```
    ///
    /// with first_l and last_l the components of an eigenvector in the first and in the last block. V' is taken to be spread
    /// over the spectrum as the two blocks before it are, alike in all directions, with some to spare; the least eigenvalue
    /// may be lower by its residual. To this comes what an eigenvalue near zero that was not met can cause.
    pub(super) fn error(&mut self, beside: &Mat<f64>, accuracy: f64) -> f64 {
        self.try_error(beside, accuracy).unwrap_or(f64::INFINITY)
    }

    fn try_error(&mut self, beside: &Mat<f64>, accuracy: f64) -> Option<f64> {
        self.decompose()?;
        let mut squares = vec![0.0; self.noise.ncols()];
        if beside.nrows() > 0 {
            let width = self.values.len() - self.last();
            let ends = self.vectors.as_ref().subrows(self.last(), width);
            let rounding = self.rounding();
            let missing = Missing {
                residuals: product(beside.as_ref(), ends),
                values: self
                    .values
                    .iter()
                    .map(|value| value.max(rounding))
                    .collect(),
                shares: &self.shares,
            };
            missing.add_met(&self.spread(width), &mut squares);
            missing.add_unmet(&mut squares)?;
        }
        Some(self.worst(&squares, accuracy))
    }

    /// How much of a column of the next block each eigenvalue stands for.
    fn spread(&self, width: usize) -> Vec<f64> {
        const SPREAD: f64 = 6.0;
        // A single direction may be worse than their mean.
        let factor = SPREAD * (width + 1) as f64 / (width * width) as f64;
        let ends = self
            .vectors
            .as_ref()
            .subrows(self.before(), self.values.len() - self.before());
        ends.col_iter()
            .map(|end| factor * end.squared_norm_l2())
            .collect()
    }

    /// The part of the error that no iteration mends: rounding, and eigenvalues that are truly below zero.
    pub(super) fn floor(&self) -> f64 {
        self.floor
    }

    /// The least eigenvalue met.
    pub(super) fn least(&self) -> f64 {
        self.values.first().copied().unwrap_or(0.0)
    }

    /// How far from zero rounding may bring an eigenvalue.
    pub(super) fn rounding(&self) -> f64 {
        const UNITS: f64 = 8.0;
        let most = self.values.last().copied().unwrap_or(0.0);
        UNITS * f64::EPSILON * most.max(0.0)
    }

    /// T^(1/2) E_1 R.
    pub(super) fn weights(&self) -> Mat<f64> {
        let root = |l: usize| self.values[l].max(0.0).sqrt();
        let (rows, columns) = (self.shares.nrows(), self.shares.ncols());
        let scaled = Mat::from_fn(rows, columns, |l, c| root(l) * self.shares[(l, c)]);
        product(self.vectors.as_ref(), scaled.as_ref())
    }

    fn decompose(&mut self) -> Option<()> {
        let order = self.starts[self.starts.len() - 1];
        let mut matrix = Mat::zeros(order, order);
        for &(i, j, entry) in &self.entries {
            matrix[(i, j)] = entry;
        }
        (self.values, self.vectors) = eigen(&matrix)?;
        let first = self.vectors.as_ref().subrows(0, self.noise.nrows());
        self.shares = product(first.transpose(), self.noise.as_ref());
        Some(())
    }

    /// The greatest relative error of all columns, from the squares of what is missing of each.
    fn worst(&mut self, squares: &[f64], accuracy: f64) -> f64 {
        let rounding = self.rounding();
        let moved = |value: f64| {
            let positive = value.max(0.0);
            let below = (positive - value - accuracy).max(0.0);
            (positive + below + rounding).sqrt() - positive.sqrt()
        };
        let (mut worst, mut floor) = (0.0_f64, 0.0_f64);
        for (square, shares) in squares.iter().zip(self.shares.col_iter()) {
            let (mut size, mut off) = (0.0, 0.0);
            for (share, &value) in shares.iter().zip(&self.values) {
                size += share * share * value;
                off += (share * moved(value)).powi(2);
            }
            let size = size.max(0.0);
            let relative = |square: f64| match (square / size).sqrt() {
                _ if square == 0.0 => 0.0,
                relative if relative.is_nan() => f64::INFINITY,
                relative => relative,
            };
            floor = floor.max(relative(off));
            worst = worst.max(relative(*square) + relative(off));
        }
        self.floor = floor;
        worst
    }
}

/// What is missing of the roots, in the next block of the basis.
struct Missing<'a> {
    /// B last_l, eigenvector by eigenvector.
    residuals: Mat<f64>,
    /// Eigenvalues in rising order, none below rounding.
    values: Vec<f64>,
    /// first_l . R.
    shares: &'a Mat<f64>,
}

impl Missing<'_> {
    /// B last_l `factor(t_l)`, eigenvector by eigenvector.
    fn scaled(&self, factor: impl Fn(f64) -> f64) -> Mat<f64> {
        let (rows, columns) = (self.residuals.nrows(), self.residuals.ncols());
        let scaled = |i, l| self.residuals[(i, l)] * factor(self.values[l]);
        Mat::from_fn(rows, columns, scaled)
    }

    /// D(t), a column for each white vector.
    fn defect(&self, t: f64) -> Mat<f64> {
        let scaled = self.scaled(|value| (t.sqrt() + value.sqrt()).recip());
        product(scaled.as_ref(), self.shares.as_ref())
    }

    /// Adds the squares of the errors that come of the spectrum that was met.
    fn add_met(&self, spread: &[f64], squares: &mut [f64]) {
        /// How far apart eigenvalues are that count as one, the least of them.
        const RATIO: f64 = 1.25;
        let residual = self.residuals.col(0).norm_l2();
        let mut first = 0;
        while first < self.values.len() {
            let least = self.values[first];
            let count = self.values[first..].partition_point(|value| *value <= RATIO * least);
            let end = first + count.max(1);
            let t = if first == 0 { least - residual } else { least };
            let weight: f64 = spread[first..end].iter().sum();
            let defect = self.defect(t.max(0.0));
            for (square, column) in squares.iter_mut().zip(defect.col_iter()) {
                *square += weight * column.squared_norm_l2();
            }
            first = end;
        }
    }

    /// Adds the squares of the errors to be expected from an eigenvalue at zero that was not met.
    ///
    /// Its eigenvector has components b in the next block and, since M V = V T + V' B, components -X^T b in those before,
    /// with X = B last T^-1; all of them together are no longer than 1, so b . (1 + X X^T) b <= 1. What it has of the white
    /// vectors, -b . S with S = X first R, are normal numbers: to be small in a direction is as probable as the singular
    /// value of S there is below 1, with some to spare. It causes the errors b . D(0).
    fn add_unmet(&self, squares: &mut [f64]) -> Option<()> {
        const SPARE: f64 = 6.0;
        let before = self.scaled(f64::recip);
        let (extents, axes) = eigen(&product(before.as_ref(), before.transpose()))?;
        let within = |columns: Mat<f64>| {
            let mut turned = product(axes.transpose(), columns.as_ref());
            for column in turned.col_iter_mut() {
                for (x, extent) in column.iter_mut().zip(&extents) {
                    *x /= (1.0 + extent.max(0.0)).sqrt();
                }
            }
            turned
        };
        let share = within(product(before.as_ref(), self.shares.as_ref()));
        let (values, directions) = eigen(&product(share.as_ref(), share.transpose()))?;
        let defect = product(directions.transpose(), within(self.defect(0.0)).as_ref());
        let chance = |value: &f64| (SPARE * value.max(0.0)).sqrt().min(1.0);
        for (square, column) in squares.iter_mut().zip(defect.col_iter()) {
            let parts = column.iter().zip(&values);
            *square += parts.map(|(x, value)| chance(value) * x * x).sum::<f64>();
        }
        Some(())
    }
}

fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let mut product = Mat::zeros(a.nrows(), b.ncols());
    matmul(&mut product, Accum::Replace, a, b, 1.0, Par::Seq);
    product
}

/// Eigenvalues in rising order and eigenvectors of a symmetric matrix, of which the lower triangle is read.
fn eigen(matrix: &Mat<f64>) -> Option<(Vec<f64>, Mat<f64>)> {
    if !matrix.is_all_finite() {
        return None;
    }
    let order = matrix.nrows();
    if order == 0 {
        return Some((Vec::new(), Mat::new()));
    }
    let (mut values, mut vectors) = (Diag::zeros(order), Mat::zeros(order, order));
    let scratch = self_adjoint_evd_scratch::<f64>(
        order,
        ComputeEigenvectors::Yes,
        Par::Seq,
        Default::default(),
    );
    let mut memory = MemBuffer::new(scratch);
    let stack = MemStack::new(&mut memory);
    self_adjoint_evd(
        matrix.as_ref(),
        values.as_mut(),
        Some(vectors.as_mut()),
        Par::Seq,
        stack,
        Default::default(),
    )
    .ok()?;
    Some((values.column_vector().iter().copied().collect(), vectors))
}
