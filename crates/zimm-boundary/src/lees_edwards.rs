//! A brick that flows in shear.

use crate::history::FlowHistory;
use zimm_core::{Boundary, DMat3, DVec3, IVec3, Lattice, LatticeError, Periodic, Remap};

/// Lees-Edwards boundaries as a lattice flow: u_x = rate(t) y, gradient along y, vorticity along z.
///
/// Rows of images above and below the cell are displaced along x by the strain times L_y (Lees and Edwards 1972). Seen
/// as a lattice, its basis is carried by the flow,
///
/// ```text
///        | L_x  tilt  0   |
/// H(t) = |  0   L_y   0   |     tilt = strain(t) L_y  modulo L_x
///        |  0    0   L_z  |
/// ```
///
/// and then reduced. H is computed from the strain at the time asked for and never accumulated. The modulus is taken
/// without rounding, so that the tilt is exact to a few units in the last place of L_x, however large the strain: a
/// strain known to 1e-16 of itself is all that limits a long run.
///
/// Nothing outside sees when the basis changes: image counts are told how to follow by the [`Remap`], and peculiar
/// velocities are untouched. Counts are integers of 32 bits, so a particle may be carried past 2e9 images, a strain of
/// 2e9 L_x / L_y per row. A time at which the strain is not finite leaves the space as it was.
///
/// ```
/// use zimm_boundary::{LeesEdwards, Steady};
/// use zimm_core::{Boundary, DVec3};
///
/// let mut space = LeesEdwards::new(DVec3::new(10.0, 5.0, 8.0), Steady::new(0.1)?)?;
/// space.advance(17.0);
/// assert!((space.tilt() + 1.5).abs() < 1e-15); // 0.1 * 17 * 5 = 8.5, one L_x taken off
/// assert_eq!(space.min_image_distance(), 5.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LeesEdwards<H> {
    history: H,
    edges: DVec3,
    time: f64,
    lattice: Lattice,
}

impl<H: FlowHistory> LeesEdwards<H> {
    /// A brick of the given edges, of any aspect ratio, sheared as `history` tells; it stands at time zero.
    ///
    /// # Errors
    /// If an edge is not finite and above zero, if L_y is below 5e-11 L_x (the cell would be flat at half an L_x of
    /// tilt), or if the strain at time zero is not finite.
    pub fn new(edges: DVec3, history: H) -> Result<Self, LatticeError> {
        Lattice::brick(edges)?;
        // The most oblique cell that a fold can leave: if this is a lattice, so are all others.
        Lattice::new(basis(edges, 0.5 * edges.x))?;
        let lattice = Lattice::new(basis(edges, tilt(history.strain(0.0), edges)))?;
        Ok(Self {
            history,
            edges,
            time: 0.0,
            lattice,
        })
    }

    /// The smallest box in which a cutoff fits at every strain: a cube of twice the cutoff.
    ///
    /// # Errors
    /// If the cutoff is not finite and above zero, or the strain at time zero is not finite.
    pub fn box_for_cutoff(cutoff: f64, history: H) -> Result<Self, LatticeError> {
        Self::new(DVec3::splat(2.0 * cutoff), history)
    }

    /// The history of the shear.
    pub fn history(&self) -> &H {
        &self.history
    }

    /// How far the row of images above is displaced along x now, between -L_x / 2 and L_x / 2.
    pub fn tilt(&self) -> f64 {
        tilt(self.history.strain(self.time), self.edges)
    }

    /// The closest that two images ever come: the shortest edge. A cutoff up to half of it fits at every strain.
    ///
    /// Images in the same row are multiples of L_x and L_z away, as at rest; those in the n-th row above or below are
    /// at least n L_y away, and just that at whole strains. So shear never brings images closer than the brick does.
    pub fn min_image_distance(&self) -> f64 {
        self.edges.min_element()
    }
}

impl<H: FlowHistory> Boundary for LeesEdwards<H> {
    const FLOWS: bool = true;

    #[inline(always)]
    fn min_image(&self, dr: DVec3) -> DVec3 {
        self.lattice.nearest(dr)
    }

    #[inline(always)]
    fn wrap(&self, r: DVec3) -> (DVec3, IVec3) {
        self.lattice.fold(r)
    }

