//! Error of the schemes of DPD against the time step and against CPU time, in two states: the fluid of Groot and Warren
//! (density 3, a = 25, gamma = 4.5), and a melt of FENE chains with stiff springs and strong friction (5 beads, H = 50,
//! Q_0 = 1, gamma = 40, the same density and repulsion).
//!
//! Four errors. Kinetic and configurational temperature are compared with kT = 1. The pressure of the fluid is compared
//! with a Monte Carlo simulation, which has no time step; that of the melt, and diffusion (the slope of the mean square
//! displacement of beads from 1.6 to 6.4 time units), with `DpdBaoab` at a step of 0.005. The scheme of Lowe and
//! Andersen has a diffusion of its own and is compared with itself there.
//!
//! Points below their statistical error are drawn at it; steps at which a scheme gives up have no point. CPU time is that
//! of the steps alone, for a particle and a unit of time.

use crate::chart::{Curve, Panel, slope};
use crate::{Problem, Task};
use cpu_time::ThreadTime;
use plotters::prelude::SeriesLabelPosition;
use zimm::prelude::*;

const DENSITY: f64 = 3.0;
const REPULSION: f64 = 25.0;
const STIFFNESS: f64 = 50.0;
const LIMIT: f64 = 1.0;
const BEADS: u32 = 5;
/// Step of the runs that others are compared with.
const FINEST: f64 = 0.005;

/// A state.
pub(crate) struct Case {
    name: &'static str,
    friction: f64,
    /// Rate of Lowe and Andersen's bath.
    rate: f64,
    chains: bool,
    /// The largest step.
    longest: f64,
    /// By Monte Carlo, 1536 particles.
    pressure: Option<f64>,
}

/// The Groot-Warren state.
pub(crate) const FLUID: Case = Case {
    name: "fluid, gamma 4.5",
    friction: 4.5,
    rate: 5.0,
    chains: false,
    longest: 0.08 * std::f64::consts::SQRT_2,
    pressure: Some(23.652_826),
};

/// The stiff state.
pub(crate) const CHAINS: Case = Case {
    name: "FENE chains, gamma 40",
    friction: 40.0,
    rate: 20.0,
    chains: true,
    longest: 0.08,
    pressure: None,
};

#[derive(Clone, Copy, PartialEq, Eq)]
enum Scheme {
    GrootWarren,
    Predicting,
    Shardlow,
    DpdBaoab,
    LoweAndersen,
}

const SCHEMES: [(Scheme, &str); 5] = [
    (Scheme::GrootWarren, "Groot-Warren, λ = 0.5"),
    (Scheme::Predicting, "Groot-Warren, λ = 0.65"),
    (Scheme::Shardlow, "Shardlow"),
    (Scheme::DpdBaoab, "BAOAB"),
    (Scheme::LoweAndersen, "Lowe-Andersen"),
];

const QUANTITIES: [&str; 4] = [
    "kinetic temperature",
    "configurational temperature",
    "pressure",
    "diffusion",
];

/// What one scheme shows at one step.
#[derive(Clone, Copy)]
struct Point {
    scheme: Scheme,
    dt: f64,
    /// CPU time for a particle and a unit of time, in microseconds.
    cost: f64,
    found: [Mean; 4],
}

/// How large and long the runs are.
struct Size {
    edge: f64,
    time: f64,
    /// Time of the runs that others are compared with.
    reference: f64,
    /// Between steps of one curve.
    factor: f64,
    shortest: f64,
}

