//! Flows that change: start-up, cessation, a sudden strain, oscillation.

use super::model::Model;
use super::scene::{Experiment, Scene, isolated};
use super::theory::{rouse_times, rouse_transient};
use super::{GROUPS, KT, TRANSIENT};
use super::{chains, first_difference, seed, step_size, viscosity};
use crate::Problem;
use crate::options::{Options, Protocol};
use crate::panel::{INK, POLYMER, Panel, SOLUTION, Series, spread};
use crate::text::{Record, aligned, csv, json_line};
use indicatif::ProgressBar;
use plotters::prelude::*;
use serde_json::json;
use std::f64::consts::TAU;
use std::fs;
use std::io::{self, Write};
use std::marker::PhantomData;
use std::path::Path;
use zimm::prelude::*;

/// Strain amplitude of oscillations: small enough for linear response to a few per mille.
const AMPLITUDE: f64 = 0.1;
/// Periods of an oscillation that count.
const PERIODS: u64 = 4;
/// Moments of a period at which the stress is looked at.
const MOMENTS_OF_PERIOD: u64 = 32;
/// Moments at which a transient is looked at, and the first and the last of them in longest relaxation times.
const MOMENTS: u32 = 40;
const FIRST: f64 = 0.01;
const LAST: f64 = 6.0;

/// What is known of one moment of a transient, or of one frequency.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment {
    protocol: Protocol,
    rate: f64,
    /// Time, or angular frequency.
    pub(crate) at: f64,
    /// eta+(t), eta-(t), G(t) or G'(omega) over n kT, with lambda_H where there is a time in it.
    pub(crate) first: (Mean, Option<f64>),
    /// First normal stress difference over n kT, or G''(omega).
    pub(crate) second: (Mean, Option<f64>),
}

impl Protocol {
    /// What is measured.
    pub(crate) fn names(self) -> [&'static str; 3] {
        match self {
            Self::Oscillation => ["omega", "G'", "G''"],
            Self::Step => ["t", "G", "N_1"],
            _ => ["t", "eta", "N_1"],
        }
    }
}

impl Moment {
    pub(crate) fn record(&self) -> Record {
        let [at, first, second] = self.protocol.names();
        let protocol = format!("{:?}", self.protocol).to_lowercase();
        let mut record = vec![
            ("method".into(), json!("bd")),
            ("protocol".into(), json!(protocol)),
            ("rate".into(), json!(self.rate)),
            (at.into(), json!(self.at)),
        ];
        for (name, (mean, theory)) in [(first, self.first), (second, self.second)] {
            record.push((name.into(), json!(mean.value)));
            record.push((format!("{name}_error"), json!(mean.at_least())));
            record.push((format!("theory_{name}"), json!(theory)));
        }
        record
    }
}

/// All rates, as table, files and picture.
pub(crate) fn rheogram(
    options: &Options,
    model: &Model,
    protocol: Protocol,
    bar: &ProgressBar,
) -> Result<(), Problem> {
    if model.is_in_cell() {
        return Err("flows that change are for isolated chains: --hi none or rpy".into());
    }
    let mut curves = Vec::new();
    for &rate in &options.rates {
        let curve = match protocol {
            Protocol::Oscillation => Ok(vec![oscillation(options, model, rate, bar)?]),
            _ => transient(options, model, protocol, rate, bar),
        };
        curves.push(curve.map_err(|error| Problem::from(format!("rate {rate}: {error}")))?);
    }
    bar.finish_and_clear();
    if protocol == Protocol::Oscillation {
        curves = vec![curves.concat()];
    }
    let moments = curves.concat();
    let file = |extension| options.out.join(format!("rheometer.{extension}"));
    fs::write(file("csv"), csv(moments.iter().map(Moment::record)))?;
    draw(&file("svg"), &curves)?;
    let report = if options.json {
        moments.iter().map(|m| json_line(m.record())).collect()
    } else {
        let (csv, svg) = (file("csv"), file("svg"));
        let (csv, svg) = (csv.display(), svg.display());
        format!("{}written: {csv}, {svg}\n", table(&moments))
    };
    Ok(io::stdout().write_all(report.as_bytes())?)
}

/// The stress per chain over kT of one group at given steps.
struct Moments<'a, B> {
    steps: &'a [u64],
    space: PhantomData<B>,
}

impl<'a, B> Moments<'a, B> {
    fn new(steps: &'a [u64]) -> Self {
        let space = PhantomData;
        Self { steps, space }
    }
}

