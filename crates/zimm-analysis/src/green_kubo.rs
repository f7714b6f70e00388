//! The viscosity from the stress at rest.

use crate::{AnalysisError, Autocorrelation, Mean};
use std::f64::consts::SQRT_2;
use zimm_core::{DMat3, Estimator, ParameterError};

/// The relaxation modulus, the viscosity and the moduli of oscillatory shear from the fluctuations of the stress in
/// equilibrium:
///
/// ```text
/// G(t) = (V / kT) <S(t) : S(0)> / 10,   eta(t) = integral of G from 0 to t by the trapezoidal rule
/// G'(w) = w integral of G(t) sin(w t),   G''(w) = w integral of G(t) cos(w t)
/// ```
///
/// with S the traceless symmetric part of the total stress; S : S / 10 is the average of sigma_xy sigma_xy over all
/// directions of space, and contains the three shear stresses and the three halved normal differences (Daivis and
/// Evans, J. Chem. Phys. 100, 541, 1994). Lags, memory and errors are those of [`Autocorrelation`]: G is averaged a
/// little at long times, eta is exact at all.
///
/// **Noise between pairs** (DPD) is part of the stress and white: push the stress of *every* time step, or its mean
/// over all steps since the last sample. With all items in it, and only then, the integral is the viscosity of the
/// fluid with its thermostat.
///
/// Stresses may come from a running scene or from a file.
///
/// ```
/// use zimm_analysis::GreenKubo;
/// use zimm_core::{DMat3, DVec3, Estimator};
///
/// let mut green_kubo = GreenKubo::new(0.1, 1000.0, 1.0)?;
/// let sigma_xy = DMat3::from_cols(DVec3::Y, DVec3::X, DVec3::ZERO) * 0.05;
/// for _ in 0..8 {
///     green_kubo.push(sigma_xy);
/// }
/// let relaxation = green_kubo.estimate()?;
/// assert_eq!(relaxation.times, [0.0, 0.1, 0.2]);
/// assert!((relaxation.modulus[1].value - 1000.0 * 2.0 * 0.0025 / 10.0).abs() < 1e-12);
/// assert!((relaxation.viscosity[2].value - 0.2 * 0.5).abs() < 1e-12);
/// assert_eq!(green_kubo.viscosity(0.2)?.value, relaxation.viscosity[2].value);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct GreenKubo {
    scale: f64,
    stress: Autocorrelation<[f64; 6]>,
}

/// What the stress at rest says of flow. The lists have one entry a lag, from zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Relaxation {
    /// The lag times.
    pub times: Vec<f64>,
    /// The relaxation modulus G(t). At zero it holds the white noise of the stress, if there is some.
    pub modulus: Vec<Mean>,
    /// The integral of the modulus up to each time; the viscosity once it has levelled off.
    pub viscosity: Vec<Mean>,
}

/// The moduli of small oscillatory shear at one angular frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moduli {
    /// The angular frequency.
    pub frequency: f64,
    /// The storage modulus G'.
    pub storage: Mean,
    /// The loss modulus G''.
    pub loss: Mean,
}

/// The traceless symmetric part of a tensor, in components whose products add up to the full contraction.
fn deviator(m: DMat3) -> [f64; 6] {
    let mean = (m.x_axis.x + m.y_axis.y + m.z_axis.z) / 3.0;
    let shear = |a: f64, b: f64| (a + b) / SQRT_2;
    [
        m.x_axis.x - mean,
        m.y_axis.y - mean,
        m.z_axis.z - mean,
        shear(m.y_axis.x, m.x_axis.y),
        shear(m.z_axis.y, m.y_axis.z),
        shear(m.x_axis.z, m.z_axis.x),
    ]
}

impl GreenKubo {
    /// Stresses come at this interval of time, from a cell of this volume at this thermal energy.
    ///
    /// # Errors
    /// If a parameter is not above zero.
    pub fn new(interval: f64, volume: f64, kt: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            scale: ParameterError::positive("volume", volume)?
                / (10.0 * ParameterError::positive("kt", kt)?),
            stress: Autocorrelation::new(interval)?,
        })
    }

    /// Number of samples.
    pub fn samples(&self) -> u64 {
        self.stress.samples()
    }

    /// The viscosity, if the modulus has decayed by a time: the integral up to the first lag at or beyond it.
    ///
    /// # Errors
    /// If the run is shorter than four times that time, or a stress is not finite.
    pub fn viscosity(&self, until: f64) -> Result<Mean, AnalysisError> {
        Ok(self.stress.integral(until)?.times(self.scale))
    }

    /// The moduli of oscillatory shear at these angular frequencies, if the modulus has decayed by a time. Frequencies
    /// should be well below one over the interval, or the modulus is not resolved.
    ///
    /// # Errors
    /// As [`viscosity`](Self::viscosity).
    pub fn moduli(&self, frequencies: &[f64], until: f64) -> Result<Vec<Moduli>, AnalysisError> {
        let transform = self.stress.transform(frequencies, until)?;
        let moduli = |(&frequency, [cosine, sine]): (&f64, [Mean; 2])| Moduli {
            frequency,
            storage: sine.times(frequency * self.scale),
            loss: cosine.times(frequency * self.scale),
        };
        Ok(frequencies.iter().zip(transform).map(moduli).collect())
    }
}

impl Estimator for GreenKubo {
    type Sample = DMat3;
    type Estimate = Result<Relaxation, AnalysisError>;

    fn push(&mut self, stress: DMat3) {
        self.stress.push(deviator(stress));
    }

