//! The picture of a sweep.

use crate::Problem;
use crate::options::Flow;
use crate::sweep::{Row, ideal_extension, ideal_squared_radius, of_concentrations};
use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;
use std::ops::Range;
use std::path::Path;
use zimm::prelude::*;

/// Three quantities against the Deborah number.
pub(crate) fn draw(path: &Path, flow: Flow, rows: &[Row]) -> Result<(), Problem> {
    let root = SVGBackend::new(path, (1200, 420)).into_drawing_area();
    root.fill(&WHITE)?;
    let [first, second, third] = &root.split_evenly((1, 3))[..] else {
        return Err("a picture of three panels".into());
    };
    let rising = |title, value| Panel {
        title,
        value,
        at_rest: None,
        mark: None,
        legend: SeriesLabelPosition::UpperLeft,
    };
    let falling = |title, value| Panel {
        legend: SeriesLabelPosition::LowerLeft,
        ..rising(title, value)
    };
    if flow == Flow::Extension {
        let extension = Panel {
            at_rest: Some(ideal_extension()),
            mark: Some(0.5),
            ..rising("Extension along x over contour length", |row| row.extension)
        };
        extension.draw(first, rows, 0.0..1.0, 0.0..1.0)?;
        let title = "Springs, (σ_xx - σ_yy) / rate over n kT λ";
        rising(title, |row| row.viscosity).draw_logarithmic(second, rows)?;
    } else {
        let title = "Springs, (σ_xx - σ_yy) / rate² over n kT λ²";
        falling(title, |row| row.psi_1).draw_logarithmic(first, rows)?;
        let title = "Springs, σ_xy / rate over n kT λ";
        falling(title, |row| row.viscosity).draw_logarithmic(second, rows)?;
    }
    let radius = Panel {
        at_rest: Some(ideal_squared_radius()),
        ..rising("<R_g²> / r_c²", |row| row.squared_radius)
    };
    radius.draw_logarithmic(third, rows)?;
    root.present()?;
    Ok(())
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

const INK: RGBColor = RGBColor(40, 40, 40);
const GRID: RGBColor = RGBColor(225, 225, 225);

struct Panel {
    title: &'static str,
    value: fn(&Row) -> Mean,
    /// What ideal chains have, dashed.
    at_rest: Option<f64>,
    /// A Deborah number to look at, dashed.
    mark: Option<f64>,
    legend: SeriesLabelPosition,
}

impl Panel {
    fn draw_logarithmic(&self, area: &Area<'_>, rows: &[Row]) -> Result<(), Problem> {
        let values = rows.iter().map(|row| (self.value)(row).value);
        let bounds = spread(values.chain(self.at_rest), 1.5);
        let axis = bounds.clone().log_scale().with_key_points(ticks(&bounds));
        self.draw(area, rows, bounds, axis)
    }

    /// `bounds` are those of the axis `y`.
    fn draw<Y>(
        &self,
        area: &Area<'_>,
        rows: &[Row],
        bounds: Range<f64>,
        y: Y,
    ) -> Result<(), Problem>
    where
        Y: AsRangedCoord<Value = f64>,
        Y::CoordDescType: ValueFormatter<f64> + Ranged<ValueType = f64>,
    {
        let x = spread(rows.iter().map(|row| row.deborah), 1.25);
        let mut chart = ChartBuilder::on(area)
            .caption(self.title, ("sans-serif", 16).with_color(INK))
            .margin(10)
            .x_label_area_size(42)
            .y_label_area_size(48)
            .build_cartesian_2d(x.clone().log_scale().with_key_points(ticks(&x)), y)?;
        chart
            .configure_mesh()
            .x_desc("De = λ × rate, λ = 90 τ")
            .bold_line_style(GRID)
            .light_line_style(WHITE)
            .axis_style(INK)
            .label_style(("sans-serif", 13).with_color(INK))
            .x_label_formatter(&|x| plain(*x))
            .y_label_formatter(&|y| plain(*y))
            .draw()?;
        if let Some(level) = self.at_rest {
            let ends = [(x.start, level), (x.end, level)];
            chart
                .draw_series(DashedLineSeries::new(ends, 6, 5, INK.stroke_width(1)))?
                .label("ideal chains at rest")
                .legend(|(x, y)| PathElement::new([(x, y), (x + 18, y)], INK.stroke_width(1)));
        }
        if let Some(mark) = self.mark.filter(|mark| x.contains(mark)) {
            let ends = [(mark, bounds.start), (mark, bounds.end)];
            chart.draw_series(DashedLineSeries::new(ends, 6, 5, INK.stroke_width(1)))?;
        }
        let all = of_concentrations(rows).count().max(2) - 1;
        for (number, rows) in of_concentrations(rows).enumerate() {
            // From blue to red.
            let colour = HSLColor(0.58 * (1.0 - number as f64 / all as f64), 0.8, 0.4);
            let inside = |row: &&Row| bounds.contains(&(self.value)(row).value);
            let points = || {
                let rows = rows.iter().filter(inside);
                rows.map(|row| (row.deborah, (self.value)(row)))
            };
            let line = points().map(|(x, mean)| (x, mean.value));
            chart.draw_series(LineSeries::new(line, colour.stroke_width(1)))?;
            let bars = points().map(|(x, mean)| {
                let (y, error) = (mean.value, mean.at_least());
                let (low, high) = ((y - error).max(bounds.start), (y + error).min(bounds.end));
                ErrorBar::new_vertical(x, low, y, high, colour.filled(), 8)
            });
            let concentration = rows.first().map_or(0.0, |row| row.concentration);
            chart
                .draw_series(bars)?
                .label(format!("c/c* = {concentration}"))
                .legend(move |(x, y)| Circle::new((x + 9, y), 4, colour.filled()));
        }
        chart
            .configure_series_labels()
            .position(self.legend.clone())
            .label_font(("sans-serif", 13).with_color(INK))
            .draw()?;
        Ok(())
    }
}

/// The range of all numbers above zero, widened by a factor at either end.
fn spread(values: impl Iterator<Item = f64>, factor: f64) -> Range<f64> {
    let positive = values.filter(|x| *x > 0.0 && x.is_finite());
    let (least, most) = positive.fold((f64::MAX, 0.0), |(a, b), x| (x.min(a), x.max(b)));
    if least <= most {
        least / factor..most * factor
    } else {
        0.1..10.0
    }
}

/// A number without what rounding has left.
fn plain(x: f64) -> String {
    ((1e6 * x).round() / 1e6).to_string()
}

/// Round numbers for a logarithmic axis.
fn ticks(range: &Range<f64>) -> Vec<f64> {
    let digits: &[f64] = match range.end / range.start {
        ratio if ratio < 10.0 => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0],
        ratio if ratio < 300.0 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let powers = range.start.log10().floor() as i32..=range.end.log10().ceil() as i32;
    let numbers =
        powers.flat_map(|power| digits.iter().map(move |digit| digit * 10.0_f64.powi(power)));
    numbers.filter(|x| range.contains(x)).collect()
}
