//! The solution in reverse Poiseuille flow: two channels above each other in one cell, driven to and fro by body forces.
//! Shear rates rise from nothing at the centre lines to the largest where the flow turns round.

use super::channel_report::{draw, summary};
use super::kept::Kept;
use super::{DT, Forces, KT, LIMIT, MEASUREMENT, QUICK_MEASUREMENT, Solution, TRANSIENT, spaces};
use crate::Problem;
use crate::options::Options;
use crate::text::{Record, csv, json_line, unsettled, with_errors};
use indicatif::ProgressBar;
use rayon::prelude::*;
use serde_json::json;
use std::fs;
use std::io::{self, Write};
use zimm::prelude::*;

/// Height of the cell, two channels.
const HEIGHT: f64 = 4.0 * LIMIT;
const QUICK_HEIGHT: f64 = 16.0;
const LAYERS_PER_LENGTH: f64 = 2.0;
/// Time in units of the square of a channel's height until the flow is what it stays, about five relaxation times of
/// the momentum.
const ONSET: f64 = 0.4;
const STEPS_PER_SAMPLE: u64 = 10;
const STEPS_PER_CHECKPOINT: u64 = 1000;
/// Share of half a channel from which zero-shear values are taken.
pub(crate) const CENTRE: f64 = 0.7;

type Driven<L> = (Forces<L>, ReversePoiseuille);

/// One body force and what it has shown.
pub(crate) struct Run {
    pub(crate) force: f64,
    pub(crate) channel: Channel,
    pub(crate) average: StressProfileAverage,
    pub(crate) layers: Vec<ChannelLayer>,
}

/// The results in one layer.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    /// The body force.
    pub(crate) force: f64,
    /// Distance from the centre line.
    pub(crate) distance: f64,
    /// Shear rate.
    pub(crate) rate: Mean,
    /// Imposed stress over the rate.
    pub(crate) viscosity: Mean,
    /// First normal stress coefficient.
    pub(crate) psi1: Mean,
    /// Second normal stress coefficient.
    pub(crate) psi2: Mean,
    /// Number density of the molecules' beads over that of the cell.
    pub(crate) concentration: Mean,
    /// Kinetic temperature.
    pub(crate) temperature: Mean,
}