impl<B: Boundary> Experiment for Moments<'_, B> {
    type Space = B;
    type Answer = Vec<DMat3>;

    fn run<S, X, M, R>(&self, mut scene: Scene<B, S, X, M, R>) -> Result<Vec<DMat3>, Problem>
    where
        S: BondForce,
        X: ForceField<B>,
        M: Mobility<B>,
        R: Root<B, M>,
    {
        let mut kramers = ChainStress {
            molecules: scene.chains,
        };
        let mut stresses = Vec::new();
        for &step in self.steps {
            let virial: Virial = scene.go_to(step)?;
            let stress = kramers.measure(&scene.system.frame(), &virial)?;
            stresses.push(stress * (1.0 / KT));
        }
        Ok(stresses)
    }
}

/// The stress of all groups at given times: group by group, time by time. From each group's stress that of a twin at
/// rest is taken off, with the same start and the same noise: its mean is zero, and what the flow does not change drops
/// out (Wagner and Oettinger 1997).
fn stresses<H: FlowHistory>(
    options: &Options,
    model: &Model,
    rate: f64,
    space: &OpenFlow<H>,
    dt: f64,
    steps: &[u64],
    bar: &ProgressBar,
) -> Result<Vec<Vec<DMat3>>, Problem> {
    let rest = OpenFlow::with_history(DMat3::ZERO, ())?;
    replicas(GROUPS, |group| {
        let (seed, count) = (seed(options, rate, group), chains(options, model));
        let clock = Clock::new(dt, KT, seed)?;
        let mut stresses = isolated(&Moments::new(steps), model, count, space.clone(), clock)?;
        let twins = isolated(&Moments::new(steps), model, count, rest, clock)?;
        for (stress, twin) in stresses.iter_mut().zip(twins) {
            *stress -= twin;
        }
        bar.inc(1);
        Ok(stresses)
    })
}

/// Start-up, cessation or a sudden strain.
fn transient(
    options: &Options,
    model: &Model,
    protocol: Protocol,
    rate: f64,
    bar: &ProgressBar,
) -> Result<Vec<Moment>, Problem> {
    let (shape, time) = (options.flow.shape(options.mixedness), longest_time(model));
    let dt = step_size(model, rate).min(0.25 * FIRST * time);
    let before = match protocol {
        Protocol::Cessation => (TRANSIENT * time / dt).ceil() as u64,
        _ => 1,
    };
    let moment = |k: u32| FIRST * (LAST / FIRST).powf(f64::from(k) / f64::from(MOMENTS - 1));
    let mut steps: Vec<u64> = (0..MOMENTS)
        .map(|k| before + (moment(k) * time / dt).round() as u64)
        .collect();
    steps.dedup();
    let change = before as f64 * dt;
    let answer = |space, theory: Option<Vec<DMat3>>| (space, theory);
    let exact = |space: &dyn Fn(f64, f64) -> DMat3| {
        (model.is_rouse()).then(|| rouse_transient(model.beads, space, dt, &steps))
    };
    let (found, theory) = match protocol {
        Protocol::Step => {
            let space = OpenFlow::with_history(shape, StepStrain::new(rate, change)?)?;
            let theory = exact(&|from, to| space.carry(from, to));
            answer(
                stresses(options, model, rate, &space, dt, &steps, bar)?,
                theory,
            )
        }
        Protocol::Cessation => {
            let space = OpenFlow::with_history(shape, Cessation::new(rate, change)?)?;
            let theory = exact(&|from, to| space.carry(from, to));
            answer(
                stresses(options, model, rate, &space, dt, &steps, bar)?,
                theory,
            )
        }
        _ => {
            let space = OpenFlow::with_history(shape, StartUp::new(rate, change)?)?;
            let theory = exact(&|from, to| space.carry(from, to));
            answer(
                stresses(options, model, rate, &space, dt, &steps, bar)?,
                theory,
            )
        }
    };
    let reduced = |stress| viscosity(options.flow, shape * rate, stress);
    let mean = |k: usize, part: &dyn Fn(DMat3) -> f64| {
        let mut mean = EnsembleAverage::new();
        for (group, stresses) in (0..).zip(&found) {
            mean.push((group, part(stresses[k])));
        }
        mean.estimate()
    };
    (0..steps.len())
        .map(|k| {
            let exact = theory.as_ref().map(|stresses| stresses[k]);
            Ok(Moment {
                protocol,
                rate,
                at: (steps[k] - before) as f64 * dt,
                first: (mean(k, &reduced)?, exact.map(reduced)),
                second: (mean(k, &first_difference)?, exact.map(first_difference)),
            })
        })
        .collect()
}

