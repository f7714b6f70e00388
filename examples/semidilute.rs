//! A semidilute polymer solution that starts to flow, with hydrodynamic interactions: bead-spring chains near their
//! overlap concentration in planar mixed flow.
//!
//! ```text
//! cargo run --release --example semidilute                       150 chains of 10 beads at c/c* = 1, minutes
//! cargo run --release --example semidilute -- --quick            a minute
//! cargo run --release --example semidilute -- --help             all options
//! ```
//!
//! Chains of FENE springs, b = 50, at rest in equilibrium, are carried from time zero by u = (e x + g y, -e y, 0), whose
//! strain rate G and mixedness chi are given: e = G sqrt(chi), g = G (1 - chi). Every bead moves every other through the
//! solvent, by Rotne-Prager-Yamakawa mobilities summed over all images of the deforming cell on a mesh, and so does the
//! noise. Units are kT, l_H = sqrt(kT / H) and lambda_H = zeta / 4H.
//!
//! An interrupted run goes on with `--resume`, to the same bits. `--trajectory FILE.xyz` writes the chains at every
//! sample, for OVITO, ASE and [`XyzReader`]. The picture shows Hounkonnou's viscosity and the mean
//! square end-to-end distance against strain, and the chains as they are at the end, in the plane of the flow.

use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};
use plotters::prelude::*;
use std::error::Error;
use std::f64::consts::PI;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use zimm::prelude::*;

/// What went wrong, in one sentence.
type Problem = Box<dyn Error + Send + Sync>;

const KT: f64 = 1.0;
const FRICTION: f64 = 4.0;
const EXTENSIBILITY: f64 = 50.0;
const SAMPLES: u64 = 200;
const STEPS_PER_CHECKPOINT: u64 = 100;

/// Starts the flow of a semidilute solution.
#[derive(Debug, Parser)]
struct Options {
    /// Concentration over the overlap concentration of ideal chains.
    #[arg(long, default_value_t = 1.0)]
    concentration: f64,
    /// Chains in the cell.
    #[arg(long, default_value_t = 150)]
    chains: u32,
    /// Beads of a chain.
    #[arg(long, default_value_t = 10)]
    beads: u32,
    /// Strain rate G, in 1 / lambda_H.
    #[arg(long, default_value_t = 0.2)]
    rate: f64,
    /// Mixedness chi, from 1e-3, nearly shear, to 1, extension.
    #[arg(long, default_value_t = 0.2)]
    mixedness: f64,
    /// Hydrodynamic interaction parameter h*; beads have the radius sqrt(pi) h*.
    #[arg(long, default_value_t = 0.25)]
    hstar: f64,
    /// Relative error of mobilities and noise.
    #[arg(long, default_value_t = 1e-3)]
    tolerance: f64,
    /// Strain G t at the end.
    #[arg(long, default_value_t = 20.0)]
    strain: f64,
    /// Time step.
    #[arg(long, default_value_t = 0.05)]
    dt: f64,
    /// Seed; the same seed gives the same bits on any number of threads.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// A strain of 2.
    #[arg(long)]
    quick: bool,
    /// Directory for semidilute.csv, semidilute.svg and the checkpoint.
    #[arg(long, default_value = "target/semidilute")]
    out: PathBuf,
    /// Goes on from the checkpoint.
    #[arg(long)]
    resume: bool,
    /// Extended XYZ file for the chains at every sample.
    #[arg(long)]
    trajectory: Option<PathBuf>,
}

/// One moment: strain, viscosity, mean square end-to-end distance.
type Sample = [f64; 3];
type Space = PlanarMixed<Steady>;

fn main() -> Result<(), Problem> {
    // Inside a pool: from outside, every part of a step would be handed over to it anew.
    rayon::ThreadPoolBuilder::new().build()?.install(run)
}

