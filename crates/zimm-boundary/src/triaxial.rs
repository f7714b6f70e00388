//! Extension at any three rates along any three axes.

use crate::history::FlowHistory;
use crate::lattice_flow::{Part, Recurrence};
use crate::{FlowError, LatticeFlow};
use std::f64::consts::PI;
use zimm_core::{DMat3, DVec3, Lattice, ParameterError};

/// Flow without end along any three axes: kappa = rate(t) V diag(stretch) V^-1, with the axes as the columns of V and
/// stretch of sum zero; the generalised cell of Kraynik and Reinelt (Dobson 2014; Hunt 2016).
///
/// The integers of the cubic field of the heptagon, real and totally so, form a cubic lattice that two commuting
/// matrices map onto itself, both of them stretches along the same perpendicular axes. Every stretch at constant
/// volume is a product of powers of the two, and each of them is taken modulo one. The product of the three coordinates
/// of a lattice vector is an integer over 7, so that in perpendicular axes images never come closer than
/// sqrt(3) 7^(-1/3) = 0.905 of the edge. Oblique axes, such as shear added to an extension gives, shear the lattice once
/// and bring images closer.
///
/// In planar and uniaxial flow other cells are better: [`KraynikReinelt`](crate::KraynikReinelt),
/// [`PlanarMixed`](crate::PlanarMixed), [`UniaxialExtension`](crate::UniaxialExtension).
///
/// ```
/// use zimm_boundary::{Steady, TriaxialFlow};
/// use zimm_core::{Boundary, DMat3, DVec3, Periodic};
///
/// let stretch = DVec3::new(1.0, -0.3, -0.7);
/// let mut space = TriaxialFlow::new(10.0, stretch, DMat3::IDENTITY, Steady::new(0.2)?)?;
/// space.advance(500.0);
/// assert!((space.gradient() * DVec3::ONE - 0.2 * stretch).length() < 1e-16);
/// assert!((space.lattice().volume() / 1000.0 - 1.0).abs() < 1e-14);
/// assert!((space.min_image_distance() - 9.054).abs() < 1e-3);
/// # Ok::<(), zimm_boundary::FlowError>(())
/// ```
pub type TriaxialFlow<H> = LatticeFlow<Triaxial, H>;

/// Extension along three axes: names the flow of a [`TriaxialFlow`] cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Triaxial(());

impl<H: FlowHistory> TriaxialFlow<H> {
    /// A cell of the volume of a cube of the given edge, in a flow with the rates `stretch` along `axes` when the rate
    /// of the history is 1; it stands at time zero. Axes may be of any length and either handedness.
    ///
    /// # Errors
    /// If the edge is not finite and above zero, the sum of the rates not zero to 1e-12 of them, the axes not finite or
    /// in a plane, or the strain at time zero not finite.
    pub fn new(edge: f64, stretch: DVec3, axes: DMat3, history: H) -> Result<Self, FlowError> {
        let edge = ParameterError::positive("edge", edge)?;
        let axes = unit_volume(axes)?;
        let parts = parts(stretch)?;
        let recurrence = Recurrence {
            shape: axes * (parts[0].shape + parts[1].shape) * axes.inverse(),
            axes,
            start: edge * heptagon(),
            parts,
            min_image_distance: edge * closest(axes),
        };
        Self::assemble(Triaxial(()), recurrence, history)
    }

    /// The smallest box in which a cutoff fits at every strain, to 1e-12.
    ///
    /// # Errors
    /// As [`new`](Self::new), of the cutoff instead of the edge.
    pub fn box_for_cutoff(
        cutoff: f64,
        stretch: DVec3,
        axes: DMat3,
        history: H,
    ) -> Result<Self, FlowError> {
        let edge = 2.0 * cutoff / closest(unit_volume(axes)?) * (1.0 + 1e-12);
        Self::new(edge, stretch, axes, history)
    }
}

/// The axes as columns of a matrix of determinant +-1.
fn unit_volume(axes: DMat3) -> Result<DMat3, FlowError> {
    Lattice::new(axes)?;
    let [a, b, c] = [axes.x_axis, axes.y_axis, axes.z_axis].map(DVec3::normalize);
    let axes = DMat3::from_cols(a, b, c);
    Ok(axes * (1.0 / libm::cbrt(axes.determinant().abs())))
}

/// The cubic lattice of volume 1 along whose axes both maps stretch.
fn heptagon() -> DMat3 {
    let side = |k: f64| 2.0 / 7.0_f64.sqrt() * libm::sin(k * PI / 7.0);
    let [a, b, c] = [side(1.0), side(2.0), side(3.0)];
    DMat3::from_cols(
        DVec3::new(b, c, a),
        DVec3::new(-c, a, b),
        DVec3::new(a, -b, c),
    )
}

/// A flow as multiples of the stretches of the two maps, each the logarithms of its eigenvalues.
fn parts(stretch: DVec3) -> Result<[Part; 2], FlowError> {
    let trace = stretch.x + stretch.y + stretch.z;
    let conserves_volume = trace.abs() <= 1e-12 * stretch.abs().max_element();
    if !conserves_volume {
        let stretch = stretch.to_array();
        return Err(FlowError::Compressible { stretch, trace });
    }
    let log = |k: f64| -2.0 * libm::log(2.0 * libm::cos(k * PI / 7.0));
    let (u, v) = (log(1.0), log(2.0));
    let w = -(u + v);
    let determinant = u * u - v * w;
    let first = (u * stretch.x - w * stretch.y) / determinant;
    let second = (u * stretch.y - v * stretch.x) / determinant;
    let part = |times: f64, logs: DVec3| Part {
        shape: DMat3::from_diagonal(times * logs),
        period: 1.0 / times.abs(),
    };
    Ok([
        part(first, DVec3::new(u, v, w)),
        part(second, DVec3::new(w, u, v)),
    ])
}

/// The closest that images come in the cell of volume 1: the least length among vectors whose coordinates along the
/// axes have the product +-1/7.
///
/// For each combination of signs there is one shortest vector, in the direction in which |r|^2 / 2 - sum ln |x_i| is
/// least: a convex function, and Newton's method with steps damped by their own size finds it from anywhere.
fn closest(axes: DMat3) -> f64 {
    let signs = [
        DVec3::ONE,
        DVec3::new(-1.0, 1.0, 1.0),
        DVec3::new(1.0, -1.0, 1.0),
        DVec3::new(1.0, 1.0, -1.0),
    ];
    let distance = |signs: DVec3| {
        let signed = axes * DMat3::from_diagonal(signs);
        let products = signed.transpose() * signed;
        let mut x = DVec3::ONE / products.diagonal().map(f64::sqrt);
        for _ in 0..200 {
            let slope = products * x - x.recip();
            let curvature = products + DMat3::from_diagonal((x * x).recip());
            let step = curvature.inverse() * slope;
            let size = slope.dot(step).max(0.0).sqrt();
            x -= step / (1.0 + size);
        }
        (3.0 * libm::pow(7.0 * x.element_product(), -2.0 / 3.0)).sqrt()
    };
    signs
        .into_iter()
        .map(distance)
        .fold(f64::INFINITY, f64::min)
}
