//! A solution of dissipative particles, whose particulars are told at the head of the example.

mod channel;
mod channel_report;
mod kept;
mod measure;
mod plot;
mod reference;
mod report;
mod run;
mod solute;
mod spaces;

use crate::Problem;
use crate::flow::Flow;
use crate::options::Options;
use crate::text::{csv, json_line};
use indicatif::{ProgressBar, ProgressStyle};
use kept::Kept;
use measure::{Chains, Sample, measure};
use plot::draw;
use rand_distr::{Beta, Distribution};
use rayon::prelude::*;
use report::{Row, summary};
use run::{Run, common_friction};
pub(crate) use solute::Solute;
use solute::{Law, SpringRepulsion, spring};
use std::fs;
use std::io::{self, Write};
use std::time::Instant;
use zimm::prelude::*;

const DENSITY: f64 = 3.0;
/// Share of the beads that belong to molecules.
const POLYMER: f64 = 0.25;
const REPULSION: f64 = 25.0;
const FRICTION: f64 = 10.0;
const EXTENSIBILITY: f64 = 50.0;
const LIMIT: f64 = 6.0;
const KT: f64 = 1.0;
const DT: f64 = 0.01;
const LAMBDA: f64 = 0.55;
const SKIN: f64 = 0.4;

/// Time at rest until overlaps have gone and the fluid has its structure.
const REST: f64 = 10.0;
/// Time in the flow before anything counts, about eight relaxation times of dumbbells, and strain that has to have
/// passed as well. Of slower molecules it is eight relaxation times too.
const TRANSIENT: f64 = 18.0;
const TRANSIENT_STRAIN: f64 = 2.0;
/// Time that counts: some 200 relaxation times of dumbbells, of slower molecules 20 at least. Samples are just above
/// 2048, where block averages need fewest.
const MEASUREMENT: f64 = 460.0;
const SLOW_MEASUREMENT: f64 = 46.0;
const QUICK_MEASUREMENT: f64 = 20.0;
/// One relaxation time of dumbbells. Coarse runs of slower molecules take one before anything counts and four after: with
/// less the friction at the slowest rate is lost in noise.
const QUICK_SLOW: [f64; 2] = [2.3, 9.2];
/// Molecules are slow in coarse runs if they take this many times as long as dumbbells.
const SLOW: f64 = 3.0;
const STEPS_PER_SAMPLE: u64 = 22;
const STEPS_PER_CHECKPOINT: u64 = 1000;

/// Soft beads, springs, and what keeps springs apart.
type Forces<L> = (Pairwise<L, VerletList>, Bonded<Fene>, SpringRepulsion);

/// Body forces that show something: rates up to 0.2 and 1.
pub(crate) const DEFAULT_FORCES: [f64; 2] = [0.04, 0.2];

/// Rates that show something. Extension stretches vortices that vary along the neutral axis of planar flows: beyond a
/// rate of 0.3, which is nu (2 pi / L_z)^2 of this fluid in this cell, the fluid would stir itself. Slower molecules get
/// rates as much lower, of two digits.
pub(crate) fn default_rates(flow: Flow, solute: Solute) -> Vec<f64> {
    let of_dumbbells = match flow {
        Flow::Shear | Flow::Rpf => [0.1, 0.2, 0.4, 0.8],
        Flow::Extension | Flow::Mixed | Flow::Uniaxial => [0.05, 0.1, 0.2, 0.28],
    };
    of_dumbbells
        .map(|rate| two_digits(rate / solute.slowness()))
        .to_vec()
}

/// The nearest number of two decimal digits, as its digits are read.
fn two_digits(value: f64) -> f64 {
    format!("{value:.1e}").parse().unwrap_or(value)
}

/// The rheogram that the options ask for.
pub(crate) fn rheogram(options: &Options) -> Result<(), Problem> {
    match options.flow {
        Flow::Shear => scheme(options, spaces::shear),
        Flow::Extension => scheme(options, spaces::extension),
        Flow::Mixed => scheme(options, |rate| spaces::mixed(rate, options.mixedness)),
        Flow::Uniaxial => scheme(options, spaces::uniaxial),
        Flow::Rpf => channels(options),
    }
}

/// Chooses the scheme in time and the forces between beads that go with it. `space` is the cell of a rate.
fn scheme<B: Periodic>(
    options: &Options,
    space: impl Fn(f64) -> Result<B, Problem> + Sync,
) -> Result<(), Problem> {
    match options.solute.gamma_la {
        None => scene(&with_friction(options)?, space),
        Some(rate) => scene(&redrawn(options, rate)?, space),
    }
}

