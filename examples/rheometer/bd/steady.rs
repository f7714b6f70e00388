//! Steady flow: a row for each rate.

use super::model::Model;
use super::scene::{Experiment, Scene, in_cell, isolated};
use super::theory::{self, Averages};
use super::{FRICTION, GROUPS, GROUPS_IN_CELLS, KT, TRANSIENT};
use super::{chains, first_difference, seed, step_size, viscosity};
use crate::Problem;
use crate::flow::Flow;
use crate::options::Options;
use crate::panel::{INK, POLYMER, Panel, Series, spread};
use crate::text::{Record, aligned, csv, json_line, with_errors};
use indicatif::ProgressBar;
use plotters::prelude::*;
use serde_json::json;
use std::fs;
use std::io::{self, Write};
use std::marker::PhantomData;
use std::path::Path;
use std::time::Instant;
use zimm::prelude::*;

/// Time that counts, in longest relaxation times.
const MEASUREMENT: f64 = 20.0;
/// Strain in which a coil unfolds.
const UNFOLDING: f64 = 15.0;

/// All rates, as table, files and picture.
pub(crate) fn rheogram(options: &Options, model: &Model, bar: &ProgressBar) -> Result<(), Problem> {
    let mut rows = Vec::new();
    for &rate in &options.rates {
        let row = row(options, model, rate, bar);
        let row = row.map_err(|error| Problem::from(format!("rate {rate}: {error}")))?;
        bar.println(format!("rate {rate}: viscosity {:#}", row.viscosity));
        rows.push(row);
    }
    bar.finish_and_clear();
    let file = |extension| options.out.join(format!("rheometer.{extension}"));
    fs::write(file("csv"), csv(rows.iter().map(Row::record)))?;
    draw(&file("svg"), options.flow, &rows)?;
    let report = if options.json {
        rows.iter().map(|row| json_line(row.record())).collect()
    } else {
        let (csv, svg) = (file("csv"), file("svg"));
        format!(
            "{}written: {}, {}\n",
            table(&rows),
            csv.display(),
            svg.display()
        )
    };
    Ok(io::stdout().write_all(report.as_bytes())?)
}

/// The results at one rate, in units of kT, l_H and lambda_H.
#[derive(Clone, Copy, Debug)]
struct Row {
    flow: Flow,
    rate: f64,
    viscosity: Mean,
    first_difference: Mean,
    end_to_end: Mean,
    theory: Option<(f64, Averages)>,
    dt: f64,
    seconds: f64,
}

impl Row {
    fn record(&self) -> Record {
        let mut record = vec![
            ("method".into(), json!("bd")),
            ("flow".into(), json!(self.flow.name())),
            ("rate".into(), json!(self.rate)),
        ];
        record.extend(with_errors(&[
            ("viscosity", self.viscosity),
            ("first_normal_difference", self.first_difference),
            ("end_to_end_squared", self.end_to_end),
        ]));
        let theory = |part: fn(&(f64, Averages)) -> f64| json!(self.theory.as_ref().map(part));
        record.extend([
            (
                "theory_viscosity".into(),
                theory(|(viscosity, _)| *viscosity),
            ),
            (
                "theory_first_normal_difference".into(),
                theory(|(_, averages)| first_difference(averages.stress)),
            ),
            (
                "theory_end_to_end_squared".into(),
                theory(|(_, averages)| averages.end_to_end),
            ),
            ("dt".into(), json!(self.dt)),
            ("seconds".into(), json!(self.seconds)),
        ]);
        record
    }
}

fn groups(model: &Model) -> u64 {
    if model.is_in_cell() {
        GROUPS_IN_CELLS
    } else {
        GROUPS
    }
}

