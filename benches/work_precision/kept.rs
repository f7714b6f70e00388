//! A mobility that is kept for several steps: what that errs by, and what it saves.
//!
//! Errors are those of `<Q^2>` of dumbbells in open space, b = 50, h* = 0.25: at rest, where it is known, and in planar
//! extension at a rate of 1, against the same with steps of 0.02 and nothing kept. Beside them is what steps that are as
//! long as a round err by, for which binding costs the same. CPU time is that of one thread, a step of a round over a step
//! that keeps nothing.

use crate::chart::{Curve, Panel};
use crate::{Problem, Task};
use cpu_time::ThreadTime;
use plotters::prelude::SeriesLabelPosition;
use std::f64::consts::PI;
use zimm::prelude::*;

const FRICTION: f64 = 4.0;
const HSTAR: f64 = 0.25;
const EXTENSIBILITY: f64 = 50.0;
const STEP: f64 = 0.02;
const ROUNDS: [u64; 6] = [1, 4, 16, 32, 64, 128];
const RATES: [f64; 2] = [0.0, 1.0];
const TOLERANCE: f64 = 1e-3;

/// `<Q^2>` of dumbbells and its standard error.
struct Found {
    rate: f64,
    dt: f64,
    round: u64,
    mean: f64,
    error: f64,
}

/// CPU seconds of a step.
struct Cost {
    what: &'static str,
    round: u64,
    seconds: f64,
}

pub(crate) fn figure(task: &Task) -> Result<(), Problem> {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    one.install(|| on_one_thread(task))
}

fn on_one_thread(task: &Task) -> Result<(), Problem> {
    let rounds: Vec<u64> = if task.quick {
        vec![1, 16]
    } else {
        ROUNDS.to_vec()
    };
    let mut costs = Vec::new();
    for &round in &rounds {
        each_cost(round, task.quick, &mut costs)?;
    }
    let mut found = Vec::new();
    for rate in RATES {
        for &round in &rounds {
            found.push(dumbbells(rate, STEP, round, task.quick)?);
            if round > 1 {
                found.push(dumbbells(rate, STEP * round as f64, 1, task.quick)?);
            }
        }
    }
    task.csv(
        "what,rate,dt,steps_kept,value,noise",
        costs
            .iter()
            .map(|c| format!("CPU s of a step: {},,,{},{:e},", c.what, c.round, c.seconds))
            .chain(found.iter().map(|f| {
                let Found { rate, dt, .. } = f;
                format!("<Q^2>,{rate},{dt},{},{},{:e}", f.round, f.mean, f.error)
            })),
    )?;
    let reference = |rate: f64| {
        let first = found.iter().find(|f| f.rate == rate);
        if rate == 0.0 {
            3.0 * EXTENSIBILITY / (EXTENSIBILITY + 5.0)
        } else {
            first.map_or(f64::NAN, |f| f.mean)
        }
    };
    let off = |f: &Found| f.mean / reference(f.rate) - 1.0;
    let error_curve = |rate: f64, kept: bool| {
        let mine = found.iter().filter(|f| f.rate == rate);
        let mine = mine.filter(|f| (f.dt == STEP) == kept && f.dt * f.round as f64 > STEP);
        Curve {
            label: format!(
                "{}, {}",
                ["steps of a round's length", "kept for a round"][usize::from(kept)],
                if rate == 0.0 { "at rest" } else { "extension" }
            ),
            colour: usize::from(kept),
            filled: rate > 0.0,
            points: mine
                .map(|f| {
                    let noise = f.error / f.mean;
                    (f.dt * f.round as f64, off(f).abs().max(noise))
                })
                .collect(),
        }
    };
    let base = |what: &str| {
        let mut mine = costs.iter().filter(|c| c.what == what);
        mine.find(|c| c.round == 1)
            .map_or(f64::NAN, |cost| cost.seconds)
    };
    let scenes: Vec<&str> = costs
        .iter()
        .filter(|c| c.round == 1)
        .map(|c| c.what)
        .collect();
    task.draw(&[
        Panel {
            title: "Error of <Q²> of dumbbells",
            x: "length of a round / λ_H",
            y: "relative error, or its uncertainty",
            legend: SeriesLabelPosition::UpperLeft,
            curves: [(0.0, true), (0.0, false), (1.0, true), (1.0, false)]
                .map(|(rate, kept)| error_curve(rate, kept))
                .into(),
        },
        Panel {
            title: "Cost of a step",
            x: "steps of a round",
            y: "CPU time over that of a step that keeps nothing",
            legend: SeriesLabelPosition::LowerLeft,
            curves: scenes
                .iter()
                .enumerate()
                .map(|(k, what)| Curve {
                    label: (*what).into(),
                    colour: k,
                    filled: true,
                    points: costs
                        .iter()
                        .filter(|c| c.what == *what)
                        .map(|c| (c.round as f64, c.seconds / base(what)))
                        .collect(),
                })
                .collect(),
        },
    ])?;
    for cost in &costs {
        let ratio = cost.seconds / base(cost.what);
        println!(
            "{}, {} steps: {:.3} ms a step, {ratio:.2}",
            cost.what,
            cost.round,
            1e3 * cost.seconds
        );
    }
    for f in &found {
        println!(
            "rate {}, dt {}, {} steps: <Q^2> {:.4} +- {:.4}, {:+.4}",
            f.rate,
            f.dt,
            f.round,
            f.mean,
            f.error,
            off(f)
        );
    }
    check(&costs, &base)
}

