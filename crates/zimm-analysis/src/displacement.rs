//! How far molecules have gone where nothing conserves momentum.

use crate::AnalysisError;
use crate::chain::map_chains;
use crate::followed::Followed;
use zimm_core::{Boundary, DVec3, Frame, Molecules, Observable};

/// The displacement of each molecule's centre of mass relative to the flow, summed from one measurement to the next:
///
/// ```text
/// d(t') = d(t) + nearest image of [ c(t') - E c(t) ],     E the deformation from t to t'
/// ```
///
/// Nothing is taken off: this is for Brownian dynamics, where the solvent is at rest in the flow and a single chain
/// diffuses too. Where momentum is conserved there is a drift to take off, and
/// [`CentresOfMass`](crate::CentresOfMass) or [`NonAffine`](crate::NonAffine) serve.
///
/// It serves isolated chains and cells, at rest and in any flow, and needs no image counts, but must be measured often
/// enough that no centre moves by half the distance of images in between; one that seems to have moved by more than half
/// of that is an error. Molecules of one bead are particles. With
/// [`MeanSquareDisplacement`](crate::MeanSquareDisplacement) it gives the long-time diffusivity from the slope of late
/// lags, and the short-time one from the displacement at the first.
///
/// ```
/// use zimm_analysis::Displacement;
/// use zimm_core::{Clock, DVec3, Molecules, Observable, Open, Particles, System};
///
/// let particles = Particles::new(vec![DVec3::ZERO, DVec3::X])?;
/// let mut system = System::new(Open, particles, Clock::new(0.1, 1.0, 1)?);
/// let mut displacement = Displacement::new(Molecules::linear(0, 1, 2)?);
/// displacement.measure(&system.frame(), &())?;
/// system.particles.positions_mut()[0].y = 1.0;
/// assert_eq!(displacement.measure(&system.frame(), &())?, [0.5 * DVec3::Y]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Displacement {
    molecules: Molecules,
    followed: Followed,
}

impl Displacement {
    /// Of these molecules, from the first measurement on.
    pub fn new(molecules: Molecules) -> Self {
        Self {
            molecules,
            followed: Followed::default(),
        }
    }

    /// Takes the molecules where they are now for where they were at the last measurement. After
    /// [`recentre`](zimm_core::recentre), which isolated chains in an extension need, what it moved is not to be counted:
    /// measure, recentre, rebase.
    ///
    /// # Errors
    /// If the molecules cannot be put together.
    pub fn rebase<B: Boundary>(&mut self, frame: &Frame<'_, B>) -> Result<(), AnalysisError> {
        let centres = self.centres(frame)?;
        self.followed.rebase(frame, centres);
        Ok(())
    }

    fn centres<B: Boundary>(&self, frame: &Frame<'_, B>) -> Result<Vec<DVec3>, AnalysisError> {
        map_chains(frame, &self.molecules, |places, beads| {
            let (mut mass, mut moment) = (0.0, DVec3::ZERO);
            for (&place, &bead) in places.iter().zip(beads) {
                mass += frame.mass(place);
                moment += frame.mass(place) * bead;
            }
            moment / mass
        })
    }
}

impl<B: Boundary, T> Observable<B, T> for Displacement {
    type Output = Result<Vec<DVec3>, AnalysisError>;

