//! The two ways to name a planar flow.

/// The shear rate and the extension rate of a planar mixed flow, u = (extension_rate x + shear_rate y,
/// -extension_rate y, 0), in inverse time.
///
/// The same flow, seen from axes turned by atan(sqrt(chi)), is Gamma [[0, 1], [chi, 0]] (Fuller and Leal 1981), with
/// the strain rate Gamma and the mixedness chi:
///
/// ```text
/// extension_rate = Gamma sqrt(chi)     shear_rate = Gamma (1 - chi)
/// ```
///
/// ```
/// use zimm_boundary::MixedRates;
///
/// let rates = MixedRates { shear_rate: 3.0, extension_rate: 0.7 };
/// assert!((rates.mixedness() - 0.049217).abs() < 1e-6);
/// assert!((rates.strain_rate() - 3.155295).abs() < 1e-6);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MixedRates {
    /// Velocity along x per length along y.
    pub shear_rate: f64,
    /// Velocity along x per length along x.
    pub extension_rate: f64,
}

impl MixedRates {
    /// From the strain rate Gamma and the mixedness chi, between 0 and 1.
    pub fn from_strain_rate(strain_rate: f64, mixedness: f64) -> Self {
        Self {
            shear_rate: strain_rate * (1.0 - mixedness),
            extension_rate: strain_rate * mixedness.sqrt(),
        }
    }

    /// The mixedness chi: 0 in shear, 1 in extension, whatever the signs of the rates.
    pub fn mixedness(&self) -> f64 {
        let [shear, extension] = [self.shear_rate, self.extension_rate].map(f64::abs);
        let root = 2.0 * extension / (shear + libm::hypot(shear, 2.0 * extension));
        root * root
    }

    /// The strain rate Gamma, not below zero.
    pub fn strain_rate(&self) -> f64 {
        libm::hypot(self.shear_rate, 2.0 * self.extension_rate) / (1.0 + self.mixedness())
    }
}
