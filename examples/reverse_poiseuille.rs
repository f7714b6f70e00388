//! A rheometer without walls or moving images: the melts and solutions of Fedosov, Karniadakis and Caswell (J. Chem. Phys.
//! 132, 144103, 2010) in reverse Poiseuille flow.
//!
//! ```text
//! cargo run --release --example reverse_poiseuille                         melt of dumbbells, ten minutes
//! cargo run --release --example reverse_poiseuille -- --quick              half a minute
//! cargo run --release --example reverse_poiseuille -- --beads 5 --time 2000
//! cargo run --release --example reverse_poiseuille -- --beads 5 --concentration 0.25 --forces 0.12,1.2
//! cargo run --release --example reverse_poiseuille -- --help               all options
//! ```
//!
//! Dissipative particles of density 3, r_c = 2, a = 25 kT and friction 4.5 with the weight (1 - r / r_c)^(1/2), some or
//! all of them joined to chains of FENE springs. A force f drives them along x in the upper half of the cell and back in
//! the lower: four half-channels in which the stress rises linearly from zero. Each body force is a run of its own;
//! together they are one rheogram. The published cell is `--size 20,50,10` with forces 0.025 and 0.25.
//!
//! The tables hold, for each layer, what was found and its error: layers.csv for all runs. Zero-shear values come from
//! the neighbourhood of the centre line in the run of the least force, the exponent p of tau = kappa rate^p from the
//! velocity in that of the largest. In solutions chains migrate: columns with `shifted` in their names are the points
//! moved to the mean concentration by the published rule of time and concentration.
//!
//! An interrupted run goes on with `--resume`, to the same bits.

