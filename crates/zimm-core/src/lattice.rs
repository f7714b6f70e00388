//! A lattice in three dimensions: its basis, its images, its reduction.

use crate::LatticeError;
use glam::{DMat3, DVec3, IVec3};

/// A lattice, its basis kept as the columns of a matrix H.
///
/// Every lattice holds a *reduced* basis: no vector can be shortened by adding the others once (Minkowski's condition
/// in three dimensions; Semaev 2001). That is what makes the nearest image findable among the 27 neighbours of the
/// rounded one, and cells as compact as they can be.
///
/// ```
/// # use zimm_core::{DMat3, DVec3, Lattice};
/// // A square cell sheared by 1.7 is the same lattice as one tilted by -0.3.
/// let tilted = DMat3::from_cols(DVec3::X, DVec3::new(1.7, 1.0, 0.0), DVec3::Z);
/// let lattice = Lattice::new(tilted)?;
/// assert!((lattice.basis().y_axis.x + 0.3).abs() < 1e-15);
/// assert!((lattice.nearest(DVec3::new(1.7, 1.0, 0.1)) - DVec3::new(0.0, 0.0, 0.1)).length() < 1e-15);
/// # Ok::<(), zimm_core::LatticeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    basis: DMat3,
    inverse: DMat3,
    shortest: f64,
    safe_squared: f64,
}

impl Lattice {
    /// A lattice from any three vectors that span a volume; the basis is reduced.
    ///
    /// # Errors
    /// If the vectors are not finite, or flat to 1e-10 of the box that their lengths span.
    pub fn new(basis: DMat3) -> Result<Self, LatticeError> {
        let lengths = basis.x_axis.length() * basis.y_axis.length() * basis.z_axis.length();
        let (volume, least) = (basis.determinant().abs(), 1e-10 * lengths);
        // Vectors whose squared lengths underflow have no length to go by.
        let axes = [basis.x_axis, basis.y_axis, basis.z_axis];
        let measurable = axes.iter().all(|v| v.length_squared().is_normal());
        if !(measurable && volume.is_normal() && volume > least) {
            return Err(LatticeError::Degenerate { volume, least });
        }
        Ok(Self::from_reduced(reduce(basis)))
    }

    /// A brick of the given edges.
    ///
    /// # Errors
    /// If an edge is not finite and above zero.
    pub fn brick(edges: DVec3) -> Result<Self, LatticeError> {
        if edges.min_element() > 0.0 {
            Self::new(DMat3::from_diagonal(edges))
        } else {
            let volume = edges.x * edges.y * edges.z;
            Err(LatticeError::Degenerate { volume, least: 0.0 })
        }
    }

    fn from_reduced(basis: DMat3) -> Self {
        let inverse = basis.inverse();
        let [a, b, c] = [basis.x_axis, basis.y_axis, basis.z_axis];
        let shortest = a.length().min(b.length()).min(c.length());
        let half_width = 0.5 * perpendicular_widths(inverse).min_element();
        Self {
            basis,
            inverse,
            shortest,
            safe_squared: half_width * half_width,
        }
    }

    /// The reduced basis vectors, as columns.
    #[inline]
    pub fn basis(&self) -> DMat3 {
        self.basis
    }

    /// The inverse of the basis; its rows are the reciprocal vectors (without 2 pi).
    #[inline]
    pub fn inverse(&self) -> DMat3 {
        self.inverse
    }

    /// Volume of the cell.
    pub fn volume(&self) -> f64 {
        self.basis.determinant().abs()
    }

    /// Distances between opposite faces.
    pub fn widths(&self) -> DVec3 {
        perpendicular_widths(self.inverse)
    }

    /// Length of the shortest lattice vector: how close a particle comes to its own images.
    #[inline]
    pub fn shortest(&self) -> f64 {
        self.shortest
    }

    /// A position in the cell centred on the origin, and the lattice vector taken off it in units of the basis.
    #[inline]
    pub fn fold(&self, r: DVec3) -> (DVec3, IVec3) {
        let n = round(self.inverse * r);
        (r - self.basis * n, n.as_ivec3())
    }

    /// The image of a separation in the cell around the origin: the nearest one whenever it is shorter than half
    /// the smallest width.
    #[inline]
    pub fn rounded(&self, dr: DVec3) -> DVec3 {
        dr - self.basis * round(self.inverse * dr)
    }

    /// The nearest image of a separation, in all cases.
    #[inline]
    pub fn nearest(&self, dr: DVec3) -> DVec3 {
        let near = self.rounded(dr);
        if near.length_squared() <= self.safe_squared {
            near
        } else {
            self.search(near)
        }
    }

    fn search(&self, near: DVec3) -> DVec3 {
        let mut best = near;
        for n in neighbours_of_zero() {
            let image = near + self.basis * n;
            if image.length_squared() < best.length_squared() {
                best = image;
            }
        }
        best
    }
}

/// Rounds to the nearest integer by adding and taking off 1.5 2^52: two additions where a call would be slow. Exact
/// for magnitudes below 2^51; halves go to the even neighbour.
#[inline(always)]
pub(crate) fn round(s: DVec3) -> DVec3 {
    const SHIFT: f64 = 6_755_399_441_055_744.0;
    (s + SHIFT) - SHIFT
}

