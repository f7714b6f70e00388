use super::ShearHistory;
use zimm_core::ParameterError;

/// Shear at a constant rate, always: strain = rate t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steady {
    rate: f64,
}

impl Steady {
    /// Shear at `shear_rate`, in inverse time; of either sign.
    ///
    /// # Errors
    /// If the rate is not finite.
    pub fn new(shear_rate: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            rate: ParameterError::finite("shear rate", shear_rate)?,
        })
    }
}

impl ShearHistory for Steady {
    fn strain(&self, time: f64) -> f64 {
        self.rate * time
    }

    fn rate(&self, _: f64) -> f64 {
        self.rate
    }
}
