//! Many runs, against the Deborah number.

use crate::Problem;
use crate::figure::draw;
use crate::options::{Flow, Options};
use crate::solution::{
    BEADS, CONTOUR, CROWDED, Forces, KT, SQUARE_OF_SPRING, STEPS_PER_CHECKPOINT, Solution, filled,
    progress_bar, spans, stepper, trace,
};
use indicatif::ProgressBar;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::fs;
use std::path::{Path, PathBuf};
use zimm::prelude::*;

const STEPS_PER_SAMPLE: u64 = 100;
/// Of each chain: extension over contour, squared radius of gyration, sigma_xy and sigma_xx - sigma_yy over n kT.
const OF_CHAIN: usize = 4;
/// Of the solution: pressure of the springs' repulsion, share of the volume that is nearer to a spring than half of its
/// range, temperature.
const OF_SOLUTION: usize = 3;

/// `space` is the cell of a rate.
pub(crate) fn run<B: Periodic>(
    options: &Options,
    solutions: &[Solution],
    space: impl Fn(f64) -> Result<B, Problem> + Sync,
) -> Result<(), Problem> {
    for solution in solutions {
        solution.chains(space(solution.rate)?.lattice())?;
        let checkpoint = checkpoint(options, solution);
        if !options.resume && checkpoint.exists() {
            fs::remove_file(checkpoint)?;
        }
    }
    let bar = progress_bar("flowing", options.steps() * solutions.len() as u64);
    let measured = solutions.par_iter().map(|solution| {
        space(solution.rate)
            .and_then(|space| flow(options, solution, space, &bar))
            .map_err(|error| Problem::from(format!("{}: {error}", name(solution))))
    });
    let measured: Vec<Measured> = measured.collect::<Result<_, _>>()?;
    bar.finish_and_clear();

    let runs: Vec<_> = solutions.iter().zip(&measured).collect();
    let alike = |a: &(&Solution, _), b: &(&Solution, _)| {
        (a.0.concentration, a.0.rate) == (b.0.concentration, b.0.rate)
    };
    let rows = runs.chunk_by(alike).map(Row::of_runs);
    let rows: Vec<Row> = rows.collect::<Result<_, _>>()?;
    let [table, picture] =
        ["csv", "svg"].map(|kind| options.out.join(format!("semidilute_dpd.{kind}")));
    write(&table, options.flow, &rows)?;
    draw(&picture, options.flow, &rows)?;
    report(options, &rows);
    println!("written: {}, {}", table.display(), picture.display());
    Ok(())
}

fn name(solution: &Solution) -> String {
    format!(
        "c/c* = {}, De = {:.3}, seed {}",
        solution.concentration,
        solution.deborah(),
        solution.seed
    )
}

/// Each run has its own.
fn checkpoint(options: &Options, solution: &Solution) -> PathBuf {
    let scene = solution.to_string().to_lowercase().replace(' ', "-");
    options.out.join(format!("{scene}.checkpoint"))
}

/// What was measured, sample after sample: of each chain, then of the solution.
struct Measured {
    chains: usize,
    numbers: Vec<f64>,
}

impl Measured {
    /// The later half of the samples.
    fn samples(&self) -> impl Iterator<Item = &[f64]> {
        let samples = self
            .numbers
            .chunks_exact(OF_CHAIN * self.chains + OF_SOLUTION);
        let unseen = samples.len() / 2;
        samples.skip(unseen)
    }
}

