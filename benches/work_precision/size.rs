//! CPU time and memory of a particle against the number of particles, 3 000 to a million: the fluid of Groot and Warren
//! at its usual step, on one thread. Larger cells are copies of an equilibrated one of 3 000 particles, which the
//! noise soon makes different.
//!
//! Memory is the largest resident set less that before the first cell was made, where the system tells.

use crate::chart::{Curve, Panel};
use crate::memory::peak_resident;
use crate::{Problem, Task, scene};
use cpu_time::ProcessTime;
use plotters::prelude::SeriesLabelPosition;
use zimm::prelude::*;

const EDGE: f64 = 10.0;

struct Row {
    particles: usize,
    /// CPU time for a particle and a step, in nanoseconds.
    cost: f64,
    /// Bytes for a particle.
    memory: Option<f64>,
}

pub(crate) fn figure(task: &Task) -> Result<(), Problem> {
    let (copies, work): (&[usize], _) = if task.quick {
        (&[1, 2, 3], 1_000_000)
    } else {
        (&[1, 2, 3, 4, 5, 6, 7], 12_000_000)
    };
    let before = peak_resident();
    let (small, _) = scene::equilibrated(scene::cube(EDGE));
    let mut rows = Vec::new();
    for &copies in copies {
        let mut system = enlarged(&small, copies)?;
        let particles = system.particles.len();
        let (mut field, mut stepper) = (scene::field(), GrootWarren::new(0.65)?);
        for _ in 0..10 {
            stepper.step(&mut system, &mut field, &mut ())?;
        }
        let steps = (work / particles).max(10);
        let start = ProcessTime::now();
        for _ in 0..steps {
            stepper.step(&mut system, &mut field, &mut ())?;
        }
        let particle_steps = (particles * steps) as f64;
        let grown = before.and_then(|before| Some(peak_resident()?.saturating_sub(before)));
        // An earlier figure may have held more.
        let grown = grown.filter(|bytes| *bytes > 0);
        rows.push(Row {
            particles,
            cost: 1e9 * start.elapsed().as_secs_f64() / particle_steps,
            memory: grown.map(|bytes| bytes as f64 / particles as f64),
        });
    }
    task.csv(
        "particles,cpu_nanoseconds,bytes",
        rows.iter().map(|row| {
            let memory = row
                .memory
                .map_or_else(String::new, |bytes| format!("{bytes:.0}"));
            format!("{},{:.1},{memory}", row.particles, row.cost)
        }),
    )?;
    let panel = |title, y, points: Vec<(f64, f64)>| Panel {
        title,
        x: "particles",
        y,
        legend: SeriesLabelPosition::UpperRight,
        curves: vec![Curve {
            label: String::new(),
            colour: 0,
            filled: true,
            points,
        }],
    };
    let points = |pick: fn(&Row) -> Option<f64>| {
        let points = rows
            .iter()
            .map(|row| Some((row.particles as f64, pick(row)?)));
        points.flatten().collect()
    };
    task.draw(&[
        panel(
            "CPU time of a step",
            "ns / particle",
            points(|row| Some(row.cost)),
        ),
        panel("Memory", "bytes / particle", points(|row| row.memory)),
    ])?;
    let costs = rows.iter().map(|row| row.cost);
    let (least, most) = costs.fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
    println!("a particle and step take {least:.0} to {most:.0} ns");
    // Linear, but for what leaves the caches.
    if most > 2.5 * least {
        return Err(format!("the time of a particle varies from {least} to {most} ns").into());
    }
    Ok(())
}

/// A cube of as many copies along each axis.
fn enlarged(small: &System<PeriodicBox>, copies: usize) -> Result<System<PeriodicBox>, Problem> {
    let shifts = || (0..copies).map(|k| k as f64 * EDGE);
    let (mut positions, mut velocities) = (Vec::new(), Vec::new());
    for x in shifts() {
        for y in shifts() {
            for z in shifts() {
                let shift = DVec3::new(x, y, z);
                positions.extend(small.particles.positions().iter().map(|&r| r + shift));
                velocities.extend_from_slice(small.particles.velocities());
            }
        }
    }
    let particles = Particles::new(positions)?.with_velocities(velocities)?;
    let space = scene::cube(EDGE * copies as f64);
    Ok(System::new(space, particles, Clock::new(0.04, 1.0, 1)?))
}
