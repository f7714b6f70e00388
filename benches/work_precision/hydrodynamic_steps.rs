//! What a unit of time costs with hydrodynamic interactions, at equal error: chains of 10 beads with excluded volume (WCA,
//! FENE b = 23.3, bead radius 0.82) at c/c* = 1.2, as in Jain (2013), table 5.1. The algorithm of that thesis, direct sums
//! without storage, Chebyshev's root and Euler's step with rejection at dt = 1e-4, beside the mesh, its split noise and the
//! semi-implicit step. CPU time is that of one thread; the direct sum is extrapolated from a few steps.
//!
//! The error of a time step is that of dumbbells of the same springs and beads, by two averages that quadrature knows: <Q^2>
//! at rest, with hydrodynamic interactions, which is easy, and eta_1 in planar extension at a rate of 5, free-draining, which
//! feels springs near their limit. Points below their statistical error are drawn at it.
//!
//! The thesis' own program took longer than its algorithm does here: 3.3 s a step for 1 000 beads and 58 s for 5 000 (by its
//! equations 5.27 to 5.30), which is 11 s for 2 000. Both comparisons are printed.

use crate::chart::{Curve, Panel};
use crate::{Problem, Task};
use cpu_time::ThreadTime;
use plotters::prelude::SeriesLabelPosition;
use zimm::prelude::*;

const FRICTION: f64 = 4.0;
const RADIUS: f64 = 0.819_742;
const EXTENSIBILITY: f64 = 23.333_3;
const EPSILON: f64 = 0.833_333;
const SIGMA: f64 = 2.415_229;
/// Beads in a volume at c/c* = 1.2.
const DENSITY: f64 = 0.0311;
const TOLERANCE: f64 = 1e-3;
/// To which the implicit equations are solved, a tenth of the error of mobilities.
const IMPLICIT: f64 = 1e-4;
const RATE: f64 = 5.0;
/// Seconds a step that the thesis tells for 1 000 and 5 000 beads.
const PUBLISHED: [f64; 2] = [3.3, 58.0];
const SCHEMES: [&str; 2] = ["thesis", "zimm"];
/// The steps of the thesis and of the semi-implicit scheme.
const STEPS: [f64; 2] = [1e-4, 5e-3];

const ERRORS: [&str; 2] = ["<Q²> at rest", "eta_1, rate 5"];

type Forces = (Bonded<Fene>, Pairwise<Wca, VerletList>);
type Space = PeriodicBox;

/// Steps whose errors are looked at, scheme by scheme.
const TRIED: [[f64; 5]; 2] = [
    [1e-4, 3e-4, 1e-3, 3e-3, 1e-2],
    [2.5e-3, 5e-3, 1e-2, 2e-2, 4e-2],
];

/// Cost of a step.
struct Cost {
    scheme: usize,
    beads: u32,
    dt: f64,
    seconds: f64,
}

/// Error of a time step.
struct Bias {
    scheme: usize,
    flows: bool,
    dt: f64,
    /// Relative error and its statistical error; nothing if the scheme failed.
    error: Option<[f64; 2]>,
}

pub(crate) fn figure(task: &Task) -> Result<(), Problem> {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    one.install(|| on_one_thread(task))
}

