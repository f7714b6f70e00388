//! Polynomials through points with error bars.

use crate::{AnalysisError, Mean, StandardError};
use zimm_core::ParameterError;

/// The weighted least squares fit of a polynomial of `P` coefficients to points with error bars,
///
/// ```text
/// y = c_0 + c_1 x + ... + c_(P-1) x^(P-1),   minimal chi^2 = sum_i ((y_i - y(x_i)) / error_i)^2
/// ```
///
/// by orthogonal columns (Gram and Schmidt), with the covariance of the coefficients that the errors of the points
/// entail (Press et al., Numerical Recipes, 2007, sec. 15.4). Points are independent.
///
/// This is how results are extrapolated: to long chains with x = N^(-1/2), to large cells with x = 1/L, to small
/// steps with x = dt. The error of a value of the polynomial is conservative: it is scaled by sqrt(chi^2 / freedom) if
/// the points scatter more than their errors explain, and never reduced if they scatter less. No fit knows that its
/// polynomial is the wrong one: compare `P` = 2 and 3.
///
/// ```
/// use zimm_analysis::{Mean, PolynomialFit, StandardError};
///
/// let point = |x, value| (x, Mean { value, error: StandardError::Plateau { error: 0.1, uncertainty: 0.01 } });
/// let line = PolynomialFit::<2>::new(&[point(1.0, 3.0), point(2.0, 5.0), point(3.0, 7.0)])?;
/// assert!((line.coefficients[1] - 2.0).abs() < 1e-14);
/// assert_eq!(format!("{:#}", line.at(0.0)), "1.00(15)");
/// # Ok::<(), zimm_analysis::AnalysisError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PolynomialFit<const P: usize> {
    /// The coefficients, the constant first.
    pub coefficients: [f64; P],
    /// Their covariance, from the errors of the points alone.
    pub covariance: [[f64; P]; P],
    /// The sum of squared deviations in units of the errors.
    pub chi2: f64,
    /// Points less coefficients: the mean of `chi2` if the polynomial is right.
    pub freedom: usize,
    /// The largest uncertainty of a point's error relative to it, or nothing if one is a lower bound.
    uncertainty: Option<f64>,
}

impl<const P: usize> PolynomialFit<P> {
    /// Fits points (x, y).
    ///
    /// # Errors
    /// If there are fewer than `P` different x, a number is not finite, or an error is not above zero.
    pub fn new(points: &[(f64, Mean)]) -> Result<Self, AnalysisError> {
        let mut distinct: Vec<f64> = points.iter().map(|&(x, _)| x).collect();
        distinct.sort_by(f64::total_cmp);
        distinct.dedup();
        if distinct.len() < P {
            return Err(AnalysisError::TooFew {
                what: "different x of points to fit",
                found: distinct.len() as u64,
                needed: P as u64,
            });
        }
        let mut columns: [Vec<f64>; P] = std::array::from_fn(|_| Vec::new());
        let (mut rest, mut uncertainty) = (Vec::new(), Some(0.0_f64));
        for &(x, mean) in points {
            ParameterError::finite("x of a point to fit", x)?;
            ParameterError::finite("y of a point to fit", mean.value)?;
            let error = ParameterError::positive("error of a point to fit", mean.at_least())?;
            for (k, column) in columns.iter_mut().enumerate() {
                column.push(x.powi(k as i32) / error);
            }
            rest.push(mean.value / error);
            uncertainty = match mean.error {
                StandardError::Plateau { uncertainty: u, .. } => {
                    uncertainty.map(|most| most.max(u / error))
                }
                StandardError::AtLeast(_) => None,
            };
        }
        let triangle = orthonormalise(&mut columns)?;
        let mut projected = [0.0; P];
        for (column, component) in columns.iter().zip(&mut projected) {
            *component = take_off(column, &mut rest);
        }
        let unit = |k| std::array::from_fn(|i| f64::from(u8::from(i == k)));
        let inverse: [[f64; P]; P] = std::array::from_fn(|k| solve(&triangle, unit(k)));
        let covariance =
            |i: usize, j: usize| inverse.iter().map(|column| column[i] * column[j]).sum();
        Ok(Self {
            coefficients: solve(&triangle, projected),
            covariance: std::array::from_fn(|i| std::array::from_fn(|j| covariance(i, j))),
            chi2: rest.iter().map(|r| r * r).sum(),
            freedom: points.len() - P,
            uncertainty,
        })
    }

