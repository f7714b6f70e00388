//! What reverse Poiseuille flow has found: table and picture.

use super::channel::{CENTRE, Row, Run};
use super::{DENSITY, KT};
use crate::Problem;
use crate::options::Options;
use crate::panel::{INK, Panel, Points, Series, spread};
use crate::text::aligned;
use plotters::prelude::*;
use std::path::Path;
use zimm::prelude::*;

const SIZE: (u32, u32) = (1000, 780);

/// What the columns are, and their units.
const COLUMNS: [[&str; 2]; 8] = [
    ["force", "kT/r_c"],
    ["y", "r_c"],
    ["rate", "1/tau"],
    ["eta", "kT tau/r_c^3"],
    ["Psi_1", "kT tau^2/r_c^3"],
    ["Psi_2", "kT tau^2/r_c^3"],
    ["n_p / mean", ""],
    ["T", "kT"],
];

/// The table and how to read it.
pub(crate) fn summary(rows: &[Row], runs: &[Run]) -> String {
    let mut cells = [0, 1]
        .map(|k| COLUMNS.map(|column| column[k].to_string()))
        .to_vec();
    for row in rows {
        let means = row.means().map(|(_, mean)| format!("{mean:#}"));
        let [rate, viscosity, psi1, psi2, concentration, temperature] = means;
        let (force, distance) = (row.force.to_string(), row.distance.to_string());
        cells.push([
            force,
            distance,
            rate,
            viscosity,
            psi1,
            psi2,
            concentration,
            temperature,
        ]);
    }
    let mut text = aligned(&cells);
    for run in runs {
        text += &of_run(run);
    }
    text + "y: distance from the centre line; n_p: beads of molecules per volume, which the flow may move across it\n\
        errors: 0.912(12) is 0.912 +- 0.012; (>12): the run is too short, the error may be larger\n"
}

fn of_run(run: &Run) -> String {
    let worst = |off: &dyn Fn(&ChannelLayer) -> f64| run.layers.iter().map(off).fold(0.0, f64::max);
    let uneven = 100.0 * worst(&|layer| (layer.density.value / DENSITY - 1.0).abs());
    let off =
        worst(&|layer| (layer.shear.value - layer.imposed.value).abs() / layer.shear.at_least());
    let centre = match run.channel.zero_shear(&run.average, CENTRE) {
        Ok(ZeroShear {
            viscosity,
            relaxation_time,
            ..
        }) => format!("eta_0 = {viscosity:#}, Psi_1 / 2 eta_0 = {relaxation_time:#} tau"),
        Err(AnalysisError::Denominator { .. }) => "the velocity is flat within four errors".into(),
        Err(problem) => problem.to_string(),
    };
    format!(
        "force {}: near the centre line {centre}; density within {uneven:.1} %, stress within {off:.1} errors of f n y\n",
        run.force
    )
}

/// Draws viscosity, normal stress, where the molecules are, and temperature against the rate, a colour for each force.
pub(crate) fn draw(path: &Path, options: &Options, rows: &[Row]) -> Result<(), Problem> {
    let root = SVGBackend::new(path, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let (heading, body) = root.split_vertically(44);
    let style = TextStyle::from(("sans-serif", 22)).color(&INK);
    let title = format!(
        "FENE {} (b = 50) in a DPD solvent, {}",
        options.solute.title(),
        options.flow.title()
    );
    heading.draw_text(&title, &style, (24, 14))?;
    let panels = body.margin(0, 8, 8, 16).split_evenly((2, 2));
    let rates = spread(rows.iter().map(|row| row.rate.value), [1.5, 1.5]);
    let each = |part: fn(&Row) -> Mean| -> Vec<Series> {
        let series = |(k, force): (usize, &f64)| {
            let of_force = rows.iter().filter(|row| row.force == *force);
            let points: Points = of_force.map(|row| (row.rate.value, part(row))).collect();
            Series::new(format!("f = {force}"), colour(k), points)
        };
        options.forces.iter().enumerate().map(series).collect()
    };
    let viscosity = each(|row| row.viscosity);
    panel(
        "Viscosity, in kT τ / r_c³",
        &viscosity,
        None,
        SeriesLabelPosition::UpperRight,
    )
    .draw_logarithmic(&panels[0], &rates)?;
    let psi1 = each(|row| row.psi1);
    panel(
        "Ψ₁ = (σ_xx - σ_yy) / rate², in kT τ² / r_c³",
        &psi1,
        None,
        SeriesLabelPosition::UpperRight,
    )
    .draw_logarithmic(&panels[1], &rates)?;
    for (area, title, part, level, least) in [
        (
            &panels[2],
            "Beads of molecules per volume, over their mean",
            (|row| row.concentration) as fn(&Row) -> Mean,
            ("everywhere alike", 1.0),
            0.05,
        ),
        (
            &panels[3],
            "Kinetic temperature, kT",
            |row| row.temperature,
            ("thermostat", KT),
            0.02,
        ),
    ] {
        let series = each(part);
        let points = series.iter().flat_map(|series| &series.points);
        let ends = points.map(|(_, mean)| (mean.value - level.1).abs() + mean.at_least());
        let off = 1.2 * ends.fold(least, f64::max);
        let bounds = level.1 - off..level.1 + off;
        panel(title, &series, Some(level), SeriesLabelPosition::UpperLeft).draw(
            area,
            &rates,
            bounds.clone(),
            bounds,
        )?;
    }
    root.present()?;
    Ok(())
}

fn panel<'a>(
    title: &'static str,
    series: &'a [Series],
    level: Option<(&'static str, f64)>,
    legend: SeriesLabelPosition,
) -> Panel<'a> {
    Panel {
        abscissa: "shear rate × τ",
        title,
        series,
        theory: ("", Vec::new()),
        level,
        legend,
        room: [1.3, 1.3],
    }
}

fn colour(force: usize) -> RGBColor {
    [
        RGBColor(0, 90, 170),
        RGBColor(205, 85, 20),
        RGBColor(20, 130, 90),
        RGBColor(140, 70, 160),
    ][force % 4]
}