/// G' and G'' at one angular frequency, by Fourier sums over whole periods.
fn oscillation(
    options: &Options,
    model: &Model,
    omega: f64,
    bar: &ProgressBar,
) -> Result<Moment, Problem> {
    let shape = options.flow.shape(options.mixedness);
    let between = (TAU / omega / MOMENTS_OF_PERIOD as f64 / step_size(model, omega)).ceil();
    let dt = TAU / omega / MOMENTS_OF_PERIOD as f64 / between;
    let period = MOMENTS_OF_PERIOD * between as u64;
    let before = (TRANSIENT * longest_time(model) / (period as f64 * dt)).ceil() as u64 * period;
    let moments = 1..=PERIODS * MOMENTS_OF_PERIOD;
    let steps: Vec<u64> = moments.map(|k| before + k * between as u64).collect();
    let space = OpenFlow::with_history(shape, Oscillation::new(AMPLITUDE, omega)?)?;
    let found = stresses(options, model, omega, &space, dt, &steps, bar)?;
    let modulus = |part: fn(f64) -> f64| {
        let mut mean = EnsembleAverage::new();
        for (group, stresses) in (0..).zip(&found) {
            for (&step, &stress) in steps.iter().zip(stresses) {
                let modulus = viscosity(options.flow, shape * AMPLITUDE, stress);
                mean.push((group, 2.0 * modulus * part(omega * step as f64 * dt)));
            }
        }
        mean.estimate()
    };
    let theory = |part: fn(f64) -> f64| {
        let modes = rouse_times(model.beads).map(|time| part(omega * time));
        (model.is_rouse()).then(|| options.flow.customary() * modes.sum::<f64>())
    };
    Ok(Moment {
        protocol: Protocol::Oscillation,
        rate: omega,
        at: omega,
        first: (modulus(f64::sin)?, theory(|x| x * x / (1.0 + x * x))),
        second: (modulus(f64::cos)?, theory(|x| x / (1.0 + x * x))),
    })
}

fn longest_time(model: &Model) -> f64 {
    rouse_times(model.beads).next().unwrap_or(1.0)
}

/// The table of all moments.
fn table(moments: &[Moment]) -> String {
    let Some(protocol) = moments.first().map(|moment| moment.protocol) else {
        return String::new();
    };
    let [at, first, second] = protocol.names();
    let names = ["rate", at, first, "theory", second, "theory"];
    let mut cells = vec![names.map(String::from)];
    let theory = |known: Option<f64>| known.map_or_else(String::new, |known| format!("{known:.5}"));
    for moment in moments {
        cells.push([
            moment.rate.to_string(),
            format!("{:.4}", moment.at),
            format!("{:#}", moment.first.0),
            theory(moment.first.1),
            format!("{:#}", moment.second.0),
            theory(moment.second.1),
        ]);
    }
    aligned(&cells)
}

/// Both quantities against time or frequency; one curve of theory a rate, as far as there is room for it.
fn draw(path: &Path, curves: &[Vec<Moment>]) -> Result<(), Problem> {
    let Some(protocol) = curves
        .first()
        .and_then(|curve| Some(curve.first()?.protocol))
    else {
        return Ok(());
    };
    let root = SVGBackend::new(path, (1000, 420)).into_drawing_area();
    root.fill(&WHITE)?;
    let (heading, body) = root.split_vertically(44);
    let style = TextStyle::from(("sans-serif", 22)).color(&INK);
    let title = "Bead-spring chains in Brownian dynamics, in units of kT, l_H, λ_H";
    heading.draw_text(title, &style, (24, 14))?;
    let panels = body.margin(0, 8, 8, 16).split_evenly((1, 2));
    let all = || curves.iter().flatten();
    let range = spread(all().map(|moment| moment.at), [1.2, 1.2]);
    let [at, first, second] = protocol.names();
    type Part = fn(&Moment) -> (Mean, Option<f64>);
    let parts: [(&'static str, Part); 2] = [(first, |m| m.first), (second, |m| m.second)];
    for (area, (title, part)) in panels.iter().zip(parts) {
        let colours = [POLYMER, SOLUTION, INK];
        let series: Vec<_> = (curves.iter().zip(colours.iter().cycle()))
            .map(|(curve, colour)| {
                let points = curve.iter().map(|m| (m.at, part(m).0)).collect();
                Series::new("chains", *colour, points)
            })
            .collect();
        let known = |m: &Moment| Some((m.at, part(m).1?));
        Panel {
            abscissa: at,
            title,
            series: &series,
            theory: ("exact", curves[0].iter().filter_map(known).collect()),
            level: None,
            legend: SeriesLabelPosition::LowerRight,
            room: [1.3, 1.8],
        }
        .draw_logarithmic(area, &range)?;
    }
    root.present()?;
    Ok(())
}
