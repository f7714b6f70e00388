//! The same force on every particle.

use zimm_core::{Boundary, DVec3, ForceError, ForceField, Frame, ParameterError, Reads, Tally};

/// The same force on every particle: gravity for equal masses, or a pressure gradient between walls.
///
/// The total momentum grows. Body forces act between no pair, so tallies do not hear of them.
///
/// ```
/// use zimm_core::{Clock, DVec3, ForceField, Open, Particles, System};
/// use zimm_forces::ConstantForce;
///
/// let particles = Particles::new(vec![DVec3::ZERO, DVec3::ONE])?;
/// let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
/// let mut forces = vec![DVec3::ZERO; 2];
/// ConstantForce::new(DVec3::X)?.accumulate(&system.frame(), &mut forces, &mut ())?;
/// assert_eq!(forces, [DVec3::X, DVec3::X]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstantForce {
    force: DVec3,
}

impl ConstantForce {
    /// This force on each particle.
    ///
    /// # Errors
    /// If a component is not finite.
    pub fn new(force: DVec3) -> Result<Self, ParameterError> {
        ParameterError::finite("x component of the force", force.x)?;
        ParameterError::finite("y component of the force", force.y)?;
        ParameterError::finite("z component of the force", force.z)?;
        Ok(Self { force })
    }
}

impl<B: Boundary> ForceField<B> for ConstantForce {
    const READS: Reads = Reads::NOTHING;
    const CONSERVES_MOMENTUM: bool = false;

    fn accumulate<T: Tally>(
        &mut self,
        _: &Frame<'_, B>,
        forces: &mut [DVec3],
        _: &mut T,
    ) -> Result<(), ForceError> {
        for force in forces {
            *force += self.force;
        }
        Ok(())
    }
}
