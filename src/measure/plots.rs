//! Plots as SVG.

use plotters::prelude::*;

use super::page::escaped;
use crate::error::{Error, Result};

/// Width and height of a plot, pixels; it scales.
const SIZE: (u32, u32) = (560, 380);

/// Colours that stay apart for those who see few [Okabe and Ito 2008].
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(90, 90, 90),
];

/// A value, and the smallest and largest that were measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Along x.
    pub x: f64,
    /// Along y.
    pub y: f64,
    /// Smallest and largest y, where they differ.
    pub spread: Option<(f64, f64)>,
}

/// Points of one kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// For the legend; none where it is empty.
    pub name: String,
    /// The points.
    pub points: Vec<Point>,
    /// What a line joins, in this order; nothing where it is empty.
    pub line: Vec<Point>,
}

/// What a plot shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Plot {
    /// Above it.
    pub title: String,
    /// What x is.
    pub x: Axis,
    /// What y is.
    pub y: Axis,
    /// The points.
    pub series: Vec<Series>,
}

/// An axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// What it is, with its unit.
    pub name: String,
    /// Where values have names and no size: the name of 0, 1, 2 ...
    pub names: Vec<String>,
    /// Whether equal ratios are equally far apart; values are above 0 then.
    pub logarithmic: bool,
}

impl Axis {
    /// An axis of numbers.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            names: Vec::new(),
            logarithmic: false,
        }
    }

    /// Where a value is drawn.
    fn place(&self, value: f64) -> f64 {
        if self.logarithmic {
            value.max(1e-9).log10()
        } else {
            value
        }
    }

    /// The text beside a place.
    fn label(&self, place: f64) -> String {
        if !self.names.is_empty() {
            let at = (place.round() - place).abs() < 1e-6 && place > -0.5;
            let name = self.names.get(place.round() as usize).filter(|_| at);
            return name.cloned().unwrap_or_default();
        }
        let value = if self.logarithmic {
            10f64.powf(place)
        } else {
            place
        };
        let digits = match value.abs() {
            v if v >= 100.0 || v <= 0.0 => 0,
            v if v >= 1.0 => 1,
            v if v >= 0.1 => 2,
            _ => 3,
        };
        let text = format!("{value:.digits$}");
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    }

    /// The span of these values, with a little room.
    fn span(&self, values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for place in values.map(|v| self.place(v)).filter(|v| v.is_finite()) {
            (low, high) = (low.min(place), high.max(place));
        }
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        let room = if self.names.is_empty() {
            ((high - low) * 0.06).max(high.abs() * 1e-3).max(1e-6)
        } else {
            0.5
        };
        low - room..high + room
    }
}

impl Plot {
    /// The plot as SVG, its names escaped.
    ///
    /// # Errors
    /// [`Error::Setting`] where it cannot be drawn.
    pub fn svg(&self) -> Result<String> {
        let mut svg = String::new();
        self.draw(&mut svg)
            .map_err(|problem| Error::Setting(format!("a plot cannot be drawn: {problem}")))?;
        // It scales with the page; the description is for those who do not see it.
        let (width, height) = SIZE;
        let scaled = format!(
            "viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{}\"",
            escaped(&self.title)
        );
        let start =
            format!("width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\"");
        Ok(svg.replacen(&start, &scaled, 1))
    }

    fn draw(&self, svg: &mut String) -> std::result::Result<(), Box<dyn std::error::Error>> {
        let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let points = || self.series.iter().flat_map(|s| &s.points);
        let y_values = points().flat_map(|p| {
            let (low, high) = p.spread.unwrap_or((p.y, p.y));
            [p.y, low, high]
        });
        let mut chart = ChartBuilder::on(&root)
            .caption(crate::text::printable(&self.title), ("sans-serif", 18))
            .margin(10)
            .x_label_area_size(44)
            .y_label_area_size(60)
            .build_cartesian_2d(self.x.span(points().map(|p| p.x)), self.y.span(y_values))?;
        let x_labels = if self.x.names.is_empty() {
            8
        } else {
            2 * self.x.names.len() + 1
        };
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .x_desc(crate::text::printable(&self.x.name))
            .y_desc(crate::text::printable(&self.y.name))
            .x_labels(x_labels)
            .x_label_formatter(&|place| self.x.label(*place))
            .y_label_formatter(&|place| self.y.label(*place))
            .label_style(("sans-serif", 13))
            .draw()?;
        let place = |p: &Point, y: f64| (self.x.place(p.x), self.y.place(y));
        for (series, colour) in self.series.iter().zip(COLOURS.iter().cycle()) {
            for point in &series.points {
                if let Some((low, high)) = point.spread {
                    let bar = [place(point, low), place(point, high)];
                    chart.draw_series(LineSeries::new(bar, colour.mix(0.5).stroke_width(2)))?;
                }
            }
            if !series.line.is_empty() {
                let line = series.line.iter().map(|p| place(p, p.y));
                chart.draw_series(LineSeries::new(line, colour.stroke_width(2)))?;
            }
            let dots = series
                .points
                .iter()
                .map(|p| Circle::new(place(p, p.y), 4, colour.filled()));
            let drawn = chart.draw_series(dots)?;
            if !series.name.is_empty() {
                drawn
                    .label(crate::text::printable(&series.name))
                    .legend(|(x, y)| Circle::new((x + 8, y), 4, colour.filled()));
            }
        }
        if self.series.iter().any(|s| !s.name.is_empty()) {
            chart
                .configure_series_labels()
                .position(SeriesLabelPosition::MiddleRight)
                .background_style(WHITE.mix(0.8))
                .border_style(RGBColor(200, 200, 200))
                .label_font(("sans-serif", 13))
                .draw()?;
        }
        root.present()?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_is_drawn_and_names_are_escaped() {
        let point = |x: f64| Point {
            x,
            y: 10f64.powf(x),
            spread: Some((1.0, 2e3)),
        };
        let plot = Plot {
            title: "<b>".to_owned(),
            x: Axis {
                names: vec!["a&b".to_owned(), "c".to_owned()],
                ..Axis::new("\"x\"")
            },
            y: Axis {
                logarithmic: true,
                ..Axis::new("ms")
            },
            series: vec![Series {
                name: "<i>".to_owned(),
                points: vec![point(0.0), point(1.0)],
                line: vec![point(0.0), point(1.0)],
            }],
        };
        let svg = plot.svg().unwrap_or_default();
        assert!(
            svg.contains("viewBox=\"0 0 560 380\" role=\"img\""),
            "{svg}"
        );
        assert!(
            !svg.contains("<b>") && !svg.contains("<i>") && svg.contains("a&amp;b"),
            "{svg}"
        );
        assert_eq!(
            svg.matches("<circle").count(),
            3,
            "two points and the legend"
        );
    }

    #[test]
    fn labels_have_no_more_digits_than_they_need() {
        let axis = Axis::new("x");
        assert_eq!(
            [0.0, 0.25, 1.5, 20.0, 1200.0].map(|v| axis.label(v)),
            ["0", "0.25", "1.5", "20", "1200"]
        );
    }
}
