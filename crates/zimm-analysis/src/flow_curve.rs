//! Laws of shear thinning.

use crate::{AnalysisError, Mean, PolynomialFit, ShearFunctions, StandardError, minimum};
use zimm_core::ParameterError;

/// The material functions at one shear rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowPoint {
    /// Shear rate.
    pub rate: Mean,
    /// Shear stress.
    pub stress: Mean,
    /// Viscosity and normal stress coefficients.
    pub functions: ShearFunctions,
}

impl FlowPoint {
    /// What a viscometer found at a rate that it was told.
    pub fn at(rate: f64, functions: ShearFunctions) -> Self {
        let exact = StandardError::Plateau {
            error: 0.0,
            uncertainty: 0.0,
        };
        Self {
            rate: Mean {
                value: rate,
                error: exact,
            },
            stress: functions.viscosity.times(rate),
            functions,
        }
    }
}

/// `tau = kappa rate^p`, Ostwald and de Waele.
///
/// ```
/// use zimm_analysis::{FlowPoint, Mean, PowerLaw, ShearFunctions, StandardError};
///
/// let mean = |value: f64| Mean { value, error: StandardError::AtLeast(0.1 * value) };
/// let point = |rate: f64| {
///     let [viscosity, psi1, psi2] = [mean(3.0 * rate.powf(-0.3)), mean(1.0), mean(-0.1)];
///     FlowPoint::at(rate, ShearFunctions { viscosity, psi1, psi2 })
/// };
/// let law = PowerLaw::fit(&[point(1.0), point(2.0), point(4.0)])?;
/// assert!((law.exponent - 0.7).abs() < 1e-12 && (law.consistency - 3.0).abs() < 1e-12);
/// # Ok::<(), zimm_analysis::AnalysisError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerLaw {
    /// Stress at a rate of one.
    pub consistency: f64,
    /// The exponent p; the slope of log viscosity against log rate is p - 1.
    pub exponent: f64,
}

impl PowerLaw {
    /// The line through the logarithms, weighted by the errors of the viscosities. Give it the range of rates in which
    /// there is a power law.
    ///
    /// # Errors
    /// If there are fewer than two rates, or one of the numbers or errors is not above zero.
    pub fn fit(points: &[FlowPoint]) -> Result<Self, AnalysisError> {
        let mut logs = Vec::with_capacity(points.len());
        for point in points {
            let rate = ParameterError::positive("rate of a point to fit", point.rate.value)?;
            let stress = ParameterError::positive("stress of a point to fit", point.stress.value)?;
            let viscosity = point.functions.viscosity;
            let error = StandardError::AtLeast(viscosity.at_least() / viscosity.value.abs());
            let value = stress.ln();
            logs.push((rate.ln(), Mean { value, error }));
        }
        let [constant, exponent] = PolynomialFit::<2>::new(&logs)?.coefficients;
        Ok(Self {
            consistency: constant.exp(),
            exponent,
        })
    }
}

/// `eta = eta_0 / (1 + (tau / tau_half)^(alpha - 1))`, Ellis: a plateau and a power law, in the stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellis {
    /// Viscosity at rest.
    pub viscosity: f64,
    /// The stress at which the viscosity is half of that.
    pub half_stress: f64,
    /// The exponent alpha; 1/alpha is the p of the power law at large stresses.
    pub exponent: f64,
}

impl Ellis {
    /// Least squares of the viscosities, weighted by their errors; alpha between 1 and 10, the stress within a factor
    /// of 100 of those given.
    ///
    /// # Errors
    /// If there are fewer than three points, or one of the numbers or errors is not above zero.
    pub fn fit(points: &[FlowPoint]) -> Result<Self, AnalysisError> {
        let data = data(points, |point| point.stress.value, 0.0)?;
        let shape = |stress: f64, [half, exponent]: [f64; 2]| {
            (1.0 + (stress / half).powf(exponent - 1.0)).recip()
        };
        let (viscosity, [half_stress, exponent]) = fit(&data, shape, [1.0, 10.0]);
        Ok(Self {
            viscosity,
            half_stress,
            exponent,
        })
    }
}

/// `eta = eta_inf + (eta_0 - eta_inf) (1 + (lambda rate)^2)^((n - 1) / 2)`, Carreau: a plateau at either end of a power
/// law, in the rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Carreau {
    /// Viscosity at rest.
    pub viscosity: f64,
    /// Viscosity at infinite rate, as given.
    pub infinite: f64,
    /// The time lambda: thinning sets in at its inverse.
    pub time: f64,
    /// The exponent n.
    pub exponent: f64,
}

impl Carreau {
    /// Least squares of the viscosities, weighted by their errors, with a known viscosity at infinite rate (0 if it is
    /// out of sight); n between 0 and 1, the time within a factor of 100 of the inverse rates given.
    ///
    /// # Errors
    /// If there are fewer than three points, or one of the numbers or errors is not above zero.
    pub fn fit(points: &[FlowPoint], infinite: f64) -> Result<Self, AnalysisError> {
        let data = data(points, |point| point.rate.value, infinite)?;
        let shape = |rate: f64, [onset, exponent]: [f64; 2]| {
            (1.0 + (rate / onset).powi(2)).powf(0.5 * (exponent - 1.0))
        };
        let (above, [onset, exponent]) = fit(&data, shape, [0.0, 1.0]);
        Ok(Self {
            viscosity: infinite + above,
            infinite,
            time: onset.recip(),
            exponent,
        })
    }
}