fn on_one_thread(task: &Task) -> Result<(), Problem> {
    let sizes: &[u32] = if task.quick {
        &[200, 2000]
    } else {
        &[200, 500, 1000, 2000]
    };
    let mut costs = Vec::new();
    for &beads in sizes {
        let system = at_rest(beads)?;
        for scheme in [0, 1] {
            // An implicit step takes more products the longer it is, Euler's always one.
            let all = scheme == 1 && Some(&beads) == sizes.last();
            for &dt in if all {
                &TRIED[1][..]
            } else {
                &STEPS[scheme..=scheme]
            } {
                costs.push(Cost {
                    scheme,
                    beads,
                    dt,
                    seconds: cost(scheme, beads, dt, &system, task.quick)?,
                });
            }
        }
    }
    let mut biases = Vec::new();
    for flows in [false, true] {
        for (scheme, steps) in TRIED.iter().enumerate() {
            for &dt in steps {
                if !task.quick || flows || dt >= 1e-3 {
                    biases.push(Bias {
                        scheme,
                        flows,
                        dt,
                        error: bias(scheme, dt, flows, task.quick)?,
                    });
                }
            }
        }
    }
    task.csv(
        "what,scheme,beads,dt,value,noise",
        costs
            .iter()
            .map(|c| {
                format!(
                    "seconds a step,{},{},{},{:e},",
                    SCHEMES[c.scheme], c.beads, c.dt, c.seconds
                )
            })
            .chain(biases.iter().map(|b| {
                let [error, noise] = b.error.unwrap_or([f64::NAN; 2]);
                let what = ERRORS[usize::from(b.flows)];
                format!(
                    "{what},{},2,{},{error:e},{noise:e}",
                    SCHEMES[b.scheme], b.dt
                )
            })),
    )?;
    let standard: Vec<&Cost> = costs.iter().filter(|c| c.dt == STEPS[c.scheme]).collect();
    let per_time = |cost: &Cost| cost.seconds / cost.dt;
    // Seconds of a unit of time for the most beads.
    let unit = |scheme: usize, dt: f64| {
        let mut mine = costs.iter().rev().filter(|cost| cost.scheme == scheme);
        let same = mine.clone().find(|cost| cost.dt == dt);
        let seconds = same.or_else(|| mine.next()).map(|cost| cost.seconds);
        seconds.map_or(f64::NAN, |seconds| seconds / dt)
    };
    let names = [
        "direct, Chebyshev, Euler",
        "mesh, split noise, semi-implicit",
    ];
    let errors = |scheme: usize, flows: bool| {
        let mine = biases
            .iter()
            .filter(|bias| bias.scheme == scheme && bias.flows == flows);
        mine.filter_map(|b| b.error.map(|[error, noise]| (b.dt, error.abs().max(noise))))
            .collect::<Vec<_>>()
    };
    let beads = |scheme: usize| Curve {
        label: names[scheme].into(),
        colour: 1 - scheme,
        filled: true,
        points: {
            let mine = standard.iter().filter(|cost| cost.scheme == scheme);
            mine.map(|cost| (f64::from(cost.beads), per_time(cost)))
                .collect()
        },
    };
    let error_curves = |x: &dyn Fn(usize, f64) -> f64| -> Vec<Curve> {
        let each = [(0, true), (1, true), (0, false), (1, false)];
        let curve = |(scheme, flows): (usize, bool)| Curve {
            label: format!(
                "{}, {}",
                ["Euler", "semi-implicit"][scheme],
                ERRORS[usize::from(flows)]
            ),
            colour: 1 - scheme,
            filled: flows,
            points: errors(scheme, flows)
                .into_iter()
                .map(|(dt, error)| (x(scheme, dt), error))
                .collect(),
        };
        each.map(curve).into()
    };
    task.draw(&[
        Panel {
            title: "A unit of time at dt = 1e-4 and 5e-3",
            x: "beads",
            y: "CPU time / λ_H, s",
            legend: SeriesLabelPosition::UpperLeft,
            curves: [0, 1].map(beads).into(),
        },
        Panel {
            title: "Error of dumbbells",
            x: "time step / λ_H",
            y: "relative error",
            legend: SeriesLabelPosition::LowerRight,
            curves: error_curves(&|_, dt| dt),
        },
        Panel {
            title: "Error against cost, 2000 beads",
            x: "CPU time / λ_H, s",
            y: "relative error",
            legend: SeriesLabelPosition::LowerLeft,
            curves: error_curves(&unit),
        },
    ])?;
    for cost in &costs {
        let (scheme, beads, step) = (SCHEMES[cost.scheme], cost.beads, 1e3 * cost.seconds);
        println!(
            "{beads} beads, {scheme}, dt {}: {step:.2} ms a step, {:.3} s / lambda_H",
            cost.dt,
            per_time(cost)
        );
    }
    for bias in &biases {
        let (scheme, what, dt) = (
            SCHEMES[bias.scheme],
            ERRORS[usize::from(bias.flows)],
            bias.dt,
        );
        match bias.error {
            Some([error, noise]) => {
                println!("{scheme}, dt {dt}: {what} off by {error:+.5} +- {noise:.5}")
            }
            None => println!("{scheme}, dt {dt}: {what} fails"),
        }
    }
    for flows in [false, true] {
        let largest = |scheme: usize| {
            let mut points = errors(scheme, flows);
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            let good = points.into_iter().take_while(|(_, error)| *error < 0.01);
            good.last().map_or(f64::NAN, |(dt, _)| dt)
        };
        let [a, b] = [0, 1].map(largest);
        let (what, ratio) = (ERRORS[usize::from(flows)], unit(0, a) / unit(1, b));
        println!("2000 beads, {what} within 1 %: steps {a} and {b}, ratio {ratio:.0}");
        // No worse than the thesis' step, as far as both are known.
        let of = |scheme| biases.iter().filter(move |bias| bias.scheme == scheme);
        let thesis = of(0).find(|bias| bias.flows == flows && bias.dt == STEPS[0]);
        if let Some([known, noise]) = thesis.and_then(|bias| bias.error) {
            let equal = of(1).filter(|bias| {
                let is_no_worse =
                    |[error, own]: [f64; 2]| error.abs() < known.abs() + 2.0 * noise.hypot(own);
                bias.flows == flows && bias.error.is_some_and(is_no_worse)
            });
            let longest = equal.map(|bias| bias.dt).fold(f64::NAN, f64::max);
            let ratio = unit(0, STEPS[0]) / unit(1, longest);
            println!("2000 beads, {what} no worse than at 1e-4: step {longest}, ratio {ratio:.0}");
        }
    }
    let unit = unit(1, STEPS[1]);
    let ours = costs
        .iter()
        .rfind(|cost| cost.scheme == 0)
        .map_or(f64::NAN, per_time)
        / unit;
    let exponent = (PUBLISHED[1] / PUBLISHED[0]).ln() / 5.0_f64.ln();
    let theirs = PUBLISHED[0] * 2.0_f64.powf(exponent) / STEPS[0] / unit;
    println!(
        "2000 beads, steps 1e-4 and 5e-3: ratio {ours:.0} for the thesis' algorithm as it is here"
    );
    println!(
        "2000 beads, steps 1e-4 and 5e-3: ratio {theirs:.0} for the thesis' cost model of its program, on its machine"
    );
    if ours >= 400.0 {
        Ok(())
    } else {
        Err(format!("the ratio of algorithms is {ours:.0}, below 400").into())
    }
}

