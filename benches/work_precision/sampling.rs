//! How often to measure: the statistical error of averages of pressure, shear stress and kinetic temperature against the
//! CPU time of the run, for sampling intervals of 1 to 128 steps. The fluid of Groot and Warren, 3000 particles.
//!
//! One run is sampled in every step. An interval of k steps is the same run with all but every k-th sample left out; its
//! error is that of blocks of 512 steps, which are long against the memory of the fluid, averaged over the k ways
//! to begin. Its cost is that of all steps and of the samples that are left, each measured by itself.

use crate::chart::{Curve, Panel};
use crate::{Problem, Task, scene};
use cpu_time::ThreadTime;
use plotters::prelude::SeriesLabelPosition;
use zimm::prelude::*;

const BLOCK: usize = 512;
const INTERVALS: [usize; 8] = [1, 2, 4, 8, 16, 32, 64, 128];
const QUANTITIES: [&str; 3] = ["pressure", "shear stress", "kinetic temperature"];

/// What one interval gives.
struct Row {
    interval: usize,
    /// CPU seconds of the whole run.
    cost: f64,
    /// Standard errors over it.
    errors: [f64; 3],
}

pub(crate) fn figure(task: &Task) -> Result<(), Problem> {
    let (edge, blocks) = if task.quick { (6.0, 16) } else { (10.0, 60) };
    let (mut system, mut field) = scene::equilibrated(scene::cube(edge));
    let mut stepper = GrootWarren::new(0.65)?;
    let steps = blocks * BLOCK;
    let mut samples = Vec::with_capacity(steps);
    let start = ThreadTime::now();
    for _ in 0..steps {
        let mut virial = Virial::default();
        stepper.step(&mut system, &mut field, &mut virial)?;
        let frame = system.frame();
        let stress = Stress.measure(&frame, &virial);
        let temperature = KineticTemperature::default().measure(&frame, &())?;
        samples.push([stress.pressure(), stress.shear(), temperature.mean()]);
    }
    let sampled = start.elapsed().as_secs_f64() / steps as f64;
    let start = ThreadTime::now();
    for _ in 0..steps / 4 {
        stepper.step(&mut system, &mut field, &mut ())?;
    }
    let plain = start.elapsed().as_secs_f64() / (steps / 4) as f64;
    let sample = sampled - plain;
    println!(
        "a step takes {:.0} μs, a sample {:.0} % of that",
        1e6 * plain,
        100.0 * sample / plain
    );
    let rows = INTERVALS.map(|interval| Row {
        interval,
        cost: steps as f64 * (plain + sample / interval as f64),
        errors: [0, 1, 2].map(|k| error(&samples, k, interval)),
    });
    task.csv(
        "interval_steps,cpu_seconds,error_pressure,error_shear_stress,error_temperature",
        rows.iter().map(|row| {
            let [a, b, c] = row.errors;
            format!("{},{},{a:e},{b:e},{c:e}", row.interval, row.cost)
        }),
    )?;
    let panel = |title, x, y, pick: fn(&Row, usize) -> (f64, f64)| Panel {
        title,
        x,
        y,
        legend: SeriesLabelPosition::UpperRight,
        curves: QUANTITIES
            .iter()
            .enumerate()
            .map(|(k, quantity)| Curve {
                label: (*quantity).into(),
                colour: k,
                filled: true,
                points: rows.iter().map(|row| pick(row, k)).collect(),
            })
            .collect(),
    };
    task.draw(&[
        panel(
            "One run, sampled every 1 to 128 steps",
            "CPU time of the run, s",
            "standard error",
            |row, k| (row.cost, row.errors[k]),
        ),
        panel(
            "Error that a second of CPU time buys",
            "sampling interval, steps",
            "standard error",
            |row, k| (row.interval as f64, row.errors[k] * row.cost.sqrt()),
        ),
    ])?;
    check(&rows)
}

/// The standard error of the mean over the run, from the scatter of blocks of which every `interval`-th sample is seen.
fn error(samples: &[[f64; 3]], quantity: usize, interval: usize) -> f64 {
    let blocks = samples.len() / BLOCK;
    let mut variance = 0.0;
    for first in 0..interval {
        let means: Vec<f64> = samples
            .chunks_exact(BLOCK)
            .map(|block| {
                let seen = block.iter().skip(first).step_by(interval);
                seen.map(|sample| sample[quantity]).sum::<f64>() * interval as f64 / BLOCK as f64
            })
            .collect();
        let mean = means.iter().sum::<f64>() / blocks as f64;
        let squares: f64 = means.iter().map(|m| (m - mean) * (m - mean)).sum();
        variance += squares / (blocks * (blocks - 1)) as f64 / interval as f64;
    }
    variance.sqrt()
}

/// What the figure is there to show, in numbers.
fn check(rows: &[Row]) -> Result<(), Problem> {
    let bought = |row: &Row, k: usize| row.errors[k] * row.cost.sqrt();
    for (k, quantity) in QUANTITIES.iter().enumerate() {
        let Some(best) = rows
            .iter()
            .min_by(|a, b| bought(a, k).total_cmp(&bought(b, k)))
        else {
            continue;
        };
        println!("{quantity}: best sampled every {} steps", best.interval);
        let loss = |row: &Row| bought(row, k) / bought(best, k) - 1.0;
        for row in rows {
            println!(
                "  every {:3} steps: error {:.2e}, {:+.0} % at equal CPU time",
                row.interval,
                row.errors[k],
                100.0 * loss(row)
            );
        }
        // The pressure forgets within some steps: rare samples throw most of a run away.
        if let (0, Some(rare)) = (k, rows.last())
            && loss(rare) < 0.5
        {
            return Err(format!(
                "sampling the {quantity} every {} steps loses only {} of its precision",
                rare.interval,
                loss(rare)
            )
            .into());
        }
    }
    Ok(())
}
