//! A mean and what is known of its error.

use crate::independent::of_independent;
use crate::{AnalysisError, PolynomialFit};
use std::fmt;

/// A mean with its standard error.
///
/// Printed, it carries its error, and says so if that is only a lower bound. The short form `{:#}`, for tables, has
/// the error in units of the last digits:
///
/// ```
/// use zimm_analysis::{Mean, StandardError};
///
/// let viscosity = Mean { value: 0.8192, error: StandardError::Plateau { error: 0.0123, uncertainty: 0.001 } };
/// assert_eq!(viscosity.to_string(), "0.819 ± 0.012");
/// assert_eq!(format!("{viscosity:#}"), "0.819(12)");
///
/// let short_run = Mean { value: 0.8192, error: StandardError::AtLeast(0.0123) };
/// assert_eq!(short_run.to_string(), "0.819 ± at least 0.012 (no plateau)");
/// assert_eq!(format!("{short_run:#}"), "0.819(>12)");
/// assert_eq!(short_run.standard_error(), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mean {
    /// The mean of all samples.
    pub value: f64,
    /// Its standard error, in the unit of the value.
    pub error: StandardError,
}

/// What is known of the standard error of a mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StandardError {
    /// The samples cover enough correlation times for the error to be known.
    Plateau {
        /// One standard deviation of the mean.
        error: f64,
        /// One standard deviation of `error` itself.
        uncertainty: f64,
    },
    /// The samples are too few for their correlations: the error may be much larger than this.
    AtLeast(f64),
}

impl Mean {
    /// The standard error, if it is known.
    pub fn standard_error(&self) -> Option<f64> {
        match self.error {
            StandardError::Plateau { error, .. } => Some(error),
            StandardError::AtLeast(_) => None,
        }
    }

    /// The standard error if it is known, and its lower bound if not.
    pub fn at_least(&self) -> f64 {
        match self.error {
            StandardError::Plateau { error, .. } | StandardError::AtLeast(error) => error,
        }
    }

    /// The mean of all samples times a number.
    pub fn times(self, factor: f64) -> Self {
        let size = factor.abs();
        let error = match self.error {
            StandardError::Plateau { error, uncertainty } => StandardError::Plateau {
                error: size * error,
                uncertainty: size * uncertainty,
            },
            StandardError::AtLeast(error) => StandardError::AtLeast(size * error),
        };
        Self {
            value: factor * self.value,
            error,
        }
    }

    /// The difference of two means from independent runs: errors add in quadrature.
    ///
    /// For quantities of the same run, average the difference of the samples instead.
    pub fn minus_independent(self, other: Self) -> Self {
        of_independent(self.value - other.value, [(1.0, self), (-1.0, other)])
    }

    /// About how many more samples it takes to know the mean to this relative error; none if it is known already.
    ///
    /// `samples` is the number that this mean is made of. Its error falls as one over the square root of it. While the
    /// error is only bounded from below the answer is never none, and at least as many as there are.
    ///
    /// A run that stops at the first moment when its error is small enough stops, more often than not, when the error
    /// is estimated too small. Ask seldom, after as many more samples as were answered, and this effect is small.
    ///
    /// ```
    /// use zimm_analysis::BlockAverage;
    /// use zimm_core::Estimator;
    ///
    /// // Run until the viscosity is known to 2 %.
    /// let mut viscosity = BlockAverage::new();
    /// let (mut more, mut k) = (100_u64, 0_u64);
    /// while more > 0 {
    ///     for _ in 0..more {
    ///         k += 1; // ... a step of the system, and its stress ...
    ///         viscosity.push(0.5 + (k * 2_654_435_769 % 1000) as f64 / 1000.0);
    ///     }
    ///     more = viscosity.estimate()?.more_samples(viscosity.samples(), 0.02);
    /// }
    /// assert!(viscosity.estimate()?.at_least() < 0.02);
    /// assert!(viscosity.samples() < 1000);
    /// # Ok::<(), zimm_analysis::AnalysisError>(())
    /// ```
    pub fn more_samples(&self, samples: u64, relative_error: f64) -> u64 {
        let allowed = relative_error.max(0.0) * self.value.abs();
        let excess = if self.at_least() > 0.0 {
            (self.at_least() / allowed).powi(2)
        } else {
            1.0
        };
        // More than there are numbers is all of them.
        let more = (samples as f64 * (excess - 1.0)).ceil() as u64;
        match self.error {
            StandardError::Plateau { .. } => more,
            StandardError::AtLeast(_) => more.max(samples).max(1),
        }
    }

