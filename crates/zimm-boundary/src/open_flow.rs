//! Unbounded space that streams.

use crate::exp::exp;
use crate::history::{FlowHistory, Steady};
use zimm_core::{Boundary, DMat3, DVec3, IVec3, ParameterError, Remap};

/// Unbounded space with a homogeneous flow: u = kappa r, kappa = rate(t) K, carried by exp(strain K).
///
/// Any shape K is allowed: shear, extension, rotation, mixtures of them, and flows that change volume. A particle far
/// from the origin streams fast, so the origin is best put where the particles are.
///
/// ```
/// use zimm_boundary::{OpenFlow, StartUp};
/// use zimm_core::{Boundary, DMat3, DVec3};
///
/// // Planar extension along x at rate 0.5, for a time of 2: stretched by e.
/// let shape = DMat3::from_diagonal(DVec3::new(1.0, -1.0, 0.0));
/// let space = OpenFlow::new(0.5 * shape)?;
/// let carried = space.carry(1.0, 3.0) * DVec3::ONE;
/// assert!((carried.x - 1_f64.exp()).abs() < 1e-15);
/// assert_eq!(carried.z, 1.0);
///
/// // The same, but at rest until a time of 2.
/// let space = OpenFlow::with_history(shape, StartUp::new(0.5, 2.0)?)?;
/// assert!((space.carry(1.0, 3.0).x_axis.x - 0.5_f64.exp()).abs() < 1e-15);
/// # Ok::<(), zimm_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenFlow<H = Steady> {
    shape: DMat3,
    history: H,
    time: f64,
}

impl OpenFlow {
    /// The steady flow of a velocity gradient kappa_ij = dv_i / dx_j, in inverse time. The x axis of the matrix is
    /// dv / dx, its y axis dv / dy; simple shear at a rate g is `DMat3::from_cols(DVec3::ZERO, g * DVec3::X,
    /// DVec3::ZERO)`.
    ///
    /// # Errors
    /// If an entry is not finite.
    pub fn new(gradient: DMat3) -> Result<Self, ParameterError> {
        Self::with_history(gradient, Steady::new(1.0)?)
    }
}

impl<H: FlowHistory> OpenFlow<H> {
    /// A flow of shape K that goes on in time as the history tells: kappa = rate(t) K.
    ///
    /// # Errors
    /// If an entry is not finite.
    pub fn with_history(shape: DMat3, history: H) -> Result<Self, ParameterError> {
        for entry in shape.to_cols_array() {
            ParameterError::finite("entry of the velocity gradient", entry)?;
        }
        Ok(Self {
            shape,
            history,
            time: 0.0,
        })
    }
}

impl<H: FlowHistory> Boundary for OpenFlow<H> {
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
        self.shape * self.history.rate(self.time)
    }

    fn carry(&self, from: f64, to: f64) -> DMat3 {
        exp(self.shape * (self.history.strain(to) - self.history.strain(from)))
    }

    fn advance(&mut self, to: f64) -> Remap {
        self.time = to;
        Remap::None
    }
}
