//! Site files in memory: read and checked as a whole, or made from floors.

use crate::input;
use crate::output::Bytes;
use crate::plan_import::PlanRaster;
use crate::progress::{Progress, Silent};
use crate::site::{BuildError, BuildOptions, PackedPlan, build_with_progress};
use compass_core::map::site::{Floor, FloorError, MAX_NAME_BYTES, Site, SiteError, Writer};
use compass_core::map::site_map::{SiteMap, SiteMapError};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a site file could not be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SiteFileError {
    /// The file could not be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file is not a valid site file.
    #[error("{}: {source}", path.display())]
    Site {
        /// The file.
        path: PathBuf,
        /// The invalid field.
        source: SiteError,
    },
    /// The file is not a valid plain site map.
    #[error("{}: {source}", path.display())]
    Map {
        /// The file.
        path: PathBuf,
        /// The invalid field.
        source: SiteMapError,
    },
}

/// Why a floor could not be made from a plan.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FloorBuildError {
    /// The site map could not be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The built map is not valid.
    #[error(transparent)]
    Map(#[from] SiteMapError),
    /// The name is not allowed, or map and plans do not match each other.
    #[error(transparent)]
    Floor(#[from] FloorError),
    /// The floor does not fit into a site file.
    #[error(transparent)]
    Site(#[from] SiteError),
}

/// The bytes of a site file, or of a plain site map, which counts as one floor without name or plan.
#[derive(Debug, Clone)]
pub struct SiteFile {
    bytes: Vec<u8>,
}

/// A floor of a file.
#[derive(Debug, Clone, Copy)]
pub struct SiteFloor<'a> {
    /// The site map with its candidates.
    pub map: SiteMap<'a>,
    /// The whole floor; `None` for a plain site map.
    pub floor: Option<Floor<'a>>,
}

impl SiteFile {
    /// Reads a file and verifies all its checksums.
    ///
    /// # Errors
    /// Names the file and the invalid field.
    pub fn read(path: &Path) -> Result<Self, SiteFileError> {
        let named = || path.to_path_buf();
        let bytes = input::read(path, input::limits().site_bytes)
            .map_err(|source| SiteFileError::Read { path: named(), source })?;
        let map = |source| SiteFileError::Map { path: named(), source };
        match Site::new(&bytes) {
            Err(SiteError::Magic) => SiteMap::new(&bytes).and_then(|map| map.verify()).map_err(map)?,
            site => site
                .and_then(|site| site.verify())
                .map_err(|source| SiteFileError::Site { path: named(), source })?,
        }
        Ok(Self { bytes })
    }

    /// A site in memory, such as [`floor_bytes`] makes; verifies all its checksums.
    ///
    /// # Errors
    /// [`SiteError`] names the invalid field.
    pub fn from_bytes(bytes: Vec<u8>) -> Result<Self, SiteError> {
        Site::new(&bytes)?.verify()?;
        Ok(Self { bytes })
    }

    /// The bytes of the file.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The floors in the order of the file; there is at least one.
    #[must_use]
    pub fn floors(&self) -> Vec<SiteFloor<'_>> {
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
    /// The name of the floor; a plain site map has none.
    #[must_use]
    pub fn name(&self) -> Option<&'a str> {
        self.floor.map(|floor| floor.name())
    }
}

/// A name of a floor from the name of its plan's file.
#[must_use]
pub fn floor_name(plan: &Path) -> String {
    let stem = plan.file_stem().unwrap_or_default().to_string_lossy().replace(char::is_control, "");
    let name = &stem[..stem.floor_char_boundary(MAX_NAME_BYTES)];
    if name.is_empty() { "floor".into() } else { name.into() }
}

/// The site file of these floors.
///
/// # Errors
/// [`SiteError`]: no floor, too many, two with one name, or more bytes than the format can count.
pub fn site_bytes(floors: &[Floor<'_>]) -> Result<Vec<u8>, SiteError> {
    let writer = Writer::new(floors)?;
    let Ok(Bytes(bytes)) = writer.write(Bytes(Vec::with_capacity(writer.site_bytes())));
    Ok(bytes)
}

/// Builds the site file of one floor: its site map, its plan, and, if given, its structure as layer 1.
///
/// # Errors
/// As [`crate::site::build`]; also a name that is not allowed.
pub fn floor_bytes(
    name: &str,
    raster: &PlanRaster,
    plan: &PackedPlan,
    structure: Option<&PackedPlan>,
    options: &BuildOptions,
) -> Result<Vec<u8>, FloorBuildError> {
    floor_bytes_with_progress(name, raster, plan, structure, options, &Silent)
}

/// [`floor_bytes`] with progress reports.
///
/// # Errors
/// As [`floor_bytes`].
pub fn floor_bytes_with_progress(
    name: &str,
    raster: &PlanRaster,
    plan: &PackedPlan,
    structure: Option<&PackedPlan>,
    options: &BuildOptions,
    progress: &dyn Progress,
) -> Result<Vec<u8>, FloorBuildError> {
    let map = build_with_progress(raster, plan, structure, options, progress)?;
    let floor = Floor::new(name, SiteMap::new(&map)?, plan.view(), structure.map(PackedPlan::view))?;
    Ok(site_bytes(&[floor])?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use compass_core::map::site::is_name;

    #[test]
    fn file_names_become_names_of_floors() {
        for (file, name) in [
            ("plans/floor_1.png", "floor_1"),
            ("Erdgeschoß mit Anbau (neu).png", "Erdgeschoß mit Anbau ("),
            ("zweiundzwanzig Zeichen_ß.png", "zweiundzwanzig Zeichen_"),
            ("einundzwanzig Zeichen_ß.png", "einundzwanzig Zeichen_"),
            ("a\nb.png", "ab"),
            ("\n", "floor"),
            ("", "floor"),
        ] {
            assert_eq!(floor_name(Path::new(file)), name);
            assert!(is_name(name), "{name}");
        }
    }
}
