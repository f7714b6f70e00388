//! Panels of a picture: points with error bars, curves of theory, logarithmic axes.

use crate::Problem;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;
use std::ops::Range;
use zimm::prelude::*;

pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(crate) type Points = Vec<(f64, Mean)>;

pub(crate) const INK: RGBColor = RGBColor(40, 40, 40);
const GRID: RGBColor = RGBColor(225, 225, 225);
pub(crate) const POLYMER: RGBColor = RGBColor(0, 90, 170);
pub(crate) const SOLUTION: RGBColor = RGBColor(205, 85, 20);

/// Points of one colour.
pub(crate) struct Series {
    label: String,
    colour: RGBColor,
    pub(crate) points: Points,
}

impl Series {
    pub(crate) fn new(label: impl Into<String>, colour: RGBColor, points: Points) -> Self {
        Self {
            label: label.into(),
            colour,
            points,
        }
    }
}

/// What one panel shows.
pub(crate) struct Panel<'a> {
    pub(crate) abscissa: &'static str,
    pub(crate) title: &'static str,
    pub(crate) series: &'a [Series],
    /// What the curve is called, and the curve.
    pub(crate) theory: (&'static str, Vec<(f64, f64)>),
    pub(crate) level: Option<(&'static str, f64)>,
    pub(crate) legend: SeriesLabelPosition,
    /// Factors by which a logarithmic axis reaches beyond the values, for the legend.
    pub(crate) room: [f64; 2],
}

impl Panel<'_> {
    pub(crate) fn draw_logarithmic(&self, area: &Area<'_>, x: &Range<f64>) -> Result<(), Problem> {
        let points = self.series.iter().flat_map(|series| &series.points);
        let values = points.map(|(_, mean)| mean.value);
        let theory = self.theory.1.iter().map(|(_, y)| *y);
        let bounds = spread(
            values.chain(theory).chain(self.level.map(|(_, y)| y)),
            self.room,
        );
        let axis = bounds.clone().log_scale().with_key_points(ticks(&bounds));
        self.draw(area, x, bounds, axis)
    }

    pub(crate) fn draw<Y>(
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
            .x_desc(self.abscissa)
            .bold_line_style(GRID)
            .light_line_style(WHITE)
            .axis_style(INK)
            .label_style(("sans-serif", 14).with_color(INK))
            .x_label_formatter(&|x| plain(*x))
            .y_label_formatter(&|y| plain(*y))
            .draw()?;
        let (label, curve) = &self.theory;
        if !curve.is_empty() {
            chart
                .draw_series(LineSeries::new(curve.iter().copied(), INK.stroke_width(2)))?
                .label(*label)
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
                .label(label)
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
}

/// The range of all numbers above zero, widened by a factor at either end.
pub(crate) fn spread(values: impl Iterator<Item = f64>, [below, above]: [f64; 2]) -> Range<f64> {
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
