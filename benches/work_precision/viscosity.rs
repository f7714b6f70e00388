//! Three rheometers on one fluid: the relative error of the viscosity against the CPU time of the run, in shear between
//! Lees and Edwards' images, in reverse Poiseuille flow, and at rest by Green and Kubo. The fluid of Groot and Warren.
//!
//! The error is not the one that a run tells but the scatter of independent runs. The cost is that of the whole run, the
//! 500 steps before anything counts included. Shear and channel reach the same rate at most, 0.4; the cell at rest is
//! that of the shear.

use crate::chart::{Curve, Panel, slope};
use crate::{Problem, Task, scene};
use cpu_time::ThreadTime;
use plotters::prelude::SeriesLabelPosition;
use zimm::prelude::*;

const RATE: f64 = 0.4;
const EDGE: f64 = 6.0;
/// The channel is as high as two cells.
const HEIGHT: f64 = 10.0;
const EVERY: u64 = 5;
const UNSEEN: u64 = 500;
/// Lags until which the modulus is integrated; it has decayed by then.
const LAG: f64 = 4.0;

type Rheometer = fn(u64, u64) -> Result<f64, Problem>;
const RHEOMETERS: [(&str, Rheometer); 3] = [
    ("shear, Lees-Edwards", in_shear),
    ("reverse Poiseuille flow", in_a_channel),
    ("rest, Green-Kubo", at_rest),
];

/// What runs of one length give.
struct Row {
    rheometer: &'static str,
    steps: u64,
    /// CPU seconds of a run.
    cost: f64,
    mean: f64,
    /// Standard deviation over the mean.
    error: f64,
}

pub(crate) fn figure(task: &Task) -> Result<(), Problem> {
    let (lengths, runs): (&[u64], u64) = if task.quick {
        (&[1000, 2000], 6)
    } else {
        (&[1000, 2000, 4000], 12)
    };
    let mut rows = Vec::new();
    for (rheometer, viscosity) in RHEOMETERS {
        for &steps in lengths {
            // Short runs are cheap, so there are more of them.
            let runs = runs * (lengths.last().unwrap_or(&steps) / steps).min(2);
            let (start, mut found) = (ThreadTime::now(), Vec::new());
            for seed in 1..=runs {
                found.push(viscosity(seed, steps)?);
            }
            let mean = found.iter().sum::<f64>() / runs as f64;
            let square = found.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
            let row = Row {
                rheometer,
                steps,
                cost: start.elapsed().as_secs_f64() / runs as f64,
                mean,
                error: (square / (runs - 1) as f64).sqrt() / mean,
            };
            println!(
                "{rheometer}: {steps} steps, {:.2} s, viscosity {mean:.3}, error {:.1} %",
                row.cost,
                100.0 * row.error
            );
            rows.push(row);
        }
    }
    task.csv(
        "rheometer,steps,cpu_seconds,viscosity,relative_error",
        rows.iter().map(|row| {
            let Row {
                rheometer,
                steps,
                cost,
                mean,
                error,
            } = row;
            format!("\"{rheometer}\",{steps},{cost:.3},{mean:.4},{error:.4}")
        }),
    )?;
    let curves = RHEOMETERS.iter().zip(0..).map(|((name, _), colour)| Curve {
        label: (*name).into(),
        colour,
        filled: true,
        points: (rows.iter().filter(|row| row.rheometer == *name))
            .map(|row| (row.cost, row.error))
            .collect(),
    });
    let curves: Vec<_> = curves.collect();
    check(&curves, task.quick)?;
    task.draw(&[Panel {
        title: "Viscosity of the fluid of Groot and Warren",
        x: "CPU time of a run, s",
        y: "relative error",
        legend: SeriesLabelPosition::UpperRight,
        curves,
    }])
}

