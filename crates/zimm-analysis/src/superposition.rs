//! Curves that become one when they are shifted.

use crate::{AnalysisError, Mean, StandardError, minimum};
use zimm_core::ParameterError;

/// The factor a that shifts one flow curve onto another: rates become rate / a, ordinates become y a^v,
///
/// | to shift | y | v |
/// | --- | --- | --- |
/// | viscosity less that of the solvent, with concentration or temperature | eta - eta_s | 1 |
/// | normal stress coefficients, likewise | Psi | 2 |
/// | anything over its value at rest | eta / eta_0 | 0 |
/// | moduli over their plateau | G' | 0 |
///
/// found by the code: both curves are drawn through their points in double logarithmic axes (cubics by Catmull and
/// Rom), and a is where the mean square of their distance is least, in units of the errors of both, wherever they
/// overlap. Points of both curves count.
///
/// ```
/// use zimm_analysis::{Mean, StandardError, Superposition};
///
/// // Two pieces of eta = 1 / (1 + rate), one of a melt three times as slow and as viscous.
/// let point = |slow: f64, rate: f64| {
///     let value = slow / (1.0 + slow * rate);
///     (rate, Mean { value, error: StandardError::AtLeast(0.01 * value) })
/// };
/// let rates = |least: f64| (0..12).map(move |k| least * 1.5_f64.powi(k));
/// let reference: Vec<_> = rates(0.1).map(|rate| point(1.0, rate)).collect();
/// let curve: Vec<_> = rates(0.05).map(|rate| point(3.0, rate)).collect();
/// let found = Superposition::find(&reference, &curve, 1.0)?;
/// assert!((found.factor.value - 1.0 / 3.0).abs() < 0.002);
/// # Ok::<(), zimm_analysis::AnalysisError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Superposition {
    /// The factor a, with the error that those of independent points entail, grown by the residual if that is above
    /// one.
    pub factor: Mean,
    /// Root mean square distance of the curves at a, in units of the errors: about 1 if they superpose.
    pub residual: f64,
    /// Root mean square of the relative distance of the curves at a.
    pub distance: f64,
    /// Points of either curve that lie within the other.
    pub overlapping: usize,
}

/// Fewest points of either curve within the other.
const FEWEST: usize = 3;
/// Shifts tried before the best of them is refined, per unit of the logarithm.
const TRIALS: f64 = 20.0;

impl Superposition {
    /// Shifts `curve` onto `reference`, both points (rate, y) of any order, with ordinates shifted by the power
    /// `vertical` of the factor.
    ///
    /// # Errors
    /// If a rate, an ordinate or an error is not above zero, a curve has fewer than four points, or no shift is better
    /// than those around it: power laws, and plateaus without a shift of the ordinate, fit everywhere.
    pub fn find(
        reference: &[(f64, Mean)],
        curve: &[(f64, Mean)],
        vertical: f64,
    ) -> Result<Self, AnalysisError> {
        let (reference, curve) = (Curve::new(reference)?, Curve::new(curve)?);
        ParameterError::finite("power of the vertical shift", vertical)?;
        let misfit = |shift: f64| Misfit::of(&reference, &curve, shift, vertical);
        let chi2 = |shift: f64| misfit(shift).map_or(f64::INFINITY, |misfit| misfit.chi2());
        // Curve moves left by the shift: from where its left end meets the reference's right end to the opposite.
        let [low, high] = [
            curve.first() - reference.last(),
            curve.last() - reference.first(),
        ];
        let trials = ((high - low) * TRIALS).ceil().max(2.0);
        let step = (high - low) / trials;
        let (mut best, mut least) = (low, f64::INFINITY);
        for k in 0..=trials as usize {
            let shift = low + k as f64 * step;
            if chi2(shift) < least {
                (best, least) = (shift, chi2(shift));
            }
        }
        let shift = minimum::golden(chi2, [best - step, best + step]);
        let found = misfit(shift).ok_or(AnalysisError::TooFew {
            what: "points of either curve within the other",
            found: 0,
            needed: FEWEST as u64,
        })?;
        // chi^2 of the points grows by one a standard error away from its minimum, up to the terms beyond the square.
        // Each stretch of the overlap is seen twice, by the points of either curve.
        let apart = 0.5 * step;
        let bend =
            (chi2(shift + apart) + chi2(shift - apart) - 2.0 * found.chi2()) / (apart * apart);
        let points = 0.5 * found.points as f64;
        let name = "curvature of the residual against the shift";
        let bend = ParameterError::positive(name, bend)?;
        let error = (2.0 * found.chi2().max(1.0) / (bend * points)).sqrt();
        if error > 0.5 * (high - low) {
            return Err(ParameterError::new(name, bend, "large enough to tell a shift").into());
        }
        let value = shift.exp();
        Ok(Self {
            factor: Mean {
                value,
                error: StandardError::Plateau {
                    error: value * error,
                    uncertainty: value * error / (2.0 * points).sqrt(),
                },
            },
            residual: found.chi2().sqrt(),
            distance: (0.5 * found.squares / points).sqrt(),
            overlapping: found.points,
        })
    }

