//! Weak error of schemes for bead-spring chains in strong planar extension, rate 5 / lambda_H, against the time step and
//! against CPU time: FENE dumbbells of extensibility 10, 50 and 1000, whose averages are known by quadrature, and a
//! chain of 20 beads, b = 50, at rate 0.05, compared with the semi-implicit scheme at a step of 1/20.
//!
//! Two errors: of the mean square length and of eta_1 by Kramers' expression, which feels springs near their limit most.
//! Points below their statistical error are drawn at it; steps at which a scheme gives up have no point. Every point costs
//! the same CPU time, so that small steps have larger statistical errors.

use crate::chart::{Curve, Panel, slope};
use crate::{Problem, Task};
use cpu_time::ThreadTime;
use plotters::prelude::SeriesLabelPosition;
use zimm::prelude::*;

/// Independent groups of chains.
const GROUPS: u64 = 16;

/// A chain in a flow.
struct Case {
    name: &'static str,
    beads: u32,
    extensibility: f64,
    rate: f64,
    /// Time until the steady state, and time that counts.
    times: [f64; 2],
    /// Exact <R_e^2> and eta_1, if they are known.
    exact: Option<[f64; 2]>,
}

const CASES: [Case; 4] = [
    Case {
        name: "dumbbell, b = 10",
        beads: 2,
        extensibility: 10.0,
        rate: 5.0,
        times: [3.0, 3.0],
        exact: Some([8.785_527_561_408_482, 17.368_643_049_718_377]),
    },
    Case {
        name: "dumbbell, b = 50",
        beads: 2,
        extensibility: 50.0,
        rate: 5.0,
        times: [3.0, 3.0],
        exact: Some([44.788_265_090_977_81, 89.376_078_839_300_93]),
    },
    Case {
        name: "dumbbell, b = 1000",
        beads: 2,
        extensibility: 1000.0,
        rate: 5.0,
        times: [4.0, 3.0],
        exact: Some([899.788_86, 1_799.377_69]),
    },
    Case {
        name: "20 beads, b = 50",
        beads: 20,
        extensibility: 50.0,
        rate: 0.05,
        times: [160.0, 80.0],
        exact: None,
    },
];

#[derive(Clone, Copy, PartialEq, Eq)]
enum Scheme {
    Euler,
    Rejection,
    Heun,
    SemiImplicit,
}

const SCHEMES: [(Scheme, &str); 4] = [
    (Scheme::Euler, "Euler"),
    (Scheme::Rejection, "Euler with rejection"),
    (Scheme::Heun, "Heun"),
    (Scheme::SemiImplicit, "semi-implicit"),
];

/// What one scheme does to one case at one step.
#[derive(Clone, Copy)]
struct Point {
    case: usize,
    scheme: Scheme,
    dt: f64,
    /// CPU time for a chain and a unit of time, in microseconds.
    cost: f64,
    found: [Mean; 2],
}

