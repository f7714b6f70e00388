//! Logarithmic charts of error against cost.

use crate::Problem;
use plotters::prelude::*;
use std::ops::Range;
use std::path::Path;

const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 90, 170),
    RGBColor(200, 80, 20),
    RGBColor(20, 130, 90),
    RGBColor(140, 70, 160),
    RGBColor(190, 150, 0),
    RGBColor(90, 90, 90),
    RGBColor(200, 40, 110),
];

/// Points joined by a line.
pub(crate) struct Curve {
    /// Empty for no entry in the legend.
    pub(crate) label: String,
    /// Which of the colours.
    pub(crate) colour: usize,
    /// Full points or rings.
    pub(crate) filled: bool,
    pub(crate) points: Vec<(f64, f64)>,
}

/// A chart with two logarithmic axes.
pub(crate) struct Panel {
    pub(crate) title: &'static str,
    pub(crate) x: &'static str,
    pub(crate) y: &'static str,
    pub(crate) legend: SeriesLabelPosition,
    pub(crate) curves: Vec<Curve>,
}

/// Draws panels side by side, at most three in a row, or four if that leaves no gap.
pub(crate) fn draw(path: &Path, panels: &[Panel]) -> Result<(), Problem> {
    let columns = match panels.len() {
        8 => 4,
        few => few.clamp(1, 3),
    };
    let rows = panels.len().div_ceil(columns);
    let size = (500 * columns as u32, 420 * rows as u32);
    let root = SVGBackend::new(path, size).into_drawing_area();
    root.fill(&WHITE)?;
    for (area, panel) in root.split_evenly((rows, columns)).iter().zip(panels) {
        let points = || panel.curves.iter().flat_map(|curve| &curve.points);
        let mut chart = ChartBuilder::on(area)
            .caption(panel.title, ("sans-serif", 18))
            .margin(14)
            .x_label_area_size(42)
            .y_label_area_size(64)
            .build_cartesian_2d(
                spread(points().map(|(x, _)| *x)).log_scale(),
                spread(points().map(|(_, y)| *y)).log_scale(),
            )?;
        chart
            .configure_mesh()
            .x_desc(panel.x)
            .y_desc(panel.y)
            .x_label_formatter(&|x| format!("{x:.0e}"))
            .y_label_formatter(&|y| format!("{y:.0e}"))
            .light_line_style(WHITE)
            .draw()?;
        for curve in &panel.curves {
            let colour = COLOURS[curve.colour % COLOURS.len()];
            let style = ShapeStyle {
                color: colour.to_rgba(),
                filled: curve.filled,
                stroke_width: 1,
            };
            let points = curve.points.iter().copied();
            let line = LineSeries::new(points.clone(), colour.stroke_width(1));
            let series = chart.draw_series(line)?;
            if !curve.label.is_empty() {
                series
                    .label(curve.label.clone())
                    .legend(move |(x, y)| Circle::new((x + 10, y), 4, style));
            }
            chart.draw_series(points.map(|point| Circle::new(point, 3, style)))?;
        }
        if panel.curves.iter().all(|curve| curve.label.is_empty()) {
            continue;
        }
        chart
            .configure_series_labels()
            .position(panel.legend.clone())
            .border_style(BLACK.mix(0.2))
            .background_style(WHITE.mix(0.85))
            .draw()?;
    }
    root.present()?;
    Ok(())
}

/// The order of a method: the slope of the logarithms, by least squares.
pub(crate) fn slope(points: &[(f64, f64)]) -> f64 {
    let logs = points.iter().map(|(x, y)| (x.ln(), y.ln()));
    let n = points.len() as f64;
    let (sx, sy) = logs
        .clone()
        .fold((0.0, 0.0), |(a, b), (x, y)| (a + x, b + y));
    let (mx, my) = (sx / n, sy / n);
    let (mut above, mut below) = (0.0, 0.0);
    for (x, y) in logs {
        above += (x - mx) * (y - my);
        below += (x - mx) * (x - mx);
    }
    above / below
}

/// Whole decades around all numbers.
fn spread(values: impl Iterator<Item = f64>) -> Range<f64> {
    let positive = values.filter(|x| *x > 0.0 && x.is_finite());
    let (least, most) = positive.fold((f64::MAX, f64::MIN_POSITIVE), |(a, b), x| {
        (a.min(x), b.max(x))
    });
    if least > most {
        return 0.1..10.0;
    }
    let decade = |exponent: f64| 10.0_f64.powf(exponent);
    decade(least.log10().floor())..decade(most.log10().ceil().max(least.log10().floor() + 1.0))
}