    /// The factor that Fedosov, Karniadakis and Caswell (2010, eq. 12) use for solutions of number density n of chain
    /// beads, a = (n_0 / n) exp(alpha (n_0 - n)), as rates / a and (eta - eta_s) a are those of density n_0.
    ///
    /// # Errors
    /// If a density is not above zero, or alpha is not finite.
    pub fn of_concentration(
        density: f64,
        reference: f64,
        alpha: f64,
    ) -> Result<f64, ParameterError> {
        let density = ParameterError::positive("density", density)?;
        let reference = ParameterError::positive("density of the reference", reference)?;
        let alpha = ParameterError::finite("alpha", alpha)?;
        let exponent = alpha * (reference - density);
        ParameterError::finite("shift factor", reference / density * exponent.exp())
    }
}

/// The distance of two curves.
#[derive(Default)]
struct Misfit {
    points: usize,
    weighted: f64,
    squares: f64,
}

impl Misfit {
    fn of(reference: &Curve, curve: &Curve, shift: f64, vertical: f64) -> Option<Self> {
        let mut misfit = Self::default();
        let mut take = |one: &Point, other: Option<[f64; 2]>, up: f64| {
            if let Some([y, error]) = other {
                let apart = one.y - y - up;
                misfit.points += 1;
                misfit.squares += apart * apart;
                misfit.weighted += apart * apart / (error * error + one.error * one.error);
                return 1;
            }
            0
        };
        let up = vertical * shift;
        let mut within = [0, 0];
        for point in &reference.points {
            within[0] += take(point, curve.at(point.x + shift), up);
        }
        for point in &curve.points {
            within[1] += take(point, reference.at(point.x - shift), -up);
        }
        (within[0] >= FEWEST && within[1] >= FEWEST).then_some(misfit)
    }

    /// The mean square in units of the errors.
    fn chi2(&self) -> f64 {
        self.weighted / self.points as f64
    }
}

/// A curve in logarithms, by rising rate.
struct Curve {
    points: Vec<Point>,
}

#[derive(Clone, Copy)]
struct Point {
    x: f64,
    y: f64,
    error: f64,
}

impl Curve {
    fn new(points: &[(f64, Mean)]) -> Result<Self, AnalysisError> {
        const NEEDED: usize = 4;
        let mut logs = Vec::with_capacity(points.len());
        for (rate, mean) in points {
            let y = ParameterError::positive("ordinate of a curve to shift", mean.value)?;
            let error = ParameterError::positive("error of a curve to shift", mean.at_least())?;
            logs.push(Point {
                x: ParameterError::positive("rate of a curve to shift", *rate)?.ln(),
                y: y.ln(),
                error: error / y,
            });
        }
        logs.sort_by(|a, b| a.x.total_cmp(&b.x));
        logs.dedup_by(|a, b| a.x == b.x);
        if logs.len() < NEEDED {
            return Err(AnalysisError::TooFew {
                what: "different rates of a curve to shift",
                found: logs.len() as u64,
                needed: NEEDED as u64,
            });
        }
        Ok(Self { points: logs })
    }

    fn first(&self) -> f64 {
        self.points.first().map_or(0.0, |point| point.x)
    }

    fn last(&self) -> f64 {
        self.points.last().map_or(0.0, |point| point.x)
    }

