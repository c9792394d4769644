use super::*;
use crate::base::num::Metres;
use crate::base::raster::BitMask;
use crate::pose::locate::Effort;
use crate::pose::track::Track;
use crate::vision::camera::{Bearing, Camera, Intrinsics, KannalaBrandt};
use nalgebra::{Matrix3, Vector3};
use std::string::ToString as _;
use std::vec::Vec;
use std::{format, vec};

const UP: UpHint = UpHint::Up(Bearing::new(0.0, 1.0, 0.0));
const PRIOR: Prior = Prior::new(UP, HeightPrior::camera(1.6));

/// The sample that all targets compute on.
struct Sample {
    site: Vec<u8>,
    frames: [Vec<u8>; 2],
}

impl Sample {
    fn read() -> Self {
        let read = |name: &str| {
            std::fs::read(format!("{}/../tests/vectors/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
        };
        Self {
            site: read("sample.site"),
            frames: [read("frame_368x360_cam0.gray"), read("frame_368x360_cam1.gray")],
        }
    }

    fn frames(&self) -> Frames<'_> {
        self.frames.each_ref().map(|pixels| Some(GrayImage::new(pixels, 368, 360).unwrap().into()))
    }

    fn locator(&self, settings: Settings) -> Locator<'_, Vec<u32>> {
        let site = Site::new(&self.site).unwrap();
        Locator::new(&site, rig(), settings, vec![7; settings.memory_words(368, 360)]).unwrap()
    }
}

fn rig() -> Rig {
    let view = |[fx, fy, cx, cy]: [f32; 4], k| {
        let lens = KannalaBrandt::new(Intrinsics { fx, fy, cx, cy }, k).unwrap();
        View::new(Camera::KannalaBrandt(lens), 368, 360)
    };
    let front = view([116.0, 116.1, 182.95, 179.9], [0.024, -0.0105, -0.0016, 0.000_14]);
    let back = View {
        rotation: Matrix3::new(
            -0.999_975,
            0.005_025,
            0.004_975,
            0.005,
            0.999_974_7,
            -0.005_025,
            -0.005,
            -0.005,
            -0.999_974_9,
        ),
        position: Vector3::new(0.0012, -0.0007, -0.038),
        ..view([116.25, 116.3, 183.65, 179.2], [0.025, -0.0107, -0.001_55, 0.000_13])
    };
    Rig::new([Some(front), Some(back)]).unwrap()
}

/// One camera of 64 x 48 pixels.
fn small_rig() -> Rig {
    let lens = KannalaBrandt::new(Intrinsics { fx: 30.0, fy: 30.0, cx: 32.0, cy: 24.0 }, [0.0; 4]);
    Rig::new([Some(View::new(Camera::KannalaBrandt(lens.unwrap()), 64, 48)), None]).unwrap()
}

#[test]
fn a_board_of_512_kib_holds_two_frames_of_368_by_360() {
    let words = Settings::BOARD.memory_words(368, 360);
    let bytes = 4 * words + size_of::<Locator<'_>>() + size_of::<Track>();
    // Beside it the stack, of which no stage takes more than 32 KiB.
    assert!(bytes + (32 << 10) < 512 << 10, "{bytes}");
}

#[test]
fn memory_that_is_missing_is_counted_in_bytes() {
    let both = [Smoothing::Off, Smoothing::Again, Smoothing::Kept];
    for (smoothing, lens_field_mask) in both.into_iter().flat_map(|s| [(s, false), (s, true)]) {
        let settings = Settings { smoothing, lens_field_mask, ..Settings::BOARD };
        let words = settings.memory_words_of(&rig());
        assert_eq!(words, settings.memory_words(368, 360), "both cameras have that size");
        assert!(Locator::<_, _, 1>::without_site(rig(), settings, vec![0; words]).is_ok());
        let short = Locator::<_, _, 1>::without_site(rig(), settings, vec![0; words - 3]);
        assert_eq!(short.unwrap_err(), Error::Memory { missing_bytes: 12 });
    }
}

#[test]
fn every_stage_fits_into_the_memory_and_into_no_less() {
    for settings in [Settings::BOARD, Settings { smoothing: Smoothing::Kept, ..Settings::FULL }] {
        let layout = settings.layout(&rig());
        let fits = |memory: &mut [u32]| {
            let cameras = [0, 1].map(|camera| layout.detector(memory, camera).is_some());
            let windows = layout.windows(memory, settings.panorama).is_some();
            let (arcs, boundary) = (layout.arcs(memory).is_some(), layout.boundary(memory).is_some());
            cameras == [true; 2] && windows && arcs && boundary && layout.search(memory).is_some()
        };
        let mut memory = vec![0; settings.memory_words(368, 360)];
        assert!(fits(&mut memory));
        memory.pop();
        assert!(!fits(&mut memory));
    }
}

