//! The stages of `compass-core`, one checksum each.
//!
//! The host, emulated Cortex-M boards and emulated ARM Linux all run this list on the same bytes. The core's floating
//! point is IEEE arithmetic through one library, so the checksums must be equal everywhere, bit for bit.
//!
//! Two parts: [`STAGES`] are functions that read the [`Inputs`] and the outputs of earlier stages in the
//! [`Workspace`]; to add one, give its output a field of [`Workspace`] and append it to the list. From frames to a
//! pose the stages are those of the core's [`Locator`](compass_core::locator::Locator), whose
//! [`Trace`](compass_core::locator::Trace) receives each result. A [`Report`] is called when a stage begins and ends,
//! so that a target can measure its cost, and then with its checksum.
#![no_std]
#![forbid(unsafe_code)]

mod pipeline;
mod sample;
mod shots;

use compass_core::base::confidence::Confidence;
use compass_core::base::num::{BINS, Metres, Point, Score, Turn, Unit};
use compass_core::base::scan::Scan;
use compass_core::descriptor::Descriptor;
use compass_core::descriptor::matching::{
    Answer, Board, Exact, GROUP, Group, Index, Match, exhaustive, shortlist,
};
use compass_core::descriptor::similarity::{Query, Similarity, Weights};
use compass_core::descriptor::sketch::{Sketch, SketchQuery};
use compass_core::descriptor::spectrum::{Complex, MAX_POINTS, forward};
use compass_core::map::plan::Plan;
use compass_core::map::site::Site;
use compass_core::map::site_map::SiteMap;
use compass_core::pose::track::Track;
use core::fmt::{self, Write as _};
use core::hint::black_box;
use crc::{CRC_32_ISO_HDLC, Crc, Digest};
pub use pipeline::{POSE_RAM, POSE_STAGES};
pub use sample::{FRAMES_FROM, WORDS, frames, prior, rig};
pub use shots::{Located, Shots};

/// Angles of the trigonometry stages.
const ANGLES: usize = 2 * BINS;
/// Places of the shortlist.
const SHORTLIST: usize = 64;
/// Size of the pool from which the shortlist search selects alternatives.
const SHORTLIST_POOL: usize = 256;
/// Size of the pool from which the exact search selects alternatives.
const EXACT_POOL: usize = 400;

static SAMPLE_SITE: &[u8] = include_bytes!("../../../tests/vectors/sample.site");

/// Candidates of the sample, from the headers of its site file and of the map in it.
const CANDIDATES: usize = {
    const fn word(site: &[u8], at: usize) -> usize {
        u32::from_le_bytes([site[at], site[at + 1], site[at + 2], site[at + 3]]) as usize
    }
    let site = include_bytes!("../../../tests/vectors/sample.site");
    let map = word(site, 40);
    word(site, map + 12)
};

/// The inputs of every target.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<'a> {
    /// A site of one floor, with at most as many candidates as the sample's.
    pub site: &'a [u8],
    /// Position of the robot.
    pub position: Point,
    /// Heading of the robot.
    pub heading: Turn,
    /// The candidate nearest to it.
    pub nearest: u32,
}

impl Inputs<'static> {
    /// The sample that is compared between targets: the sample building at its demo pose (`compass_host::sample`).
    ///
    /// The test `vectors` of `compass-tests` makes the file.
    pub const SAMPLE: Self = Self {
        site: SAMPLE_SITE,
        position: Point::new(Metres::lit("13.37"), Metres::lit("3.68")),
        heading: Turn::from_ratio(74, 360),
        nearest: 72,
    };
}

/// Bytes of the sample that every image carries: site and frames.
#[must_use]
pub fn input_bytes() -> usize {
    let frames = sample::FRAMES.iter().map(|(gray, red)| gray.len() + red.len());
    SAMPLE_SITE.len() + frames.sum::<usize>()
}

