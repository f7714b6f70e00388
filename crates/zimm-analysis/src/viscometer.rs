//! Material functions of steady shear.

use crate::stress::viscometric;
use crate::{AnalysisError, BlockAverage, Mean};
use zimm_core::{DMat3, Estimator, ParameterError};

/// Averages a stress in steady shear u = rate y e_x into its material functions.
///
/// Push the total stress, one item of it, or the polymer's part of it: each gives its share of the functions.
///
/// ```
/// use zimm_analysis::Viscometer;
/// use zimm_core::{DMat3, DVec3, Estimator};
///
/// let mut viscometer = Viscometer::new(0.5)?;
/// let stress = DMat3::from_cols(DVec3::new(3.0, 2.0, 0.0), DVec3::new(2.0, 1.0, 0.0), DVec3::new(0.0, 0.0, 1.5));
/// viscometer.push(stress);
/// viscometer.push(stress);
/// let functions = viscometer.estimate()?;
/// assert_eq!((functions.viscosity.value, functions.psi1.value, functions.psi2.value), (4.0, 8.0, -2.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Viscometer {
    rate: f64,
    averages: [BlockAverage; 3],
}

impl Viscometer {
    /// A viscometer for this shear rate.
    ///
    /// # Errors
    /// If the rate is zero or not finite.
    pub fn new(rate: f64) -> Result<Self, ParameterError> {
        ParameterError::positive("magnitude of the shear rate", rate.abs())?;
        Ok(Self {
            rate,
            averages: Default::default(),
        })
    }

    /// The means of sigma_xy, sigma_xx - sigma_yy and sigma_yy - sigma_zz.
    ///
    /// # Errors
    /// If there are fewer than two samples, or one is not finite.
    pub fn stresses(&self) -> Result<[Mean; 3], AnalysisError> {
        let [shear, first, second] = &self.averages;
        Ok([shear.estimate()?, first.estimate()?, second.estimate()?])
    }
}

impl Estimator for Viscometer {
    type Sample = DMat3;
    type Estimate = Result<ShearFunctions, AnalysisError>;

    fn push(&mut self, stress: DMat3) {
        for (average, x) in self.averages.iter_mut().zip(viscometric(stress)) {
            average.push(x);
        }
    }

    fn estimate(&self) -> Self::Estimate {
        let [shear, first, second] = self.stresses()?;
        let per_rate = self.rate.recip();
        Ok(ShearFunctions {
            viscosity: shear.times(per_rate),
            psi1: first.times(per_rate * per_rate),
            psi2: second.times(per_rate * per_rate),
        })
    }
}

/// The material functions of steady shear, from stresses with tension positive:
///
/// ```text
/// eta = sigma_xy / rate,   Psi_1 = (sigma_xx - sigma_yy) / rate^2,   Psi_2 = (sigma_yy - sigma_zz) / rate^2
/// ```
///
/// (Bird, Armstrong and Hassager 1987, sec. 3.3, who count compression positive and write a minus sign.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShearFunctions {
    /// Viscosity.
    pub viscosity: Mean,
    /// First normal stress coefficient.
    pub psi1: Mean,
    /// Second normal stress coefficient.
    pub psi2: Mean,
}