/// One rate: all groups, then their means.
fn row(options: &Options, model: &Model, rate: f64, bar: &ProgressBar) -> Result<Row, Problem> {
    let start = Instant::now();
    let gradient = options.flow.shape(options.mixedness) * rate;
    let dt = step_size(model, rate);
    let flowing = |group| -> Result<_, Problem> {
        let clock = Clock::new(dt, KT, seed(options, rate, group))?;
        let samples = if model.is_in_cell() {
            in_a_cell(options, model, rate, clock)
        } else {
            let (space, count) = (OpenFlow::new(gradient)?, chains(options, model));
            isolated(
                &SteadyFlow::new(options, model, rate),
                model,
                count,
                space,
                clock,
            )
        };
        bar.inc(1);
        samples
    };
    let groups = replicas(groups(model), flowing)?;
    let [mut eta, mut difference, mut square] = [(); 3].map(|()| EnsembleAverage::new());
    for (group, samples) in (0..).zip(groups) {
        for (stress, end_to_end) in samples {
            eta.push((group, viscosity(options.flow, gradient, stress)));
            difference.push((group, first_difference(stress)));
            square.push((group, end_to_end));
        }
    }
    let theory = theory::steady(model, gradient);
    Ok(Row {
        flow: options.flow,
        rate,
        viscosity: eta.estimate()?,
        first_difference: difference.estimate()?,
        end_to_end: square.estimate()?,
        theory: theory.map(|exact| (viscosity(options.flow, gradient, exact.stress), exact)),
        dt,
        seconds: start.elapsed().as_secs_f64(),
    })
}

/// Chains in the cell of the flow.
fn in_a_cell(
    options: &Options,
    model: &Model,
    rate: f64,
    clock: Clock,
) -> Result<Samples, Problem> {
    let history = Steady::new(rate)?;
    // Springs must not meet their images; and there should be some chains.
    const FEWEST: f64 = 8.0;
    let volume = FEWEST * f64::from(model.beads) / model.bead_concentration()?;
    let reach = model.spring().limit().min(8.0).max(0.5 * volume.cbrt());
    match options.flow {
        Flow::Shear | Flow::Rpf => {
            let space = LeesEdwards::new(DVec3::splat(2.0 * reach), history)?;
            in_cell(&SteadyFlow::new(options, model, rate), model, space, clock)
        }
        Flow::Extension => {
            let space = KraynikReinelt::box_for_cutoff(reach, history)?;
            in_cell(&SteadyFlow::new(options, model, rate), model, space, clock)
        }
        Flow::Mixed => {
            let space = PlanarMixed::box_for_cutoff(reach, options.mixedness, history)?;
            in_cell(&SteadyFlow::new(options, model, rate), model, space, clock)
        }
        Flow::Uniaxial => {
            let space = UniaxialExtension::box_for_cutoff(reach, history)?;
            in_cell(&SteadyFlow::new(options, model, rate), model, space, clock)
        }
    }
}

/// Stress per chain over kT and mean square distance of the ends, again and again.
type Samples = Vec<(DMat3, f64)>;

/// Chains in a steady flow.
struct SteadyFlow<B> {
    flow: Flow,
    rate: f64,
    /// Length at which a spring ends.
    limit: f64,
    /// Whether the positions of the beads tell the stress.
    is_free_draining: bool,
    space: PhantomData<B>,
}

impl<B> SteadyFlow<B> {
    fn new(options: &Options, model: &Model, rate: f64) -> Self {
        Self {
            flow: options.flow,
            rate,
            limit: model.spring().limit(),
            is_free_draining: model.is_free_draining(),
            space: PhantomData,
        }
    }
}

impl<B: Boundary> Experiment for SteadyFlow<B> {
    type Space = B;
    type Answer = Samples;