fn fene() -> Result<Fene, ParameterError> {
    Fene::new(1.0, EXTENSIBILITY.sqrt())
}

fn forces(chains: &Molecules) -> Result<Forces, ParameterError> {
    let repulsion = Pairwise::new(Wca::new(EPSILON, SIGMA)?, VerletList::new(0.8)?);
    Ok((Bonded::new(fene()?, chains.bonds()), repulsion))
}

/// The repulsion with a force that does not grow below a distance, to push overlapping chains apart.
#[derive(Clone, Copy)]
struct Capped {
    law: Wca,
    least: f64,
}

impl PairForce for Capped {
    fn cutoff(&self) -> f64 {
        self.law.cutoff()
    }

    fn force(&self, pair: &Pair, now: &Now) -> Central {
        let r2 = pair.r2.max(self.least * self.least);
        self.law.force(&Pair { r2, ..*pair }, now)
    }

    fn energy(&self, pair: &Pair) -> f64 {
        let r2 = pair.r2.max(self.least * self.least);
        self.law.energy(&Pair { r2, ..*pair })
    }
}

/// Chains that have been pushed apart and have relaxed for a while without hydrodynamic interactions.
fn at_rest(beads: u32) -> Result<System<Space>, Problem> {
    let chains = Molecules::linear(0, beads / 10, 10)?;
    let space = PeriodicBox::cubic(cell_edge(beads as usize, DENSITY)?)?;
    let mut rng = start::stream(1);
    let positions = start::chains(space.lattice(), &chains, |_| 2.3, &mut rng);
    let mut system = System::new(space, Particles::new(positions)?, Clock::new(2e-3, 1.0, 1)?);
    let mut stepper = SemiImplicit::new(FreeDraining::new(FRICTION)?, Diagonal);
    let law = Wca::new(EPSILON, SIGMA)?;
    for share in [0.95, 0.9, 0.85, 0.8, 0.75, 0.7] {
        let repulsion = Pairwise::new(
            Capped {
                law,
                least: share * SIGMA,
            },
            VerletList::new(0.8)?,
        );
        let mut soft = (Bonded::new(fene()?, chains.bonds()), repulsion);
        for _ in 0..500 {
            stepper.step(&mut system, &mut soft, &mut ())?;
        }
    }
    let mut field = forces(&chains)?;
    for _ in 0..1000 {
        stepper.step(&mut system, &mut field, &mut ())?;
    }
    Ok(system)
}