/// `<Q^2>` by steps `dt` of which `round` share a mobility.
fn dumbbells(rate: f64, dt: f64, round: u64, quick: bool) -> Result<Found, Problem> {
    const GROUPS: usize = 20;
    let (count, time) = if quick { (100, 10.0) } else { (2000, 100.0) };
    let pairs = Molecules::linear(0, count, 2)?;
    let spring = Fene::new(1.0, EXTENSIBILITY.sqrt())?;
    let bond = start::BondLength::new(&spring, 1.0)?;
    let mut rng = start::stream(3);
    let mut positions = start::isolated(&pairs, |rng| bond.sample(rng), &mut rng);
    if rate > 0.0 {
        for (k, r) in positions.iter_mut().enumerate() {
            *r = DVec3::new(0.8 * spring.limit() * (k % 2) as f64, 0.0, 0.0) + 0.01 * *r;
        }
    }
    let flow = OpenFlow::new(DMat3::from_diagonal(DVec3::new(rate, -rate, 0.0)))?;
    let clock = Clock::new(dt, 1.0, 5)?;
    let mut system = System::new(flow, Particles::new(positions)?, clock);
    let mut springs = Bonded::new(spring, pairs.bonds());
    let mobility = Rpy::new(FRICTION, PI.sqrt() * HSTAR)?.within(pairs);
    let stepper = SemiImplicit::new(mobility, Cholesky::new(1e-6)?).with_tolerance(1e-4)?;
    let mut stepper = stepper.keeping(round)?;
    let steps = (time / dt) as u64;
    let between = (0.1 / dt).ceil() as u64;
    let (mut sums, mut looks) = ([0.0; GROUPS], 0.0);
    for step in 1..=steps {
        stepper.step(&mut system, &mut springs, &mut ())?;
        recentre(&mut system, &pairs)?;
        if 10 * step < steps || !step.is_multiple_of(between) {
            continue;
        }
        looks += 1.0;
        for (k, r) in system.particles.positions().chunks_exact(2).enumerate() {
            sums[k % GROUPS] += r[0].distance_squared(r[1]);
        }
    }
    let each = looks * f64::from(count) / GROUPS as f64;
    let means = sums.map(|sum| sum / each);
    let mean = means.iter().sum::<f64>() / GROUPS as f64;
    let variance: f64 = means.iter().map(|x| (x - mean) * (x - mean)).sum();
    let error = (variance / (GROUPS * (GROUPS - 1)) as f64).sqrt();
    Ok(Found {
        rate,
        dt,
        round,
        mean,
        error,
    })
}

