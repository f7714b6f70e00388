//! What is read off one frame.

use super::{Forces, REPULSION};
use zimm::prelude::*;

/// One measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample {
    /// Number of the step.
    pub(crate) step: u64,
    /// Wall time since the shear was switched on.
    pub(crate) seconds: f64,
    /// Kinetic temperature.
    pub(crate) temperature: f64,
    /// Stress of the solution.
    pub(crate) stress: DMat3,
    /// Mean over dumbbells of Q F.
    pub(crate) tension: DMat3,
    /// Mean over dumbbells of Q Q.
    pub(crate) stretch: DMat3,
}

/// The dumbbells as an observable: means of Q F and Q Q, with Q the connector and F the tension in it, spring less
/// repulsion.
pub(crate) struct Dumbbells {
    bonded: Bonded<Fene>,
    repulsion: DpdConservative,
}

impl Dumbbells {
    /// The dumbbells that these forces join.
    pub(crate) fn new((_, bonded): &Forces) -> Result<Self, ParameterError> {
        Ok(Self {
            bonded: bonded.clone(),
            repulsion: DpdConservative::new(REPULSION, 1.0)?,
        })
    }
}

impl<B: Boundary, T> Observable<B, T> for Dumbbells {
    type Output = [DMat3; 2];

    fn measure(&mut self, frame: &Frame<'_, B>, _: &T) -> [DMat3; 2] {
        let position = |identity| frame.place(identity).map(|place| frame.positions[place]);
        let (mut tension, mut stretch, mut count) = (DMat3::ZERO, DMat3::ZERO, 0.0);
        for &[i, j] in self.bonded.bonds() {
            let (Some(first), Some(second)) = (position(i), position(j)) else {
                continue;
            };
            let q = frame.boundary.min_image(first - second);
            let r2 = q.length_squared();
            let pair = Pair {
                r2,
                ..Pair::default()
            };
            let force =
                self.bonded.spring().force(r2) + self.repulsion.force(&pair, &frame.now).total();
            let qq = DMat3::from_cols(q.x * q, q.y * q, q.z * q);
            tension -= force * qq;
            stretch += qq;
            count += 1.0;
        }
        [tension * (1.0 / count), stretch * (1.0 / count)]
    }
}

/// Measures everything. The noise of a step knows nothing of its positions, so its stress is zero on average and only
/// scatters; it is left out.
pub(crate) fn measure<B: Periodic>(
    frame: &Frame<'_, B>,
    virial: &Virial,
    dumbbells: &mut Dumbbells,
    seconds: f64,
) -> Result<Sample, AnalysisError> {
    let stress = Stress.measure(frame, virial);
    let [tension, stretch] = dumbbells.measure(frame, virial);
    Ok(Sample {
        step: frame.now.step,
        seconds,
        temperature: KineticTemperature::default().measure(frame, virial)?.mean(),
        stress: symmetric(stress.total() - stress.item(Item::Random)),
        tension,
        stretch,
    })
}

/// Central forces make a symmetric stress but for rounding; six components are kept in files.
fn symmetric(m: DMat3) -> DMat3 {
    0.5 * (m + m.transpose())
}
