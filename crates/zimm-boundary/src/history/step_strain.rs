use super::FlowHistory;
use zimm_core::ParameterError;

/// Rest, a sudden strain just after the time `at`, rest again.
///
/// The rate is zero throughout, so nothing streams and the gradient never shows the jump. The deformation between two
/// times does: the one step that contains the jump displaces every particle and the lattice by exp(strain K), as one.
/// SLLOD dynamics, integrated through the pulse, also carries peculiar velocities by the inverse; a stepper that moves
/// velocities by the deformation does so, one that moves them by the gradient leaves them alone. A step
/// that begins at `at` contains the jump, so a jump at time zero falls into the first step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepStrain {
    strain: f64,
    at: f64,
}

impl StepStrain {
    /// A jump by `strain` just after the time `at`.
    ///
    /// # Errors
    /// If the strain or the time is not finite.
    pub fn new(strain: f64, at: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            strain: ParameterError::finite("strain", strain)?,
            at: ParameterError::finite("time of step", at)?,
        })
    }
}

impl FlowHistory for StepStrain {
    fn strain(&self, time: f64) -> f64 {
        if time > self.at { self.strain } else { 0.0 }
    }

    fn rate(&self, _: f64) -> f64 {
        0.0
    }
}
