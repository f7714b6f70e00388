//! One run, against time.

use crate::Problem;
use crate::options::{Flow, Options};
use crate::solution::{
    BEADS, CONTOUR, CROWDED, DT, KT, SPRINGS_CUTOFF, STEPS_PER_CHECKPOINT, Solution, filled,
    progress_bar, stepper, trace,
};
use plotters::prelude::*;
use std::fs;
use std::path::Path;
use zimm::prelude::*;

/// Time at rest before the flow.
const REST: f64 = 20.0;
const SAMPLES: u64 = 200;

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

/// `space` is the cell of a rate.
pub(crate) fn run<B: Periodic>(
    options: &Options,
    solution: &Solution,
    space: impl Fn(f64) -> Result<B, Problem>,
) -> Result<(), Problem> {
    let flowing = space(solution.rate)?;
    let chains = solution.chains(flowing.lattice())?;
    let mut forces = solution.forces(&chains)?;
    let [table, checkpoint] =
        ["csv", "checkpoint"].map(|kind| options.out.join(format!("semidilute_dpd.{kind}")));
    let (mut system, mut samples) = if options.resume && checkpoint.exists() {
        let (system, measured) = solution.go_on(&checkpoint, flowing)?;
        (system, measured.as_chunks().0.to_vec())
    } else {
        let mut rest = solution.begin(space(0.0)?, &chains, &mut forces)?;
        let mut stepper = stepper()?;
        let bar = progress_bar("at rest", (REST / DT) as u64);
        while rest.clock.now().time < REST {
            stepper.step(&mut rest, &mut forces, &mut ())?;
            bar.inc(1);
        }
        bar.finish_and_clear();
        let clock = Clock::new(DT, KT, solution.seed ^ (1 << 63))?;
        (System::new(flowing, rest.particles, clock), Vec::new())
    };

    let mut stepper = stepper()?;
    let last = options.steps();
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
            solution.keep(&checkpoint, &system, &mut forces, samples.as_flattened())?;
        }
        bar.set_position(step);
    }
    bar.finish_and_clear();
    let picture = options.out.join("semidilute_dpd.svg");
    draw(&picture, options, &samples)?;
    report(solution, &chains, &system, &samples)?;
    println!("written: {}, {}", table.display(), picture.display());
    Ok(())
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
    let stress = Stress.measure(&frame, virial);
    let repulsion = stress.item(Item::SpringRepulsion);
    let springs = stress.item(Item::Spring) + repulsion;
    let numbers = [
        frame.now.time,
        extension / CONTOUR,
        average(SquaredRadius { molecules }.measure(&frame, &())?),
        match flow {
            Flow::Extension => springs.x_axis.x - springs.y_axis.y,
            Flow::Rest | Flow::Shear => springs.y_axis.x,
        },
        -trace(repulsion) / 3.0,
        filled(system, &chains.bonds()),
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
    solution: &Solution,
    chains: &Molecules,
    system: &System<B>,
    samples: &[Sample],
) -> Result<(), Problem> {
    println!(
        "{} chains of {BEADS} beads among {} beads, rate {:.5}, De {:.3}",
        chains.count(),
        system.particles.len(),
        solution.rate,
        solution.deborah(),
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