    /// One mean of several independent ones of the same quantity, each weighted by the inverse square of its error:
    /// the constant of [`PolynomialFit`], with its error. If the means scatter more than their errors explain, the
    /// error grows accordingly.
    ///
    /// ```
    /// use zimm_analysis::{Mean, StandardError};
    ///
    /// let mean = |value, error| Mean { value, error: StandardError::Plateau { error, uncertainty: 0.0 } };
    /// let friction = Mean::combined(&[mean(1.0, 0.1), mean(1.1, 0.2)])?;
    /// assert_eq!(format!("{friction:#}"), "1.02(9)");
    /// # Ok::<(), zimm_analysis::AnalysisError>(())
    /// ```
    ///
    /// # Errors
    /// If there is no mean, one is not finite, or an error is not above zero.
    pub fn combined(means: &[Self]) -> Result<Self, AnalysisError> {
        let points: Vec<_> = means.iter().map(|&mean| (0.0, mean)).collect();
        Ok(PolynomialFit::<1>::new(&points)?.at(0.0))
    }

    /// A value with its error in units of the last digits, which are two if the first of them is 1.
    fn short(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (value, error) = (self.value, self.at_least());
        let mark = if self.standard_error().is_some() {
            ""
        } else {
            ">"
        };
        if !(error > 0.0 && error.is_finite()) {
            write!(f, "{value:.4}")?;
            return match self.error {
                StandardError::Plateau { .. } => Ok(()),
                StandardError::AtLeast(error) => write!(f, "(>{error})"),
            };
        }
        let exponent = error.log10().floor() as i32;
        let two_digits = i32::from(error < 1.95 * 10.0_f64.powi(exponent));
        let decimals = (two_digits - exponent).clamp(0, 17) as usize;
        if exponent < 0 {
            let last_digits = error * 10.0_f64.powi(decimals as i32);
            write!(f, "{value:.decimals$}({mark}{last_digits:.0})")
        } else {
            write!(f, "{value:.decimals$}({mark}{error:.decimals$})")
        }
    }
}

impl fmt::Display for Mean {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if f.alternate() {
            return self.short(f);
        }
        let digits = f.precision().unwrap_or_else(|| decimals(self.at_least()));
        match self.error {
            StandardError::Plateau { error, .. } => {
                write!(f, "{:.digits$} ± {error:.digits$}", self.value)
            }
            StandardError::AtLeast(error) => {
                write!(
                    f,
                    "{:.digits$} ± at least {error:.digits$} (no plateau)",
                    self.value
                )
            }
        }
    }
}

