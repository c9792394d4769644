use super::layout::{ENTRY_BYTES, HEADER_BYTES, SUMMED_BYTES};
use super::*;
use crate::base::crc::CRC32;
use crate::base::num::{BINS, Metres, Point};
use crate::base::raster::BitMask;
use crate::base::scan::{Hit, Scan};
use crate::map::plan::{Plan, PlanError, PlanGrid, pack, packed_len};
use crate::map::site_map::{self, Header, Layer, PackedScan, SiteMap, SiteMapError};
use proptest::prelude::*;
use std::string::String;
use std::vec::Vec;

const SIDE: u32 = 24;
const GRID: PlanGrid = PlanGrid { resolution_nm: 50_000_000, origin: Point::new(Metres::ZERO, Metres::ONE) };

/// A plan of 24 x 24 cells with a wall along this row.
fn plan(row: usize, grid: PlanGrid) -> Vec<u8> {
    let row_bytes = BitMask::row_bytes(SIDE);
    let (mut walls, windows) = (std::vec![0; row_bytes * SIDE as usize], [0; 3 * SIDE as usize]);
    walls[row * row_bytes..][..row_bytes].fill(0xff);
    let mask = |bytes| BitMask::new(bytes, SIDE, SIDE).unwrap();
    let mut bytes = std::vec![0; packed_len(&mask(&walls), &mask(&windows)).unwrap()];
    pack(&mask(&walls), &mask(&windows), grid, &mut bytes).unwrap();
    bytes
}

fn map(plan: &[u8], layers: u8) -> Vec<u8> {
    let plan = Plan::new(plan).unwrap();
    let header = Header {
        candidates: 2,
        layers,
        grid: plan.grid(),
        spacing_mm: 250,
        plan_size: [plan.width(), plan.height()],
        plan_checksum: plan.checksum(),
    };
    let mut writer = site_map::Writer::new(Vec::new(), &header).unwrap();
    let layer = |steps| {
        let scan = Scan { steps: [steps; BINS], hit: [Hit::Wall; BINS] };
        Layer::new(&PackedScan::new(&scan), &[1; 16], &[2; 24])
    };
    for cell in [[3, 4], [5, 6]] {
        writer.candidate(cell, &[layer(20), layer(40)][..layers.into()]).unwrap();
    }
    writer.finish().unwrap()
}

/// The parts of two floors, of two layers and of one.
struct Parts {
    maps: [Vec<u8>; 2],
    plans: [Vec<u8>; 3],
}

impl Parts {
    fn new() -> Self {
        let plans = [plan(2, GRID), plan(5, GRID), plan(9, GRID)];
        Self { maps: [map(&plans[0], 2), map(&plans[2], 1)], plans }
    }

    fn floors(&self) -> [Floor<'_>; 2] {
        let map = |at: usize| SiteMap::new(&self.maps[at]).unwrap();
        let plan = |at: usize| Plan::new(&self.plans[at]).unwrap();
        [
            Floor::new("ground", map(0), plan(0), Some(plan(1))).unwrap(),
            Floor::new("Dachgeschoß", map(1), plan(2), None).unwrap(),
        ]
    }
}

fn site() -> Vec<u8> {
    let parts = Parts::new();
    let floors = parts.floors();
    let writer = Writer::new(&floors).unwrap();
    let bytes = writer.write(Vec::new()).unwrap();
    assert_eq!(bytes.len(), writer.site_bytes());
    bytes
}

/// Recomputes the checksum of the header.
fn seal(bytes: &mut [u8]) {
    let floors = usize::from(bytes[10]);
    let entries = bytes[HEADER_BYTES..][..ENTRY_BYTES * floors].as_chunks().0;
    let crc = layout::header_checksum(&bytes[..SUMMED_BYTES], entries);
    bytes[SUMMED_BYTES..HEADER_BYTES].copy_from_slice(&crc.to_le_bytes());
}

/// Reads all contents of a site.
fn read_all(site: &Site<'_>) {
    let mut scan = Scan::OPEN;
    for floor in site.floors() {
        assert!(is_name(floor.name()));
        for (record, layer) in floor.map().iter().flat_map(|record| (0..3).map(move |layer| (record, layer)))
        {
            record.layer(layer).inspect(|layer| layer.scan(&mut scan));
        }
        for plan in (0..3).filter_map(|layer| floor.plan(layer)) {
            let _ = plan.scan(plan.cell_centre(12, 12), crate::base::num::Turn::ZERO, &mut scan);
        }
    }
}

#[test]
fn a_written_site_is_read_back() {
    let (bytes, parts) = (site(), Parts::new());
    let site = Site::new(&bytes).unwrap();
    site.verify().unwrap();
    assert_eq!(site.len(), 2);
    let names: Vec<_> = site.floors().map(|floor| floor.name()).collect();
    assert_eq!(names, ["ground", "Dachgeschoß"]);
    let [ground, attic] = [0, 1].map(|number| site.floor(number).unwrap());
    assert!(site.floor(2).is_none());
    assert_eq!((ground.layers(), attic.layers()), (2, 1));
    assert_eq!(ground.map().as_bytes(), parts.maps[0], "parts are stored as they are");
    assert_eq!(ground.plan(1).unwrap().as_bytes(), parts.plans[1]);
    assert_eq!(attic.plan(0).unwrap().as_bytes(), parts.plans[2]);
    assert!(attic.plan(1).is_none() && ground.plan(2).is_none());
    for part in [ground, attic].iter().flat_map(Floor::parts) {
        assert_eq!((part.as_ptr().addr() - bytes.as_ptr().addr()) % 8, 0);
    }
    read_all(&site);
}