pub(crate) fn figure(task: &Task, case: &Case) -> Result<(), Problem> {
    let size = if task.quick {
        Size {
            edge: 5.0,
            time: 28.0,
            reference: 56.0,
            factor: 2.0,
            shortest: 0.02,
        }
    } else {
        Size {
            edge: 8.0,
            time: 100.0,
            reference: 400.0,
            factor: 2.0_f64.sqrt(),
            shortest: 0.0099,
        }
    };
    let mut points = Vec::new();
    for (scheme, _) in SCHEMES {
        let mut dt = case.longest;
        while dt >= size.shortest {
            points.extend(point(case, scheme, dt, &size, size.time)?);
            dt /= size.factor;
        }
    }
    let reference = |scheme| -> Result<[Mean; 4], Problem> {
        let finest = point(case, scheme, FINEST, &size, size.reference)?;
        let mut found = finest.ok_or("a reference failed")?.found;
        let exact = |value| Mean {
            value,
            error: StandardError::AtLeast(0.0),
        };
        (found[0], found[1]) = (exact(1.0), exact(1.0));
        if let Some(pressure) = case.pressure {
            found[2] = exact(pressure);
        }
        Ok(found)
    };
    let of_dpd = reference(Scheme::DpdBaoab)?;
    let of_redraw = reference(Scheme::LoweAndersen)?;
    let error = |point: &Point, k: usize| {
        let mut exact = of_dpd[k];
        if k == 3 && point.scheme == Scheme::LoweAndersen {
            exact = of_redraw[k];
        }
        let noise = point.found[k].at_least().hypot(exact.at_least());
        let off = (point.found[k].value - exact.value).abs();
        (off / exact.value, noise / exact.value)
    };
    write(task, &points, &error)?;
    draw(task, &points, &error)?;
    check(case, &points, &error)
}

/// Error of a quantity and its statistical error.
trait Errs: Fn(&Point, usize) -> (f64, f64) {}
impl<F: Fn(&Point, usize) -> (f64, f64)> Errs for F {}

fn name(scheme: Scheme) -> &'static str {
    SCHEMES.iter().find(|s| s.0 == scheme).map_or("", |s| s.1)
}

fn write(task: &Task, points: &[Point], error: &impl Errs) -> Result<(), Problem> {
    let columns = ["kinetic_temperature", "configurational_temperature"];
    let columns = columns.into_iter().chain(["pressure", "diffusion"]);
    let columns: Vec<String> = columns
        .map(|column| format!("{column},error_{column},noise_{column}"))
        .collect();
    task.csv(
        &format!("scheme,dt,cpu_microseconds,{}", columns.join(",")),
        points.iter().map(|point| {
            let mut line = format!("\"{}\",{},{}", name(point.scheme), point.dt, point.cost);
            for (k, found) in point.found.iter().enumerate() {
                let (off, noise) = error(point, k);
                line += &format!(",{},{off:e},{noise:e}", found.value);
            }
            line
        }),
    )
}

/// Errors against the step above, against CPU time below.
fn draw(task: &Task, points: &[Point], error: &impl Errs) -> Result<(), Problem> {
    let panels: Vec<Panel> = [false, true]
        .into_iter()
        .flat_map(|by_cost| (0..QUANTITIES.len()).map(move |k| (by_cost, k)))
        .map(|(by_cost, k)| Panel {
            title: QUANTITIES[k],
            x: if by_cost {
                "CPU time of a particle, μs / unit of time"
            } else {
                "time step"
            },
            y: "relative error",
            legend: SeriesLabelPosition::UpperLeft,
            curves: SCHEMES
                .iter()
                .enumerate()
                .map(|(colour, (scheme, label))| Curve {
                    // There is room in the first panel only.
                    label: if by_cost || k > 0 {
                        String::new()
                    } else {
                        (*label).into()
                    },
                    colour,
                    filled: true,
                    points: points
                        .iter()
                        .filter(|point| point.scheme == *scheme)
                        .map(|point| {
                            let (off, noise) = error(point, k);
                            let x = if by_cost { point.cost } else { point.dt };
                            (x, off.max(noise))
                        })
                        .collect(),
                })
                .collect(),
        })
        .collect();
    task.draw(&panels)
}

