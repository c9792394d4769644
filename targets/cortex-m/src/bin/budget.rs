//! The cost of a localization's operations on a board, on any map, to choose a board by.
//!
//! Arguments: a site file, of which the first floor is used, or a plain site map and the packed plan it was made from.
//! They are files of the host and are read into external memory.
//!
//! Figures are instructions, averaged over candidates spread over the map; a query is the descriptor at another
//! candidate's place. `part` lines break down a figure above them.
#![no_std]
#![no_main]

use compass_core::base::confidence::Confidence;
use compass_core::base::num::{BINS, Score, Turn};
use compass_core::base::scan::Scan;
use compass_core::descriptor::Descriptor;
use compass_core::descriptor::matching::{Board, Match, shortlist};
use compass_core::descriptor::similarity::{Candidate, Query, Similarity, Weights};
use compass_core::descriptor::sketch::{Sketch, SketchQuery};
use compass_core::descriptor::spectrum::{Complex, Correlator, Extent, MAX_POINTS, forward, inverse};
use compass_core::map::plan::Plan;
use compass_core::map::site::Site;
use compass_core::map::site_map::SiteMap;
use compass_firmware::files::{self, refuse};
use compass_firmware::{counter::Counter, stack};
use core::hint::black_box;
use cortex_m_rt::entry;
use semihosting::{println, process};

/// Number of candidates that figures are averaged over.
const SAMPLES: usize = 20;
/// Heading of the scans: not a special case of the trigonometry.
const HEADING: Turn = Turn::from_ratio(741, 3600);
/// Size of the shortlist, and of the pool of its alternatives.
const SHORTLIST: usize = 48;
const POOL: usize = 4 * SHORTLIST;

/// Upper limits of an operation's instructions.
const SCAN_LIMIT: u64 = 400_000;
const CORRELATION_LIMIT: u64 = 500_000;
const RANKING_LIMIT: u64 = 10_000;

/// The buffers of the operations.
struct Workspace {
    board: Board,
    query: Query,
    ranked: [(i32, u32); SHORTLIST],
    pool: [Match; POOL],
    scan: Scan,
    descriptor: Descriptor,
    candidate: Candidate,
    correlator: Correlator,
    correlation: [i32; BINS],
    scores: [Score; BINS],
    signal: [Complex; MAX_POINTS],
}

impl Workspace {
    const EMPTY: Self = Self {
        board: Board::new(),
        query: Query::EMPTY,
        ranked: [(0, 0); SHORTLIST],
        pool: [Match::NONE; POOL],
        scan: Scan::OPEN,
        descriptor: Descriptor::ZERO,
        candidate: Candidate::ZERO,
        correlator: Correlator::new(),
        correlation: [0; BINS],
        scores: [Score::ZERO; BINS],
        signal: [Complex::ZERO; MAX_POINTS],
    };
}

#[entry]
fn main() -> ! {
    static mut WORKSPACE: Workspace = Workspace::EMPTY;

    let (map, plan) = read_files();
    let (map_bytes, plan_bytes) = (map.as_bytes().len(), plan.as_bytes().len());
    println!("bytes map {map_bytes} plan {plan_bytes} workspace {}", size_of::<Workspace>());
    map.verify().expect("the site map is whole");
    plan.verify().expect("the plan is whole");
    println!("candidates {}", map.len());

    let mut bench = Bench { counter: Counter::start(), map, plan, work: WORKSPACE };
    let before = stack::high_water_mark();
    bench.scans();
    bench.query();
    bench.correlations();
    bench.ranking();
    let after = stack::high_water_mark();
    println!("stack {after}");
    if before == after {
        println!("the operations took no more stack than reading the files: {before} is theirs");
    }
    process::exit(0)
}

struct Bench<'a> {
    counter: Counter,
    map: SiteMap<'a>,
    plan: Plan<'a>,
    work: &'a mut Workspace,
}

