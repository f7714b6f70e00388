//! Particle-steps per second of whole workloads: one JSON line each.
//!
//! ```text
//! cargo run --release -p benches --bin throughput -- dpd --particles 24000 --threads 1
//! ```
//!
//! | workload | state |
//! | --- | --- |
//! | `dpd` | the Groot-Warren fluid at rest: density 3, a = 25, gamma = 4.5, dt = 0.04 |
//! | `fene_shear` | the same with 10 % of the beads in FENE chains of 5 (H = 20, Q_0 = 2), sheared at 0.2, dt = 0.02 |
//! | `srp` | melt of chains of 20 (density 3, a = 60, gamma = 4.5; springs of 450, length 0.85), repulsion of springs of 100 (1 - D / 0.8), dt = 0.01 |
//! | `fedosov` | melt of FENE chains of 5 (H = 50, Q_0 = 1) at density 3, a = 25, gamma = 4.5, r_c = 2, weight x^1/2, reverse Poiseuille flow of 0.25, dt = 0.005 |
//! | `wca_cubic` | WCA beads at density 0.8442, kT = 0.722, dt = 0.005, in Langevin's bath of rate 1 |
//! | `wca_extension` | the same in planar extension at 0.1, in the cell of Kraynik and Reinelt; the bath is colder by what the flow heats |
//! | `bd_mesh` | theta chains of 10 beads (FENE, b = 50, h* = 0.25) at c/c* = 1, hydrodynamic interactions at 1e-3: mesh, split noise, semi-implicit steps of 0.05 |
//! | `bd_dumbbells` | free-draining FENE dumbbells, b = 50, in planar extension at a rate of 1, semi-implicit steps of 0.01 |
//!
//! `dpd` runs with lambda = 0.65, the others of DPD with 1/2. Scenes with inertia run some hundred steps before the clock starts, and every tenth step is measured. `cpu_seconds` is
//! the time of all threads together; the rate goes by it when there is one thread and by `wall_seconds` otherwise.
//! `bytes_per_particle` is the largest resident set less that before the scene was made, where the system tells.
#[allow(dead_code, clippy::expect_used)]
mod scene;

mod memory;
mod states;

use clap::{Parser, ValueEnum};
use cpu_time::ProcessTime;
use memory::peak_resident;
use std::{error::Error, time::Instant};
use zimm::prelude::*;

type Problem = Box<dyn Error + Send + Sync>;

#[derive(Parser)]
struct Options {
    /// What to run.
    workload: Workload,
    /// About how many particles; the workload's own number if not given.
    #[arg(long, value_parser = clap::value_parser!(u32).range(100..))]
    particles: Option<u32>,
    /// Threads.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    threads: u16,
    /// Steps that are timed.
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..))]
    steps: u32,
    /// Skin of the Verlet list; the workload's own if not given.
    #[arg(long)]
    skin: Option<f64>,
}

#[derive(Clone, Copy, ValueEnum)]
#[value(rename_all = "snake_case")]
enum Workload {
    /// The Groot-Warren fluid.
    Dpd,
    /// The same with FENE chains, sheared.
    FeneShear,
    /// A melt of chains whose springs repel each other.
    Srp,
    /// A melt of short chains with a long range, in reverse Poiseuille flow.
    Fedosov,
    /// Hard beads at rest.
    WcaCubic,
    /// Hard beads in planar extension.
    WcaExtension,
    /// Chains with hydrodynamic interactions on a mesh.
    BdMesh,
    /// Free-draining dumbbells in extension.
    BdDumbbells,
}

fn main() -> Result<(), Problem> {
    let options = Options::parse();
    // Inside the pool: work that comes from outside is handed over at every turn.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(options.threads.into());
    pool.build()?.install(|| match options.workload {
        Workload::Dpd => dpd(&options),
        Workload::FeneShear => fene_shear(&options),
        Workload::Srp => srp(&options),
        Workload::Fedosov => fedosov(&options),
        Workload::WcaCubic => wca_cubic(&options),
        Workload::WcaExtension => wca_extension(&options),
        Workload::BdMesh => bd_mesh(&options),
        Workload::BdDumbbells => bd_dumbbells(&options),
    })
}

fn dpd(options: &Options) -> Result<(), Problem> {
    let meter = Meter::new(options, "dpd");
    let edge = (options.particles(24_000) / scene::DENSITY).cbrt();
    let system = scene::fluid(scene::cube(edge));
    let law = Dpd::new(25.0, 4.5)?;
    let field = Pairwise::new(law, options.list(scene::SKIN)?);
    meter.run(system, field, GrootWarren::new(0.65)?, &[(300, 0.04)])
}

