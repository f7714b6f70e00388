//! How far molecules reach along a direction.

use crate::AnalysisError;
use crate::chain::map_chains;
use zimm_core::{Boundary, DVec3, Frame, Molecules, Observable};

/// The extent of each molecule along a direction: the distance of its foremost from its rearmost bead, projected. This
/// is what a microscope sees of a stretched chain, also of one that is folded; over the contour length it is the
/// fractional extension.
///
/// ```
/// use zimm_analysis::Extent;
/// use zimm_core::{Clock, DVec3, Molecules, Observable, Open, Particles, System};
///
/// // A hairpin: its ends are 1 apart, its extent along x is 3.
/// let particles = Particles::new(vec![DVec3::ZERO, 3.0 * DVec3::X, DVec3::new(1.0, 0.2, 0.0)])?;
/// let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
/// let extents = Extent { molecules: Molecules::linear(0, 1, 3)?, along: DVec3::X }.measure(&system.frame(), &())?;
/// assert_eq!(extents, [3.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// The molecules.
    pub molecules: Molecules,
    /// The direction, a vector of length 1.
    pub along: DVec3,
}

impl<B: Boundary, T> Observable<B, T> for Extent {
    type Output = Result<Vec<f64>, AnalysisError>;

    fn measure(&mut self, frame: &Frame<'_, B>, _: &T) -> Self::Output {
        map_chains(frame, &self.molecules, |_, beads| {
            let (mut rear, mut front) = (f64::INFINITY, f64::NEG_INFINITY);
            for bead in beads {
                let place = self.along.dot(*bead);
                (rear, front) = (rear.min(place), front.max(place));
            }
            front - rear
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Cell, at};

    // A rod of 50 beads 0.7 apart, ten times longer than the cell, and a ring of radius 2: 49 0.7 cos and 4.
    #[test]
    fn limit_a_rod_and_a_ring_across_many_images() {
        let along = DVec3::new(1.0, 2.0, -2.0) / 3.0;
        let angle = |k| std::f64::consts::TAU * f64::from(k) / 60.0;
        let ring = (0..60).map(|k| 2.0 * DVec3::new(angle(k).cos(), angle(k).sin(), 0.0));
        let rod = (0..50).map(|k| along * 0.7 * f64::from(k));
        let system = at(
            Cell::lees_edwards(DVec3::splat(3.5), 1.1),
            rod.chain(ring).collect(),
        );
        let extent = |first, beads, along| {
            let molecules = Molecules::linear(first, 1, beads).unwrap();
            Extent { molecules, along }
                .measure(&system.frame(), &())
                .unwrap()[0]
        };
        for (direction, cos) in [(along, 1.0), (DVec3::X, 1.0 / 3.0), (DVec3::Z, 2.0 / 3.0)] {
            assert!((extent(0, 50, direction) - 34.3 * cos).abs() < 1e-12);
        }
        assert!((extent(50, 60, DVec3::X) - 4.0).abs() < 1e-12);
        assert!(extent(50, 60, DVec3::Z).abs() < 1e-12);
        assert_eq!(extent(7, 1, along), 0.0);
    }
}