fn channels(options: &Options) -> Result<(), Problem> {
    match options.solute.gamma_la {
        None => channel::rheogram(&with_friction(options)?),
        Some(rate) => channel::rheogram(&redrawn(options, rate)?),
    }
}

/// Friction and noise after Groot and Warren.
fn with_friction(
    options: &Options,
) -> Result<Solution<'_, Dpd<f64, SquareRoot>, GrootWarren>, ParameterError> {
    Ok(Solution {
        options,
        beads: Dpd::new(REPULSION, FRICTION)?.with_weight(SquareRoot),
        stepper: GrootWarren::new(LAMBDA)?,
    })
}

/// Relative velocities drawn anew after Lowe and Andersen.
fn redrawn(
    options: &Options,
    rate: f64,
) -> Result<Solution<'_, DpdConservative, LoweAndersen<VerletList>>, ParameterError> {
    Ok(Solution {
        options,
        beads: DpdConservative::new(REPULSION, 1.0)?,
        stepper: LoweAndersen::new(rate, 1.0, VerletList::new(SKIN)?)?,
    })
}

/// Build, warm up, let it flow, report.
fn scene<B, L, S>(
    solution: &Solution<'_, L, S>,
    space: impl Fn(f64) -> Result<B, Problem> + Sync,
) -> Result<(), Problem>
where
    B: Periodic,
    L: PairForce + Clone,
    S: Stepper<B, Forces<L>> + Clone + Sync,
{
    let options = solution.options;
    let fluid = solution.at_rest(space(0.0)?)?;
    let steps = options.rates.iter().map(|&rate| last_step(rate, options));
    let bar = progress_bar(steps.sum());
    let rates = options.rates.par_iter();
    let runs: Vec<Run> = rates
        .map(|&rate| {
            let run = space(rate).and_then(|space| solution.flowing(&fluid, space, rate, &bar));
            run.map_err(|error| Problem::from(format!("rate {rate}: {error}")))
        })
        .collect::<Result<_, _>>()?;
    bar.finish_and_clear();

    let friction = common_friction(&runs)?;
    let solute = options.solute;
    let relaxation = friction.times(solute.time_per_friction()?);
    let rows = runs.iter().map(|run| run.row(relaxation));
    let rows = rows.collect::<Result<Vec<_>, _>>()?;
    fs::write(
        options.out.join("rheometer.csv"),
        csv(rows.iter().map(Row::record)),
    )?;
    let picture = options.out.join("rheometer.svg");
    let molecules = POLYMER / f64::from(solute.chain);
    draw(&picture, options, &rows, KT * DENSITY * molecules)?;
    let report = if options.json {
        rows.iter().map(|row| json_line(row.record())).collect()
    } else {
        let written = options.out.display();
        let summary = summary(&rows, solute, friction, relaxation);
        format!("{summary}written: {written}/rheometer.csv, {written}/rheometer.svg\n")
    };
    Ok(io::stdout().write_all(report.as_bytes())?)
}

fn progress_bar(steps: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("flowing [{bar:40}] {percent:>3} %, {eta} left");
    ProgressBar::new(steps).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// Molecules in a solvent: what is needed to run it.
struct Solution<'a, L, S> {
    options: &'a Options,
    beads: L,
    stepper: S,
}

