//! The square root for several steps at once: any mobility that is kept.

mod basis;
mod projection;

use crate::columns::add_scaled;
use crate::lanczos::{not_finite, relative_error};
use crate::{Mobility, Root, White, stage::zero};
use basis::Basis;
use faer::Mat;
use projection::Projection;
use zimm_core::{Boundary, DVec3, MobilityError, ParameterError};

/// The symmetric square root of any mobility for the noise of several steps at once, by Lanczos' method for blocks.
///
/// A stepper that keeps a mobility for several steps ([`SemiImplicit::keeping`](crate::SemiImplicit::keeping)) needs
/// M^(1/2) z for the white vector z of each of them, and noise is addressed, so those of later steps are known at the first.
/// From all of them together, Z = (z_1 .. z_s) = V_1 R, an orthonormal basis V of the space of Z, M Z, M^2 Z, ... is made, in
/// which M is a block tridiagonal matrix T; then M^(1/2) Z = V T^(1/2) E_1 R (Ando, Chow, Saad and Skolnick 2012, J. Chem.
/// Phys. 137, 064106). The first root is handed out, the others when their steps come. What is asked for besides, noise
/// that is drawn again or a step that was not foreseen, begins a block of its own.
///
/// # What it saves
/// Every column is found in the space that all of them span, which takes fewer products a root than [`Lanczos`](crate::Lanczos):
/// for chains of 10 beads at c/c* = 1 and an error of 1e-3, with stored pairs of [`Ewald`](crate::Ewald),
///
/// | beads | one by one | 4 columns | 8 columns | 16 columns |
/// | --- | --- | --- | --- | --- |
/// | 100 | 18 | 14 | 13 | 11 |
/// | 1000 | 38 | 28 | 24 | 20 |
/// | 3000 | 70 | 42 | 37 | 32 |
///
/// and a share as large at 1e-6. The worse the mobility is conditioned, the more it saves. Not all of it is time: a basis of
/// all columns is made orthogonal, and T decomposed. With 8 or 16 columns a root takes 1.3 or 1.5 times less time for 1000
/// beads, 1.7 or 1.9 times less for 3000, and no less for 100; a whole step of 1000 beads 1.45 times less with 16 (the
/// work-precision study, figure `kept`).
///
/// # When it does not pay
/// - Where a step does not come for which a root was taken: `columns` should be how many steps a mobility is kept for. A
///   stepper that keeps nothing gets right roots, and throws all but one of each block away.
/// - For [`Mesh`](crate::Mesh), whose [`SplitNoise`](crate::SplitNoise) takes a handful of products for a root.
/// - Where [`Cholesky`](crate::Cholesky) is affordable: its factor serves all steps.
/// - Where memory is short: the basis is as many columns as a block takes products, some hundreds.
///
/// # The error
/// Iterations end when the relative error |x - M^(1/2) z| / |M^(1/2) z| of every column is below the one asked for. As
/// [`Lanczos`](crate::Lanczos) does, it is estimated from T, not from how little the last iteration changed, and for the same
/// causes: the residuals of the shifted systems of which the root is made; eigenvalues near zero that were not met; rounding,
/// and eigenvalues below zero. Tests hold every column against dense roots, to condition numbers of 1e6 and for singular
/// matrices. Columns that depend on each other, and blocks that fill the space, are no exception.
///
/// ```
/// # #[cfg(feature = "hydrodynamics")] {
/// use zimm_brownian::{BlockLanczos, Rpy, SemiImplicit};
///
/// let root = BlockLanczos::new(1e-3, 8)?;
/// let stepper = SemiImplicit::new(Rpy::new(4.0, 0.5)?, root).keeping(8)?;
/// # let _ = stepper;
/// # }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct BlockLanczos {
    tolerance: f64,
    columns: usize,
    most: usize,
    products: usize,
    error: f64,
    basis: Basis,
    force: Vec<DVec3>,
    image: Vec<DVec3>,
    /// White vectors and their roots, step by step.
    white: Vec<Vec<DVec3>>,
    roots: Vec<Vec<DVec3>>,
}

impl BlockLanczos {
    /// Roots to a relative error |x - M^(1/2) z| / |M^(1/2) z| of `tolerance`, for so many steps at once: `columns` of
    /// them. A block takes 2000 products at most.
    ///
    /// # Errors
    /// If `tolerance` is not between 1e-12, what double precision can give, and 1, or `columns` is 0.
    pub fn new(tolerance: f64, columns: usize) -> Result<Self, ParameterError> {
        if columns == 0 {
            return Err(ParameterError::new("columns", 0.0, "at least 1"));
        }
        Ok(Self {
            tolerance: relative_error(1e-12, tolerance)?,
            columns,
            most: 2000,
            products: 0,
            error: 0.0,
            basis: Basis::default(),
            force: Vec::new(),
            image: Vec::new(),
            white: Vec::new(),
            roots: Vec::new(),
        })
    }

    /// At most so many products for a block, which is also how many columns the basis can come to hold.
    ///
    /// # Errors
    /// If that is fewer than there are columns.
    pub fn within(mut self, products: usize) -> Result<Self, ParameterError> {
        if products < self.columns {
            let allowed = "at least one for each column";
            return Err(ParameterError::new("products", products as f64, allowed));
        }
        self.most = products;
        Ok(self)
    }

    /// Products with the mobility that the last block took.
    pub fn products(&self) -> usize {
        self.products
    }

    /// The relative error of the worst root of the last block, as it was estimated.
    pub fn error(&self) -> f64 {
        self.error
    }

