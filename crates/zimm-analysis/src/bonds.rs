//! How bonds are stretched and where they point.

use crate::AnalysisError;
use crate::chain::map_chains;
use crate::tensor::{outer, trace};
use zimm_core::{Boundary, DMat3, Frame, Molecules, Observable};

/// Means over the bonds Q between successive beads of molecules: the stretch `<QQ>` and the orientation `<uu>` with
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
    /// The molecules, linear ones of one length.
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
    /// `<Q^2>`, in length squared.
    pub fn mean_square_length(&self) -> f64 {
        trace(&self.stretch)
    }
}

impl<B: Boundary, T> Observable<B, T> for BondStatistics {
    type Output = Result<BondMoments, AnalysisError>;

    fn measure(&mut self, frame: &Frame<'_, B>, _: &T) -> Self::Output {
        let (mut bonds, mut stretch, mut orientation) = (0_u64, DMat3::ZERO, DMat3::ZERO);
        map_chains(frame, &self.molecules, |_, beads| {
            for (here, there) in beads.iter().zip(beads.iter().skip(1)) {
                let bond = there - here;
                let direction = bond.normalize_or_zero();
                bonds += 1;
                stretch += outer(bond, bond);
                orientation += outer(direction, direction);
            }
        })?;
        if bonds == 0 {
            let (what, found, needed) = ("bonds", 0, 1);
            return Err(AnalysisError::TooFew {
                what,
                found,
                needed,
            });
        }
        let per_bond = 1.0 / bonds as f64;
        Ok(BondMoments {
            bonds,
            stretch: stretch * per_bond,
            orientation: orientation * per_bond,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Cell, Random, at};
    use zimm_core::DVec3;

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
