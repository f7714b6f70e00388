//! A solution of dissipative particles.
//!
//! # What is simulated
//! A cube of edge 12 with 5184 beads at density 3 is sheared by Lees-Edwards boundaries; extension and mixed flow take
//! the smallest cell in which images stay 12 apart (Kraynik-Reinelt and its kin). All beads are alike: DPD with
//! a = 25, gamma = 10 and the weight of Fan et al. (2006), w_D = (1 - r)^(1/2), whose friction is felt more than that of
//! Groot and Warren's (1 - r)^2. Every fourth bead belongs to a dumbbell, held by a FENE spring of extensibility
//! b = H Q_0^2 / kT = 50 and limit Q_0 = 6. After Clarke (PhD thesis, MIT 2008, chapter 4).
//!
//! With `--chain N` the same share of the beads belongs to chains of N beads. `--spring-repulsion` keeps their springs
//! from passing through each other, and `--gamma-la` takes Lowe-Andersen dynamics of that rate instead of friction and
//! noise: chains as in Clarke's chapter 5, of which the example `semidilute_dpd` is a closer study.
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
//!   For chains lambda_1 = zeta / (8 H sin^2(pi / 2N)) takes the place of lambda_H, and twice the sum of R R over beads,
//!   R from their centre, that of Q Q: the same for two beads.
//! * `eta`, `Psi_1`: viscosity and (sigma_xx - sigma_yy) / rate^2 of the whole solution, from the stress of all forces
//!   and of the beads' motion; tension is positive. The viscosity is sigma_xy / rate in shear, eta_1 =
//!   (sigma_xx - sigma_yy) / rate in planar extension, Trouton's (sigma_xx - (sigma_yy + sigma_zz) / 2) / rate in
//!   uniaxial extension and Hounkonnou's in mixed flow, sigma : A / (A : A) with A = kappa + kappa^T.
//! * `eta_p*`, `Psi_1p*`: the dumbbells' share by Kramers' expression, over n kT lambda_H and n kT lambda_H^2, with n
//!   their number density.
//! * `<Q^2>/Q_0^2`: mean square length of the dumbbells; of chains `<R_e^2>/L^2`, from end to end over the contour length.
//!   At rest <Q^2>/Q_0^2 is 3 / (b + 5) = 0.0545 for beads that do not repel each other, and 3 % more for these.
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
/// Time in the flow before anything counts, about eight relaxation times of dumbbells, and strain for each bead of a
/// molecule that has to have passed as well.
const TRANSIENT: f64 = 18.0;
const TRANSIENT_STRAIN_PER_BEAD: f64 = 1.0;
/// Time that counts: some 200 relaxation times. Samples are just above 2048, where block averages need fewest.
const MEASUREMENT: f64 = 460.0;
const QUICK_MEASUREMENT: f64 = 20.0;
const STEPS_PER_SAMPLE: u64 = 22;
const STEPS_PER_CHECKPOINT: u64 = 1000;

/// Soft beads, springs, and what keeps springs apart.
type Forces<L> = (Pairwise<L, VerletList>, Bonded<Fene>, SpringRepulsion);

/// Rates that show something. Extension stretches vortices that vary along the neutral axis of planar flows: beyond a
/// rate of 0.3, which is nu (2 pi / L_z)^2 of this fluid in this cell, the fluid would stir itself.
pub(crate) fn default_rates(flow: Flow) -> Vec<f64> {
    match flow {
        Flow::Shear => vec![0.1, 0.2, 0.4, 0.8],
        Flow::Extension | Flow::Mixed | Flow::Uniaxial => vec![0.05, 0.1, 0.2, 0.28],
    }
}

/// The rheogram that the options ask for.
pub(crate) fn rheogram(options: &Options) -> Result<(), Problem> {
    match options.flow {
        Flow::Shear => scheme(options, spaces::shear),
        Flow::Extension => scheme(options, spaces::extension),
        Flow::Mixed => scheme(options, |rate| spaces::mixed(rate, options.mixedness)),
        Flow::Uniaxial => scheme(options, spaces::uniaxial),
    }
}

/// Chooses the scheme in time and the forces between beads that go with it. `space` is the cell of a rate.
fn scheme<B: Periodic>(
    options: &Options,
    space: impl Fn(f64) -> Result<B, Problem> + Sync,
) -> Result<(), Problem> {
    match options.solute.gamma_la {
        None => {
            let beads = Dpd::new(REPULSION, FRICTION)?.with_weight(SquareRoot);
            scene(options, space, beads, GrootWarren::new(LAMBDA)?)
        }
        Some(rate) => {
            let beads = DpdConservative::new(REPULSION, 1.0)?;
            let stepper = LoweAndersen::new(rate, 1.0, VerletList::new(SKIN)?)?;
            scene(options, space, beads, stepper)
        }
    }
}

/// Build, warm up, let it flow, report.
fn scene<B, L, S>(
    options: &Options,
    space: impl Fn(f64) -> Result<B, Problem> + Sync,
    beads: L,
    stepper: S,
) -> Result<(), Problem>
where
    B: Periodic,
    L: PairForce + Clone,
    S: Stepper<B, Forces<L>> + Clone + Sync,
{
    let solution = Solution {
        options,
        beads,
        stepper,
    };
    let fluid = solution.at_rest(space(0.0)?)?;
    let bar = progress_bar(options);
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

fn progress_bar(options: &Options) -> ProgressBar {
    let steps = options
        .rates
        .iter()
        .map(|&rate| last_step(rate, options))
        .sum();
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
        let (done, last) = (fluid.clock.now().step, last_step(rate, options));
        bar.inc(done.min(last));
        let before = samples.last().map_or(0.0, |sample: &Sample| sample.seconds);
        let start = Instant::now();
        for step in done + 1..=last {
            if step % STEPS_PER_SAMPLE == 0 {
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
            gradient,
            samples,
        };
        let viscosity = run.viscosity()?;
        bar.println(format!("rate {rate}: viscosity {viscosity:#}"));
        Ok(run)
    }
}

/// Steps before anything counts.
fn transient(rate: f64, solute: Solute) -> u64 {
    let strain = TRANSIENT_STRAIN_PER_BEAD * f64::from(solute.chain);
    (TRANSIENT.max(strain / rate) / DT).ceil() as u64
}

/// The step at which a rate is done, always one with a checkpoint.
fn last_step(rate: f64, options: &Options) -> u64 {
    let measurement = if options.quick {
        QUICK_MEASUREMENT
    } else {
        MEASUREMENT
    };
    let steps = transient(rate, options.solute) + (measurement / DT) as u64;
    steps.next_multiple_of(STEPS_PER_CHECKPOINT)
}