impl Bench<'_> {
    /// Casts 360 rays.
    fn scans(&mut self) {
        let (mut all, mut most) = (Mean::default(), 0);
        for candidate in self.samples() {
            let cost = self.scan(candidate);
            all.add(cost);
            most = most.max(cost);
        }
        figure("scan", all.mean(), Some(SCAN_LIMIT));
        part("most", most);
    }

    fn scan(&mut self, candidate: usize) -> u64 {
        let at = self.map.position(candidate).expect("samples are within the map");
        let (cast, cost) = self.counter.count(|| black_box(self.plan).scan(at, HEADING, &mut self.work.scan));
        cast.expect("candidates are free");
        cost
    }

    /// Casts a query at the place of the middle candidate, and prepares it.
    fn query(&mut self) {
        self.scan(self.map.len() / 2);
        let work = &mut *self.work;
        let ((), fill) = self.counter.count(|| black_box(&mut work.descriptor).fill(&work.scan));
        let ((), set) = self.counter.count(|| {
            work.query.set(&work.descriptor, &Confidence::CERTAIN, Weights::EQUAL, Similarity::Centred);
        });
        let ((), load) = self.counter.count(|| work.board.load(black_box(&work.query)));
        work.query.load(&mut work.correlator);
        figure("query", fill + set + load, None);
        part("descriptor", fill);
        part("set", set);
        part("load", load);
    }

    /// Scores one candidate at all headings.
    fn correlations(&mut self) {
        let mut whole = Mean::default();
        let mut parts = [Mean::default(); PARTS.len()];
        for candidate in self.samples() {
            let work = &mut *self.work;
            whole.add(
                self.counter.count(|| drop_scores(&mut work.board, &work.query, &self.map, candidate)).1,
            );
            for (mean, cost) in parts.iter_mut().zip(self.correlation_parts(candidate)) {
                mean.add(cost);
            }
        }
        figure("candidate", whole.mean(), None);
        for (name, mean) in PARTS.into_iter().zip(parts) {
            let limit = (name == "scores").then_some(CORRELATION_LIMIT);
            match limit {
                Some(_) => figure("correlation", mean.mean(), limit),
                None => part(name, mean.mean()),
            }
        }
    }

    fn correlation_parts(&mut self, candidate: usize) -> [u64; PARTS.len()] {
        let Workspace {
            query,
            scan,
            descriptor,
            candidate: other,
            correlator,
            correlation,
            scores,
            signal,
            ..
        } = &mut *self.work;
        let record = self.map.get(candidate).expect("samples are within the map");
        let counter = &self.counter;
        let unpack = counter.count(|| black_box(record).scan(scan)).1;
        let fill = counter.count(|| black_box(&mut *descriptor).fill(scan)).1;
        let profile = counter.count(|| black_box(&mut *other).fill(descriptor)).1;
        let all = counter.count(|| query.scores(black_box(other), correlator, scores)).1;
        // As called by `Query::scores`: values without their mean.
        let value = |channel: usize, bin: usize| {
            let (values, sums) = (&other.profile().values, other.sums());
            let value = values.get(channel).and_then(|v| v.get(bin)).copied().unwrap_or_default();
            BINS as i32 * i32::from(value) - sums.get(channel).copied().unwrap_or_default()
        };
        let extent = Extent::of(other.sums().len(), value);
        let correlate = counter.count(|| black_box(&mut *correlator).correlate(extent, value, correlation)).1;
        for (point, &value) in signal.iter_mut().zip(correlation.iter()) {
            point.re = value;
        }
        let transform = counter.count(|| forward(black_box(&mut *signal))).1;
        let back = counter.count(|| inverse(black_box(&mut *signal))).1;
        let exact = counter.count(|| black_box(&*query).score(other, 7)).1;
        [unpack, fill, profile, all, correlate, transform, back, exact]
    }

    /// Ranks by sketches, and runs the whole search.
    fn ranking(&mut self) {
        let work = &mut *self.work;
        let map = self.map;
        let candidates = map.len() as u64;
        let (sketch, new) = self.counter.count(|| SketchQuery::new(black_box(&work.query)));
        let (_, all) = self
            .counter
            .count(|| map.iter().map(|record| sketch.rank(&Sketch::stored(&record.plan_layer()))).max());
        figure("ranking", all / candidates, Some(RANKING_LIMIT));
        part("query_sketch", new);
        let (answer, search) = self
            .counter
            .count(|| shortlist(&map, &work.query, None, &mut work.board, &mut work.ranked, &mut work.pool));
        figure("shortlist", search, None);
        part("per_candidate", search / candidates);
        // The remainder is the scoring of the shortlist.
        part("per_place", search.saturating_sub(new + all) / u64::from(answer.scored.max(1)));
        println!("best {:?}", answer.best());
    }

    /// Candidates spread over the map.
    fn samples(&self) -> impl Iterator<Item = usize> + use<> {
        let len = self.map.len();
        (0..SAMPLES).map(move |sample| (2 * sample + 1) * len / (2 * SAMPLES))
    }
}

/// Parts of a correlation; the last belongs to the shortlist, which scores each peak exactly.
const PARTS: [&str; 8] = [
    "unpack",
    "descriptor",
    "candidate",
    "scores",
    "scores/correlate",
    "scores/correlate/forward",
    "scores/correlate/inverse",
    "exact_score",
];

#[inline(never)]
fn drop_scores(board: &mut Board, query: &Query, map: &SiteMap<'_>, candidate: usize) {
    black_box(board.scores(query, map, candidate));
}

#[derive(Debug, Clone, Copy, Default)]
struct Mean {
    sum: u64,
    count: u64,
}

impl Mean {
    fn add(&mut self, value: u64) {
        self.sum += value;
        self.count += 1;
    }

    const fn mean(self) -> u64 {
        self.sum / if self.count == 0 { 1 } else { self.count }
    }
}

fn figure(name: &str, instructions: u64, limit: Option<u64>) {
    match limit {
        Some(limit) if instructions <= limit => println!("insns {name} {instructions} within {limit}"),
        Some(limit) => println!("insns {name} {instructions} ABOVE {limit}"),
        None => println!("insns {name} {instructions}"),
    }
}

fn part(name: &str, instructions: u64) {
    println!("  part {name} {instructions}");
}

/// Reads the first floor of the site file named by the only argument, or the two files named by two.
fn read_files() -> (SiteMap<'static>, Plan<'static>) {
    let arguments = files::arguments();
    let mut paths = (&arguments).skip(1).flatten();
    let Some(first) = paths.next() else {
        refuse("usage", &"-append \"SITE\" or \"MAP PLAN\": a site file, or a site map and its packed plan")
    };
    // SAFETY: it is called once.
    let (bytes, rest) = files::read(first, unsafe { files::external() });
    let Some(second) = paths.next() else {
        let site = Site::new(bytes).unwrap_or_else(|error| refuse(first, &error));
        let floor = site.floor(0).expect("a site has a floor");
        return (*floor.map(), floor.plan(0).expect("a floor has a plan"));
    };
    let map = SiteMap::new(bytes).unwrap_or_else(|error| refuse(first, &error));
    (map, Plan::new(files::read(second, rest).0).unwrap_or_else(|error| refuse(second, &error)))
}
