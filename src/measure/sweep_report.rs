//! A sweep as plots, a page and lines of text.

use super::bench::Spread;
use super::compare_report::aligned;
use super::page::{Cell, Page};
use super::plots::{Axis, Plot, Point, Series};
use super::row::{NUMBERS, Row};
use super::sweep::Vary;
use crate::error::Result;

/// What is plotted against each key: the column, and what it is called.
const PLOTTED: [(&str, &str); 9] = [
    ("ratio", "frame, x reference"),
    ("mirrors_ms", "mirrors, ms"),
    ("search_ms", "search, ms"),
    ("hit_rate", "hit rate"),
    ("coverage_before", "coverage before closing"),
    ("coverage", "coverage"),
    ("albedo_psnr", "albedo, dB"),
    ("picture_psnr", "picture, dB"),
    ("picture_flip", "FLIP"),
];

/// Columns of the table.
const TABLE: [(&str, usize); 14] = [
    ("wall_ms", 1),
    ("ratio", 3),
    ("mirrors_ms", 1),
    ("search_ms", 1),
    ("regions", 0),
    ("hit_rate", 4),
    ("coverage_before", 4),
    ("coverage", 4),
    ("recall", 4),
    ("position_m_p95", 4),
    ("position_px_p95", 3),
    ("albedo_psnr", 2),
    ("picture_psnr", 2),
    ("picture_flip", 4),
];

/// Tables of the scene file; other keys are settings.
const SCENE_KEYS: [&str; 4] = ["cloud.", "camera.", "light.", "mirror."];

/// A sweep, finished or not.
pub struct SweepReport<'a> {
    title: &'a str,
    vary: &'a [Vary],
    combinations: Vec<Vec<Row>>,
}

/// A plot with the name of its file, without an ending.
pub struct NamedPlot {
    /// For a file: plain letters.
    pub name: String,
    /// The plot.
    pub plot: Plot,
}

impl<'a> SweepReport<'a> {
    /// Of these rows, in any order.
    pub fn new(title: &'a str, vary: &'a [Vary], rows: &[Row]) -> Self {
        let mut combinations: Vec<Vec<Row>> = Vec::new();
        let mut rows: Vec<&Row> = rows.iter().collect();
        rows.sort_by_key(|r| (r.combination, r.round));
        for row in rows {
            match combinations.last_mut() {
                Some(last)
                    if last
                        .first()
                        .is_some_and(|r| r.combination == row.combination) =>
                {
                    last.push(row.clone());
                }
                _ => combinations.push(vec![row.clone()]),
            }
        }
        Self {
            title,
            vary,
            combinations,
        }
    }

    /// A table for a terminal: the values that vary, time and quality; with a line break at the end.
    pub fn text(&self) -> String {
        let names = self
            .vary
            .iter()
            .map(|v| v.key.as_str())
            .collect::<Vec<_>>()
            .join(" ");
        let head = [
            &names,
            "ms",
            "x reference",
            "coverage %",
            "albedo dB",
            "FLIP",
        ];
        let mut rows = vec![head.map(crate::text::printable)];
        for frames in &self.combinations {
            let of = |name: &str, scale: f64, digits: usize| {
                format!("{:.digits$}", spread(frames, name).median * scale)
            };
            let values = frames
                .first()
                .map(|r| r.values.join(" "))
                .unwrap_or_default();
            rows.push([
                crate::text::printable(&values),
                of("wall_ms", 1.0, 1),
                of("ratio", 1.0, 3),
                of("coverage", 100.0, 2),
                of("albedo_psnr", 1.0, 2),
                of("picture_flip", 1.0, 4),
            ]);
        }
        aligned(&rows)
    }

    /// Every plot: what varies against each key, and quality against time.
    pub fn plots(&self) -> Vec<NamedPlot> {
        let mut plots = vec![NamedPlot {
            name: "trade".to_owned(),
            plot: self.trade(),
        }];
        for (index, vary) in self
            .vary
            .iter()
            .enumerate()
            .filter(|(_, v)| v.values.len() > 1)
        {
            for (column, what) in PLOTTED {
                let plot = self.against(index, column, what);
                let values = || plot.series.iter().flat_map(|s| &s.points).map(|p| p.y);
                let varies = values().any(|y| values().any(|other| y != other));
                if varies {
                    let key = vary.key.replace(|c: char| !c.is_ascii_alphanumeric(), "_");
                    plots.push(NamedPlot {
                        name: format!("{key}-{column}"),
                        plot,
                    });
                }
            }
        }
        plots
    }

