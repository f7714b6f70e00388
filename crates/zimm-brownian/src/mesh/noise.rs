//! Noise that goes with a mesh.

use super::Mesh;
use crate::{Lanczos, Mobility, Root, White};
use zimm_core::{Boundary, DVec3, Frame, MobilityError, ParameterError, Periodic};

/// The square root of a [`Mesh`], drawn in two parts: waves in Fourier space, pairs by Lanczos' method.
///
/// The mobility is a sum of two positive parts, so independent noise of the covariance of each adds up to noise of the
/// covariance of the whole (Fiore, Balboa Usabiaga, Donev and Swan, J. Chem. Phys. 146, 124116, 2017). Waves do not
/// move each other: their root is the root of a number, and their noise costs half a product. What is left to the
/// iteration are the pairs, a matrix without the long waves that make the whole one ill-conditioned. As long as beads do
/// not overlap, the number of iterations does not grow with the number of beads; where they do at random, it grows
/// slowly, as the closest two come closer. No iteration needs a transform.
///
/// Waves are drawn by their place on the mesh, pairs by the identity of beads.
///
/// ```
/// use zimm_brownian::{EulerMaruyama, Mesh, SplitNoise};
///
/// let stepper = EulerMaruyama::new(Mesh::new(4.0, 0.4, 1e-3)?, SplitNoise::new(1e-3)?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SplitNoise {
    pairs: Lanczos,
}

impl SplitNoise {
    /// The root with a relative error of `tolerance` in the iteration for the pairs; the error of the mesh comes on
    /// top.
    ///
    /// # Errors
    /// If `tolerance` is not between 1e-12, what double precision can give, and 1.
    pub fn new(tolerance: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            pairs: Lanczos::new(tolerance)?,
        })
    }

    /// Iterations of the last root, each a product with the pair part.
    pub fn iterations(&self) -> usize {
        self.pairs.iterations()
    }
}

impl<B: Periodic> Root<B, Mesh> for SplitNoise {
    fn add(
        &mut self,
        mobility: &mut Mesh,
        white: &White<'_>,
        scale: f64,
        displacements: &mut [DVec3],
    ) -> Result<(), MobilityError> {
        let scale = scale * mobility.mobility.sqrt();
        let pairs = &mut PairPart(mobility);
        Root::<B, _>::add(&mut self.pairs, pairs, white, scale, displacements)?;
        mobility.draw(white, scale, displacements);
        Ok(())
    }
}

/// The pair part alone, of beads of a mobility of one.
struct PairPart<'a>(&'a mut Mesh);

impl<B: Boundary> Mobility<B> for PairPart<'_> {
    fn bind(&mut self, _: &Frame<'_, B>) -> Result<(), MobilityError> {
        Ok(())
    }

    fn apply(&mut self, forces: &[DVec3], velocities: &mut [DVec3]) {
        self.0.near.apply(forces, velocities);
    }

    fn accuracy(&self) -> f64 {
        self.0.tolerance
    }

    fn alone(&self, _: usize) -> f64 {
        1.0
    }
}
