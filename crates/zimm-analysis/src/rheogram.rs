//! Runs at several body forces as one flow curve.

use crate::StressProfileAverage;
use crate::{AnalysisError, Channel, FlowPoint, Jackknife, Mean, ShearFunctions};

/// Channels driven by several forces, joined: the material functions against the rate, and any function of them with
/// its error.
///
/// A layer is a point if its rate is clear of zero by four of its errors. The error of a function of the points is that
/// of a [`Jackknife`] that leaves out one block of one run at a time: runs are independent, the layers of a run are
/// not.
///
/// ```
/// use zimm_analysis::{AnalysisError, Carreau, Channel, Mean, Rheogram, StressProfileAverage};
///
/// fn time_of_thinning(slow: (Channel, StressProfileAverage), fast: (Channel, StressProfileAverage)) -> Result<Mean, AnalysisError> {
///     let rheogram = Rheogram::new(vec![slow, fast])?;
///     let fitted = rheogram.of(|points| Ok(vec![Carreau::fit(points, 42.0)?.time]))?;
///     Ok(fitted[0])
/// }
/// ```
#[derive(Clone, Debug)]
pub struct Rheogram {
    runs: Vec<(Channel, StressProfileAverage)>,
    /// The run, the layer and the point, by rising rate.
    points: Vec<(usize, usize, FlowPoint)>,
}

impl Rheogram {
    /// Of these runs.
    ///
    /// # Errors
    /// As [`Channel::layers`].
    pub fn new(runs: Vec<(Channel, StressProfileAverage)>) -> Result<Self, AnalysisError> {
        let mut points = Vec::new();
        for (run, (channel, average)) in runs.iter().enumerate() {
            for (k, layer) in channel.layers(average)?.into_iter().enumerate() {
                let (rate, stress) = (layer.rate, layer.imposed);
                if let Some(functions) = layer.functions {
                    let point = FlowPoint {
                        rate,
                        stress,
                        functions,
                    };
                    points.push((run, k, point));
                }
            }
        }
        points.sort_by(|(.., a), (.., b)| a.rate.value.total_cmp(&b.rate.value));
        Ok(Self { runs, points })
    }

    /// The points, by rising rate.
    pub fn points(&self) -> impl Iterator<Item = &FlowPoint> {
        self.points.iter().map(|(.., point)| point)
    }

    /// The values of a function of the points, each with its error. The function is called with the points of many
    /// jackknife samples, whose errors are always those of [`points`](Self::points).
    ///
    /// # Errors
    /// If the function fails or gives what is not finite.
    pub fn of(
        &self,
        function: impl Fn(&[FlowPoint]) -> Result<Vec<f64>, AnalysisError>,
    ) -> Result<Vec<Mean>, AnalysisError> {
        let mut sums = Vec::new();
        for (_, average) in &self.runs {
            sums.push(average.sums()?);
        }
        Jackknife::joint(&sums, |means| {
            let mut folded = Vec::new();
            for ((channel, average), means) in self.runs.iter().zip(means) {
                folded.push(channel.fold(average, means)?);
            }
            let moved = |(run, k, point): &(usize, usize, FlowPoint)| {
                let layer = folded.get(*run)?.get(*k)?;
                let with = |mean: Mean, value| Mean { value, ..mean };
                let [viscosity, psi1, psi2] = layer.functions();
                let functions = point.functions;
                Some(FlowPoint {
                    rate: with(point.rate, layer.rate()),
                    stress: with(point.stress, layer.imposed()),
                    functions: ShearFunctions {
                        viscosity: with(functions.viscosity, viscosity),
                        psi1: with(functions.psi1, psi1),
                        psi2: with(functions.psi2, psi2),
                    },
                })
            };
            let points: Vec<_> = self.points.iter().filter_map(moved).collect();
            function(&points)
        })
    }
}
