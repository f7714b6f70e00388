//! The square root from a factorisation: mobilities whose entries can be asked for.

use crate::{Entries, Root, White, lanczos::relative_error};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{
    LltError, LltRegularization, cholesky_in_place, cholesky_in_place_scratch,
};
use faer::{MatMut, Par};
use std::ops::Range;
use zimm_core::{Boundary, DMat3, DVec3, MobilityError, ParameterError, each_block};

/// The lower triangular root of a mobility, M = L L^T, by Cholesky's factorisation: L z.
///
/// Every run of beads that does not feel the others is factorised alone, so an ensemble of isolated chains costs N n^2
/// for chains of n beads; a full matrix of N beads takes 9 N^3 multiplications and 72 N^2 bytes. The root is that of
/// the matrix to rounding.
///
/// # Singular matrices
/// Coincident beads move alike: their mobility is exactly singular, which is legal. A pivot below the square of
/// `tolerance`, in units of the greatest entry of the diagonal, is taken for it. It follows that L L^T is M but for
/// twice as much on the diagonal, at those pivots only: the displacement of such a bead is wrong by some `tolerance` of
/// that of a bead alone. Where a pivot is as far below zero as that, M is factorised again with its
/// [`accuracy`](crate::Mobility::accuracy) on the diagonal, which makes up for eigenvalues below zero that are not
/// known from zero; if a pivot is below zero still, that is an error ([`MobilityError::NotPositive`]).
///
/// ```
/// # #[cfg(feature = "hydrodynamics")] {
/// use zimm_brownian::Cholesky;
///
/// let root = Cholesky::new(1e-6)?;
/// # let _ = root;
/// # }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Cholesky {
    tolerance: f64,
    noise: Vec<DVec3>,
    blocks: Vec<Block>,
}

/// The factor of one run.
#[derive(Clone, Debug, Default)]
struct Block {
    places: Range<usize>,
    /// L, column after column; above the diagonal is nothing of use.
    factor: Vec<f64>,
    diagonal: Vec<f64>,
    product: Vec<f64>,
    outcome: Outcome,
}

/// What became of a factorisation.
#[derive(Clone, Copy, Debug, Default)]
enum Outcome {
    #[default]
    Good,
    /// A pivot was below zero.
    Negative(f64),
    /// The pivot of this row was no number.
    NotFinite(usize),
}

impl Cholesky {
    /// The factorisation that takes pivots below the square of `tolerance` for zero.
    ///
    /// # Errors
    /// If `tolerance` is not between 1e-6, the square of which is what rounding makes of a vanishing pivot of a
    /// matrix of thousands of beads, and 1.
    pub fn new(tolerance: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            tolerance: relative_error(1e-6, tolerance)?,
            noise: Vec::new(),
            blocks: Vec::new(),
        })
    }
}

impl<B: Boundary, M: Entries<B> + Sync> Root<B, M> for Cholesky {
    fn add(
        &mut self,
        mobility: &mut M,
        white: &White<'_>,
        scale: f64,
        displacements: &mut [DVec3],
    ) -> Result<(), MobilityError> {
        let (guard, accuracy) = (self.tolerance * self.tolerance, mobility.accuracy());
        let runs = mobility.runs();
        self.blocks.resize_with(runs.len(), Block::default);
        for (block, places) in self.blocks.iter_mut().zip(runs) {
            block.places = places;
        }
        let entries = &*mobility;
        each_block(&mut self.blocks, |_, block| {
            block.read(|i, j| entries.entry(i, j));
            let least = block.least(guard);
            block.factorise(least);
            if matches!(block.outcome, Outcome::Negative(_)) && accuracy > 0.0 {
                let raised = |i, j| if i == j { accuracy } else { 0.0 };
                let raised = |i, j| DMat3::from_diagonal(DVec3::splat(raised(i, j)));
                block.read(|i, j| entries.entry(i, j) + raised(i, j));
                block.factorise(least);
            }
        });
        for block in &self.blocks {
            block.check()?;
        }
        Root::<B, M>::again(self, mobility, white, scale, displacements)
    }