/// Decimals that show two digits of an error.
fn decimals(error: f64) -> usize {
    if error > 0.0 && error.is_finite() {
        (1.0 - error.log10().floor()).clamp(0.0, 17.0) as usize
    } else {
        6
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn known(value: f64, error: f64, uncertainty: f64) -> Mean {
        let error = StandardError::Plateau { error, uncertainty };
        Mean { value, error }
    }

    #[test]
    fn law_errors_scale_and_add_in_quadrature() {
        assert_eq!(known(3.0, 0.5, 0.1).times(-2.0), known(-6.0, 1.0, 0.2));
        let difference = known(5.0, 3.0, 0.5).minus_independent(known(1.0, 4.0, 1.0));
        let uncertainty = (1.5_f64 * 1.5 + 16.0).sqrt() / 5.0;
        assert_eq!(difference, known(4.0, 5.0, uncertainty));
    }

    // Errors fall as one over the root of the samples: 3 times the error asked for takes 9 times the samples.
    #[test]
    fn law_more_samples_are_those_that_the_error_takes() {
        let mean = known(-2.0, 0.06, 0.0);
        assert_eq!(mean.more_samples(100, 0.01), 800);
        assert_eq!(
            (mean.more_samples(100, 0.03), mean.more_samples(100, 1.0)),
            (0, 0)
        );
        assert_eq!(mean.more_samples(100, 0.029_99), 1);
        assert_eq!(known(0.0, 0.0, 0.0).more_samples(10, 0.1), 0);
        for hopeless in [
            known(0.0, 1.0, 0.1).more_samples(10, 0.1),
            mean.more_samples(10, 0.0),
        ] {
            assert_eq!(hopeless, u64::MAX);
        }
        let error = StandardError::AtLeast(0.06);
        let short = Mean { value: 2.0, error };
        assert_eq!(
            (short.more_samples(100, 1.0), short.more_samples(100, 0.01)),
            (100, 800)
        );
        assert_eq!(short.more_samples(0, 1.0), 1);
    }

    #[test]
    fn law_a_missing_plateau_is_passed_on_and_shown() {
        let short = Mean {
            value: 2.0,
            error: StandardError::AtLeast(4.0),
        };
        let difference = known(5.0, 3.0, 0.5).minus_independent(short);
        assert_eq!(difference.error, StandardError::AtLeast(5.0));
        assert_eq!(difference.times(2.0).standard_error(), None);
        assert!(difference.to_string().contains("no plateau"));
    }

    #[test]
    fn law_a_precision_asked_for_is_kept() {
        assert_eq!(format!("{:.1}", known(1.26, 0.04, 0.01)), "1.3 ± 0.0");
        assert_eq!(known(1234.4, 52.0, 1.0).to_string(), "1234 ± 52");
        assert_eq!(known(1.0, 0.0, 0.0).to_string(), "1.000000 ± 0.000000");
    }

    #[test]
    fn law_the_short_form_has_the_error_in_its_last_digits() {
        for (value, error, text) in [
            (0.05634, 0.00042, "0.0563(4)"),
            (0.9123, 0.0124, "0.912(12)"),
            (2.35, 0.97, "2.4(10)"),
            (-3.21, 1.4, "-3.2(1.4)"),
            (512.4, 37.0, "512(37)"),
            (1.0, 0.0, "1.0000"),
        ] {
            assert_eq!(format!("{:#}", known(value, error, 0.0)), text);
        }
        for (error, text) in [(0.03, "0.91(>3)"), (0.0, "0.9123(>0)")] {
            let short = Mean {
                value: 0.9123,
                error: StandardError::AtLeast(error),
            };
            assert_eq!(format!("{short:#}"), text);
        }
        assert_eq!(format!("{:#}", known(1.0, 1e-300, 0.0)).len(), 22);
    }

    // Weights 1/9 and 1/16: value (1/9 + 2/16) / (25/144) = 1.36, error 12/5; the scatter is a tenth of a sigma. The
    // second pair is ten errors apart, chi^2 = 50: the error of 1/sqrt(2) grows to sqrt(25) = 5, half the distance.
    #[test]
    fn law_means_combine_by_their_errors() {
        let found = Mean::combined(&[known(1.0, 3.0, 0.3), known(2.0, 4.0, 0.8)]).unwrap();
        approx::assert_relative_eq!(found.value, 1.36, max_relative = 1e-14);
        approx::assert_relative_eq!(found.at_least(), 2.4, max_relative = 1e-14);
        let found = Mean::combined(&[known(0.0, 1.0, 0.1), known(10.0, 1.0, 0.1)]).unwrap();
        approx::assert_relative_eq!(found.standard_error().unwrap(), 5.0, max_relative = 1e-14);
        let unsettled = Mean {
            value: 1.0,
            error: StandardError::AtLeast(1.0),
        };
        let found = Mean::combined(&[unsettled, known(1.0, 1.0, 0.1)]).unwrap();
        assert!(found.standard_error().is_none());
        assert!(Mean::combined(&[]).is_err());
        assert!(Mean::combined(&[known(1.0, 0.0, 0.0)]).is_err());
        assert!(Mean::combined(&[known(f64::NAN, 1.0, 0.0)]).is_err());
    }
}