/// One run from its beginning, or from where it was interrupted.
fn flow<B: Periodic>(
    options: &Options,
    solution: &Solution,
    space: B,
    bar: &ProgressBar,
) -> Result<Measured, Problem> {
    let chains = solution.chains(space.lattice())?;
    let mut forces = solution.forces(&chains)?;
    let mut stepper = stepper()?;
    let checkpoint = checkpoint(options, solution);
    let (mut system, mut numbers) = if checkpoint.exists() {
        solution.go_on(&checkpoint, space)?
    } else {
        (solution.begin(space, &chains, &mut forces)?, Vec::new())
    };
    let last = options.steps();
    bar.inc(system.clock.now().step.min(last));
    while system.clock.now().step < last {
        let step = system.clock.now().step + 1;
        if step.is_multiple_of(STEPS_PER_SAMPLE) {
            let mut virial = Virial::default();
            stepper.step(&mut system, &mut forces, &mut virial)?;
            measure(&system, &chains, &forces, &virial, &mut numbers)?;
        } else {
            stepper.step(&mut system, &mut forces, &mut ())?;
        }
        if step.is_multiple_of(STEPS_PER_CHECKPOINT) || step == last {
            solution.keep(&checkpoint, &system, &mut forces, &numbers)?;
        }
        bar.inc(1);
    }
    let chains = chains.count() as usize;
    // A longer run may have been here before.
    numbers.truncate((last / STEPS_PER_SAMPLE) as usize * (OF_CHAIN * chains + OF_SOLUTION));
    bar.set_message(format!("done: {}", name(solution)));
    Ok(Measured { chains, numbers })
}

/// Kramers' stress of each chain over n kT is the sum of its tensions and spans, F Q / kT. The repulsion's is shared out
/// among the chains in equal parts.
fn measure<B: Periodic>(
    system: &System<B>,
    chains: &Molecules,
    (_, bonds, _): &Forces,
    virial: &Virial,
    numbers: &mut Vec<f64>,
) -> Result<(), Problem> {
    let frame = system.frame();
    let (molecules, along) = (*chains, DVec3::X);
    let extents = Extent { molecules, along }.measure(&frame, &())?;
    let radii = SquaredRadius { molecules }.measure(&frame, &())?;
    let repulsion = Stress.measure(&frame, virial).item(Item::SpringRepulsion);
    let share = system.boundary.lattice().volume() / f64::from(chains.count());
    let shares = [
        repulsion.y_axis.x * share,
        (repulsion.x_axis.x - repulsion.y_axis.y) * share,
    ];
    let spans = spans(system, bonds.bonds());
    let spans = spans.chunks(BEADS as usize - 1);
    for ((extent, radius), spans) in extents.into_iter().zip(radii).zip(spans) {
        let [mut shear, mut normal] = shares;
        for q in spans {
            let tension = -bonds.spring().force(q.length_squared());
            shear += tension * q.x * q.y;
            normal += tension * (q.x * q.x - q.y * q.y);
        }
        numbers.extend([extent / CONTOUR, radius, shear / KT, normal / KT]);
    }
    let temperature = KineticTemperature::default().measure(&frame, virial)?;
    numbers.extend([
        -trace(repulsion) / 3.0,
        filled(system, bonds.bonds()),
        temperature.mean(),
    ]);
    Ok(())
}

/// What the runs of one concentration and rate show.
pub(crate) struct Row {
    pub(crate) concentration: f64,
    rate: f64,
    pub(crate) deborah: f64,
    pub(crate) extension: Mean,
    pub(crate) squared_radius: Mean,
    /// Over n kT lambda.
    pub(crate) viscosity: Mean,
    /// Over n kT lambda^2.
    pub(crate) psi_1: Mean,
    solution: [f64; OF_SOLUTION],
}

impl Row {
    fn of_runs(runs: &[(&Solution, &Measured)]) -> Result<Self, Problem> {
        let Some((first, _)) = runs.first() else {
            return Err("no runs".into());
        };
        let mut chains: [EnsembleAverage; OF_CHAIN] = Default::default();
        let (mut solution, mut samples) = ([0.0; OF_SOLUTION], 0.0);
        for (run, (_, measured)) in (0..).zip(runs) {
            for sample in measured.samples() {
                let (each, whole) = sample.split_at(OF_CHAIN * measured.chains);
                for (chain, numbers) in (0..).zip(each.chunks_exact(OF_CHAIN)) {
                    let chain: u64 = (run << 32) | chain;
                    for (average, &x) in chains.iter_mut().zip(numbers) {
                        average.push((chain, x));
                    }
                }
                samples += 1.0;
                for (mean, x) in solution.iter_mut().zip(whole) {
                    *mean += (x - *mean) / samples;
                }
            }
        }
        let too_few = |error| format!("--times or --runs is too small: {error}");
        let [extension, squared_radius, shear, normal] =
            chains.map(|average| average.estimate().map_err(too_few));
        let (shear, normal) = (shear?, normal?);
        let (rate, deborah) = (first.rate, first.deborah());
        let driven = match first.flow {
            Flow::Extension => normal,
            Flow::Rest | Flow::Shear => shear,
        };
        Ok(Self {
            concentration: first.concentration,
            rate,
            deborah,
            extension: extension?,
            squared_radius: squared_radius?,
            viscosity: driven.times(1.0 / deborah),
            psi_1: normal.times(1.0 / (deborah * deborah)),
            solution,
        })
    }

