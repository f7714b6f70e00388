//! The space that particles live in, and the homogeneous flow that carries it.

use crate::Lattice;
use glam::{DMat3, DVec3, IVec3};

/// The space particles live in, and the homogeneous flow `u = kappa r` that carries it.
///
/// A boundary is a closed-form function of time: [`advance`](Self::advance) sets it to its state at any time, so it
/// never drifts and a restart needs the time alone. Positions are measured from the point where the flow is at rest.
///
/// An implementation guarantees that `carry(t, t)` is the identity, that carries compose, and that lattice vectors
/// are carried as particles are. Whatever it does to its basis, the set of images is that of the carried lattice.
pub trait Boundary: Clone + Send + Sync {
    /// Whether the space streams. `false` takes `kappa r` out of every loop.
    const FLOWS: bool = false;

    /// The nearest image of a separation.
    fn min_image(&self, dr: DVec3) -> DVec3;

    /// A position brought into the primary cell, and the lattice vector taken off it in units of the basis.
    fn wrap(&self, r: DVec3) -> (DVec3, IVec3);

    /// Separations shorter than this have one nearest image: half the shortest lattice vector.
    fn reach(&self) -> f64 {
        f64::INFINITY
    }

    /// The velocity gradient now, `kappa_ij = dv_i / dx_j`.
    fn gradient(&self) -> DMat3 {
        DMat3::ZERO
    }

    /// The deformation between two times: the one matrix that carries particles and lattice alike.
    fn carry(&self, _from: f64, _to: f64) -> DMat3 {
        DMat3::IDENTITY
    }

    /// Sets the space to its state at time `to` and tells how image counts change with the basis.
    fn advance(&mut self, _to: f64) -> Remap {
        Remap::None
    }

    /// The basis of the cell (columns), if there is one.
    fn cell(&self) -> Option<DMat3> {
        None
    }
}

/// A boundary with a lattice. Cell grids and Ewald sums ask for this, so that open space cannot reach them.
pub trait Periodic: Boundary {
    /// The lattice now, in a reduced basis.
    fn lattice(&self) -> &Lattice;
}

/// How image counts follow a change of basis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Remap {
    /// The basis was carried by the flow and nothing else.
    #[default]
    None,
    /// The basis was multiplied by an integer matrix of determinant +-1; image counts are multiplied by its inverse,
    /// whose rows these are.
    Counts([IVec3; 3]),
}

impl Remap {
    /// The remap from `carried`, the former basis carried to now and perhaps no longer reduced, to the basis now.
    pub fn between(carried: DMat3, now: &Lattice) -> Self {
        let rows = (now.inverse() * carried).transpose();
        let rows = [rows.x_axis, rows.y_axis, rows.z_axis].map(|row| row.round().as_ivec3());
        if rows == [IVec3::X, IVec3::Y, IVec3::Z] {
            Self::None
        } else {
            Self::Counts(rows)
        }
    }

    /// The image count in the new basis.
    #[inline]
    pub fn apply(&self, count: IVec3) -> IVec3 {
        match self {
            Self::None => count,
            Self::Counts(rows) => {
                // Counts of particles that diverge with an extension wrap around.
                let dot = |row: IVec3| {
                    (row.x.wrapping_mul(count.x))
                        .wrapping_add(row.y.wrapping_mul(count.y))
                        .wrapping_add(row.z.wrapping_mul(count.z))
                };
                IVec3::new(dot(rows[0]), dot(rows[1]), dot(rows[2]))
            }
        }
    }
}

/// Unbounded space at rest: the null boundary.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Open;

impl Boundary for Open {
    #[inline(always)]
    fn min_image(&self, dr: DVec3) -> DVec3 {
        dr
    }

    #[inline(always)]
    fn wrap(&self, r: DVec3) -> (DVec3, IVec3) {
        (r, IVec3::ZERO)
    }
}
