//! The CAD drawing of a real site against the raster of its plan.

use compass_core::base::scan::Hit;
use compass_host::interior::{self, InteriorOptions, Places};
use compass_host::plan_import::structure::{DEFAULT_THICKNESS_M, keep_structure};
use compass_host::plan_import::{PlanOptions, import, load};
use compass_host::reference;
use compass_tests::recordings;

/// The drawing lies here on the map, in metres.
const OFFSET: [f64; 2] = [50.92, 3.27];

/// At 200 places, at least 90 % of the rays that end on structure in both are as long within 5 cm.
#[test]
fn structure_of_a_drawing_is_that_of_the_raster() {
    let Some(data) = recordings("structure_of_a_drawing_is_that_of_the_raster") else { return };
    let drawing = import(&PlanOptions::new(data.join("plans/hilti_floor_1.dxf"))).unwrap();
    assert!(drawing.has_structure());
    let drawn = drawing.structure(DEFAULT_THICKNESS_M, &Places::default()).unwrap();
    let mut options = PlanOptions::new(data.join("hilti/floorplans/masks_with_windows/floor_1.png"));
    options.walls = Some(data.join("hilti/floorplans/masks_no_windows/floor_1.png"));
    let raster = keep_structure(&load(&options).unwrap(), DEFAULT_THICKNESS_M).unwrap();

    let float = |plan: &compass_host::PlanRaster| {
        reference::Plan::new(&plan.walls_mask(), &plan.windows_mask(), plan.resolution_m, plan.origin)
    };
    let (from_drawing, from_raster) = (float(&drawn), float(&raster));
    let (walls, windows) = (raster.walls_mask(), raster.windows_mask());
    let inside = interior::find(&walls, &windows, raster.resolution_m, &InteriorOptions::default()).unwrap();
    let places = inside.candidates(&walls, &windows, 2.0, 0.3).unwrap();
    let (mut positions, mut both, mut near, mut nearer, mut farther) = (0, 0, 0, 0, 0);
    for [column, row] in places.iter().step_by((places.len() / 200).max(1)).take(200) {
        let [x, y] = [column, row].map(|cell| (f64::from(*cell) + 0.5) * raster.resolution_m);
        let scans = from_raster.scan(x, y, 0.0).zip(from_drawing.scan(x - OFFSET[0], y - OFFSET[1], 0.0));
        let Some((raster, drawn)) = scans else { continue };
        positions += 1;
        for bin in 0..360 {
            if raster.hit[bin] == Hit::Wall && drawn.hit[bin] == Hit::Wall {
                let difference = drawn.range_m[bin] - raster.range_m[bin];
                both += 1;
                near += usize::from(difference.abs() <= 0.05);
                nearer += usize::from(difference < -0.05);
                farther += usize::from(difference > 0.05);
            }
        }
    }
    println!(
        "{positions} positions, {both} rays on structure in both, {near} within 5 cm, {nearer} nearer in the drawing, {farther} farther"
    );
    assert!(positions >= 150 && 10 * near >= 9 * both, "{near} of {both}");
}