#[test]
fn truncated_and_damaged_files_are_rejected() {
    let bytes = site();
    for len in 0..bytes.len() {
        assert!(Site::new(&bytes[..len]).is_err(), "{len} bytes");
    }
    assert_eq!(Site::new(&bytes[..40]).unwrap_err(), SiteError::Length);
    assert_eq!(Site::new(&bytes[..bytes.len() - 1]).unwrap_err(), SiteError::Length);
    assert_eq!(Site::new(&[&bytes[..], &[0]].concat()).unwrap_err(), SiteError::Length);
    assert_eq!(Site::new(b"CMPSMAP1").unwrap_err(), SiteError::Magic);
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x20;
        assert!(Site::new(&damaged).and_then(|site| site.verify()).is_err(), "byte {at}");
    }
    for (at, value, error) in [
        (8, 2, SiteError::Version(2)),
        (10, 0, SiteError::Floors),
        (10, 33, SiteError::Floors),
        (16, 7, SiteError::HeaderChecksum),
    ] {
        let mut damaged = bytes.clone();
        damaged[at] = value;
        assert_eq!(Site::new(&damaged).unwrap_err(), error);
    }
}

#[test]
fn damage_with_a_valid_checksum_names_the_field() {
    let bytes = site();
    let first = HEADER_BYTES;
    let map_at = HEADER_BYTES + 2 * ENTRY_BYTES;
    for (at, value, error) in [
        (first, 0, FloorError::Name),
        (first, 24, FloorError::Name),
        (first, 3, FloorError::Name),
        (first + 1, 0xff, FloorError::Name),
        (first + 1, b'\n', FloorError::Name),
        (first + 24, 120, FloorError::Offset),
        (first + 40, 0, FloorError::Offset),
        (map_at, b'X', FloorError::Map(SiteMapError::Magic)),
    ] {
        let mut damaged = bytes.clone();
        damaged[at] = value;
        seal(&mut damaged);
        assert_eq!(Site::new(&damaged).unwrap_err(), SiteError::Floor(0, error), "byte {at}");
    }
    let mut twice = bytes.clone();
    twice.copy_within(first..first + 24, first + ENTRY_BYTES);
    seal(&mut twice);
    assert_eq!(Site::new(&twice).unwrap_err(), SiteError::SameName(1));
    let plan = Site::new(&bytes).unwrap().floor(1).unwrap().plan(0).unwrap().as_bytes();
    let end = plan.as_ptr_range().end.addr() - bytes.as_ptr().addr();
    let mut damaged = bytes.clone();
    damaged[end - 1] ^= 1;
    let verified = Site::new(&damaged).unwrap().verify().unwrap_err();
    assert_eq!(verified, SiteError::Floor(1, FloorError::Plan(0, PlanError::Checksum)));
}

#[test]
fn maps_and_plans_that_differ_are_rejected() {
    let parts = Parts::new();
    let view = |bytes| Plan::new(bytes).unwrap();
    let [map_2, map_1] = [0, 1].map(|at: usize| SiteMap::new(&parts.maps[at]).unwrap());
    let [ground, structure, attic] = [0, 1, 2].map(|at: usize| view(&parts.plans[at]));
    let error = |name, map, plan, second| Floor::new(name, map, plan, second).unwrap_err();
    for name in ["", "a name of above 23 bytes", "tab\t"] {
        assert_eq!(error(name, map_1, attic, None), FloorError::Name);
    }
    assert_eq!(error("a", map_2, ground, None), FloorError::Layers);
    assert_eq!(error("a", map_1, attic, Some(structure)), FloorError::Layers);
    assert_eq!(error("a", map_1, ground, None), FloorError::PlanChecksum);
    let moved = plan(5, PlanGrid { resolution_nm: 50_000_001, ..GRID });
    assert_eq!(error("a", map_2, ground, Some(view(&moved))), FloorError::Grid(1));
    let mut wider = parts.plans[0].clone();
    wider[12] -= 1;
    assert_eq!(error("a", map_2, view(&wider), Some(structure)), FloorError::PlanSize(0));
}

#[test]
fn invalid_sets_of_floors_are_rejected() {
    let parts = Parts::new();
    let floors = parts.floors();
    assert_eq!(Writer::new(&[]).unwrap_err(), SiteError::Floors);
    assert_eq!(Writer::new(&[floors[0], floors[1], floors[0]]).unwrap_err(), SiteError::SameName(2));
    let names: Vec<String> = (0..33).map(|n| std::format!("floor {n}")).collect();
    let floor = |name| Floor::new(name, *floors[1].map(), floors[1].plan(0).unwrap(), None).unwrap();
    let many: Vec<_> = names.iter().map(|name| floor(name)).collect();
    assert_eq!(Writer::new(&many).unwrap_err(), SiteError::Floors);
    let bytes = Writer::new(&many[..MAX_FLOORS]).unwrap().write(Vec::new()).unwrap();
    assert_eq!(Site::new(&bytes).unwrap().floors().count(), MAX_FLOORS);
}

proptest! {
    #[test]
    fn arbitrary_changes_do_not_panic(changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6)) {
        let mut bytes = site();
        // Half of the changes are in the header; its checksums are recomputed.
        let header = HEADER_BYTES + 2 * ENTRY_BYTES;
        for (number, (at, value)) in changes.iter().enumerate() {
            let reach = if number % 2 == 0 { header } else { bytes.len() };
            bytes[at.index(reach)] = *value;
        }
        if usize::from(bytes[10]) * ENTRY_BYTES + HEADER_BYTES <= bytes.len() {
            seal(&mut bytes);
        }
        let map = &mut bytes[header..];
        let crc = CRC32.checksum(&map[..52]);
        map[52..56].copy_from_slice(&crc.to_le_bytes());
        if let Ok(site) = Site::new(&bytes) {
            let _ = site.verify();
            read_all(&site);
        }
    }
}
