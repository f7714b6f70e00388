//! Uniaxial and biaxial extension.

use crate::history::FlowHistory;
use crate::lattice_flow::{Part, Recurrence};
use crate::{FlowError, LatticeFlow};
use std::f64::consts::PI;
use zimm_core::{DMat3, DVec3, ParameterError};

/// Uniaxial extension without end, u = rate(t) (x, -y / 2, -z / 2); with a negative rate biaxial.
///
/// No integer matrix has the eigenvalues of such a flow, two of them equal. But the flow does not care for rotations
/// about its axis, and there are matrices that stretch and turn: the lattice of the integers of the cubic field of
/// discriminant -23 is the same again after a Hencky strain of ln 1.3247 = 0.281 and a turn by 139.7 degrees, which is
/// the argument of the complex root of x^3 = x + 1. The lattice is carried by the flow alone; that it has come back
/// turned is told in closed form. Images never come closer than sqrt(3) 23^(-1/6) = 1.027 of the edge of a cube of the
/// same volume, further than in any cell of [`TriaxialFlow`](crate::TriaxialFlow).
///
/// The strain of the history is the Hencky strain along x.
///
/// ```
/// use zimm_boundary::{Steady, UniaxialExtension};
/// use zimm_core::{Boundary, DVec3, Periodic};
///
/// let mut space = UniaxialExtension::new(10.0, Steady::new(0.1)?)?;
/// space.advance(500.0);
/// assert_eq!(space.gradient() * DVec3::ONE, DVec3::new(0.1, -0.05, -0.05));
/// assert!((space.lattice().volume() / 1000.0 - 1.0).abs() < 1e-14);
/// assert!((space.min_image_distance() - 10.27).abs() < 1e-3);
/// # Ok::<(), zimm_boundary::FlowError>(())
/// ```
pub type UniaxialExtension<H> = LatticeFlow<Uniaxial, H>;

/// Uniaxial or biaxial extension: names the flow of a [`UniaxialExtension`] cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Uniaxial(());

impl<H: FlowHistory> UniaxialExtension<H> {
    /// A cell of the volume of a cube of the given edge; it stands at time zero.
    ///
    /// # Errors
    /// If the edge is not finite and above zero, or the strain at time zero is not finite.
    pub fn new(edge: f64, history: H) -> Result<Self, FlowError> {
        let edge = ParameterError::positive("edge", edge)?;
        // The real root of x^3 = x + 1. The others have the sum -root and the product 1 / root.
        let root = 1.324_717_957_244_746_f64;
        let real = -0.5 * root;
        let imaginary = (1.0 / root - real * real).sqrt();
        let (period, angle) = (libm::log(root), libm::atan2(imaginary, real));
        let shape = DMat3::from_diagonal(DVec3::new(1.0, -0.5, -0.5));
        let turning = DMat3::from_cols(DVec3::ZERO, DVec3::Z, -DVec3::Y) * (angle / period);
        // The stretch alone is no map of the lattice; with the turn it is, and to turn back is one again after a full
        // turn.
        let parts = [
            Part {
                shape: shape + turning,
                period,
            },
            Part {
                shape: -turning,
                period: 2.0 * PI * period / angle,
            },
        ];
        // 1, x and x^2, each with its real and its complex value.
        let scale = edge * libm::cbrt(2.0 / 23.0_f64.sqrt());
        let power = |x: f64, y: f64, z: f64| scale * DVec3::new(x, y, z);
        let start = DMat3::from_cols(
            power(1.0, 1.0, 0.0),
            power(root, real, imaginary),
            power(
                root * root,
                real * real - imaginary * imaginary,
                2.0 * real * imaginary,
            ),
        );
        let recurrence = Recurrence {
            shape,
            axes: DMat3::IDENTITY,
            start,
            parts,
            min_image_distance: edge * closest(),
        };
        Self::assemble(Uniaxial(()), recurrence, history)
    }

    /// The smallest box in which a cutoff fits at every strain, to 1e-12.
    ///
    /// # Errors
    /// If the cutoff is not finite and above zero, or the strain at time zero is not finite.
    pub fn box_for_cutoff(cutoff: f64, history: H) -> Result<Self, FlowError> {
        Self::new(2.0 * cutoff / closest() * (1.0 + 1e-12), history)
    }
}

/// How close images come in the cell of volume 1. With x along the axis and q the distance from it, |x| q^2 is
/// 2 / sqrt(23) times an integer for every lattice vector, and x^2 + q^2 is least when 2 x^2 = q^2.
fn closest() -> f64 {
    3.0_f64.sqrt() / libm::pow(23.0, 1.0 / 6.0)
}
