//! Diffusion from displacements.

use crate::{AnalysisError, BlockAverage, BlockAverages, Mean};
use std::collections::VecDeque;
use std::f64::consts::PI;
use std::ops::RangeInclusive;
use zimm_core::{DVec3, Estimator, ParameterError};

/// The mean square displacement over a number of lags, each sample the origin of all of them, and the diffusion
/// coefficient from its slope:
///
/// ```text
/// D = (1/6) d<|r(t) - r(0)|^2> / dt        one third of which belongs to each axis
/// ```
///
/// The slope is the least squares line through the lags chosen, computed for every origin; so its error, from block
/// averages over origins, knows of all correlations between lags.
///
/// A sample is the unwrapped positions of particles ([`Unwrapped`](crate::Unwrapped)) or molecules
/// ([`CentresOfMass`](crate::CentresOfMass)), at equal intervals of time. With the drift of N equal particles taken
/// off, displacements that are independent come out smaller by 1 - 1/N. A finite cell slows diffusion down:
/// [`periodic_correction`].
///
/// ```
/// use zimm_analysis::MeanSquareDisplacement;
/// use zimm_core::{DVec3, Estimator};
///
/// // Ballistic: r = t along x, so r^2 grows as t^2.
/// let mut displacement = MeanSquareDisplacement::new(0.5, 4, 1..=2)?;
/// for step in 0..8 {
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
    lags: usize,
    weights: Vec<f64>,
    history: VecDeque<Vec<DVec3>>,
    displacement: BlockAverages,
    slopes: [BlockAverage; 4],
    samples: u64,
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

impl MeanSquareDisplacement {
    /// Samples come at this interval of time; displacements are kept for lags of 1 to `lags` intervals, and those in
    /// `fit` make the slope. It costs `lags` sets of positions in memory, and as many differences a sample.
    ///
    /// # Errors
    /// If the interval is not above zero, or `fit` is not within 1 to `lags` or holds fewer than two lags.
    pub fn new(
        interval: f64,
        lags: usize,
        fit: RangeInclusive<usize>,
    ) -> Result<Self, ParameterError> {
        let interval = ParameterError::positive("interval", interval)?;
        let (first, last) = (*fit.start(), *fit.end());
        if first < 1 || last > lags || first >= last {
            let found = if last > lags { last } else { first } as f64;
            let allowed = "within 1 to `lags`, and hold two lags or more";
            return Err(ParameterError::new("fit", found, allowed));
        }
        let middle = 0.5 * (first + last) as f64;
        let square: f64 = fit
            .clone()
            .map(|k| (k as f64 - middle) * (k as f64 - middle))
            .sum();
        let weight = |k: usize| {
            if fit.contains(&k) {
                (k as f64 - middle) / (square * interval)
            } else {
                0.0
            }
        };
        Ok(Self {
            interval,
            lags,
            weights: (1..=lags).map(weight).collect(),
            history: VecDeque::with_capacity(lags),
            displacement: BlockAverages::new(lags),
            slopes: Default::default(),
            samples: 0,
            misfit: None,
        })
    }

    /// Squared displacements along each axis since every sample kept, averaged over particles; the latest first.
    fn squares<'a>(&'a self, now: &'a [DVec3]) -> impl Iterator<Item = DVec3> + 'a {
        self.history.iter().rev().map(move |then| {
            let sum: DVec3 = now.iter().zip(then).map(|(a, b)| (a - b) * (a - b)).sum();
            sum / now.len().max(1) as f64
        })
    }
}

impl Estimator for MeanSquareDisplacement {
    type Sample = Vec<DVec3>;
    type Estimate = Result<Diffusion, AnalysisError>;

    fn push(&mut self, positions: Vec<DVec3>) {
        let expected = self.history.front().map_or(positions.len(), Vec::len);
        if positions.len() != expected || expected == 0 {
            self.misfit.get_or_insert(AnalysisError::Length {
                sample: self.samples,
                found: positions.len(),
                expected: expected.max(1),
            });
        } else if self.history.len() == self.lags {
            let squares: Vec<DVec3> = self.squares(&positions).collect();
            let totals: Vec<f64> = squares.iter().map(|s| s.element_sum()).collect();
            self.displacement.take(&totals);
            let slope: DVec3 = squares
                .iter()
                .zip(&self.weights)
                .map(|(&s, &w)| w * s)
                .sum();
            let coefficients = [
                slope.element_sum() / 6.0,
                slope.x / 2.0,
                slope.y / 2.0,
                slope.z / 2.0,
            ];
            for (average, coefficient) in self.slopes.iter_mut().zip(coefficients) {
                average.push(coefficient);
            }
            self.history.pop_front();
            self.history.push_back(positions);
        } else {
            self.history.push_back(positions);
        }
        self.samples += 1;
    }

    fn estimate(&self) -> Self::Estimate {
        if let Some(misfit) = &self.misfit {
            return Err(misfit.clone());
        }
        let needed = self.lags as u64 + 2;
        if self.samples < needed {
            return Err(AnalysisError::TooFew {
                what: "samples",
                found: self.samples,
                needed,
            });
        }
        let [total, x, y, z] = &self.slopes;
        Ok(Diffusion {
            times: (1..=self.lags).map(|k| k as f64 * self.interval).collect(),
            displacement: self.displacement.estimate()?,
            coefficient: total.estimate()?,
            axes: [x.estimate()?, y.estimate()?, z.estimate()?],
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
        let mut displacement = MeanSquareDisplacement::new(interval, 8, 1..=8).unwrap();
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
        for (first, last) in [(0, 2), (2, 2), (3, 2), (2, 5)] {
            let fit = first..=last;
            assert!(MeanSquareDisplacement::new(0.1, 4, fit).is_err());
        }
        assert!(MeanSquareDisplacement::new(0.0, 4, 1..=4).is_err());
        let fresh = MeanSquareDisplacement::new(0.1, 2, 1..=2).unwrap();
        let mut short = fresh.clone();
        for found in 0..4 {
            let (what, needed) = ("samples", 4);
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
                sample: 4,
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
        (0..6).for_each(|k| wild.push(vec![DVec3::X / (3 - k) as f64]));
        assert!(matches!(
            wild.estimate(),
            Err(AnalysisError::NotFinite { .. })
        ));
    }
}
