//! Planar mixed flow.

use crate::history::{FlowHistory, Steady};
use crate::lattice_flow::{Part, Recurrence};
use crate::{FlowError, LatticeFlow, MixedRates, PlanarMap};
use zimm_core::{DMat3, DVec3, ParameterError};

/// Planar mixed flow without end: shear and planar extension at once, after Hunt, Bernardi and Todd (2010).
///
/// ```text
///                  | sqrt(chi)   1 - chi    0 |
/// kappa = Gamma(t) |     0      -sqrt(chi)  0 |
///                  |     0          0       0 |
/// ```
///
/// The mixedness chi tells the kind of the flow, from 0, shear, to 1, planar extension; the rate of the history is the
/// strain rate Gamma of Fuller and Leal (1981), [`MixedRates`] converts. The strain of the history is the integral of
/// Gamma, sqrt(chi) of it Hencky strain.
///
/// The axes of the flow are oblique, so the lattice is that of an extension, sheared once. At chi = 1 it is the cell of
/// [`KraynikReinelt`](crate::KraynikReinelt). Images come the closer the more shear dominates, D^2 is at most
/// 2 sqrt(chi / (1 + 4 chi)) of the area of the cell: there is no way from here to the cell of
/// [`LeesEdwards`](crate::LeesEdwards), whose rows of images along the flow no extension, however slow, gives back. Below
/// a mixedness of 1e-5, where the box would have to be more than 12 times as wide as images are to be apart, the
/// constructors refuse. The cell is exact to 1e-12 down to a mixedness of 1e-3 and to 1e-8 at 1e-5, where its period is
/// long.
///
/// ```
/// use zimm_boundary::{MixedRates, PlanarMap, PlanarMixed, Steady};
/// use zimm_core::Boundary;
///
/// let rates = MixedRates { shear_rate: 1.0, extension_rate: 1.0 };
/// let space = PlanarMixed::from_rates(10.0, 10.0, rates)?;
/// assert!((space.mixedness() - 0.381966).abs() < 1e-6);
/// assert!((space.gradient().y_axis.x - 1.0).abs() < 1e-15);
/// // The lattice of Hunt's cell, k = 3, would let images come closer.
/// let classic = PlanarMixed::with_map(PlanarMap::CLASSIC, 10.0, 10.0, space.mixedness(), Steady::new(1.0)?)?;
/// assert!((classic.min_image_distance() - 7.435).abs() < 1e-3);
/// assert!((space.min_image_distance() - 8.507).abs() < 1e-3);
/// # Ok::<(), zimm_boundary::FlowError>(())
/// ```
pub type PlanarMixed<H> = LatticeFlow<MixedFlow, H>;

/// Planar mixed flow: names the flow of a [`PlanarMixed`] cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MixedFlow {
    mixedness: f64,
    map: PlanarMap,
}

/// Below this the flow is shear for all that a box can tell.
const LEAST_MIXEDNESS: f64 = 1e-5;

impl<H: FlowHistory> PlanarMixed<H> {
    /// The cell that keeps images furthest apart, see [`PlanarMap::best`]. `edge` is the square root of its area in the
    /// plane of the flow, `neutral_edge` the edge along z. It stands at time zero.
    ///
    /// # Errors
    /// If the mixedness is not between 1e-5 and 1 (below zero flow is elliptic), an edge not finite and above zero, or
    /// the strain at time zero not finite.
    pub fn new(
        edge: f64,
        neutral_edge: f64,
        mixedness: f64,
        history: H,
    ) -> Result<Self, FlowError> {
        let map = PlanarMap::best(check(mixedness)?);
        Self::with_map(map, edge, neutral_edge, mixedness, history)
    }

    /// A cell that returns by a map of one's choice. With [`PlanarMap::CLASSIC`] it is that of Hunt et al., as it is after
    /// a Hencky strain of ln((1 + chi) / (2 sqrt(chi))) / 2.
    ///
    /// # Errors
    /// As [`new`](Self::new), and if the period of the map is so long that the cell gets flat to 1e-10 on the way.
    pub fn with_map(
        map: PlanarMap,
        edge: f64,
        neutral_edge: f64,
        mixedness: f64,
        history: H,
    ) -> Result<Self, FlowError> {
        let flow = MixedFlow {
            mixedness: check(mixedness)?,
            map,
        };
        planar(flow, map, mixedness, [edge, neutral_edge], history)
    }

