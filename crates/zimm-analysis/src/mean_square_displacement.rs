//! Diffusion from displacements.

use crate::ladder::{Ladder, Rule};
use crate::{AnalysisError, Mean};
use std::f64::consts::PI;
use std::ops::RangeInclusive;
use zimm_core::{DVec3, Estimator, ParameterError};

/// The mean square displacement over lags from one sample to a quarter of the run, in memory that grows as the
/// logarithm of the run, and the diffusion coefficient from its slope:
///
/// ```text
/// D = (1/6) d<|r(t) - r(0)|^2> / dt        one third of which belongs to each axis
/// ```
///
/// The slope is the least squares line through the lags chosen. Its error, from the scatter of 64 to 128 stretches of
/// the run, or 2 or 4 of them together, knows of all correlations between lags.
///
/// The first 16 samples before each are compared with it, the 16 before among every second sample with every second,
/// and so on: lags are as in [`Autocorrelation`](crate::Autocorrelation), but nothing is averaged, so displacements
/// are exact at all.
///
/// A sample is the unwrapped positions of particles ([`Unwrapped`](crate::Unwrapped)) or molecules
/// ([`CentresOfMass`](crate::CentresOfMass)), at equal intervals of time. With the drift of N equal particles taken
/// off, displacements that are independent come out smaller by 1 - 1/N. A finite cell slows diffusion down:
/// [`periodic_correction`].
///
/// The other route to D is a third of the integral of the autocorrelation of [`Velocities`](crate::Velocities). It
/// shows when particles forget their velocities, needs samples much closer in time, and is exact only as far as its
/// trapezoidal rule is.
///
/// ```
/// use zimm_analysis::MeanSquareDisplacement;
/// use zimm_core::{DVec3, Estimator};
///
/// // Ballistic: r = t along x, so r^2 grows as t^2.
/// let mut displacement = MeanSquareDisplacement::new(0.5, 1..=2)?;
/// for step in 0..16 {
///     displacement.push(vec![DVec3::X * 0.5 * f64::from(step)]);
/// }
/// let diffusion = displacement.estimate()?;
/// assert_eq!(diffusion.times, [0.5, 1.0, 1.5, 2.0]);
/// assert_eq!(diffusion.displacement[3].value, 4.0);
/// assert!((diffusion.coefficient.value - 0.75 / 0.5 / 6.0).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct MeanSquareDisplacement {
    interval: f64,
    fit: RangeInclusive<u64>,
    ladder: Ladder<Squares, 3>,
    components: Vec<f64>,
    misfit: Option<AnalysisError>,
}

/// What displacements say of diffusion.
#[derive(Clone, Debug, PartialEq)]
pub struct Diffusion {
    /// The lag times.
    pub times: Vec<f64>,
    /// The mean square displacement at each lag, in length squared.
    pub displacement: Vec<Mean>,
    /// The diffusion coefficient, in length squared over time.
    pub coefficient: Mean,
    /// The diffusion coefficient along each axis.
    pub axes: [Mean; 3],
}

#[derive(Clone, Debug)]
struct Squares;

impl Rule<3> for Squares {
    const AVERAGES: bool = false;

    fn compare(now: &[f64], then: &[f64]) -> [f64; 3] {
        let mut squares = [0.0; 3];
        for (a, b) in now.as_chunks::<3>().0.iter().zip(then.as_chunks::<3>().0) {
            for ((square, a), b) in squares.iter_mut().zip(a).zip(b) {
                *square += (a - b) * (a - b);
            }
        }
        squares
    }
}

/// Samples of a level, and how many one of the next level stands for.
const LEVELS: (usize, usize) = (16, 2);

impl MeanSquareDisplacement {
    /// Samples come at this interval of time; the lags within `fit`, in intervals, make the slope. Each sample costs
    /// 32 comparisons of all positions, and memory holds 16 sets of them for every doubling of the run beyond 16
    /// samples.
    ///
    /// # Errors
    /// If the interval is not above zero, or `fit` holds fewer than two of the lags 1 to 16, 18 to 32 by 2, 36 to 64
    /// by 4, and so on, or zero.
    pub fn new(interval: f64, fit: RangeInclusive<usize>) -> Result<Self, ParameterError> {
        let interval = ParameterError::positive("interval", interval)?;
        let (first, last) = (*fit.start() as u64, *fit.end() as u64);
        // From one power of two to the next there are eight lags.
        let next = |lag: u64| {
            let apart = 1 << (lag / 8).max(1).ilog2();
            (lag / apart + 1).saturating_mul(apart)
        };
        let start = if first > 0 { next(first - 1) } else { 0 };
        if first < 1 || next(start) > last {
            let allowed = "1 or more, and hold two lags or more";
            return Err(ParameterError::new("fit", first as f64, allowed));
        }
        Ok(Self {
            interval,
            fit: first..=last,
            ladder: Ladder::new(LEVELS.0, LEVELS.1),
            components: Vec::new(),
            misfit: None,
        })
    }

