//! A force on some particles, and its opposite on all others.

use std::ops::Range;
use zimm_core::{Boundary, DVec3, ForceError, ForceField, Frame, ParameterError, Reads, Tally};

/// A force on each particle of a range of identities, whose opposite all others share: what it takes to pull a bead, or
/// one species, through a fluid that stays where it is.
///
/// A bead that is pulled by F drifts at `v = F D / kT`, with D its diffusion coefficient in the same cell, which is one way
/// to its drag (Clarke, PhD thesis, MIT 2008, section 4.2.4). The same holds for any number of them, if they are alike and
/// F is small enough not to part them from the others: then n beads tell it as well as one does in n times the time.
///
/// The total momentum stays. Body forces act between no pair, so tallies do not hear of them.
///
/// ```
/// use zimm_core::{Clock, DVec3, ForceField, Open, Particles, System};
/// use zimm_forces::Pulled;
///
/// let particles = Particles::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y])?;
/// let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
/// let mut forces = vec![DVec3::ZERO; 3];
/// Pulled::new(2.0 * DVec3::X, 0..1)?.accumulate(&system.frame(), &mut forces, &mut ())?;
/// assert_eq!(forces, [2.0 * DVec3::X, -DVec3::X, -DVec3::X]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Pulled {
    force: DVec3,
    identities: Range<u32>,
}

impl Pulled {
    /// This force on each particle of these identities.
    ///
    /// A step is an error if they are none or all of the particles ([`ForceError::NoneOrAll`]).
    ///
    /// # Errors
    /// If a component is not finite.
    pub fn new(force: DVec3, identities: Range<u32>) -> Result<Self, ParameterError> {
        ParameterError::finite("x component of the force", force.x)?;
        ParameterError::finite("y component of the force", force.y)?;
        ParameterError::finite("z component of the force", force.z)?;
        Ok(Self { force, identities })
    }
}

impl<B: Boundary> ForceField<B> for Pulled {
    const READS: Reads = Reads::NOTHING;
    const CONSERVES_MOMENTUM: bool = true;

    fn accumulate<T: Tally>(
        &mut self,
        frame: &Frame<'_, B>,
        forces: &mut [DVec3],
        _: &mut T,
    ) -> Result<(), ForceError> {
        let Range { start, end } = self.identities;
        let particles = frame.len();
        let pulled = particles.min(end as usize).saturating_sub(start as usize);
        if pulled == 0 || pulled == particles {
            return Err(ForceError::NoneOrAll {
                start,
                end,
                particles,
            });
        }
        let opposite = -(pulled as f64 / (particles - pulled) as f64) * self.force;
        for (place, force) in forces.iter_mut().enumerate() {
            let is_pulled = self.identities.contains(&frame.id(place));
            *force += if is_pulled { self.force } else { opposite };
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use zimm_core::{Clock, Open, Particles, System};

    fn forces(count: usize, identities: Range<u32>) -> Result<Vec<DVec3>, ForceError> {
        let positions = (0..count).map(|k| k as f64 * DVec3::X).collect();
        let mut particles = Particles::new(positions).unwrap();
        let order: Vec<u32> = (0..count as u32).rev().collect();
        particles.permute(&order).unwrap();
        let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1).unwrap());
        let mut forces = vec![DVec3::ZERO; count];
        let mut pulled = Pulled::new(DVec3::new(3.0, -1.0, 2.0), identities).unwrap();
        pulled.accumulate(&system.frame(), &mut forces, &mut ())?;
        Ok(forces)
    }

    /// By identity, wherever particles are.
    #[test]
    fn law_forces_balance() {
        for (count, identities) in [(7, 2..4), (7, 0..6), (2, 1..9), (1000, 0..1)] {
            let found = forces(count, identities.clone()).unwrap();
            assert!(found.iter().sum::<DVec3>().length() < 1e-12);
            for (place, force) in found.iter().rev().enumerate() {
                let is_pulled = identities.contains(&(place as u32));
                assert_eq!(*force == DVec3::new(3.0, -1.0, 2.0), is_pulled);
            }
        }
    }

    #[test]
    fn extreme_nobody_to_pull_or_nobody_to_hold() {
        for (count, identities) in [(3, 0..3), (3, 3..5), (3, 1..1), (0, 0..1), (3, 0..u32::MAX)] {
            let (start, end) = (identities.start, identities.end);
            let expected = ForceError::NoneOrAll {
                start,
                end,
                particles: count,
            };
            assert_eq!(forces(count, identities), Err(expected));
        }
        assert!(Pulled::new(DVec3::new(0.0, f64::NAN, 0.0), 0..1).is_err());
    }
}
