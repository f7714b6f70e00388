//! Where particles and molecules would be without wrapping.

use crate::AnalysisError;
use crate::chain::map_chains;
use zimm_core::{Boundary, DVec3, Frame, Molecules, Observable};

/// The unwrapped position of every particle relative to the centre of mass of all of them, by identity.
///
/// This is what a mean square displacement is made of: no drift, no images. A scene with a cell must count images
/// ([`Particles::counting_images`](zimm_core::Particles::counting_images)). In a flow, images are those of the lattice
/// as it is now, and displacements are physical across the flow only; [`NonAffine`](crate::NonAffine) serves there.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unwrapped;

impl<B: Boundary, T> Observable<B, T> for Unwrapped {
    type Output = Result<Vec<DVec3>, AnalysisError>;

    fn measure(&mut self, frame: &Frame<'_, B>, _: &T) -> Self::Output {
        let centre = centre_of_mass(frame)?;
        let mut positions = vec![DVec3::ZERO; frame.len()];
        for place in 0..frame.len() {
            let position = unwrapped(frame, place)? - centre;
            if let Some(entry) = positions.get_mut(frame.id(place) as usize) {
                *entry = position;
            }
        }
        Ok(positions)
    }
}

/// The unwrapped centre of mass of every molecule relative to that of all particles.
///
/// Where momentum is conserved the common drift means nothing. In Brownian dynamics it is diffusion:
/// [`Displacement`](crate::Displacement) keeps it.
#[derive(Clone, Copy, Debug)]
pub struct CentresOfMass {
    /// The molecules.
    pub molecules: Molecules,
}

impl<B: Boundary, T> Observable<B, T> for CentresOfMass {
    type Output = Result<Vec<DVec3>, AnalysisError>;

    fn measure(&mut self, frame: &Frame<'_, B>, _: &T) -> Self::Output {
        let centre = centre_of_mass(frame)?;
        let centres = map_chains(frame, &self.molecules, |places, beads| {
            let (mut mass, mut moment) = (0.0, DVec3::ZERO);
            for (&place, &bead) in places.iter().zip(beads) {
                mass += frame.mass(place);
                moment += frame.mass(place) * bead;
            }
            let mut travelled = DVec3::ZERO;
            if let Some(&first) = places.first() {
                travelled = unwrapped(frame, first)? - frame.positions[first];
            }
            Ok(moment / mass + travelled - centre)
        })?;
        centres.into_iter().collect()
    }
}

fn centre_of_mass<B: Boundary>(frame: &Frame<'_, B>) -> Result<DVec3, AnalysisError> {
    if frame.is_empty() {
        return Err(AnalysisError::TooFew {
            what: "particles",
            found: 0,
            needed: 1,
        });
    }
    let (mut moment, mut mass) = (DVec3::ZERO, 0.0);
    for place in 0..frame.len() {
        moment += frame.mass(place) * unwrapped(frame, place)?;
        mass += frame.mass(place);
    }
    Ok(moment / mass)
}

/// Space without a cell wraps nothing.
fn unwrapped<B: Boundary>(frame: &Frame<'_, B>, place: usize) -> Result<DVec3, AnalysisError> {
    if frame.boundary.cell().is_none() {
        return Ok(frame.positions[place]);
    }
    let column = "images";
    frame
        .unwrapped(place)
        .ok_or(AnalysisError::MissingColumn { column })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Cell, at, step, system};
    use zimm_core::{Open, Particles};

    /// Three particles of masses 1, 2, 1 that start at the origin and take a step of their own each time.
    fn travellers() -> Particles {
        Particles::new(vec![DVec3::ZERO; 3])
            .unwrap()
            .with_masses(vec![1.0, 2.0, 1.0])
            .unwrap()
            .counting_images()
    }

    const STEPS: [DVec3; 3] = [
        DVec3::new(0.9, 0.1, -0.4),
        DVec3::new(-0.3, 0.8, 0.0),
        DVec3::new(0.2, 0.7, 0.7),
    ];

    #[test]
    fn law_travel_is_told_from_wrapping_and_drift_and_order() {
        let mut system = system(
            Cell::lees_edwards(DVec3::new(2.0, 1.5, 1.0), 0.6),
            travellers(),
        );
        for _ in 0..30 {
            let mut k = 0;
            step(&mut system, || {
                k += 1;
                STEPS[k - 1]
            });
        }
        let centre = (STEPS[0] + 2.0 * STEPS[1] + STEPS[2]) / 4.0;
        system.particles.permute(&[2, 0, 1]).unwrap();
        let found = Unwrapped.measure(&system.frame(), &()).unwrap();
        for (found, step) in found.iter().zip(STEPS) {
            assert!(
                (*found - 30.0 * (step - centre)).length() < 1e-12,
                "{found}"
            );
        }
    }

    #[test]
    fn law_molecules_travel_with_their_mass() {
        let bonds = [
            DVec3::ZERO,
            DVec3::new(0.3, 0.2, 0.1),
            DVec3::new(0.1, 0.6, 0.0),
        ];
        let particles = Particles::new(bonds.to_vec())
            .unwrap()
            .with_masses(vec![1.0, 2.0, 1.0])
            .unwrap()
            .counting_images();
        let mut system = system(Cell::lees_edwards(DVec3::splat(1.5), 0.6), particles);
        for _ in 0..30 {
            step(&mut system, || STEPS[0]);
        }
        let all = bonds[1] * 0.5 + bonds[2] * 0.25;
        let pair = bonds[1] * 2.0 / 3.0;
        let centre = |first, beads| {
            let molecules = Molecules::linear(first, 1, beads).unwrap();
            CentresOfMass { molecules }
                .measure(&system.frame(), &())
                .unwrap()[0]
        };
        assert!((centre(0, 2) - (pair - all)).length() < 1e-12);
        assert!((centre(2, 1) - (bonds[2] - all)).length() < 1e-12);
        assert!(centre(0, 3).length() < 1e-12);
    }

    #[test]
    fn extreme_images_that_nobody_counts_are_an_error() {
        let column = "images";
        let wrapped = at(Cell::cube(1.0), vec![DVec3::ZERO]);
        let found = Unwrapped.measure(&wrapped.frame(), &());
        assert_eq!(found, Err(AnalysisError::MissingColumn { column }));
        let open = at(Open, vec![DVec3::ZERO, 2.0 * DVec3::X]);
        assert_eq!(
            Unwrapped.measure(&open.frame(), &()).unwrap(),
            [-DVec3::X, DVec3::X]
        );
        assert!(Unwrapped.measure(&at(Open, vec![]).frame(), &()).is_err());
    }
}