/// What the figure is there to show, in numbers.
fn check(case: &Case, points: &[Point], error: &impl Errs) -> Result<(), Problem> {
    for (scheme, name) in SCHEMES {
        let mine: Vec<&Point> = points.iter().filter(|p| p.scheme == scheme).collect();
        for (k, quantity) in QUANTITIES.iter().enumerate() {
            let clear = mine.iter().filter(|p| {
                let (off, noise) = error(p, k);
                off > 5.0 * noise && off < 0.3
            });
            let clear: Vec<_> = clear.map(|p| (p.dt, error(p, k).0)).collect();
            let mut largest = 0.0_f64;
            for point in mine.iter().rev() {
                if error(point, k).0 > 0.01 + error(point, k).1 {
                    break;
                }
                largest = point.dt;
            }
            let order = if clear.len() > 1 {
                format!("order {:.1}", slope(&clear))
            } else {
                "too few points above the noise for an order".into()
            };
            println!(
                "{}, {name}, {quantity}: within 1 % up to dt = {largest:.4}, {order}",
                case.name
            );
        }
    }
    let cooled = points.iter().filter(|p| p.scheme == Scheme::DpdBaoab);
    let cooled: Vec<_> = cooled
        .map(|p| (p.dt, error(p, 0)))
        .filter(|(_, (off, noise))| *off < 0.3 && *off > 5.0 * noise)
        .map(|(dt, (off, _))| (dt, off))
        .collect();
    let order = slope(&cooled);
    if cooled.len() > 1 && !(1.4..2.6).contains(&order) {
        return Err(
            format!("velocities of BAOAB cool with the step to the power of {order}").into(),
        );
    }
    // Positions: BAOAB leaves them to a potential nearer to the true one than Verlet does, in any bath.
    let dt = points.iter().filter(|p| p.scheme == Scheme::DpdBaoab);
    let longest = dt.map(|p| p.dt).filter(|&dt| dt < 0.09);
    let longest = longest.fold(0.0, f64::max);
    let of = |scheme, k| {
        let same = |p: &&Point| p.scheme == scheme && (p.dt - longest).abs() < 1e-12;
        points.iter().find(same).map_or(f64::INFINITY, |p| {
            let (off, _) = error(p, k);
            off
        })
    };
    let ours = of(Scheme::DpdBaoab, 1);
    for other in [Scheme::GrootWarren, Scheme::Shardlow] {
        let theirs = of(other, 1);
        if 2.0 * ours > theirs {
            return Err(format!(
                "at dt = {longest} the temperature of positions is off by {ours} with BAOAB and by {theirs} with {}",
                name(other)
            )
            .into());
        }
    }
    Ok(())
}

type Springs = Bonded<Fene>;

/// One run; nothing if the scheme fails.
fn point(
    case: &Case,
    scheme: Scheme,
    dt: f64,
    size: &Size,
    time: f64,
) -> Result<Option<Point>, Problem> {
    let space = PeriodicBox::cubic(size.edge)?;
    let particles = (DENSITY * space.lattice().volume()).round() as u32;
    let chains = Molecules::linear(0, particles / BEADS, BEADS)?;
    let mut rng = start::stream(1);
    let spring = Fene::new(STIFFNESS, LIMIT)?;
    let (positions, bonds) = if case.chains {
        let positions = start::chains(space.lattice(), &chains, |_| 0.3, &mut rng);
        (positions, chains.bonds())
    } else {
        let positions = start::uniform(space.lattice(), particles as usize, &mut rng);
        (positions, Vec::new())
    };
    let particles = Particles::new(positions)?;
    let velocities = start::velocities(&particles, 1.0, &mut rng)?;
    let particles = particles.with_velocities(velocities)?.counting_images();
    let mut system = System::new(space, particles, Clock::new(0.01, 1.0, 5)?);

    let list = || VerletList::new(0.4);
    let friction = DpdDissipative::new(case.friction, Quadratic, 1.0)?;
    let springs = || Bonded::new(spring, bonds.clone());
    let mut soft = (
        Pairwise::new(DpdConservative::new(REPULSION, 1.0)?, list()?),
        springs(),
    );
    let mut bath = Shardlow::new(friction, list()?);
    for _ in 0..500 {
        bath.step(&mut system, &mut soft, &mut ())?;
    }
    system.clock.set_dt(dt)?;

    let probe = (
        Pairwise::new(DpdConservative::new(REPULSION, 1.0)?, list()?),
        springs(),
    );
    let run = Run {
        system,
        probe,
        time,
    };
    let done = match scheme {
        Scheme::GrootWarren | Scheme::Predicting => {
            let lambda = if scheme == Scheme::Predicting {
                0.65
            } else {
                0.5
            };
            let law = Dpd::new(REPULSION, case.friction)?;
            let field = (Pairwise::new(law, list()?), springs());
            run.go(GrootWarren::new(lambda)?, field)?
        }
        Scheme::Shardlow => run.go(Shardlow::new(friction, list()?), soft)?,
        Scheme::DpdBaoab => run.go(DpdBaoab::new(friction, list()?), soft)?,
        Scheme::LoweAndersen => run.go(LoweAndersen::new(case.rate, 1.0, list()?)?, soft)?,
    };
    Ok(done.map(|(cost, found)| Point {
        scheme,
        dt,
        cost,
        found,
    }))
}