impl<'a> Inputs<'a> {
    fn site(&self) -> Site<'a> {
        Site::new(self.site).expect("the input is a site")
    }

    fn plan(&self) -> Plan<'a> {
        self.site().floor(0).and_then(|floor| floor.plan(0)).expect("a floor has a plan")
    }

    fn map(&self) -> SiteMap<'a> {
        *self.site().floor(0).expect("a site has a floor").map()
    }
}

/// The output of each stage; no stage allocates.
#[derive(Debug)]
pub struct Workspace {
    turns: [Turn; ANGLES],
    directions: [(Unit, Unit); ANGLES],
    scan: Scan,
    descriptor: Descriptor,
    signal: [Complex; MAX_POINTS],
    query: Query,
    board: Board,
    scores: [Score; BINS],
    ranks: [i32; CANDIDATES],
    ranked: [(i32, u32); SHORTLIST],
    shortlist_pool: [Match; SHORTLIST_POOL],
    localized: Option<Answer>,
    groups: [Group; CANDIDATES.div_ceil(GROUP)],
    exact: Exact,
    bounds: [i32; CANDIDATES],
    exact_pool: [Match; EXACT_POOL],
    proven: Option<Answer>,
    pipeline: pipeline::Memory,
}

/// Bytes of RAM by purpose; a board needs those of the operations that it uses. The rest of the [`Workspace`] keeps
/// outputs for their checksums.
pub const RAM: [(&str, usize); 4] = [
    ("locator", POSE_RAM),
    ("track", size_of::<Track>()),
    (
        "shortlist",
        size_of::<Scan>()
            + size_of::<Descriptor>()
            + size_of::<Query>()
            + size_of::<Board>()
            + size_of::<[(i32, u32); SHORTLIST]>()
            + size_of::<[Match; SHORTLIST_POOL]>(),
    ),
    (
        "exact",
        size_of::<[Group; CANDIDATES.div_ceil(GROUP)]>()
            + size_of::<Exact>()
            + size_of::<[i32; CANDIDATES]>()
            + size_of::<[Match; EXACT_POOL]>(),
    ),
];

impl Workspace {
    /// An empty workspace, usable in a `static`.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            turns: [Turn::ZERO; ANGLES],
            directions: [(Unit::ZERO, Unit::ZERO); ANGLES],
            scan: Scan::OPEN,
            descriptor: Descriptor::ZERO,
            signal: [Complex::ZERO; MAX_POINTS],
            query: Query::EMPTY,
            board: Board::new(),
            scores: [Score::ZERO; BINS],
            ranks: [0; CANDIDATES],
            ranked: [(0, 0); SHORTLIST],
            shortlist_pool: [Match::NONE; SHORTLIST_POOL],
            localized: None,
            groups: [const { Group::EMPTY }; CANDIDATES.div_ceil(GROUP)],
            exact: Exact::new(),
            bounds: [0; CANDIDATES],
            exact_pool: [Match::NONE; EXACT_POOL],
            proven: None,
            pipeline: pipeline::Memory::new(),
        }
    }
}

impl Default for Workspace {
    fn default() -> Self {
        Self::new()
    }
}

