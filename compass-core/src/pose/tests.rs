use super::*;
use crate::base::num::{BINS, CellNats, Metres, Nats, Point, Turn};
use crate::base::pose::Separation;
use crate::base::raster::BitMask;
use crate::base::scan::{Hit, MAX_STEPS, Scan};
use crate::map::plan::{Plan, PlanGrid, pack, packed_len};
use crate::map::site_map::{Header, Layer, PackedScan, SiteMap, Writer};
use crate::vision::boundary::{BoundaryEvidence, CELLS, NOMINAL_RUNG, RUNGS};
use std::boxed::Box;
use std::vec;
use std::vec::Vec;

const WIDTH: u32 = 600;
const HEIGHT: u32 = 400;
const GRID: PlanGrid = PlanGrid { resolution_nm: 20_000_000, origin: Point::new(Metres::ZERO, Metres::ZERO) };

/// Walls and windows as left, bottom, width, height in cells of 0.02 m: 12 x 8 m, three rooms, a pillar.
const WALLS: [[u32; 4]; 10] = [
    [0, 0, 600, 8],
    [0, 392, 600, 8],
    [0, 0, 8, 400],
    [592, 0, 8, 400],
    [240, 0, 8, 170],
    [240, 220, 8, 180],
    [248, 250, 150, 8],
    [450, 250, 150, 8],
    [420, 90, 20, 20],
    [90, 300, 60, 40],
];
const WINDOWS: [[u32; 4]; 5] =
    [[40, 392, 90, 8], [300, 392, 60, 8], [480, 392, 80, 8], [592, 60, 8, 110], [0, 120, 8, 70]];

fn fill(mask: &mut [u8], boxes: &[[u32; 4]]) {
    for &[left, bottom, width, height] in boxes {
        for (x, y) in (left..left + width).flat_map(|x| (bottom..bottom + height).map(move |y| (x, y))) {
            mask[y as usize * BitMask::row_bytes(WIDTH) + x as usize / 8] |= 1 << (x % 8);
        }
    }
}

pub(crate) struct Building {
    plan: Vec<u8>,
    map: Vec<u8>,
}

impl Building {
    pub(crate) fn new() -> Self {
        let len = BitMask::row_bytes(WIDTH) * HEIGHT as usize;
        let (mut walls, mut windows) = (vec![0; len], vec![0; len]);
        fill(&mut walls, &WALLS);
        fill(&mut windows, &WINDOWS);
        for (wall, window) in walls.iter_mut().zip(&windows) {
            *wall &= !window;
        }
        let (walls, windows) =
            (BitMask::new(&walls, WIDTH, HEIGHT).unwrap(), BitMask::new(&windows, WIDTH, HEIGHT).unwrap());
        let mut bytes = vec![0; packed_len(&walls, &windows).unwrap()];
        let plan = pack(&walls, &windows, GRID, &mut bytes).unwrap();
        let mut scan = Scan::OPEN;
        let cells =
            (12..HEIGHT as u16).step_by(25).flat_map(|y| (12..WIDTH as u16).step_by(25).map(move |x| [x, y]));
        let mut found = Vec::new();
        for cell in cells {
            if plan.scan(plan.cell_centre(cell[0], cell[1]), Turn::ZERO, &mut scan).is_ok() {
                found.push((cell, Layer::new(&PackedScan::new(&scan), &[0; 16], &[0; 24])));
            }
        }
        let header = Header {
            candidates: found.len() as u32,
            layers: 1,
            grid: GRID,
            spacing_mm: 500,
            plan_size: [WIDTH, HEIGHT],
            plan_checksum: plan.checksum(),
        };
        let mut writer = Writer::new(Vec::new(), &header).unwrap();
        for (cell, layer) in found {
            writer.candidate(cell, &[layer]).unwrap();
        }
        let map = writer.finish().unwrap();
        Self { plan: bytes, map }
    }

    pub(crate) fn layer(&self) -> FloorLayer<'_> {
        let (map, plan) = (SiteMap::new(&self.map).unwrap(), Plan::new(&self.plan).unwrap());
        FloorLayer { map, number: 0, plan, floor: 0, name: "ground" }
    }
}

/// What was seen of a scan, from a camera 1.5 m above the floor.
pub(crate) struct Observed {
    cells: Vec<CellNats>,
    hits: HitEvidence,
}

impl Observed {
    pub(crate) fn nothing() -> Self {
        Self {
            cells: vec![CellNats::ZERO; CELLS],
            hits: HitEvidence { wall: [CellNats::ZERO; BINS], window: [CellNats::ZERO; BINS] },
        }
    }