fn run() -> Result<(), Problem> {
    let options = Options::parse();
    fs::create_dir_all(&options.out)?;
    let (chains, space) = (chains(&options)?, space(&options)?);
    let radius = PI.sqrt() * options.hstar;
    let mobility = Mesh::new(FRICTION, radius, options.tolerance)?;
    let mut stepper = SemiImplicit::new(mobility, SplitNoise::new(options.tolerance)?);
    let spring = Fene::new(1.0, EXTENSIBILITY.sqrt())?;
    let mut forces = Bonded::new(spring, chains.bonds());

    let [table, checkpoint] =
        ["csv", "checkpoint"].map(|kind| options.out.join(format!("semidilute.{kind}")));
    let (mut system, mut samples) = if options.resume && checkpoint.exists() {
        let system = load_file(space, &checkpoint)?;
        let samples = read(&table, options.rate * system.clock.now().time)?;
        (system, samples)
    } else {
        (at_rest(&options, space, &chains, &spring)?, Vec::new())
    };

    let mut trajectory = match &options.trajectory {
        Some(path) => Some(trajectory(path, &chains, system.clock.now().step)?),
        None => None,
    };

    let strain = if options.quick { 2.0 } else { options.strain };
    let last = (strain / options.rate / options.dt).ceil() as u64;
    let between = last.div_ceil(SAMPLES);
    let bar = ProgressBar::new(last);
    let style =
        ProgressStyle::with_template("flowing [{bar:40}] {percent:>3} %, {eta} left, {msg}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let (mut kramers, mut ends) = (
        ChainStress { molecules: chains },
        EndToEnd { molecules: chains },
    );
    while system.clock.now().step < last {
        let mut virial = Virial::default();
        stepper.step(&mut system, &mut forces, &mut virial)?;
        let (frame, step) = (system.frame(), system.clock.now().step);
        if step.is_multiple_of(between) {
            let stress = kramers.measure(&frame, &virial)? * (1.0 / KT);
            let viscosity = hounkonnou(system.boundary.gradient(), stress);
            let ends = ends.measure(&frame, &())?;
            let square = ends.iter().map(|r| r.length_squared()).sum::<f64>() / ends.len() as f64;
            samples.push([options.rate * frame.now.time, viscosity, square]);
            bar.set_message(format!("eta {viscosity:.2}, R_e^2 {square:.1}"));
            if let Some((writer, written)) = &mut trajectory
                && step > *written
            {
                writer.write(&frame)?;
            }
        }
        if step.is_multiple_of(STEPS_PER_CHECKPOINT) || step == last {
            write(&table, &samples)?;
            save_file(&system, &mut forces, &checkpoint)?;
        }
        bar.set_position(step);
    }
    bar.finish_and_clear();
    let picture = options.out.join("semidilute.svg");
    draw(&picture, &options, &samples, &system, &chains)?;
    println!(
        "{} beads; written: {}, {}",
        system.particles.len(),
        table.display(),
        picture.display()
    );
    Ok(())
}

fn chains(options: &Options) -> Result<Molecules, ParameterError> {
    Molecules::linear(0, options.chains, options.beads)
}

/// A cell of the flow that holds the chains at their concentration.
fn space(options: &Options) -> Result<Space, Problem> {
    let n = f64::from(options.beads);
    let bond = 3.0 * EXTENSIBILITY / (EXTENSIBILITY + 5.0);
    let radius = ((n * n - 1.0) / (6.0 * n) * bond).sqrt();
    let beads = chains(options)?.identities().len();
    let density = options.concentration * overlap_concentration(options.beads as usize, radius)?;
    let edge = cell_edge(beads, density)?;
    let history = Steady::new(options.rate)?;
    let space = PlanarMixed::new(edge, edge, options.mixedness, history)?;
    let (reach, limit) = (0.5 * space.min_image_distance(), EXTENSIBILITY.sqrt());
    if reach < limit {
        let why = "springs may meet their images: take more chains or a lower concentration";
        return Err(format!(
            "half the distance of images is {reach:.2}, springs reach {limit:.2}; {why}"
        )
        .into());
    }
    Ok(space)
}

fn at_rest(
    options: &Options,
    space: Space,
    chains: &Molecules,
    spring: &Fene,
) -> Result<System<Space>, Problem> {
    let bond = start::BondLength::new(spring, KT)?;
    let mut rng = start::stream(options.seed);
    let positions = start::chains(space.lattice(), chains, |rng| bond.sample(rng), &mut rng);
    let particles = Particles::new(positions)?;
    Ok(System::new(
        space,
        particles,
        Clock::new(options.dt, KT, options.seed)?,
    ))
}

/// A trajectory, and the last step that it has. A run that goes on makes the same frames again from its checkpoint up to
/// where it was interrupted; these are not written twice.
fn trajectory(
    path: &Path,
    chains: &Molecules,
    step: u64,
) -> Result<(XyzWriter<File>, u64), Problem> {
    let mut written = 0;
    let file = if step > 0 && path.exists() {
        for snapshot in XyzReader::new(BufReader::new(File::open(path)?)) {
            written = snapshot?.now.step;
        }
        File::options().append(true).open(path)?
    } else {
        File::create(path)?
    };
    Ok((XyzWriter::new(file).with_molecules([*chains]), written))
}

/// sigma : A / (A : A), A = kappa + kappa^T.
fn hounkonnou(gradient: DMat3, stress: DMat3) -> f64 {
    let rate = gradient + gradient.transpose();
    let contract = |a: DMat3| {
        [0, 1, 2]
            .map(|k| a.col(k).dot(rate.col(k)))
            .iter()
            .sum::<f64>()
    };
    contract(stress) / contract(rate)
}

