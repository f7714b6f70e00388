//! How bonds are stretched and where they point.

use crate::AnalysisError;
use crate::chain::map_chains;
use crate::tensor::{outer, trace};
use zimm_core::{Boundary, DMat3, DVec3, Frame, Molecules, Observable};

/// Means over the bonds Q of molecules: the stretch `<QQ>` and the orientation `<uu>` with
/// u = Q / |Q|.
///
/// ```
/// use zimm_analysis::BondStatistics;
/// use zimm_core::{Clock, DVec3, Molecules, Observable, Open, Particles, System};
///
/// let particles = Particles::new(vec![DVec3::ZERO, 2.0 * DVec3::X, DVec3::new(2.0, 1.0, 0.0)])?;
/// let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
/// let molecules = Molecules::linear(0, 1, 3)?;
/// let moments = BondStatistics { molecules }.measure(&system.frame(), &())?;
/// assert_eq!(moments.mean_square_length(), 2.5);
/// assert_eq!((moments.orientation.x_axis.x, moments.orientation.y_axis.y), (0.5, 0.5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct BondStatistics {
    /// The molecules.
    pub molecules: Molecules,
}

/// Means over bonds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BondMoments {
    /// Number of bonds.
    pub bonds: u64,
    /// `<QQ>`, in length squared.
    pub stretch: DMat3,
    /// `<uu>`; its trace is 1, or less by bonds of no length.
    pub orientation: DMat3,
}

impl BondMoments {
    /// The moments of any connectors: of the end-to-end vectors of [`EndToEnd`](crate::EndToEnd), say.
    ///
    /// # Errors
    /// If there are none.
    pub fn of(connectors: impl IntoIterator<Item = DVec3>) -> Result<Self, AnalysisError> {
        let (mut bonds, mut stretch, mut orientation) = (0_u64, DMat3::ZERO, DMat3::ZERO);
        for bond in connectors {
            let direction = bond.normalize_or_zero();
            bonds += 1;
            stretch += outer(bond, bond);
            orientation += outer(direction, direction);
        }
        if bonds == 0 {
            let (what, found, needed) = ("bonds", 0, 1);
            return Err(AnalysisError::TooFew {
                what,
                found,
                needed,
            });
        }
        let per_bond = 1.0 / bonds as f64;
        Ok(Self {
            bonds,
            stretch: stretch * per_bond,
            orientation: orientation * per_bond,
        })
    }

    /// `<Q^2>`, in length squared.
    pub fn mean_square_length(&self) -> f64 {
        trace(&self.stretch)
    }

    /// The order parameter about an axis n of length 1, `(3 <(u . n)^2> - 1) / 2`: 1 if all bonds lie along it, 0 if
    /// they point anywhere, -1/2 if all lie across.
    pub fn order(&self, axis: DVec3) -> f64 {
        1.5 * axis.dot(self.orientation * axis) - 0.5
    }
}

impl<B: Boundary, T> Observable<B, T> for BondStatistics {
    type Output = Result<BondMoments, AnalysisError>;

    fn measure(&mut self, frame: &Frame<'_, B>, _: &T) -> Self::Output {
        let mut connectors = Vec::new();
        map_chains(frame, &self.molecules, |_, beads| {
            let links = self.molecules.links();
            connectors.extend(links.map(|[i, j]| beads[j as usize] - beads[i as usize]));
        })?;
        BondMoments::of(connectors)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Cell, Random, at};

