//! The square root from Krylov spaces: any mobility, any spectrum.

use crate::columns::{add_scaled, dot, norm, rescale};
use crate::{Mobility, Root, White, ritz::Ritz, stage::zero};
use zimm_core::{Boundary, DVec3, MobilityError, ParameterError, for_each_chunk};

/// The symmetric square root of any mobility, M^(1/2) z, by Lanczos' method.
///
/// From the vectors z, M z, M^2 z, ... an orthonormal basis V is made, in which M is the tridiagonal matrix T of low
/// order; then M^(1/2) z = |z| V T^(1/2) e_1 (Ando et al. 2012, J. Chem. Phys. 137, 064106). Nothing need be known of
/// the spectrum. One iteration is one product with the mobility.
///
/// # The error
/// Iterations end when the relative error |x - M^(1/2) z| / |M^(1/2) z| is below the one asked for. It is estimated
/// from T at every iteration, not from how little the last iteration changed: a spectrum with a few tiny eigenvalues
/// lets iterations stall for long, far from the root. What is added up:
///
/// - the greatest error that an eigenvalue near zero can cause which the basis has not met yet, for normal z: such an
///   eigenvalue has a weight in z that is bounded by what was met (Chebyshev, Markov and Stieltjes);
/// - the integral of the residuals of the shifted systems (M + s) y = z over s, of which the root is made, for a
///   residual that is spread over the spectrum as the last two basis vectors are, twice or three times as long;
/// - what rounding does to the smallest eigenvalues that were met; those below zero are taken for zero, which is no
///   error within the [`accuracy`](Mobility::accuracy) of the mobility.
///
/// Tests hold it against dense roots, to condition numbers of 1e6 and for singular matrices.
///
/// The basis is kept, one column an iteration, and made orthogonal against all of it: without, a condition number of
/// 1e4 takes half as many iterations more. Coincident beads, which make the mobility singular, are no exception.
///
/// ```
/// use zimm_brownian::{EulerMaruyama, FreeDraining, Lanczos};
///
/// let stepper = EulerMaruyama::new(FreeDraining::new(4.0)?, Lanczos::new(1e-3)?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Lanczos {
    tolerance: f64,
    most: usize,
    iterations: usize,
    error: f64,
    basis: Vec<Vec<DVec3>>,
    image: Vec<DVec3>,
    diagonal: Vec<f64>,
    off: Vec<f64>,
    shares: Vec<f64>,
    pub(crate) ritz: Ritz,
}