    /// A third of the directions unknown, a tenth at a wrong range.
    fn of(scan: &Scan, random: &mut impl FnMut() -> u32) -> Self {
        let mut observed = Self::nothing();
        for bin in 0..BINS {
            let fate = random() % 30;
            if fate < 10 || scan.hit[bin] == Hit::Open {
                continue;
            }
            let wrong = 20 + random() % (u32::from(MAX_STEPS) - 20);
            let steps = if fate < 13 { wrong as u16 } else { scan.steps[bin] };
            let seen = NOMINAL_RUNG + usize::from(plane_of(steps, Hit::Wall));
            for rung in 0..RUNGS {
                let nats = (40 - 12 * rung.abs_diff(seen) as i32).max(-16);
                observed.cells[rung * BINS + bin] = CellNats::from_bits(nats as i8);
            }
            let [right, wrong] = [8, -24].map(CellNats::from_bits);
            let is_window = scan.hit[bin] == Hit::Window;
            (observed.hits.window[bin], observed.hits.wall[bin]) =
                if is_window { (right, wrong) } else { (wrong, right) };
        }
        observed
    }

    pub(crate) fn boundaries(&self) -> BoundaryEvidence<'_> {
        BoundaryEvidence::new(&self.cells).unwrap()
    }

    /// The table at the camera's true height.
    fn table(&self) -> Box<EvidenceTable> {
        let mut table = Box::new(EvidenceTable::EMPTY);
        evidence::weigh(&self.boundaries(), [0, 0], &self.hits, &mut table);
        table
    }

    fn rows<const N: usize>(&self) -> Box<Rows<N>> {
        let mut rows = Box::new(Rows::<N>::BLANK);
        rows.set(&self.boundaries(), &self.hits, 0.5);
        rows
    }
}

/// The camera's height is known: 1.5 m.
fn grid() -> heights::HeightGrid {
    heights::HeightGrid::coarse(&heights::HeightPrior::camera(1.5))
}

/// Evidence of a scan: a third of the directions unknown, a tenth at a wrong range.
pub(crate) fn evidence(scan: &Scan, random: &mut impl FnMut() -> u32) -> Box<EvidenceTable> {
    Observed::of(scan, random).table()
}

pub(crate) fn point(x: f64, y: f64) -> Point {
    Point::new(Metres::from_num(x), Metres::from_num(y))
}

fn check_found<const N: usize>(building: &Building, seed: u32) {
    let layer = building.layer();
    let mut state = seed;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state >> 8
    };
    let mut scan = Scan::OPEN;
    for (x, y, degrees) in [(2.13, 3.41, 17.3), (7.37, 2.09, 201.6), (9.21, 1.44, 311.8), (1.02, 6.49, 95.4)]
    {
        let (at, heading) = (point(x, y), Turn::from_ratio((degrees * 1000.0) as i64, 360_000));
        layer.plan.scan(at, heading, &mut scan).unwrap();
        let observed = Observed::of(&scan, &mut random);
        let (table, rows) = (observed.table(), observed.rows::<N>());
        let mut pool = [PoolEntry::EMPTY; 64];
        let used = search(&rows, &grid(), &[layer], &PosePrior::UNKNOWN, &mut pool);
        let mut refined = poses(&[layer], &pool[..used.min(8)]);
        for pose in refined.iter_mut() {
            let climbed = refine(&table, &layer, *pose);
            let again = refine(&table, &layer, climbed);
            assert!(again.score >= climbed.score, "never worse");
            assert_eq!(layer.plan.hit_at(climbed.at), Some(Hit::Open));
            *pose = climbed;
        }
        let alternatives = select_alternatives(&[layer], &mut refined);
        let best = alternatives.best().unwrap();
        assert!(best.at.within(at, Metres::from_num(0.05)), "{best:?}, not {at:?}");
        assert!(best.heading.distance(heading) < Turn::from_ratio(1, 720), "{best:?}, not {degrees} degrees");
        assert!(alternatives.margin() > Nats::ZERO);
    }
}

#[test]
fn a_pose_off_the_grid_is_found() {
    let building = Building::new();
    for seed in 0..4 {
        check_found::<360>(&building, seed);
        check_found::<90>(&building, seed);
        check_found::<40>(&building, seed);
    }
}

#[test]
fn a_pose_in_a_wall_or_outside_is_returned_unchanged() {
    let building = Building::new();
    for at in [point(0.05, 0.05), point(-1.0, 3.0), Point::new(Metres::MAX, Metres::MIN)] {
        let pose = ScoredPose { at, score: Nats::from_bits(7), ..ScoredPose::NONE };
        assert_eq!(refine(&EvidenceTable::EMPTY, &building.layer(), pose), pose);
    }
}

