//! The public entry points of `compass-core`, by module in its reading order. Displaying errors is omitted: that code
//! is `core::fmt`'s.

use compass_core::base::confidence::Confidence;
use compass_core::base::ladder;
use compass_core::base::num::{BINS, Point, Turn};
use compass_core::base::raster::{BitMask, GrayImage, RgbImage};
use compass_core::base::scan::{Hit, Scan};
use compass_core::descriptor::matching::{self, Board, Group, Index};
use compass_core::descriptor::signature::Signature;
use compass_core::descriptor::similarity::{Candidate, Peak, Profile, Query};
use compass_core::descriptor::sketch::{Sketch, SketchQuery};
use compass_core::descriptor::spectrum::{self, Correlator, Extent};
use compass_core::descriptor::windows as paper;
use compass_core::descriptor::{Descriptor, channels};
use compass_core::locator::{self, Locator, Prior, Settings};
use compass_core::map::plan::{self, MarchError, Plan, PlanGrid};
use compass_core::map::site::{self, Floor, Site};
use compass_core::map::site_map::{self, Header, Layer, LayerView, PackedScan, Record, Sink, SiteMap};
use compass_core::pose::evidence;
use compass_core::pose::evidence::EvidenceTable;
use compass_core::pose::heights::HeightMemory;
use compass_core::pose::locate;
use compass_core::pose::track::Track;
use compass_core::pose::wall_check;
use compass_core::pose::{self, FloorLayer, PoolEntry, Rows, ScoredPose};
use compass_core::vision::attitude::{self, Arc, Axes, Vertical};
use compass_core::vision::boundary::{BoundaryEvidence, BoundaryFinder, RangeLikelihoods};
use compass_core::vision::camera::{Camera, DoubleSphere, Equidistant, Eucm, KannalaBrandt, Omni, Rig, View};
use compass_core::vision::level_frame::LevelFrame;
use compass_core::vision::panorama::Resolution;
use compass_core::vision::segments;
use compass_core::vision::shot::{self, Shot};
use compass_core::vision::visual_scan;
use compass_core::vision::windows::{self, Edge, VerticalSegment, Window, WindowFinder};
use compass_core::{Fix, LocateError};

use core::hint::black_box;

/// Headings of the search under evidence.
const HEADINGS: usize = 90;