impl Lanczos {
    /// The root to a relative error of `tolerance`, in at most 1000 iterations.
    ///
    /// # Errors
    /// If `tolerance` is not between 1e-12, what double precision can give, and 1.
    pub fn new(tolerance: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            tolerance: relative_error(1e-12, tolerance)?,
            most: 1000,
            iterations: 0,
            error: 0.0,
            basis: Vec::new(),
            image: Vec::new(),
            diagonal: Vec::new(),
            off: Vec::new(),
            shares: Vec::new(),
            ritz: Ritz::default(),
        })
    }

    /// At most so many iterations, which is also how many columns the basis can come to hold.
    ///
    /// # Errors
    /// If that is none.
    pub fn within(mut self, iterations: usize) -> Result<Self, ParameterError> {
        if iterations == 0 {
            return Err(ParameterError::new("iterations", 0.0, "at least 1"));
        }
        self.most = iterations;
        Ok(self)
    }

    /// Iterations of the last root, each a product with the mobility.
    pub fn iterations(&self) -> usize {
        self.iterations
    }

    /// The relative error of the last root, as it was estimated.
    pub fn error(&self) -> f64 {
        self.error
    }

    pub(crate) fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Makes the basis from z, until the root is good enough. Its length, or nothing if M z = 0.
    fn grow<B: Boundary, M: Mobility<B>>(
        &mut self,
        mobility: &mut M,
        white: &White<'_>,
        len: usize,
    ) -> Result<f64, MobilityError> {
        (self.iterations, self.error) = (0, 0.0);
        self.diagonal.clear();
        self.off.clear();
        white.fill(self.vector(0), len);
        let length = norm(&self.basis[0]);
        if length == 0.0 {
            return Ok(0.0);
        }
        rescale(&mut self.basis[0], length.recip());
        loop {
            let beta = self.iterate(mobility)?;
            if self.iterations == 1 && self.diagonal[0] == 0.0 && beta == 0.0 {
                return Ok(0.0);
            }
            if self.is_due() {
                let accuracy = mobility.accuracy();
                let ritz = &mut self.ritz;
                self.error = ritz.error(&self.diagonal, &self.off, beta, len, accuracy);
                if self.error <= self.tolerance {
                    return Ok(length);
                }
            }
            let exhausted = self.iterations >= self.most || beta == 0.0;
            if exhausted || self.ritz.floor() > self.tolerance {
                return Err(self.failure(mobility.accuracy()));
            }
            self.off.push(beta);
            let mut next = std::mem::take(self.vector(self.iterations));
            self.image.clone_into(&mut next);
            rescale(&mut next, beta.recip());
            self.basis[self.iterations] = next;
        }
    }

    fn failure(&self, accuracy: f64) -> MobilityError {
        let found = self.ritz.least();
        if found < -accuracy - self.ritz.rounding() * self.iterations as f64 {
            let quantity = "an eigenvalue";
            return MobilityError::NotPositive { quantity, found };
        }
        MobilityError::NotConverged {
            iterations: self.iterations,
            reached: self.error,
            asked: self.tolerance,
        }
    }

    /// One product with the mobility, made orthogonal to the basis: the length of what remains.
    fn iterate<B: Boundary, M: Mobility<B>>(
        &mut self,
        mobility: &mut M,
    ) -> Result<f64, MobilityError> {
        let known = self.iterations + 1;
        let last = &self.basis[self.iterations];
        zero(&mut self.image, last.len());
        mobility.apply(last, &mut self.image);
        let alpha = dot(last, &self.image);
        add_scaled(&mut self.image, -alpha, last);
        if let (Some(beta), Some(before)) =
            (self.off.last(), self.basis[..known].iter().nth_back(1))
        {
            add_scaled(&mut self.image, -beta, before);
        }
        self.make_orthogonal(known);
        let beta = norm(&self.image);
        if !(alpha.is_finite() && beta.is_finite()) {
            return Err(not_finite(&self.image));
        }
        self.diagonal.push(alpha);
        self.iterations = known;
        // What is left of a space that the mobility maps into itself is rounding.
        let scale = self
            .off
            .iter()
            .fold(alpha.abs(), |scale, beta| scale.max(*beta));
        Ok(if beta > 4.0 * f64::EPSILON * scale {
            beta
        } else {
            0.0
        })
    }

    /// Takes off the image what it has of the basis.
    fn make_orthogonal(&mut self, known: usize) {
        let Self {
            basis,
            image,
            shares,
            ..
        } = self;
        let basis = &basis[..known];
        shares.clear();
        shares.extend(basis.iter().map(|vector| dot(vector, image)));
        for_each_chunk(image, |start, chunk| {
            for (vector, share) in basis.iter().zip(shares.iter()) {
                for (w, v) in chunk.iter_mut().zip(&vector[start..]) {
                    *w -= *share * *v;
                }
            }
        });
    }

    /// Whether the error is looked at: at every iteration first, then ever less often.
    fn is_due(&self) -> bool {
        let m = self.iterations;
        m.is_multiple_of(1 + m / 32) || m == self.most
    }

    fn vector(&mut self, k: usize) -> &mut Vec<DVec3> {
        if self.basis.len() <= k {
            self.basis.resize_with(k + 1, Vec::new);
        }
        &mut self.basis[k]
    }
}

impl<B: Boundary, M: Mobility<B>> Root<B, M> for Lanczos {
    fn add(
        &mut self,
        mobility: &mut M,
        white: &White<'_>,
        scale: f64,
        displacements: &mut [DVec3],
    ) -> Result<(), MobilityError> {
        let length = self.grow(mobility, white, displacements.len())?;
        if length > 0.0 {
            let weights = self.ritz.weights(&self.diagonal, &self.off);
            let basis = &self.basis;
            for_each_chunk(displacements, |start, chunk| {
                for (weight, vector) in weights.iter().zip(basis) {
                    let factor = scale * length * weight;
                    for (displacement, v) in chunk.iter_mut().zip(&vector[start..]) {
                        *displacement += factor * *v;
                    }
                }
            });
        }
        Ok(())
    }
}

/// A relative error that can be asked for.
pub(crate) fn relative_error(least: f64, value: f64) -> Result<f64, ParameterError> {
    if value >= least && value < 1.0 {
        Ok(value)
    } else {
        let allowed = "below 1, and not below what double precision can give";
        Err(ParameterError::new("relative error", value, allowed))
    }
}

/// The first entry of a column that is not finite.
pub(crate) fn not_finite(column: &[DVec3]) -> MobilityError {
    let particle = column.iter().position(|v| !v.is_finite()).unwrap_or(0);
    MobilityError::NotFinite {
        quantity: "velocity",
        particle,
        value: column.get(particle).copied().unwrap_or_default().to_array(),
    }
}
