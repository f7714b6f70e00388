//! Schemes in time.

use crate::{Boundary, ForceField, StepError, System, Tally};

/// One step of one scheme.
pub trait Stepper<B: Boundary, F: ForceField<B>> {
    /// Moves the system forward by one time step; the tally hears of the forces at the new positions.
    ///
    /// # Errors
    /// If the step cannot be taken. The system is then as it was before.
    fn step<T: Tally>(
        &mut self,
        system: &mut System<B>,
        field: &mut F,
        tally: &mut T,
    ) -> Result<(), StepError>;
}

/// Time stands still: the null stepper.
impl<B: Boundary, F: ForceField<B>> Stepper<B, F> for () {
    fn step<T: Tally>(&mut self, _: &mut System<B>, _: &mut F, _: &mut T) -> Result<(), StepError> {
        Ok(())
    }
}
