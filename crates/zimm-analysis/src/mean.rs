//! A mean and what is known of its error.

use std::fmt;

/// A mean with its standard error.
///
/// Printed, it carries its error, and says so if that is only a lower bound:
///
/// ```
/// use zimm_analysis::{Mean, StandardError};
///
/// let viscosity = Mean { value: 0.8192, error: StandardError::Plateau { error: 0.0123, uncertainty: 0.001 } };
/// assert_eq!(viscosity.to_string(), "0.819 ± 0.012");
///
/// let short_run = Mean { value: 0.8192, error: StandardError::AtLeast(0.0123) };
/// assert_eq!(short_run.to_string(), "0.819 ± at least 0.012 (no plateau)");
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
        let value = self.value - other.value;
        let total = self.at_least().hypot(other.at_least());
        let error = match (self.error, other.error) {
            (
                StandardError::Plateau {
                    error: a,
                    uncertainty: da,
                },
                StandardError::Plateau {
                    error: b,
                    uncertainty: db,
                },
            ) => StandardError::Plateau {
                error: total,
                uncertainty: if total > 0.0 {
                    (a * da).hypot(b * db) / total
                } else {
                    0.0
                },
            },
            _ => StandardError::AtLeast(total),
        };
        Self { value, error }
    }
}

impl fmt::Display for Mean {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
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
}