/// The address of a function of any signature.
pub(crate) struct Entry(#[expect(dead_code, reason = "only its presence matters")] *const ());

// SAFETY: the address is never used.
unsafe impl Sync for Entry {}

macro_rules! entries {
    ($($function:expr),* $(,)?) => { [$(Entry($function as *const ())),*] };
}

pub(crate) static ALL: &[Entry] = &entries![
    // num, raster, scan
    Point::within,
    Turn::from_ratio,
    Turn::to_microdegrees,
    Turn::distance,
    Turn::cos_sin,
    BitMask::new,
    BitMask::get,
    BitMask::byte,
    GrayImage::new,
    GrayImage::row,
    RgbImage::new,
    RgbImage::pixel,
    Scan::count,
    Scan::segments,
    // plan
    plan::packed_len,
    plan::pack,
    Plan::new,
    Plan::verify,
    Plan::hit_at,
    Plan::scan,
    cast,
    Plan::cell_centre,
    PlanGrid::cell_centre,
    // descriptor, spectrum
    Descriptor::fill,
    channels::hit_level,
    spectrum::forward,
    spectrum::inverse,
    correlate,
    // similarity, signature
    Confidence::new,
    Confidence::is_certain,
    Peak::score,
    Profile::fill,
    Candidate::fill,
    Query::set,
    Query::channel,
    Query::score,
    Query::parts,
    Query::peak,
    Query::scores,
    Query::load,
    Signature::new,
    Signature::distance,
    // site_map, site
    Header::map_bytes,
    write_map,
    Layer::new,
    PackedScan::new,
    PackedScan::unpack,
    SiteMap::new,
    SiteMap::verify,
    SiteMap::get,
    SiteMap::position,
    walk_map,
    Record::layer,
    Record::scan,
    LayerView::scan,
    Sketch::new,
    SketchQuery::new,
    SketchQuery::rank,
    Sketch::stored,
    Signature::stored,
    LayerView::signature_bytes,
    LayerView::sketch_bytes,
    site::is_name,
    Floor::new,
    Floor::plan,
    Site::new,
    Site::verify,
    Site::floor,
    walk_site,
    site::Writer::new,
    write_site,
    // matching
    Group::fill,
    Index::new,
    Index::len,
    matching::nearest_signatures,
    matching::Match::heading,
    matching::Answer::matches,
    matching::Answer::best,
    matching::Answer::margin,
    Board::scores,
    Board::load,
    matching::shortlist,
    matching::exhaustive,
    // likelihood
    EvidenceTable::plane,
    EvidenceTable::get,
    EvidenceTable::set,
    EvidenceTable::set_plane,
    EvidenceTable::at,
    pose::plane_of,
    Rows::<HEADINGS>::set,
    search,
    pose::refine_coarse,
    pose::refine_final,
    pose::refine,
    pose::refine_fine,
    pose::select_alternatives,
    pose::Alternatives::poses,
    pose::Alternatives::best,
    pose::Alternatives::margin,
    // camera
    KannalaBrandt::new,
    Eucm::new,
    DoubleSphere::new,
    Omni::new,
    Equidistant::new,
    Camera::project,
    Camera::unproject,
    Camera::scaled,
    Camera::intrinsics,
    Camera::max_angle,
    View::new,
    Rig::new,
    Rig::back_to_back,
    Rig::view,
    walk_rig,
    // shot
    Shot::new,
    Shot::verify,
    shot::Writer::new,
    shot::Writer::shot_bytes,
    write_shot,
    // segments
    segments::detect,
    // attitude
    Arc::new,
    Arc::agreement,
    attitude::vertical,
    Vertical::roll_deg,
    Vertical::pitch_deg,
    attitude::building_axes,
    Axes::directions,
    Axes::axis_of,
    // windows
    Resolution::of,
    LevelFrame::new,
    LevelFrame::up,
    LevelFrame::bearing,
    LevelFrame::direction,
    WindowFinder::new,
    WindowFinder::add,
    WindowFinder::finish,
    visit_edges,
    Window::azimuth_deg,
    Window::elevation_deg,
    windows::segment_parameters,
    windows::sky_is_above,
    windows::wants_smoothed,
    windows::image_box,
    paper::find,
    // boundary, sight
    BoundaryFinder::new,
    BoundaryFinder::add,
    BoundaryFinder::finish,
    ladder::height_rungs,
    ladder::height_m,
    BoundaryEvidence::new,
    BoundaryEvidence::known,
    BoundaryEvidence::guess_ceiling,
    BoundaryEvidence::ranges,
    BoundaryEvidence::likeliest,
    RangeLikelihoods::ceiling_ratio,
    RangeLikelihoods::heights,
    RangeLikelihoods::knows,
    RangeLikelihoods::row,
    RangeLikelihoods::range,
    evidence::weigh,
    visual_scan::scan,
    wall_check::compare,
    // locate, track
    locate::locate,
    pose::Headings::search,
    Fix::pose,
    Fix::floor_name,
    Fix::camera_height_m,
    Fix::ceiling_height_m,
    Fix::probability,
    Fix::is_sure,
    HeightMemory::learn,
    HeightMemory::prior,
    HeightMemory::is_like,
    Track::step,
    Track::estimate,
    hypotheses,
    // locator
    Settings::memory_words,
    Settings::memory_words_of,
    run_locator,
    run_stages,
    recall,
];

// Generic functions, and those that return iterators, for arguments as unknown as those of the rest.

fn cast(
    plan: &Plan<'_>,
    at: Point,
    heading: Turn,
    stride: usize,
    out: &mut [(u16, Hit)],
) -> Result<(), MarchError> {
    out.iter_mut().zip(plan.rays(at, heading, stride)?).for_each(|(out, ray)| *out = ray);
    Ok(())
}

fn correlate(correlator: &mut Correlator, values: &[[i16; BINS]], out: &mut [i32; BINS]) -> i32 {
    let value = |channel: usize, bin: usize| {
        i32::from(values.get(channel).and_then(|values| values.get(bin)).copied().unwrap_or_default())
    };
    correlator.set_query(values.len(), value);
    correlator.correlate(Extent::of(values.len(), value), value, out)
}

fn search(
    rows: &Rows<HEADINGS>,
    heights: &pose::heights::HeightGrid,
    layers: &[FloorLayer<'_>],
    within: &pose::PosePrior,
    pool: &mut [PoolEntry],
) -> usize {
    pose::search(rows, heights, layers, within, pool)
}

struct Bytes<'a>(&'a mut dyn FnMut(&[u8]) -> bool);

impl Sink for Bytes<'_> {
    type Error = ();
    fn append(&mut self, bytes: &[u8]) -> Result<(), ()> {
        if (self.0)(bytes) { Ok(()) } else { Err(()) }
    }
}

