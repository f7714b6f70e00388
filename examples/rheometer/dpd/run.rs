//! From samples to material functions.

use super::measure::Sample;
use super::report::Row;
use super::solute::Solute;
use super::{KT, LIMIT};
use crate::Problem;
use crate::flow::Flow;
use zimm::prelude::*;

/// A run in a flow and what was measured in it.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    /// The flow.
    pub(crate) flow: Flow,
    /// Its rate.
    pub(crate) rate: f64,
    /// What flows.
    pub(crate) solute: Solute,
    /// Steps before anything counts.
    pub(crate) transient: u64,
    /// Its velocity gradient.
    pub(crate) gradient: DMat3,
    /// All samples, the transient's among them.
    pub(crate) samples: Vec<Sample>,
}

impl Run {
    fn steady(&self) -> impl Iterator<Item = &Sample> {
        self.samples
            .iter()
            .filter(|sample| sample.step > self.transient)
    }

    fn average(&self, part: impl Fn(&Sample) -> f64) -> Result<Mean, AnalysisError> {
        let mut average = BlockAverage::new();
        self.steady().for_each(|sample| average.push(part(sample)));
        average.estimate()
    }

    /// Viscosity and (sigma_xx - sigma_yy) / rate^2 of a part of the stress.
    fn functions(&self, part: impl Fn(&Sample) -> DMat3) -> Result<[Mean; 2], Problem> {
        let mut viscosity = FlowViscosity::new(self.gradient)?;
        let mut difference = BlockAverage::new();
        for sample in self.steady() {
            let stress = part(sample);
            viscosity.push(stress);
            difference.push(stress.x_axis.x - stress.y_axis.y);
        }
        Ok([
            viscosity.estimate()?.times(self.flow.customary()),
            difference.estimate()?.times(self.rate.powi(-2)),
        ])
    }

    /// Viscosity of the solution, for those who watch.
    pub(crate) fn viscosity(&self) -> Result<Mean, Problem> {
        Ok(self.functions(|sample| sample.stress)?[0])
    }

    /// Friction of a bead by comparing Kramers' and Giesekus' stress.
    fn friction(&self) -> Result<Mean, Problem> {
        let mut drag = GiesekusDrag::new(self.gradient, KT)?;
        self.steady()
            .for_each(|sample| drag.push([sample.tension, sample.stretch]));
        Ok(drag.estimate()?.deformation)
    }

    /// The results, for molecules of this longest relaxation time.
    pub(crate) fn row(&self, relaxation: Mean) -> Result<Row, Problem> {
        let [viscosity, psi1] = self.functions(|sample| sample.stress)?;
        let [polymer_viscosity, polymer_psi1] = self.functions(|sample| sample.tension)?;
        let lambda = relaxation.value;
        let squared_length = |sample: &Sample| {
            let q = sample.ends;
            q.x_axis.x + q.y_axis.y + q.z_axis.z
        };
        let contour = self.solute.springs() * LIMIT;
        Ok(Row {
            flow: self.flow,
            rate: self.rate,
            solute: self.solute,
            deborah: lambda * self.rate,
            deborah_error: relaxation.at_least() * self.rate,
            viscosity,
            psi1,
            polymer_viscosity: polymer_viscosity.times(1.0 / (KT * lambda)),
            polymer_psi1: polymer_psi1.times(1.0 / (KT * lambda * lambda)),
            extension: self
                .average(squared_length)?
                .times(1.0 / (contour * contour)),
            temperature: self.average(|sample| sample.temperature)?,
            friction: self.friction()?,
            seconds: self.samples.last().map_or(0.0, |sample| sample.seconds),
        })
    }
}

/// The friction of a bead from all runs, each weighted by the inverse square of its error.
pub(crate) fn common_friction(runs: &[Run]) -> Result<Mean, Problem> {
    let each: Vec<Mean> = runs.iter().map(Run::friction).collect::<Result<_, _>>()?;
    let friction = Mean::combined(&each)?;
    let (value, error) = (friction.value, friction.at_least());
    if value.is_nan() || value < 4.0 * error {
        let why = "it has to be four errors above zero; longer runs or higher rates would help";
        return Err(format!("the friction of a bead is {value:.3} +- {error:.3}: {why}").into());
    }
    Ok(friction)
}
