//! A report as one HTML file: pictures and plots within, nothing from the network, light and dark, for wide and narrow screens.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;

use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::image::Background;
use crate::job::Job;
use crate::output::encode_png;
use crate::text::printable;

/// A page that grows from top to bottom. Whatever text it is given is shown as it is and never understood as HTML.
#[derive(Debug, Clone, Default)]
pub struct Page {
    title: String,
    body: String,
}

/// A cell of a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Sorted by its letters.
    Text(String),
    /// Sorted by its size; so many digits behind the point are shown.
    Number(f64, usize),
    /// Nothing to say; sorted last.
    Empty,
}

impl Cell {
    /// A number that may be missing.
    pub fn maybe(number: Option<f64>, digits: usize) -> Self {
        number.map_or(Self::Empty, |number| Self::Number(number, digits))
    }
}

impl Page {
    /// An empty page.
    pub fn new(title: &str) -> Self {
        Self {
            title: escaped(title),
            body: String::new(),
        }
    }

    /// A heading.
    pub fn heading(&mut self, text: &str) {
        let _ = writeln!(self.body, "<h2>{}</h2>", escaped(text));
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) {
        let _ = writeln!(self.body, "<p>{}</p>", escaped(text));
    }

    /// Text as it stands, line by line.
    pub fn code(&mut self, text: &str) {
        let lines: Vec<String> = text.lines().map(escaped).collect();
        let _ = writeln!(self.body, "<pre>{}</pre>", lines.join("\n"));
    }

    /// A table whose columns sort it when they are tapped.
    pub fn table(&mut self, columns: &[&str], rows: &[Vec<Cell>]) {
        self.body
            .push_str("<div class=\"scroll\"><table><thead><tr>");
        for column in columns {
            let _ = write!(
                self.body,
                "<th aria-sort=\"none\"><button type=\"button\">{}</button></th>",
                escaped(column)
            );
        }
        self.body.push_str("</tr></thead><tbody>\n");
        for row in rows {
            self.body.push_str("<tr>");
            for cell in row {
                let _ = match cell {
                    Cell::Text(text) => write!(self.body, "<td>{}</td>", escaped(text)),
                    Cell::Number(number, digits) if number.is_finite() => write!(
                        self.body,
                        "<td class=\"n\" data-v=\"{number}\">{number:.digits$}</td>"
                    ),
                    Cell::Number(..) | Cell::Empty => {
                        write!(self.body, "<td class=\"n\">–</td>")
                    }
                };
            }
            self.body.push_str("</tr>\n");
        }
        self.body.push_str("</tbody></table></div>\n");
    }

    /// Starts a row of figures that stand side by side where there is room.
    pub fn figures(&mut self, add: impl FnOnce(&mut Self) -> Result<()>) -> Result<()> {
        self.body.push_str("<div class=\"figures\">\n");
        add(self)?;
        self.body.push_str("</div>\n");
        Ok(())
    }

    /// A picture (sRGB and alpha), with what it shows.
    ///
    /// # Errors
    /// [`Error::Cancelled`], or where it is too large for a PNG.
    pub fn picture(&mut self, caption: &str, picture: &Grid<[u8; 4]>, job: &Job) -> Result<()> {
        let mut png = Vec::new();
        encode_png(&mut png, picture, Background::Transparent, job).map_err(|e| {
            e.downcast::<Error>()
                .unwrap_or_else(|e| Error::Setting(format!("the picture {caption:?}: {e}")))
        })?;
        let caption = escaped(caption);
        let _ = writeln!(
            self.body,
            "<figure><img alt=\"{caption}\" src=\"data:image/png;base64,{}\"><figcaption>{caption}</figcaption></figure>",
            BASE64.encode(png)
        );
        Ok(())
    }

    /// A plot that [`super::plots`] drew.
    pub fn plot(&mut self, svg: &str) {
        // Within a page an SVG needs no name of its namespace, which looks like an address.
        let svg = svg.replace(" xmlns=\"http://www.w3.org/2000/svg\"", "");
        let _ = writeln!(self.body, "<figure class=\"plot\">{svg}</figure>");
    }

    /// The whole file.
    pub fn html(&self) -> String {
        format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"color-scheme\" content=\"light dark\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n\
             <link rel=\"icon\" href=\"data:,\">\n\
             <title>{0}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{0}</h1>\n{1}</main>\n<script>{SCRIPT}</script>\n</body>\n</html>\n",
            self.title, self.body
        )
    }
}