    /// The smallest box in which a cutoff fits at every strain, to 1e-12: of the lattices that [`new`](Self::new) tries.
    ///
    /// # Errors
    /// If the mixedness is not between 1e-5 and 1, the cutoff not finite and above zero, or the strain at time zero not
    /// finite.
    pub fn box_for_cutoff(cutoff: f64, mixedness: f64, history: H) -> Result<Self, FlowError> {
        let map = PlanarMap::best(check(mixedness)?);
        let [edge, neutral_edge] = map.edges_for_cutoff(cutoff, mixedness);
        Self::with_map(map, edge, neutral_edge, mixedness, history)
    }

    /// The mixedness chi.
    pub fn mixedness(&self) -> f64 {
        self.flow.mixedness
    }

    /// How the lattice returns.
    pub fn map(&self) -> PlanarMap {
        self.flow.map
    }
}

impl PlanarMixed<Steady> {
    /// Steady flow of a shear rate and an extension rate, u = (extension_rate x + shear_rate y, -extension_rate y, 0).
    /// Either may be negative.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_rates(edge: f64, neutral_edge: f64, rates: MixedRates) -> Result<Self, FlowError> {
        let history = Steady::new(rates.strain_rate().copysign(rates.extension_rate))?;
        let upright = (rates.shear_rate * rates.extension_rate.signum()).signum();
        Self::new(edge, neutral_edge, rates.mixedness(), history)?
            .oriented(DMat3::from_diagonal(DVec3::new(1.0, upright, 1.0)))
    }
}

fn check(mixedness: f64) -> Result<f64, FlowError> {
    if mixedness < 0.0 {
        return Err(FlowError::Elliptic { mixedness });
    }
    let allowed = "from 0, shear, to 1, planar extension";
    if !(0.0..=1.0).contains(&mixedness) {
        return Err(ParameterError::new("mixedness", mixedness, allowed).into());
    }
    if mixedness < LEAST_MIXEDNESS {
        return Err(FlowError::NearlyShear {
            mixedness,
            least: LEAST_MIXEDNESS,
            closest: PlanarMap::best(mixedness).min_image_distance(mixedness),
        });
    }
    Ok(mixedness)
}

/// A planar flow in the cell of a map. In the basis of its axes, (1, 0) and (-s, 1) with s = shear rate / 2 extension
/// rate, every planar flow is an extension; the cell is that of the extension, at the time when the basis that belongs to
/// the map is shortest.
pub(crate) fn planar<F: Clone, H: FlowHistory>(
    flow: F,
    map: PlanarMap,
    mixedness: f64,
    [edge, neutral_edge]: [f64; 2],
    history: H,
) -> Result<LatticeFlow<F, H>, FlowError> {
    let edge = ParameterError::positive("edge in the plane", edge)?;
    let neutral_edge = ParameterError::positive("neutral edge", neutral_edge)?;
    let root = mixedness.sqrt();
    let extension = DMat3::from_diagonal(DVec3::new(root, -root, 0.0));
    let mut shape = extension;
    shape.y_axis.x = 1.0 - mixedness;
    let mut axes = DMat3::IDENTITY;
    axes.y_axis.x = -0.5 * (1.0 - mixedness) / root;
    let stretch = (0.5 * (1.0 + mixedness) / root).sqrt();
    let round = DMat3::from_diagonal(DVec3::new(edge * stretch, edge / stretch, neutral_edge));
    let part = Part {
        shape: extension,
        period: map.hencky_period() / root,
    };
    let recurrence = Recurrence {
        shape,
        axes,
        start: round * map.basis(),
        parts: [part, Part::NONE],
        min_image_distance: (edge * map.min_image_distance(mixedness)).min(neutral_edge),
    };
    LatticeFlow::assemble(flow, recurrence, history)
}
