//! A map of planar mixed flow: FENE dumbbells that repel each other, alone and at their overlap concentration, at many
//! extension and shear rates.
//!
//! ```text
//! cargo run --release --example mixed_flow_map                   an hour or two on two cores
//! cargo run --release --example mixed_flow_map -- --quick        a coarse map in ten minutes
//! cargo run --release --example mixed_flow_map -- --resume       goes on after an interruption
//! ```
//!
//! The dumbbells have the extensibility b = 50 and an excluded volume of strength z* = 10 and range d* = 1; units are kT,
//! l_H and lambda_H. At the overlap concentration c* = N / (4 pi R_g^3 / 3) they fill the smallest periodic cell in which
//! no spring meets its own image: Lees-Edwards in shear, Kraynik-Reinelt in extension, and its kin for mixed flow. The
//! system is that of Jain, Sasmal, Hartkamp, Todd and Prakash, Chem. Eng. Sci. 121, 245 (2015). Without hydrodynamic
//! interactions, as there.
//!
//! The flow is u = (e x + g y, -e y, 0). What to look at:
//! * coils unfold as e grows, more sharply at c* than alone: neighbours compress the coils at rest and add to the stress;
//! * at e = 0.7, shear first leaves the coils as they are, then lets them tumble, then stretches them again;
//! * at high e shear does not matter: all curves end at the full length, b, and at eta_1 = 2 b.
//!
//! `eta` joins sigma_xy / g in shear and eta_1 = (sigma_xx - sigma_yy) / e in extension: [sqrt(chi) (sigma_xx - sigma_yy)
//! + (1 - chi) sigma_xy] / [G (sqrt(chi) + 1 - chi)], G and chi the strain rate and the mixedness of Fuller and Leal.

#[allow(dead_code)] // The rheometer uses more of it.
#[path = "rheometer/panel.rs"]
mod panel;

use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};
use panel::{Panel, Points, Series, spread};
use plotters::prelude::*;
use std::error::Error;
use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use zimm::prelude::*;

/// What went wrong, in one sentence.
type Problem = Box<dyn Error + Send + Sync>;

const KT: f64 = 1.0;
const FRICTION: f64 = 4.0;
const EXTENSIBILITY: f64 = 50.0;
const STRENGTH: f64 = 10.0;
const RANGE: f64 = 1.0;
/// Mean radius of gyration of a dumbbell alone at rest, by quadrature.
const RADIUS_OF_GYRATION: f64 = 1.200857;
const SKIN: f64 = 0.5;
/// Times that pass before anything counts, and that count.
const TRANSIENT: f64 = 12.0;
const MEASUREMENT: f64 = 24.0;
const BETWEEN: f64 = 0.5;
/// Systems with noise of their own.
const REPLICAS: u64 = 8;
/// Dumbbells of a replica that are alone.
const ALONE: u32 = 400;

const EXTENSION_RATES: [f64; 6] = [0.0, 0.1, 0.3, 0.7, 1.0, 2.0];
const SHEAR_RATES: [f64; 6] = [0.0, 0.1, 0.3, 1.0, 3.0, 10.0];

/// Maps planar mixed flow of a dumbbell solution.
#[derive(Debug, Parser)]
struct Options {
    /// A coarse map.
    #[arg(long)]
    quick: bool,
    /// Seed; the same seed gives the same bits on any number of threads.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Directory for mixed_flow_map.csv and mixed_flow_map.svg.
    #[arg(long, default_value = "target/mixed_flow_map")]
    out: PathBuf,
    /// Keeps the points that the CSV has.
    #[arg(long)]
    resume: bool,
}

/// One flow at one concentration.
#[derive(Clone, Copy, Debug)]
struct Point {
    /// c / c*; 0 for dumbbells that are alone.
    concentration: f64,
    extension: f64,
    shear: f64,
    square: Mean,
    viscosity: Mean,
}

