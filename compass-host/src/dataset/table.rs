//! Text tables as people have them: of `EuRoC`, of TUM, from pandas, from a spreadsheet.
//!
//! The separator is found: comma, semicolon, tab or blanks. Cells may be quoted, rows may have more columns than are
//! read, with semicolons numbers may have a decimal comma. Blank lines and lines that begin with `#` or `%` are skipped;
//! the last of those before the first row, or a first row of words, names the columns.

use crate::input;
use csv::{ReaderBuilder, StringRecord, Trim};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Rows from which the separator is found.
const SAMPLED: usize = 20;

/// Times from here on are no seconds: 3170 years. In nanoseconds they are 100 s.
const LATEST_S: f64 = 1e11;

/// Nanoseconds in a second.
const NANOSECONDS: u64 = 1_000_000_000;

/// Why a table could not be read: one line that names the file and the line at fault.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TableError {
    /// The file could not be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// A row is not a valid record, or none of them is.
    #[error("{}:{line}: {problem}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// What is wrong with it.
        problem: String,
    },
}

/// The unit of a column of times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TimeUnit {
    Seconds,
    Nanoseconds,
}

/// The names of the columns: lower case, without units.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Header {
    names: Vec<String>,
    units: Vec<String>,
}

impl Header {
    fn new(numbered: &StringRecord) -> Self {
        let (mut names, mut units) = (Vec::new(), Vec::new());
        for cell in numbered.iter().skip(1) {
            let cell = cell.trim_matches(['#', '%', ' ', '"']).to_lowercase();
            let (name, unit) = cell.split_once(['[', '(']).unwrap_or((&cell, ""));
            names.push(name.trim().to_owned());
            units.push(unit.trim_end_matches([']', ')', ' ']).to_owned());
        }
        Self { names, units }
    }

    /// The first column whose name fits.
    pub(super) fn find(&self, is: impl Fn(&str) -> bool) -> Option<usize> {
        self.names.iter().position(|name| is(name))
    }

    /// The columns of the components named by the last letters of their names, where all are there.
    pub(super) fn components<const N: usize>(
        &self,
        letters: [char; N],
        is: impl Fn(&str) -> bool,
    ) -> Option<[usize; N]> {
        let mut columns = [0; N];
        for (column, letter) in columns.iter_mut().zip(letters) {
            *column = self.find(|name| name.ends_with(letter) && is(name))?;
        }
        Some(columns)
    }

    /// The unit of a column of times, if the header says it.
    fn time_unit(&self, column: usize) -> Option<TimeUnit> {
        let (name, unit) = (self.names.get(column)?, self.units.get(column)?);
        if unit.starts_with("ns")
            || unit.starts_with("nano")
            || name.ends_with("_ns")
            || name.contains("nano")
        {
            Some(TimeUnit::Nanoseconds)
        } else if unit == "s" || unit.starts_with("sec") || name.ends_with("_s") {
            Some(TimeUnit::Seconds)
        } else {
            None
        }
    }
}

/// A row of a table.
pub(super) struct Row<'a> {
    /// The first is the number of the line.
    cells: &'a StringRecord,
    pub(super) header: Option<&'a Header>,
    separator: u8,
}

impl<'a> Row<'a> {
    pub(super) fn len(&self) -> usize {
        self.cells.len().saturating_sub(1)
    }

    fn line(&self) -> u64 {
        self.cells.get(0).and_then(|number| number.parse().ok()).unwrap_or_default()
    }

    /// Whether commas separate the cells.
    pub(super) const fn has_commas(&self) -> bool {
        self.separator == b','
    }