    /// The value of the polynomial, with its conservative error. At zero it is the value extrapolated to.
    pub fn at(&self, x: f64) -> Mean {
        let powers: [f64; P] = std::array::from_fn(|k| x.powi(k as i32));
        let (mut value, mut variance) = (0.0, 0.0);
        for ((c, row), a) in self.coefficients.iter().zip(&self.covariance).zip(powers) {
            value += c * a;
            variance += row.iter().zip(powers).map(|(v, b)| a * v * b).sum::<f64>();
        }
        let scatter = self.chi2 / self.freedom.max(1) as f64;
        let error = (variance * scatter.max(1.0)).sqrt();
        let error = match self.uncertainty {
            Some(relative) => StandardError::Plateau {
                error,
                uncertainty: relative * error,
            },
            None => StandardError::AtLeast(error),
        };
        Mean { value, error }
    }
}

/// Makes columns orthonormal; they were these times the upper triangle returned.
fn orthonormalise<const P: usize>(
    columns: &mut [Vec<f64>; P],
) -> Result<[[f64; P]; P], ParameterError> {
    /// Columns that differ by less are told apart by rounding alone.
    const INDEPENDENT: f64 = 1e-12;
    let mut triangle = [[0.0; P]; P];
    for k in 0..P {
        let (done, rest) = columns.split_at_mut(k);
        let Some(column) = rest.first_mut() else {
            break;
        };
        let before = length(column);
        // Twice is enough (Kahan).
        for _ in 0..2 {
            for (row, direction) in triangle.iter_mut().zip(done.iter()) {
                row[k] += take_off(direction, column);
            }
        }
        let left = length(column);
        let name = "part of a power of x that lower powers do not give";
        let share = ParameterError::positive(name, left / before)?;
        if share < INDEPENDENT {
            return Err(ParameterError::new(name, share, "above 1e-12"));
        }
        triangle[k][k] = left;
        column.iter_mut().for_each(|entry| *entry /= left);
    }
    Ok(triangle)
}

fn length(v: &[f64]) -> f64 {
    v.iter().map(|a| a * a).sum::<f64>().sqrt()
}

/// Takes the component along a direction off a vector, and returns it.
fn take_off(direction: &[f64], v: &mut [f64]) -> f64 {
    let component = direction.iter().zip(v.iter()).map(|(a, b)| a * b).sum();
    for (entry, d) in v.iter_mut().zip(direction) {
        *entry -= component * d;
    }
    component
}