/// Abscissa, viscosity less a constant, weight.
type Datum = [f64; 3];

fn data(
    points: &[FlowPoint],
    abscissa: fn(&FlowPoint) -> f64,
    less: f64,
) -> Result<Vec<Datum>, AnalysisError> {
    const NEEDED: u64 = 3;
    if (points.len() as u64) < NEEDED {
        return Err(AnalysisError::TooFew {
            what: "points to fit",
            found: points.len() as u64,
            needed: NEEDED,
        });
    }
    let less = ParameterError::non_negative("viscosity at infinite rate", less)?;
    let datum = |point: &FlowPoint| {
        let x = ParameterError::positive("rate or stress of a point to fit", abscissa(point))?;
        let viscosity = point.functions.viscosity;
        let value = ParameterError::positive("viscosity of a point to fit", viscosity.value)?;
        let error = ParameterError::positive("error of a point to fit", viscosity.at_least())?;
        Ok([x, value - less, (error * error).recip()])
    };
    points.iter().map(datum).collect()
}

/// The amplitude, the place on the abscissa and the exponent of the shape that fits best.
fn fit(
    data: &[Datum],
    shape: impl Fn(f64, [f64; 2]) -> f64,
    exponents: [f64; 2],
) -> (f64, [f64; 2]) {
    /// How far beyond the data the place may be.
    const FARTHEST: f64 = 100.0;
    let abscissas = || data.iter().map(|[x, ..]| *x);
    let least = abscissas().fold(f64::MAX, f64::min) / FARTHEST;
    let most = abscissas().fold(0.0, f64::max) * FARTHEST;
    // For each shape the best amplitude is known, and what is left then.
    let amplitude = |parameters| {
        let (mut ys, mut ss) = (0.0, 0.0);
        for &[x, y, weight] in data {
            let s = shape(x, parameters);
            (ys, ss) = (ys + weight * y * s, ss + weight * s * s);
        }
        ys / ss
    };
    let misfit = |parameters| {
        let amplitude = amplitude(parameters);
        let square =
            |&[x, y, weight]: &Datum| weight * (y - amplitude * shape(x, parameters)).powi(2);
        data.iter().map(square).sum::<f64>()
    };
    let place = |exponent: f64| {
        let at = |log: f64| misfit([log.exp(), exponent]);
        minimum::golden(at, [least.ln(), most.ln()]).exp()
    };
    let exponent = minimum::golden(|e| misfit([place(e), e]), exponents);
    let parameters = [place(exponent), exponent];
    (amplitude(parameters), parameters)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn curve(viscosity: impl Fn(f64) -> f64) -> Vec<FlowPoint> {
        let point = |k: i32| {
            let rate = 10.0_f64.powf(0.2 * f64::from(k) - 2.0);
            let value = viscosity(rate);
            let error = StandardError::Plateau {
                error: 0.01 * value,
                uncertainty: 0.0,
            };
            let viscosity = Mean { value, error };
            FlowPoint::at(
                rate,
                ShearFunctions {
                    viscosity,
                    psi1: viscosity,
                    psi2: viscosity,
                },
            )
        };
        (0..=20).map(point).collect()
    }

    #[test]
    fn law_curves_of_each_law_give_its_parameters_back() {
        let power = PowerLaw::fit(&curve(|rate| 40.0 * rate.powf(-0.19))).unwrap();
        assert_relative_eq!(power.exponent, 0.81, max_relative = 1e-10);
        assert_relative_eq!(power.consistency, 40.0, max_relative = 1e-10);
        // eta (1 + (eta rate / 5)^1.5) = 30, solved by bisection.
        let ellis = |rate: f64| {
            let (mut low, mut high) = (0.0, 30.0);
            for _ in 0..100 {
                let eta: f64 = 0.5 * (low + high);
                if eta * (1.0 + (eta * rate / 5.0).powf(1.5)) > 30.0 {
                    high = eta;
                } else {
                    low = eta;
                }
            }
            0.5 * (low + high)
        };
        let found = Ellis::fit(&curve(ellis)).unwrap();
        assert_relative_eq!(found.viscosity, 30.0, max_relative = 1e-4);
        assert_relative_eq!(found.half_stress, 5.0, max_relative = 1e-3);
        assert_relative_eq!(found.exponent, 2.5, max_relative = 1e-3);
        let carreau = |rate: f64| 41.0 + 97.0 * (1.0 + (8.5 * rate).powi(2)).powf(-0.35);
        let found = Carreau::fit(&curve(carreau), 41.0).unwrap();
        assert_relative_eq!(found.viscosity, 138.0, max_relative = 1e-4);
        assert_relative_eq!(found.time, 8.5, max_relative = 1e-3);
        assert_relative_eq!(found.exponent, 0.3, max_relative = 1e-3);
    }

    #[test]
    fn extreme_points_that_make_no_curve_are_errors() {
        let good = curve(|_| 1.0);
        assert!(Ellis::fit(&good[..2]).is_err());
        assert!(Carreau::fit(&good, f64::NAN).is_err());
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let bad = curve(|rate| if rate > 1.0 { bad } else { 1.0 });
            assert!(PowerLaw::fit(&bad).is_err());
            assert!(Ellis::fit(&bad).is_err());
            assert!(Carreau::fit(&bad, 0.0).is_err());
        }
    }
}