/// One entry of the list.
#[derive(Debug, Clone, Copy)]
pub struct Stage {
    /// Name in the report, without spaces.
    pub name: &'static str,
    /// Computes the stage's output.
    pub run: fn(&Inputs<'_>, &mut Workspace),
    /// The [`checksum`] of every bit of that output.
    pub checksum: fn(&Workspace) -> u32,
}

/// All stages, in the order in which they must run.
pub const STAGES: &[Stage] = &[
    Stage { name: "turns", run: turns, checksum: |w| checksum(w.turns.iter().map(|turn| turn.to_bits())) },
    Stage {
        name: "cos_sin",
        run: cos_sin,
        checksum: |w| checksum(w.directions.iter().flat_map(|&(c, s)| [c, s].map(unit_bits))),
    },
    Stage {
        name: "scan",
        run: scan,
        checksum: |w| {
            checksum(w.scan.steps.iter().zip(&w.scan.hit).flat_map(|(&s, &h)| [s.into(), h as u32]))
        },
    },
    Stage {
        name: "descriptor",
        run: descriptor,
        checksum: |w| {
            checksum(
                w.descriptor.levels.as_flattened().iter().map(|level| level.to_bits().cast_unsigned().into()),
            )
        },
    },
    Stage {
        name: "fft",
        run: fft,
        checksum: |w| checksum(w.signal.iter().flat_map(|c| [c.re, c.im].map(i32::cast_unsigned))),
    },
    Stage {
        name: "query",
        run: query,
        checksum: |w| {
            let norm = w.query.squared_norm();
            checksum([norm as u32, (norm >> 32) as u32])
        },
    },
    Stage {
        name: "correlate",
        run: correlate,
        checksum: |w| checksum(w.scores.iter().copied().map(unit_bits)),
    },
    Stage {
        name: "rank",
        run: rank,
        checksum: |w| checksum(w.ranks.iter().copied().map(i32::cast_unsigned)),
    },
    Stage { name: "localize", run: localize, checksum: |w| checksum(answer_words(w.localized.as_ref())) },
    Stage { name: "index", run: index, checksum: |w| debug_checksum(&w.groups) },
    Stage {
        name: "exact",
        run: exact,
        checksum: |w| {
            let bounds = w.bounds.iter().copied().map(i32::cast_unsigned);
            checksum(answer_words(w.proven.as_ref()).chain(bounds))
        },
    },
];

/// The callbacks of a target around a stage.
pub trait Report {
    /// A stage begins.
    fn begin(&mut self, name: &'static str) {
        let _ = name;
    }

    /// A stage has ended.
    fn end(&mut self, name: &'static str) {
        let _ = name;
    }