fn main() -> Result<(), Problem> {
    let options = Options::parse();
    fs::create_dir_all(&options.out)?;
    let table = options.out.join("mixed_flow_map.csv");
    let mut points = if options.resume && table.exists() {
        read(&table)?
    } else {
        fs::write(&table, NAMES)?;
        Vec::new()
    };
    let every = if options.quick { 2 } else { 1 };
    let rates = |all: [f64; 6]| all.into_iter().step_by(every);
    let flows: Vec<_> = [0.0, 1.0]
        .into_iter()
        .flat_map(|c| {
            rates(EXTENSION_RATES).flat_map(move |e| rates(SHEAR_RATES).map(move |g| (c, e, g)))
        })
        .filter(|(_, e, g)| e + g > 0.0)
        .collect();
    let bar = ProgressBar::new(flows.len() as u64);
    let style = ProgressStyle::with_template("mapping [{bar:40}] {pos}/{len}, {eta} left");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    for (concentration, extension, shear) in flows {
        let is_there = |p: &Point| {
            (p.concentration, p.extension, p.shear) == (concentration, extension, shear)
        };
        if !points.iter().any(is_there) {
            let point = point(&options, concentration, extension, shear)?;
            OpenOptions::new()
                .append(true)
                .open(&table)?
                .write_all(line(&point).as_bytes())?;
            let (square, viscosity) = (point.square, point.viscosity);
            bar.println(format!(
                "c/c* {concentration}  e {extension:<4} g {shear:<4} R_e^2 {square:#}  eta {viscosity:#}"
            ));
            points.push(point);
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    let picture = options.out.join("mixed_flow_map.svg");
    draw(&picture, &points)?;
    println!("written: {}, {}", table.display(), picture.display());
    Ok(())
}

fn point(options: &Options, concentration: f64, e: f64, g: f64) -> Result<Point, Problem> {
    let rates = MixedRates {
        extension_rate: e,
        shear_rate: g,
    };
    let history = Steady::new(rates.strain_rate())?;
    let reach = EXTENSIBILITY.sqrt();
    let run = |replica| {
        let seed = options.seed ^ e.to_bits().rotate_left(9) ^ g.to_bits() ^ (replica << 50);
        let dt = 0.02 / rates.strain_rate().max(1.0);
        let clock = Clock::new(dt, KT, seed)?;
        if concentration == 0.0 {
            let gradient = DMat3::from_cols(e * DVec3::X, DVec3::new(g, -e, 0.0), DVec3::ZERO);
            alone(OpenFlow::new(gradient)?, clock, options.quick)
        } else if e == 0.0 {
            let space = LeesEdwards::new(DVec3::splat(2.0 * reach), history)?;
            crowded(space, concentration, clock, options.quick)
        } else {
            let space = PlanarMixed::box_for_cutoff(reach, rates.mixedness(), history)?;
            crowded(space, concentration, clock, options.quick)
        }
    };
    let (mut square, mut viscosity) = (EnsembleAverage::new(), EnsembleAverage::new());
    for (replica, samples) in (0..).zip(replicas(REPLICAS, run)?) {
        for (stress, end_to_end) in samples {
            square.push((replica, end_to_end));
            viscosity.push((replica, smooth_viscosity(rates, stress)));
        }
    }
    Ok(Point {
        concentration,
        extension: e,
        shear: g,
        square: square.estimate()?,
        viscosity: viscosity.estimate()?,
    })
}

fn smooth_viscosity(rates: MixedRates, stress: DMat3) -> f64 {
    let (root, strain_rate) = (rates.mixedness().sqrt(), rates.strain_rate());
    let shear = 1.0 - rates.mixedness();
    let difference = stress.x_axis.x - stress.y_axis.y;
    (root * difference + shear * stress.y_axis.x) / (strain_rate * (root + shear))
}

type Samples = Vec<(DMat3, f64)>;

/// Dumbbells in open space that do not know of each other.
fn alone(space: OpenFlow, clock: Clock, quick: bool) -> Result<Samples, Problem> {
    let dumbbells = Molecules::linear(0, ALONE, 2)?;
    let bond = start::BondLength::new(&spring()?, KT)?;
    let mut rng = start::stream(clock.now().seed);
    let positions = start::isolated(&dumbbells, |rng| bond.sample(rng), &mut rng);
    let system = System::new(space, Particles::new(positions)?, clock);
    let repulsion = Pairwise::new(repulsion()?, WithinMolecules::new(dumbbells));
    flow(system, repulsion, dumbbells, quick, |system| {
        recentre(system, &dumbbells)
    })
}

/// Dumbbells in a cell, all of which repel each other.
fn crowded<B: Periodic>(
    space: B,
    concentration: f64,
    clock: Clock,
    quick: bool,
) -> Result<Samples, Problem> {
    let beads =
        concentration * overlap_concentration(2, RADIUS_OF_GYRATION)? * space.lattice().volume();
    let dumbbells = Molecules::linear(0, (0.5 * beads).round() as u32, 2)?;
    let bond = start::BondLength::new(&spring()?, KT)?;
    let mut rng = start::stream(clock.now().seed);
    let positions = start::chains(
        space.lattice(),
        &dumbbells,
        |rng| bond.sample(rng),
        &mut rng,
    );
    let system = System::new(space, Particles::new(positions)?, clock);
    let repulsion = Pairwise::new(repulsion()?, VerletList::new(SKIN)?);
    flow(system, repulsion, dumbbells, quick, |_| Ok(()))
}

fn spring() -> Result<Fene, ParameterError> {
    Fene::new(1.0, EXTENSIBILITY.sqrt())
}

fn repulsion() -> Result<NarrowGaussian, ParameterError> {
    NarrowGaussian::new(STRENGTH, RANGE)
}

/// Stress per dumbbell over kT and mean square length, again and again.
fn flow<B: Boundary, X: ForceField<B>>(
    mut system: System<B>,
    repulsion: X,
    dumbbells: Molecules,
    quick: bool,
    tidy: impl Fn(&mut System<B>) -> Result<(), ParameterError>,
) -> Result<Samples, Problem> {
    let mut field = (Bonded::new(spring()?, dumbbells.bonds()), repulsion);
    let mut stepper = SemiImplicit::new(FreeDraining::new(FRICTION)?, Diagonal);
    let (mut kramers, mut ends) = (
        ChainStress {
            molecules: dumbbells,
        },
        EndToEnd {
            molecules: dumbbells,
        },
    );
    let step_at = |time: f64| (time / system.clock.now().dt).ceil() as u64;
    let share = if quick { 0.25 } else { 1.0 };
    let transient = step_at(TRANSIENT);
    let (last, between) = (transient + step_at(share * MEASUREMENT), step_at(BETWEEN));
    let mut samples = Vec::new();
    for step in 1..=last {
        if step > transient && (step - transient).is_multiple_of(between) {
            let mut virial = Virial::default();
            stepper.step(&mut system, &mut field, &mut virial)?;
            let frame = system.frame();
            let stress = kramers.measure(&frame, &virial)?;
            let ends = ends.measure(&frame, &())?;
            let square = ends.iter().map(|r| r.length_squared()).sum::<f64>();
            samples.push((stress * (1.0 / KT), square / ends.len() as f64));
        } else {
            stepper.step(&mut system, &mut field, &mut ())?;
        }
        if step.is_multiple_of(10) {
            tidy(&mut system)?;
        }
    }
    Ok(samples)
}

const NAMES: &str = "concentration,extension_rate,shear_rate,\
    end_to_end_squared,end_to_end_squared_error,viscosity,viscosity_error\n";

fn line(point: &Point) -> String {
    let (square, viscosity) = (point.square, point.viscosity);
    format!(
        "{},{},{},{},{},{},{}\n",
        point.concentration,
        point.extension,
        point.shear,
        square.value,
        square.at_least(),
        viscosity.value,
        viscosity.at_least()
    )
}

fn read(path: &Path) -> Result<Vec<Point>, Problem> {
    let mean = |value, error| Mean {
        value,
        error: StandardError::Plateau {
            error,
            uncertainty: 0.0,
        },
    };
    let text = fs::read_to_string(path)?;
    let point = |line: &str| {
        let numbers: Vec<f64> = line
            .split(',')
            .map(str::parse)
            .collect::<Result<_, _>>()
            .ok()?;
        let &[
            concentration,
            extension,
            shear,
            square,
            e_square,
            viscosity,
            e_viscosity,
        ] = &numbers[..]
        else {
            return None;
        };
        Some(Point {
            concentration,
            extension,
            shear,
            square: mean(square, e_square),
            viscosity: mean(viscosity, e_viscosity),
        })
    };
    text.lines()
        .skip(1)
        .map(|line| {
            point(line).ok_or_else(|| format!("{}: cannot read {line}", path.display()).into())
        })
        .collect()
}

/// Extension and viscosity against the shear rate, alone and at c*.
fn draw(path: &Path, points: &[Point]) -> Result<(), Problem> {
    let root = SVGBackend::new(path, (1000, 780)).into_drawing_area();
    root.fill(&WHITE)?;
    let areas = root.split_evenly((2, 2));
    let shear = spread(SHEAR_RATES.into_iter(), [1.5, 1.5]);
    let colours = [0.1, 0.3, 0.7, 1.0, 2.0].into_iter().zip([
        RGBColor(0, 90, 170),
        RGBColor(20, 130, 90),
        RGBColor(190, 150, 0),
        RGBColor(205, 85, 20),
        RGBColor(140, 70, 160),
    ]);
    let labels = ["e = 0", "e = 0.1", "e = 0.3", "e = 0.7", "e = 1", "e = 2"];
    type Part = fn(&Point) -> Mean;
    let parts: [(&str, &str, Part); 2] = [
        (
            "<R_e²> over l_H², alone",
            "<R_e²> over l_H², at c*",
            |point| point.square,
        ),
        (
            "Viscosity over n kT λ_H, alone",
            "Viscosity over n kT λ_H, at c*",
            |point| point.viscosity,
        ),
    ];
    for (row, (alone, crowded, part)) in parts.into_iter().enumerate() {
        for (column, (title, concentration)) in
            [(alone, 0.0), (crowded, 1.0)].into_iter().enumerate()
        {
            let curve = |e: f64| -> Points {
                let mine = |p: &&Point| {
                    p.concentration == concentration && p.extension == e && p.shear > 0.0
                };
                points
                    .iter()
                    .filter(mine)
                    .map(|p| (p.shear, part(p)))
                    .collect()
            };
            let all = std::iter::once((0.0, RGBColor(90, 90, 90))).chain(colours.clone());
            let series: Vec<Series> = all
                .zip(labels)
                .map(|((e, colour), label)| Series::new(label, colour, curve(e)))
                .filter(|series| !series.points.is_empty())
                .collect();
            Panel {
                abscissa: "shear rate g × λ_H",
                title,
                series: &series,
                theory: ("", Vec::new()),
                level: None,
                legend: SeriesLabelPosition::LowerLeft,
                room: [4.0, 1.5],
            }
            .draw_logarithmic(&areas[2 * row + column], &shear)?;
        }
    }
    root.present()?;
    Ok(())
}