    fn reach(&self) -> f64 {
        0.5 * self.lattice.shortest()
    }

    fn gradient(&self) -> DMat3 {
        shear(self.history.rate(self.time))
    }

    fn carry(&self, from: f64, to: f64) -> DMat3 {
        DMat3::IDENTITY + shear(self.history.strain(to) - self.history.strain(from))
    }

    fn advance(&mut self, to: f64) -> Remap {
        let tilt = tilt(self.history.strain(to), self.edges);
        match Lattice::new(basis(self.edges, tilt)) {
            Ok(lattice) if to.is_finite() => {
                let carried = self.carry(self.time, to) * self.lattice.basis();
                (self.time, self.lattice) = (to, lattice);
                Remap::between(carried, &lattice)
            }
            // Only a time or strain that is not finite comes here; the next good time finds the old state intact.
            _ => Remap::None,
        }
    }

    fn cell(&self) -> Option<DMat3> {
        Some(self.lattice.basis())
    }
}

impl<H: FlowHistory> Periodic for LeesEdwards<H> {
    fn lattice(&self) -> &Lattice {
        &self.lattice
    }
}

/// e_x e_y^T times a number.
fn shear(amount: f64) -> DMat3 {
    DMat3::from_cols(DVec3::ZERO, DVec3::new(amount, 0.0, 0.0), DVec3::ZERO)
}

fn basis(edges: DVec3, tilt: f64) -> DMat3 {
    let mut basis = DMat3::from_diagonal(edges);
    basis.y_axis.x = tilt;
    basis
}

/// strain L_y modulo L_x, nearest to zero. Factors are halved into leading and trailing digits, so that the partial
/// products are exact, and the remainder of each is exact by definition: only the last sums round.
fn tilt(strain: f64, edges: DVec3) -> f64 {
    let ([s, s_rest], [y, y_rest]) = (halves(strain), halves(edges.y));
    let folded = |product| libm::remainder(product, edges.x);
    let small = folded(s_rest * y_rest) + folded(s_rest * y) + folded(s * y_rest);
    folded(small + folded(s * y))
}

/// The leading 26 binary digits of a number, and the rest.
fn halves(x: f64) -> [f64; 2] {
    let leading = f64::from_bits(x.to_bits() & !0x07ff_ffff);
    [leading, x - leading]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// Edges are whole multiples of 2^-30 and strains of 2^-20, up to 1e6 and beyond, so that the tilt is an
        /// integer that i128 arithmetic knows exactly. A modulus by L_x / L_y in double precision is wrong by 1e-10
        /// L_x at a strain of 1e6; the bound is 1e-15 L_x.
        #[test]
        fn law_tilt_is_exact_at_any_strain(
            x in 1_i64 << 30..1 << 37,
            y in 1_i64 << 30..1 << 37,
            s in -(1_i64 << 42)..1 << 42,
            shift in 0..30,
        ) {
            let s = s >> shift;
            let unit = 2.0_f64.powi(-30);
            let edges = DVec3::new(x as f64 * unit, y as f64 * unit, 1.0);
            let strain = s as f64 * 2.0_f64.powi(-20);
            // Everything in units of 2^-50.
            let (product, period) = (i128::from(s) * i128::from(y), i128::from(x) << 20);
            let remainder = product.rem_euclid(period);
            let exact = remainder as f64 * 2.0_f64.powi(-50);
            let found = tilt(strain, edges);
            let apart = libm::remainder(found - exact, edges.x).abs();
            prop_assert!(apart <= 1e-15 * edges.x, "{found} {exact}");
            prop_assert!(found.abs() <= 0.5 * edges.x);
        }
    }

    #[test]
    fn extreme_tilt_of_products_that_overflow_is_not_finite() {
        let edges = DVec3::new(1.0, 1e10, 1.0);
        assert!(tilt(1e300, edges).is_nan());
        assert!(tilt(f64::NAN, edges).is_nan());
        assert!(tilt(f64::INFINITY, edges).is_nan());
        assert!(tilt(1e290, edges).abs() <= 0.5);
        assert_eq!(tilt(0.0, edges), 0.0);
    }
}
