//! What a page works with: files, a plan, a site, frames.

use crate::message::{Reply, error, floats, reply};
use crate::place::{Question, Sought, heat};
use crate::plan::{Options, Plan};
use crate::progress::Told;
use compass_host::dataset::tum::Pose;
use compass_host::input;
use compass_host::interior::Places;
use compass_host::sample::{FRAME_HEIGHT_M, FRAME_PITCH_ROLL_DEG, FRAME_PIXELS, FRAME_POSE};
use compass_host::simulate::{Scene, SceneOptions, render};
use compass_host::site_file::floor_bytes_with_progress;
use compass_host::{BuildOptions, Calibration, Frame, SiteFile, VisualDescriptor, dual_image};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The state of a page.
#[derive(Debug, Default)]
pub struct Session {
    plan: Option<Plan>,
    site: Option<SiteFile>,
    calibration: Option<Calibration>,
    frames: [Option<Frame>; 2],
    /// What the frames show that were located last.
    seen: Option<VisualDescriptor>,
}

#[derive(Deserialize)]
#[serde(tag = "call", rename_all = "snake_case", deny_unknown_fields)]
enum Request {
    /// Takes the bytes as a file of this name.
    Lend { name: String },
    /// Makes the file the plan.
    Plan {
        name: String,
        #[serde(default)]
        options: Options,
    },
    /// Makes the sample building the plan.
    Sample,
    /// What surrounds a place in the plan.
    Scan { at: [f64; 2], heading: f64 },
    /// Builds the site of the plan.
    Build {
        spacing: f64,
        #[serde(default)]
        inside: Vec<[f64; 2]>,
        #[serde(default)]
        region: Option<[f64; 4]>,
    },
    /// Makes the file the site.
    Site { name: String },
    /// The bytes of the site file.
    Save,
    /// Takes the cameras from the file, or those of the simulator.
    Calibration { name: Option<String> },
    /// Takes the files as frames.
    Frames { files: [Option<String>; 2] },
    /// Renders frames from a place in the plan, with the simulator's cameras.
    Simulate {
        #[serde(default)]
        at: Option<[f64; 2]>,
        #[serde(default)]
        heading: f64,
        #[serde(default)]
        seed: Option<u64>,
    },
    /// A frame as pixels.
    Image { camera: usize },
    /// Finds the frames on the site.
    Locate(Question),
    /// How well the candidates of the first floor match what the located frames show.
    Heat,
}

#[derive(Serialize)]
struct Built<'a> {
    floors: Vec<&'a str>,
    candidates: usize,
}

#[derive(Serialize)]
struct Taken {
    /// Width and height of each frame, pixels.
    sizes: [Option<[u32; 2]>; 2],
}

impl Session {
    /// Answers a request; what is wrong with it is the answer `{"error": ...}`.
    ///
    /// | request | bytes with it | reply | bytes with it |
    /// |---|---|---|---|
    /// | `lend` `name` | the file | `null` | |
    /// | `plan` `name` `options`; `sample` | | name, size, origin, notes, size of the picture | picture, a byte a pixel |
    /// | `scan` `at` `heading` | | `null` | 360 ranges, 360 hit types, 5 x 360 channels, f32 |
    /// | `build` `spacing`; `site` `name` | | floors, number of candidates | x and y of each, f32 |
    /// | `save` | | `null` | the site file |
    /// | `calibration` `name` | | `null` | |
    /// | `frames` `files`; `simulate` `at` `heading` | | sizes | |
    /// | `image` `camera` | | sizes | red, green and blue |
    /// | `locate` `mount` `camera_height` | | pose, candidates, overlays | |
    /// | `heat` | | `null` | x, y and score of candidates, f32 |
    pub fn answer(&mut self, json: &str, bytes: &[u8]) -> Reply {
        let answered = serde_json::from_str(json)
            .map_err(|error| format!("not a request: {error}"))
            .and_then(|request| self.call(request, bytes));
        answered.unwrap_or_else(|what| error(&what))
    }

    fn call(&mut self, request: Request, bytes: &[u8]) -> Result<Reply, String> {
        match request {
            Request::Lend { name } => {
                input::lend(name, bytes);
                Ok(reply(&(), &[]))
            }
            Request::Plan { name, options } => self.take_plan(Plan::read(&name, &options)?),
            Request::Sample => self.take_plan(Plan::sample()?),
            Request::Scan { at, heading } => self.plan()?.scan(at, heading),
            Request::Build { spacing, inside, region } => {
                let places = Places { points: inside, regions: region.into_iter().collect() };
                self.build(BuildOptions { spacing_m: spacing, places, ..BuildOptions::default() })
            }
            Request::Site { name } => {
                self.site = Some(SiteFile::read(Path::new(&name)).map_err(|error| error.to_string())?);
                self.built()
            }
            Request::Save => Ok(reply(&(), self.site()?.as_bytes())),
            Request::Calibration { name } => {
                self.calibration = Some(calibration(name.as_deref())?);
                Ok(reply(&(), &[]))
            }
            Request::Frames { files } => self.take_frames(&files),
            Request::Simulate { at, heading, seed } => self.simulate(at, heading, seed),
            Request::Image { camera } => self.image(camera),
            Request::Locate(question) => self.locate(&question),
            Request::Heat => self.heat(),
        }
    }