fn write_map(sink: Bytes<'_>, header: &Header, candidates: &[([u16; 2], &[Layer])]) -> Result<(), ()> {
    let mut writer = site_map::Writer::new(sink, header)?;
    candidates.iter().try_for_each(|(cell, layers)| writer.candidate(*cell, layers))?;
    writer.finish().map(drop)
}

fn write_site(sink: Bytes<'_>, writer: &site::Writer<'_, '_>) -> Result<(), ()> {
    writer.write(sink).map(drop)
}

fn write_shot(sink: Bytes<'_>, writer: &shot::Writer<'_>) -> Result<(), ()> {
    writer.write(sink).map(drop)
}

fn walk_map(map: &SiteMap<'_>, visit: &mut dyn FnMut([u16; 2])) {
    map.iter().for_each(|record| visit(record.cell()));
}

fn walk_site(site: &Site<'_>, visit: &mut dyn FnMut(&str)) {
    site.floors().for_each(|floor| visit(floor.name()));
}

fn walk_rig(rig: &Rig, visit: &mut dyn FnMut(usize, &View)) {
    rig.views().for_each(|(number, view)| visit(number, view));
}

fn visit_edges(segments: &mut [VerticalSegment], resolution: Resolution, visit: &mut dyn FnMut(&Edge)) {
    windows::visit_edges(segments, resolution, visit);
}

fn hypotheses(track: &Track, visit: &mut dyn FnMut(ScoredPose, f32)) {
    track.hypotheses().for_each(|(pose, probability)| visit(pose, probability));
}

fn run_locator<'a>(
    site: &Site<'a>,
    rig: Rig,
    settings: Settings,
    memory: &'a mut [u32],
    frames: &locator::Frames<'_>,
    prior: &Prior,
) -> Result<Fix<'a>, LocateError> {
    let mut locator: Locator<'_> = Locator::new(site, rig, settings, memory)?;
    locator.set_rig(rig)?;
    locator.locate(frames, prior)
}

fn run_stages(
    locator: &mut Locator<'_>,
    frames: &locator::Frames<'_>,
    up: &compass_core::Bearing,
    track: &mut Track,
) -> Result<Option<f32>, LocateError> {
    let mut segmented = locator.segment(frames)?;
    black_box(segmented.segments(1).len());
    black_box(segmented.sky_is_above(up)?);
    let mut levelled = segmented.level(up)?;
    black_box(levelled.axes());
    let mut seen = levelled.see();
    black_box((seen.windows().len(), seen.boundaries().is_some()));
    let fix = seen.locate(compass_core::HeightPrior::UNKNOWN);
    let mut ranges = RangeLikelihoods::EMPTY;
    seen.range_likelihoods(compass_core::HeightPrior::both(fix.heights()), &mut ranges);
    black_box(&ranges);
    Ok(seen.track(track, &fix, 0.1, None).map(|estimate| estimate.spread_m))
}

fn recall(
    locator: &mut Locator<'_>,
    boundaries: &BoundaryEvidence<'_>,
    windows: &compass_core::vision::windows::WindowEvidence,
) {
    black_box(locator.recall(boundaries, windows).locate(compass_core::HeightPrior::camera(1.6)).is_sure());
}
