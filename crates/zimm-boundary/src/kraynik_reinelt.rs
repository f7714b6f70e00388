//! Planar extension.

use crate::history::FlowHistory;
use crate::planar_mixed::planar;
use crate::{FlowError, LatticeFlow, PlanarMap};

/// Planar extension without end: u = rate(t) (x, -y, 0), after Kraynik and Reinelt (1992).
///
/// A square turned by the magic angle, atan((sqrt 5 - 1) / 2) = 31.7 degrees to the axis of extension, is the same
/// lattice again after a Hencky strain of ln((3 + sqrt 5) / 2) = 0.962. Images never come closer than
/// (4 / 5)^(1/4) = 0.946 of its edge. Other squares and lattices return as well, see [`PlanarMap`]; none keeps images
/// further apart.
///
/// The neutral edge L_z should be short. Extension stretches vortices: a velocity along the contracting axis that varies
/// along z grows at the rate of the flow less nu (2 pi / L_z)^2, with nu the kinematic viscosity, in the equations as
/// in nature. Where that is above zero the fluid stirs itself, and pressure and stress are no longer those of
/// homogeneous flow. Planar mixed flow does the same at its extension rate.
///
/// The strain of the history is the Hencky strain. A negative rate contracts along x.
///
/// ```
/// use zimm_boundary::{KraynikReinelt, Steady};
/// use zimm_core::{Boundary, DVec3, Periodic};
///
/// let mut space = KraynikReinelt::new(10.0, 8.0, Steady::new(0.5)?)?;
/// space.advance(1000.0);
/// assert_eq!(space.gradient() * DVec3::ONE, DVec3::new(0.5, -0.5, 0.0));
/// assert!((space.lattice().volume() / 800.0 - 1.0).abs() < 1e-14);
/// assert!(space.reach() >= 4.0 && space.min_image_distance() == 8.0);
/// # Ok::<(), zimm_boundary::FlowError>(())
/// ```
pub type KraynikReinelt<H> = LatticeFlow<PlanarExtension, H>;

/// Planar extension: names the flow of a [`KraynikReinelt`] cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlanarExtension {
    map: PlanarMap,
}

impl<H: FlowHistory> KraynikReinelt<H> {
    /// A square cell of the given edge in the plane of the flow, and of another edge along z; it stands at time zero.
    ///
    /// # Errors
    /// If an edge is not finite and above zero, or the strain at time zero is not finite.
    pub fn new(edge: f64, neutral_edge: f64, history: H) -> Result<Self, FlowError> {
        Self::with_map(PlanarMap::CLASSIC, edge, neutral_edge, history)
    }

    /// A cell that returns by another map; `edge` is the square root of its area in the plane.
    ///
    /// # Errors
    /// As [`new`](Self::new), and if the period of the map is so long that the cell gets flat to 1e-10 on the way.
    pub fn with_map(
        map: PlanarMap,
        edge: f64,
        neutral_edge: f64,
        history: H,
    ) -> Result<Self, FlowError> {
        planar(
            PlanarExtension { map },
            map,
            1.0,
            [edge, neutral_edge],
            history,
        )
    }

    /// The smallest box in which a cutoff fits at every strain, to 1e-12.
    ///
    /// # Errors
    /// If the cutoff is not finite and above zero, or the strain at time zero is not finite.
    pub fn box_for_cutoff(cutoff: f64, history: H) -> Result<Self, FlowError> {
        let map = PlanarMap::CLASSIC;
        let [edge, neutral_edge] = map.edges_for_cutoff(cutoff, 1.0);
        Self::with_map(map, edge, neutral_edge, history)
    }

    /// How the lattice returns.
    pub fn map(&self) -> PlanarMap {
        self.flow.map
    }
}