    fn take_plan(&mut self, plan: Plan) -> Result<Reply, String> {
        // A site of another plan would give poses that are not on this one.
        self.site = None;
        Ok(self.plan.insert(plan).describe())
    }

    fn plan(&self) -> Result<&Plan, String> {
        self.plan.as_ref().ok_or_else(|| "there is no plan yet".to_owned())
    }

    fn site(&self) -> Result<&SiteFile, String> {
        self.site.as_ref().ok_or_else(|| "there is no site yet: build one, or open a site file".to_owned())
    }

    fn build(&mut self, options: BuildOptions) -> Result<Reply, String> {
        let Plan { name, raster, packed, structure, .. } = self.plan()?;
        let bytes = floor_bytes_with_progress(name, raster, packed, structure.as_ref(), &options, &Told)
            .map_err(|error| format!("{name}: {error}"))?;
        self.site = Some(SiteFile::from_bytes(bytes).map_err(|error| error.to_string())?);
        self.built()
    }

    fn built(&self) -> Result<Reply, String> {
        let floors = self.site()?.floors();
        let map = &floors[0].map;
        let places = (0..map.len()).filter_map(|number| map.position(number));
        let places = floats(places.flat_map(|at| [at.x.to_num(), at.y.to_num()]));
        let names = floors.iter().map(|floor| floor.name().unwrap_or_default()).collect();
        Ok(reply(&Built { floors: names, candidates: map.len() }, &places))
    }

    fn take_frames(&mut self, files: &[Option<String>; 2]) -> Result<Reply, String> {
        let read = |file: &Option<String>| {
            file.as_ref()
                .map(|file| Frame::read(Path::new(file)).map_err(|error| error.to_string()))
                .transpose()
        };
        let [first, second] = files;
        let frames = [read(first)?, read(second)?];
        if frames.iter().all(Option::is_none) {
            return Err("no frame: give that of cam0, of cam1, or both".to_owned());
        }
        let calibration = self.calibration.as_ref().ok_or("there is no calibration yet")?;
        self.frames = dual_image::split(calibration, frames).0;
        Ok(self.taken())
    }

    fn taken(&self) -> Reply {
        let sizes =
            self.frames.each_ref().map(|frame| frame.as_ref().map(|frame| [frame.width(), frame.height()]));
        reply(&Taken { sizes }, &[])
    }

    /// Frames of the simulator; without a place, those of the command's demo.
    fn simulate(&mut self, at: Option<[f64; 2]>, heading: f64, seed: Option<u64>) -> Result<Reply, String> {
        let ([x, y], heading) = at.map_or(FRAME_POSE, |at| (at, heading));
        // Nothing is rendered from inside a wall or outside the plan.
        self.plan()?.packed.scan([x, y], heading).map_err(|error| error.to_string())?;
        let calibration = calibration(None)?;
        let rig = calibration.rig([Some(FRAME_PIXELS); 2]).map_err(|error| error.to_string())?;
        let [pitch, roll] = FRAME_PITCH_ROLL_DEG;
        let pose = Pose::looking(0, [x, y, FRAME_HEIGHT_M], heading, pitch, roll);
        let options = seed.map_or_else(SceneOptions::default, |seed| SceneOptions {
            seed,
            style: seed,
            ..SceneOptions::default()
        });
        let images = render(&Scene::new(&options, &self.plan()?.raster), &rig, &pose);
        self.frames = images.map(|image| image.and_then(Frame::from_rgb));
        self.calibration = Some(calibration);
        Ok(self.taken())
    }

    fn image(&self, camera: usize) -> Result<Reply, String> {
        let frame = self.frames.get(camera).and_then(Option::as_ref);
        let frame = frame.ok_or_else(|| format!("there is no frame of cam{camera}"))?;
        let gray = || frame.gray().pixels().iter().flat_map(|level| [*level; 3]).collect();
        Ok(reply(&[frame.width(), frame.height()], &frame.rgb().map_or_else(gray, <[u8]>::to_vec)))
    }

    fn locate(&mut self, question: &Question) -> Result<Reply, String> {
        let calibration = self.calibration.as_ref().ok_or("there is no calibration yet")?;
        let frames = self.frames.each_ref().map(Option::as_ref);
        if frames.iter().all(Option::is_none) {
            return Err("there are no frames yet".to_owned());
        }
        let (reply, seen) = Sought { site: self.site()?, calibration, frames }.locate(question)?;
        self.seen = seen;
        Ok(reply)
    }

    fn heat(&self) -> Result<Reply, String> {
        let floors = self.site()?.floors();
        let values = self.seen.as_ref().map(|seen| heat(&floors[0].map, seen));
        Ok(reply(&(), &values.unwrap_or_default()))
    }
}

fn calibration(name: Option<&str>) -> Result<Calibration, String> {
    match name {
        None => Ok(Calibration::nominal()),
        Some(name) => Calibration::load(Path::new(name)).map_err(|error| error.to_string()),
    }
}