/// The solution of an upper triangle of equations, from the last.
fn solve<const P: usize>(triangle: &[[f64; P]; P], mut right: [f64; P]) -> [f64; P] {
    for (i, row) in triangle.iter().enumerate().rev() {
        let known: f64 = row.iter().zip(right).skip(i + 1).map(|(a, x)| a * x).sum();
        right[i] = (right[i] - known) / row[i];
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Random;
    use approx::assert_relative_eq;

    fn point(x: f64, value: f64, error: f64) -> (f64, Mean) {
        let uncertainty = 0.1 * error;
        let error = StandardError::Plateau { error, uncertainty };
        (x, Mean { value, error })
    }

    /// Chains of 6, 8, ..., 20 beads and errors that grow with them.
    const X: fn(u32) -> f64 = |k| f64::from(6 + 2 * k).powf(-0.5);
    const ERROR: fn(u32) -> f64 = |k| 0.01 * f64::from(1 + k);

    // The covariance of a line's coefficients is that of the textbook: with S = sum w, S_x = sum w x, S_xx = sum w x^2
    // and D = S S_xx - S_x^2, it is S_xx / D, S / D and -S_x / D.
    #[test]
    fn law_lines_and_parabolas_come_back_with_their_covariance() {
        let line: Vec<_> = (0..8)
            .map(|k| point(X(k), 1.7 - 0.9 * X(k), ERROR(k)))
            .collect();
        let fit = PolynomialFit::<2>::new(&line).unwrap();
        assert_relative_eq!(fit.coefficients[0], 1.7, max_relative = 1e-13);
        assert_relative_eq!(fit.coefficients[1], -0.9, max_relative = 1e-13);
        assert!(fit.chi2 < 1e-20 && fit.freedom == 6);
        let sum = |power| {
            (0..8)
                .map(|k| X(k).powi(power) * ERROR(k).powi(-2))
                .sum::<f64>()
        };
        let d = sum(0) * sum(2) - sum(1) * sum(1);
        let exact = [[sum(2) / d, -sum(1) / d], [-sum(1) / d, sum(0) / d]];
        for (row, exact) in fit.covariance.iter().zip(exact) {
            for (found, exact) in row.iter().zip(exact) {
                assert_relative_eq!(*found, exact, max_relative = 1e-11);
            }
        }
        assert_relative_eq!(
            fit.at(0.0).standard_error().unwrap(),
            (sum(2) / d).sqrt(),
            max_relative = 1e-11
        );
        let parabola = |x: f64| 2.0 - 3.0 * x + 0.5 * x * x;
        let points: Vec<_> = (0..8)
            .map(|k| point(X(k), parabola(X(k)), ERROR(k)))
            .collect();
        let fit = PolynomialFit::<3>::new(&points).unwrap();
        for (found, exact) in fit.coefficients.iter().zip([2.0, -3.0, 0.5]) {
            assert_relative_eq!(*found, exact, max_relative = 1e-10);
        }
        assert_relative_eq!(fit.at(0.3).value, parabola(0.3), max_relative = 1e-12);
    }

    // 20 000 fits of a line to eight points with normal errors, seed 23. Intercept and slope are normal with the
    // covariance given: their normalised variances have a standard error of sqrt(2 / 20 000) = 1 %, chi^2 has mean 6 and
    // variance 12, 0.4 % of its mean. Bounds 4 sigma. A point counted twice, or weights of 1 / error, is off by 10 % and
    // more. The error given grows with chi^2: <max(1, chi^2 / 6)> = 1.22 times the variance, by quadrature; 1 %.
    #[test]
    fn limit_fits_scatter_as_their_covariance_says() {
        let mut random = Random::new(23);
        let repeats = 20_000;
        let (mut intercept, mut slope, mut both, mut chi2, mut given) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for _ in 0..repeats {
            let points: Vec<_> = (0..8)
                .map(|k| {
                    point(
                        X(k),
                        1.7 - 0.9 * X(k) + ERROR(k) * random.normal(),
                        ERROR(k),
                    )
                })
                .collect();
            let fit = PolynomialFit::<2>::new(&points).unwrap();
            let [[c00, c01], [_, c11]] = fit.covariance;
            let [a, b] = [fit.coefficients[0] - 1.7, fit.coefficients[1] + 0.9];
            intercept += a * a / c00;
            slope += b * b / c11;
            both += a * b / c01;
            chi2 += fit.chi2;
            given += fit.at(0.0).at_least().powi(2) / c00;
        }
        for (name, sum, exact, bound) in [
            ("intercept", intercept, 1.0, 0.04),
            ("slope", slope, 1.0, 0.04),
            ("covariance", both, 1.0, 0.04),
            ("chi^2", chi2, 6.0, 0.1),
            ("error", given, 1.224, 0.02),
        ] {
            let mean = sum / f64::from(repeats);
            assert!((mean - exact).abs() < bound, "{name}: {mean} for {exact}");
        }
    }

    #[test]
    fn extreme_points_that_make_no_polynomial_are_errors() {
        let fit = |points: &[_]| PolynomialFit::<2>::new(points);
        assert!(matches!(
            fit(&[point(1.0, 1.0, 0.1), point(1.0, 2.0, 0.1)]),
            Err(AnalysisError::TooFew {
                found: 1,
                needed: 2,
                ..
            })
        ));
        let close = fit(&[point(1.0, 1.0, 0.1), point(1.0 + 1e-15, 2.0, 0.1)]);
        assert!(
            matches!(close, Err(AnalysisError::Parameter(_))),
            "{close:?}"
        );
        for bad in [
            point(f64::NAN, 1.0, 0.1),
            point(2.0, f64::INFINITY, 0.1),
            point(2.0, 1.0, 0.0),
            point(2.0, 1.0, f64::NAN),
            point(2.0, 1.0, 1e-320),
        ] {
            let found = fit(&[point(1.0, 1.0, 0.1), bad]);
            assert!(
                matches!(found, Err(AnalysisError::Parameter(_))),
                "{found:?}"
            );
        }
        // Two points make a line without freedom.
        let exact = fit(&[point(1.0, 1.0, 0.1), point(2.0, 2.0, 0.1)]).unwrap();
        assert_relative_eq!(
            exact.at(0.0).at_least(),
            0.1 * 5.0_f64.sqrt(),
            max_relative = 1e-12
        );
    }
}
