//! What is read off one frame.

use super::solute::spring;
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
    /// Mean over molecules of the sum of Q F, with Q the connectors and F the tensions of their springs.
    /// The bare repulsion between two beads is left out: the solvent all but cancels it.
    pub(crate) tension: DMat3,
    /// Mean over molecules of twice the sum of R R over their beads, from their centre: Q Q of dumbbells.
    pub(crate) stretch: DMat3,
    /// Mean over molecules of R_e R_e, with R_e from end to end.
    pub(crate) ends: DMat3,
}

/// The molecules as an observable: the three tensors of a [`Sample`] that are theirs.
pub(crate) struct Chains {
    molecules: Molecules,
    spring: Fene,
}

impl Chains {
    pub(crate) fn new(molecules: Molecules) -> Result<Self, ParameterError> {
        Ok(Self {
            molecules,
            spring: spring()?,
        })
    }
}

impl<B: Boundary, T> Observable<B, T> for Chains {
    type Output = [DMat3; 3];

    fn measure(&mut self, frame: &Frame<'_, B>, _: &T) -> [DMat3; 3] {
        let position = |identity| frame.place(identity).map(|place| frame.positions[place]);
        let (mut tension, mut stretch, mut ends) = (DMat3::ZERO, DMat3::ZERO, DMat3::ZERO);
        let square = |q: DVec3| DMat3::from_cols(q.x * q, q.y * q, q.z * q);
        let mut connectors = Vec::new();
        for beads in self.molecules.iter() {
            connectors.clear();
            for i in beads.start + 1..beads.end {
                let (Some(first), Some(second)) = (position(i - 1), position(i)) else {
                    continue;
                };
                let q = frame.boundary.min_image(first - second);
                tension -= self.spring.force(q.length_squared()) * square(q);
                connectors.push(q);
            }
            // The sum over beads, from their centre, is that over pairs of beads over their number (Lagrange).
            for first in 0..connectors.len() {
                let mut between = DVec3::ZERO;
                for &connector in &connectors[first..] {
                    between += connector;
                    stretch += square(between);
                }
                if first == 0 {
                    ends += square(between);
                }
            }
        }
        let count = f64::from(self.molecules.count());
        let per_pair = 2.0 / f64::from(self.molecules.beads()) / count;
        [
            tension * (1.0 / count),
            stretch * per_pair,
            ends * (1.0 / count),
        ]
    }
}

/// Measures everything. The noise of a step knows nothing of its positions, so its stress is zero on average and only
/// scatters; it is left out.
pub(crate) fn measure<B: Periodic>(
    frame: &Frame<'_, B>,
    virial: &Virial,
    chains: &mut Chains,
    seconds: f64,
) -> Result<Sample, AnalysisError> {
    let stress = Stress.measure(frame, virial);
    let [tension, stretch, ends] = chains.measure(frame, virial);
    Ok(Sample {
        step: frame.now.step,
        seconds,
        temperature: KineticTemperature::default().measure(frame, virial)?.mean(),
        stress: symmetric(stress.total() - stress.item(Item::Random)),
        tension,
        stretch,
        ends,
    })
}

/// Central forces make a symmetric stress but for rounding; six components are kept in files.
fn symmetric(m: DMat3) -> DMat3 {
    0.5 * (m + m.transpose())
}