fn fene_shear(options: &Options) -> Result<(), Problem> {
    let meter = Meter::new(options, "fene_shear");
    let (system, chains) = states::fene_shear(options.particles(24_000))?;
    let field = (
        Pairwise::new(Dpd::new(25.0, 4.5)?, options.list(0.45)?),
        Bonded::new(Fene::new(20.0, 2.0)?, chains.bonds()),
    );
    let before = [(200, 0.01), (500, 0.02)];
    meter.run(system, field, GrootWarren::new(0.5)?, &before)
}

fn srp(options: &Options) -> Result<(), Problem> {
    const BEADS: u32 = 20;
    let meter = Meter::new(options, "srp");
    let chains = Molecules::linear(0, options.particles(24_000) as u32 / BEADS, BEADS)?;
    let edge = (f64::from(chains.count() * BEADS) / 3.0).cbrt();
    let mut system = states::start(PeriodicBox::cubic(edge)?, &chains, 0.85, 0)?;
    // 3 a = 100 at contact, a range of 3 times 0.8.
    let law = PanManke::new(100.0 / 3.0, 2.4)?;
    let mut field = (
        Pairwise::new(Dpd::new(60.0, 4.5)?, options.list(0.25)?),
        Bonded::new(Fraenkel::new(450.0, 0.85)?, chains.bonds()),
        SegmentRepulsion::new(law, chains.bonds(), options.list(0.15)?),
    );
    // Chains grown through each other set free more heat than DPD's bath takes up.
    let mut bath = Langevin::new(10.0)?;
    system.clock.set_dt(0.005)?;
    for _ in 0..500 {
        bath.step(&mut system, &mut field, &mut ())?;
    }
    meter.run(system, field, GrootWarren::new(0.5)?, &[(300, 0.01)])
}

fn fedosov(options: &Options) -> Result<(), Problem> {
    let meter = Meter::new(options, "fedosov");
    let (system, chains) = states::fedosov(options.particles(30_000))?;
    let law = Dpd::new(25.0, 4.5)?
        .with_cutoff(2.0)?
        .with_weight(SquareRoot);
    let field = (
        Pairwise::new(law, options.list(0.25)?),
        Bonded::new(Fene::new(50.0, 1.0)?, chains.bonds()),
        ReversePoiseuille::new(0.25, 0, 1)?,
    );
    let before = [(200, 0.002), (300, 0.005)];
    meter.run(system, field, GrootWarren::new(0.5)?, &before)
}

/// Density and temperature of the fluid of hard beads.
const HARD: (f64, f64) = (0.8442, 0.722);

fn wca_cubic(options: &Options) -> Result<(), Problem> {
    let meter = Meter::new(options, "wca_cubic");
    let edge = (options.particles(4_000) / HARD.0).cbrt();
    wca(meter, PeriodicBox::cubic(edge)?, HARD.1)
}

fn wca_extension(options: &Options) -> Result<(), Problem> {
    let meter = Meter::new(options, "wca_extension");
    let edge = (options.particles(4_000) / HARD.0).cbrt();
    // 4 eta rate^2 / 3 density, with eta = 2.2, is what a bath of rate 1 lags behind.
    let space = KraynikReinelt::new(edge, edge, Steady::new(0.1)?)?;
    wca(meter, space, HARD.1 - 0.035)
}

fn wca<B: Periodic>(meter: Meter<'_>, space: B, kt: f64) -> Result<(), Problem> {
    let count = (HARD.0 * space.lattice().volume()).round() as usize;
    let positions = start::grid(space.lattice(), count);
    let system = states::moving(space, positions, kt)?;
    let field = Pairwise::new(Wca::new(1.0, 1.0)?, meter.options.list(0.3)?);
    meter.run(system, field, Langevin::new(1.0)?, &[(1000, 0.005)])
}

impl Options {
    fn particles(&self, own: u32) -> f64 {
        f64::from(self.particles.unwrap_or(own))
    }

    fn list(&self, own: f64) -> Result<VerletList, ParameterError> {
        VerletList::new(self.skin.unwrap_or(own))
    }
}

/// Times one workload, beginning before its scene is made.
struct Meter<'a> {
    options: &'a Options,
    workload: &'static str,
    resident: Option<u64>,
}

impl<'a> Meter<'a> {
    fn new(options: &'a Options, workload: &'static str) -> Self {
        Self {
            options,
            workload,
            resident: peak_resident(),
        }
    }

