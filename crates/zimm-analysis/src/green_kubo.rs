//! The viscosity from the stress at rest.

use crate::{AnalysisError, BlockAverages, Mean};
use std::collections::VecDeque;
use zimm_core::{DMat3, DVec3, Estimator, ParameterError};

/// The relaxation modulus and the viscosity from the fluctuations of the stress in equilibrium:
///
/// ```text
/// G(t) = (V / kT) <S(t) : S(0)> / 10,   eta(t) = integral of G from 0 to t by the trapezoidal rule
/// ```
///
/// with S the traceless symmetric part of the total stress; S : S / 10 is the average of sigma_xy sigma_xy over all
/// directions of space, and contains the three shear stresses and the three halved normal differences (Daivis and
/// Evans, J. Chem. Phys. 100, 541, 1994). Each sample is the end of all lags; the running integral is computed
/// for each, so that its error, from block averages over samples, knows of all correlations between lags.
///
/// **Noise between pairs** (DPD) is part of the stress and white: push the stress of *every* time step, or its mean
/// over all steps since the last sample. With all items in it, and only then, the integral is the viscosity of the
/// fluid with its thermostat.
///
/// ```
/// use zimm_analysis::GreenKubo;
/// use zimm_core::{DMat3, DVec3, Estimator};
///
/// let mut green_kubo = GreenKubo::new(0.1, 2, 1000.0, 1.0)?;
/// let sigma_xy = DMat3::from_cols(DVec3::Y, DVec3::X, DVec3::ZERO) * 0.05;
/// for _ in 0..5 {
///     green_kubo.push(sigma_xy);
/// }
/// let relaxation = green_kubo.estimate()?;
/// assert_eq!(relaxation.times, [0.0, 0.1, 0.2]);
/// assert!((relaxation.modulus[1].value - 1000.0 * 2.0 * 0.0025 / 10.0).abs() < 1e-12);
/// assert!((relaxation.viscosity[2].value - 0.2 * 0.5).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct GreenKubo {
    interval: f64,
    lags: usize,
    scale: f64,
    history: VecDeque<Deviator>,
    modulus: BlockAverages,
    viscosity: BlockAverages,
    samples: u64,
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

/// A traceless symmetric tensor: its diagonal and, each counted once, its off-diagonal elements.
#[derive(Clone, Copy, Debug)]
struct Deviator {
    diagonal: DVec3,
    shear: DVec3,
}

impl Deviator {
    fn of(m: DMat3) -> Self {
        let diagonal = DVec3::new(m.x_axis.x, m.y_axis.y, m.z_axis.z);
        let shear = DVec3::new(
            m.y_axis.x + m.x_axis.y,
            m.z_axis.y + m.y_axis.z,
            m.x_axis.z + m.z_axis.x,
        ) * 0.5;
        Self {
            diagonal: diagonal - diagonal.element_sum() / 3.0,
            shear,
        }
    }

    /// Full contraction of two tensors.
    fn contract(&self, other: &Self) -> f64 {
        self.diagonal.dot(other.diagonal) + 2.0 * self.shear.dot(other.shear)
    }
}

impl GreenKubo {
    /// Stresses come at this interval of time, from a cell of this volume at this thermal energy; correlations are
    /// kept for lags of 0 to `lags` intervals. Each sample costs as many steps of work.
    ///
    /// # Errors
    /// If a parameter is not above zero.
    pub fn new(interval: f64, lags: usize, volume: f64, kt: f64) -> Result<Self, ParameterError> {
        ParameterError::positive("lags", lags as f64)?;
        Ok(Self {
            interval: ParameterError::positive("interval", interval)?,
            lags,
            scale: ParameterError::positive("volume", volume)?
                / (10.0 * ParameterError::positive("kt", kt)?),
            history: VecDeque::with_capacity(lags + 1),
            modulus: BlockAverages::new(lags + 1),
            viscosity: BlockAverages::new(lags + 1),
            samples: 0,
        })
    }
}

impl Estimator for GreenKubo {
    type Sample = DMat3;
    type Estimate = Result<Relaxation, AnalysisError>;