/// A state to be run, and the conservative forces to look at it with.
struct Run {
    system: System<PeriodicBox>,
    probe: (Pairwise<DpdConservative, VerletList>, Springs),
    time: f64,
}

impl Run {
    /// Microseconds for a particle and a unit of time, and what was found; nothing if a step fails.
    fn go<F: ForceField<PeriodicBox>>(
        mut self,
        mut stepper: impl Stepper<PeriodicBox, F>,
        mut field: F,
    ) -> Result<Option<(f64, [Mean; 4])>, Problem> {
        let (dt, system) = (self.system.clock.now().dt, &mut self.system);
        let steps = |time: f64| (time / dt).round().max(1.0) as u64;
        let (between, apart) = (steps(0.2), steps(0.8));
        let (before, last) = (steps(10.0), steps(10.0 + self.time));
        let [mut temperature, mut pressure] = [(); 2].map(|()| BlockAverage::new());
        let mut configurational = RatioAverage::new();
        let mut diffusion = MeanSquareDisplacement::new(apart as f64 * dt, 2..=8)?;
        let mut seconds = 0.0;
        let mut forces = vec![DVec3::ZERO; system.particles.len()];
        for step in 1..=last {
            let is_sample = step > before && step.is_multiple_of(between);
            let mut virial = Virial::default();
            let start = ThreadTime::now();
            let done = if is_sample {
                stepper.step(system, &mut field, &mut virial)
            } else {
                stepper.step(system, &mut field, &mut ())
            };
            if step > before {
                seconds += start.elapsed().as_secs_f64();
            }
            if done.is_err() {
                return Ok(None);
            }
            let frame = system.frame();
            if is_sample {
                temperature.push(KineticTemperature::default().measure(&frame, &())?.mean());
                pressure.push(Stress.measure(&frame, &virial).pressure());
                let mut curvature = Curvature(0.0);
                forces.fill(DVec3::ZERO);
                self.probe.accumulate(&frame, &mut forces, &mut curvature)?;
                let squares = forces.iter().map(|f| f.length_squared()).sum();
                configurational.push([squares, curvature.0]);
            }
            if step > before && step.is_multiple_of(apart) {
                diffusion.push(Unwrapped.measure(&frame, &())?);
            }
        }
        let particle_time = system.particles.len() as f64 * (last - before) as f64 * dt;
        // Positions that have no temperature: the step is far too long.
        let Ok(configurational) = configurational.estimate() else {
            return Ok(None);
        };
        let found = [
            temperature.estimate()?,
            configurational,
            pressure.estimate()?,
            diffusion.estimate()?.coefficient,
        ];
        Ok(Some((1e6 * seconds / particle_time, found)))
    }
}

/// The Laplacian of the potential energy, summed over beads: with the squared forces it makes the configurational
/// temperature of pairs and springs together.
struct Curvature(f64);

impl Tally for Curvature {
    fn fresh(&self) -> Self {
        Self(0.0)
    }

    fn hear(&mut self, item: Item, _: DVec3, r: DVec3, _: DVec3, _: &impl Fn() -> f64) {
        let r2 = r.length_squared();
        // U'' + 2 U' / r of U = (a / 2) (1 - r)^2 and of Warner's spring.
        self.0 += 2.0
            * match item {
                Item::Spring => {
                    let left = 1.0 - r2 / (LIMIT * LIMIT);
                    STIFFNESS / left * (3.0 + 2.0 * (1.0 - left) / left)
                }
                _ => REPULSION * (3.0 - 2.0 / r2.sqrt()),
            };
    }

    fn absorb(&mut self, other: Self) {
        self.0 += other.0;
    }
}
