//! A comparison as a page and as lines of text.

use std::fmt::Write as _;

use super::compare::{Comparison, Measured};
use super::page::{Cell, Page};
use super::plots::{Axis, Plot, Point, Series};
use super::precision::Precision;
use crate::error::Result;
use crate::job::Job;

/// Columns of the main table.
const COLUMNS: [&str; 19] = [
    "variant",
    "ms",
    "ms min",
    "ms max",
    "x reference",
    "CPU ms",
    "first ms",
    "MiB",
    "coverage %",
    "hit rate %",
    "recall %",
    "off m median",
    "off m p95",
    "off m p99",
    "off px median",
    "albedo dB",
    "picture dB",
    "SSIM",
    "FLIP",
];

/// Those of the text on a terminal.
const SHORT: [usize; 12] = [0, 1, 4, 5, 8, 9, 10, 11, 15, 16, 17, 18];

impl Comparison {
    /// A table for a terminal, with a line break at the end.
    pub fn text(&self) -> String {
        let mut rows = vec![SHORT.map(|c| COLUMNS[c].to_owned())];
        for variant in &self.variants {
            let cells = row(variant);
            rows.push(SHORT.map(|c| match cells.get(c) {
                Some(Cell::Text(text)) => crate::text::short_name(text),
                Some(Cell::Number(number, digits)) => format!("{number:.digits$}"),
                Some(Cell::Empty) | None => "-".to_owned(),
            }));
        }
        let mut text = aligned(&rows);
        for (name, p) in self.precisions() {
            let _ = writeln!(
                text,
                "{}: f32 and f64 part for {:.4} % of {} points searched (hits {:.3} and {:.3} %); hits of both are {:.2e} px apart (median), {:.2e} (99 %), {:.2} (worst)",
                crate::text::short_name(name),
                p.part * 100.0,
                p.offered,
                p.percent(p.hit_f32),
                p.percent(p.hit_f64),
                p.apart_px.median,
                p.apart_px.p99,
                p.apart_px.max
            );
        }
        text
    }

    /// The variants of which it was asked where f32 and f64 part.
    fn precisions(&self) -> impl Iterator<Item = (&str, &Precision)> {
        let all = self.variants.iter();
        all.filter_map(|v| Some((v.name.as_str(), v.precision.as_ref()?)))
    }

    /// The page.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`], and where a picture or plot cannot be made.
    pub fn page(&self, job: &Job) -> Result<Page> {
        let mut page = Page::new(&format!("{}: settings side by side", self.scene));
        let [width, height] = self.size;
        page.paragraph(&format!(
            "{} points, {width}x{height} pixels, catoptric {} on {}{}; medians of {} frames each after one that is not counted, in turn.",
            self.points,
            self.version,
            self.backend,
            self.adapter.as_ref().map(|a| format!(" ({a})")).unwrap_or_default(),
            self.repeats
        ));
        page.paragraph(&format!(
            "The reference traces the reflected rays through the same points. For comparison: the reference moved by one pixel has an albedo of {:.1} dB, black mirrors {:.1}. 120 dB is no difference.",
            self.controls.moved_by_one_pixel.psnr, self.controls.black.psnr
        ));
        let rows: Vec<Vec<Cell>> = self.variants.iter().map(row).collect();
        page.table(&COLUMNS, &rows);
        page.plot(&self.trade()?.svg()?);
        self.truths(&mut page);
        self.precision(&mut page);
        self.passes(&mut page);
        page.heading("Settings");
        let settings: Vec<Vec<Cell>> = (self.variants.iter())
            .map(|v| {
                let all: Vec<String> = v
                    .settings
                    .iter()
                    .map(|(k, v)| format!("{k} = {v}"))
                    .collect();
                vec![Cell::Text(v.name.clone()), Cell::Text(all.join(", "))]
            })
            .collect();
        page.table(&["variant", "differs from the defaults"], &settings);
        page.heading("Pictures");
        page.paragraph("Differences from the reference are four times as bright as they are.");
        page.figures(|page| {
            for variant in &self.variants {
                for (what, picture) in &variant.pictures {
                    page.picture(&format!("{}: {what}", variant.name), picture, job)?;
                }
            }
            Ok(())
        })?;
        Ok(page)
    }

    /// Quality against time.
    fn trade(&self) -> Result<Plot> {
        let series = self.variants.iter().skip(1).map(|v| Series {
            name: v.name.clone(),
            points: vec![Point {
                x: v.wall_ms.median,
                y: v.quality.mirrors.albedo_psnr.min(60.0),
                spread: None,
            }],
            line: Vec::new(),
        });
        Ok(Plot {
            title: "What the mirrors show, and what it takes".to_owned(),
            x: Axis {
                logarithmic: true,
                ..Axis::new("frame, ms")
            },
            y: Axis::new("albedo, dB (60 and more: no difference)"),
            series: series.collect(),
        })
    }

