//! The lattice of a planar flow through one period, frame by frame, as a strip of pictures.
//!
//! ```text
//! cargo run --release --example lattice_movie -- --flow mixed --mixedness 0.25
//! ```
//!
//! Dots are the images of one particle. Each keeps its colour as the flow carries it. The cell that is drawn is the
//! reduced one, the thin parallelogram the first cell, carried and never reduced. No image ever enters the circle; when
//! the period is over, all dots are where they were in the first frame, under other colours.

use clap::{Parser, ValueEnum};
use plotters::coord::Shift;
use plotters::prelude::*;
use std::error::Error;
use std::path::PathBuf;
use zimm::prelude::*;

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Flow {
    Shear,
    Extension,
    Mixed,
}

#[derive(Debug, Parser)]
struct Options {
    /// Kind of flow.
    #[arg(long, value_enum, default_value = "extension")]
    flow: Flow,
    /// From 0, shear, to 1, extension; for mixed flow.
    #[arg(long, default_value_t = 0.25)]
    mixedness: f64,
    /// Take the lattice with k = 3, also where others keep images further apart.
    #[arg(long)]
    classic: bool,
    /// Number of pictures in a period.
    #[arg(long, default_value_t = 9)]
    frames: u32,
    /// Where the picture goes; `target/lattice_movie/<flow>.svg` if not given.
    #[arg(long)]
    out: Option<PathBuf>,
}

/// Side of a frame in pixels, and half of it in edges of the cell.
const SIDE: u32 = 360;
const VIEW: f64 = 2.2;

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    let name = format!("{:?}", options.flow).to_lowercase();
    let out = options
        .out
        .clone()
        .unwrap_or_else(|| PathBuf::from(format!("target/lattice_movie/{name}.svg")));
    if let Some(folder) = out.parent() {
        std::fs::create_dir_all(folder)?;
    }
    // Strain at rate 1 is time.
    let (steady, neutral) = (Steady::new(1.0)?, 2.0);
    match options.flow {
        Flow::Shear => {
            let space = LeesEdwards::new(DVec3::new(1.0, 1.0, neutral), steady)?;
            film(&space, 1.0, space.min_image_distance(), &options, &out)?;
        }
        Flow::Extension => {
            let space = KraynikReinelt::new(1.0, neutral, steady)?;
            let period = space.map().hencky_period();
            film(&space, period, space.min_image_distance(), &options, &out)?;
        }
        Flow::Mixed => {
            let mixedness = options.mixedness;
            let map = if options.classic {
                PlanarMap::CLASSIC
            } else {
                PlanarMap::best(mixedness)
            };
            let space = PlanarMixed::with_map(map, 1.0, neutral, mixedness, steady)?;
            let period = space.map().hencky_period() / mixedness.sqrt();
            film(&space, period, space.min_image_distance(), &options, &out)?;
        }
    }
    println!("{}", out.display());
    Ok(())
}

fn film<B: Periodic>(
    space: &B,
    period: f64,
    apart: f64,
    options: &Options,
    out: &PathBuf,
) -> Result<(), Box<dyn Error>> {
    let columns = 5.min(options.frames + 1);
    let rows = (options.frames + 1).div_ceil(columns);
    let page = SVGBackend::new(out, (columns * SIDE, rows * (SIDE + 24))).into_drawing_area();
    page.fill(&WHITE)?;
    let frames = page.split_evenly((rows as usize, columns as usize));
    let start = space.lattice().basis();
    for (frame, k) in frames.iter().zip(0..=options.frames) {
        let time = period * f64::from(k) / f64::from(options.frames);
        let mut now = space.clone();
        now.advance(time);
        picture(frame, &now, space.carry(0.0, time) * start, apart, time)?;
    }
    page.present()?;
    Ok(())
}

fn picture<B: Periodic>(
    frame: &DrawingArea<SVGBackend<'_>, Shift>,
    space: &B,
    carried: DMat3,
    apart: f64,
    strain: f64,
) -> Result<(), Box<dyn Error>> {
    let (width, height) = frame.dim_in_pixel();
    let edge = Rectangle::new([(0, 0), (width as i32, height as i32)], BLACK.mix(0.15));
    frame.draw(&edge)?;
    let mut chart = ChartBuilder::on(frame)
        .caption(format!("strain {strain:.3}"), ("sans-serif", 18))
        .build_cartesian_2d(-VIEW..VIEW, -VIEW..VIEW)?;
    let cell = space.lattice().basis();
    // The two vectors in the plane.
    let in_plane = |h: DMat3| {
        let sides = [h.x_axis, h.y_axis, h.z_axis]
            .into_iter()
            .filter(|v| v.z.abs() < 0.5);
        sides.collect::<Vec<_>>()
    };
    let corners = |h: DMat3| -> Vec<(f64, f64)> {
        let sides = in_plane(h);
        let signs = [
            (-0.5, -0.5),
            (0.5, -0.5),
            (0.5, 0.5),
            (-0.5, 0.5),
            (-0.5, -0.5),
        ];
        let corner = |&(p, q): &(f64, f64)| p * sides[0] + q * sides[1];
        signs.iter().map(corner).map(|r| (r.x, r.y)).collect()
    };
    let blue = RGBColor(70, 110, 180);
    chart.draw_series([
        Polygon::new(corners(cell), blue.mix(0.18)).into_dyn(),
        PathElement::new(corners(cell), blue.stroke_width(2)).into_dyn(),
        PathElement::new(corners(carried), BLACK.mix(0.45)).into_dyn(),
    ])?;
    let around = (0..=90).map(|k| (f64::from(k) * 4.0).to_radians().sin_cos());
    let circle: Vec<(f64, f64)> = around
        .map(|(sin, cos)| (apart * cos, apart * sin))
        .collect();
    chart.draw_series([PathElement::new(circle, RED.stroke_width(1))])?;

    let sides = in_plane(cell);
    let mut dots = Vec::new();
    for (m, n) in (-40..=40).flat_map(|m| (-40..=40).map(move |n| (m, n))) {
        let r = f64::from(m) * sides[0] + f64::from(n) * sides[1];
        if r.x.abs() < VIEW && r.y.abs() < VIEW {
            let first = (carried.inverse() * r).round().as_ivec3();
            let hue = f64::from((first.x + 3 * first.y + 5 * first.z).rem_euclid(9)) / 9.0;
            let colour = if r.length() < 1e-9 {
                BLACK.to_rgba()
            } else {
                HSLColor(hue, 0.75, 0.45).to_rgba()
            };
            dots.push(Circle::new((r.x, r.y), 5, colour.filled()));
        }
    }
    chart.draw_series(dots)?;
    Ok(())
}
