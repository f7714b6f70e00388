//! From one end of a molecule to the other.

use crate::AnalysisError;
use crate::chain::map_chains;
use zimm_core::{Boundary, DVec3, Frame, Molecules, Observable};

/// The vector from the first to the last bead of each molecule, the sum of its bonds' nearest images.
///
/// ```
/// use zimm_analysis::EndToEnd;
/// use zimm_core::{Clock, DVec3, Molecules, Observable, Open, Particles, System};
///
/// let particles = Particles::new(vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y])?;
/// let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
/// let ends = EndToEnd { molecules: Molecules::linear(0, 1, 3)? }.measure(&system.frame(), &())?;
/// assert_eq!(ends, [DVec3::new(1.0, 1.0, 0.0)]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct EndToEnd {
    /// The molecules, linear ones of one length.
    pub molecules: Molecules,
}

impl<B: Boundary, T> Observable<B, T> for EndToEnd {
    type Output = Result<Vec<DVec3>, AnalysisError>;

    fn measure(&mut self, frame: &Frame<'_, B>, _: &T) -> Self::Output {
        map_chains(frame, &self.molecules, |_, beads| {
            let ends = beads.last().zip(beads.first());
            ends.map_or(DVec3::ZERO, |(last, first)| last - first)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Cell, at};

    #[test]
    fn limit_a_rod_across_many_images_and_a_ring() {
        let along = DVec3::new(0.3, -0.5, 0.4);
        let ring = |k: u32| {
            let angle = std::f64::consts::TAU * f64::from(k) / 40.0;
            DVec3::new(2.0 * angle.cos(), 1.0, 2.0 * angle.sin())
        };
        let rod = (0..50).map(|k| along * f64::from(k));
        let system = at(
            Cell::lees_edwards(DVec3::splat(3.0), 1.1),
            rod.chain((0..=40).map(ring)).collect(),
        );
        let ends = |first, beads| {
            let molecules = Molecules::linear(first, 1, beads).unwrap();
            EndToEnd { molecules }
                .measure(&system.frame(), &())
                .unwrap()[0]
        };
        assert!((ends(0, 50) - 49.0 * along).length() < 1e-12);
        assert!(ends(50, 41).length() < 1e-12);
        assert_eq!(ends(3, 1), DVec3::ZERO);
    }
}
