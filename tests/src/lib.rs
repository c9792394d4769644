//! Helpers shared by the tests that span the crates.

pub mod bag;

use compass_core::map::site_map::SiteMap;
use compass_host::calibration::{Calibration, NOMINAL_YAML};
use compass_host::dataset::tum::Pose;
use compass_host::plan_import::PlanRaster;
use compass_host::plan_import::structure::{DEFAULT_THICKNESS_M, keep_structure};
use compass_host::sample;
use compass_host::simulate::{Renderer, Scene, SceneOptions};
use compass_host::site::{self, BuildOptions, PackedPlan};
use compass_host::site_file::floor_bytes;
use image::RgbImage;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// A free pose of the sample building: its demo pose, as `--at` and `--heading` take it.
pub const POSE: &str = "--at 13.37,3.68 --heading 74";

/// The `compass` binary, built once per test process beside the test executable, as `env!("CARGO_BIN_EXE_compass")`
/// would be in its own package.
///
/// # Panics
/// When the build fails.
pub fn compass() -> &'static Path {
    static BINARY: OnceLock<PathBuf> = OnceLock::new();
    BINARY.get_or_init(|| {
        let test = std::env::current_exe().expect("path of the test");
        // target/PROFILE/deps/test
        let folder = test.ancestors().nth(2).expect("folder of the profile");
        let target = folder.parent().expect("target folder");
        // The folder of the profiles dev and test is named debug.
        let profile = match folder.file_name().and_then(|n| n.to_str()) {
            Some("debug") | None => "test",
            Some(name) => name,
        };
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        cargo.args([
            "build",
            "--quiet",
            "--package",
            "compass-host",
            "--bin",
            "compass",
            "--profile",
            profile,
        ]);
        cargo.arg("--target-dir").arg(target).current_dir(env!("CARGO_MANIFEST_DIR"));
        assert!(cargo.status().expect("cargo runs").success(), "compass does not build: {cargo:?}");
        folder.join("compass").with_extension(std::env::consts::EXE_EXTENSION)
    })
}

/// The sample building as a plan.
pub fn sample_plan() -> &'static (PlanRaster, PackedPlan) {
    static PLAN: OnceLock<(PlanRaster, PackedPlan)> = OnceLock::new();
    PLAN.get_or_init(|| {
        let raster = PlanRaster::from(sample::building());
        let packed = PackedPlan::new(&raster).expect("sample building packs");
        (raster, packed)
    })
}

/// The site map of the sample building with default options, of the plan as drawn alone.
pub fn sample_map() -> &'static [u8] {
    static MAP: OnceLock<Vec<u8>> = OnceLock::new();
    MAP.get_or_init(|| {
        let (raster, plan) = sample_plan();
        let bytes = site::build(raster, plan, None, &BuildOptions::default()).expect("sample map builds");
        assert!(SiteMap::new(&bytes).is_ok());
        bytes
    })
}

/// The site file of the sample building with default options: the floor `sample`, with its structure as layer 1.
pub fn sample_site() -> &'static [u8] {
    static SITE: OnceLock<Vec<u8>> = OnceLock::new();
    SITE.get_or_init(|| {
        let (raster, plan) = sample_plan();
        let kept = keep_structure(raster, DEFAULT_THICKNESS_M).expect("sample building has a structure");
        let structure = PackedPlan::new(&kept).expect("its structure packs");
        floor_bytes("sample", raster, plan, Some(&structure), &BuildOptions::default())
            .expect("the site of one floor builds")
    })
}

/// The frames of cam0 and cam1 of the rig of [`Calibration::nominal`], rendered in the sample building with clutter
/// and people.
///
/// # Panics
/// When `size` has another aspect ratio than the calibrated frames, 736 x 720.
#[must_use]
pub fn sample_frames(pose: &Pose, size: (u32, u32)) -> [RgbImage; 2] {
    static SCENE: OnceLock<Scene> = OnceLock::new();
    let scene = SCENE.get_or_init(|| Scene::new(&SceneOptions::default(), &sample_plan().0));
    let rig =
        Calibration::nominal().rig([Some(size); 2]).expect("size of the shape of the calibrated frames");
    Renderer::new(scene, &rig, None).render(pose).map(|frame| frame.expect("the rig has two cameras"))
}