    pub(super) fn cell(&self, column: usize) -> Option<&'a str> {
        self.cells.get(column + 1).filter(|cell| !cell.is_empty())
    }

    /// A finite number; `name` is for the message.
    pub(super) fn number(&self, column: usize, name: &str) -> Result<f64, String> {
        let text = self.cell(column).ok_or_else(|| format!("{name} is missing"))?;
        let number = self.with_point(text).parse::<f64>().ok().filter(|number| number.is_finite());
        number.ok_or_else(|| format!("{name} is '{text}', no finite number"))
    }

    fn with_point(&self, text: &str) -> String {
        if self.has_commas() { text.to_owned() } else { text.replace(',', ".") }
    }

    /// The unit of a column of times that the header says.
    pub(super) fn told_unit(&self, column: usize) -> Option<TimeUnit> {
        self.header?.time_unit(column)
    }

    /// A time in nanoseconds, in the unit that the header says; else a whole number is nanoseconds, and a decimal one
    /// seconds if that is a time of this age.
    pub(super) fn nanoseconds(&self, column: usize) -> Result<u64, String> {
        let text = self.cell(column).ok_or("timestamp is missing")?;
        let unit = self.told_unit(column).unwrap_or_else(|| {
            let is_whole = text.bytes().all(|byte| byte.is_ascii_digit());
            let is_late = self.with_point(text).parse::<f64>().is_ok_and(|value| value >= LATEST_S);
            if is_whole || is_late { TimeUnit::Nanoseconds } else { TimeUnit::Seconds }
        });
        self.time(column, unit)
    }

    /// A time in nanoseconds, written in this unit.
    pub(super) fn time(&self, column: usize, unit: TimeUnit) -> Result<u64, String> {
        let text = self.cell(column).ok_or("timestamp is missing")?;
        match unit {
            TimeUnit::Nanoseconds => whole(&self.with_point(text))
                .ok_or_else(|| format!("timestamp is '{text}', no number of nanoseconds from 0 up")),
            TimeUnit::Seconds => match seconds(&self.with_point(text)) {
                Some(time) => Ok(time),
                None if text.parse::<f64>().is_ok_and(|value| value >= LATEST_S) => Err(format!(
                    "timestamp is '{text}': that looks like nanoseconds, and seconds are expected; a header line \
                     '#timestamp [ns] ...' says that it is"
                )),
                None => Err(format!("timestamp is '{text}', no number of seconds from 0 up")),
            },
        }
    }
}

/// A whole number, exact unless it has a point or an exponent.
fn whole(text: &str) -> Option<u64> {
    let by_float =
        || text.parse::<f64>().ok().filter(|v| (0.0..1.8e19).contains(v)).map(|v| v.round() as u64);
    text.parse().ok().or_else(by_float)
}

/// Nanoseconds from a decimal number of seconds, exact unless it has an exponent.
fn seconds(text: &str) -> Option<u64> {
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    let digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
    if !digits(whole) || !digits(fraction) || whole.len() + fraction.len() == 0 {
        let seconds = text.parse::<f64>().ok().filter(|s| (0.0..1e10).contains(s))?;
        return Some((seconds * NANOSECONDS as f64).round() as u64);
    }
    let seconds: u64 = if whole.is_empty() { 0 } else { whole.parse().ok()? };
    let padded: String = fraction.chars().chain(std::iter::repeat('0')).take(9).collect();
    seconds.checked_mul(NANOSECONDS)?.checked_add(padded.parse().ok()?)
}

/// Rows that were rejected, with their problems, and the number of the others.
#[derive(Debug, Default)]
pub(super) struct Visited {
    pub(super) rejected: Vec<(u64, String)>,
    pub(super) taken: usize,
}