#[test]
fn frames_that_do_not_fit_are_named() {
    let pixels = [90; 64 * 48];
    let frame = |height| Some(Frame::from(GrayImage::new(&pixels, 64, height).unwrap()));
    let memory = vec![0; Settings::BOARD.memory_words(64, 48)];
    let mut locator: Locator<'_, _> = Locator::without_site(small_rig(), Settings::BOARD, memory).unwrap();
    let mut refused = |frames| locator.locate(&frames, &PRIOR).unwrap_err();
    let missing = refused([None, None]);
    assert_eq!(missing, Error::Camera { camera: 0, missing: true });
    assert_eq!(missing.to_string(), "the frame of cam0 is missing");
    let unknown = refused([frame(48), frame(48)]);
    assert_eq!(unknown.to_string(), "there is a frame of cam1, which the rig does not have");
    let size = refused([frame(40), None]);
    assert_eq!(size.to_string(), "the frame of cam0 has 64 x 40 pixels, the rig says 64 x 48");
    assert_eq!(refused([frame(48), None]), Error::Up, "gray alone has no lines");
    let frames = [frame(48), None];
    let axis = locator.segment(&frames).unwrap().level(&Bearing::z());
    assert_eq!(axis.unwrap_err(), Error::Axis);
    let missing_words = Settings::BOARD.memory_words(368, 360) - Settings::BOARD.memory_words(64, 48);
    assert_eq!(locator.set_rig(rig()), Err(Error::Memory { missing_bytes: 4 * missing_words }));
}

#[test]
fn a_site_of_too_many_layers_is_refused_whole() {
    let sample = Sample::read();
    let site = Site::new(&sample.site).unwrap();
    let memory = vec![0; Settings::BOARD.memory_words(368, 360)];
    let mut one: Locator<'_, _, _, 1> = Locator::new(&site, rig(), Settings::BOARD, memory).unwrap();
    assert_eq!(one.add_site(&site), Err(Error::Layers { most: 1 }));
    assert_eq!(one.layers().len(), 1);
    let mut two: Locator<'_, _, _, 2> = Locator::new(&site, rig(), Settings::BOARD, one.memory).unwrap();
    two.add_site(&site).unwrap();
    assert_eq!([0, 1].map(|layer| two.layers()[layer].floor), [0, 1]);
}

/// Bits of a fix: poses with their scores, and the heights.
fn bits(fix: &Fix<'_>) -> (Vec<crate::pose::ScoredPose>, [i8; 2]) {
    (fix.poses().to_vec(), fix.heights().to_rungs())
}

#[test]
fn one_call_and_its_stages_give_the_same_fix() {
    let sample = Sample::read();
    let mut locator = sample.locator(Settings::BOARD);
    let fix = locator.locate(&sample.frames(), &PRIOR).unwrap();
    let pose = fix.pose().unwrap();
    assert_eq!((fix.floor_name(), pose.floor, fix.layer_number()), (Some("ground"), 0, Some(0)));
    let truth = crate::base::num::Point::new(Metres::lit("4.12"), Metres::lit("17.77"));
    assert!(pose.at.within(truth, Metres::lit("0.4")), "{pose:?}");
    assert!(fix.probability() > 0.5 && fix.camera_height_m() == 1.6);
    let mut seen = locator.segment(&sample.frames()).unwrap().level_near(UP).unwrap().see();
    let (windows, cells) = (seen.window_evidence().clone(), seen.boundaries().unwrap().cells().to_vec());
    assert_eq!(bits(&seen.locate(PRIOR.heights)), bits(&fix));
    assert_eq!(bits(&seen.locate(PRIOR.heights)), bits(&fix), "what was seen stays");
    // Evidence that was kept gives it again, without frames.
    let memory = vec![9; Settings::BOARD.memory_words(0, 0)];
    let mut later: Locator<'_, _> = Locator::without_rig(Settings::BOARD, memory).unwrap();
    later.add_site(&Site::new(&sample.site).unwrap()).unwrap();
    let boundaries = crate::vision::boundary::BoundaryEvidence::new(&cells).unwrap();
    assert_eq!(bits(&later.recall(&boundaries, &windows).locate(PRIOR.heights)), bits(&fix));
}

#[test]
fn a_trace_sees_the_stages_in_their_order() {
    #[derive(Default)]
    struct Stages(Vec<(Stage, bool)>);
    impl Trace for Stages {
        fn begin(&mut self, stage: Stage) {
            self.0.push((stage, true));
        }
        fn end(&mut self, stage: Stage, picture: Picture<'_>) {
            match picture {
                Picture::Segments(segments) => assert!(segments.len() > 40),
                Picture::Windows { windows, boxes, .. } => assert!(windows.len() < boxes.len()),
                Picture::Up(up) => assert!(up.is_some()),
                _ => {}
            }
            self.0.push((stage, false));
        }
    }
    let sample = Sample::read();
    let mut locator = sample.locator(Settings::BOARD).with_trace(Stages::default());
    locator.locate(&sample.frames(), &PRIOR).unwrap();
    let stages =
        [Stage::Segments(0), Stage::Segments(1), Stage::Up, Stage::Windows, Stage::Boundaries, Stage::Locate];
    let expected: Vec<_> = stages.into_iter().flat_map(|stage| [(stage, true), (stage, false)]).collect();
    assert_eq!(locator.trace_mut().0, expected);
}