/// CPU seconds of a step, the mean of a few.
fn cost(
    scheme: usize,
    beads: u32,
    dt: f64,
    system: &System<Space>,
    quick: bool,
) -> Result<f64, Problem> {
    let chains = Molecules::linear(0, beads / 10, 10)?;
    let (mut system, mut field) = (system.clone(), forces(&chains)?);
    system.clock.set_dt(dt)?;
    if scheme == 0 {
        let mobility = Ewald::new(FRICTION, RADIUS, TOLERANCE)?.without_storage();
        let stepper = Rejection::new(mobility, Chebyshev::new(TOLERANCE)?, &field.0);
        per_step(stepper, &mut system, &mut field, if quick { 1 } else { 5 })
    } else {
        let mobility = Mesh::new(FRICTION, RADIUS, TOLERANCE)?;
        let stepper =
            SemiImplicit::new(mobility, SplitNoise::new(TOLERANCE)?).with_tolerance(IMPLICIT)?;
        per_step(
            stepper,
            &mut system,
            &mut field,
            if quick { 50 } else { 200 },
        )
    }
}

/// The first step chooses splits and bounds, once for all; it does not count.
fn per_step(
    mut stepper: impl Stepper<Space, Forces>,
    system: &mut System<Space>,
    field: &mut Forces,
    steps: u32,
) -> Result<f64, Problem> {
    stepper.step(system, field, &mut ())?;
    let start = ThreadTime::now();
    for _ in 0..steps {
        stepper.step(system, field, &mut ())?;
    }
    Ok(start.elapsed().as_secs_f64() / f64::from(steps))
}

/// The repulsion of two beads, as a spring.
#[derive(Clone, Copy)]
struct Core(Wca);

impl BondForce for Core {
    fn force(&self, r2: f64) -> f64 {
        let pair = Pair {
            r2,
            ..Pair::default()
        };
        self.0.force(&pair, &Now::default()).total()
    }

    fn energy(&self, r2: f64) -> f64 {
        self.0.energy(&Pair {
            r2,
            ..Pair::default()
        })
    }
}

/// The relative error of a time step and its standard error; nothing if the scheme fails. At rest that of <Q^2> of dumbbells
/// with hydrodynamic interactions; in extension that of eta_1 by Kramers' expression, of free-draining ones.
fn bias(scheme: usize, dt: f64, flows: bool, quick: bool) -> Result<Option<[f64; 2]>, Problem> {
    let dumbbells = Molecules::linear(0, if quick { 200 } else { 600 }, 2)?;
    let limits = (fene()?, Core(Wca::new(EPSILON, SIGMA)?));
    let springs = Bonded::new(limits.0, dumbbells.bonds());
    let rate = if flows { RATE } else { 0.0 };
    let exact = exact(&limits, rate)?;
    let run = if flows {
        let mobility = || FreeDraining::new(FRICTION);
        if scheme == 0 {
            let stepper = Rejection::new(mobility()?, Diagonal, &springs);
            sample(stepper, dumbbells, limits, rate, dt, quick)?
        } else {
            let stepper = SemiImplicit::new(mobility()?, Diagonal).with_tolerance(IMPLICIT)?;
            sample(stepper, dumbbells, limits, rate, dt, quick)?
        }
    } else {
        let mobility = || Ok::<_, ParameterError>(Rpy::new(FRICTION, RADIUS)?.within(dumbbells));
        if scheme == 0 {
            let stepper = Rejection::new(mobility()?, Cholesky::new(1e-6)?, &springs);
            sample(stepper, dumbbells, limits, rate, dt, quick)?
        } else {
            let stepper =
                SemiImplicit::new(mobility()?, Cholesky::new(1e-6)?).with_tolerance(IMPLICIT)?;
            sample(stepper, dumbbells, limits, rate, dt, quick)?
        }
    };
    let Some(sums) = run else { return Ok(None) };
    let means: Vec<f64> = sums.iter().map(|mean| mean / exact - 1.0).collect();
    let groups = means.len() as f64;
    let mean = means.iter().sum::<f64>() / groups;
    let variance = means.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (groups - 1.0);
    Ok(Some([mean, (variance / groups).sqrt()]))
}