/// The folder of the recordings; prints a note when a test is skipped without it.
pub fn recordings(test: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("COMPASS_DATA").map(PathBuf::from);
    if folder.is_none() {
        eprintln!("SKIPPED {test}: COMPASS_DATA is not set");
    }
    folder
}

/// A temporary folder with the sample building's `sample.png`, its plain site map `sample.map` and its site file
/// `sample.site`, to run `compass` in.
#[derive(Debug)]
pub struct Folder(tempfile::TempDir);

/// The outcome of a run of `compass`.
#[derive(Debug)]
pub struct Ran {
    /// Exit status; `None` when it was killed.
    pub status: Option<i32>,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

impl Folder {
    /// Creates a folder with the three files.
    ///
    /// # Panics
    /// When they cannot be written.
    #[must_use]
    pub fn new() -> Self {
        static IMAGE: OnceLock<Vec<u8>> = OnceLock::new();
        let folder = Self(tempfile::tempdir().expect("temporary folder"));
        let image = IMAGE.get_or_init(|| {
            let path = folder.path("sample.png");
            sample::image(&sample::building()).save(&path).expect("sample image is written");
            std::fs::read(path).expect("sample image is read")
        });
        folder.write("sample.png", image);
        folder.write("sample.map", sample_map());
        folder.write("sample.site", sample_site());
        folder
    }

    /// The path of a file in the folder.
    #[must_use]
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file in the folder.
    ///
    /// # Panics
    /// When it cannot be written.
    pub fn write(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.path(name), bytes).expect("file is written");
    }

    /// Reads a file in the folder.
    ///
    /// # Panics
    /// When it cannot be read.
    #[must_use]
    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Writes `rig.yaml`, the calibration of [`sample_frames`], and its frames as `cam0.png` and `cam1.png`; returns
    /// the options that name the three.
    ///
    /// # Panics
    /// When they cannot be written.
    #[must_use]
    pub fn write_frames(&self, frames: &[RgbImage; 2]) -> &'static str {
        self.write("rig.yaml", NOMINAL_YAML.as_bytes());
        for (frame, name) in frames.iter().zip(["cam0.png", "cam1.png"]) {
            frame.save(self.path(name)).expect("frame is written");
        }
        "--calib rig.yaml --cam0 cam0.png --cam1 cam1.png"
    }

    /// Runs `compass` in the folder with the words of `line`.
    ///
    /// # Panics
    /// When the binary cannot be started.
    #[must_use]
    pub fn run(&self, line: &str) -> Ran {
        let mut command = Command::new(compass());
        command.args(line.split_whitespace()).current_dir(self.0.path());
        let output = command.output().expect("compass starts");
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("compass writes UTF-8");
        Ran { status: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }

    /// Runs `compass` with `--json -` and returns its standard output, which must be JSON alone.
    ///
    /// # Panics
    /// When it fails, warns, or writes anything else.
    #[must_use]
    pub fn json(&self, line: &str) -> Value {
        let ran = self.run(&format!("{line} --json -"));
        assert_eq!((ran.status, ran.stderr.as_str()), (Some(0), ""), "{line}");
        serde_json::from_str(&ran.stdout).unwrap_or_else(|e| panic!("{line}: {e}: {}", ran.stdout))
    }

    /// The names of everything in the folder, subfolders included.
    #[must_use]
    pub fn names(&self) -> BTreeSet<PathBuf> {
        let mut found = BTreeSet::new();
        let mut open = vec![self.0.path().to_path_buf()];
        while let Some(folder) = open.pop() {
            for entry in std::fs::read_dir(folder).expect("folder is listed").flatten() {
                let path = entry.path();
                if path.is_dir() {
                    open.push(path.clone());
                }
                found.insert(path);
            }
        }
        found
    }
}

impl Default for Folder {
    fn default() -> Self {
        Self::new()
    }
}

/// A JSON value as a number.
///
/// # Panics
/// When it is not a number.
#[must_use]
pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// A JSON array as numbers.
///
/// # Panics
/// When it is not an array of numbers.
#[must_use]
pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap_or_else(|| panic!("{value} is no array")).iter().map(number).collect()
}

/// The angle between two headings in degrees.
#[must_use]
pub fn angle(a: f64, b: f64) -> f64 {
    ((a - b + 180.0).rem_euclid(360.0) - 180.0).abs()
}