    /// A column against a key, a line for each combination of the other keys.
    fn against(&self, key: usize, column: &str, what: &str) -> Plot {
        let vary = &self.vary[key];
        let numbers: Option<Vec<f64>> = vary.values.iter().map(|v| v.parse().ok()).collect();
        let mut series: Vec<Series> = Vec::new();
        for frames in &self.combinations {
            let Some(first) = frames.first() else {
                continue;
            };
            let value = first.values.get(key);
            let Some(place) = vary.values.iter().position(|v| Some(v) == value) else {
                continue;
            };
            let x = numbers.as_ref().map_or(place as f64, |n| n[place]);
            let others = (self.vary.iter().zip(&first.values).enumerate())
                .filter(|(i, (v, _))| *i != key && v.values.len() > 1)
                .map(|(_, (_, value))| value.as_str());
            let name = others.collect::<Vec<_>>().join(", ");
            let Spread { median, min, max } = spread(frames, column);
            let point = Point {
                x,
                y: median,
                spread: (max > min).then_some((min, max)),
            };
            match series.iter_mut().find(|s| s.name == name) {
                Some(line) => line.points.push(point),
                None => series.push(Series {
                    name,
                    points: vec![point],
                    line: Vec::new(),
                }),
            }
        }
        for line in &mut series {
            line.points.sort_by(|a, b| a.x.total_cmp(&b.x));
            if numbers.is_some() {
                line.line.clone_from(&line.points);
            }
        }
        Plot {
            title: what.to_owned(),
            x: Axis {
                names: if numbers.is_some() {
                    Vec::new()
                } else {
                    vary.values.clone()
                },
                ..Axis::new(&vary.key)
            },
            y: Axis::new(what),
            series,
        }
    }

    /// Quality against time, and those that nothing beats in both; what shows another scene is of another kind.
    fn trade(&self) -> Plot {
        let mut series: Vec<Series> = Vec::new();
        for frames in &self.combinations {
            let values = frames
                .first()
                .map(|r| r.values.as_slice())
                .unwrap_or_default();
            let of_scene = self.vary.iter().zip(values).filter(|(vary, _)| {
                vary.values.len() > 1 && SCENE_KEYS.iter().any(|table| vary.key.starts_with(table))
            });
            let name = of_scene
                .map(|(_, v)| v.as_str())
                .collect::<Vec<_>>()
                .join(", ");
            let point = Point {
                x: spread(frames, "ratio").median,
                y: spread(frames, "albedo_psnr").median.min(60.0),
                spread: None,
            };
            match series.iter_mut().find(|s| s.name == name) {
                Some(kind) => kind.points.push(point),
                None => series.push(Series {
                    name,
                    points: vec![point],
                    line: Vec::new(),
                }),
            }
        }
        for kind in &mut series {
            (kind.points).sort_by(|a, b| a.x.total_cmp(&b.x).then(b.y.total_cmp(&a.y)));
            for point in &kind.points {
                if kind.line.last().is_none_or(|best| point.y > best.y) {
                    kind.line.push(*point);
                }
            }
        }
        Plot {
            title: "Quality against time; lines join what nothing beats in both".to_owned(),
            x: Axis {
                logarithmic: true,
                ..Axis::new("frame, x reference")
            },
            y: Axis::new("albedo, dB (60 and more: no difference)"),
            series,
        }
    }

    /// The page.
    ///
    /// # Errors
    /// Where a plot cannot be drawn.
    pub fn page(&self) -> Result<Page> {
        let mut page = Page::new(self.title);
        if let Some(row) = self.combinations.iter().flatten().next() {
            page.paragraph(&format!(
                "{} combinations, up to {} frames each, in turn, after one that is not counted; catoptric {} on {}{}. Medians; bars reach from the smallest to the largest.",
                self.combinations.len(),
                self.combinations.iter().map(Vec::len).max().unwrap_or_default(),
                row.version,
                row.backend,
                row.adapter.as_ref().map(|a| format!(" ({a})")).unwrap_or_default()
            ));
        }
        page.figures(|page| {
            for named in self.plots() {
                page.plot(&named.plot.svg()?);
            }
            Ok(())
        })?;
        page.heading("All combinations");
        let mut columns: Vec<&str> = self.vary.iter().map(|v| v.key.as_str()).collect();
        columns.extend(TABLE.iter().map(|(name, _)| *name));
        let rows: Vec<Vec<Cell>> = (self.combinations.iter())
            .map(|frames| {
                let values = frames
                    .first()
                    .map(|r| r.values.as_slice())
                    .unwrap_or_default();
                let of_keys = values.iter().map(|v| match v.parse::<f64>() {
                    Ok(number) => Cell::Number(number, v.split('.').nth(1).map_or(0, str::len)),
                    Err(_) => Cell::Text(v.clone()),
                });
                let numbers = TABLE
                    .iter()
                    .map(|(name, digits)| Cell::Number(spread(frames, name).median, *digits));
                of_keys.chain(numbers).collect()
            })
            .collect();
        page.table(&columns, &rows);
        Ok(page)
    }
}

/// A column's values over frames.
fn spread(frames: &[Row], column: &str) -> Spread {
    let value = NUMBERS.iter().find(|(name, _)| *name == column);
    let values = frames.iter().filter_map(|row| value.map(|(_, of)| of(row)));
    Spread::of(&values.collect::<Vec<_>>())
}
