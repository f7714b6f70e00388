//! A semidilute polymer solution in dissipative particle dynamics: chains of 20 beads that cannot pass through each
//! other, at rest, in shear or in extension. After Clarke (PhD thesis, MIT 2008, chapter 5).
//!
//! ```text
//! cargo run --release --example semidilute_dpd                             c/c* = 1, extension at De = 1, minutes
//! cargo run --release --example semidilute_dpd -- --quick                  less than a minute
//! cargo run --release --example semidilute_dpd -- --flow shear --de 10 --solvent good
//! cargo run --release --example semidilute_dpd -- --help                   all options
//! ```
//!
//! The fluid has four beads per volume, a = 18.75 and Lowe-Andersen dynamics at the rate Gamma = 5. Chains are held by
//! FENE springs of limit 5 and extensibility 50, which repel each other by the exponential law with A = 100 and
//! alpha = 10. In a theta solvent all beads are alike, in a good one those of chains and solvent repel each other less,
//! a = 13.125. Units are those of DPD: r_c, kT, and tau = r_c (m / kT)^(1/2).
//!
//! The Deborah number De is the rate times 90 tau, the time in which stretched chains come back at c/c* = 0.5. (Rouse's
//! theory has zeta / (8 H sin^2(pi / 2N)) = 110 for the friction of a bead among its like.) Coils unravel in an extension
//! of De = 1/2 or more.
//!
//! An interrupted run goes on with `--resume`, to the same bits. The picture shows the extension of the chains, their size
//! and the stress of the springs against time, and how far springs are from each other.

