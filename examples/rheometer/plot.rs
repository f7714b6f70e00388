//! The picture: four panels against the Deborah number.

use crate::flow::Flow;
use crate::reference::{self, Dumbbell, EXTENSION_AT_REST};
use crate::report::Row;
use crate::{KT, Problem};
use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;
use std::ops::Range;
use std::path::Path;
use zimm::prelude::*;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Points = Vec<(f64, Mean)>;

const INK: RGBColor = RGBColor(40, 40, 40);
const GRID: RGBColor = RGBColor(225, 225, 225);
const POLYMER: RGBColor = RGBColor(0, 90, 170);
const SOLUTION: RGBColor = RGBColor(205, 85, 20);
const SIZE: (u32, u32) = (1000, 780);

/// Draws viscosity, normal stress, extension and temperature, with error bars and theory. `modulus` is n kT of the
/// dumbbells.
pub(crate) fn draw(path: &Path, flow: Flow, rows: &[Row], modulus: f64) -> Result<(), Problem> {
    let root = SVGBackend::new(path, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let (heading, body) = root.split_vertically(44);
    let style = TextStyle::from(("sans-serif", 22)).color(&INK);
    heading.draw_text(
        &format!("FENE dumbbells (b = 50) in a DPD solvent, {}", flow.title()),
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

    Panel {
        flow,
        title: "Viscosity",
        series: &[
            Series::new(
                "solution: η in kT τ / r_c³",
                SOLUTION,
                along(|row| row.viscosity),
            ),
            Series::new(
                "polymer: η_p / n kT λ_H",
                POLYMER,
                along(|row| row.polymer_viscosity),
            ),
        ],
        theory: Some(|t| t.viscosity),
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
        flow,
        title: "Ψ₁ = (σ_xx - σ_yy) / rate², over n kT λ_H²",
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
        theory: Some(|t| t.psi1),
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
        flow,
        title: "Extension of the dumbbells, <Q²> / Q₀²",
        series: &[Series::new("polymer", POLYMER, along(|row| row.extension))],
        theory: Some(|t| t.extension),
        level: Some(("at rest: 3 / (b + 5)", EXTENSION_AT_REST)),
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
        flow,
        title: "Kinetic temperature, kT",
        series: &[temperature],
        theory: None,
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

/// Points of one colour.
struct Series {
    label: &'static str,
    colour: RGBColor,
    points: Points,
}

impl Series {
    fn new(label: &'static str, colour: RGBColor, points: Points) -> Self {
        Self {
            label,
            colour,
            points,
        }
    }
}

/// What one panel shows.
struct Panel<'a> {
    flow: Flow,
    title: &'static str,
    series: &'a [Series],
    theory: Option<fn(&Dumbbell) -> f64>,
    level: Option<(&'static str, f64)>,
    legend: SeriesLabelPosition,
    /// Factors by which a logarithmic axis reaches beyond the values, for the legend.
    room: [f64; 2],
}

impl Panel<'_> {
    fn draw_logarithmic(&self, area: &Area<'_>, x: &Range<f64>) -> Result<(), Problem> {
        let points = self.series.iter().flat_map(|series| &series.points);
        let values = points.map(|(_, mean)| mean.value);
        let theory = self.curve(x).into_iter().map(|(_, y)| y);
        let bounds = spread(
            values.chain(theory).chain(self.level.map(|(_, y)| y)),
            self.room,
        );
        let axis = bounds.clone().log_scale().with_key_points(ticks(&bounds));
        self.draw(area, x, bounds, axis)
    }

    fn draw<Y>(
        &self,
        area: &Area<'_>,
        x: &Range<f64>,
        bounds: Range<f64>,
        y: Y,
    ) -> Result<(), Problem>
    where
        Y: AsRangedCoord<Value = f64>,
        Y::CoordDescType: ValueFormatter<f64> + Ranged<ValueType = f64>,
    {
        let mut chart = ChartBuilder::on(area)
            .caption(self.title, ("sans-serif", 17).with_color(INK))
            .margin(10)
            .x_label_area_size(42)
            .y_label_area_size(56)
            .build_cartesian_2d(x.clone().log_scale().with_key_points(ticks(x)), y)?;
        chart
            .configure_mesh()
            .x_desc("De = λ_H × rate")
            .bold_line_style(GRID)
            .light_line_style(WHITE)
            .axis_style(INK)
            .label_style(("sans-serif", 14).with_color(INK))
            .x_label_formatter(&|x| plain(*x))
            .y_label_formatter(&|y| plain(*y))
            .draw()?;
        let curve = self.curve(x);
        if !curve.is_empty() {
            chart
                .draw_series(LineSeries::new(curve, INK.stroke_width(2)))?
                .label("theory: no interaction between beads")
                .legend(|(x, y)| PathElement::new([(x, y), (x + 18, y)], INK.stroke_width(2)));
        }
        if let Some((label, level)) = self.level {
            let ends = [(x.start, level), (x.end, level)];
            chart
                .draw_series(DashedLineSeries::new(ends, 6, 5, INK.stroke_width(1)))?
                .label(label)
                .legend(|(x, y)| PathElement::new([(x, y), (x + 18, y)], INK.stroke_width(1)));
        }
        for Series {
            label,
            colour,
            points,
        } in self.series
        {
            let colour = *colour;
            // A value at or below zero has no place on a logarithmic axis.
            let inside = points
                .iter()
                .filter(|(_, mean)| bounds.contains(&mean.value));
            let bars = inside.map(|(x, mean)| {
                let (y, error) = (mean.value, mean.at_least());
                let (low, high) = ((y - error).max(bounds.start), (y + error).min(bounds.end));
                ErrorBar::new_vertical(*x, low, y, high, colour.filled(), 9)
            });
            chart
                .draw_series(bars)?
                .label(*label)
                .legend(move |(x, y)| Circle::new((x + 9, y), 4, colour.filled()));
        }
        chart
            .configure_series_labels()
            .position(self.legend.clone())
            .background_style(WHITE.mix(0.85))
            .label_font(("sans-serif", 13).with_color(INK))
            .draw()?;
        Ok(())
    }

    /// Theory at many Deborah numbers.
    fn curve(&self, x: &Range<f64>) -> Vec<(f64, f64)> {
        let Some(part) = self.theory else {
            return Vec::new();
        };
        let at = |k: u32| x.start * (x.end / x.start).powf(f64::from(k) / 60.0);
        (0..=60)
            .filter_map(|k| Some((at(k), part(&reference::dumbbell(self.flow, at(k))?))))
            .collect()
    }
}

/// The range of all numbers above zero, widened by a factor at either end.
fn spread(values: impl Iterator<Item = f64>, [below, above]: [f64; 2]) -> Range<f64> {
    let positive = values.filter(|x| *x > 0.0 && x.is_finite());
    let (least, most) = positive.fold((f64::MAX, f64::MIN_POSITIVE), |(a, b), x| {
        (a.min(x), b.max(x))
    });
    if least <= most {
        least / below..most * above
    } else {
        0.1..10.0
    }
}

/// Round numbers for a logarithmic axis.
fn ticks(range: &Range<f64>) -> Vec<f64> {
    let decades = range.end / range.start;
    let digits: &[f64] = match decades {
        _ if decades < 10.0 => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0],
        _ if decades < 300.0 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let powers = range.start.log10().floor() as i32..=range.end.log10().ceil() as i32;
    let numbers =
        powers.flat_map(|power| digits.iter().map(move |digit| digit * 10.0_f64.powi(power)));
    numbers.filter(|x| range.contains(x)).collect()
}

/// A number without trailing zeros.
fn plain(x: f64) -> String {
    let text = format!("{x:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}