/// Means of independent groups of dumbbells; nothing if the scheme fails.
fn sample(
    mut stepper: impl Stepper<OpenFlow, (Bonded<Fene>, Bonded<Core>)>,
    dumbbells: Molecules,
    spring: (Fene, Core),
    rate: f64,
    dt: f64,
    quick: bool,
) -> Result<Option<Vec<f64>>, Problem> {
    const GROUPS: usize = 20;
    let bond = start::BondLength::new(&spring, 1.0)?;
    let mut rng = start::stream(3);
    let mut positions = start::isolated(&dumbbells, |rng| bond.sample(rng), &mut rng);
    if rate > 0.0 {
        // Stretched from the start, so that no time is lost in unfolding.
        for (k, r) in positions.iter_mut().enumerate() {
            *r = DVec3::new(0.9 * spring.limit() * (k % 2) as f64, 0.0, 0.0) + 0.01 * *r;
        }
    }
    let gradient = DMat3::from_diagonal(DVec3::new(rate, -rate, 0.0));
    let clock = Clock::new(dt, 1.0, 5)?;
    let mut system = System::new(OpenFlow::new(gradient)?, Particles::new(positions)?, clock);
    let mut field = (
        Bonded::new(spring.0, dumbbells.bonds()),
        Bonded::new(spring.1, dumbbells.bonds()),
    );
    // Dumbbells at rest forget in the course of their relaxation, those that are stretched at once.
    let time = match (quick, rate > 0.0) {
        (true, _) => 3.0,
        (false, true) => 4.0,
        (false, false) if dt < 2e-3 => 6.0,
        (false, false) => 40.0,
    };
    let steps = (time / dt).ceil() as u64;
    let between = (0.05 / dt).ceil() as u64;
    let (mut sums, mut count) = (vec![0.0; GROUPS], 0.0);
    for step in 1..=steps {
        if stepper.step(&mut system, &mut field, &mut ()).is_err() {
            return Ok(None);
        }
        recentre(&mut system, &dumbbells)?;
        if 4 * step < steps || !step.is_multiple_of(between) {
            continue;
        }
        count += 1.0;
        for (k, beads) in system.particles.positions().chunks_exact(2).enumerate() {
            let q = beads[1] - beads[0];
            sums[k % GROUPS] += if rate > 0.0 {
                -spring.force(q.length_squared()) * (q.x * q.x - q.y * q.y) / rate
            } else {
                q.length_squared()
            };
        }
    }
    let each = count * f64::from(dumbbells.count()) / GROUPS as f64;
    Ok(Some(sums.into_iter().map(|sum| sum / each).collect()))
}

/// <Q^2> at rest or eta_1 = 2 <x^2 + y^2> in extension, by the midpoint rule: the density is exp(-U / kT) times
/// exp(rate (x^2 - y^2)), in which x^2 - y^2 = (Q^2 - z^2) cos 2 phi.
fn exact(spring: &impl BondForce, rate: f64) -> Result<f64, Problem> {
    const POINTS: [usize; 3] = [800, 200, 64];
    let [lengths, heights, angles] = POINTS;
    let limit = spring.limit();
    let middle = |k: usize, count: usize| (k as f64 + 0.5) / count as f64;
    let (mut above, mut below) = (0.0, 0.0);
    for k in 0..lengths {
        let q2 = (limit * middle(k, lengths)).powi(2);
        let potential = spring.energy(q2) + rate * limit * limit;
        for l in 0..heights {
            let across = q2 * (1.0 - middle(l, heights).powi(2));
            for m in 0..angles {
                let turned = (std::f64::consts::PI * middle(m, angles)).cos();
                let weight = q2 * (rate * across * turned - potential).exp();
                above += weight * if rate > 0.0 { 2.0 * across } else { q2 };
                below += weight;
            }
        }
    }
    if below > 0.0 {
        Ok(above / below)
    } else {
        Err("the springs have no steady state".into())
    }
}