    /// Means and what they are called. Psi_1 is of shear.
    fn means(&self, flow: Flow) -> Vec<(&'static str, Mean)> {
        let mut means = vec![
            ("extension", self.extension),
            ("squared_radius", self.squared_radius),
            ("viscosity", self.viscosity),
        ];
        if flow == Flow::Shear {
            means.push(("psi_1", self.psi_1));
        }
        means
    }
}

const NAMES_OF_SOLUTION: [&str; OF_SOLUTION] = ["repulsion_pressure", "filled", "temperature"];

fn write(path: &Path, flow: Flow, rows: &[Row]) -> Result<(), Problem> {
    let mut lines = Vec::new();
    for row in rows {
        let means = row.means(flow);
        if lines.is_empty() {
            let mut names: Vec<_> = ["concentration", "de", "rate"].map(String::from).into();
            names.extend(
                means
                    .iter()
                    .flat_map(|(name, _)| [name.to_string(), format!("{name}_error")]),
            );
            names.extend(NAMES_OF_SOLUTION.map(String::from));
            lines.push(names.join(","));
        }
        let mut numbers = vec![row.concentration, row.deborah, row.rate];
        numbers.extend(
            means
                .iter()
                .flat_map(|(_, mean)| [mean.value, mean.at_least()]),
        );
        numbers.extend(row.solution);
        let words: Vec<_> = numbers.iter().map(f64::to_string).collect();
        lines.push(words.join(","));
    }
    Ok(fs::write(path, lines.join("\n") + "\n")?)
}

fn report(options: &Options, rows: &[Row]) {
    for row in rows {
        let means = row.means(options.flow);
        let words = means.iter().map(|(name, mean)| format!("{name} {mean:#}"));
        let words: Vec<_> = words.collect();
        let [_, filled, temperature] = row.solution;
        println!(
            "c/c* = {}, De = {:.3}: {}, temperature {temperature:.4}",
            row.concentration,
            row.deborah,
            words.join(", "),
        );
        if filled > CROWDED {
            println!(
                "    {:.0} % of the volume is nearer to a spring than half of the range of their repulsion: it orders \
                 the solution and makes a pressure of its own",
                100.0 * filled
            );
        }
    }
    if options.flow == Flow::Extension {
        for rows in of_concentrations(rows) {
            if let (Some(row), Some([deborah, error])) = (rows.first(), half_way(rows)) {
                println!(
                    "c/c* = {}: half of the way from coil to contour at De = {deborah:.3} +- {error:.3}",
                    row.concentration,
                );
            }
        }
    }
}

pub(crate) fn of_concentrations(rows: &[Row]) -> impl Iterator<Item = &[Row]> {
    rows.chunk_by(|a, b| a.concentration == b.concentration)
}

/// The Deborah number at which extension passes half of the way from that of an ideal coil to one, and its error: between
/// two points, linear in the logarithm of De.
fn half_way(rows: &[Row]) -> Option<[f64; 2]> {
    let half = 0.5 * (ideal_extension() + 1.0);
    let passes = |pair: &&[Row]| pair[0].extension.value < half && half <= pair[1].extension.value;
    let pair = rows.windows(2).find(passes)?;
    let [below, above] = [pair[0].extension, pair[1].extension];
    let rise = above.value - below.value;
    let part = (half - below.value) / rise;
    let error = (below.at_least() * (1.0 - part)).hypot(above.at_least() * part) / rise;
    let step = (pair[1].deborah / pair[0].deborah).ln();
    let deborah = pair[0].deborah * (part * step).exp();
    Some([deborah, deborah * step * error])
}

