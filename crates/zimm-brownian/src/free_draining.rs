//! Beads that do not feel each other through the solvent.

use crate::{Mobility, Root, White};
use zimm_core::{Boundary, DVec3, Frame, MobilityError, ParameterError, for_each_chunk};

/// No hydrodynamic interaction: every bead moves by its own force, u = F / zeta.
///
/// The friction zeta has the unit force over velocity. With lengths in sqrt(kT / H), energies in kT and times in
/// lambda_H = zeta / 4H, as is customary for bead-spring chains, it is 4.
///
/// ```
/// use zimm_brownian::{FreeDraining, Mobility};
/// use zimm_core::{Clock, DVec3, Open, Particles, System};
///
/// let particles = Particles::new(vec![DVec3::ZERO; 2])?.with_species(vec![0, 1])?;
/// let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
/// let mut mobility = FreeDraining::new(4.0)?.with_species(&[4.0, 8.0])?;
/// mobility.bind(&system.frame())?;
/// let mut velocities = [DVec3::ZERO; 2];
/// Mobility::<Open>::apply(&mut mobility, &[DVec3::X; 2], &mut velocities);
/// assert_eq!(velocities, [0.25 * DVec3::X, 0.125 * DVec3::X]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct FreeDraining {
    mobilities: Vec<f64>,
    species: Vec<u8>,
}

impl FreeDraining {
    /// The same friction for every bead, whatever its species.
    ///
    /// # Errors
    /// If `friction` is not finite and above zero.
    pub fn new(friction: f64) -> Result<Self, ParameterError> {
        let mobility = ParameterError::positive("friction", friction)?.recip();
        Ok(Self {
            mobilities: vec![mobility],
            species: Vec::new(),
        })
    }

    /// A friction for each species.
    ///
    /// # Errors
    /// If a friction is not finite and above zero, or there is none.
    pub fn with_species(mut self, frictions: &[f64]) -> Result<Self, ParameterError> {
        let check = |&friction: &f64| ParameterError::positive("friction", friction);
        self.mobilities = frictions
            .iter()
            .map(|friction| Ok(check(friction)?.recip()))
            .collect::<Result<_, _>>()?;
        if self.mobilities.is_empty() {
            return Err(ParameterError::new(
                "number of frictions",
                0.0,
                "at least 1",
            ));
        }
        Ok(self)
    }

    #[inline(always)]
    fn mobility(&self, place: usize) -> f64 {
        let species = self.species.get(place).copied().unwrap_or(0);
        self.mobilities[usize::from(species)]
    }
}

impl<B: Boundary> Mobility<B> for FreeDraining {
    const DIAGONAL: bool = true;

    fn bind(&mut self, frame: &Frame<'_, B>) -> Result<(), MobilityError> {
        self.species.clear();
        let known = self.mobilities.len();
        if known == 1 {
            return Ok(());
        }
        let unknown = |&species: &u8| usize::from(species) >= known;
        if let Some(particle) = frame.species.iter().position(unknown) {
            return Err(MobilityError::NoFriction {
                particle,
                species: frame.species[particle],
                known,
            });
        }
        self.species.extend_from_slice(frame.species);
        Ok(())
    }

    fn apply(&mut self, forces: &[DVec3], velocities: &mut [DVec3]) {
        for_each_chunk(velocities, |start, chunk| {
            for (k, u) in chunk.iter_mut().enumerate() {
                *u += self.mobility(start + k) * forces[start + k];
            }
        });
    }

    fn alone(&self, place: usize) -> f64 {
        self.mobility(place)
    }
}

/// The square root of a diagonal matrix: bead by bead.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Diagonal;

impl<B: Boundary> Root<B, FreeDraining> for Diagonal {
    fn add(
        &mut self,
        mobility: &mut FreeDraining,
        white: &White<'_>,
        scale: f64,
        displacements: &mut [DVec3],
    ) -> Result<(), MobilityError> {
        const RUN: usize = 128;
        for_each_chunk(displacements, |start, chunk| {
            let mut noise = [DVec3::ZERO; RUN];
            for (start, run) in (start..).step_by(RUN).zip(chunk.chunks_mut(RUN)) {
                let noise = &mut noise[..run.len()];
                white.beads(start, noise);
                for ((place, displacement), &mut z) in (start..).zip(run).zip(noise) {
                    *displacement += scale * mobility.mobility(place).sqrt() * z;
                }
            }
        });
        Ok(())
    }
}
