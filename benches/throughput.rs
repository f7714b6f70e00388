//! Particle-steps per second of whole workloads: one JSON line each.
//!
//! ```text
//! cargo run --release -p benches --bin throughput -- dpd --particles 24000 --threads 1
//! ```
//!
//! `dpd` is the Groot-Warren fluid at rest (density 3, a = 25, gamma = 4.5, kT = 1, dt = 0.04, lambda = 0.65). The
//! fluid runs 300 steps before the clock starts. `cpu_seconds` is the time of all threads together; the rate goes by
//! it when there is one thread and by `wall_seconds` otherwise.
#[allow(dead_code, clippy::expect_used)]
mod scene;

use clap::{Parser, ValueEnum};
use cpu_time::ProcessTime;
use std::{error::Error, time::Instant};
use zimm::prelude::*;

#[derive(Parser)]
struct Options {
    /// What to run.
    workload: Workload,
    /// About how many particles.
    #[arg(long, default_value_t = 24_000, value_parser = clap::value_parser!(u32).range(100..))]
    particles: u32,
    /// Threads.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    threads: u16,
    /// Steps that are timed.
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..))]
    steps: u32,
}

#[derive(Clone, Copy, ValueEnum)]
enum Workload {
    /// The Groot-Warren fluid.
    Dpd,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    rayon::ThreadPoolBuilder::new()
        .num_threads(options.threads.into())
        .build_global()?;
    match options.workload {
        Workload::Dpd => dpd(&options),
    }
}

fn dpd(options: &Options) -> Result<(), Box<dyn Error>> {
    let edge = (f64::from(options.particles) / scene::DENSITY).cbrt();
    let (mut system, mut field) = (scene::fluid(scene::cube(edge)), scene::field());
    let mut stepper = GrootWarren::new(0.65)?;
    for _ in 0..300 {
        stepper.step(&mut system, &mut field, &mut ())?;
    }
    let (mut temperature, mut pressure, mut samples) = (0.0, 0.0, 0);
    let (wall, cpu) = (Instant::now(), ProcessTime::now());
    for step in 1..=options.steps {
        if step % 10 == 0 || step == options.steps {
            let mut virial = Virial::default();
            stepper.step(&mut system, &mut field, &mut virial)?;
            let frame = system.frame();
            temperature += KineticTemperature::default().measure(&frame, &())?.mean();
            pressure += Stress.measure(&frame, &virial).pressure();
            samples += 1;
        } else {
            stepper.step(&mut system, &mut field, &mut ())?;
        }
    }
    let (cpu_seconds, wall_seconds) = (cpu.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64());
    let seconds = if options.threads == 1 {
        cpu_seconds
    } else {
        wall_seconds
    };
    let particles = system.particles.len();
    println!(
        "{}",
        serde_json::json!({
            "workload": "dpd",
            "particles": particles,
            "steps": options.steps,
            "threads": options.threads,
            "cpu_seconds": cpu_seconds,
            "wall_seconds": wall_seconds,
            "particle_steps_per_second": particles as f64 * f64::from(options.steps) / seconds,
            "temperature": temperature / f64::from(samples),
            "pressure": pressure / f64::from(samples),
        })
    );
    Ok(())
}