pub(crate) fn figure(task: &Task) -> Result<(), Problem> {
    let mut points = Vec::new();
    // The chain takes most of the time.
    let cases = if task.quick { 3 } else { CASES.len() };
    for (case, spec) in CASES.iter().enumerate().take(cases) {
        let factor = if task.quick { 4 } else { 2 };
        let largest = 2.0 / spec.rate.max(0.5);
        for (scheme, _) in SCHEMES {
            let smallest = match scheme {
                Scheme::SemiImplicit => largest / 256.0,
                _ => largest / 4096.0,
            };
            let mut dt = largest;
            while dt >= smallest {
                if let Some(point) = point(case, scheme, dt, task.quick)? {
                    points.push(point);
                }
                dt /= f64::from(factor);
            }
        }
    }
    let references: Vec<[f64; 2]> = CASES[..cases]
        .iter()
        .enumerate()
        .map(|(k, case)| match case.exact {
            Some(exact) => Ok(exact),
            None => {
                let finest = point(k, Scheme::SemiImplicit, 0.05, task.quick)?;
                let finest = finest.ok_or("the reference of the chain failed")?;
                Ok(finest.found.map(|mean| mean.value))
            }
        })
        .collect::<Result<_, Problem>>()?;
    let error = |point: &Point, k: usize| {
        let exact = references[point.case][k];
        let (off, noise) = (point.found[k].value - exact, point.found[k].at_least());
        (off.abs() / exact, noise / exact)
    };
    let name = |scheme| SCHEMES.iter().find(|s| s.0 == scheme).map_or("", |s| s.1);
    task.csv(
        "case,scheme,dt,cpu_microseconds,error_square,noise_square,error_viscosity,noise_viscosity",
        points.iter().map(|point| {
            let ([a, b], [c, d]) = (error(point, 0).into(), error(point, 1).into());
            let (case, scheme) = (CASES[point.case].name, name(point.scheme));
            format!(
                "\"{case}\",{scheme},{},{},{a:e},{b:e},{c:e},{d:e}",
                point.dt, point.cost
            )
        }),
    )?;
    let panels: Vec<Panel> = [0, 1, cases - 1]
        .into_iter()
        .flat_map(|case| [(case, false), (case, true)])
        .map(|(case, by_cost)| Panel {
            title: CASES[case].name,
            x: if by_cost {
                "CPU time of a chain, μs / λ_H"
            } else {
                "time step / λ_H"
            },
            y: "relative error of eta_1",
            legend: if by_cost {
                SeriesLabelPosition::UpperRight
            } else {
                SeriesLabelPosition::UpperLeft
            },
            curves: SCHEMES
                .iter()
                .enumerate()
                .map(|(colour, (scheme, label))| Curve {
                    label: (*label).into(),
                    colour,
                    filled: true,
                    points: points
                        .iter()
                        .filter(|point| point.case == case && point.scheme == *scheme)
                        .map(|point| {
                            let (error, noise) = error(point, 1);
                            let x = if by_cost { point.cost } else { point.dt };
                            (x, error.max(noise))
                        })
                        .collect(),
                })
                .collect(),
        })
        .collect();
    task.draw(&panels)?;
    check(&points, &error)
}

/// What the figure is there to show, in numbers.
fn check(points: &[Point], error: &impl Fn(&Point, usize) -> (f64, f64)) -> Result<(), Problem> {
    // The largest step from which on all smaller ones are within 1 %.
    let largest = |case: usize, scheme: Scheme| {
        let mine = points
            .iter()
            .filter(|p| p.case == case && p.scheme == scheme);
        let mut mine: Vec<_> = mine.map(|p| (p.dt, error(p, 1).0)).collect();
        mine.sort_by(|a, b| a.0.total_cmp(&b.0));
        let good = mine.iter().take_while(|(_, error)| *error < 0.01);
        good.last().map_or(0.0, |(dt, _)| *dt)
    };
    for (k, case) in CASES.iter().enumerate() {
        let steps = SCHEMES.map(|(scheme, _)| largest(k, scheme));
        println!("{}: largest steps within 1 %: {steps:?}", case.name);
    }
    for (scheme, name) in SCHEMES {
        for (k, case) in CASES.iter().enumerate().take(3) {
            let mine = points.iter().filter(|p| p.case == k && p.scheme == scheme);
            let clear = mine.filter(|p| {
                let (error, noise) = error(p, 1);
                error > 5.0 * noise && error < 0.3
            });
            let clear: Vec<_> = clear.map(|p| (p.dt, error(p, 1).0)).collect();
            if clear.len() > 1 {
                println!("{}, {name}: order {:.2}", case.name, slope(&clear));
            }
        }
    }
    let (ours, theirs) = (
        largest(0, Scheme::SemiImplicit),
        largest(0, Scheme::Rejection),
    );
    if ours < 30.0 * theirs {
        return Err(format!(
            "the semi-implicit step is {ours}, that of Euler with rejection {theirs}"
        )
        .into());
    }
    Ok(())
}