    /// The [`checksum`] of its output.
    fn check(&mut self, name: &'static str, checksum: u32);
}

/// Runs all stages and reports the name and checksum of each.
pub fn run(inputs: &Inputs<'_>, workspace: &mut Workspace, report: &mut impl Report) {
    for stage in STAGES {
        let run = black_box(stage.run);
        report.begin(stage.name);
        run(inputs, workspace);
        report.end(stage.name);
        report.check(stage.name, (stage.checksum)(workspace));
    }
    pipeline::run(inputs, &mut workspace.pipeline, report);
}

static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// CRC-32 (the one of zip and PNG) of the words in little-endian order.
#[must_use]
pub fn checksum(words: impl IntoIterator<Item = u32>) -> u32 {
    let mut digest = CRC.digest();
    for word in words {
        digest.update(&word.to_le_bytes());
    }
    digest.finalize()
}

/// The checksum of a value with private fields: of its debug text.
fn debug_checksum(value: &impl fmt::Debug) -> u32 {
    struct Sink(Digest<'static, u32>);
    impl fmt::Write for Sink {
        fn write_str(&mut self, text: &str) -> fmt::Result {
            self.0.update(text.as_bytes());
            Ok(())
        }
    }
    let mut sink = Sink(CRC.digest());
    write!(sink, "{value:?}").expect("the sink takes everything");
    sink.0.finalize()
}

const fn unit_bits(value: Unit) -> u32 {
    value.to_bits().cast_unsigned()
}

/// The best match and all alternatives, then the flags of the result.
fn answer_words(answer: Option<&Answer>) -> impl Iterator<Item = u32> {
    answer.into_iter().flat_map(|answer| {
        let matches = answer.matches().iter();
        let words = |m: &Match| [m.candidate, m.peak.shift.into(), m.peak.score_bits.cast_unsigned()];
        matches.flat_map(words).chain([answer.scored, answer.exhaustive.into()])
    })
}

/// Each whole degree, and a thousandth of a turn beyond it.
fn turns(_: &Inputs<'_>, workspace: &mut Workspace) {
    for (degrees, pair) in (0..).zip(workspace.turns.chunks_exact_mut(2)) {
        let whole = Turn::from_ratio(degrees, 360);
        pair.copy_from_slice(&[whole, whole + Turn::from_ratio(1, 1000)]);
    }
}

/// Cosine and sine of the [`turns`].
fn cos_sin(_: &Inputs<'_>, workspace: &mut Workspace) {
    for (direction, turn) in workspace.directions.iter_mut().zip(&workspace.turns) {
        *direction = turn.cos_sin();
    }
}

/// 360 rays from the pose.
fn scan(inputs: &Inputs<'_>, workspace: &mut Workspace) {
    let cast = inputs.plan().scan(inputs.position, inputs.heading, &mut workspace.scan);
    cast.expect("the pose is free");
}

/// The descriptor of the [`scan`].
fn descriptor(_: &Inputs<'_>, workspace: &mut Workspace) {
    workspace.descriptor.fill(&workspace.scan);
}

/// Copies a noise-like signal and transforms it.
fn fft(_: &Inputs<'_>, workspace: &mut Workspace) {
    workspace.signal = SIGNAL;
    assert!(forward(&mut workspace.signal), "1024 points are supported");
}

/// Values between -2^29 and 2^29, by a linear congruential generator.
static SIGNAL: [Complex; MAX_POINTS] = {
    let mut signal = [Complex::ZERO; MAX_POINTS];
    let mut state = 1_u32;
    let mut n = 0;
    while n < MAX_POINTS {
        signal[n] = Complex { re: noise(&mut state), im: noise(&mut state) };
        n += 1;
    }
    signal
};

const fn noise(state: &mut u32) -> i32 {
    *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    state.cast_signed() >> 2
}

/// The query of the [`descriptor`], and its spectra.
fn query(_: &Inputs<'_>, workspace: &mut Workspace) {
    let Workspace { query, descriptor, board, .. } = workspace;
    query.set(descriptor, &Confidence::CERTAIN, Weights::EQUAL, Similarity::Centred);
    board.load(query);
}

/// Unpacks the nearest candidate and scores it at all headings.
fn correlate(inputs: &Inputs<'_>, workspace: &mut Workspace) {
    let Workspace { query, board, scores, .. } = workspace;
    *scores = *board.scores(query, &inputs.map(), inputs.nearest as usize);
}

/// The rank of every candidate by its sketch.
fn rank(inputs: &Inputs<'_>, workspace: &mut Workspace) {
    let sketch = SketchQuery::new(&workspace.query);
    for (rank, record) in workspace.ranks.iter_mut().zip(inputs.map().iter()) {
        *rank = sketch.rank(&Sketch::stored(&record.plan_layer()));
    }
}

/// The search for a board: ranks all candidates, scores the best.
fn localize(inputs: &Inputs<'_>, workspace: &mut Workspace) {
    let Workspace { query, board, ranked, shortlist_pool, localized, .. } = workspace;
    *localized = Some(shortlist(&inputs.map(), query, None, board, ranked, shortlist_pool));
}

/// The index of the whole map.
fn index(inputs: &Inputs<'_>, workspace: &mut Workspace) {
    let map = inputs.map();
    for (number, group) in workspace.groups.iter_mut().enumerate() {
        group.fill(&map, number);
    }
}

/// The exact search in the [`index`].
fn exact(inputs: &Inputs<'_>, workspace: &mut Workspace) {
    let Workspace { query, groups, exact, bounds, exact_pool, proven, .. } = workspace;
    let map = inputs.map();
    let index = Index::new(groups, &map).expect("the workspace is made for this map");
    *proven = exhaustive(&index, &map, query, None, exact, bounds, exact_pool);
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use std::sync::{Mutex, MutexGuard, PoisonError};
    use std::vec;
    use std::vec::Vec;

    /// Too large for the stack of a test.
    static WORKSPACE: Mutex<Workspace> = Mutex::new(Workspace::new());

    fn workspace() -> MutexGuard<'static, Workspace> {
        WORKSPACE.lock().unwrap_or_else(PoisonError::into_inner)
    }

    #[test]
    fn checksum_is_the_one_of_zip() {
        let words = [*b"1234", *b"5678"].map(u32::from_le_bytes);
        assert_eq!(checksum(words), 0x9ae0_daaf);
    }

    /// Names and checksums in their order.
    #[derive(Default)]
    struct Lines(Vec<(&'static str, u32)>);

    impl Report for Lines {
        fn check(&mut self, name: &'static str, checksum: u32) {
            self.0.push((name, checksum));
        }
    }

    fn run_sample(workspace: &mut Workspace) -> Vec<(&'static str, u32)> {
        let mut lines = Lines::default();
        run(&Inputs::SAMPLE, workspace, &mut lines);
        lines.0
    }

    #[test]
    fn stages_have_distinct_names_and_repeat() {
        let mut workspace = workspace();
        let lines = run_sample(&mut workspace);
        for (i, (name, _)) in lines.iter().enumerate() {
            assert!(lines[..i].iter().all(|(earlier, _)| earlier != name));
            assert!(!name.contains(' '));
        }
        assert!(POSE_STAGES.iter().all(|stage| lines.iter().any(|(name, _)| name == stage)));
        assert_eq!(run_sample(&mut workspace), lines);
    }

    #[test]
    fn both_searches_find_the_pose() {
        let inputs = Inputs::SAMPLE;
        let mut workspace = workspace();
        run_sample(&mut workspace);
        for answer in [&workspace.localized, &workspace.proven] {
            let best = answer.as_ref().unwrap().best().unwrap();
            let position = inputs.map().position(best.candidate as usize).unwrap();
            assert!(position.within(inputs.position, Metres::ONE), "{best:?} is at {position:?}");
            assert!(best.heading().distance(inputs.heading) < Turn::from_ratio(5, 360), "{best:?}");
        }
        assert!(workspace.proven.as_ref().unwrap().exhaustive);
    }

    #[test]
    fn the_sample_frames_show_the_sample_building() {
        let inputs = Inputs::SAMPLE;
        let mut words = vec![0; WORDS];
        let mut locator = inputs.locator(&mut words, ());
        let mut segmented = locator.segment(&frames()).unwrap();
        assert!([0, 1].iter().all(|camera| segmented.segments(*camera).len() > 40));
        let up = segmented.vertical(prior().up).unwrap();
        // The frames are tilted by 4 degrees and hang upside down, 7 degrees askew.
        assert!((up.roll_deg() - 173.0).abs() < 1.5 && (up.pitch_deg() - 4.0).abs() < 1.5, "{up:?}");
        let mut seen = segmented.level(&up.up).unwrap().see();
        let windows = seen.window_evidence();
        assert!(!windows.truncated && windows.count > 0);
        // Against the plan's scan at the same pose.
        let mut scan = Scan::OPEN;
        inputs.plan().scan(FRAMES_FROM.0, FRAMES_FROM.1, &mut scan).unwrap();
        let bins = windows.hit.iter().zip(windows.confidence.sixteenths()).zip(&scan.hit);
        let (agree, all) = bins
            .filter(|((_, confidence), _)| **confidence > 0)
            .fold((0, 0), |(agree, all), ((a, _), b)| (agree + usize::from(a == b), all + 1));
        assert!(all > 300 && agree * 100 > 75 * all, "{agree} of {all}");
        let fix = seen.locate(prior().heights);
        let (pose, (at, heading)) = (fix.pose().unwrap(), FRAMES_FROM);
        assert!(pose.at.within(at, Metres::lit("0.4")), "{pose:?}");
        assert!(pose.heading.distance(heading) < Turn::from_ratio(2, 360), "{pose:?}");
        let estimate = seen.track(&mut Track::new(), &fix, 0.0, None).unwrap();
        assert!(estimate.pose.at.within(at, Metres::lit("0.4")), "{estimate:?}");
    }

    #[test]
    fn the_nearest_candidate_is_the_nearest() {
        let inputs = Inputs::SAMPLE;
        let map = inputs.map();
        let square = |at: Point| {
            let along = |a: Metres, b: Metres| i128::from((a - b).to_bits()).pow(2);
            along(at.x, inputs.position.x) + along(at.y, inputs.position.y)
        };
        let nearest = (0..map.len()).min_by_key(|&c| square(map.position(c).unwrap()));
        assert_eq!(nearest, Some(inputs.nearest as usize));
    }
}