use clap::{Parser, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use plotters::prelude::*;
use std::error::Error;
use std::fs::{self, File};
use std::io::{BufRead, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use zimm::prelude::*;

/// What went wrong, in one sentence.
type Problem = Box<dyn Error + Send + Sync>;

const KT: f64 = 1.0;
const DT: f64 = 0.02;
const DENSITY: f64 = 4.0;
const REPULSION: f64 = 18.75;
const REPULSION_OF_GOOD_SOLVENT: f64 = 13.125;
const BATH_RATE: f64 = 5.0;
const SKIN: f64 = 0.35;
const BEADS: u32 = 20;
const LIMIT: f64 = 5.0;
const EXTENSIBILITY: f64 = 50.0;
/// Range of the springs' repulsion, and of the distances in the picture.
const SPRINGS_CUTOFF: f64 = 1.0 / 3.0;
/// At which c / c* = 1 is one bead in ten.
const RADIUS_OF_GYRATION: f64 = 2.285;
/// Measured as chains came back from a stretch at c / c* = 0.5: 90 +- 7.
const RELAXATION_TIME: f64 = 90.0;
/// Images of the cell stay this far apart: twice the longest spring, nearly.
const IMAGES: f64 = 9.6;
/// Share of the volume near springs from which their repulsion is more than a hindrance to crossing.
const CROWDED: f64 = 0.5;
/// Time at rest before the flow.
const REST: f64 = 20.0;
const SAMPLES: u64 = 200;
const STEPS_PER_CHECKPOINT: u64 = 500;

/// Lets a semidilute solution of chains flow.
#[derive(Debug, Parser)]
struct Options {
    /// Concentration over the overlap concentration.
    #[arg(long, default_value_t = 1.0)]
    concentration: f64,
    /// How solvent and chains get along.
    #[arg(long, value_enum, default_value_t = Solvent::Theta)]
    solvent: Solvent,
    /// The flow.
    #[arg(long, value_enum, default_value_t = Flow::Extension)]
    flow: Flow,
    /// Deborah number, the rate times the relaxation time below c*.
    #[arg(long, default_value_t = 1.0)]
    de: f64,
    /// Rate of shear or extension in 1 / tau, instead of --de.
    #[arg(long)]
    rate: Option<f64>,
    /// Lets springs pass through each other.
    #[arg(long)]
    phantom: bool,
    /// Time in the flow, in relaxation times.
    #[arg(long, default_value_t = 10.0)]
    times: f64,
    /// Seed; the same seed gives the same bits on any number of threads.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// A third of a relaxation time.
    #[arg(long)]
    quick: bool,
    /// Directory for semidilute_dpd.csv, semidilute_dpd.svg and the checkpoint.
    #[arg(long, default_value = "target/semidilute_dpd")]
    out: PathBuf,
    /// Goes on from the checkpoint.
    #[arg(long)]
    resume: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Solvent {
    /// All beads are alike.
    Theta,
    /// Beads of chains and of solvent repel each other less.
    Good,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Flow {
    /// No flow.
    Rest,
    /// u = (rate y, 0, 0).
    Shear,
    /// u = rate (x, -y, 0).
    Extension,
}

/// One moment: time, extension of the chains over their contour, squared radius of gyration, stress of the springs
/// (sigma_xx - sigma_yy in extension, else sigma_xy), pressure of their repulsion, share of the volume that is nearer to
/// a spring than half of its range, temperature, and numbers of pairs of springs by their distance.
type Sample = [f64; NAMES.len() + BINS];
const NAMES: [&str; 7] = [
    "time",
    "extension",
    "squared_radius",
    "spring_stress",
    "repulsion_pressure",
    "filled",
    "temperature",
];
const BINS: usize = 20;

type Beads = Pairwise<DpdConservative<SpeciesMatrix<2>>, VerletList>;
type Forces<L> = (Beads, Bonded<Fene>, SegmentRepulsion<L, VerletList>);

fn main() -> Result<(), Problem> {
    // Inside a pool: from outside, every part of a step would be handed over to it anew.
    rayon::ThreadPoolBuilder::new().build()?.install(run)
}

fn run() -> Result<(), Problem> {
    let options = Options::parse();
    fs::create_dir_all(&options.out)?;
    match options.flow {
        Flow::Rest | Flow::Shear => springs(&options, |rate| {
            let edges = DVec3::splat(IMAGES);
            Ok(LeesEdwards::new(edges, Steady::new(rate)?)?)
        }),
        Flow::Extension => springs(&options, |rate| {
            let history = Steady::new(rate)?;
            Ok(KraynikReinelt::box_for_cutoff(0.5 * IMAGES, history)?)
        }),
    }
}

/// Chooses how springs repel each other. `space` is the cell of a rate.
fn springs<B: Periodic>(
    options: &Options,
    space: impl Fn(f64) -> Result<B, Problem>,
) -> Result<(), Problem> {
    if options.phantom {
        solution(options, space, Phantom::new(SPRINGS_CUTOFF)?)
    } else {
        let law = KumarLarson::new(100.0, 10.0, SPRINGS_CUTOFF)?;
        solution(options, space, law)
    }
}

fn solution<B: Periodic, L: SegmentForce + Copy>(
    options: &Options,
    space: impl Fn(f64) -> Result<B, Problem>,
    law: L,
) -> Result<(), Problem> {
    let rate = match options.flow {
        Flow::Rest => 0.0,
        _ => options.rate.unwrap_or(options.de / RELAXATION_TIME),
    };
    let flowing = space(rate)?;
    let chains = chains(options, flowing.lattice())?;
    let mut forces = forces(options, &chains, law)?;
    let mut stepper = stepper()?;
    let [table, checkpoint] =
        ["csv", "checkpoint"].map(|kind| options.out.join(format!("semidilute_dpd.{kind}")));
    let scene = scene(options, rate);
    let (mut system, mut samples) = if options.resume && checkpoint.exists() {
        go_on(&checkpoint, &scene, flowing)?
    } else {
        let rest = at_rest(options, space(0.0)?, &chains, &mut forces)?;
        let clock = Clock::new(DT, KT, options.seed ^ (1 << 63))?;
        (System::new(flowing, rest.particles, clock), Vec::new())
    };

    let times = if options.quick { 0.3 } else { options.times };
    let last = (times * RELAXATION_TIME / DT).ceil() as u64;
    let between = last.div_ceil(SAMPLES);
    let bar = progress_bar("flowing", last);
    let mut full = false;
    while system.clock.now().step < last {
        let step = system.clock.now().step + 1;
        if step.is_multiple_of(between) {
            let mut heard = (Virial::default(), SpringDistances::default());
            stepper.step(&mut system, &mut forces, &mut heard)?;
            let sample = measure(&system, options.flow, &chains, &heard)?;
            bar.set_message(format!("extension {:.3}", sample[1]));
            if sample[5] > CROWDED && !full {
                full = true;
                bar.println(format!(
                    "at time {:.0}, {:.0} % of the volume is nearer to a spring than half of the range of their repulsion: \
                     it orders the solution and makes a pressure of its own",
                    sample[0],
                    100.0 * sample[5],
                ));
            }
            samples.push(sample);
        } else {
            stepper.step(&mut system, &mut forces, &mut ())?;
        }
        if step.is_multiple_of(STEPS_PER_CHECKPOINT) || step == last {
            write(&table, &samples)?;
            keep(&checkpoint, &scene, &system, &mut forces, &samples)?;
        }
        bar.set_position(step);
    }
    bar.finish_and_clear();
    let picture = options.out.join("semidilute_dpd.svg");
    draw(&picture, options, &samples)?;
    report(rate, &chains, &system, &samples)?;
    println!("written: {}, {}", table.display(), picture.display());
    Ok(())
}

/// All that a run begins with, in a line: one of another scene is not gone on with. Only the time may grow.
fn scene(options: &Options, rate: f64) -> String {
    let Options {
        concentration,
        solvent,
        flow,
        phantom,
        seed,
        ..
    } = options;
    format!(
        "concentration {concentration} solvent {solvent:?} flow {flow:?} rate {rate} phantom {phantom} seed {seed}\n"
    )
}

/// Scene, state and samples in one file, which takes the place of the former when it is complete.
fn keep<B: Periodic>(
    path: &Path,
    scene: &str,
    system: &System<B>,
    forces: &mut impl ForceField<B>,
    samples: &[Sample],
) -> Result<(), Problem> {
    let part = path.with_extension("part");
    let mut file = BufWriter::new(File::create(&part)?);
    file.write_all(scene.as_bytes())?;
    save(system, forces, &mut file)?;
    for x in samples.as_flattened() {
        file.write_all(&x.to_le_bytes())?;
    }
    file.into_inner()?.sync_all()?;
    Ok(fs::rename(part, path)?)
}

/// State and samples of an interrupted run.
fn go_on<B: Periodic>(
    path: &Path,
    scene: &str,
    space: B,
) -> Result<(System<B>, Vec<Sample>), Problem> {
    let mut file = BufReader::new(File::open(path)?);
    let mut found = String::new();
    file.read_line(&mut found)?;
    if found != scene {
        let (name, found, scene) = (path.display(), found.trim_end(), scene.trim_end());
        return Err(format!("{name} is of another run, {found}; this one is {scene}").into());
    }
    let system = load(space, &mut file)?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    let numbers: Vec<f64> = bytes
        .as_chunks()
        .0
        .iter()
        .map(|eight| f64::from_le_bytes(*eight))
        .collect();
    Ok((system, numbers.as_chunks().0.to_vec()))
}

fn progress_bar(what: &str, steps: u64) -> ProgressBar {
    let template = format!("{what} [{{bar:40}}] {{percent:>3}} %, {{eta}} left, {{msg}}");
    let style = ProgressStyle::with_template(&template);
    ProgressBar::new(steps).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

fn chains(options: &Options, lattice: &Lattice) -> Result<Molecules, Problem> {
    let overlap = overlap_concentration(BEADS as usize, RADIUS_OF_GYRATION)?;
    let beads = options.concentration * overlap * lattice.volume();
    let chains = (beads / f64::from(BEADS)).round();
    let most = DENSITY * lattice.volume() / f64::from(BEADS);
    if (1.0..=most).contains(&chains) {
        Ok(Molecules::linear(0, chains as u32, BEADS)?)
    } else {
        let why = format!("{chains} chains of {BEADS} beads, but has room for 1 to {most:.0}");
        Err(format!(
            "--concentration {}: the cell would hold {why}",
            options.concentration
        )
        .into())
    }
}

fn stepper() -> Result<LoweAndersen<VerletList>, Problem> {
    Ok(LoweAndersen::new(BATH_RATE, 1.0, VerletList::new(SKIN)?)?)
}

fn forces<L>(options: &Options, chains: &Molecules, law: L) -> Result<Forces<L>, Problem> {
    let unlike = match options.solvent {
        Solvent::Theta => REPULSION,
        Solvent::Good => REPULSION_OF_GOOD_SOLVENT,
    };
    let repulsion = SpeciesMatrix::new([[REPULSION, unlike], [unlike, REPULSION]])?;
    let beads = DpdConservative::new(repulsion, 1.0)?;
    let spring = Fene::with_extensibility(EXTENSIBILITY, LIMIT, KT)?;
    Ok((
        Pairwise::new(beads, VerletList::new(SKIN)?),
        Bonded::new(spring, chains.bonds()),
        SegmentRepulsion::new(law, chains.bonds(), VerletList::new(SKIN)?),
    ))
}

/// Chains that are random walks, solvent anywhere, overlaps parted, then a while without flow.
fn at_rest<B: Periodic, L: SegmentForce>(
    options: &Options,
    space: B,
    chains: &Molecules,
    forces: &mut Forces<L>,
) -> Result<System<B>, Problem> {
    let bond = start::BondLength::new(forces.1.spring(), KT)?;
    let (lattice, mut rng) = (*space.lattice(), start::stream(options.seed));
    let positions = start::chains(&lattice, chains, |rng| bond.sample(rng), &mut rng);
    let positions = start::fill(&lattice, positions, DENSITY, &mut rng)?;
    let mut species = chains.species(&[(BEADS, 0)])?;
    species.resize(positions.len(), 1);
    let particles = Particles::new(positions)?.with_species(species)?;
    let velocities = start::velocities(&particles, KT, &mut rng)?;
    let particles = particles.with_velocities(velocities)?;
    let mut system = System::new(space, particles, Clock::new(DT, KT, options.seed)?);
    start::relax(&mut system, forces, 0.03, 100)?;
    let mut stepper = stepper()?;
    let bar = progress_bar("at rest", (REST / DT) as u64);
    while system.clock.now().time < REST {
        stepper.step(&mut system, forces, &mut ())?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(system)
}

fn measure<B: Periodic>(
    system: &System<B>,
    flow: Flow,
    chains: &Molecules,
    (virial, distances): &(Virial, SpringDistances),
) -> Result<Sample, Problem> {
    let frame = system.frame();
    let (molecules, along) = (*chains, DVec3::X);
    let average = |each: Vec<f64>| each.iter().sum::<f64>() / each.len() as f64;
    let extension = average(Extent { molecules, along }.measure(&frame, &())?);
    let contour = f64::from(BEADS - 1) * LIMIT;
    let stress = Stress.measure(&frame, virial);
    let repulsion = stress.item(Item::SpringRepulsion);
    let springs = stress.item(Item::Spring) + repulsion;
    let trace = repulsion.x_axis.x + repulsion.y_axis.y + repulsion.z_axis.z;
    let position = |id| frame.place(id).map(|place| frame.positions[place]);
    let spans = chains.bonds().into_iter().filter_map(|[i, j]| {
        let span = position(i)? - position(j)?;
        Some(system.boundary.min_image(span).length())
    });
    let tube = std::f64::consts::PI * (0.5 * SPRINGS_CUTOFF).powi(2);
    let numbers = [
        frame.now.time,
        extension / contour,
        average(SquaredRadius { molecules }.measure(&frame, &())?),
        match flow {
            Flow::Extension => springs.x_axis.x - springs.y_axis.y,
            Flow::Rest | Flow::Shear => springs.y_axis.x,
        },
        -trace / 3.0,
        tube * spans.sum::<f64>() / system.boundary.lattice().volume(),
        KineticTemperature::default()
            .measure(&frame, virial)?
            .mean(),
    ];
    let pairs = SpringDistribution::new(SPRINGS_CUTOFF, BINS)?.measure(&frame, distances);
    let mut sample = [0.0; NAMES.len() + BINS];
    for (entry, number) in sample.iter_mut().zip(numbers.into_iter().chain(pairs)) {
        *entry = number;
    }
    Ok(sample)
}

/// Means over the second half.
fn report<B>(
    rate: f64,
    chains: &Molecules,
    system: &System<B>,
    samples: &[Sample],
) -> Result<(), Problem> {
    println!(
        "{} chains of {BEADS} beads among {} beads, rate {rate:.5}, De {:.3}",
        chains.count(),
        system.particles.len(),
        rate * RELAXATION_TIME,
    );
    for (k, name) in NAMES.iter().enumerate().skip(1) {
        let mut average = BlockAverage::new();
        let half = &samples[samples.len() / 2..];
        half.iter().for_each(|sample| average.push(sample[k]));
        println!("{name:>18}  {:#}", average.estimate()?);
    }
    Ok(())
}

fn write(path: &Path, samples: &[Sample]) -> Result<(), Problem> {
    let pairs = (0..BINS).map(|k| format!("pairs_{k}"));
    let names: Vec<_> = NAMES.map(String::from).into_iter().chain(pairs).collect();
    let mut text = names.join(",") + "\n";
    for sample in samples {
        text += &(sample.map(|x| x.to_string()).join(",") + "\n");
    }
    Ok(fs::write(path, text)?)
}

/// Three quantities against time, and the distances of springs in the second half.
fn draw(path: &Path, options: &Options, samples: &[Sample]) -> Result<(), Problem> {
    let root = SVGBackend::new(path, (1000, 760)).into_drawing_area();
    root.fill(&WHITE)?;
    let areas = root.split_evenly((2, 2));
    let colour = RGBColor(0, 90, 170);
    let stress = match options.flow {
        Flow::Extension => "Stress of the springs, σ_xx - σ_yy in kT / r_c³",
        Flow::Rest | Flow::Shear => "Stress of the springs, σ_xy in kT / r_c³",
    };
    let titles = [
        "Extension along x over contour length",
        "<R_g²> / r_c²",
        stress,
    ];
    let end = samples.last().map_or(1.0, |sample| sample[0]);
    let curves = (1..4).map(|k| samples.iter().map(move |sample| (sample[0], sample[k])));
    for ((area, title), curve) in areas.iter().zip(titles).zip(curves) {
        panel(area, title, "t / τ", end, curve.collect(), colour)?;
    }
    let half = &samples[samples.len() / 2..];
    let width = SPRINGS_CUTOFF / BINS as f64;
    let bins = (0..BINS).map(|k| {
        let pairs: f64 = half.iter().map(|sample| sample[NAMES.len() + k]).sum();
        ((k as f64 + 0.5) * width, pairs / half.len().max(1) as f64)
    });
    let title = "Pairs of springs at a distance D";
    panel(
        &areas[3],
        title,
        "D / r_c",
        SPRINGS_CUTOFF,
        bins.collect(),
        colour,
    )?;
    root.present()?;
    Ok(())
}

fn panel(
    area: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    title: &str,
    abscissa: &str,
    end: f64,
    points: Vec<(f64, f64)>,
    colour: RGBColor,
) -> Result<(), Problem> {
    let values = || points.iter().map(|point| point.1);
    let (low, high) = values().fold((0.0_f64, 0.0_f64), |(a, b), y| (a.min(y), b.max(y)));
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 17))
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(56)
        .build_cartesian_2d(0.0..end, 1.1 * low..1.1 * high + 1e-9)?;
    let mesh = &mut chart.configure_mesh();
    mesh.x_desc(abscissa).light_line_style(WHITE).draw()?;
    chart.draw_series(LineSeries::new(points, colour.stroke_width(2)))?;
    Ok(())
}
