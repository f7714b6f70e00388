//! Where particles would be had the flow not carried them.

use crate::AnalysisError;
use crate::followed::Followed;
use zimm_core::{Boundary, DVec3, Frame, Observable};

/// The displacement of every particle relative to the flow, summed from one measurement to the next, by identity.
///
/// ```text
/// d(t') = d(t) + nearest image of [ r(t') - E r(t) ],     E the deformation from t to t'
/// ```
///
/// less the mean over all particles. In a flow this is what a mean square displacement is made of: the affine part of
/// the motion is taken off, and neither images nor changes of the cell's basis show. It needs no image counts, but
/// must be measured often enough that no particle moves by half the distance of images in between; one that seems to
/// have moved by more than half of that is an error.
///
/// ```
/// use zimm_analysis::NonAffine;
/// use zimm_core::{Clock, DVec3, Observable, Open, Particles, System};
///
/// let mut system = System::new(Open, Particles::new(vec![DVec3::ZERO, DVec3::X])?, Clock::new(0.1, 1.0, 1)?);
/// let mut displacement = NonAffine::default();
/// displacement.measure(&system.frame(), &())?;
/// system.particles.positions_mut()[0].y = 1.0;
/// assert_eq!(displacement.measure(&system.frame(), &())?, [0.5 * DVec3::Y, -0.5 * DVec3::Y]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct NonAffine {
    followed: Followed,
}

impl<B: Boundary, T> Observable<B, T> for NonAffine {
    type Output = Result<Vec<DVec3>, AnalysisError>;

    fn measure(&mut self, frame: &Frame<'_, B>, _: &T) -> Self::Output {
        let mut positions = vec![DVec3::ZERO; frame.len()];
        for (place, &r) in frame.positions.iter().enumerate() {
            if let Some(entry) = positions.get_mut(frame.id(place) as usize) {
                *entry = r;
            }
        }
        let mut displacements = self.followed.to(frame, positions)?;
        let mean = displacements.iter().sum::<DVec3>() / frame.len().max(1) as f64;
        for displacement in &mut displacements {
            *displacement -= mean;
        }
        Ok(displacements)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Random;
    use zimm_core::{Clock, DMat3, IVec3, Lattice, Particles, System};

    /// Extension along x in a lattice that is carried from where it was at time zero.
    #[derive(Clone)]
    struct Extension(Lattice);

    impl Extension {
        fn at(time: f64) -> Self {
            Self(Lattice::new(deformation(time) * 6.0).unwrap())
        }
    }

    fn deformation(strain: f64) -> DMat3 {
        DMat3::from_diagonal(DVec3::new(strain.exp(), (-strain).exp(), 1.0))
    }

    impl Boundary for Extension {
        const FLOWS: bool = true;

        fn min_image(&self, dr: DVec3) -> DVec3 {
            self.0.nearest(dr)
        }

        fn wrap(&self, r: DVec3) -> (DVec3, IVec3) {
            self.0.fold(r)
        }

        fn reach(&self) -> f64 {
            0.5 * self.0.shortest()
        }

        fn carry(&self, from: f64, to: f64) -> DMat3 {
            deformation(to - from)
        }
    }

    /// Kicks of known size are added to particles that the flow carries and wraps: their sum comes back to rounding.
    #[test]
    fn law_what_is_left_is_what_was_added() {
        let (mut random, dt, n) = (Random::new(3), 0.02, 40);
        let start: Vec<DVec3> = (0..n).map(|_| random.normal3()).collect();
        let clock = Clock::new(dt, 1.0, 1).unwrap();
        let mut system = System::new(Extension::at(0.0), Particles::new(start).unwrap(), clock);
        let mut displacement = NonAffine::default();
        displacement.measure(&system.frame(), &()).unwrap();
        let mut added = vec![DVec3::ZERO; n];
        let mut found = Vec::new();
        for step in 1..=50 {
            system.clock.tick();
            system.boundary = Extension::at(f64::from(step) * dt);
            let kicks: Vec<DVec3> = (0..n).map(|_| 0.05 * random.normal3()).collect();
            let mean = kicks.iter().sum::<DVec3>() / n as f64;
            for ((r, &kick), sum) in system
                .particles
                .positions_mut()
                .iter_mut()
                .zip(&kicks)
                .zip(&mut added)
            {
                *r = system.boundary.wrap(deformation(dt) * *r + kick).0;
                *sum += kick - mean;
            }
            found = displacement.measure(&system.frame(), &()).unwrap();
        }
        for (found, added) in found.iter().zip(&added) {
            assert!(
                (*found - *added).length() < 1e-12,
                "{found} against {added}"
            );
        }
    }

    #[test]
    fn extreme_a_leap_is_an_error_with_its_length() {
        let clock = Clock::new(0.1, 1.0, 1).unwrap();
        let particles = Particles::new(vec![DVec3::ZERO]).unwrap();
        let mut system = System::new(Extension::at(0.0), particles, clock);
        let mut displacement = NonAffine::default();
        displacement.measure(&system.frame(), &()).unwrap();
        system.particles.positions_mut()[0].x = 2.0;
        let error = displacement.measure(&system.frame(), &()).unwrap_err();
        let expected = AnalysisError::TooFar {
            particle: 0,
            distance: 2.0,
            most: 1.5,
        };
        assert_eq!(error, expected);
    }
}
