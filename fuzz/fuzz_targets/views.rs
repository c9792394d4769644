//! Views of binary files with damage, used without `verify`: no panic, no read out of bounds.
#![no_main]

use compass_core::map::site_map::SiteMap;
use compass_core::vision::shot::Shot;
use compass_core::{Metres, Point, Scan, Site, Turn};
use compass_fuzz::{edited, sealed, shot, site};
use libfuzzer_sys::fuzz_target;

/// The corner of a plan.
const ORIGIN: Point = Point::new(Metres::ZERO, Metres::ZERO);

fuzz_target!(|data: &[u8]| {
    let Some((kind, data)) = data.split_first() else { return };
    let bytes = match kind % 6 {
        0 => sealed(edited(site(), data)),
        1 => edited(site(), data),
        2 => sealed(edited(&site()[64..], data)),
        3 => sealed(edited(&shot(), data)),
        4 => edited(&shot(), data),
        _ => data.to_vec(),
    };
    if let Ok(site) = Site::new(&bytes) {
        let _ = site.verify();
        site.floors().for_each(|floor| {
            walk(floor.map());
            for plan in [floor.plan(0), floor.plan(1)].into_iter().flatten() {
                let _ = plan.verify();
                let mut scan = Scan::OPEN;
                let _ = plan.scan(floor.map().position(0).unwrap_or(ORIGIN), Turn::ZERO, &mut scan);
                let _ = plan.hit_at(ORIGIN);
            }
        });
    }
    if let Ok(map) = SiteMap::new(&bytes) {
        walk(&map);
    }
    if let Ok(shot) = Shot::new(&bytes) {
        let _ = (shot.verify(), shot.header());
        for (gray, mask) in shot.images().into_iter().flatten() {
            let [width, height] = [gray.width(), gray.height()];
            let _ = (gray.pixels().last(), mask.get(width - 1, height - 1));
        }
    }
});

fn walk(map: &SiteMap<'_>) {
    let _ = map.verify();
    let mut scan = Scan::OPEN;
    for (at, record) in map.iter().enumerate().take(50) {
        record.scan(&mut scan);
        let _ = (map.position(at), record.layer(1).map(|layer| layer.scan(&mut scan)));
    }
}