/// What a step costs where binding and roots weigh differently.
fn each_cost(round: u64, quick: bool, costs: &mut Vec<Cost>) -> Result<(), Problem> {
    let radius = PI.sqrt() * HSTAR;
    let mut push = |what, seconds| {
        costs.push(Cost {
            what,
            round,
            seconds,
        });
    };
    let alone = Molecules::linear(0, 1, 100)?;
    let rpy = || Rpy::new(FRICTION, radius);
    let stepper = SemiImplicit::new(rpy()?, Cholesky::new(1e-6)?);
    let seconds = per_step(stepper.keeping(round)?, in_space(&alone)?, &alone, quick)?;
    push("one chain of 100, Cholesky", seconds);
    let stepper = SemiImplicit::new(rpy()?, Lanczos::new(TOLERANCE)?);
    let seconds = per_step(stepper.keeping(round)?, in_space(&alone)?, &alone, quick)?;
    push("the same, Lanczos", seconds);

    let many = Molecules::linear(0, 100, 10)?;
    let ewald = Ewald::new(FRICTION, radius, TOLERANCE)?;
    let stepper = SemiImplicit::new(ewald, Lanczos::new(TOLERANCE)?);
    let seconds = per_step(stepper.keeping(round)?, in_cell(&many)?, &many, quick)?;
    push("1000 beads, direct, Lanczos", seconds);
    let ewald = Ewald::new(FRICTION, radius, TOLERANCE)?;
    // Roots of so many steps at once as need not be thrown away.
    let root = BlockLanczos::new(TOLERANCE, round.min(16) as usize)?;
    let stepper = SemiImplicit::new(ewald, root).keeping(round)?;
    let seconds = per_step(stepper, in_cell(&many)?, &many, quick)?;
    push("1000 beads, direct, BlockLanczos", seconds);
    let mesh = Mesh::new(FRICTION, radius, TOLERANCE)?;
    let stepper = SemiImplicit::new(mesh, SplitNoise::new(TOLERANCE)?);
    let seconds = per_step(stepper.keeping(round)?, in_cell(&many)?, &many, quick)?;
    push("1000 beads, mesh, split noise", seconds);
    Ok(())
}

/// Chains in equilibrium, all from the origin: for one of them.
fn in_space(chains: &Molecules) -> Result<System<Open>, Problem> {
    let bond = start::BondLength::new(&Fene::new(1.0, EXTENSIBILITY.sqrt())?, 1.0)?;
    let mut rng = start::stream(3);
    let positions = start::isolated(chains, |rng| bond.sample(rng), &mut rng);
    let particles = Particles::new(positions)?;
    Ok(System::new(Open, particles, Clock::new(STEP, 1.0, 5)?))
}

/// Chains in a cell at their overlap concentration.
fn in_cell(chains: &Molecules) -> Result<System<PeriodicBox>, Problem> {
    let (n, length) = (chains.identities().len(), chains.iter().len());
    let beads = n / length;
    let q2 = 3.0 * EXTENSIBILITY / (EXTENSIBILITY + 5.0);
    let size = beads as f64;
    let radius = ((size * size - 1.0) / (6.0 * size) * q2).sqrt();
    let edge = cell_edge(n, overlap_concentration(beads, radius)?)?;
    let space = PeriodicBox::cubic(edge)?;
    let bond = start::BondLength::new(&Fene::new(1.0, EXTENSIBILITY.sqrt())?, 1.0)?;
    let mut rng = start::stream(3);
    let positions = start::chains(space.lattice(), chains, |rng| bond.sample(rng), &mut rng);
    let particles = Particles::new(positions)?;
    Ok(System::new(space, particles, Clock::new(STEP, 1.0, 5)?))
}

/// CPU seconds of a step, the mean over whole rounds after one of them.
fn per_step<B: Boundary>(
    mut stepper: impl Stepper<B, Bonded<Fene>>,
    mut system: System<B>,
    chains: &Molecules,
    quick: bool,
) -> Result<f64, Problem> {
    let mut springs = Bonded::new(Fene::new(1.0, EXTENSIBILITY.sqrt())?, chains.bonds());
    let longest = ROUNDS[ROUNDS.len() - 1];
    let steps = if quick { longest / 4 } else { 4 * longest };
    for _ in 0..longest / 4 {
        stepper.step(&mut system, &mut springs, &mut ())?;
    }
    let start = ThreadTime::now();
    for _ in 0..steps {
        stepper.step(&mut system, &mut springs, &mut ())?;
    }
    Ok(start.elapsed().as_secs_f64() / steps as f64)
}

/// What the figure is there to show, in numbers.
fn check(costs: &[Cost], base: &dyn Fn(&str) -> f64) -> Result<(), Problem> {
    let dear = costs.iter().filter(|c| c.what.contains("Cholesky"));
    for cost in dear.filter(|c| c.round >= 16) {
        let ratio = cost.seconds / base(cost.what);
        if ratio > 0.75 {
            return Err(format!("{} steps: {ratio:.2} of the cost is left", cost.round).into());
        }
    }
    Ok(())
}