/// One run; nothing if the scheme fails.
fn point(case: usize, scheme: Scheme, dt: f64, quick: bool) -> Result<Option<Point>, Problem> {
    let spec = &CASES[case];
    let spring = Fene::new(1.0, spec.extensibility.sqrt())?;
    let bead_steps = if quick { 1e5 } else { 1.5e6 };
    let beads = bead_steps * dt / (spec.times[0] + spec.times[1]);
    let chains = Molecules::linear(0, (beads / f64::from(spec.beads)).ceil() as u32, spec.beads)?;
    let bonds = chains.bonds();
    let springs = || Bonded::new(spring, bonds.clone());
    let run = |group| -> Result<Run, Problem> {
        let free = FreeDraining::new(4.0)?;
        match scheme {
            Scheme::Euler => run(
                spec,
                chains,
                group,
                dt,
                springs(),
                EulerMaruyama::new(free, Diagonal),
            ),
            Scheme::Heun => run(spec, chains, group, dt, springs(), Heun::new(free)),
            Scheme::SemiImplicit => run(
                spec,
                chains,
                group,
                dt,
                springs(),
                SemiImplicit::new(free, Diagonal),
            ),
            Scheme::Rejection => {
                let stepper = Rejection::new(free, Diagonal, &springs());
                run(spec, chains, group, dt, springs(), stepper)
            }
        }
    };
    let mut means = [(); 2].map(|()| EnsembleAverage::new());
    let mut seconds = 0.0;
    for (group, run) in (0..).zip(replicas(GROUPS, run)?) {
        let Some((samples, time)) = run else {
            return Ok(None);
        };
        seconds += time;
        for sample in samples {
            for (mean, sample) in means.iter_mut().zip(sample) {
                mean.push((group, sample));
            }
        }
    }
    let time = spec.times[0] + spec.times[1];
    let chains = GROUPS as f64 * f64::from(chains.count());
    Ok(Some(Point {
        case,
        scheme,
        dt,
        cost: 1e6 * seconds / (chains * time),
        found: [means[0].estimate()?, means[1].estimate()?],
    }))
}

/// <R_e^2> and eta_1 again and again, and CPU seconds; nothing if the scheme fails.
type Run = Option<(Vec<[f64; 2]>, f64)>;

fn run(
    case: &Case,
    chains: Molecules,
    group: u64,
    dt: f64,
    mut springs: Bonded<Fene>,
    mut stepper: impl Stepper<OpenFlow, Bonded<Fene>>,
) -> Result<Run, Problem> {
    let bond = start::BondLength::new(springs.spring(), 1.0)?;
    let mut rng = start::stream(group);
    let mut positions = start::isolated(&chains, |rng| bond.sample(rng), &mut rng);
    // Stretched from the start, so that no time is lost in unfolding.
    let along = 0.9 * case.extensibility.sqrt();
    for (k, r) in positions.iter_mut().enumerate() {
        let bead = k as u32 % case.beads;
        *r = DVec3::new(along * f64::from(bead), 0.0, 0.0) + 0.01 * *r;
    }
    let gradient = DMat3::from_diagonal(DVec3::new(case.rate, -case.rate, 0.0));
    let clock = Clock::new(dt, 1.0, 1000 + group)?;
    let mut system = System::new(OpenFlow::new(gradient)?, Particles::new(positions)?, clock);
    recentre(&mut system, &chains)?;
    let steps = |time: f64| (time / dt).ceil() as u64;
    let (before, last) = (steps(case.times[0]), steps(case.times[0] + case.times[1]));
    let between = steps(case.times[1] / 100.0).max(1);
    let (mut kramers, mut ends) = (
        ChainStress { molecules: chains },
        EndToEnd { molecules: chains },
    );
    let mut samples = Vec::new();
    let start = ThreadTime::now();
    for step in 1..=last {
        let is_sample = step > before && step.is_multiple_of(between);
        let mut virial = Virial::default();
        let done = if is_sample {
            stepper.step(&mut system, &mut springs, &mut virial)
        } else {
            stepper.step(&mut system, &mut springs, &mut ())
        };
        if done.is_err() {
            return Ok(None);
        }
        recentre(&mut system, &chains)?;
        if is_sample {
            let frame = system.frame();
            let stress = kramers.measure(&frame, &virial)?;
            let ends = ends.measure(&frame, &())?;
            let square = ends.iter().map(|r| r.length_squared()).sum::<f64>();
            let viscosity = (stress.x_axis.x - stress.y_axis.y) / case.rate;
            samples.push([square / ends.len() as f64, viscosity]);
        }
    }
    Ok(Some((samples, start.elapsed().as_secs_f64())))
}
