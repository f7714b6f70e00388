//! The work-precision study: what an approximation really errs by, against what it costs. One figure a name, each a
//! CSV and an SVG.
//!
//! ```text
//! cargo run --release -p benches --bin study                 every figure, into benches/study/
//! cargo run --release -p benches --bin study -- lattice      one of them
//! ```
//!
//! `lattice`: error of the carried lattice and of pair distances against the number of strain periods, planar
//! extension and planar mixed flow. "Closed form" is what zimm does: the cell is computed anew from the strain.
//! "Accumulated" carries the basis on from step to step and reduces it, a hundred steps a period: rounding grows as
//! exp(2 strain) and the lattice is lost within some twenty periods.

use clap::{Parser, ValueEnum};
use plotters::prelude::*;
use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use zimm::prelude::*;

#[derive(Parser)]
struct Options {
    /// The figures to make; all if none is named.
    figures: Vec<Figure>,
    /// Where CSV and SVG go.
    #[arg(long, default_value = "benches/study")]
    out: PathBuf,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Figure {
    /// Error of the carried lattice against the number of periods.
    Lattice,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    fs::create_dir_all(&options.out)?;
    let figures = if options.figures.is_empty() {
        Figure::value_variants()
    } else {
        &options.figures
    };
    for figure in figures {
        match figure {
            Figure::Lattice => lattice(&options.out)?,
        }
    }
    Ok(())
}

/// Errors after a number of periods.
struct Row {
    flow: &'static str,
    scheme: &'static str,
    periods: u32,
    lattice: f64,
    distance: f64,
}

fn lattice(out: &Path) -> Result<(), Box<dyn Error>> {
    let rate = Steady::new(1.0)?;
    let mut rows = Vec::new();
    rows.extend(errors(
        "planar extension",
        &KraynikReinelt::new(1.0, 1.0, rate)?,
        1.0,
    )?);
    for (name, mixedness) in [("mixedness 0.5", 0.5), ("mixedness 0.1", 0.1)] {
        let space = PlanarMixed::with_map(PlanarMap::CLASSIC, 1.0, 1.0, mixedness, rate)?;
        rows.extend(errors(name, &space, mixedness.sqrt())?);
    }
    let mut csv = String::from("flow,scheme,periods,lattice_error,distance_error\n");
    for row in &rows {
        writeln!(
            csv,
            "{},{},{},{:e},{:e}",
            row.flow, row.scheme, row.periods, row.lattice, row.distance
        )?;
    }
    fs::write(out.join("lattice.csv"), csv)?;
    draw_lattice(&out.join("lattice.svg"), &rows)?;
    println!("lattice: {}", out.join("lattice.svg").display());
    Ok(())
}

/// The lattice after n periods and a third is that after a third, whatever n. `hencky` is the Hencky strain in a unit
/// of time.
fn errors<B: Periodic>(
    flow: &'static str,
    space: &B,
    hencky: f64,
) -> Result<Vec<Row>, Box<dyn Error>> {
    const STEPS: u32 = 99;
    let period = ((3.0 + 5.0_f64.sqrt()) / 2.0).ln() / hencky;
    let at = |time: f64| {
        let mut space = space.clone();
        space.advance(time);
        *space.lattice()
    };
    let exact = at(period / 3.0);
    let mut rows = Vec::new();
    let mut add = |scheme, periods, lattice: &Lattice| {
        rows.push(Row {
            flow,
            scheme,
            periods,
            lattice: lattice_error(lattice, &exact),
            distance: distance_error(lattice, &exact),
        });
    };
    for periods in (0..=16).map(|k| 10_f64.powf(0.25 * f64::from(k)).round() as u32) {
        add(
            "closed form",
            periods,
            &at((f64::from(periods) + 1.0 / 3.0) * period),
        );
    }
    let step = space.carry(0.0, period / f64::from(STEPS));
    let mut carried = at(0.0);
    for n in 1..=40 * STEPS {
        carried = Lattice::new(step * carried.basis())?;
        if n % STEPS == STEPS / 3 && n > STEPS {
            add("accumulated", n / STEPS, &carried);
        }
    }
    Ok(rows)
}

/// How far basis vectors of one lattice are from vectors of the other, relative to the cell; 1 if they have nothing in
/// common.
fn lattice_error(found: &Lattice, exact: &Lattice) -> f64 {
    let off = [0, 1, 2].map(|k| exact.nearest(found.basis().col(k)).length());
    let volumes = (found.volume() / exact.volume() - 1.0).abs();
    off.into_iter().fold(volumes, f64::max).min(1.0)
}

/// The largest difference in nearest-image distance over a grid of separations.
fn distance_error(found: &Lattice, exact: &Lattice) -> f64 {
    let mut worst = 0.0_f64;
    for i in 0..20 {
        for j in 0..20 {
            let s = DVec3::new(f64::from(i) / 20.0, f64::from(j) / 20.0, 0.3) - 0.5;
            let r = exact.basis() * s;
            worst = worst.max((found.nearest(r).length() - exact.nearest(r).length()).abs());
        }
    }
    worst
}

fn draw_lattice(path: &Path, rows: &[Row]) -> Result<(), Box<dyn Error>> {
    let root = SVGBackend::new(path, (1000, 420)).into_drawing_area();
    root.fill(&WHITE)?;
    let flows = ["planar extension", "mixedness 0.5", "mixedness 0.1"];
    let colours = [
        RGBColor(0, 90, 170),
        RGBColor(200, 80, 20),
        RGBColor(20, 130, 90),
    ];
    type Pick = fn(&Row) -> f64;
    let panels: [(&str, Pick); 2] = [
        ("Error of the carried lattice", |row| row.lattice),
        ("Error of pair distances", |row| row.distance),
    ];
    for (area, (title, pick)) in root.split_evenly((1, 2)).iter().zip(panels) {
        let mut chart = ChartBuilder::on(area)
            .caption(title, ("sans-serif", 18))
            .margin(14)
            .x_label_area_size(42)
            .y_label_area_size(64)
            .build_cartesian_2d(
                (1.0..10_000.0_f64).log_scale(),
                (1e-17..2.0_f64).log_scale(),
            )?;
        chart
            .configure_mesh()
            .x_desc("strain periods")
            .y_desc("error / edge of the cell")
            .x_label_formatter(&|x| format!("{x}"))
            .y_label_formatter(&|y| format!("{y:.0e}"))
            .light_line_style(WHITE)
            .draw()?;
        for (flow, colour) in flows.into_iter().zip(colours) {
            for scheme in ["closed form", "accumulated"] {
                let points: Vec<(f64, f64)> = rows
                    .iter()
                    .filter(|row| row.flow == flow && row.scheme == scheme)
                    .map(|row| (f64::from(row.periods), pick(row).max(1e-17)))
                    .collect();
                let filled = scheme == "closed form";
                let line = LineSeries::new(points.clone(), colour.stroke_width(1));
                chart
                    .draw_series(line)?
                    .label(format!("{flow}, {scheme}"))
                    .legend(move |(x, y)| {
                        Circle::new(
                            (x + 10, y),
                            4,
                            ShapeStyle {
                                color: colour.to_rgba(),
                                filled,
                                stroke_width: 1,
                            },
                        )
                    });
                chart.draw_series(points.into_iter().map(|point| {
                    Circle::new(
                        point,
                        3,
                        ShapeStyle {
                            color: colour.to_rgba(),
                            filled,
                            stroke_width: 1,
                        },
                    )
                }))?;
            }
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::MiddleRight)
            .border_style(BLACK.mix(0.2))
            .background_style(WHITE)
            .draw()?;
    }
    root.present()?;
    Ok(())
}
