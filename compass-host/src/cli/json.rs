//! `--json`: the machine-readable result, and the summary for people.

use anyhow::{Context as _, Result};
use compass_host::output::{check_file, printable, write_file};
use serde::Serialize;

/// Where `--json` goes.
#[derive(Debug, Clone, Default, clap::Args)]
pub(super) struct JsonOption {
    /// Write the machine-readable result to FILE; `-` is standard output, which then carries nothing else
    #[arg(long, value_name = "FILE")]
    json: Option<std::path::PathBuf>,
}

impl JsonOption {
    /// Checks, before long work, that the result can be written.
    ///
    /// # Errors
    /// Names the file that cannot be.
    pub(super) fn check(&self) -> Result<()> {
        match &self.json {
            Some(path) if path.as_os_str() != "-" => Ok(check_file(path)?),
            _ => Ok(()),
        }
    }

    /// Writes `result` to the destination; without `--json` prints `summary` instead.
    ///
    /// With `--json FILE` the summary is printed as well; with `--json -` it is not.
    ///
    /// # Errors
    /// Names the file that could not be written.
    pub(super) fn emit(&self, result: &impl Serialize, summary: &str) -> Result<()> {
        let text = || -> Result<String> { Ok(serde_json::to_string_pretty(result)? + "\n") };
        match &self.json {
            Some(path) if path.as_os_str() == "-" => print(&text()?),
            Some(path) => {
                write_file(path, text()?.as_bytes())?;
                print(&printable(summary))
            }
            None => print(&printable(summary)),
        }
    }
}

/// Prints to standard output; a closed pipe is not an error.
fn print(text: &str) -> Result<()> {
    use std::io::Write as _;
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(e).context("standard output"),
        _ => Ok(()),
    }
}