impl Row {
    pub(crate) fn means(&self) -> [(&'static str, Mean); 6] {
        [
            ("rate", self.rate),
            ("viscosity", self.viscosity),
            ("psi1", self.psi1),
            ("psi2", self.psi2),
            ("concentration", self.concentration),
            ("temperature", self.temperature),
        ]
    }

    fn record(&self) -> Record {
        let mut record = vec![
            ("method".into(), json!("dpd")),
            ("flow".into(), json!("rpf")),
            ("force".into(), json!(self.force)),
            ("distance".into(), json!(self.distance)),
        ];
        record.extend(with_errors(&self.means()));
        record.push(("unsettled".into(), unsettled(&self.means())));
        record
    }
}

impl Run {
    /// A row for each layer whose rate is clear of zero.
    fn rows(&self, beads: f64) -> impl Iterator<Item = Row> {
        self.layers.iter().filter_map(move |layer| {
            let functions = layer.functions?;
            Some(Row {
                force: self.force,
                distance: layer.distance,
                rate: layer.rate,
                viscosity: functions.viscosity,
                psi1: functions.psi1,
                psi2: functions.psi2,
                concentration: layer.concentrations.get(1)?.times(1.0 / beads),
                temperature: layer.temperature,
            })
        })
    }
}

/// Build, warm up, let it flow at each body force, report.
pub(crate) fn rheogram<L, S>(solution: &Solution<'_, L, S>) -> Result<(), Problem>
where
    L: PairForce + Clone,
    S: Stepper<PeriodicBox, Forces<L>> + Stepper<PeriodicBox, Driven<L>> + Clone + Sync,
{
    let options = solution.options;
    let height = if options.quick { QUICK_HEIGHT } else { HEIGHT };
    let space = spaces::channels(height)?;
    let mut rest = solution.at_rest(space)?;
    let molecules = solution.molecules(space.lattice())?;
    let joined = molecules.iter().map(|beads| beads.len()).sum::<usize>();
    let in_molecule = |place| u8::from((rest.frame().id(place) as usize) < joined);
    let species = (0..rest.particles.len()).map(in_molecule).collect();
    rest.particles = rest.particles.with_species(species)?;

    let bar = super::progress_bar(options.forces.len() as u64 * last_step(options, height));
    let forces = options.forces.par_iter();
    let runs: Vec<Run> = forces
        .map(|&force| {
            let run = flowing(solution, &rest, force, &bar);
            run.map_err(|error| Problem::from(format!("body force {force}: {error}")))
        })
        .collect::<Result<_, _>>()?;
    bar.finish_and_clear();

    let beads = joined as f64 / space.lattice().volume();
    let rows: Vec<Row> = runs.iter().flat_map(|run| run.rows(beads)).collect();
    fs::write(
        options.out.join("rheometer.csv"),
        csv(rows.iter().map(Row::record)),
    )?;
    draw(&options.out.join("rheometer.svg"), options, &rows)?;
    let report = if options.json {
        rows.iter().map(|row| json_line(row.record())).collect()
    } else {
        let written = options.out.display();
        let summary = summary(&rows, &runs);
        format!("{summary}written: {written}/rheometer.csv, {written}/rheometer.svg\n")
    };
    Ok(io::stdout().write_all(report.as_bytes())?)
}

/// Switches the body force on and measures. The noise depends on seed and force alone.
fn flowing<L, S>(
    solution: &Solution<'_, L, S>,
    rest: &System<PeriodicBox>,
    force: f64,
    bar: &ProgressBar,
) -> Result<Run, Problem>
where
    L: PairForce + Clone,
    S: Stepper<PeriodicBox, Driven<L>> + Clone,
{
    let options = solution.options;
    let molecules = solution.molecules(rest.boundary.lattice())?;
    let height = rest.boundary.lattice().basis().y_axis.y;
    let layers = (LAYERS_PER_LENGTH * height) as usize;
    let profile = Profile::new(DVec3::Y, height, layers)?;
    let heard = LayeredVirial::new(&profile);
    let mut observable = StressProfile::new(profile, 2).without(Item::Random);
    let mut average = StressProfileAverage::new(&observable);

    let clock = Clock::new(DT, KT, options.seed ^ force.to_bits())?;
    let mut fluid = System::new(rest.boundary, rest.particles.clone(), clock);
    let kept = Kept::at(&options.out, &options.name_of_run(force));
    if !options.resume {
        kept.remove()?;
    } else if let Some(state) = kept.load_average(&fluid, &mut average)? {
        fluid = state;
    }
    let drive = ReversePoiseuille::new(force, 0, 1)?;
    let (mut forces, mut stepper) = (
        (solution.forces(&molecules)?, drive),
        solution.stepper.clone(),
    );
    let (done, last) = (fluid.clock.now().step, last_step(options, height));
    bar.inc(done.min(last));
    for step in done + 1..=last {
        if step > transient(options, height) && step.is_multiple_of(STEPS_PER_SAMPLE) {
            let mut heard = heard.fresh();
            stepper.step(&mut fluid, &mut forces, &mut heard)?;
            average.push(observable.measure(&fluid.frame(), &heard)?);
        } else {
            stepper.step(&mut fluid, &mut forces, &mut ())?;
        }
        if step.is_multiple_of(STEPS_PER_CHECKPOINT) {
            kept.save_average(&fluid, &mut forces, &average)?;
        }
        bar.inc(1);
    }
    let channel = Channel::new(DVec3::X, force)?;
    let run = Run {
        force,
        channel,
        layers: channel.layers(&average)?,
        average,
    };
    if let Ok(viscosity) = run.channel.viscosity(&run.average) {
        bar.println(format!(
            "body force {force}: viscosity of the parabola {viscosity:#}"
        ));
    }
    Ok(run)
}

/// Steps before anything counts: the molecules find their shape as they do in shear, and momentum its profile.
fn transient(options: &Options, height: f64) -> u64 {
    let time = TRANSIENT * 0.5 * f64::from(options.solute.chain);
    (time.max(ONSET * 0.25 * height * height) / DT).ceil() as u64
}

/// The step at which a run is done, always one with a checkpoint.
fn last_step(options: &Options, height: f64) -> u64 {
    let time = if options.quick {
        QUICK_MEASUREMENT
    } else {
        MEASUREMENT
    };
    let steps = transient(options, height) + (time / DT) as u64;
    steps.next_multiple_of(STEPS_PER_CHECKPOINT)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_a_record_has_each_number_once_and_its_error() {
        let mean = |value, error| Mean {
            value,
            error: StandardError::AtLeast(error),
        };
        let row = Row {
            force: 0.2,
            distance: 1.25,
            rate: mean(0.3, 0.01),
            viscosity: mean(4.0, 0.1),
            psi1: mean(5.0, 0.5),
            psi2: mean(-1.0, 0.5),
            concentration: mean(1.02, 0.01),
            temperature: mean(1.0, 0.001),
        };
        let text = csv([row.record(), row.record()]);
        let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
        assert!(lines.iter().all(|line| line.len() == 17), "{text}");
        let at = |name| lines[0].iter().position(|word| *word == name).unwrap();
        assert_eq!(lines[2][at("viscosity_error")], "0.1");
        assert_eq!(lines[2][at("distance")], "1.25");
        assert!(lines[1][16].starts_with("rate viscosity"));
    }
}