use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};
use plotters::coord::Shift;
use plotters::prelude::*;
use std::error::Error;
use std::fs::{self, File};
use std::io::{BufRead, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use zimm::prelude::*;

/// What went wrong, in one sentence.
type Problem = Box<dyn Error + Send + Sync>;

const DENSITY: f64 = 3.0;
const CUTOFF: f64 = 2.0;
const DT: f64 = 0.005;
/// Overlaps of the random start want short steps.
const FIRST_STEPS: u64 = 1000;
const FIRST_DT: f64 = 0.001;
const STEPS_PER_SAMPLE: u64 = 10;
const STEPS_PER_CHECKPOINT: u64 = 2000;

/// Drives polymers up and down in one cell and measures what a rheometer would.
#[derive(Debug, Parser)]
struct Options {
    /// Beads of a chain; 1 is a fluid of free beads.
    #[arg(long, default_value_t = 2)]
    beads: u32,
    /// Share of the beads that belong to chains.
    #[arg(long, default_value_t = 1.0)]
    concentration: f64,
    /// Body forces, each a run.
    #[arg(long, value_delimiter = ',', default_values_t = [0.12, 0.6])]
    forces: Vec<f64>,
    /// Edges of the cell along the flow, across the channels, and along the neutral axis.
    #[arg(long, value_delimiter = ',', num_args = 3, default_values_t = [5.0, 20.0, 5.0])]
    size: Vec<f64>,
    /// Time that counts.
    #[arg(long, default_value_t = 500.0)]
    time: f64,
    /// Time in the flow before that.
    #[arg(long, default_value_t = 50.0)]
    unseen: f64,
    /// Layers across the cell, a multiple of four.
    #[arg(long, default_value_t = 40)]
    layers: usize,
    /// Layers to either side from which shear rates are taken.
    #[arg(long, default_value_t = 3)]
    window: usize,
    /// Share of half a channel from which zero-shear values are taken.
    #[arg(long, default_value_t = 0.7)]
    share: f64,
    /// Thermal energy.
    #[arg(long, default_value_t = 1.0)]
    kt: f64,
    /// Repulsion a.
    #[arg(long, default_value_t = 25.0)]
    repulsion: f64,
    /// Friction gamma.
    #[arg(long, default_value_t = 4.5)]
    friction: f64,
    /// Stiffness of the springs.
    #[arg(long, default_value_t = 50.0)]
    stiffness: f64,
    /// Length at which springs end.
    #[arg(long, default_value_t = 1.0)]
    limit: f64,
    /// Viscosity of the free beads, for solutions.
    #[arg(long, default_value_t = 42.0)]
    solvent: f64,
    /// The published alpha of time and concentration; 1.5 suits chains of 25 beads, 0.75 those of 5.
    #[arg(long, default_value_t = 0.75)]
    alpha: f64,
    /// Seed; the same seed gives the same bits on any number of threads.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// A small cell for a short time.
    #[arg(long)]
    quick: bool,
    /// Directory for layers.csv, reverse_poiseuille.svg and checkpoints.
    #[arg(long, default_value = "target/reverse_poiseuille")]
    out: PathBuf,
    /// Goes on from checkpoints.
    #[arg(long)]
    resume: bool,
}

type Forces = (
    Pairwise<Dpd<f64, SquareRoot>, VerletList>,
    Bonded<Fene>,
    ReversePoiseuille,
);

/// One run and its layers.
struct Run {
    force: f64,
    channel: Channel,
    average: StressProfileAverage,
    layers: Vec<ChannelLayer>,
}

fn main() -> Result<(), Problem> {
    // Inside a pool: from outside, every part of a step would be handed over to it anew.
    rayon::ThreadPoolBuilder::new().build()?.install(run)
}

fn run() -> Result<(), Problem> {
    let mut options = Options::parse();
    if options.quick {
        (options.size, options.layers) = (vec![5.0, 16.0, 5.0], 32);
        (options.forces, options.unseen, options.time) = (vec![0.5, 1.5], 5.0, 20.0);
    }
    let least = 4 * (2 * options.window + 1);
    if !options.layers.is_multiple_of(4) || options.layers < least {
        let layers = options.layers;
        let why = format!(
            "--layers {layers} is no multiple of 4 of at least {least}, which the window takes"
        );
        return Err(why.into());
    }
    fs::create_dir_all(&options.out)?;
    let mut runs = Vec::new();
    for &force in &options.forces {
        runs.push(measure(&options, force)?);
    }
    runs.sort_by(|a, b| a.force.total_cmp(&b.force));
    let [table, picture] =
        ["layers.csv", "reverse_poiseuille.svg"].map(|name| options.out.join(name));
    fs::write(&table, csv(&options, &runs))?;
    report(&options, &runs)?;
    draw(&picture, &options, &runs)?;
    println!("written: {}, {}", table.display(), picture.display());
    Ok(())
}

/// The run at one body force, from a checkpoint if there is one and it is wanted.
fn measure(options: &Options, force: f64) -> Result<Run, Problem> {
    let channel = Channel::new(DVec3::X, force)?.with_window(options.window)?;
    let (mut system, chains) = start(options)?;
    let profile = Profile::new(DVec3::Y, options.size[1], options.layers)?;
    let heard = LayeredVirial::new(&profile);
    let mut observable = StressProfile::new(profile, 2).without(Item::Random);
    let mut average = StressProfileAverage::new(&observable);
    let law = Dpd::new(options.repulsion, options.friction)?.with_cutoff(CUTOFF)?;
    let springs = Fene::new(options.stiffness, options.limit)?;
    let mut field: Forces = (
        Pairwise::new(law.with_weight(SquareRoot), VerletList::new(0.25)?),
        Bonded::new(springs, chains.bonds()),
        ReversePoiseuille::new(force, 0, 1)?,
    );
    let name = format!("beads-{}-force-{force}.checkpoint", options.beads);
    let checkpoint = options.out.join(name);
    let scene = scene(options, force);
    if options.resume && checkpoint.exists() {
        let mut file = BufReader::new(File::open(&checkpoint)?);
        let mut found = String::new();
        file.read_line(&mut found)?;
        if found != scene {
            let (name, found, scene) = (checkpoint.display(), found.trim_end(), scene.trim_end());
            return Err(format!("{name} is of another run, {found}; this one is {scene}").into());
        }
        system = load(system.boundary, &mut file)?;
        average.restore(&mut file)?;
    }
    let mut stepper = GrootWarren::new(0.5)?;
    let first = FIRST_STEPS + (options.unseen / DT) as u64;
    let last = first + (options.time / DT) as u64;
    let bar = ProgressBar::new(last);
    let template = "f = {prefix} [{bar:40}] {percent:>3} %, {eta} left";
    let style = ProgressStyle::with_template(template);
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.set_prefix(force.to_string());
    while system.clock.now().step < last {
        let step = system.clock.now().step + 1;
        if step > first && step.is_multiple_of(STEPS_PER_SAMPLE) {
            let mut heard = heard.fresh();
            stepper.step(&mut system, &mut field, &mut heard)?;
            average.push(observable.measure(&system.frame(), &heard)?);
        } else {
            stepper.step(&mut system, &mut field, &mut ())?;
        }
        if step == FIRST_STEPS {
            system.clock.set_dt(DT)?;
        }
        if step.is_multiple_of(STEPS_PER_CHECKPOINT) || step == last {
            keep(&checkpoint, &scene, &system, &mut field, &average)?;
            bar.set_position(step);
        }
    }
    bar.finish_and_clear();
    let layers = channel.layers(&average)?;
    Ok(Run {
        force,
        channel,
        average,
        layers,
    })
}

/// All that a run begins with, in a line: one of another scene is not gone on with. Only the time may grow.
fn scene(options: &Options, force: f64) -> String {
    let Options {
        beads,
        concentration,
        size,
        unseen,
        layers,
        kt,
        repulsion,
        friction,
        stiffness,
        limit,
        seed,
        ..
    } = options;
    format!(
        "beads {beads} concentration {concentration} force {force} size {size:?} unseen {unseen} layers {layers} kt {kt} \
         repulsion {repulsion} friction {friction} stiffness {stiffness} limit {limit} seed {seed}\n"
    )
}

/// Scene, state and statistic in one file, which takes the place of the former when it is complete.
fn keep(
    path: &Path,
    scene: &str,
    system: &System<PeriodicBox>,
    field: &mut Forces,
    average: &StressProfileAverage,
) -> Result<(), Problem> {
    let part = path.with_extension("part");
    let mut file = BufWriter::new(File::create(&part)?);
    file.write_all(scene.as_bytes())?;
    save(system, field, &mut file)?;
    average.save(&mut file)?;
    file.into_inner()?.sync_all()?;
    Ok(fs::rename(part, path)?)
}

/// Chains (species 1) and free beads (species 0) at random.
fn start(options: &Options) -> Result<(System<PeriodicBox>, Molecules), Problem> {
    let &[x, y, z] = options.size.as_slice() else {
        return Err("--size takes three numbers".into());
    };
    let space = PeriodicBox::brick(DVec3::new(x, y, z))?;
    let count = DENSITY * space.lattice().volume();
    let share = count * options.concentration.clamp(0.0, 1.0) / f64::from(options.beads.max(1));
    let chains = Molecules::linear(0, share.round() as u32, options.beads)?;
    let mut rng = start::stream(options.seed);
    let bond = 0.3 * options.limit;
    let mut positions = start::chains(space.lattice(), &chains, |_| bond, &mut rng);
    let joined = positions.len();
    let free = (count.round() as usize).saturating_sub(joined);
    positions.extend(start::uniform(space.lattice(), free, &mut rng));
    let particles = Particles::new(positions)?;
    let velocities = start::velocities(&particles, options.kt, &mut rng)?;
    let species = (0..particles.len()).map(|k| u8::from(k < joined));
    let species = species.collect();
    let particles = particles
        .with_velocities(velocities)?
        .with_species(species)?;
    let clock = Clock::new(FIRST_DT, options.kt, options.seed)?;
    Ok((System::new(space, particles, clock), chains))
}

/// A line for each layer of each run.
fn csv(options: &Options, runs: &[Run]) -> String {
    let names = [
        "velocity",
        "density",
        "chain_beads",
        "temperature",
        "pressure",
        "imposed_stress",
        "shear_stress",
        "first_difference",
        "second_difference",
        "rate",
        "viscosity",
        "psi1",
        "psi2",
    ];
    let mut text = String::from("force,distance");
    for name in names {
        text += &format!(",{name},{name}_error");
    }
    text += ",shifted_rate,shifted_viscosity\n";
    for run in runs {
        for layer in &run.layers {
            text += &format!("{},{}", run.force, layer.distance);
            let mut put = |mean: Option<Mean>| match mean {
                Some(mean) => text += &format!(",{},{}", mean.value, mean.at_least()),
                None => text += ",,",
            };
            let functions = layer.functions;
            for mean in [
                layer.velocity,
                layer.density,
                chain_beads(layer),
                layer.temperature,
                layer.pressure,
                layer.imposed,
                layer.shear,
                layer.first_difference,
                layer.second_difference,
                layer.rate,
            ] {
                put(Some(mean));
            }
            put(functions.map(|f| f.viscosity));
            put(functions.map(|f| f.psi1));
            put(functions.map(|f| f.psi2));
            match shifted(options, layer) {
                Some([rate, viscosity]) => text += &format!(",{rate},{viscosity}\n"),
                None => text += ",,\n",
            }
        }
    }
    text
}

/// Beads of chains per volume.
fn chain_beads(layer: &ChannelLayer) -> Mean {
    layer
        .concentrations
        .get(1)
        .copied()
        .unwrap_or(layer.density)
}

/// Rate and viscosity moved to the mean concentration.
fn shifted(options: &Options, layer: &ChannelLayer) -> Option<[f64; 2]> {
    let mean = DENSITY * options.concentration;
    let density = chain_beads(layer).value;
    let a = Superposition::of_concentration(density, mean, options.alpha).ok()?;
    let viscosity = layer.functions?.viscosity.value;
    let shifted = options.solvent + (viscosity - options.solvent) * a;
    Some([layer.rate.value / a, shifted])
}

/// Table II of the paper: eta_0, lambda_0, -Psi_2 / Psi_1, p of the velocity.
const PUBLISHED: [(u32, [f64; 4]); 3] = [
    (2, [62.7, 0.636, 0.003, 0.898]),
    (5, [138.4, 8.564, 0.281, 0.831]),
    (25, [830.9, 536.73, 0.3, 0.703]),
];

fn report(options: &Options, runs: &[Run]) -> Result<(), Problem> {
    println!(
        "chains of {} beads, {} of all",
        options.beads, options.concentration
    );
    for Run {
        force,
        channel,
        average,
        layers,
    } in runs
    {
        let worst =
            |pick: &dyn Fn(&ChannelLayer) -> f64| layers.iter().map(pick).fold(0.0, f64::max);
        let uneven = worst(&|layer| (layer.density.value / DENSITY - 1.0).abs());
        let off = worst(&|l| (l.shear.value - l.imposed.value).abs() / l.shear.at_least());
        println!(
            "f = {force}: density within {:.1} %, computed stress within {off:.1} errors of the imposed",
            100.0 * uneven
        );
        match channel.zero_shear(average, options.share) {
            Ok(ZeroShear {
                viscosity,
                psi1,
                psi2,
                relaxation_time,
                ratio,
            }) => {
                let ratio = ratio.map_or("-".into(), |ratio| format!("{ratio:#}"));
                println!(
                    "  near the centre: eta_0 {viscosity:#}, Psi_1 {psi1:#}, Psi_2 {psi2:#}, lambda_0 {relaxation_time:#}, -Psi_2/Psi_1 {ratio}"
                );
            }
            Err(problem) => println!("  near the centre: {problem}"),
        }
        if let (Ok(one), Ok(p)) = (
            channel.viscosity(average),
            channel.velocity_exponent(average),
        ) {
            println!("  over the channel: parabola with eta {one:#}, power law with p {p:#}");
        }
    }
    if let Some((_, [eta, time, ratio, p])) =
        PUBLISHED.iter().find(|(beads, _)| *beads == options.beads)
    {
        println!(
            "published for the melt: eta_0 {eta}, lambda_0 {time}, -Psi_2/Psi_1 {ratio}, p {p}"
        );
    }
    let rheogram = Rheogram::new(
        runs.iter()
            .map(|run| (run.channel, run.average.clone()))
            .collect(),
    )?;
    let fitted = rheogram.of(|points| {
        let Ellis {
            viscosity,
            half_stress,
            exponent,
        } = Ellis::fit(points)?;
        Ok(vec![viscosity, half_stress, exponent])
    });
    match fitted.as_deref() {
        Ok([viscosity, stress, exponent]) => {
            println!("Ellis: eta_0 {viscosity:#}, tau_1/2 {stress:#}, alpha {exponent:#}");
        }
        Ok(_) => {}
        Err(problem) => println!("Ellis: {problem}"),
    }
    Ok(())
}

/// Points of one run in a picture.
type Points = Vec<(f64, Mean)>;

/// Profiles above, rheogram below.
fn draw(path: &Path, options: &Options, runs: &[Run]) -> Result<(), Problem> {
    let root = SVGBackend::new(path, (1260, 800)).into_drawing_area();
    root.fill(&WHITE)?;
    let areas = root.split_evenly((2, 3));
    let across = |pick: &dyn Fn(&ChannelLayer) -> Option<Mean>| -> Vec<Points> {
        let point = |layer: &ChannelLayer| Some((layer.distance, pick(layer)?));
        let points = |run: &Run| run.layers.iter().filter_map(point).collect();
        runs.iter().map(points).collect()
    };
    let against_rate = |pick: &dyn Fn(&ShearFunctions) -> Mean| -> Vec<Points> {
        let point =
            |layer: &ChannelLayer| Some((layer.rate.value, pick(layer.functions.as_ref()?)));
        let points = |run: &Run| run.layers.iter().filter_map(point).collect();
        runs.iter().map(points).collect()
    };
    let (y, rate) = ("distance from the centre line", "shear rate");
    let imposed = across(&|layer| Some(layer.imposed));
    panel(
        &areas[0],
        runs,
        "velocity",
        y,
        &across(&|layer| Some(layer.velocity)),
        &[],
    )?;
    let (title, density) = if options.concentration < 1.0 {
        (
            "chain beads / mean",
            across(&|layer| {
                Some(chain_beads(layer).times(1.0 / (DENSITY * options.concentration)))
            }),
        )
    } else {
        (
            "density / mean",
            across(&|layer| Some(layer.density.times(1.0 / DENSITY))),
        )
    };
    panel(&areas[1], runs, title, y, &density, &[])?;
    let title = "shear stress: computed (points), imposed (lines)";
    panel(
        &areas[2],
        runs,
        title,
        y,
        &across(&|layer| Some(layer.shear)),
        &imposed,
    )?;
    logarithmic(
        &areas[3],
        runs,
        "viscosity",
        rate,
        &against_rate(&|f| f.viscosity),
    )?;
    logarithmic(&areas[4], runs, "Psi_1", rate, &against_rate(&|f| f.psi1))?;
    logarithmic(
        &areas[5],
        runs,
        "-Psi_2",
        rate,
        &against_rate(&|f| f.psi2.times(-1.0)),
    )?;
    root.present()?;
    Ok(())
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

fn colour(run: usize) -> RGBColor {
    [
        RGBColor(0, 90, 170),
        RGBColor(205, 85, 20),
        RGBColor(20, 130, 90),
        RGBColor(140, 70, 160),
    ][run % 4]
}

fn bar(
    (x, mean): &(f64, Mean),
    [low, high]: [f64; 2],
    colour: RGBColor,
) -> ErrorBar<f64, f64, plotters::element::ErrorBarOrientV<f64, f64>> {
    let (y, error) = (mean.value, mean.at_least());
    ErrorBar::new_vertical(
        *x,
        (y - error).max(low),
        y,
        (y + error).min(high),
        colour.filled(),
        6,
    )
}

fn panel(
    area: &Area<'_>,
    runs: &[Run],
    title: &str,
    x: &str,
    series: &[Points],
    lines: &[Points],
) -> Result<(), Problem> {
    let points = || series.iter().flatten();
    let right = points().map(|(x, _)| *x).fold(0.0, f64::max) * 1.04;
    let low = points()
        .map(|(_, m)| m.value - m.at_least())
        .fold(f64::MAX, f64::min);
    let high = points()
        .map(|(_, m)| m.value + m.at_least())
        .fold(f64::MIN, f64::max);
    let room = 0.08 * (high - low);
    let ends = [low - room, high + room];
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 17))
        .margin(12)
        .margin_right(24)
        .x_label_area_size(40)
        .y_label_area_size(56)
        .build_cartesian_2d(0.0..right, ends[0]..ends[1])?;
    chart
        .configure_mesh()
        .x_desc(x)
        .light_line_style(WHITE)
        .draw()?;
    for (k, line) in lines.iter().enumerate() {
        let line = line.iter().map(|(x, mean)| (*x, mean.value));
        chart.draw_series(LineSeries::new(line, colour(k).stroke_width(1)))?;
    }
    for (k, points) in series.iter().enumerate() {
        let label = format!("f = {}", runs[k].force);
        chart
            .draw_series(points.iter().map(|point| bar(point, ends, colour(k))))?
            .label(label)
            .legend(move |(x, y)| Circle::new((x + 9, y), 4, colour(k).filled()));
    }
    let mut labels = chart.configure_series_labels();
    labels
        .position(if lines.is_empty() {
            SeriesLabelPosition::LowerLeft
        } else {
            SeriesLabelPosition::UpperLeft
        })
        .background_style(WHITE.mix(0.8))
        .draw()?;
    Ok(())
}