impl<L: PairForce + Clone, S: Clone> Solution<'_, L, S> {
    /// Which beads are in molecules: the first.
    fn molecules(&self, lattice: &Lattice) -> Result<Molecules, ParameterError> {
        let beads = self.options.solute.chain;
        let count = (POLYMER / f64::from(beads) * DENSITY * lattice.volume()).round();
        Molecules::linear(0, count as u32, beads)
    }

    fn forces(&self, molecules: &Molecules) -> Result<Forces<L>, Problem> {
        Ok((
            Pairwise::new(self.beads.clone(), VerletList::new(SKIN)?),
            Bonded::new(spring()?, molecules.bonds()),
            SpringRepulsion::new(self.options.solute.spring_repulsion, molecules, REPULSION)?,
        ))
    }

    /// A fluid in equilibrium: springs drawn from their distribution, all else random, then a while without flow.
    fn at_rest<B>(&self, space: B) -> Result<System<B>, Problem>
    where
        B: Periodic,
        S: Stepper<B, Forces<L>>,
    {
        let (lattice, seed) = (*space.lattice(), self.options.seed);
        let molecules = self.molecules(&lattice)?;
        let mut rng = start::stream(seed);
        // Q^2 / Q_0^2 of FENE springs has a beta distribution.
        let squares = Beta::new(1.5, 0.5 * EXTENSIBILITY + 1.0)?;
        let length = |rng: &mut _| LIMIT * f64::sqrt(squares.sample(rng));
        let positions = start::chains(&lattice, &molecules, length, &mut rng);
        let positions = start::fill(&lattice, positions, DENSITY, &mut rng)?;
        let particles = Particles::new(positions)?;
        let velocities = start::velocities(&particles, KT, &mut rng)?;
        let particles = particles.with_velocities(velocities)?;

        let mut fluid = System::new(space, particles, Clock::new(DT, KT, seed)?);
        let (mut forces, mut stepper) = (self.forces(&molecules)?, self.stepper.clone());
        if self.options.solute.spring_repulsion != Law::None {
            // Springs that lie across each other.
            start::relax(&mut fluid, &mut forces, 0.03, 100)?;
        }
        while fluid.clock.now().time < REST {
            stepper.step(&mut fluid, &mut forces, &mut ())?;
        }
        Ok(fluid)
    }

    /// Switches the flow on and measures. The noise depends on seed and rate alone, so a rate has the same result
    /// whatever other rates are asked for.
    fn flowing<B>(
        &self,
        rest: &System<B>,
        space: B,
        rate: f64,
        bar: &ProgressBar,
    ) -> Result<Run, Problem>
    where
        B: Periodic,
        S: Stepper<B, Forces<L>>,
    {
        let options = self.options;
        let (molecules, gradient) = (self.molecules(space.lattice())?, space.gradient());
        let clock = Clock::new(DT, KT, options.seed ^ rate.to_bits())?;
        let mut fluid = System::new(space, rest.particles.clone(), clock);
        let mut samples = Vec::new();
        let kept = Kept::at(&options.out, &options.name_of_run(rate));
        if !options.resume {
            kept.remove()?;
        } else if let Some(state) = kept.load(&fluid)? {
            (fluid, samples) = state;
        }
        let (mut forces, mut stepper) = (self.forces(&molecules)?, self.stepper.clone());
        let mut chains = Chains::new(molecules)?;
        let interval = steps_per_sample(options.solute);
        let (done, last) = (fluid.clock.now().step, last_step(rate, options));
        bar.inc(done.min(last));
        let before = samples.last().map_or(0.0, |sample: &Sample| sample.seconds);
        let start = Instant::now();
        for step in done + 1..=last {
            if step % interval == 0 {
                let mut virial = Virial::default();
                stepper.step(&mut fluid, &mut forces, &mut virial)?;
                let seconds = before + start.elapsed().as_secs_f64();
                samples.push(measure(&fluid.frame(), &virial, &mut chains, seconds)?);
            } else {
                stepper.step(&mut fluid, &mut forces, &mut ())?;
            }
            if step % STEPS_PER_CHECKPOINT == 0 {
                kept.save(&fluid, &mut forces, &samples)?;
            }
            bar.inc(1);
        }
        samples.retain(|sample| sample.step <= last);
        let run = Run {
            flow: options.flow,
            rate,
            solute: options.solute,
            transient: transient(rate, options),
            gradient,
            samples,
        };
        let viscosity = run.viscosity()?;
        bar.println(format!("rate {rate}: viscosity {viscosity:#}"));
        Ok(run)
    }
}

/// Steps before anything counts.
fn transient(rate: f64, options: &Options) -> u64 {
    let slowness = options.solute.slowness();
    let time = if options.quick && slowness > SLOW {
        QUICK_SLOW[0] * slowness
    } else {
        (TRANSIENT * slowness).max(TRANSIENT_STRAIN / rate)
    };
    (time / DT).ceil() as u64
}

/// The step at which a rate is done, always one with a checkpoint.
fn last_step(rate: f64, options: &Options) -> u64 {
    let steps = transient(rate, options) + (measurement(options) / DT) as u64;
    steps.next_multiple_of(STEPS_PER_CHECKPOINT)
}

/// Time that counts.
fn measurement(options: &Options) -> f64 {
    let slowness = options.solute.slowness();
    if options.quick {
        QUICK_MEASUREMENT.max(QUICK_SLOW[1] * slowness)
    } else {
        MEASUREMENT.max(SLOW_MEASUREMENT * slowness)
    }
}

/// Slower molecules are looked at as often in the time that counts, not in each unit of time.
fn steps_per_sample(solute: Solute) -> u64 {
    let longer = (SLOW_MEASUREMENT * solute.slowness() / MEASUREMENT).max(1.0);
    (STEPS_PER_SAMPLE as f64 * longer) as u64
}
