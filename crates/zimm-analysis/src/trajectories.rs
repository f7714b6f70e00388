//! Means over independent trajectories.

use crate::{AnalysisError, StandardError};
use std::collections::BTreeMap;

/// The mean of `D` quantities over each trajectory.
#[derive(Clone, Debug)]
pub(crate) struct Trajectories<const D: usize> {
    means: BTreeMap<u64, Running<D>>,
    samples: u64,
    not_finite: Option<u64>,
}

#[derive(Clone, Debug)]
struct Running<const D: usize> {
    samples: u64,
    mean: [f64; D],
}

impl<const D: usize> Default for Trajectories<D> {
    fn default() -> Self {
        Self {
            means: BTreeMap::new(),
            samples: 0,
            not_finite: None,
        }
    }
}

/// Fewest trajectories whose scatter is called an error: 95 % intervals of normal means then cover 91 %.
const FEWEST: usize = 8;

impl<const D: usize> Trajectories<D> {
    pub(crate) fn push(&mut self, trajectory: u64, sample: [f64; D]) {
        if self.not_finite.is_none() && !sample.iter().all(|x| x.is_finite()) {
            self.not_finite = Some(self.samples);
        }
        self.samples += 1;
        let running = self.means.entry(trajectory).or_insert(Running {
            samples: 0,
            mean: [0.0; D],
        });
        running.samples += 1;
        let weight = 1.0 / running.samples as f64;
        for (mean, x) in running.mean.iter_mut().zip(sample) {
            *mean += weight * (x - *mean);
        }
    }

    pub(crate) fn count(&self) -> usize {
        self.means.len()
    }

    /// The means over all trajectories, each counted once.
    pub(crate) fn means(&self) -> Result<[f64; D], AnalysisError> {
        if let Some(sample) = self.not_finite {
            let what = "a quantity";
            return Err(AnalysisError::NotFinite { what, sample });
        }
        if self.count() < 2 {
            return Err(AnalysisError::TooFew {
                what: "trajectories",
                found: self.count() as u64,
                needed: 2,
            });
        }
        let mut mean = [0.0; D];
        for running in self.means.values() {
            for (mean, x) in mean.iter_mut().zip(running.mean) {
                *mean += x / self.count() as f64;
            }
        }
        Ok(mean)
    }

    /// The error of the mean of sum_k w_k x_k.
    pub(crate) fn error(&self, w: [f64; D]) -> StandardError {
        let combined = |running: &Running<D>| -> f64 {
            w.iter().zip(running.mean).map(|(w, x)| w * x).sum::<f64>()
        };
        let (count, freedom) = (self.count() as f64, (self.count().max(2) - 1) as f64);
        let mean = self.means.values().map(combined).sum::<f64>() / count;
        let deviation = |running| (combined(running) - mean).powi(2);
        let square: f64 = self.means.values().map(deviation).sum();
        let error = (square / (count * freedom)).sqrt();
        if self.count() < FEWEST {
            StandardError::AtLeast(error)
        } else {
            StandardError::Plateau {
                error,
                uncertainty: error / (2.0 * freedom).sqrt(),
            }
        }
    }
}