/// Text that means itself in HTML and in SVG.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in printable(text).chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
}

const STYLE: &str = "
:root{--ink:#1b1f24;--paper:#fff;--faint:#59636e;--line:#d1d9e0;--row:#f6f8fa}
@media (prefers-color-scheme:dark){:root{--ink:#e6edf3;--paper:#0d1117;--faint:#9198a1;--line:#3d444d;--row:#151b23}
.plot svg{filter:invert(1) hue-rotate(180deg)}}
*{box-sizing:border-box}
body{margin:0;background:var(--paper);color:var(--ink);font:16px/1.5 system-ui,sans-serif}
main{max-width:80rem;margin:0 auto;padding:1rem}
h1{font-size:1.5rem;overflow-wrap:anywhere}h2{font-size:1.15rem;margin-top:2rem}
p{max-width:48rem;color:var(--faint);overflow-wrap:anywhere}
.scroll{overflow-x:auto;border:1px solid var(--line);border-radius:6px}
table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums;font-size:.9rem}
th,td{padding:.35rem .6rem;text-align:left;white-space:nowrap;border-bottom:1px solid var(--line)}
tbody tr:last-child td{border-bottom:0}tbody tr:nth-child(even){background:var(--row)}
.n{text-align:right}
th:first-child,td:first-child{position:sticky;left:0;background:var(--paper)}
th button{all:unset;cursor:pointer;font-weight:600;padding:.5rem 0}
th button:focus-visible{outline:2px solid}
th[aria-sort=ascending] button::after{content:' \\25B2'}th[aria-sort=descending] button::after{content:' \\25BC'}
.figures{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,22rem),1fr));gap:1rem}
figure{margin:0}.plot{max-width:44rem}figure img,figure svg{width:100%;height:auto;display:block}
figcaption{font-size:.85rem;color:var(--faint);overflow-wrap:anywhere}
pre{overflow-x:auto;padding:.75rem;background:var(--row);border:1px solid var(--line);border-radius:6px;font-size:.85rem}
";

const SCRIPT: &str = "
for (const button of document.querySelectorAll('th button')) button.addEventListener('click', () => {
  const th = button.parentElement, table = th.closest('table'), body = table.tBodies[0];
  const up = th.getAttribute('aria-sort') !== 'ascending', column = th.cellIndex;
  for (const other of table.tHead.rows[0].cells) other.setAttribute('aria-sort', 'none');
  th.setAttribute('aria-sort', up ? 'ascending' : 'descending');
  const key = row => { const cell = row.cells[column]; return cell.dataset.v === undefined ? cell.textContent : Number(cell.dataset.v); };
  const order = (a, b) => typeof a === typeof b ? (a < b ? -1 : a > b ? 1 : 0) : typeof a === 'number' ? -1 : 1;
  [...body.rows].sort((a, b) => order(key(a), key(b)) * (up ? 1 : -1)).forEach(row => body.append(row));
});
";

#[cfg(test)]
mod tests {
    use glam::UVec2;

    use super::*;

    const NASTY: &str = "<script>alert('x')</script>&\"\u{1b}[2J";

    #[test]
    fn no_text_becomes_html() {
        let mut page = Page::new(NASTY);
        page.heading(NASTY);
        page.paragraph(NASTY);
        page.code(NASTY);
        page.table(&[NASTY], &[vec![Cell::Text(NASTY.to_owned())]]);
        let picture = Grid::new(UVec2::ONE, [0, 0, 0, 255]);
        assert!(page.picture(NASTY, &picture, &Job::default()).is_ok());
        let html = page.html();
        assert_eq!(html.matches("<script>").count(), 1, "only the page's own");
        assert!(
            !html.contains("alert('x')") && !html.contains('\u{1b}'),
            "{html}"
        );
        assert_eq!(html.matches("&lt;script&gt;alert(&#39;x&#39;)").count(), 9);
    }

    #[test]
    fn nothing_comes_from_the_network() {
        let html = Page::new("a page").html();
        assert!(
            !html.contains("http:") && !html.contains("https:"),
            "{html}"
        );
    }

    #[test]
    fn what_is_no_number_sorts_last() {
        let mut page = Page::new("");
        let row = |cell| vec![cell];
        page.table(
            &["a"],
            &[row(Cell::Number(f64::NAN, 1)), row(Cell::Number(2.0, 2))],
        );
        assert_eq!(page.html().matches("data-v=\"2\">2.00<").count(), 1);
        assert_eq!(page.html().matches("data-v").count(), 1, "one cell alone");
    }
}