    fn truths(&self, page: &mut Page) {
        let mut mirrors = Vec::new();
        let mut pictures = Vec::new();
        for variant in &self.variants {
            for truth in &variant.truths {
                let names = [variant.name.clone(), truth.file.clone()].map(Cell::Text);
                if let Some(q) = &truth.mirrors {
                    mirrors.push([names.to_vec(), of_mirrors(q)].concat());
                }
                if let Some(p) = &truth.picture {
                    let of =
                        [(p.psnr, 2), (p.ssim, 4), (p.flip, 4)].map(|(v, d)| Cell::Number(v, d));
                    pictures.push([names.to_vec(), of.to_vec()].concat());
                }
            }
        }
        if !mirrors.is_empty() {
            page.heading("Against what others say that the mirrors show");
            let columns = [
                "variant",
                "truth",
                "coverage %",
                "recall %",
                "off m median",
                "off m p95",
                "off m p99",
                "off px median",
                "degrees median",
                "albedo dB",
                "albedo SSIM",
            ];
            page.table(&columns, &mirrors);
        }
        if !pictures.is_empty() {
            page.heading("Against the pictures of others, over mirror pixels");
            page.table(&["variant", "truth", "dB", "SSIM", "FLIP"], &pictures);
        }
    }

    fn precision(&self, page: &mut Page) {
        let row = |(name, p): (&str, &Precision)| {
            let numbers = [
                (p.offered as f64, 0),
                (p.percent(p.hit_f32), 3),
                (p.percent(p.hit_f64), 3),
                (p.part * 100.0, 4),
                (p.apart_px.median, 7),
                (p.apart_px.p99, 6),
                (p.apart_px.max, 3),
            ];
            let cells = numbers.map(|(v, digits)| Cell::Number(v, digits));
            [vec![Cell::Text(name.to_owned())], cells.to_vec()].concat()
        };
        let rows: Vec<Vec<Cell>> = self.precisions().map(row).collect();
        if rows.is_empty() {
            return;
        }
        page.heading("Where f32 and f64 part");
        page.paragraph("The interleaved search of the first frame's mirrors, once in f32 and once in f64, from the same numbers. They part where only one finds a point, or both more than 0.01 pixels apart.");
        let columns = [
            "variant",
            "points",
            "hits f32 %",
            "hits f64 %",
            "part %",
            "apart px median",
            "apart px p99",
            "apart px worst",
        ];
        page.table(&columns, &rows);
    }

    fn passes(&self, page: &mut Page) {
        let mut names: Vec<&str> = Vec::new();
        for pass in self.variants.iter().flat_map(|v| &v.passes) {
            if !names.contains(&pass.name.as_str()) {
                names.push(&pass.name);
            }
        }
        let mut columns = vec!["pass".to_owned()];
        for variant in &self.variants {
            columns.push(format!("{} ms", variant.name));
            columns.push(format!("{} CPU ms", variant.name));
        }
        let rows: Vec<Vec<Cell>> = (names.iter())
            .map(|name| {
                let mut row = vec![Cell::Text((*name).to_owned())];
                for variant in &self.variants {
                    let pass = variant.passes.iter().find(|p| p.name == *name);
                    row.push(Cell::maybe(pass.map(|p| p.wall_ms), 1));
                    row.push(Cell::maybe(pass.and_then(|p| p.cpu_ms), 1));
                }
                row
            })
            .collect();
        page.heading("Time per pass");
        let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
        page.table(&columns, &rows);
    }
}

fn of_mirrors(q: &super::quality::MirrorQuality) -> Vec<Cell> {
    [
        (q.coverage * 100.0, 2),
        (q.recall * 100.0, 2),
        (q.position_m.median, 5),
        (q.position_m.p95, 4),
        (q.position_m.p99, 4),
        (q.position_px.median, 3),
        (q.angle_degrees.median, 4),
        (q.albedo_psnr, 2),
        (q.albedo_ssim, 4),
    ]
    .map(|(v, digits)| Cell::Number(v, digits))
    .to_vec()
}

fn row(v: &Measured) -> Vec<Cell> {
    let (q, p) = (&v.quality.mirrors, &v.quality.picture);
    let search = v.search.first().filter(|s| s.points_offered > 0);
    let number = Cell::Number;
    vec![
        Cell::Text(v.name.clone()),
        number(v.wall_ms.median, 1),
        number(v.wall_ms.min, 1),
        number(v.wall_ms.max, 1),
        number(v.ratio.median, 3),
        Cell::maybe(v.cpu_ms.map(|c| c.median), 1),
        number(v.first_ms, 1),
        Cell::maybe(
            v.peak_memory_bytes.map(|b| b as f64 / f64::from(1 << 20)),
            0,
        ),
        number(q.coverage * 100.0, 2),
        Cell::maybe(search.map(|s| s.hit_rate * 100.0), 1),
        number(q.recall * 100.0, 2),
        number(q.position_m.median, 5),
        number(q.position_m.p95, 4),
        number(q.position_m.p99, 4),
        number(q.position_px.median, 3),
        number(q.albedo_psnr, 2),
        number(p.psnr, 2),
        number(p.ssim, 4),
        number(p.flip, 4),
    ]
}

/// Rows of one length as text, the first column to the left, the others to the right.
pub(super) fn aligned<const N: usize>(rows: &[[String; N]]) -> String {
    let widths: [usize; N] =
        std::array::from_fn(|c| rows.iter().map(|r| r[c].chars().count()).max().unwrap_or(0));
    let mut text = String::new();
    for row in rows {
        let cells = row
            .iter()
            .zip(widths)
            .enumerate()
            .map(|(c, (cell, width))| {
                if c == 0 {
                    format!("{cell:width$}")
                } else {
                    format!("{cell:>width$}")
                }
            });
        text.push_str(cells.collect::<Vec<_>>().join("  ").trim_end());
        text.push('\n');
    }
    text
}
