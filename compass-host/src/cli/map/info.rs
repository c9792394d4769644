//! `compass map info`: prints the contents of a site file.

use crate::cli::exit::Outcome;
use crate::cli::json::JsonOption;
use anyhow::Result;
use compass_core::map::site_map::SiteMap;
use compass_host::output::Decimal;
use compass_host::site_file::{SiteFile, SiteFloor};
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Info {
    /// A site file, or a plain site map
    file: PathBuf,
    #[command(flatten)]
    json: JsonOption,
}

/// Facts of the first floor, bytes of the whole file, and all floors.
#[derive(Debug, Serialize)]
struct Described<'a> {
    #[serde(flatten)]
    first: Option<Facts>,
    bytes: usize,
    floors: Vec<DescribedFloor<'a>>,
}

#[derive(Debug, Serialize)]
struct DescribedFloor<'a> {
    /// The floor's name; a plain site map has none.
    name: Option<&'a str>,
    #[serde(flatten)]
    facts: Facts,
    map_bytes: usize,
    plan_bytes: Vec<usize>,
}

/// Facts of a site map.
#[derive(Debug, Clone, Serialize)]
struct Facts {
    candidates: usize,
    layers: u8,
    spacing_m: Decimal,
    resolution_m: Decimal,
    origin: [Decimal; 2],
    plan_size_px: [u32; 2],
    plan_checksum: String,
    x: [Decimal; 2],
    y: [Decimal; 2],
}

impl Info {
    pub(super) fn run(&self) -> Result<Outcome> {
        let file = SiteFile::read(&self.file)?;
        let floors: Vec<_> = file.floors().iter().map(DescribedFloor::of).collect();
        let described = Described {
            first: floors.first().map(|f| f.facts.clone()),
            bytes: file.as_bytes().len(),
            floors,
        };
        let mut summary = format!(
            "{}: {} floor(s), {} bytes\n",
            self.file.display(),
            described.floors.len(),
            described.bytes
        );
        described.floors.iter().for_each(|floor| floor.summarise(&mut summary));
        self.json.emit(&described, &summary)?;
        Ok(Outcome::Done)
    }
}

impl<'a> DescribedFloor<'a> {
    fn of(floor: &SiteFloor<'a>) -> Self {
        let plans = floor.floor.iter().flat_map(|floor| (0..floor.layers()).map_while(|n| floor.plan(n)));
        Self {
            name: floor.name(),
            facts: Facts::of(&floor.map),
            map_bytes: floor.map.as_bytes().len(),
            plan_bytes: plans.map(|plan| plan.as_bytes().len()).collect(),
        }
    }

    fn summarise(&self, out: &mut String) {
        let Facts { candidates, layers, spacing_m, resolution_m, plan_size_px, plan_checksum, x, y, .. } =
            &self.facts;
        let plans: Vec<_> = self.plan_bytes.iter().map(ToString::to_string).collect();
        let plans =
            if plans.is_empty() { "no plans".into() } else { format!("plans {} bytes", plans.join(" + ")) };
        let _ = write!(
            out,
            "{}: {candidates} candidates every {} m, {layers} layer(s), map {} bytes, {plans}\n  \
             plan {} x {} cells of {} m, checksum {plan_checksum}\n  \
             x {:.2} to {:.2} m, y {:.2} to {:.2} m\n",
            self.name.unwrap_or("unnamed floor"),
            spacing_m.0,
            self.map_bytes,
            plan_size_px[0],
            plan_size_px[1],
            resolution_m.0,
            x[0].0,
            x[1].0,
            y[0].0,
            y[1].0,
        );
    }
}

impl Facts {
    fn of(map: &SiteMap<'_>) -> Self {
        let header = map.header();
        let (mut x, mut y) = ([f64::MAX, f64::MIN], [f64::MAX, f64::MIN]);
        for at in (0..map.len()).filter_map(|index| map.position(index)) {
            let (px, py) = (at.x.to_num::<f64>(), at.y.to_num::<f64>());
            x = [x[0].min(px), x[1].max(px)];
            y = [y[0].min(py), y[1].max(py)];
        }
        Self {
            candidates: map.len(),
            layers: header.layers,
            spacing_m: Decimal(f64::from(header.spacing_mm) / 1000.0),
            resolution_m: Decimal(f64::from(header.grid.resolution_nm) / 1e9),
            origin: [header.grid.origin.x, header.grid.origin.y].map(|v| Decimal(v.to_num())),
            plan_size_px: header.plan_size,
            plan_checksum: format!("{:08x}", header.plan_checksum),
            x: x.map(Decimal),
            y: y.map(Decimal),
        }
    }
}
