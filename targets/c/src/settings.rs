//! How the pipeline works: presets, and the fields worth changing.

use crate::failure::Failure;
use compass_core::Settings;
use compass_core::locator::{Field, Smoothing};
use compass_core::pose::Headings;
use compass_core::pose::locate::Effort;
use compass_core::vision::panorama::Resolution;

/// Where settings start.
#[repr(i32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CompassPreset {
    /// For a microcontroller with 512 KiB of RAM, and frames of 368 x 360 pixels.
    Board = 1,
    /// For a computer: 9.2 MB of memory for frames of 1472 x 1440 pixels.
    Full = 2,
}

/// Whether frames are smoothed where windows are sought.
#[repr(i32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CompassSmoothing {
    /// Frames are taken as they are.
    Off = 0,
    /// Each stage smooths its frames anew: more work, no more memory.
    Again = 1,
    /// Smoothed frames are kept: a byte of memory a pixel. The same poses as with Again.
    Kept = 2,
}

/// A preset as C gives it: any number. The header calls it `CompassPreset`.
#[repr(transparent)]
#[derive(Debug, Clone, Copy)]
pub struct AnyPreset(pub(crate) i32);

/// A smoothing as C gives it: any number. The header calls it `CompassSmoothing`.
#[repr(transparent)]
#[derive(Debug, Clone, Copy)]
pub struct AnySmoothing(pub(crate) i32);

/// Work of the search.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassEffort {
    /// Poses that are refined, 8 to 48.
    pub refined_poses: u8,
    /// Poses of these that are refined to the end, 1 to 48: the others are right to a decimetre or two.
    pub refined_fully: u8,
    /// Stride of the rays that coarse refinement casts, 4 to 36.
    pub rays: u8,
}

/// How the pipeline works. Start from compass_settings and change what differs.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassSettings {
    /// The preset that the fields come from: of what has no field here its values hold.
    pub preset: AnyPreset,
    /// Whether frames are smoothed.
    pub smoothing: AnySmoothing,
    /// Segments kept of each frame, 1 to 65536.
    pub segments: u32,
    /// Near-vertical segments of both frames, 1 to 65536.
    pub vertical_segments: u32,
    /// Pairs of edges that are scored as windows, 1 to 65536.
    pub boxes: u32,
    /// Windows all around, 1 to 65536.
    pub windows: u32,
    /// Poses that the search keeps for refinement, 64 to 4096.
    pub pool: u32,
    /// Headings at which candidates are scored: 40 or 90.
    pub headings: u16,
    /// Finest cells of the panorama, in a degree: 2 or 4. Lenses of fewer than 3 pixels a degree have 2 in any case.
    pub panorama_per_degree: u8,
    /// 1 if segments are sought within 95 degrees of the optical axis alone (a bit of memory a pixel), else 0.
    pub lens_field_mask: u8,
    /// Work of the search where the camera's height is unknown.
    pub effort: CompassEffort,
    /// Work of the search where it is known.
    pub effort_at_known_height: CompassEffort,
}

const _: () = {
    let ([_, refined], [_, pool]) = (Field::RefinedPoses.range(), Field::Pool.range());
    assert!(refined == 48 && pool == 4096, "as the comments say");
};

impl CompassSettings {
    /// The values of a preset; for another number settings that are refused.
    pub(crate) fn of(preset: AnyPreset) -> Self {
        let Ok(settings) = base(preset) else { return Self::NONE };
        let Settings { segments, vertical_segments, boxes, windows, pool, .. } = settings;
        let [segments, vertical_segments, boxes, windows, pool] =
            [segments, vertical_segments, boxes, windows, pool].map(|count| count as u32);
        let smoothing = match settings.smoothing {
            Smoothing::Off => CompassSmoothing::Off,
            Smoothing::Again => CompassSmoothing::Again,
            Smoothing::Kept => CompassSmoothing::Kept,
        };
        Self {
            preset,
            smoothing: AnySmoothing(smoothing as i32),
            segments,
            vertical_segments,
            boxes,
            windows,
            pool,
            headings: settings.headings.count(),
            panorama_per_degree: settings.panorama.per_degree() as u8,
            lens_field_mask: settings.lens_field_mask.into(),
            effort: CompassEffort::new(&settings.effort),
            effort_at_known_height: CompassEffort::new(&settings.effort_at_known_height),
        }
    }

