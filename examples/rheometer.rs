//! A virtual rheometer: FENE dumbbells in a solvent of dissipative particles, in shear or another flow at several rates.
//!
//! ```text
//! cargo run --release --example rheometer                        shear, about 70 seconds on two cores
//! cargo run --release --example rheometer -- --flow extension    or mixed (with --mixedness), or uniaxial
//! cargo run --release --example rheometer -- --help              all options
//! ```
//!
//! # What is simulated
//! A cube of edge 12 with 5184 beads at density 3 is sheared by Lees-Edwards boundaries; extension and mixed flow take
//! the smallest cell in which images stay 12 apart (Kraynik-Reinelt and its kin). All beads are alike: DPD with
//! a = 25, gamma = 10 and the weight of Fan et al. (2006), w_D = (1 - r)^(1/2), whose friction is felt more than that of
//! Groot and Warren's (1 - r)^2. Every fourth bead belongs to a dumbbell, held by a FENE spring of extensibility
//! b = H Q_0^2 / kT = 50 and limit Q_0 = 6. After Clarke (PhD thesis, MIT 2008, chapter 4).
//!
//! Units are those of DPD: length r_c, mass m of a bead, energy kT, hence time tau = r_c (m / kT)^(1/2).
//!
//! # What the columns mean
//! * `rate`: of shear, u_x = rate y; of planar extension, u = rate (x, -y, 0); of uniaxial extension,
//!   u = rate (x, -y/2, -z/2); of mixed flow the strain rate Gamma, u = rate (sqrt(chi) x + (1 - chi) y,
//!   -sqrt(chi) y, 0) with chi the mixedness.
//! * `De`: Deborah number, lambda_H rate with lambda_H = zeta / 4H. The friction zeta of a bead is not put in, it is
//!   found: Kramers' and Giesekus' expressions for the stress of dumbbells agree if, in shear, zeta = 4 <F_x Q_y> /
//!   (rate <Q_y^2>), with F the tension between the beads, spring less repulsion. All rates together give one zeta.
//! * `eta`, `Psi_1`: viscosity and (sigma_xx - sigma_yy) / rate^2 of the whole solution, from the stress of all forces
//!   and of the beads' motion; tension is positive. The viscosity is sigma_xy / rate in shear, eta_1 =
//!   (sigma_xx - sigma_yy) / rate in planar extension, Trouton's (sigma_xx - (sigma_yy + sigma_zz) / 2) / rate in
//!   uniaxial extension and Hounkonnou's in mixed flow, sigma : A / (A : A) with A = kappa + kappa^T.
//! * `eta_p*`, `Psi_1p*`: the dumbbells' share by Kramers' expression, over n kT lambda_H and n kT lambda_H^2, with n
//!   their number density.
//! * `<Q^2>/Q_0^2`: mean square length of the dumbbells. At rest it is 3 / (b + 5) = 0.0545 for beads that do not repel
//!   each other, and 3 % more for these.
//! * `T`: kinetic temperature of the peculiar velocities, of 3N - 3 degrees of freedom. The time step makes it half a
//!   per cent low, and viscous heating raises it as the square of the rate.
//! * `theory`: dilute dumbbells of the same b at the same De, whose beads do not interact; in shear from the
//!   Fokker-Planck equation (De up to 10) and Brownian dynamics (above), in extension exact. Blank outside
//!   0.01 < De < 300 (3 in extension) and in mixed flow.
//!
//! Errors are one standard error, from block averages, in units of the last digits: 0.912(12) is 0.912 +- 0.012. Where
//! the block average has not levelled off, the error is a lower bound: 0.912(>12). The error of lambda_H, common to
//! all rates, is told below the table and is not part of the starred columns' errors.
//!
//! # How to read the comparison
//! zeta is chosen so that Giesekus' relation holds, hence in shear eta_p* is H <Q_y^2> / kT: that column compares the
//! dumbbells' width across the flow with theory. Psi_1p* and the extension depend on the choice through De alone. Agreement is
//! within ten per cent: real beads repel each other, and they stir a solvent that takes its time to follow, so that
//! the beads of a long dumbbell feel more friction than those of a short one.

#[path = "rheometer/flow.rs"]
mod flow;
#[path = "rheometer/kept.rs"]
mod kept;
#[path = "rheometer/measure.rs"]
mod measure;
#[path = "rheometer/options.rs"]
mod options;
#[path = "rheometer/plot.rs"]
mod plot;
#[path = "rheometer/reference.rs"]
mod reference;
#[path = "rheometer/report.rs"]
mod report;
#[path = "rheometer/run.rs"]
mod run;