    fn estimate(&self) -> Self::Estimate {
        let decay = self.stress.estimate()?;
        let scaled = |means: Vec<Mean>| means.into_iter().map(|m| m.times(self.scale)).collect();
        Ok(Relaxation {
            times: decay.times,
            modulus: scaled(decay.correlation),
            viscosity: scaled(decay.integral),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Random;
    use zimm_core::DVec3;

    fn symmetric(diagonal: DVec3, shear: DVec3) -> DMat3 {
        DMat3::from_cols(
            DVec3::new(diagonal.x, shear.x, shear.z),
            DVec3::new(shear.x, diagonal.y, shear.y),
            DVec3::new(shear.z, shear.y, diagonal.z),
        )
    }

    fn contract(a: [f64; 6], b: [f64; 6]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    #[test]
    fn law_the_contraction_does_not_depend_on_axes_or_pressure() {
        let mut random = Random::new(80);
        let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 2.0) / 3.0, 0.7);
        let [a, b] = [(); 2].map(|()| symmetric(random.normal3(), random.normal3()));
        let turned = [a, b].map(|m| turn * m * turn.transpose() + DMat3::IDENTITY * 3.0);
        let (plain, turned) = (
            contract(deviator(a), deviator(b)),
            contract(deviator(turned[0]), deviator(turned[1])),
        );
        approx::assert_relative_eq!(plain, turned, max_relative = 1e-12);
    }

    // An isotropic stress of Ornstein-Uhlenbeck processes under a pressure of 20: shear stresses of variance v = 0.6,
    // diagonal ones of 2 v, relaxing as phi^k, and white noise of variance w = 0.5 in every step. Then V v / kT phi^k
    // is G, and the trapezoidal sum to lag K is (V / kT) dt (w / 2 + v (1/2 + sum_1^(K-1) phi^k + phi^K / 2)). Seed
    // 81, 200 000 samples. Each estimate comes with its error, which must be below 1 % (2.5 % to lag 60): bound 4 of
    // them; a missing factor 1/2 of the noise changes the integral to lag 10 by 7 %, a wrong weight of a component by
    // 7 % or more.
    #[test]
    fn limit_relaxation_of_a_synthetic_stress() {
        let (interval, volume, kt) = (0.02, 50.0, 1.4);
        let (variance, white, phi) = (0.6_f64, 0.5_f64, 0.9_f64);
        let mut green_kubo = GreenKubo::new(interval, volume, kt).unwrap();
        let mut random = Random::new(81);
        let (mut diagonal, mut shear) = (random.normal3(), random.normal3());
        let innovation = (1.0 - phi * phi).sqrt();
        let (width, noise, two) = (variance.sqrt(), white.sqrt(), 2.0_f64.sqrt());
        for _ in 0..200_000 {
            diagonal = phi * diagonal + innovation * random.normal3();
            shear = phi * shear + innovation * random.normal3();
            let slow = symmetric(two * width * diagonal, width * shear);
            let fast = symmetric(two * noise * random.normal3(), noise * random.normal3());
            green_kubo.push(slow + fast - DMat3::IDENTITY * 20.0);
        }
        let found = green_kubo.estimate().unwrap();
        let holds = |mean: Mean, exact: f64, precision: f64| {
            let error = mean.at_least();
            assert!(error < precision * exact, "{mean}");
            assert!(
                (mean.value - exact).abs() < 4.0 * error,
                "{mean} against {exact}"
            );
        };
        let unit = volume / kt;
        holds(found.modulus[0], unit * (variance + white), 0.005);
        holds(found.modulus[5], unit * variance * phi.powi(5), 0.01);
        for (last, precision) in [(10, 0.01), (60, 0.025)] {
            let inner: f64 = (1..last).map(|k| phi.powi(k)).sum();
            let sum = 0.5 * white + variance * (0.5 + inner + 0.5 * phi.powi(last));
            let viscosity = green_kubo.viscosity(f64::from(last) * interval);
            holds(viscosity.unwrap(), unit * interval * sum, precision);
        }
        assert_eq!(found.viscosity[0].value, 0.0);
        // Moduli of the relaxing part, taken as linear between samples, and of half a sample of the white one, at a
        // frequency of half the relaxation rate: 1/5 and 2/5 of V v / kT, and G'' of the white one.
        let rate = -phi.ln() / interval;
        let modulus = green_kubo.moduli(&[0.5 * rate], 100.0 * interval).unwrap()[0];
        holds(modulus.storage, unit * variance / 5.0, 0.05);
        let loss = 0.4 * variance + 0.25 * rate * interval * white;
        holds(modulus.loss, unit * loss, 0.05);
    }

    #[test]
    fn extreme_too_few_samples_and_bad_parameters_are_errors() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(GreenKubo::new(bad, 1.0, 1.0).is_err());
            assert!(GreenKubo::new(0.1, bad, 1.0).is_err());
            assert!(GreenKubo::new(0.1, 1.0, bad).is_err());
        }
        let mut green_kubo = GreenKubo::new(0.1, 1.0, 1.0).unwrap();
        for found in 0..2 {
            let (what, needed) = ("samples", 2);
            assert_eq!(
                green_kubo.estimate(),
                Err(AnalysisError::TooFew {
                    what,
                    found,
                    needed
                })
            );
            green_kubo.push(DMat3::IDENTITY);
        }
        assert_eq!(green_kubo.estimate().unwrap().times, [0.0]);
        assert!(green_kubo.viscosity(0.1).is_err());
        assert!(green_kubo.moduli(&[1.0], 0.1).is_err());
        green_kubo.push(DMat3::IDENTITY * f64::NAN);
        assert!(matches!(
            green_kubo.estimate(),
            Err(AnalysisError::NotFinite { .. })
        ));
    }
}