    /// Number of samples.
    pub fn samples(&self) -> u64 {
        self.ladder.samples()
    }

    /// What each lag counts in the slope, from lag zero to the last of the fit.
    fn slope(&self, last: usize) -> Vec<f64> {
        let lag = |k: usize| self.ladder.position(k);
        let fitted = || (0..=last).map(lag).filter(|lag| self.fit.contains(lag));
        let count = fitted().count() as f64;
        let middle = fitted().map(|lag| lag as f64).sum::<f64>() / count;
        let square: f64 = fitted().map(|lag| (lag as f64 - middle).powi(2)).sum();
        let weight = |lag: u64| {
            if self.fit.contains(&lag) {
                (lag as f64 - middle) / (square * self.interval)
            } else {
                0.0
            }
        };
        (0..=last).map(|k| weight(lag(k))).collect()
    }
}

impl Estimator for MeanSquareDisplacement {
    type Sample = Vec<DVec3>;
    type Estimate = Result<Diffusion, AnalysisError>;

    fn push(&mut self, positions: Vec<DVec3>) {
        let expected = if self.ladder.samples() == 0 {
            positions.len()
        } else {
            self.components.len() / 3
        };
        if positions.len() != expected || expected == 0 {
            self.misfit.get_or_insert(AnalysisError::Length {
                sample: self.ladder.samples(),
                found: positions.len(),
                expected: expected.max(1),
            });
            return;
        }
        self.components.clear();
        let components = positions.iter().flat_map(|r| r.to_array());
        self.components.extend(components);
        self.ladder.push(&self.components);
    }

    fn estimate(&self) -> Self::Estimate {
        if let Some(misfit) = &self.misfit {
            return Err(misfit.clone());
        }
        let lags = self.ladder.lags()?;
        let last = self.ladder.lag_until(*self.fit.end())?;
        let slope = self.slope(last);
        let each = 3.0 / self.components.len() as f64;
        let of = |squares: &[[f64; 3]]| {
            let mut along = DVec3::ZERO;
            for (&weight, &square) in slope.iter().zip(squares) {
                along += weight * DVec3::from_array(square);
            }
            let mut found = vec![
                along.element_sum() / 6.0,
                along.x / 2.0,
                along.y / 2.0,
                along.z / 2.0,
            ];
            found.extend(squares.iter().map(|square| square.iter().sum::<f64>()));
            found
        };
        let uses = |i: usize| if i < 4 { last + 1 } else { i - 3 };
        let found = self.ladder.estimate(lags, of, uses);
        let found: Vec<Mean> = found.into_iter().map(|mean| mean.times(each)).collect();
        let [total, x, y, z, _, squares @ ..] = &found[..] else {
            return Err(AnalysisError::TooFew {
                what: "samples",
                found: self.samples(),
                needed: 2,
            });
        };
        Ok(Diffusion {
            times: (1..lags)
                .map(|k| self.ladder.position(k) as f64 * self.interval)
                .collect(),
            displacement: squares.to_vec(),
            coefficient: *total,
            axes: [*x, *y, *z],
        })
    }
}