use flow::Flow;
use indicatif::{ProgressBar, ProgressStyle};
use kept::Kept;
use measure::{Dumbbells, measure};
use options::Options;
use plot::draw;
use rand_distr::{Beta, Distribution};
use rayon::prelude::*;
use report::{csv, json_line, summary, with_error};
use run::{Run, common_friction};
use std::error::Error;
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;
use zimm::prelude::*;

const DENSITY: f64 = 3.0;
/// Dumbbells per bead of all: a quarter of the beads are theirs.
const DUMBBELLS: f64 = 0.125;
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
/// Time in the flow before anything counts, about eight relaxation times, and strain that has to have passed as well.
const TRANSIENT: f64 = 18.0;
const TRANSIENT_STRAIN: f64 = 2.0;
/// Time that counts: some 200 relaxation times. Samples are just above 2048, where block averages need fewest.
const MEASUREMENT: f64 = 460.0;
const QUICK_MEASUREMENT: f64 = 20.0;
const STEPS_PER_SAMPLE: u64 = 22;
const STEPS_PER_CHECKPOINT: u64 = 1000;

/// What went wrong, in one sentence.
type Problem = Box<dyn Error + Send + Sync>;
type Forces = (Pairwise<Dpd<f64, SquareRoot>, VerletList>, Bonded<Fene>);

fn main() -> ExitCode {
    let options = match Options::parse_command_line() {
        Ok(options) => options,
        Err(sentence) => return fail(2, &sentence),
    };
    if let Err(error) = make_writable(&options.out) {
        let out = options.out.display();
        return fail(2, &format!("cannot write to {out}: {error}"));
    }
    let rheogram = || match options.flow {
        Flow::Shear => scene(&options, flow::shear),
        Flow::Extension => scene(&options, flow::extension),
        Flow::Mixed => scene(&options, |rate| flow::mixed(rate, options.mixedness)),
        Flow::Uniaxial => scene(&options, flow::uniaxial),
    };
    match on_threads(options.threads, rheogram) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => fail(1, &error.to_string()),
    }
}

fn on_threads(
    threads: Option<usize>,
    work: impl FnOnce() -> Result<(), Problem> + Send,
) -> Result<(), Problem> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0));
    pool.build()?.install(work)
}

fn fail(code: u8, sentence: &str) -> ExitCode {
    eprintln!("rheometer: {sentence}");
    ExitCode::from(code)
}

fn make_writable(out: &Path) -> io::Result<()> {
    fs::create_dir_all(out)?;
    OpenOptions::new()
        .append(true)
        .create(true)
        .open(out.join("rheometer.csv"))?;
    Ok(())
}

/// Build, warm up, let it flow, report. `space` is the cell of a rate.
fn scene<B: Periodic>(
    options: &Options,
    space: impl Fn(f64) -> Result<B, Problem> + Sync,
) -> Result<(), Problem> {
    let fluid = at_rest(space(0.0)?, options.seed)?;
    let bar = progress_bar(options);
    let rates = options.rates.par_iter();
    let runs: Vec<Run> = rates
        .map(|&rate| {
            let run = space(rate).and_then(|space| flowing(&fluid, space, rate, options, &bar));
            run.map_err(|error| Problem::from(format!("rate {rate}: {error}")))
        })
        .collect::<Result<_, _>>()?;
    bar.finish_and_clear();

    let friction = common_friction(&runs)?;
    let relaxation = friction.times(0.25 / spring()?.stiffness());
    let rows = runs.iter().map(|run| run.row(relaxation));
    let rows = rows.collect::<Result<Vec<_>, _>>()?;
    fs::write(options.out.join("rheometer.csv"), csv(&rows))?;
    let picture = options.out.join("rheometer.svg");
    draw(&picture, options.flow, &rows, KT * DENSITY * DUMBBELLS)?;
    let report = if options.json {
        rows.iter().map(json_line).collect()
    } else {
        let written = options.out.display();
        let summary = summary(&rows, friction, relaxation);
        format!("{summary}written: {written}/rheometer.csv, {written}/rheometer.svg\n")
    };
    Ok(io::stdout().write_all(report.as_bytes())?)
}