    /// Ordinate and error, if x is within the curve.
    fn at(&self, x: f64) -> Option<[f64; 2]> {
        if !(self.first()..=self.last()).contains(&x) {
            return None;
        }
        let above = self.points.partition_point(|point| point.x <= x);
        let k = above.clamp(1, self.points.len() - 1) - 1;
        let (left, right) = (self.points.get(k)?, self.points.get(k + 1)?);
        let slope = |a: &Point, b: &Point| (b.y - a.y) / (b.x - a.x);
        let (here, h) = (slope(left, right), right.x - left.x);
        let before = k.checked_sub(1).and_then(|k| self.points.get(k));
        let after = self.points.get(k + 2);
        // The slope of the parabola through three points, at the middle one.
        let blend = |one: f64, one_h: f64, other: f64, other_h: f64| {
            (one * other_h + other * one_h) / (one_h + other_h)
        };
        let first = before.map_or(here, |p| blend(slope(p, left), left.x - p.x, here, h));
        let second = after.map_or(here, |p| blend(slope(right, p), p.x - right.x, here, h));
        let t = (x - left.x) / h;
        let s = 1.0 - t;
        let y = s * s * (1.0 + 2.0 * t) * left.y
            + t * t * (1.0 + 2.0 * s) * right.y
            + h * s * t * (s * first - t * second);
        Some([y, s * left.error + t * right.error])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Random;

    /// A master curve with a plateau and a power law.
    fn master(rate: f64) -> f64 {
        5.0 * (1.0 + rate * rate).powf(-0.3)
    }

    /// Points of the curve that a factor and a power shift onto the master curve, from a rate on.
    fn shifted(
        factor: f64,
        vertical: f64,
        from: f64,
        noise: &mut dyn FnMut() -> f64,
    ) -> Vec<(f64, Mean)> {
        let point = |k: i32| {
            let rate = from * 1.4_f64.powi(k);
            let value = master(rate / factor) * factor.powf(-vertical);
            let error = StandardError::AtLeast(0.02 * value);
            let value = value * (1.0 + 0.02 * noise());
            (rate, Mean { value, error })
        };
        (0..16).map(point).collect()
    }

    #[test]
    fn law_known_shifts_come_back_whatever_the_vertical_power() {
        let reference = shifted(1.0, 0.0, 0.05, &mut || 0.0);
        for factor in [0.2, 0.7, 1.0, 1.3, 6.0] {
            for vertical in [0.0, 1.0, 2.0] {
                let curve = shifted(factor, vertical, 0.09 * factor, &mut || 0.0);
                let found = Superposition::find(&reference, &curve, vertical).unwrap();
                let off = found.factor.value / factor - 1.0;
                assert!(off.abs() < 2e-3, "{factor} {vertical}: {found:?}");
                assert!(found.distance < 2e-3 && found.residual < 0.1, "{found:?}");
                assert!(found.overlapping > 20);
            }
        }
    }

    // 400 pairs of curves with normal errors of 2 %, seed 31, factor 3, ordinates shifted with it. Deviations in units
    // of the error given: their mean square has an expectation near 1 and a standard error of sqrt(2 / 400) = 0.07.
    // Errors of both curves enter, those of neighbouring points together where one curve is interpolated: 0.7 to 1.4.
    // The mean deviation has a standard error of 0.05; bound 4 of them.
    #[test]
    fn limit_shift_factors_scatter_as_their_errors_say() {
        let mut random = Random::new(31);
        let (mut sum, mut squares, mut residual, repeats) = (0.0, 0.0, 0.0, 400);
        for _ in 0..repeats {
            let mut noise = || random.normal();
            let reference = shifted(1.0, 1.0, 0.05, &mut noise);
            let curve = shifted(3.0, 1.0, 0.3, &mut noise);
            let found = Superposition::find(&reference, &curve, 1.0).unwrap();
            let off = (found.factor.value - 3.0) / found.factor.at_least();
            sum += off;
            squares += off * off;
            residual += found.residual / f64::from(repeats);
        }
        let (mean, square) = (sum / f64::from(repeats), squares / f64::from(repeats));
        println!("mean {mean}, square {square}, residual {residual}");
        assert!(mean.abs() < 0.2, "{mean}");
        assert!((0.7..1.4).contains(&square), "{square}");
        assert!((0.7..1.3).contains(&residual), "{residual}");
    }

    // Fedosov's rule at alpha = 1.5: from density 1.5 to 0.75, a = (0.75 / 1.5) exp(1.5 (0.75 - 1.5)) = 0.162326.
    #[test]
    fn reference_the_rule_of_concentrations() {
        let factor = Superposition::of_concentration(1.5, 0.75, 1.5).unwrap();
        assert!((factor - 0.162_326_2).abs() < 1e-6, "{factor}");
        assert_eq!(
            Superposition::of_concentration(2.0, 2.0, 0.75).unwrap(),
            1.0
        );
        assert!(Superposition::of_concentration(0.0, 1.0, 1.0).is_err());
        assert!(Superposition::of_concentration(1.0, 1.0, f64::NAN).is_err());
        assert!(Superposition::of_concentration(1.0, 1e5, 1.0).is_err());
    }

    #[test]
    fn extreme_curves_without_a_shift_are_errors() {
        let curve = |y: fn(f64) -> f64| -> Vec<_> {
            let point = |k: i32| {
                let rate = 1.3_f64.powi(k);
                let value = y(rate);
                let error = StandardError::AtLeast(0.01);
                (rate, Mean { value, error })
            };
            (0..12).map(point).collect()
        };
        let plateau = curve(|_| 2.0);
        assert!(Superposition::find(&plateau, &plateau, 0.0).is_err());
        let power = curve(|rate| 1.0 / rate);
        assert!(Superposition::find(&power, &power, 1.0).is_err());
        let good = curve(master);
        assert!(Superposition::find(&good, &good[..3], 0.0).is_err());
        assert!(Superposition::find(&good, &good, f64::NAN).is_err());
        for bad in [0.0, -1.0, f64::NAN] {
            let mut points = good.clone();
            points[2].1.value = bad;
            assert!(Superposition::find(&good, &points, 0.0).is_err());
            let mut points = good.clone();
            points[2].0 = bad;
            assert!(Superposition::find(&points, &good, 0.0).is_err());
        }
    }
}