    fn push(&mut self, stress: DMat3) {
        let now = Deviator::of(stress);
        self.samples += 1;
        self.history.push_back(now);
        if self.history.len() <= self.lags {
            return;
        }
        let backwards = self.history.iter().rev();
        let modulus: Vec<f64> = backwards
            .map(|then| self.scale * now.contract(then))
            .collect();
        let mut integral = 0.0;
        let mut viscosity = vec![0.0];
        for (before, after) in modulus.iter().zip(modulus.iter().skip(1)) {
            integral += 0.5 * self.interval * (before + after);
            viscosity.push(integral);
        }
        self.modulus.take(&modulus);
        self.viscosity.take(&viscosity);
        self.history.pop_front();
    }

    fn estimate(&self) -> Self::Estimate {
        let needed = self.lags as u64 + 2;
        if self.samples < needed {
            return Err(AnalysisError::TooFew {
                what: "samples",
                found: self.samples,
                needed,
            });
        }
        Ok(Relaxation {
            times: (0..=self.lags).map(|k| k as f64 * self.interval).collect(),
            modulus: self.modulus.estimate()?,
            viscosity: self.viscosity.estimate()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Random;

    fn symmetric(diagonal: DVec3, shear: DVec3) -> DMat3 {
        DMat3::from_cols(
            DVec3::new(diagonal.x, shear.x, shear.z),
            DVec3::new(shear.x, diagonal.y, shear.y),
            DVec3::new(shear.z, shear.y, diagonal.z),
        )
    }

    #[test]
    fn law_the_contraction_does_not_depend_on_axes_or_pressure() {
        let mut random = Random::new(80);
        let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 2.0) / 3.0, 0.7);
        let [a, b] = [(); 2].map(|()| symmetric(random.normal3(), random.normal3()));
        let turned = [a, b].map(|m| turn * m * turn.transpose() + DMat3::IDENTITY * 3.0);
        let (plain, turned) = (
            Deviator::of(a).contract(&Deviator::of(b)),
            Deviator::of(turned[0]).contract(&Deviator::of(turned[1])),
        );
        approx::assert_relative_eq!(plain, turned, max_relative = 1e-12);
    }

    // An isotropic stress of Ornstein-Uhlenbeck processes under a pressure of 20: shear stresses of variance v = 0.6,
    // diagonal ones of 2 v, relaxing as phi^k, and white noise of variance w = 0.5 in every step. Then V v / kT phi^k
    // is G, and the trapezoidal sum to lag K is (V / kT) dt (w / 2 + v (1/2 + sum_1^(K-1) phi^k + phi^K / 2)). Seed 81,
    // 200 000 samples. Each estimate comes with its error, which must be below 1 % (2.5 % to lag 60): bound 4 of them;
    // a missing factor 1/2 of the noise changes the integral to lag 10 by 7 %, a wrong weight of a component by 7 % or
    // more.
    #[test]
    fn limit_relaxation_of_a_synthetic_stress() {
        let (interval, lags, volume, kt) = (0.02, 60, 50.0, 1.4);
        let (variance, white, phi) = (0.6_f64, 0.5_f64, 0.9_f64);
        let mut green_kubo = GreenKubo::new(interval, lags, volume, kt).unwrap();
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
            holds(
                found.viscosity[last as usize],
                unit * interval * sum,
                precision,
            );
        }
        assert_eq!((found.viscosity[0].value, found.times.len()), (0.0, 61));
    }

    #[test]
    fn extreme_too_few_samples_and_bad_parameters_are_errors() {
        assert!(GreenKubo::new(0.1, 0, 1.0, 1.0).is_err());
        assert!(GreenKubo::new(0.1, 3, 0.0, 1.0).is_err());
        assert!(GreenKubo::new(0.1, 3, 1.0, 0.0).is_err());
        let mut green_kubo = GreenKubo::new(0.1, 3, 1.0, 1.0).unwrap();
        for found in 0..5 {
            let (what, needed) = ("samples", 5);
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
        assert!(green_kubo.estimate().is_ok());
        green_kubo.push(DMat3::IDENTITY * f64::NAN);
        assert!(matches!(
            green_kubo.estimate(),
            Err(AnalysisError::NotFinite { .. })
        ));
    }
}