    fn measure(&mut self, frame: &Frame<'_, B>, _: &T) -> Self::Output {
        let centres = self.centres(frame)?;
        self.followed.to(frame, centres)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MeanSquareDisplacement;
    use crate::scene::{Cell, Flow, Random, at, planar_mixed, step, system};
    use zimm_core::{DMat3, Estimator, Open, Particles, recentre};

    // Dumbbells carried by shear through a cell that changes its basis every strain of 1, kicked bead by bead: the sum of
    // the kicks of a molecule, half of them each as its beads weigh the same, comes back, drift and all.
    #[test]
    fn law_kicks_add_up_in_a_flow() {
        let (n, mut random) = (8, Random::new(96));
        let start = (0..n).flat_map(|_| {
            let r = random.within(DMat3::IDENTITY * 6.0);
            [r, r + random.normal3().clamp_length_max(1.0)]
        });
        let particles = Particles::new(start.collect()).unwrap();
        let mut system = system(Cell::new(DMat3::IDENTITY * 6.0, 0.09), particles);
        let mut displacement = Displacement::new(Molecules::linear(0, n, 2).unwrap());
        displacement.measure(&system.frame(), &()).unwrap();
        let mut added = vec![DVec3::ZERO; n as usize];
        let mut found = Vec::new();
        for _ in 0..60 {
            let mut place = 0;
            // The second bead is drawn back to the first, lest bonds grow with the flow.
            let before = system.particles.positions().to_vec();
            let carry = DMat3::from_cols(DVec3::X, DVec3::new(0.09, 1.0, 0.0), DVec3::Z);
            let boundary = system.boundary.clone();
            step(&mut system, || {
                let (molecule, second) = (place / 2, place % 2 == 1);
                let mut kick = 0.1 * random.normal3() + DVec3::new(0.02, 0.05, -0.03);
                if second {
                    let bond = boundary.min_image(before[place] - before[place - 1]);
                    kick -= 0.2 * (carry * bond);
                }
                added[molecule] += 0.5 * kick;
                place += 1;
                kick
            });
            found = displacement.measure(&system.frame(), &()).unwrap();
        }
        for (found, added) in found.iter().zip(&added) {
            assert!((*found - *added).length() < 1e-11, "{found} for {added}");
        }
    }

    // One free dumbbell, alone in open space, whose beads take normal steps of variance 2 D0 dt along each axis: D = D0 /
    // 2 at all lags, and nothing of it is lost as drift. D0 = 0.25, dt = 1; 100 000 steps, seed 97. The first lag is known
    // to sqrt(2 / 300 000) = 0.26 %; each estimate's own error must be below 0.8 %, and the bounds are 4 of them.
    #[test]
    fn limit_a_single_chain_diffuses() {
        let mut random = Random::new(97);
        let mut system = at(Open, vec![DVec3::ZERO, DVec3::X]);
        let mut displacement = Displacement::new(Molecules::linear(0, 1, 2).unwrap());
        let mut squares = MeanSquareDisplacement::new(1.0, 1..=4).unwrap();
        for _ in 0..100_000 {
            step(&mut system, || 0.5_f64.sqrt() * random.normal3());
            squares.push(displacement.measure(&system.frame(), &()).unwrap());
        }
        let found = squares.estimate().unwrap();
        let short_time = found.displacement[0].times(1.0 / 6.0);
        for mean in [short_time, found.coefficient] {
            let error = mean.standard_error().unwrap();
            assert!(error < 0.008 * 0.125, "{mean}");
            assert!((mean.value - 0.125).abs() < 4.0 * error, "{mean}");
        }
    }

    // A bead in a mixed flow of extension rate 1, kicked by 0.1 a step along x and brought back after each: the kicks
    // count, and neither the flow nor the way back. Over 50 steps the flow alone would carry it to 1e20.
    #[test]
    fn law_what_was_recentred_is_not_counted() {
        let molecules = Molecules::linear(0, 1, 1).unwrap();
        let mut system = at(Flow(planar_mixed(1.0, 0.5)), vec![DVec3::ZERO]);
        let mut displacement = Displacement::new(molecules);
        for steps in 0..50 {
            let found = displacement.measure(&system.frame(), &()).unwrap()[0];
            assert!((found - DVec3::X * 0.1 * f64::from(steps)).length() < 1e-12);
            recentre(&mut system, &molecules).unwrap();
            displacement.rebase(&system.frame()).unwrap();
            step(&mut system, || DVec3::X * 0.1);
        }
    }

    #[test]
    fn extreme_a_leap_is_an_error_with_its_length() {
        let mut system = at(Cell::cube(6.0), vec![DVec3::ZERO; 3]);
        let mut displacement = Displacement::new(Molecules::linear(1, 2, 1).unwrap());
        displacement.measure(&system.frame(), &()).unwrap();
        system.particles.positions_mut()[2].x = 2.0;
        let expected = AnalysisError::TooFar {
            particle: 1,
            distance: 2.0,
            most: 1.5,
        };
        assert_eq!(displacement.measure(&system.frame(), &()), Err(expected));
    }
}
