//! The picture: four panels against the Deborah number.

use super::KT;
use super::reference::{self, Dumbbell, EXTENSION_AT_REST};
use super::report::Row;
use crate::Problem;
use crate::flow::Flow;
use crate::options::Options;
use crate::panel::{INK, POLYMER, Panel, Points, SOLUTION, Series, spread};
use plotters::prelude::*;
use std::path::Path;
use zimm::prelude::*;

const SIZE: (u32, u32) = (1000, 780);
const THEORY: &str = "theory: no interaction between beads";

/// Draws viscosity, normal stress, extension and temperature, with error bars and theory. `modulus` is n kT of the
/// molecules.
pub(crate) fn draw(
    path: &Path,
    options: &Options,
    rows: &[Row],
    modulus: f64,
) -> Result<(), Problem> {
    let (flow, solute) = (options.flow, options.solute);
    let dumbbells = solute.chain == 2;
    let either = |of_dumbbells, of_chains| if dumbbells { of_dumbbells } else { of_chains };
    let abscissa = either("De = λ_H × rate", "De = λ_1 × rate");
    let root = SVGBackend::new(path, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let (heading, body) = root.split_vertically(44);
    let style = TextStyle::from(("sans-serif", 22)).color(&INK);
    heading.draw_text(
        &format!(
            "FENE {} (b = 50) in a DPD solvent, {}",
            solute.title(),
            flow.title()
        ),
        &style,
        (24, 14),
    )?;
    // In shear the curves fall to the right, in other flows they rise.
    let thins = flow == Flow::Shear;
    let panels = body.margin(0, 8, 8, 16).split_evenly((2, 2));

    let along = |part: fn(&Row) -> Mean| -> Points {
        rows.iter().map(|row| (row.deborah, part(row))).collect()
    };
    let reduced_psi1 = |row: &Row| row.psi1.times((row.rate / row.deborah).powi(2) / modulus);
    let deborahs = spread(rows.iter().map(|row| row.deborah), [1.5, 1.5]);
    let curve = |part: fn(&Dumbbell) -> f64| -> Vec<(f64, f64)> {
        let at =
            |k: u32| deborahs.start * (deborahs.end / deborahs.start).powf(f64::from(k) / 60.0);
        (0..=60)
            .filter(|_| dumbbells)
            .filter_map(|k| Some((at(k), part(&reference::dumbbell(flow, at(k))?))))
            .collect()
    };

    Panel {
        abscissa,
        title: "Viscosity",
        series: &[
            Series::new(
                "solution: η in kT τ / r_c³",
                SOLUTION,
                along(|row| row.viscosity),
            ),
            Series::new(
                either("polymer: η_p / n kT λ_H", "polymer: η_p / n kT λ_1"),
                POLYMER,
                along(|row| row.polymer_viscosity),
            ),
        ],
        theory: (THEORY, curve(|t| t.viscosity)),
        level: None,
        legend: if thins {
            SeriesLabelPosition::MiddleLeft
        } else {
            SeriesLabelPosition::UpperLeft
        },
        room: [1.15, if thins { 1.15 } else { 2.5 }],
    }
    .draw_logarithmic(&panels[0], &deborahs)?;
    Panel {
        abscissa,
        title: either(
            "Ψ₁ = (σ_xx - σ_yy) / rate², over n kT λ_H²",
            "Ψ₁ = (σ_xx - σ_yy) / rate², over n kT λ_1²",
        ),
        series: &[
            Series::new(
                "solution",
                SOLUTION,
                rows.iter()
                    .map(|row| (row.deborah, reduced_psi1(row)))
                    .collect(),
            ),
            Series::new("polymer", POLYMER, along(|row| row.polymer_psi1)),
        ],
        theory: (THEORY, curve(|t| t.psi1)),
        level: None,
        legend: if thins {
            SeriesLabelPosition::LowerLeft
        } else {
            SeriesLabelPosition::UpperRight
        },
        room: if thins { [2.0, 1.3] } else { [1.3, 1.5] },
    }
    .draw_logarithmic(&panels[1], &deborahs)?;
    Panel {
        abscissa,
        title: either(
            "Extension of the dumbbells, <Q²> / Q₀²",
            "Extension of the chains, <R_e²> / L²",
        ),
        series: &[Series::new("polymer", POLYMER, along(|row| row.extension))],
        theory: (THEORY, curve(|t| t.extension)),
        level: Some((
            either("at rest: 3 / (b + 5)", "at rest: 3 / (b + 5)(N - 1)"),
            EXTENSION_AT_REST / solute.springs(),
        )),
        legend: SeriesLabelPosition::UpperLeft,
        room: [1.2, 1.5],
    }
    .draw_logarithmic(&panels[2], &deborahs)?;
    let temperature = Series::new("solution", SOLUTION, along(|row| row.temperature));
    let ends = temperature
        .points
        .iter()
        .map(|(_, mean)| (mean.value - KT).abs() + mean.at_least());
    let off = 1.2 * ends.fold(0.02, f64::max);
    Panel {
        abscissa,
        title: "Kinetic temperature, kT",
        series: &[temperature],
        theory: (THEORY, Vec::new()),
        level: Some(("thermostat", KT)),
        legend: SeriesLabelPosition::UpperLeft,
        room: [1.0, 1.0],
    }
    .draw(
        &panels[3],
        &deborahs,
        KT - off..KT + off,
        KT - off..KT + off,
    )?;
    root.present()?;
    Ok(())
}
