//! `compass map join`: the floors of several site files in one.

use crate::cli::exit::Outcome;
use crate::cli::json::JsonOption;
use anyhow::{Context as _, Result, bail};
use compass_core::map::site::Floor;
use compass_host::output::{check_file, write_file};
use compass_host::site_file::{SiteFile, site_bytes};
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Join {
    /// Site files whose floors have different names
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// The site file to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    json: JsonOption,
}

#[derive(Debug, Serialize)]
struct Joined<'a> {
    floors: Vec<&'a str>,
    bytes: usize,
}

impl Join {
    pub(super) fn run(&self) -> Result<Outcome> {
        check_file(&self.out)?;
        let files: Vec<SiteFile> =
            self.files.iter().map(|path| SiteFile::read(path)).collect::<Result<_, _>>()?;
        let floors = self.floors(&files)?;
        let bytes = site_bytes(&floors)?;
        write_file(&self.out, &bytes)?;
        let joined = Joined { floors: floors.iter().map(Floor::name).collect(), bytes: bytes.len() };
        let summary = format!(
            "{}: {} floors ({}), {} bytes\n",
            self.out.display(),
            floors.len(),
            joined.floors.join(", "),
            joined.bytes
        );
        self.json.emit(&joined, &summary)?;
        Ok(Outcome::Done)
    }

    fn floors<'a>(&self, files: &'a [SiteFile]) -> Result<Vec<Floor<'a>>> {
        let mut found: Vec<(&Path, Floor<'a>)> = Vec::new();
        for (path, file) in self.files.iter().zip(files) {
            for site_floor in file.floors() {
                let floor = site_floor.floor.with_context(|| {
                    format!("{}: a plain site map has no plan to join; build a site file", path.display())
                })?;
                let name = floor.name();
                if let Some((other, _)) = found.iter().find(|(_, before)| before.name() == name) {
                    let (a, b) = (other.display(), path.display());
                    bail!("{a} and {b} both have a floor '{name}': name one otherwise with map build --name");
                }
                found.push((path, floor));
            }
        }
        Ok(found.into_iter().map(|(_, floor)| floor).collect())
    }
}