    // 20 000 dumbbells with Gaussian connectors of variances 0.04, 0.09, 0.01: the moments of the normal distribution
    // and, for equal variances, the isotropic orientation 1/3. Seed 41; standard errors sqrt(2 / 20 000) = 1 % of each
    // stretch and sqrt(4 / 45 / 20 000) = 0.0021 of an orientation. Bounds 4 sigma.
    #[test]
    fn limit_gaussian_bonds() {
        for width in [DVec3::new(0.2, 0.3, 0.1), DVec3::splat(0.2)] {
            let mut random = Random::new(41);
            let mut positions = Vec::new();
            for _ in 0..20_000 {
                let r = random.within(DMat3::IDENTITY * 4.0);
                positions.extend([r, r + width * random.normal3()]);
            }
            let system = at(Cell::lees_edwards(DVec3::splat(4.0), -1.7), positions);
            let molecules = Molecules::linear(0, 20_000, 2).unwrap();
            let found = BondStatistics { molecules }
                .measure(&system.frame(), &())
                .unwrap();
            assert_eq!(found.bonds, 20_000);
            let stretch = DVec3::new(
                found.stretch.x_axis.x,
                found.stretch.y_axis.y,
                found.stretch.z_axis.z,
            );
            assert!(
                (stretch / (width * width) - 1.0).abs().max_element() < 0.04,
                "{stretch}"
            );
            assert!((trace(&found.orientation) - 1.0).abs() < 1e-12);
            if width.x == width.y {
                let u = DVec3::new(
                    found.orientation.x_axis.x,
                    found.orientation.y_axis.y,
                    found.orientation.y_axis.x,
                );
                assert!(
                    (u - DVec3::new(1.0, 1.0, 0.0) / 3.0).abs().max_element() < 0.0085,
                    "{u}"
                );
            }
        }
    }

    // Rods along x, across it, and an isotropic set of directions: the corners of a cube.
    #[test]
    fn limit_order_about_an_axis() {
        let order = |bonds: &[DVec3]| {
            BondMoments::of(bonds.iter().copied())
                .unwrap()
                .order(DVec3::X)
        };
        assert_eq!(order(&[DVec3::X, -3.0 * DVec3::X]), 1.0);
        assert_eq!(order(&[DVec3::Y, DVec3::Z]), -0.5);
        let corners =
            [DVec3::ONE, DVec3::new(1.0, 1.0, -1.0)].map(|r| [r, r * DVec3::new(1.0, -1.0, 1.0)]);
        let corners: Vec<_> = corners
            .as_flattened()
            .iter()
            .flat_map(|&r| [r, -r])
            .collect();
        assert!(order(&corners).abs() < 1e-15);
    }

    // An equilateral ring across images, and a star with arms along x, y and z: bonds as the topology has them.
    #[test]
    fn limit_rings_and_stars() {
        let corner = |k| {
            let angle = std::f64::consts::TAU * f64::from(k) / 3.0;
            DVec3::new(angle.cos(), angle.sin(), 0.9)
        };
        let arms = DVec3::AXES.map(|axis| [axis, 2.0 * axis]);
        let star = std::iter::once(DVec3::ZERO).chain(arms.as_flattened().iter().copied());
        let positions = (0..3).map(corner).chain(star).collect();
        let system = at(Cell::lees_edwards(DVec3::splat(3.6), 1.0), positions);
        let measure = |molecules| {
            BondStatistics { molecules }
                .measure(&system.frame(), &())
                .unwrap()
        };
        let ring = measure(Molecules::ring(0, 1, 3).unwrap());
        assert!((ring.mean_square_length() - 3.0).abs() < 1e-12 && ring.bonds == 3);
        let star = measure(Molecules::star(3, 1, 3, 2).unwrap());
        assert!((star.mean_square_length() - 1.0).abs() < 1e-12 && star.bonds == 6);
        assert!(star.order(DVec3::X).abs() < 1e-12);
    }

    #[test]
    fn extreme_no_bonds_are_an_error_and_no_length_has_no_direction() {
        let system = at(Cell::cube(4.0), vec![DVec3::ONE; 2]);
        let statistics = |beads| {
            let molecules = Molecules::linear(0, 1, beads).unwrap();
            BondStatistics { molecules }.measure(&system.frame(), &())
        };
        assert!(matches!(statistics(1), Err(AnalysisError::TooFew { .. })));
        assert_eq!(statistics(2).unwrap().orientation, DMat3::ZERO);
    }
}