fn progress_bar(options: &Options) -> ProgressBar {
    let steps = options
        .rates
        .iter()
        .map(|&rate| last_step(rate, options.quick))
        .sum();
    let style = ProgressStyle::with_template("flowing [{bar:40}] {percent:>3} %, {eta} left");
    ProgressBar::new(steps).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// The two forces: soft beads with friction and noise, and springs.
fn forces(dumbbells: &Molecules) -> Result<Forces, ParameterError> {
    let beads = Pairwise::new(
        Dpd::new(REPULSION, FRICTION)?.with_weight(SquareRoot),
        VerletList::new(SKIN)?,
    );
    Ok((beads, Bonded::new(spring()?, dumbbells.bonds())))
}

fn spring() -> Result<Fene, ParameterError> {
    Fene::with_extensibility(EXTENSIBILITY, LIMIT, KT)
}

/// Which beads are in dumbbells: the first.
fn dumbbells(lattice: &Lattice) -> Result<Molecules, ParameterError> {
    let count = (DUMBBELLS * DENSITY * lattice.volume()).round();
    Molecules::linear(0, count as u32, 2)
}

/// A fluid in equilibrium: springs drawn from their distribution, all else random, then a while without flow.
fn at_rest<B: Periodic>(space: B, seed: u64) -> Result<System<B>, Problem> {
    let lattice = *space.lattice();
    let dumbbells = dumbbells(&lattice)?;
    let mut rng = start::stream(seed);
    // Q^2 / Q_0^2 of FENE springs has a beta distribution.
    let squares = Beta::new(1.5, 0.5 * EXTENSIBILITY + 1.0)?;
    let length = |rng: &mut _| LIMIT * f64::sqrt(squares.sample(rng));
    let mut positions = start::chains(&lattice, &dumbbells, length, &mut rng);
    let beads = (DENSITY * lattice.volume()).round() as usize;
    let solvent = beads - positions.len();
    positions.extend(start::uniform(&lattice, solvent, &mut rng));
    let particles = Particles::new(positions)?;
    let velocities = start::velocities(&particles, KT, &mut rng)?;
    let particles = particles.with_velocities(velocities)?;

    let mut fluid = System::new(space, particles, Clock::new(DT, KT, seed)?);
    let (mut forces, mut stepper) = (forces(&dumbbells)?, GrootWarren::new(LAMBDA)?);
    while fluid.clock.now().time < REST {
        stepper.step(&mut fluid, &mut forces, &mut ())?;
    }
    Ok(fluid)
}

/// Switches the flow on and measures. The noise depends on seed and rate alone, so a rate has the same result whatever
/// other rates are asked for.
fn flowing<B: Periodic>(
    rest: &System<B>,
    space: B,
    rate: f64,
    options: &Options,
    bar: &ProgressBar,
) -> Result<Run, Problem> {
    let (dumbbells, gradient) = (dumbbells(space.lattice())?, space.gradient());
    let clock = Clock::new(DT, KT, options.seed ^ rate.to_bits())?;
    let mut fluid = System::new(space, rest.particles.clone(), clock);
    let mut samples = Vec::new();
    let kept = Kept::at(&options.out, &options.name_of_run(rate));
    if !options.resume {
        kept.remove()?;
    } else if let Some(state) = kept.load(&fluid)? {
        (fluid, samples) = state;
    }
    let (mut forces, mut stepper) = (forces(&dumbbells)?, GrootWarren::new(LAMBDA)?);
    let mut dumbbells = Dumbbells::new(&forces)?;
    let (done, last) = (fluid.clock.now().step, last_step(rate, options.quick));
    bar.inc(done.min(last));
    let before = samples.last().map_or(0.0, |sample| sample.seconds);
    let start = Instant::now();
    for step in done + 1..=last {
        if step % STEPS_PER_SAMPLE == 0 {
            let mut virial = Virial::default();
            stepper.step(&mut fluid, &mut forces, &mut virial)?;
            let seconds = before + start.elapsed().as_secs_f64();
            samples.push(measure(&fluid.frame(), &virial, &mut dumbbells, seconds)?);
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
        gradient,
        samples,
    };
    let viscosity = with_error(run.viscosity()?);
    bar.println(format!("rate {rate}: viscosity {viscosity}"));
    Ok(run)
}

/// Steps before anything counts.
fn transient(rate: f64) -> u64 {
    (TRANSIENT.max(TRANSIENT_STRAIN / rate) / DT).ceil() as u64
}

/// The step at which a rate is done, always one with a checkpoint.
fn last_step(rate: f64, quick: bool) -> u64 {
    let measurement = if quick {
        QUICK_MEASUREMENT
    } else {
        MEASUREMENT
    };
    let steps = transient(rate) + (measurement / DT) as u64;
    steps.next_multiple_of(STEPS_PER_CHECKPOINT)
}