/// What a cubic cell of this edge takes off a diffusion coefficient by the hydrodynamic interaction of a particle with
/// its images, to be added to what is measured:
///
/// ```text
/// D(infinite) = D(L) + 2.837297 kT / (6 pi eta L)
/// ```
///
/// (Duenweg and Kremer, J. Chem. Phys. 99, 6983, 1993; Yeh and Hummer, J. Phys. Chem. B 108, 15873, 2004.)
///
/// ```
/// # use zimm_analysis::periodic_correction;
/// let correction = periodic_correction(1.0, 1.0, 10.0)?;
/// assert!((correction - 0.01505).abs() < 1e-5);
/// # Ok::<(), zimm_core::ParameterError>(())
/// ```
///
/// # Errors
/// If a parameter is not above zero.
pub fn periodic_correction(kt: f64, viscosity: f64, edge: f64) -> Result<f64, ParameterError> {
    /// The constant of the simple cubic lattice (Hasimoto 1959).
    const SIMPLE_CUBIC: f64 = 2.837_297_479_480_62;
    let kt = ParameterError::positive("kt", kt)?;
    let viscosity = ParameterError::positive("viscosity", viscosity)?;
    let edge = ParameterError::positive("edge", edge)?;
    Ok(SIMPLE_CUBIC * kt / (6.0 * PI * viscosity * edge))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Unwrapped;
    use crate::scene::{Cell, Random, step, system};
    use zimm_core::{Observable, Particles};

    // 50 walkers with normal steps of variance 2 D dt along each axis, D = 0.3, 0.2, 0.1, dt = 0.5, wrapped into a
    // tilted cell that they cross many times; the drift taken off leaves D (1 - 1/50). Seed 61, 4000 steps. The slope
    // of the first 8 lags of 4000 origins and 150 components has a standard error near 0.5 %; the estimate's own error
    // must be below 0.8 %, and the bound is 4 of it: 3 %. The displacement at lag 8 likewise (its error below 2 %,
    // bound 8 %).
    #[test]
    fn limit_random_walkers_in_a_cell() {
        let (n, diffusion, interval) = (50, DVec3::new(0.3, 0.2, 0.1), 0.5);
        let cell = Cell::lees_edwards(DVec3::new(3.0, 2.0, 2.5), 1.2);
        let particles = Particles::new(vec![DVec3::ZERO; n])
            .unwrap()
            .counting_images();
        let (mut system, mut random) = (system(cell, particles), Random::new(61));
        let width = DVec3::from_array((2.0 * interval * diffusion).to_array().map(f64::sqrt));
        let mut displacement = MeanSquareDisplacement::new(interval, 1..=8).unwrap();
        for _ in 0..4000 {
            step(&mut system, || width * random.normal3());
            displacement.push(Unwrapped.measure(&system.frame(), &()).unwrap());
        }
        let found = displacement.estimate().unwrap();
        let without_drift = 1.0 - 1.0 / n as f64;
        let holds = |mean: &Mean, exact: f64, precision: f64| {
            let error = mean.standard_error().unwrap();
            assert!(error < precision * exact, "{mean}");
            assert!(
                (mean.value - exact).abs() < 4.0 * error,
                "{mean} against {exact}"
            );
        };
        holds(&found.coefficient, 0.2 * without_drift, 0.008);
        for (mean, exact) in found.axes.iter().zip(diffusion.to_array()) {
            holds(mean, exact * without_drift, 0.014);
        }
        holds(
            &found.displacement[7],
            6.0 * 0.2 * 8.0 * interval * without_drift,
            0.02,
        );
    }

    #[test]
    fn reference_periodic_correction() {
        // 2.837297 / (6 pi) = 0.150522
        approx::assert_relative_eq!(
            periodic_correction(2.0, 0.5, 4.0).unwrap(),
            0.150_522,
            max_relative = 1e-5
        );
        assert!(periodic_correction(1.0, 0.0, 1.0).is_err());
        assert!(periodic_correction(1.0, 1.0, f64::INFINITY).is_err());
    }

    #[test]
    fn extreme_bad_fits_and_samples_are_errors() {
        for (first, last) in [(0, 2), (2, 2), (3, 2), (17, 19), (33, 39)] {
            let fit = first..=last;
            assert!(MeanSquareDisplacement::new(0.1, fit).is_err());
        }
        for (first, last) in [(15, 16), (16, 18), (17, 20), (32, 36), (1000, 2000)] {
            let fit = first..=last;
            assert!(MeanSquareDisplacement::new(0.1, fit).is_ok());
        }
        assert!(MeanSquareDisplacement::new(0.0, 1..=4).is_err());
        // Lags 16 and 18 are what there is of this fit, so that 72 samples show it.
        let mut between = MeanSquareDisplacement::new(0.1, 16..=19).unwrap();
        for found in 0..73 {
            let needed = if found < 2 { 2 } else { 72 };
            let what = "samples";
            let expected = AnalysisError::TooFew {
                what,
                found,
                needed,
            };
            let estimate = between.estimate();
            assert_eq!(estimate.err(), (found < 72).then_some(expected));
            between.push(vec![DVec3::X; 3]);
        }
        let fresh = MeanSquareDisplacement::new(0.1, 1..=2).unwrap();
        let mut short = fresh.clone();
        for found in 0..8 {
            let (what, needed) = ("samples", if found < 2 { 2 } else { 8 });
            assert_eq!(
                short.estimate(),
                Err(AnalysisError::TooFew {
                    what,
                    found,
                    needed
                })
            );
            short.push(vec![DVec3::ZERO]);
        }
        assert!(short.estimate().is_ok());
        short.push(vec![DVec3::ZERO; 2]);
        assert!(matches!(
            short.estimate(),
            Err(AnalysisError::Length {
                sample: 8,
                found: 2,
                expected: 1
            })
        ));
        let mut empty = fresh.clone();
        empty.push(vec![]);
        assert!(matches!(
            empty.estimate(),
            Err(AnalysisError::Length { sample: 0, .. })
        ));
        let mut wild = fresh;
        (0..9).for_each(|k| wild.push(vec![DVec3::X / (3 - k) as f64]));
        assert!(matches!(
            wild.estimate(),
            Err(AnalysisError::NotFinite { .. })
        ));
    }
}