fn logarithmic(
    area: &Area<'_>,
    runs: &[Run],
    title: &str,
    x: &str,
    series: &[Points],
) -> Result<(), Problem> {
    // What is below two of its errors says nothing on a logarithmic axis.
    let clear = |(_, mean): &&(f64, Mean)| mean.value > 2.0 * mean.at_least();
    let points = || series.iter().flatten().filter(clear);
    if points().next().is_none() {
        area.draw(&Text::new(
            format!("{title}: nothing above its error"),
            (30, 20),
            ("sans-serif", 17),
        ))?;
        return Ok(());
    }
    let span = |values: &mut dyn Iterator<Item = f64>| {
        let (low, high) = values.fold((f64::MAX, 0.0_f64), |(a, b), v| (a.min(v), b.max(v)));
        [low / 1.3, high * 1.3]
    };
    let ticks = |range: [f64; 2]| -> Vec<f64> {
        let digits: &[f64] = if range[1] < 30.0 * range[0] {
            &[1.0, 2.0, 3.0, 5.0, 7.0]
        } else {
            &[1.0]
        };
        let decades = -6..6;
        let ticks = decades.flat_map(|p| digits.iter().map(move |d| d * 10.0_f64.powi(p)));
        ticks.filter(|x| (range[0]..range[1]).contains(x)).collect()
    };
    let [left, right] = span(&mut points().map(|(x, _)| *x));
    let ends = span(&mut points().map(|(_, mean)| mean.value));
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 17))
        .margin(12)
        .margin_right(24)
        .x_label_area_size(40)
        .y_label_area_size(56)
        .build_cartesian_2d(
            (left..right)
                .log_scale()
                .with_key_points(ticks([left, right])),
            (ends[0]..ends[1]).log_scale().with_key_points(ticks(ends)),
        )?;
    chart
        .configure_mesh()
        .x_desc(x)
        .x_label_formatter(&|x| format!("{}", *x as f32))
        .y_label_formatter(&|y| format!("{}", *y as f32))
        .light_line_style(WHITE)
        .draw()?;
    for (k, points) in series.iter().enumerate() {
        let label = format!("f = {}", runs[k].force);
        chart
            .draw_series(
                points
                    .iter()
                    .filter(clear)
                    .map(|point| bar(point, ends, colour(k))),
            )?
            .label(label)
            .legend(move |(x, y)| Circle::new((x + 9, y), 4, colour(k).filled()));
    }
    let mut labels = chart.configure_series_labels();
    labels
        .position(SeriesLabelPosition::LowerLeft)
        .background_style(WHITE.mix(0.8))
        .draw()?;
    Ok(())
}