    fn again(
        &mut self,
        _: &mut M,
        white: &White<'_>,
        scale: f64,
        displacements: &mut [DVec3],
    ) -> Result<(), MobilityError> {
        white.fill(&mut self.noise, displacements.len());
        let noise = &self.noise;
        each_block(&mut self.blocks, |_, block| block.multiply(noise));
        for block in &self.blocks {
            let moved = &mut displacements[block.places.clone()];
            for (displacement, x) in moved.iter_mut().zip(block.product.chunks_exact(3)) {
                *displacement += scale * DVec3::from_slice(x);
            }
        }
        Ok(())
    }
}

impl Block {
    /// Writes the lower triangle of the matrix.
    fn read(&mut self, entry: impl Fn(usize, usize) -> DMat3) {
        let (beads, order) = (self.places.len(), self.order());
        let start = self.places.start;
        self.factor.resize(order * order, 0.0);
        for j in 0..beads {
            for i in j..beads {
                let columns = entry(start + i, start + j).to_cols_array_2d();
                for (k, column) in columns.iter().enumerate() {
                    let corner = (3 * j + k) * order + 3 * i;
                    self.factor[corner..corner + 3].copy_from_slice(column);
                }
            }
        }
        self.diagonal.clear();
        let diagonal = self.factor.iter().step_by(order + 1);
        self.diagonal.extend(diagonal);
    }

    fn order(&self) -> usize {
        3 * self.places.len()
    }

    /// The least pivot that is left as it is.
    fn least(&self, guard: f64) -> f64 {
        let greatest = self.diagonal.iter().copied().fold(0.0, f64::max);
        (guard * greatest).max(f64::MIN_POSITIVE)
    }

    /// Factorises, pivots below `least` raised to it.
    fn factorise(&mut self, least: f64) {
        let order = self.order();
        let raise = LltRegularization {
            dynamic_regularization_delta: least,
            dynamic_regularization_epsilon: least,
        };
        let scratch = cholesky_in_place_scratch::<f64>(order, Par::Seq, Default::default());
        let mut memory = MemBuffer::new(scratch);
        let stack = MemStack::new(&mut memory);
        let matrix = MatMut::from_column_major_slice_mut(&mut self.factor, order, order);
        let done = cholesky_in_place(matrix, raise, Par::Seq, stack, Default::default());
        self.outcome = match done {
            Err(LltError::NonPositivePivot { index }) => Outcome::NotFinite(index),
            Ok(_) => self
                .negative_pivot(least)
                .map_or(Outcome::Good, Outcome::Negative),
        };
    }

    /// The first pivot that was too far below zero.
    fn negative_pivot(&self, least: f64) -> Option<f64> {
        let order = self.order();
        let square = |k: usize, j: usize| self.factor[j * order + k].powi(2);
        let root = least.sqrt() * (1.0 + 1e-12);
        let raised = |k: &usize| self.factor[k * order + k] <= root;
        let pivot = |k: usize| self.diagonal[k] - (0..k).map(|j| square(k, j)).sum::<f64>();
        let mut pivots = (0..order).filter(raised).map(pivot);
        pivots.find(|pivot| *pivot < -least)
    }

    fn check(&self) -> Result<(), MobilityError> {
        let quantity = "pivot";
        match self.outcome {
            Outcome::Good => Ok(()),
            Outcome::Negative(found) => Err(MobilityError::NotPositive { quantity, found }),
            Outcome::NotFinite(row) => Err(MobilityError::NotFinite {
                quantity,
                particle: self.places.start + row / 3,
                value: [self.diagonal[row]; 3],
            }),
        }
    }

    /// L z.
    fn multiply(&mut self, noise: &[DVec3]) {
        let order = self.order();
        self.product.clear();
        self.product.resize(order, 0.0);
        let components = noise[self.places.clone()].iter().flat_map(|z| z.to_array());
        for (j, z) in components.enumerate() {
            let column = &self.factor[j * order + j..(j + 1) * order];
            for (x, l) in self.product[j..].iter_mut().zip(column) {
                *x += l * z;
            }
        }
    }
}