    fn run<S, X, M, R>(&self, mut scene: Scene<B, S, X, M, R>) -> Result<Samples, Problem>
    where
        S: BondForce,
        X: ForceField<B>,
        M: Mobility<B>,
        R: Root<B, M>,
    {
        let molecules = scene.chains;
        // What is stretched to its limit relaxes faster than a coil: in shear with the rate to the power 2/3, in
        // extension, which stretches from a rate of one relaxation time on, with the rate. A coil needs some strain to
        // unfold.
        let time = scene.longest_time();
        let time = match self.flow {
            Flow::Shear | Flow::Rpf | Flow::Mixed => {
                let contour = self.limit * f64::from(molecules.beads() - 1).sqrt();
                time * (self.rate * time / contour).max(1.0).powf(-2.0 / 3.0)
            }
            Flow::Extension | Flow::Uniaxial => time / (self.rate * time).max(1.0),
        };
        let before = TRANSIENT * time + UNFOLDING / self.rate.max(1.0);
        let mut giesekus = GiesekusStress {
            molecules,
            friction: |_| FRICTION,
        };
        let (mut kramers, mut ends) = (ChainStress { molecules }, EndToEnd { molecules });
        let between = scene.step_at(0.25 * time);
        let transient = scene.step_at(before);
        let samples = (MEASUREMENT / 0.25) as u64;
        let mut answer = Vec::new();
        for sample in 1..=samples {
            let virial: Virial = scene.go_to(transient + sample * between)?;
            let frame = scene.system.frame();
            let stress = if self.is_free_draining {
                giesekus.measure(&frame, &())?
            } else {
                kramers.measure(&frame, &virial)?
            };
            let ends = ends.measure(&frame, &())?;
            let square = ends.iter().map(|r| r.length_squared()).sum::<f64>();
            answer.push((stress * (1.0 / KT), square / ends.len() as f64));
        }
        Ok(answer)
    }
}

fn table(rows: &[Row]) -> String {
    let names = [
        "rate", "eta", "theory", "N_1", "theory", "<R_e^2>", "theory", "dt", "s",
    ];
    let mut cells = vec![names.map(String::from)];
    for row in rows {
        let theory = |part: fn(&(f64, Averages)) -> f64| {
            let known = row.theory.as_ref();
            known.map_or_else(String::new, |known| format!("{:.5}", part(known)))
        };
        cells.push([
            row.rate.to_string(),
            format!("{:#}", row.viscosity),
            theory(|(viscosity, _)| *viscosity),
            format!("{:#}", row.first_difference),
            theory(|(_, averages)| first_difference(averages.stress)),
            format!("{:#}", row.end_to_end),
            theory(|(_, averages)| averages.end_to_end),
            format!("{:.2e}", row.dt),
            format!("{:.1}", row.seconds),
        ]);
    }
    let units = "units: n kT lambda_H, n kT, l_H^2; errors of one sigma in the last digits\n";
    aligned(&cells) + units
}

/// Viscosity and mean square end-to-end distance against the rate.
fn draw(path: &Path, flow: Flow, rows: &[Row]) -> Result<(), Problem> {
    let root = SVGBackend::new(path, (1000, 420)).into_drawing_area();
    root.fill(&WHITE)?;
    let (heading, body) = root.split_vertically(44);
    let style = TextStyle::from(("sans-serif", 22)).color(&INK);
    let title = format!("Bead-spring chains in Brownian dynamics, {}", flow.title());
    heading.draw_text(&title, &style, (24, 14))?;
    let panels = body.margin(0, 8, 8, 16).split_evenly((1, 2));
    let rates = spread(rows.iter().map(|row| row.rate), [1.5, 1.5]);
    let points = |part: fn(&Row) -> Mean| rows.iter().map(|row| (row.rate, part(row))).collect();
    let exact = |part: fn(&(f64, Averages)) -> f64| {
        let known = |row: &Row| Some((row.rate, part(row.theory.as_ref()?)));
        (
            "exact, at these rates",
            rows.iter().filter_map(known).collect(),
        )
    };
    for (panel, title, series, theory) in [
        (
            &panels[0],
            "Polymer viscosity over n kT λ_H",
            Series::new("chains", POLYMER, points(|row| row.viscosity)),
            exact(|(viscosity, _)| *viscosity),
        ),
        (
            &panels[1],
            "Mean square end-to-end distance over l_H²",
            Series::new("chains", POLYMER, points(|row| row.end_to_end)),
            exact(|(_, averages)| averages.end_to_end),
        ),
    ] {
        Panel {
            abscissa: "rate × λ_H",
            title,
            series: &[series],
            theory,
            level: None,
            legend: SeriesLabelPosition::UpperLeft,
            room: [1.3, 1.8],
        }
        .draw_logarithmic(panel, &rates)?;
    }
    root.present()?;
    Ok(())
}