fn perpendicular_widths(inverse: DMat3) -> DVec3 {
    let rows = inverse.transpose();
    DVec3::new(
        rows.x_axis.length().recip(),
        rows.y_axis.length().recip(),
        rows.z_axis.length().recip(),
    )
}

fn neighbours_of_zero() -> impl Iterator<Item = DVec3> {
    (-1..=1).flat_map(|a| {
        (-1..=1).flat_map(move |b| (-1..=1).map(move |c| IVec3::new(a, b, c).as_dvec3()))
    })
}

/// Shortens basis vectors by each other until none can be shortened: pairs by rounding (Lagrange and Gauss), then
/// triples by one step. A shortening below rounding is not taken, so that the loop ends.
fn reduce(basis: DMat3) -> DMat3 {
    const GAIN: f64 = 1.0 - 1e-12;
    let mut v = [basis.x_axis, basis.y_axis, basis.z_axis];
    loop {
        let mut shortened = false;
        for k in 0..3 {
            for m in [(k + 1) % 3, (k + 2) % 3] {
                let times = (v[k].dot(v[m]) / v[m].length_squared()).round();
                let shorter = v[k] - times * v[m];
                if shorter.length_squared() < GAIN * v[k].length_squared() {
                    v[k] = shorter;
                    shortened = true;
                }
            }
        }
        if shortened {
            continue;
        }
        for k in 0..3 {
            let (m, n) = ((k + 1) % 3, (k + 2) % 3);
            for (p, q) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                let shorter = v[k] + p * v[m] + q * v[n];
                if shorter.length_squared() < GAIN * v[k].length_squared() {
                    v[k] = shorter;
                    shortened = true;
                }
            }
        }
        if !shortened {
            return DMat3::from_cols(v[0], v[1], v[2]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector(limit: f64) -> impl Strategy<Value = DVec3> {
        [-limit..limit, -limit..limit, -limit..limit].prop_map(DVec3::from_array)
    }

    fn basis() -> impl Strategy<Value = DMat3> {
        (vector(3.0), vector(3.0), vector(3.0))
            .prop_map(|(a, b, c)| DMat3::from_cols(a, b, c))
            .prop_filter("spans a volume", |h| h.determinant().abs() > 0.05)
    }

    fn brute_force_nearest(h: DMat3, dr: DVec3) -> f64 {
        let mut best = f64::INFINITY;
        for a in -8..=8 {
            for b in -8..=8 {
                for c in -8..=8 {
                    best = best.min((dr + h * IVec3::new(a, b, c).as_dvec3()).length());
                }
            }
        }
        best
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        #[test]
        fn law_nearest_image_is_the_nearest(h in basis(), dr in vector(4.0)) {
            let lattice = Lattice::new(h).unwrap();
            let near = lattice.nearest(dr);
            let brute = brute_force_nearest(lattice.basis(), lattice.rounded(dr));
            prop_assert!((near.length() - brute).abs() < 1e-12, "{} against {brute}", near.length());
        }

        #[test]
        fn law_reduction_keeps_the_lattice(h in basis()) {
            let lattice = Lattice::new(h).unwrap();
            let n = lattice.inverse() * h;
            for x in n.to_cols_array() {
                prop_assert!((x - x.round()).abs() < 1e-9);
            }
            prop_assert!((n.determinant().abs() - 1.0).abs() < 1e-9);
        }

        #[test]
        fn law_shortest_vector_is_the_shortest(h in basis()) {
            let lattice = Lattice::new(h).unwrap();
            let mut brute = f64::INFINITY;
            for a in -6i32..=6 {
                for b in -6i32..=6 {
                    for c in -6i32..=6 {
                        if (a, b, c) != (0, 0, 0) {
                            brute = brute.min((lattice.basis() * IVec3::new(a, b, c).as_dvec3()).length());
                        }
                    }
                }
            }
            prop_assert!((lattice.shortest() - brute).abs() < 1e-12);
        }

        #[test]
        fn law_fold_is_idempotent_and_counts_images(h in basis(), r in vector(50.0)) {
            let lattice = Lattice::new(h).unwrap();
            let (folded, n) = lattice.fold(r);
            prop_assert!((folded + lattice.basis() * n.as_dvec3() - r).length() < 1e-12);
            let s = lattice.inverse() * folded;
            prop_assert!(s.abs().max_element() <= 0.5 + 1e-12);
        }
    }

    #[test]
    fn extreme_flat_and_infinite_bases_are_refused() {
        let flat = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::X + DVec3::Y);
        assert!(matches!(
            Lattice::new(flat),
            Err(LatticeError::Degenerate { .. })
        ));
        assert!(Lattice::brick(DVec3::new(1.0, f64::INFINITY, 1.0)).is_err());
        assert!(Lattice::brick(DVec3::new(1.0, f64::NAN, 1.0)).is_err());
        assert!(Lattice::brick(DVec3::new(1.0, -1.0, -1.0)).is_err());
        assert!(Lattice::brick(DVec3::splat(1e-160)).is_err());
        assert!(Lattice::brick(DVec3::splat(1e-100)).is_ok());
    }
}