impl ShearFunctions {
    /// What the polymer adds: these functions of a solution less those of its solvent, from a run of its own at the
    /// same rate. Errors add in quadrature.
    pub fn minus_solvent(&self, solvent: &Self) -> Self {
        Self {
            viscosity: self.viscosity.minus_independent(solvent.viscosity),
            psi1: self.psi1.minus_independent(solvent.psi1),
            psi2: self.psi2.minus_independent(solvent.psi2),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Stress;
    use crate::scene::{Cell, Hooke, Random, at};
    use zimm_core::{Bonded, DVec3, ForceField, Observable, Virial};

    #[test]
    fn law_the_rate_carries_its_sign() {
        let stress = DMat3::from_cols(DVec3::X, DVec3::new(-1.0, 0.0, 0.0), DVec3::ZERO);
        let mut viscometer = Viscometer::new(-0.5).unwrap();
        viscometer.push(stress);
        viscometer.push(stress);
        let functions = viscometer.estimate().unwrap();
        assert_eq!(
            (functions.viscosity.value, functions.psi1.value),
            (1.0, 4.0)
        );
    }

    // Hookean dumbbells in steady shear, their Gaussian connectors sampled exactly (Bird et al. 1987, sec. 13.4), in
    // units of l_H, lambda_H, kT: eta_p = n, Psi_1 = 2 n, Psi_2 = 0 through Bonded, Virial, Stress and Kramers. Seed 7,
    // 400 frames of 100 dumbbells at rate 2. Standard errors for 40 000 dumbbells: var(QxQy) = 1 + 2 4 + 4 = 13 over
    // rate: 0.9 % of eta; var(QxQx - QyQy) = 2 (81 + 1 - 2 4) = 148: 3 % of rate^2 n, 1.5 % of Psi_1; Psi_2 0.25 %
    // of n. Bounds 4 sigma; a factor of 2, a sign or a lost half in any of them is caught, as is 4 % in eta.
    #[test]
    fn limit_hookean_dumbbells_in_shear() {
        let (n, rate, edge) = (100, 2.0, 60.0);
        let (mut random, mut viscometer) = (Random::new(7), Viscometer::new(rate).unwrap());
        for _ in 0..400 {
            let mut positions = Vec::new();
            for _ in 0..n {
                let (r, z) = (random.within(DMat3::IDENTITY * edge), random.normal3());
                let q = DVec3::new(rate * z.y + (1.0 + rate * rate).sqrt() * z.x, z.y, z.z);
                positions.extend([r, r + q]);
            }
            let system = at(Cell::lees_edwards(DVec3::splat(edge), 17.0), positions);
            let mut virial = Virial::default();
            Bonded::new(
                Hooke(1.0),
                (0..n as u32).map(|k| [2 * k, 2 * k + 1]).collect(),
            )
            .accumulate(&system.frame(), &mut vec![DVec3::ZERO; 2 * n], &mut virial)
            .unwrap();
            viscometer.push(Stress.measure(&system.frame(), &virial).kramers(n, 1.0));
        }
        let density = n as f64 / edge.powi(3);
        let found = viscometer.estimate().unwrap();
        assert!(
            (found.viscosity.value / density - 1.0).abs() < 0.036,
            "{}",
            found.viscosity
        );
        assert!(
            (found.psi1.value / density - 2.0).abs() < 0.12,
            "{}",
            found.psi1
        );
        assert!((found.psi2.value / density).abs() < 0.014, "{}", found.psi2);
        let error = found.viscosity.standard_error().unwrap() / density;
        assert!((error / 0.009 - 1.0).abs() < 0.6, "{error}");
    }

    #[test]
    fn law_the_solvent_is_taken_off() {
        let mean = |value| {
            let error = crate::StandardError::Plateau {
                error: 0.3,
                uncertainty: 0.0,
            };
            Mean { value, error }
        };
        let functions = |x| ShearFunctions {
            viscosity: mean(x),
            psi1: mean(2.0 * x),
            psi2: mean(-x),
        };
        let polymer = functions(3.0).minus_solvent(&functions(1.0));
        assert_eq!(
            (
                polymer.viscosity.value,
                polymer.psi1.value,
                polymer.psi2.value
            ),
            (2.0, 4.0, -2.0)
        );
        approx::assert_relative_eq!(polymer.psi1.at_least(), 0.3 * 2.0_f64.sqrt());
    }

    #[test]
    fn extreme_no_rate_and_no_samples_are_errors() {
        for rate in [0.0, f64::NAN, f64::INFINITY] {
            assert!(Viscometer::new(rate).is_err());
        }
        let viscometer = Viscometer::new(0.1).unwrap();
        assert!(matches!(
            viscometer.estimate(),
            Err(AnalysisError::TooFew { found: 0, .. })
        ));
    }
}