    /// Takes the roots of the white vectors of this step and of those that follow.
    fn prepare<B: Boundary, M: Mobility<B>>(
        &mut self,
        mobility: &mut M,
        white: &White<'_>,
        len: usize,
    ) -> Result<(), MobilityError> {
        (self.products, self.error) = (0, 0.0);
        self.roots.clear();
        self.basis.clear(len, self.columns);
        self.white.resize_with(self.columns, Vec::new);
        for (k, z) in self.white.iter_mut().enumerate() {
            white.later(k as u64).fill(z, len);
            self.basis.write(k, z);
        }
        let longest = (0..self.columns).map(|k| self.basis.length(k));
        let longest = longest.fold(0.0, f64::max);
        let noise = self.append(longest);
        let mut projection = Projection::new(noise);
        let accuracy = mobility.accuracy();
        let mut due = Due::default();
        loop {
            self.multiply(mobility, &mut projection)?;
            let beside = self.append(projection.scale());
            let is_exhausted = beside.nrows() == 0 || self.basis.columns() > self.most;
            let blocks = projection.blocks();
            if is_exhausted || blocks >= due.next {
                self.error = projection.error(&beside, accuracy);
                if self.error <= self.tolerance {
                    let weights = projection.weights();
                    self.basis.multiply(&weights, &mut self.roots);
                    return Ok(());
                }
                if is_exhausted || projection.floor() > self.tolerance {
                    return Err(self.failure(&projection, accuracy));
                }
                due.plan(blocks, self.error, self.tolerance);
            }
            projection.extend(&beside);
        }
    }

    /// The products of the mobility with the last block, of which is taken off what they have of the basis.
    fn multiply<B: Boundary, M: Mobility<B>>(
        &mut self,
        mobility: &mut M,
        projection: &mut Projection,
    ) -> Result<(), MobilityError> {
        let (before, last) = (projection.before(), projection.last());
        let width = self.basis.columns() - last;
        self.basis.expect(width);
        for k in 0..width {
            self.basis.read(last + k, &mut self.force);
            zero(&mut self.image, self.force.len());
            mobility.apply(&self.force, &mut self.image);
            self.products += 1;
            self.basis.write(k, &self.image);
            if !self.basis.length(k).is_finite() {
                return Err(not_finite(&self.image));
            }
        }
        let shares = self.basis.take_off(before, 0..width);
        let own = shares.as_ref().subrows(last - before, width);
        projection.set_diagonal(own);
        self.basis.take_off(0, 0..width);
        Ok(())
    }

    /// Makes the images a block of the basis: what they are made of in it. Those that depend on others, but for the
    /// rounding of something of size `scale`, make no column.
    fn append(&mut self, scale: f64) -> Mat<f64> {
        /// Twice is enough, but for images that are nothing but rounding.
        const TIMES: usize = 4;
        let (start, images) = (self.basis.columns(), self.basis.images());
        let least = 4.0 * f64::EPSILON * scale;
        let mut made_of = Mat::<f64>::zeros(images, images);
        for k in 0..images {
            let (mut length, mut first) = (self.basis.length(k), start);
            for _ in 0..TIMES {
                let shares = self.basis.take_off(first, k..k + 1);
                for j in start..self.basis.columns() {
                    made_of[(j - start, k)] += shares[(j - first, 0)];
                }
                let before = length;
                length = self.basis.length(k);
                if length > 0.5 * before || length <= least {
                    break;
                }
                // What was cancelled leaves rounding in all directions.
                first = 0;
            }
            if length > least && !self.basis.is_complete() {
                made_of[(self.basis.columns() - start, k)] = length;
                self.basis.push(k, length);
            }
        }
        let rows = self.basis.columns() - start;
        made_of.as_ref().subrows(0, rows).to_owned()
    }

    fn failure(&self, projection: &Projection, accuracy: f64) -> MobilityError {
        let found = projection.least();
        let iterations = projection.blocks();
        if found < -accuracy - projection.rounding() * iterations as f64 {
            let quantity = "an eigenvalue";
            return MobilityError::NotPositive { quantity, found };
        }
        MobilityError::NotConverged {
            iterations,
            reached: self.error,
            asked: self.tolerance,
        }
    }
}

/// When the error is looked at: seldom, for a decomposition costs as much as many products.
#[derive(Clone, Copy, Debug, Default)]
struct Due {
    next: usize,
    last: Option<(usize, f64)>,
}

impl Due {
    /// Goes on for what is left if the error falls as it did, but no farther than by a quarter: it falls faster with time.
    fn plan(&mut self, blocks: usize, error: f64, asked: f64) {
        let most = 1 + blocks / 4;
        let wait = self.last.map_or(1.0, |(before, was)| {
            let rate = libm::log(was / error) / (blocks - before) as f64;
            (libm::log(error / asked) / rate).round()
        });
        let wait = if wait >= 0.0 { wait as usize } else { most };
        self.next = blocks + wait.clamp(1, most);
        self.last = Some((blocks, error));
    }
}

impl<B: Boundary, M: Mobility<B>> Root<B, M> for BlockLanczos {
    fn add(
        &mut self,
        mobility: &mut M,
        white: &White<'_>,
        scale: f64,
        displacements: &mut [DVec3],
    ) -> Result<(), MobilityError> {
        self.prepare(mobility, white, displacements.len())?;
        add_scaled(displacements, scale, &self.roots[0]);
        Ok(())
    }

    fn again(
        &mut self,
        mobility: &mut M,
        white: &White<'_>,
        scale: f64,
        displacements: &mut [DVec3],
    ) -> Result<(), MobilityError> {
        white.fill(&mut self.force, displacements.len());
        let known = self.white.iter().position(|z| *z == self.force);
        match known.and_then(|k| self.roots.get(k)) {
            Some(root) => {
                add_scaled(displacements, scale, root);
                Ok(())
            }
            None => self.add(mobility, white, scale, displacements),
        }
    }
}