    /// No preset: refused.
    const NONE: Self = {
        const EFFORT: CompassEffort = CompassEffort { refined_poses: 0, refined_fully: 0, rays: 0 };
        Self {
            preset: AnyPreset(0),
            smoothing: AnySmoothing(0),
            segments: 0,
            vertical_segments: 0,
            boxes: 0,
            windows: 0,
            pool: 0,
            headings: 0,
            panorama_per_degree: 0,
            lens_field_mask: 0,
            effort: EFFORT,
            effort_at_known_height: EFFORT,
        }
    };

    /// What the core knows them as.
    ///
    /// # Errors
    /// [`Failure::Preset`], [`Failure::Setting`].
    pub(crate) fn check(&self) -> Result<Settings, Failure> {
        let base = base(self.preset)?;
        Ok(Settings {
            smoothing: self.smoothing()?,
            segments: ranged("segments", self.segments, Field::Segments)?,
            vertical_segments: ranged("vertical_segments", self.vertical_segments, Field::VerticalSegments)?,
            boxes: ranged("boxes", self.boxes, Field::Boxes)?,
            windows: ranged("windows", self.windows, Field::Windows)?,
            pool: ranged("pool", self.pool, Field::Pool)?,
            headings: match self.headings {
                40 => Headings::N40,
                90 => Headings::N90,
                _ => return Err(Failure::Setting("headings (40 or 90)", 40, 90)),
            },
            panorama: match self.panorama_per_degree {
                2 => Resolution::COARSE,
                4 => Resolution::FINE,
                _ => return Err(Failure::Setting("panorama_per_degree (2 or 4)", 2, 4)),
            },
            lens_field_mask: flag("lens_field_mask", self.lens_field_mask)?,
            effort: self.effort.check()?,
            effort_at_known_height: self.effort_at_known_height.check()?,
            ..base
        })
    }

    fn smoothing(&self) -> Result<Smoothing, Failure> {
        const OFF: i32 = CompassSmoothing::Off as i32;
        const AGAIN: i32 = CompassSmoothing::Again as i32;
        const KEPT: i32 = CompassSmoothing::Kept as i32;
        match self.smoothing.0 {
            OFF => Ok(Smoothing::Off),
            AGAIN => Ok(Smoothing::Again),
            KEPT => Ok(Smoothing::Kept),
            _ => Err(Failure::Setting("smoothing", OFF as u32, KEPT as u32)),
        }
    }
}

impl CompassEffort {
    const fn new(effort: &Effort) -> Self {
        let Effort { refined_poses, refined_fully, rays } = *effort;
        Self { refined_poses: refined_poses as u8, refined_fully: refined_fully as u8, rays: rays as u8 }
    }

    fn check(&self) -> Result<Effort, Failure> {
        Ok(Effort {
            refined_poses: ranged("effort.refined_poses", self.refined_poses.into(), Field::RefinedPoses)?,
            refined_fully: ranged("effort.refined_fully", self.refined_fully.into(), Field::RefinedFully)?,
            rays: ranged("effort.rays", self.rays.into(), Field::Rays)?,
        })
    }
}

fn base(preset: AnyPreset) -> Result<Settings, Failure> {
    const BOARD: i32 = CompassPreset::Board as i32;
    const FULL: i32 = CompassPreset::Full as i32;
    match preset.0 {
        BOARD => Ok(Settings::BOARD),
        FULL => Ok(Settings::FULL),
        _ => Err(Failure::Preset),
    }
}

fn ranged(name: &'static str, value: u32, field: Field) -> Result<usize, Failure> {
    let [least, most] = field.range().map(|bound| bound as u32);
    if (least..=most).contains(&value) {
        Ok(value as usize)
    } else {
        Err(Failure::Setting(name, least, most))
    }
}

fn flag(name: &'static str, value: u8) -> Result<bool, Failure> {
    match value {
        0 | 1 => Ok(value == 1),
        _ => Err(Failure::Setting(name, 0, 1)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_those_of_the_core() {
        for (preset, settings) in
            [(CompassPreset::Board, Settings::BOARD), (CompassPreset::Full, Settings::FULL)]
        {
            assert_eq!(CompassSettings::of(AnyPreset(preset as i32)).check().unwrap(), settings);
        }
        for preset in [0, -1, 3] {
            assert!(matches!(CompassSettings::of(AnyPreset(preset)).check(), Err(Failure::Preset)));
        }
    }
}