#[test]
fn an_empty_table_scores_zero_everywhere() {
    let building = Building::new();
    let rows = Observed::nothing().rows::<90>();
    let mut pool = [PoolEntry::EMPTY; 16];
    let nowhere = PosePrior::UNKNOWN.near(point(5.0, 3.0), Metres::from_num(-1));
    let used = search(&rows, &grid(), &[building.layer()], &PosePrior::UNKNOWN, &mut pool);
    assert!(
        used > 0 && poses(&[building.layer()], &pool[..used]).iter().all(|pose| pose.score == Nats::ZERO)
    );
    assert_eq!(search(&rows, &grid(), &[building.layer()], &nowhere, &mut pool), 0);
    assert_eq!(search(&rows, &grid(), &[building.layer()], &PosePrior::UNKNOWN, &mut []), 0);
}

/// Entries of a pool as poses.
fn poses(layers: &[FloorLayer<'_>], pool: &[PoolEntry]) -> Vec<ScoredPose> {
    pool.iter().filter_map(|entry| entry.pose(layers)).collect()
}

#[test]
fn a_pool_of_any_size_keeps_the_best() {
    let building = Building::new();
    let layer = building.layer();
    let mut scan = Scan::OPEN;
    layer.plan.scan(point(7.37, 2.09), Turn::ZERO, &mut scan).unwrap();
    let mut state = 5_u32;
    let observed = Observed::of(&scan, &mut || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state >> 8
    });
    let rows = observed.rows::<360>();
    let mut all = vec![PoolEntry::EMPTY; 2000];
    let used = search(&rows, &grid(), &[layer, layer], &PosePrior::UNKNOWN, &mut all);
    all.truncate(used);
    let all = poses(&[layer; 2], &all);
    assert_eq!(all[0].at, all[1].at, "both layers are kept");
    let mut layers = [layer; 2];
    let floors = |layers: &[FloorLayer<'_>], all: &[ScoredPose]| {
        select_alternatives(layers, &mut all.to_vec()).poses()[1]
    };
    let (first, second) = (all[0], floors(&layers, &all));
    let separation = Separation { distance: Metres::ONE, turn: Turn::from_ratio(20, 360) };
    assert!(!separation.is_near(second.place(), first.place()));
    layers[1].floor = 1;
    assert_eq!(floors(&layers, &all), all[1]);
    for len in [1, 2, 3, 7, 100] {
        let mut few = vec![PoolEntry::EMPTY; len];
        let kept = search(&rows, &grid(), &[layer, layer], &PosePrior::UNKNOWN, &mut few);
        let few = poses(&[layer; 2], &few[..kept]);
        assert!(kept > 0 && few.iter().all(|pose| all.contains(pose)));
        assert_eq!(few[0], all[0]);
    }
}

/// The pose by the boundary of one surface alone.
fn by_surface<'a>(layer: FloorLayer<'a>, cells: &[CellNats]) -> Fix<'a> {
    let headings = Headings::N40;
    let mut work = locate::Work {
        table: &mut Box::new(EvidenceTable::EMPTY),
        headings,
        rows: &mut vec![0; headings.words()],
        pool: &mut [PoolEntry::EMPTY; 64],
        effort: locate::Effort::LITTLE,
    };
    let boundaries = BoundaryEvidence::new(cells).unwrap();
    let windows = crate::vision::windows::WindowEvidence::NOTHING;
    locate::locate(
        &boundaries,
        heights::HeightPrior::camera(1.5),
        &PosePrior::UNKNOWN,
        &windows,
        &[layer],
        &mut work,
    )
}

#[test]
fn exchanged_weights_count_the_floor_half_and_the_ceiling_whole() {
    let building = Building::new();
    let layer = building.layer();
    let mut scan = Scan::OPEN;
    layer.plan.scan(point(2.13, 3.41), Turn::ZERO, &mut scan).unwrap();
    let mut state = 7_u32;
    let observed = Observed::of(&scan, &mut || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state >> 8
    });
    let floor = by_surface(layer, &observed.cells);
    let mut above = observed.cells.clone();
    above.rotate_right(CELLS / 2);
    let ceiling = by_surface(layer, &above);
    // Scores are interpolated between rungs, and exchanged by the nearest one.
    for (fix, factor) in [(floor, 0.5), (ceiling, 2.0)] {
        let score: f32 = fix.best().unwrap().score.to_num();
        let exchanged: f32 = fix.exchanged_score().unwrap().to_num();
        assert!((exchanged / score - factor).abs() < 0.1 * factor, "{exchanged} of {score}");
    }
}

#[test]
fn a_lead_counts_up_to_the_score_alone() {
    let probability = |score: i32, margin: i32| probability_of(Nats::from_num(score), Nats::from_num(margin));
    assert_eq!(probability(40, 120), probability(40, 40), "not in this plan is an explanation, too");
    assert!(probability(400, 40) < 0.5 && probability(400, 120) > 0.5);
    assert_eq!((probability(0, 0), probability(-9, 50)), (0.0, 0.0));
}