/// Passes the rows of a file to `take`, in order, and collects those that it rejects with a problem.
///
/// # Errors
/// [`TableError::Read`]; [`TableError::Line`] if all rows are rejected, with the first.
pub(super) fn visit(
    path: &Path,
    take: impl FnMut(&Row<'_>) -> Result<(), String>,
) -> Result<Visited, TableError> {
    let bytes = input::read(path, input::limits().table_bytes)
        .map_err(|source| TableError::Read { path: path.to_path_buf(), source })?;
    let visited = visit_text(&decoded(&bytes), take);
    match visited.rejected.first() {
        Some((line, problem)) if visited.taken == 0 => {
            Err(TableError::Line { path: path.to_path_buf(), line: *line, problem: problem.clone() })
        }
        _ => Ok(visited),
    }
}

/// The text of a file in UTF-8, or in UTF-16 with a mark, as shells of Windows write it.
fn decoded(bytes: &[u8]) -> String {
    let utf16 = |units: fn([u8; 2]) -> u16, rest: &[u8]| {
        let units: Vec<u16> = rest.as_chunks().0.iter().map(|pair| units(*pair)).collect();
        String::from_utf16_lossy(&units)
    };
    match bytes {
        [0xff, 0xfe, rest @ ..] => utf16(u16::from_le_bytes, rest),
        [0xfe, 0xff, rest @ ..] => utf16(u16::from_be_bytes, rest),
        _ => String::from_utf8_lossy(bytes).trim_start_matches('\u{feff}').to_owned(),
    }
}

fn is_comment(line: &str) -> bool {
    line.starts_with(['#', '%'])
}

fn visit_text(text: &str, mut take: impl FnMut(&Row<'_>) -> Result<(), String>) -> Visited {
    let lines = || text.lines().map(str::trim).filter(|line| !line.is_empty());
    let separator = separator(lines().filter(|line| !is_comment(line)).take(SAMPLED));
    let comment = lines().take_while(|line| is_comment(line)).last();
    let comment = comment.map(|line| line.trim_start_matches(['#', '%', ' ']));
    let mut header = comment.and_then(|line| Some(Header::new(&numbered(line, separator).next()?)));
    let mut visited = Visited::default();
    let mut is_first = true;
    for cells in numbered(text, separator) {
        if std::mem::take(&mut is_first) {
            // A first row of words names the columns; a comment of another length names something else.
            if cells.get(1).is_some_and(is_word) {
                header = Some(Header::new(&cells));
                continue;
            }
            header = header.filter(|header| header.names.len() + 1 == cells.len());
        }
        let row = Row { cells: &cells, header: header.as_ref(), separator };
        match take(&row) {
            Ok(()) => visited.taken += 1,
            Err(problem) => visited.rejected.push((row.line(), problem)),
        }
    }
    visited
}

/// Whether a cell is a name of a column: not a number, not empty, not NaN.
fn is_word(cell: &str) -> bool {
    cell.starts_with(|c: char| c.is_alphabetic() || c == '_') && cell.parse::<f64>().is_err()
}

/// The records of a text; the first cell of each is the number of its line.
fn numbered(text: &str, separator: u8) -> impl Iterator<Item = StringRecord> {
    // Runs of blanks are one separator, but a unit belongs to the name before it.
    let tidy = |line: &str| match separator {
        b' ' => line.replace(" [", "[").split_whitespace().collect::<Vec<_>>().join(" "),
        _ => line.to_owned(),
    };
    let mut rows = String::with_capacity(text.len());
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.trim();
        if !line.is_empty() && !is_comment(line) {
            let _ = writeln!(rows, "{number}{}{}", char::from(separator), tidy(line));
        }
    }
    let reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(Trim::All)
        .delimiter(separator)
        .from_reader(std::io::Cursor::new(rows.into_bytes()));
    // The text is UTF-8 and in memory: nothing can fail.
    reader.into_records().map_while(Result::ok)
}

/// Tab if all sampled lines have one, semicolon or comma if most have; else blanks.
fn separator<'a>(lines: impl Iterator<Item = &'a str>) -> u8 {
    let lines: Vec<_> = lines.collect();
    let count = |separator: u8| lines.iter().filter(|line| line.as_bytes().contains(&separator)).count();
    match lines.len() {
        0 => b' ',
        all if count(b'\t') == all => b'\t',
        all => [b';', b','].into_iter().find(|separator| 2 * count(*separator) >= all).unwrap_or(b' '),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rows of a text as their cells joined by `|`, and the names of the columns.
    fn read(text: &str) -> (Vec<String>, Vec<String>) {
        let (mut rows, mut names) = (Vec::new(), Vec::new());
        visit_text(&decoded(text.as_bytes()), |row| {
            rows.push(row.cells.iter().skip(1).collect::<Vec<_>>().join("|"));
            names = row.header.map_or(Vec::new(), |header| header.names.clone());
            Ok(())
        });
        (rows, names)
    }

    #[test]
    fn dialects_are_one_table() {
        let expected = vec!["1|a b.png".to_owned(), "2|c.png".to_owned()];
        for text in [
            "1,a b.png\n2,c.png\n",
            "\u{feff}\r\n1, a b.png\r\n\r\n2 ,c.png",
            "1;a b.png\n2;c.png\n",
            "1\ta b.png\n2\tc.png\n",
            "\"1\",\"a b.png\"\n\"2\",\"c.png\"\n",
            "# made by hand, with care, twice\n1,a b.png\n# no more\n2,c.png\n",
        ] {
            let (rows, names) = read(text);
            assert_eq!((rows, names), (expected.clone(), vec![]), "{text}");
        }
        assert_eq!(read(" 1   2\t3 \n4 5 6\n").0, ["1|2|3", "4|5|6"]);
        let wide: Vec<u8> = "1,2\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(decoded(&[&[0xff, 0xfe], &wide[..]].concat()), "1,2\n");
    }

    #[test]
    fn columns_are_named_by_a_comment_or_a_row() {
        let expected = ["timestamp", "q_rs_w"].map(str::to_owned).to_vec();
        for text in [
            "#timestamp [ns],q_RS_w []\n1,2\n",
            "# written by hand\n# timestamp [ns], q_RS_w []\n1,2\n",
            "timestamp [ns];Q_RS_W\n1;2\n",
            "\"timestamp\",\"q_RS_w []\"\n1,2\n",
        ] {
            let (rows, names) = read(text);
            assert_eq!((rows, names), (vec!["1|2".to_owned()], expected.clone()), "{text}");
        }
        assert_eq!(read("# a, b, c\n1,2\n").1, Vec::<String>::new(), "of another length");
        assert_eq!(read("nan,1\n2,3\n").0.len(), 2, "NaN names no column");
    }

    #[test]
    fn rejected_rows_have_their_lines() {
        let visited = visit_text("# head\n\n1,2\n3,x\n5,6\n", |row| row.number(1, "b").map(|_| ()));
        assert_eq!(visited.rejected, [(4, "b is 'x', no finite number".to_owned())]);
        assert_eq!(visited.taken, 2);
    }

    #[test]
    fn times_are_seconds_or_nanoseconds() {
        let time = |text: &str| {
            let mut found = Vec::new();
            visit_text(text, |row| {
                found.push(row.nanoseconds(0)?);
                Ok(())
            });
            found.first().copied()
        };
        assert_eq!(time("1403636579763555584,x"), Some(1_403_636_579_763_555_584));
        assert_eq!(time("1403636579.763555584,x"), Some(1_403_636_579_763_555_584));
        assert_eq!(time("100.5 x"), Some(100_500_000_000));
        assert_eq!(time("1e11,x"), Some(100_000_000_000));
        assert_eq!(time("100500000000.0,x"), Some(100_500_000_000));
        assert_eq!(time("t [s],x\n7,x"), Some(7_000_000_000));
        assert_eq!(time("1,5;x"), Some(1_500_000_000), "a decimal comma");
        assert_eq!(time("-1,x"), None);
        assert_eq!(time("nan,x"), None);
    }

    #[test]
    fn nanoseconds_for_seconds_are_named() {
        let mut message = String::new();
        visit_text("100000000000 x\n", |row| row.time(0, TimeUnit::Seconds).map(|_| ()))
            .rejected
            .iter()
            .for_each(|(_, problem)| message.clone_from(problem));
        assert!(message.contains("looks like nanoseconds"), "{message}");
    }
}
