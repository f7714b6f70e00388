use super::FlowHistory;
use zimm_core::ParameterError;

/// A flow to and fro: strain = amplitude sin(omega t), rate = amplitude omega cos(omega t).
///
/// The phase is good to 1e-16 of omega t. The bits are the same on all platforms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillation {
    amplitude: f64,
    omega: f64,
}

impl Oscillation {
    /// Flow of a strain amplitude and an angular frequency, in radians per time.
    ///
    /// # Errors
    /// If the amplitude is not finite, the frequency is not above zero, or their product overflows.
    pub fn new(strain_amplitude: f64, angular_frequency: f64) -> Result<Self, ParameterError> {
        let amplitude = ParameterError::finite("strain amplitude", strain_amplitude)?;
        let omega = ParameterError::positive("angular frequency", angular_frequency)?;
        ParameterError::finite("largest rate", amplitude * omega)?;
        Ok(Self { amplitude, omega })
    }
}

impl FlowHistory for Oscillation {
    fn strain(&self, time: f64) -> f64 {
        self.amplitude * libm::sin(self.omega * time)
    }

    fn rate(&self, time: f64) -> f64 {
        self.amplitude * self.omega * libm::cos(self.omega * time)
    }
}