#[test]
fn settings_out_of_their_ranges_are_refused() {
    let effort = |effort| Settings { effort_at_known_height: effort, ..Settings::BOARD };
    let wrong = [
        ("segments", Settings { segments: 0, ..Settings::BOARD }),
        ("boxes", Settings { boxes: usize::MAX, ..Settings::BOARD }),
        ("windows", Settings { windows: 1 << 62, ..Settings::BOARD }),
        // One pose in the pool would have no second best, and its probability would be near 1.
        ("pool", Settings { pool: 1, ..Settings::BOARD }),
        ("pool", Settings { pool: 1 << 60, ..Settings::BOARD }),
        ("inlier_tolerance_deg", Settings { inlier_tolerance_deg: Some(f32::NAN), ..Settings::BOARD }),
        ("refined_poses", effort(Effort { refined_poses: 1, ..Effort::FULL })),
        ("rays", effort(Effort { rays: 361, ..Effort::FULL })),
    ];
    for (field, settings) in wrong {
        let memory = vec![0; settings.memory_words(0, 0)];
        let refused = Locator::<_>::without_rig(settings, memory).map(|_| ()).unwrap_err();
        assert!(
            matches!(refused, Error::Setting { field: wrong, .. } if wrong.name() == field),
            "{field}: {refused}"
        );
    }
}

#[test]
fn frames_and_masks_must_have_the_size_of_the_rig() {
    let sample = Sample::read();
    let mut locator = sample.locator(Settings::BOARD);
    let bits = [0xff; 8];
    let mut frames = sample.frames();
    frames[1].as_mut().unwrap().excluded = ExclusionMask::Mask(BitMask::new(&bits, 8, 8).unwrap());
    let refused = locator.locate(&frames, &PRIOR).map(|_| ()).unwrap_err();
    assert_eq!(refused, Error::Mask { camera: 1, expected: [368, 360], found: [8, 8] });
    let wide = View { width: 8193, ..*rig().view(0).unwrap() };
    let refused = locator.set_rig(Rig::new([Some(wide), None]).unwrap()).unwrap_err();
    assert_eq!(refused, Error::Side { camera: 0, most: 8192 });
}

#[test]
fn boundaries_are_seen_in_excluded_pixels_too() {
    let sample = Sample::read();
    let mut locator = sample.locator(Settings::BOARD);
    let mut cells = |frames: &Frames<'_>| {
        let levelled = locator.segment(frames).unwrap().level_near(PRIOR.up).unwrap();
        let mut seen = levelled.see();
        let known = seen.window_evidence().confidence.sixteenths().iter().filter(|c| **c > 0).count();
        (seen.boundaries().unwrap().cells().to_vec(), known)
    };
    let (all, windows) = cells(&sample.frames());
    let bits = vec![0xff; 368_usize.div_ceil(8) * 360];
    let mut frames = sample.frames();
    for frame in frames.iter_mut().flatten() {
        frame.excluded = ExclusionMask::Mask(BitMask::new(&bits, 368, 360).unwrap());
    }
    let (masked, unseen) = cells(&frames);
    assert!(all == masked && windows > 180 && unseen == 0, "{windows} {unseen}");
}

#[test]
fn evidence_of_any_bits_has_a_pose() {
    let sample = Sample::read();
    let windows = crate::vision::windows::WindowEvidence::NOTHING;
    for bits in [i8::MIN, i8::MAX] {
        let cells = vec![crate::base::num::CellNats::from_bits(bits); crate::vision::boundary::CELLS];
        let mut locator = sample.locator(Settings::BOARD);
        let boundaries = crate::vision::boundary::BoundaryEvidence::new(&cells).unwrap();
        let fix = locator.recall(&boundaries, &windows).locate(PRIOR.heights);
        assert!(fix.best().is_some() && fix.probability().is_finite());
    }
}

#[test]
fn stripes_of_a_large_frame_are_no_trouble_to_the_detector() {
    // Edges end at the border of the lens, so that lines branch far from where they began.
    let (width, height) = (2000_u16, 2000_u16);
    let pixels: Vec<u8> = (0..2000 * 2000).map(|i| if i % 2000 / 6 % 2 == 0 { 200 } else { 10 }).collect();
    let intrinsics = Intrinsics { fx: 667.0, fy: 667.0, cx: 1000.0, cy: 1000.0 };
    let lens = crate::vision::camera::Equidistant::new(intrinsics).unwrap();
    let rig = Rig::new([Some(View::new(Camera::Equidistant(lens), width, height)), None]).unwrap();
    let settings = Settings { lens_field_mask: true, ..Settings::BOARD };
    let mut locator: Locator<'_, _> =
        Locator::without_site(rig, settings, vec![0; settings.memory_words_of(&rig)]).unwrap();
    let frame = GrayImage::new(&pixels, width.into(), height.into()).unwrap();
    assert!(!locator.segment(&[Some(frame.into()), None]).unwrap().segments(0).is_empty());
}
