//! Structure and diffusion of a fluid at rest from its trajectory alone.
//!
//! ```text
//! cargo run --release --example after_the_fact                     a DPD fluid, written first: seconds
//! cargo run --release --example after_the_fact -- FILE.xyz         what a run has written, with images counted
//! ```
//!
//! The file streams: one frame is in memory at a time. What is not known before it is read, the cell and the interval
//! of time between frames, is taken from its head.

use clap::Parser;
use std::error::Error;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use zimm::prelude::*;

/// Measures g(r) and the diffusivity of a trajectory.
#[derive(Debug, Parser)]
struct Options {
    /// An extended XYZ file of zimm; a fluid is run and written to target/after_the_fact.xyz if none is given.
    file: Option<PathBuf>,
    /// Range of g(r).
    #[arg(long, default_value_t = 2.0)]
    range: f64,
    /// Bins of g(r).
    #[arg(long, default_value_t = 20)]
    bins: usize,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    let path = match options.file {
        Some(file) => file,
        None => {
            fs::create_dir_all("target")?;
            let path = PathBuf::from("target/after_the_fact.xyz");
            write_fluid(&path)?;
            path
        }
    };
    let frames = || File::open(&path).map(|file| XyzReader::new(BufReader::new(file)));
    let head: Vec<Snapshot> = frames()?.take(2).collect::<Result<_, _>>()?;
    let [first, second] = &head[..] else {
        return Err(format!("{} has fewer than two frames", path.display()).into());
    };
    let cell = first.cell.ok_or("g(r) needs a cell")?;
    let space = PeriodicBox::triclinic(cell)?;

    let mut g = RadialDistribution::new(options.range, options.bins, VerletList::new(0.0)?)?;
    let mut structure = BlockAverages::new(g.bins());
    let interval = second.now.time - first.now.time;
    let mut displacement = MeanSquareDisplacement::new(interval, 4..=16)?;
    for snapshot in frames()? {
        let system = snapshot?.into_system(space)?;
        structure.push(g.measure(&system.frame(), &())?);
        displacement.push(Unwrapped.measure(&system.frame(), &())?);
    }
    println!("   r     g(r)");
    for (r, g) in g.radii().zip(structure.estimate()?) {
        println!("{r:.3}   {g:#}");
    }
    let diffusion = displacement.estimate()?;
    println!("D = {:#}, {path:?}", diffusion.coefficient);
    Ok(())
}

/// The fluid of Groot and Warren (1997), a = 25, sigma = 3 at a density of 3.
fn write_fluid(path: &Path) -> Result<(), Box<dyn Error>> {
    let space = PeriodicBox::cubic(6.0)?;
    let mut rng = start::stream(1);
    let positions = start::uniform(space.lattice(), 648, &mut rng);
    let particles = Particles::new(positions)?;
    let velocities = start::velocities(&particles, 1.0, &mut rng)?;
    let particles = particles.with_velocities(velocities)?.counting_images();
    let mut system = System::new(space, particles, Clock::new(0.04, 1.0, 1)?);
    let mut field = Pairwise::new(Dpd::new(25.0, 4.5)?, VerletList::new(0.35)?);
    let mut stepper = GrootWarren::new(0.65)?;
    let mut trajectory = XyzWriter::new(File::create(path)?);
    for step in 1..=3000 {
        stepper.step(&mut system, &mut field, &mut ())?;
        if step > 200 && step % 5 == 0 {
            trajectory.write(&system.frame())?;
        }
    }
    Ok(())
}
