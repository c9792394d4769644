//! What commands write: machine-readable results, and files that are whole or absent.

use anyhow::{Context as _, Result};
use serde::{Serialize, Serializer};
use std::path::Path;

/// A number of the JSON output: a plain decimal of at most six places, never an exponent.
///
/// What is not finite becomes `null`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decimal(pub f64);

impl Serialize for Decimal {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if !self.0.is_finite() {
            return serializer.serialize_none();
        }
        let text = format!("{:.6}", self.0);
        let text = text.trim_end_matches('0').trim_end_matches('.');
        let text = if text == "-0" { "0" } else { text };
        let raw = serde_json::value::RawValue::from_string(text.to_owned());
        raw.map_err(serde::ser::Error::custom)?.serialize(serializer)
    }
}

/// A whole array of [`Decimal`]s.
pub fn decimals(values: impl IntoIterator<Item = f64>) -> Vec<Decimal> {
    values.into_iter().map(Decimal).collect()
}

/// Where `--json` goes.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct JsonOption {
    /// Write the machine-readable result to FILE; `-` is standard output, which then carries nothing else
    #[arg(long, value_name = "FILE")]
    pub json: Option<std::path::PathBuf>,
}

impl JsonOption {
    /// Writes `result` as asked; without `--json` prints `summary` instead.
    ///
    /// With `--json FILE` the summary is printed as well; with `--json -` it is not.
    ///
    /// # Errors
    /// Names the file that could not be written.
    pub fn emit(&self, result: &impl Serialize, summary: &str) -> Result<()> {
        let text = || -> Result<String> { Ok(serde_json::to_string_pretty(result)? + "\n") };
        match &self.json {
            Some(path) if path.as_os_str() == "-" => print(&text()?),
            Some(path) => {
                write_file(path, text()?.as_bytes())?;
                print(summary)
            }
            None => print(summary),
        }
    }
}

/// Prints to standard output; a reader that went away is no error.
fn print(text: &str) -> Result<()> {
    use std::io::Write as _;
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(e).context("standard output"),
        _ => Ok(()),
    }
}

/// Writes a file whole or not at all.
///
/// # Errors
/// Names the file.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<()> {
    crate::figures::write_atomically(path, bytes).map_err(Into::into)
}

/// Writes an image as PNG, whole or not at all.
///
/// # Errors
/// Names the file.
pub fn write_png(path: &Path, image: &image::RgbImage) -> Result<()> {
    let mut png = std::io::Cursor::new(Vec::new());
    image
        .write_to(&mut png, image::ImageFormat::Png)
        .with_context(|| format!("{}: cannot be encoded", path.display()))?;
    write_file(path, png.get_ref())
}

/// Creates a directory for output with all its parents.
///
/// # Errors
/// Names the directory.
pub fn create_dir(path: &Path) -> Result<()> {
    std::fs::create_dir_all(path).with_context(|| format!("{}: cannot create the directory", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_plain_decimals() {
        let text = |v: f64| serde_json::to_string(&Decimal(v)).unwrap();
        assert_eq!(text(0.000_001), "0.000001");
        assert_eq!(text(1e-9), "0");
        assert_eq!(text(-1e-9), "0");
        assert_eq!(text(123_456_789.25), "123456789.25");
        assert_eq!(text(30.0), "30");
        assert_eq!(text(f64::NAN), "null");
    }
}
