use super::*;
use crate::base::num::{BINS, Metres, Point};
use crate::base::scan::{Hit, Scan};
use crate::map::plan::PlanGrid;
use std::vec::Vec;

impl Sink for Vec<u8> {
    type Error = core::convert::Infallible;
    fn append(&mut self, bytes: &[u8]) -> Result<(), Self::Error> {
        self.extend_from_slice(bytes);
        Ok(())
    }
}

fn scan(seed: usize) -> Scan {
    let mut scan = Scan { steps: [40; BINS], hit: [Hit::Wall; BINS] };
    for j in 0..BINS {
        scan.steps[j] = (30 + (j * seed) % 30) as u16;
        scan.hit[j] = if (j / 20 + seed).is_multiple_of(4) { Hit::Window } else { Hit::Wall };
    }
    scan
}

/// A layer with constant signature and sketch, which the map does not interpret.
fn layer(scan: &Scan, digest: u8) -> Layer {
    Layer::new(&PackedScan::new(scan), &[digest; SIGNATURE_BYTES], &[digest + 1; SKETCH_BYTES])
}

fn header() -> Header {
    Header {
        candidates: 3,
        layers: 1,
        grid: PlanGrid {
            resolution_nm: 10_000_000,
            origin: Point::new(Metres::from_num(-5), Metres::from_num(2)),
        },
        spacing_mm: 500,
        plan_size: [700, 400],
        plan_checksum: 0x1234_5678,
    }
}

fn map() -> Vec<u8> {
    let mut writer = Writer::new(Vec::new(), &header()).unwrap();
    for index in 0..3_u16 {
        writer.candidate([100 * index, 7], &[layer(&scan(usize::from(index) + 1), 9)]).unwrap();
    }
    writer.finish().unwrap()
}

#[test]
fn a_written_map_is_read_back() {
    let bytes = map();
    assert_eq!(Some(bytes.len()), header().map_bytes());
    let map = SiteMap::new(&bytes).unwrap();
    map.verify().unwrap();
    assert_eq!(map.header(), &header());
    assert_eq!(map.len(), 3);
    let mut read = Scan::OPEN;
    let record = map.get(2).unwrap();
    record.scan(&mut read);
    assert!(read == scan(3), "ranges up to 1.2 m are kept exactly");
    assert_eq!(record.cell(), [200, 7]);
    assert_eq!(record.plan_layer().signature_bytes(), &[9; SIGNATURE_BYTES]);
    let position = map.position(2).unwrap();
    assert!((position.x.to_num::<f64>() - (-5.0 + 2.005)).abs() < 1e-9);
    assert!((position.y.to_num::<f64>() - 2.075).abs() < 1e-9);
    assert!(map.get(3).is_none());
    assert!(record.layer(0).is_some() && record.layer(1).is_none());
    assert_eq!(map.iter().count(), 3);
}

#[test]
fn all_layers_are_read_back() {
    let mut writer = Writer::new(Vec::new(), &Header { candidates: 2, layers: 2, ..header() }).unwrap();
    for index in 0..2_u16 {
        let layer = |seed: usize| layer(&scan(usize::from(index) + seed), seed as u8);
        writer.candidate([index, 0], &[layer(1), layer(3)]).unwrap();
    }
    let bytes = writer.finish().unwrap();
    let map = SiteMap::new(&bytes).unwrap();
    let record = map.get(1).unwrap();
    for (number, expected) in [scan(2), scan(4)].iter().enumerate() {
        let (layer, mut read) = (record.layer(number).unwrap(), Scan::OPEN);
        layer.scan(&mut read);
        assert!(read == *expected, "layer {number}");
        assert_eq!(layer.signature_bytes(), &[[1, 3][number]; SIGNATURE_BYTES]);
        assert_eq!(layer.sketch_bytes(), &[[2, 4][number]; SKETCH_BYTES]);
    }
    assert!(record.layer(2).is_none() && record.layer(usize::MAX).is_none());
}

#[test]
fn truncated_and_damaged_maps_are_rejected() {
    let bytes = map();
    for len in 0..bytes.len() {
        assert!(SiteMap::new(&bytes[..len]).is_err(), "{len} bytes");
    }
    assert_eq!(SiteMap::new(&bytes[..30]).unwrap_err(), SiteMapError::Length);
    assert_eq!(SiteMap::new(b"PNG").unwrap_err(), SiteMapError::Magic);
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x20;
        let refused = SiteMap::new(&damaged).and_then(|map| map.verify());
        assert!(refused.is_err(), "byte {at}");
    }
    let mut newer = bytes;
    newer[8] = 2;
    assert_eq!(SiteMap::new(&newer).unwrap_err(), SiteMapError::Version(2));
}
