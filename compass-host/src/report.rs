//! Reports: one HTML page of key figures and pictures, without other resources.

use std::path::Path;

use minijinja::value::{Serde, Value};
use minijinja::{Environment, context};
use serde::Serialize;

use crate::figures::FigureError;
use crate::output::{printable, write_file};

/// One section of a report: its parts are optional and appear in the order of the fields.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Section {
    /// The heading.
    pub title: String,
    /// Paragraphs below it.
    pub text: Vec<String>,
    /// Tables of key figures.
    pub tables: Vec<Table>,
    /// Pictures.
    pub pictures: Vec<Picture>,
}

/// A table: numbers are aligned to the right.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Table {
    /// Caption of the table; may be empty.
    pub caption: String,
    /// The column headings; may be empty.
    pub head: Vec<String>,
    /// The cells, row by row.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// A table of names and values.
    #[must_use]
    pub fn pairs<N: Into<String>, V: Into<String>>(pairs: impl IntoIterator<Item = (N, V)>) -> Self {
        let rows = pairs.into_iter().map(|(name, value)| vec![name.into(), value.into()]).collect();
        Self { rows, ..Self::default() }
    }
}

/// A picture beside the report.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Picture {
    /// File name relative to the report.
    pub file: String,
    /// Caption and alternative text.
    pub caption: String,
}

const PAGE: &str = include_str!("report.html");

/// Writes a report as one HTML file, atomically.
///
/// All text is escaped and cannot contain mark-up.
///
/// # Errors
/// [`FigureError::Write`] when the file cannot be written.
pub fn write_html(path: &Path, title: &str, sections: &[Section]) -> Result<(), FigureError> {
    let mut html = render(title, sections).map_err(|e| FigureError::draw(path, &e))?;
    html.push('\n');
    Ok(write_file(path, printable(&html).as_bytes())?)
}

fn render(title: &str, sections: &[Section]) -> Result<String, minijinja::Error> {
    let mut environment = Environment::new();
    // The extension of the template's name enables HTML escaping.
    environment.add_template("report.html", PAGE)?;
    environment.add_filter("is_number", |text: &str| is_number(text));
    environment.add_filter("file_url", |name: &str| Value::from_safe_string(file_url(name)));
    let sections = Value::from(Serde(sections));
    environment.get_template("report.html")?.render(context! { title, sections })
}

/// Whether a cell starts with a number, with or without a unit behind it.
fn is_number(text: &str) -> bool {
    let digits = text.trim_start_matches(['+', '-', '\u{2212}']);
    digits.starts_with(|c: char| c.is_ascii_digit())
}

/// A relative file name as a URL: `#`, `?` and the like are encoded, and mark-up is escaped.
fn file_url(name: &str) -> String {
    let mut url = String::new();
    for byte in name.replace('\\', "/").bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'/' | b'~' => {
                url.push(char::from(byte));
            }
            _ => url.push_str(&format!("%{byte:02X}")),
        }
    }
    url
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sections() -> Vec<Section> {
        vec![Section {
            title: "Where & why".into(),
            text: vec!["a < b".into()],
            tables: vec![Table::pairs([("position", "0.12 m"), ("plan <script>", "\"x\"")])],
            pictures: vec![Picture { file: "rays #1.png".into(), caption: "rays \"over\" the plan".into() }],
        }]
    }

    #[test]
    fn all_text_is_escaped() {
        let html = render("<COMPASS>", &sections()).unwrap();
        for expected in [
            "<title>&lt;COMPASS&gt;</title>",
            "Where &amp; why",
            "<p>a &lt; b</p>",
            "plan &lt;script&gt;",
            "alt=\"rays &quot;over&quot; the plan\"",
            "src=\"rays%20%231.png\"",
            "<td class=\"number\">0.12 m</td>",
        ] {
            assert!(html.contains(expected), "{expected} is not in\n{html}");
        }
        assert!(!html.contains("<script"));
    }

    #[test]
    fn writes_the_page_or_names_the_path() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("report.html");
        write_html(&path, "t", &sections()).unwrap();
        assert!(std::fs::read_to_string(&path).unwrap().ends_with("</html>\n"));
        let message = write_html(Path::new("no/such/report.html"), "t", &[]).unwrap_err().to_string();
        assert!(message.starts_with("cannot write no/such/report.html: "), "{message}");
    }
}
