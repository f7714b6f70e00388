//! Unbounded space that streams.

use crate::exp::exp;
use zimm_core::{Boundary, DMat3, DVec3, IVec3, ParameterError};

/// Unbounded space with a constant velocity gradient: u = kappa r, carried by exp(kappa t).
///
/// Any gradient is allowed: shear, extension, rotation, mixtures of them, and flows that change volume. A particle far
/// from the origin streams fast, so the origin is best put where the particles are.
///
/// ```
/// use zimm_boundary::OpenFlow;
/// use zimm_core::{Boundary, DMat3, DVec3};
///
/// // Planar extension along x at rate 0.5, for a time of 2: stretched by e.
/// let space = OpenFlow::new(DMat3::from_diagonal(DVec3::new(0.5, -0.5, 0.0)))?;
/// let carried = space.carry(1.0, 3.0) * DVec3::ONE;
/// assert!((carried.x - 1_f64.exp()).abs() < 1e-15);
/// assert_eq!(carried.z, 1.0);
/// # Ok::<(), zimm_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenFlow {
    gradient: DMat3,
}

impl OpenFlow {
    /// The flow of a velocity gradient kappa_ij = dv_i / dx_j, in inverse time. The x axis of the matrix is
    /// dv / dx, its y axis dv / dy; simple shear at a rate g is `DMat3::from_cols(DVec3::ZERO, g * DVec3::X,
    /// DVec3::ZERO)`.
    ///
    /// # Errors
    /// If an entry is not finite.
    pub fn new(gradient: DMat3) -> Result<Self, ParameterError> {
        for entry in gradient.to_cols_array() {
            ParameterError::finite("entry of the velocity gradient", entry)?;
        }
        Ok(Self { gradient })
    }
}

impl Boundary for OpenFlow {
    const FLOWS: bool = true;

    #[inline(always)]
    fn min_image(&self, dr: DVec3) -> DVec3 {
        dr
    }

    #[inline(always)]
    fn wrap(&self, r: DVec3) -> (DVec3, IVec3) {
        (r, IVec3::ZERO)
    }

    fn gradient(&self) -> DMat3 {
        self.gradient
    }

    fn carry(&self, from: f64, to: f64) -> DMat3 {
        exp(self.gradient * (to - from))
    }
}
