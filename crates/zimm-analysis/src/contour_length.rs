//! How long molecules are along their bonds.

use crate::AnalysisError;
use crate::chain::map_chains;
use zimm_core::{Boundary, Frame, Molecules, Observable};

/// The contour length of each molecule: the sum of the lengths of its bonds as they are now.
///
/// Springs of limit Q_0 never reach (number of bonds) Q_0, the fully stretched contour of a linear molecule. What is
/// seen of a molecule in a flow, [`Extent`](crate::Extent) along the flow or the length of
/// [`EndToEnd`](crate::EndToEnd), over the fully stretched contour is its **fractional extension**; over the contour
/// length it says how straight the molecule is, 1 for a taut line.
///
/// ```
/// use zimm_analysis::{ContourLength, EndToEnd, Extent};
/// use zimm_core::{Clock, DVec3, Molecules, Observable, Open, Particles, System};
///
/// // A hairpin of springs with Q_0 = 4.
/// let particles = Particles::new(vec![DVec3::ZERO, 3.0 * DVec3::X, DVec3::X])?;
/// let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
/// let (frame, molecules) = (system.frame(), Molecules::linear(0, 1, 3)?);
/// let contour = ContourLength { molecules }.measure(&frame, &())?[0];
/// let extent = Extent { molecules, along: DVec3::X }.measure(&frame, &())?[0];
/// let ends = EndToEnd { molecules }.measure(&frame, &())?[0].length();
/// assert_eq!((contour, extent, ends), (5.0, 3.0, 1.0));
/// let fractional_extension = extent / (2.0 * 4.0);
/// assert_eq!(fractional_extension, 0.375);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ContourLength {
    /// The molecules.
    pub molecules: Molecules,
}

impl<B: Boundary, T> Observable<B, T> for ContourLength {
    type Output = Result<Vec<f64>, AnalysisError>;

    fn measure(&mut self, frame: &Frame<'_, B>, _: &T) -> Self::Output {
        map_chains(frame, &self.molecules, |_, beads| {
            let links = self.molecules.links();
            links
                .map(|[i, j]| beads[i as usize].distance(beads[j as usize]))
                .sum()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Cell, at};
    use zimm_core::DVec3;

    // A rod of 50 beads 0.7 apart, ten times longer than the cell; a closed ring of 12 beads on a circle of radius 1,
    // 24 sin(15 degrees); a star of three arms of two bonds of 0.9.
    #[test]
    fn limit_a_rod_a_ring_and_a_star_across_images() {
        let along = DVec3::new(1.0, 2.0, -2.0) / 3.0;
        let rod = (0..50).map(|k| along * 0.7 * f64::from(k));
        let ring = (0..12).map(|k| {
            let angle = std::f64::consts::TAU * f64::from(k) / 12.0;
            DVec3::new(angle.cos(), 1.7, angle.sin())
        });
        let arms = DVec3::AXES.map(|axis| [0.9 * axis, 1.8 * axis]);
        let star = std::iter::once(DVec3::ZERO).chain(arms.as_flattened().iter().copied());
        let system = at(
            Cell::lees_edwards(DVec3::splat(3.5), 1.1),
            rod.chain(ring).chain(star).collect(),
        );
        for (molecules, exact) in [
            (Molecules::linear(0, 1, 50), 34.3),
            (
                Molecules::ring(50, 1, 12),
                24.0 * 15.0_f64.to_radians().sin(),
            ),
            (Molecules::star(62, 1, 3, 2), 5.4),
            (Molecules::linear(0, 1, 1), 0.0),
        ] {
            let molecules = molecules.unwrap();
            let found = ContourLength { molecules }.measure(&system.frame(), &());
            assert!((found.unwrap()[0] - exact).abs() < 1e-12);
        }
    }
}