/// What ideal chains at rest extend along x, over their contour: the mean span of a random walk of n normal steps is
/// 2 sum_(k=1)^n <S_k^+> / k (Spitzer, Trans. Am. Math. Soc. 82, 323, 1956), with <S_k^+> = (k <Q^2> / 6 pi)^(1/2).
pub(crate) fn ideal_extension() -> f64 {
    let sum: f64 = (1..BEADS).map(|k| 1.0 / f64::from(k).sqrt()).sum();
    2.0 * (SQUARE_OF_SPRING / (6.0 * PI)).sqrt() * sum / CONTOUR
}

/// <Q^2> (N^2 - 1) / 6 N.
pub(crate) fn ideal_squared_radius() -> f64 {
    let n = f64::from(BEADS);
    SQUARE_OF_SPRING * (n * n - 1.0) / (6.0 * n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solution::spring;

    /// Chains as drawn from the springs' distribution, which is not quite normal.
    ///
    /// Seed 1, 8000 chains: spans scatter by 0.26 and R_g^2 by 0.55 of their means, standard errors 0.3 and 0.6 %. Bounds: 4
    /// of them and 0.5 % for the steps; a formula that is off by 3 % is caught.
    #[test]
    fn limit_ideal_chains_at_rest() {
        let space = PeriodicBox::cubic(20.0).unwrap();
        let molecules = Molecules::linear(0, 8000, BEADS).unwrap();
        let bond = start::BondLength::new(&spring().unwrap(), KT).unwrap();
        let mut rng = start::stream(1);
        let draw = |rng: &mut _| bond.sample(rng);
        let positions = start::chains(space.lattice(), &molecules, draw, &mut rng);
        let particles = Particles::new(positions).unwrap();
        let system = System::new(space, particles, Clock::new(0.01, KT, 1).unwrap());
        let (frame, along) = (system.frame(), DVec3::X);
        let mean = |each: Vec<f64>| each.iter().sum::<f64>() / each.len() as f64;
        let extent = mean(Extent { molecules, along }.measure(&frame, &()).unwrap());
        let radius = mean(SquaredRadius { molecules }.measure(&frame, &()).unwrap());
        println!("extent {extent:.3}, R_g^2 {radius:.3}");
        assert!((extent / CONTOUR / ideal_extension() - 1.0).abs() < 0.017);
        assert!((radius / ideal_squared_radius() - 1.0).abs() < 0.029);
    }

    /// Between a tenth below and three tenths above half way, at De = 0.4 and 0.8: a fourth of the way in ln De. The errors
    /// of 0.01 and 0.02 are weighted by 3/4 and 1/4, over a rise of 0.4.
    #[test]
    fn limit_half_way_lies_between_two_points() {
        let half = 0.5 * (ideal_extension() + 1.0);
        let row = |deborah: f64, value: f64, error: f64| {
            let error = StandardError::AtLeast(error);
            let mean = Mean { value, error };
            Row {
                concentration: 1.0,
                rate: deborah,
                deborah,
                extension: mean,
                squared_radius: mean,
                viscosity: mean,
                psi_1: mean,
                solution: [0.0; OF_SOLUTION],
            }
        };
        let rows = [
            row(0.2, 0.1, 0.01),
            row(0.4, half - 0.1, 0.01),
            row(0.8, half + 0.3, 0.02),
        ];
        let [deborah, error] = half_way(&rows).unwrap();
        let step = 2.0_f64.ln();
        assert!((deborah - 0.4 * (0.25 * step).exp()).abs() < 1e-12);
        let expected = deborah * step * 0.0075_f64.hypot(0.005) / 0.4;
        assert!((error - expected).abs() < 1e-12);
        assert!(half_way(&rows[..2]).is_none() && half_way(&[]).is_none());
    }
}
