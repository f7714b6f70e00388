//! Particle-steps per second of whole workloads: one JSON line each.
//!
//! ```text
//! cargo run --release -p benches --bin throughput -- dpd --particles 24000 --threads 1
//! ```
//!
//! `dpd` is the Groot-Warren fluid at rest (density 3, a = 25, gamma = 4.5, kT = 1, dt = 0.04, lambda = 0.65). The
//! fluid runs 300 steps before the clock starts. `cpu_seconds` is the time of all threads together; the rate goes by
//! it when there is one thread and by `wall_seconds` otherwise.
//!
//! `bd_mesh` are theta chains of 10 beads (FENE, b = 50, h* = 0.25) at c/c* = 1 with hydrodynamic interactions at 1e-3:
//! mesh, split noise, semi-implicit steps of 0.05. `bd_dumbbells` are free-draining FENE dumbbells, b = 50, in planar
//! extension at a rate of 1, semi-implicit steps of 0.01.
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
    /// Chains with hydrodynamic interactions on a mesh.
    #[value(name = "bd_mesh")]
    BdMesh,
    /// Free-draining dumbbells in extension.
    #[value(name = "bd_dumbbells")]
    BdDumbbells,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    rayon::ThreadPoolBuilder::new()
        .num_threads(options.threads.into())
        .build_global()?;
    match options.workload {
        Workload::Dpd => dpd(&options),
        Workload::BdMesh => bd_mesh(&options),
        Workload::BdDumbbells => bd_dumbbells(&options),
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

const EXTENSIBILITY: f64 = 50.0;

fn bd_mesh(options: &Options) -> Result<(), Box<dyn Error>> {
    const TOLERANCE: f64 = 1e-3;
    let chains = Molecules::linear(0, options.particles / 10, 10)?;
    let beads = chains.identities().len();
    let spring = Fene::new(1.0, EXTENSIBILITY.sqrt())?;
    // R_g^2 of ideal chains.
    let gyration = (99.0 / 60.0 * 3.0 * EXTENSIBILITY / (EXTENSIBILITY + 5.0)).sqrt();
    let space = PeriodicBox::cubic(cell_edge(beads, overlap_concentration(10, gyration)?)?)?;
    let bond = start::BondLength::new(&spring, 1.0)?;
    let mut rng = start::stream(1);
    let positions = start::chains(space.lattice(), &chains, |rng| bond.sample(rng), &mut rng);
    let system = System::new(space, Particles::new(positions)?, Clock::new(0.05, 1.0, 1)?);
    let mobility = Mesh::new(4.0, 0.25 * std::f64::consts::PI.sqrt(), TOLERANCE)?;
    let stepper = SemiImplicit::new(mobility, SplitNoise::new(TOLERANCE)?);
    brownian(
        "bd_mesh",
        options,
        system,
        Bonded::new(spring, chains.bonds()),
        stepper,
    )
}

fn bd_dumbbells(options: &Options) -> Result<(), Box<dyn Error>> {
    let dumbbells = Molecules::linear(0, options.particles / 2, 2)?;
    let spring = Fene::new(1.0, EXTENSIBILITY.sqrt())?;
    let bond = start::BondLength::new(&spring, 1.0)?;
    let mut rng = start::stream(1);
    let positions = start::isolated(&dumbbells, |rng| bond.sample(rng), &mut rng);
    let space = OpenFlow::new(DMat3::from_diagonal(DVec3::new(1.0, -1.0, 0.0)))?;
    let system = System::new(space, Particles::new(positions)?, Clock::new(0.01, 1.0, 1)?);
    let stepper = SemiImplicit::new(FreeDraining::new(4.0)?, Diagonal);
    brownian(
        "bd_dumbbells",
        options,
        system,
        Bonded::new(spring, dumbbells.bonds()),
        stepper,
    )
}

/// Steps of bead-spring chains; the line also tells the mean square length of springs at the end.
fn brownian<B: Boundary>(
    workload: &str,
    options: &Options,
    mut system: System<B>,
    mut springs: Bonded<Fene>,
    mut stepper: impl Stepper<B, Bonded<Fene>>,
) -> Result<(), Box<dyn Error>> {
    for _ in 0..5 {
        stepper.step(&mut system, &mut springs, &mut ())?;
    }
    let (wall, cpu) = (Instant::now(), ProcessTime::now());
    for _ in 0..options.steps {
        stepper.step(&mut system, &mut springs, &mut ())?;
    }
    let (cpu_seconds, wall_seconds) = (cpu.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64());
    let seconds = if options.threads == 1 {
        cpu_seconds
    } else {
        wall_seconds
    };
    let (particles, positions) = (system.particles.len(), system.particles.positions());
    let squares = springs.bonds().iter().map(|&[i, j]| {
        let r = positions[j as usize] - positions[i as usize];
        system.boundary.min_image(r).length_squared()
    });
    println!(
        "{}",
        serde_json::json!({
            "workload": workload,
            "particles": particles,
            "steps": options.steps,
            "threads": options.threads,
            "cpu_seconds": cpu_seconds,
            "wall_seconds": wall_seconds,
            "particle_steps_per_second": particles as f64 * f64::from(options.steps) / seconds,
            "spring_squared": squares.sum::<f64>() / springs.bonds().len() as f64,
        })
    );
    Ok(())
}