/// What the figure is there to show: errors fall as the root of the time, a little faster where the beginning still
/// counts, and where there is a flow they are less.
fn check(curves: &[Curve], quick: bool) -> Result<(), Problem> {
    let bought = |curve: &Curve| {
        let products = curve.points.iter().map(|(cost, error)| error * cost.sqrt());
        products.sum::<f64>() / curve.points.len() as f64
    };
    for curve in curves {
        let order = slope(&curve.points);
        println!(
            "{}: {:.2} % times the root of a second, order {order:.2}",
            curve.label,
            100.0 * bought(curve)
        );
        if !quick && !(-0.9..-0.3).contains(&order) {
            return Err(format!("{}: errors fall with the power {order}", curve.label).into());
        }
    }
    match curves {
        [shear, _, rest] if bought(rest) < bought(shear) => {
            Err("the fluid at rest tells its viscosity better than the one in flow".into())
        }
        _ => Ok(()),
    }
}

/// The fluid in a space, its clock set to a seed.
fn fluid<B: Periodic>(space: B, seed: u64) -> Result<System<B>, Problem> {
    let mut system = scene::fluid(space);
    system.clock = Clock::new(0.04, 1.0, seed)?;
    Ok(system)
}

fn in_shear(seed: u64, steps: u64) -> Result<f64, Problem> {
    let mut system = fluid(
        LeesEdwards::new(DVec3::splat(EDGE), Steady::new(RATE)?)?,
        seed,
    )?;
    let (mut field, mut stepper) = (scene::field(), GrootWarren::new(0.65)?);
    let mut viscometer = Viscometer::new(RATE)?;
    for step in 0..UNSEEN + steps {
        if step >= UNSEEN && step % EVERY == 0 {
            let mut virial = Virial::default();
            stepper.step(&mut system, &mut field, &mut virial)?;
            let stress = Stress.measure(&system.frame(), &virial);
            viscometer.push(stress.without(Item::Random).total());
        } else {
            stepper.step(&mut system, &mut field, &mut ())?;
        }
    }
    Ok(viscometer.estimate()?.viscosity.value)
}

fn in_a_channel(seed: u64, steps: u64) -> Result<f64, Problem> {
    // The largest rate, n f H / 2 eta, is that of the shear.
    let force = RATE * 2.0 * 0.85 / (scene::DENSITY * 0.5 * HEIGHT);
    let mut system = fluid(PeriodicBox::brick(DVec3::new(EDGE, HEIGHT, EDGE))?, seed)?;
    let mut field = (scene::field(), ReversePoiseuille::new(force, 0, 1)?);
    let mut stepper = GrootWarren::new(0.65)?;
    let profile = Profile::new(DVec3::Y, HEIGHT, 40)?;
    let silent = LayeredVirial::new(&profile);
    let mut observable = StressProfile::new(profile, 0);
    let mut average = StressProfileAverage::new(&observable);
    for step in 0..UNSEEN + steps {
        stepper.step(&mut system, &mut field, &mut ())?;
        // The viscosity is that of the velocities and the force: no stress is asked for.
        if step >= UNSEEN && step % EVERY == 0 {
            average.push(observable.measure(&system.frame(), &silent)?);
        }
    }
    Ok(Channel::new(DVec3::X, force)?.viscosity(&average)?.value)
}

fn at_rest(seed: u64, steps: u64) -> Result<f64, Problem> {
    let mut system = fluid(scene::cube(EDGE), seed)?;
    let (mut field, mut stepper) = (scene::field(), GrootWarren::new(0.65)?);
    let dt = system.clock.now().dt;
    let mut green_kubo = GreenKubo::new(EVERY as f64 * dt, EDGE.powi(3), 1.0)?;
    let mut sum = DMat3::ZERO;
    for step in 0..UNSEEN + steps {
        let mut virial = Virial::default();
        stepper.step(&mut system, &mut field, &mut virial)?;
        if step >= UNSEEN {
            sum += Stress.measure(&system.frame(), &virial).total();
            if step % EVERY == EVERY - 1 {
                green_kubo.push(sum * (EVERY as f64).recip());
                sum = DMat3::ZERO;
            }
        }
    }
    Ok(green_kubo.viscosity(LAG)?.value)
}