fn write(path: &Path, samples: &[Sample]) -> Result<(), Problem> {
    let mut text = String::from("strain,viscosity,end_to_end_squared\n");
    for [strain, viscosity, square] in samples {
        text += &format!("{strain},{viscosity},{square}\n");
    }
    Ok(fs::write(path, text)?)
}

/// The samples up to a strain.
fn read(path: &Path, strain: f64) -> Result<Vec<Sample>, Problem> {
    let sample = |line: &str| -> Option<Sample> {
        let numbers: Vec<f64> = line
            .split(',')
            .map(str::parse)
            .collect::<Result<_, _>>()
            .ok()?;
        numbers.try_into().ok()
    };
    let damaged = |line: &str| format!("{}: cannot read {line}", path.display());
    let mut samples = Vec::new();
    for line in fs::read_to_string(path)?.lines().skip(1) {
        let sample = sample(line).ok_or_else(|| damaged(line))?;
        if sample[0] <= strain {
            samples.push(sample);
        }
    }
    Ok(samples)
}

/// Both quantities against strain, and the chains seen along the neutral axis.
fn draw(
    path: &Path,
    options: &Options,
    samples: &[Sample],
    system: &System<Space>,
    chains: &Molecules,
) -> Result<(), Problem> {
    let root = SVGBackend::new(path, (1200, 420)).into_drawing_area();
    root.fill(&WHITE)?;
    let areas = root.split_evenly((1, 3));
    let colour = RGBColor(0, 90, 170);
    let end = samples.last().map_or(1.0, |sample| sample[0]);
    let titles = ["Viscosity over n kT λ_H", "<R_e²> over l_H²"];
    for (k, (area, title)) in areas.iter().zip(titles).enumerate() {
        let values = || samples.iter().map(|sample| sample[k + 1]);
        let (low, high) = values().fold((0.0_f64, 0.0_f64), |(a, b), y| (a.min(y), b.max(y)));
        let mut chart = ChartBuilder::on(area)
            .caption(title, ("sans-serif", 17))
            .margin(12)
            .x_label_area_size(42)
            .y_label_area_size(56)
            .build_cartesian_2d(0.0..end, low..1.1 * high + 1e-9)?;
        let mesh = &mut chart.configure_mesh();
        mesh.x_desc("strain").light_line_style(WHITE).draw()?;
        let points = samples.iter().map(|sample| (sample[0], sample[k + 1]));
        chart.draw_series(LineSeries::new(points, colour.stroke_width(1)))?;
    }
    let title = format!("chains at the end, c/c* = {}", options.concentration);
    let basis = system.boundary.lattice().basis();
    let corners = [
        (-0.5, -0.5),
        (0.5, -0.5),
        (0.5, 0.5),
        (-0.5, 0.5),
        (-0.5, -0.5),
    ];
    let outline = corners.map(|(a, b)| basis.x_axis * a + basis.y_axis * b);
    let walks: Vec<Vec<DVec3>> = chains.iter().map(|beads| walk(system, beads)).collect();
    let points = || outline.iter().chain(walks.iter().flatten());
    let reach =
        |part: fn(&DVec3) -> f64| 1.05 * points().map(|r| part(r).abs()).fold(0.0, f64::max);
    let (x, y) = (reach(|r| r.x), reach(|r| r.y));
    let mut chart = ChartBuilder::on(&areas[2])
        .caption(title, ("sans-serif", 17))
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(42)
        .build_cartesian_2d(-x..x, -y..y)?;
    let mesh = &mut chart.configure_mesh();
    mesh.x_desc("x / l_H").disable_mesh().draw()?;
    for (number, walk) in walks.iter().enumerate() {
        let shade = HSLColor(number as f64 / walks.len() as f64, 0.7, 0.42);
        let points = walk.iter().map(|r| (r.x, r.y));
        chart.draw_series(LineSeries::new(points.clone(), shade.stroke_width(1)))?;
        chart.draw_series(points.map(|point| Circle::new(point, 1, shade.filled())))?;
    }
    let outline = LineSeries::new(outline.map(|r| (r.x, r.y)), BLACK.stroke_width(2));
    chart.draw_series(outline)?;
    root.present()?;
    Ok(())
}

/// The beads of a chain, each by the nearest image of the one before, the first in the cell.
fn walk(system: &System<Space>, beads: std::ops::Range<u32>) -> Vec<DVec3> {
    let positions = system.particles.positions();
    let mut bead = positions[beads.start as usize];
    beads
        .map(|identity| {
            bead += system
                .boundary
                .min_image(positions[identity as usize] - bead);
            bead
        })
        .collect()
}
