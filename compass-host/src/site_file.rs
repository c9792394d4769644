//! Site files in memory: read and checked as a whole, made from floors.

use crate::plan_import::PlanRaster;
use crate::site::{BuildOptions, Bytes, PackedPlan, build};
use anyhow::{Context as _, Result, anyhow};
use compass_core::map::site::{Floor, Site, SiteError, Writer};
use compass_core::map::site_map::SiteMap;
use std::path::Path;

/// The bytes of a site file, or of a plain site map, which counts as one floor without name and plan.
#[derive(Debug, Clone)]
pub struct SiteFile {
    bytes: Vec<u8>,
}

/// A floor of a file.
#[derive(Debug, Clone, Copy)]
pub struct SiteFloor<'a> {
    /// Its candidates.
    pub map: SiteMap<'a>,
    /// All of it; a plain site map is none.
    pub floor: Option<Floor<'a>>,
}

impl SiteFile {
    /// Reads a file and compares all its checksums.
    ///
    /// # Errors
    /// Names the file and the field that is wrong.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).with_context(|| format!("{}: cannot be read", path.display()))?;
        verify(&bytes).map_err(|e| anyhow!("{}: {e}", path.display()))?;
        Ok(Self { bytes })
    }

    /// The file as it is.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The floors in the order of the file; there is at least one.
    #[must_use]
    pub fn storeys(&self) -> Vec<SiteFloor<'_>> {
        match Site::new(&self.bytes) {
            Ok(site) => {
                site.floors().map(|floor| SiteFloor { map: *floor.map(), floor: Some(floor) }).collect()
            }
            Err(_) => {
                SiteMap::new(&self.bytes).map(|map| SiteFloor { map, floor: None }).into_iter().collect()
            }
        }
    }
}

impl<'a> SiteFloor<'a> {
    /// Its name, where it has one.
    #[must_use]
    pub fn name(&self) -> Option<&'a str> {
        self.floor.map(|floor| floor.name())
    }
}

fn verify(bytes: &[u8]) -> Result<()> {
    match Site::new(bytes) {
        Err(SiteError::Magic) => Ok(SiteMap::new(bytes)?.verify()?),
        site => Ok(site?.verify()?),
    }
}

/// A site file of these floors.
///
/// # Errors
/// [`SiteError`]: no floor or too many, two of one name, or more bytes than the format can count.
pub fn site_bytes(floors: &[Floor<'_>]) -> Result<Vec<u8>, SiteError> {
    let writer = Writer::new(floors)?;
    let Ok(Bytes(bytes)) = writer.write(Bytes(Vec::with_capacity(writer.site_bytes())));
    Ok(bytes)
}

/// Builds the site file of one floor: its site map, its plan, and its structure as layer 1 where it is given.
///
/// # Errors
/// As [`build`]; and a name that no floor can have.
pub fn floor_bytes(
    name: &str,
    raster: &PlanRaster,
    plan: &PackedPlan,
    structure: Option<&PackedPlan>,
    options: &BuildOptions,
) -> Result<Vec<u8>> {
    let map = build(raster, plan, structure, options)?;
    let floor = Floor::new(name, SiteMap::new(&map)?, plan.view(), structure.map(PackedPlan::view))?;
    Ok(site_bytes(&[floor])?)
}