    /// Runs the steps `before`, each so many of one length, and then those that count.
    fn run<B: Periodic, F: ForceField<B>>(
        &self,
        mut system: System<B>,
        mut field: F,
        mut stepper: impl Stepper<B, F>,
        before: &[(u32, f64)],
    ) -> Result<(), Problem> {
        for &(steps, dt) in before {
            system.clock.set_dt(dt)?;
            for _ in 0..steps {
                stepper.step(&mut system, &mut field, &mut ())?;
            }
        }
        let (mut temperature, mut stress, mut samples) = (DVec3::ZERO, DMat3::ZERO, 0.0);
        let (wall, cpu) = (Instant::now(), ProcessTime::now());
        for step in 1..=self.options.steps {
            if step % 10 == 0 || step == self.options.steps {
                let mut virial = Virial::default();
                stepper.step(&mut system, &mut field, &mut virial)?;
                let frame = system.frame();
                temperature += KineticTemperature::default().measure(&frame, &())?.axes;
                stress += Stress.measure(&frame, &virial).total();
                samples += 1.0;
            } else {
                stepper.step(&mut system, &mut field, &mut ())?;
            }
        }
        let seconds = [cpu.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64()];
        let (temperature, stress) = (temperature / samples, stress * (1.0 / samples));
        let [x, y, z] = [stress.x_axis.x, stress.y_axis.y, stress.z_axis.z];
        let measured = serde_json::json!({
            "temperature": temperature.element_sum() / 3.0,
            "temperature_z": temperature.z,
            "pressure": -(x + y + z) / 3.0,
            "shear_stress": stress.y_axis.x,
            "normal_stress_difference": x - y,
        });
        self.print(system.particles.len(), seconds, measured);
        Ok(())
    }

    /// One line: how long it took, and what was measured.
    fn print(&self, particles: usize, [cpu, wall]: [f64; 2], mut measured: serde_json::Value) {
        let Options { steps, threads, .. } = self.options;
        let seconds = if *threads == 1 { cpu } else { wall };
        let bytes = self.resident.and_then(|before| {
            let grown = peak_resident()?.saturating_sub(before);
            Some((grown as f64 / particles as f64).round())
        });
        let mut line = serde_json::json!({
            "workload": self.workload,
            "particles": particles,
            "steps": steps,
            "threads": threads,
            "cpu_seconds": cpu,
            "wall_seconds": wall,
            "particle_steps_per_second": particles as f64 * f64::from(*steps) / seconds,
            "bytes_per_particle": bytes,
        });
        if let (Some(line), Some(measured)) = (line.as_object_mut(), measured.as_object_mut()) {
            line.append(measured);
        }
        println!("{line}");
    }
}

const EXTENSIBILITY: f64 = 50.0;

fn bd_mesh(options: &Options) -> Result<(), Problem> {
    const TOLERANCE: f64 = 1e-3;
    let meter = Meter::new(options, "bd_mesh");
    let chains = Molecules::linear(0, options.particles(24_000) as u32 / 10, 10)?;
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
    meter.brownian(system, Bonded::new(spring, chains.bonds()), stepper)
}

fn bd_dumbbells(options: &Options) -> Result<(), Problem> {
    let meter = Meter::new(options, "bd_dumbbells");
    let dumbbells = Molecules::linear(0, options.particles(24_000) as u32 / 2, 2)?;
    let spring = Fene::new(1.0, EXTENSIBILITY.sqrt())?;
    let bond = start::BondLength::new(&spring, 1.0)?;
    let mut rng = start::stream(1);
    let positions = start::isolated(&dumbbells, |rng| bond.sample(rng), &mut rng);
    let space = OpenFlow::new(DMat3::from_diagonal(DVec3::new(1.0, -1.0, 0.0)))?;
    let system = System::new(space, Particles::new(positions)?, Clock::new(0.01, 1.0, 1)?);
    let stepper = SemiImplicit::new(FreeDraining::new(4.0)?, Diagonal);
    meter.brownian(system, Bonded::new(spring, dumbbells.bonds()), stepper)
}

impl Meter<'_> {
    /// Steps of bead-spring chains; the line tells the mean square length of springs at the end.
    fn brownian<B: Boundary>(
        &self,
        mut system: System<B>,
        mut springs: Bonded<Fene>,
        mut stepper: impl Stepper<B, Bonded<Fene>>,
    ) -> Result<(), Problem> {
        for _ in 0..5 {
            stepper.step(&mut system, &mut springs, &mut ())?;
        }
        let (wall, cpu) = (Instant::now(), ProcessTime::now());
        for _ in 0..self.options.steps {
            stepper.step(&mut system, &mut springs, &mut ())?;
        }
        let seconds = [cpu.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64()];
        let positions = system.particles.positions();
        let squares = springs.bonds().iter().map(|&[i, j]| {
            let r = positions[j as usize] - positions[i as usize];
            system.boundary.min_image(r).length_squared()
        });
        let square = squares.sum::<f64>() / springs.bonds().len() as f64;
        let measured = serde_json::json!({ "spring_squared": square });
        self.print(system.particles.len(), seconds, measured);
        Ok(())
    }
}
