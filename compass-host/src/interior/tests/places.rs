//! Plans that do not show what is inside, and what is said of them. All have 0.1 m pixels.

use super::*;

const RESOLUTION_M: f64 = 0.1;
const ORIGIN: [f64; 2] = [-5.0, 20.0];

/// The outline of a rectangle `[x0, y0, x1, y1]` in pixels, 2 pixels thick.
fn is_outline([x0, y0, x1, y1]: [u32; 4], x: u32, y: u32) -> bool {
    let within = (x0..x1).contains(&x) && (y0..y1).contains(&y);
    within && !((x0 + 2..x1 - 2).contains(&x) && (y0 + 2..y1 - 2).contains(&y))
}

fn within([x0, y0, x1, y1]: [u32; 4], x: u32, y: u32) -> bool {
    (x0..x1).contains(&x) && (y0..y1).contains(&y)
}

/// 30 m x 20 m with walls on three sides; open to the south.
fn hall() -> Owned {
    Owned::new(400, 300, |x, y| is_outline([50, 50, 350, 250], x, y) && y >= 60)
}

/// A room of 20 m x 16 m with a gate of 14 m in the south.
fn gate() -> Owned {
    Owned::new(300, 260, |x, y| is_outline([50, 50, 250, 210], x, y) && !within([80, 50, 220, 60], x, y))
}

/// Two rooms of 10 m x 10 m with a door of 0.9 m between them and one of 1 m to the outside.
fn flat() -> Owned {
    Owned::new(300, 200, |x, y| {
        let walls = is_outline([50, 50, 150, 150], x, y) || is_outline([148, 50, 250, 150], x, y);
        let doors = within([148, 90, 150, 99], x, y) || within([80, 50, 90, 52], x, y);
        walls && !doors
    })
}

fn found(plan: &Owned, places: Places) -> Result<Interior, InteriorError> {
    let none = Owned::new(plan.width, plan.height, |_, _| false);
    let options = InteriorOptions::with_places(places, ORIGIN);
    find(&plan.view(), &none.view(), RESOLUTION_M, &options)
}

fn points(points: &[[f64; 2]]) -> Places {
    Places { points: points.to_vec(), ..Places::default() }
}

fn region(region: [f64; 4]) -> Places {
    Places { regions: vec![region], ..Places::default() }
}

/// The map position of the centre of a pixel.
fn at(x: u32, y: u32) -> [f64; 2] {
    [ORIGIN[0] + (f64::from(x) + 0.5) * RESOLUTION_M, ORIGIN[1] + (f64::from(y) + 0.5) * RESOLUTION_M]
}

fn refused(plan: &Owned, places: Places) -> PlacesError {
    match found(plan, places) {
        Err(InteriorError::Places(error)) => {
            let text = error.to_string();
            assert!(!text.contains('\n'), "{text}");
            error
        }
        other => panic!("{:?}", other.map(|interior| interior.area_m2())),
    }
}

#[test]
fn a_region_needs_no_walls() {
    let hall = hall();
    assert!(matches!(found(&hall, Places::default()), Err(InteriorError::NoInterior { .. })));
    // From (10 m, 2 m) of the plan to (20 m, 12 m), the corners given the other way round.
    let interior = found(&hall, region([15.0, 32.0, 5.0, 22.0])).unwrap();
    assert_eq!(interior.max_gap_m(), 0.0);
    assert!((99.0..101.0).contains(&interior.area_m2()), "{}", interior.area_m2());
    let none = Owned::new(hall.width, hall.height, |_, _| false);
    let candidates = interior.candidates(&hall.view(), &none.view(), 0.5, CLEARANCE_M).unwrap();
    assert_eq!(candidates.len(), 20 * 20);
    assert!(candidates.iter().all(|&[x, y]| within([100, 20, 200, 120], x.into(), y.into())));
}

#[test]
fn a_region_keeps_clear_of_walls_and_is_cut_at_the_edge_of_the_plan() {
    let hall = hall();
    let interior = found(&hall, region([-100.0, -100.0, 100.0, 100.0])).unwrap();
    let walls = (0..300).flat_map(|y| (0..400).map(move |x| (x, y))).filter(|&(x, y)| hall.view().get(x, y));
    let free = (400 * 300 - walls.count()) as f64 * RESOLUTION_M * RESOLUTION_M;
    assert!((interior.area_m2() - free).abs() < 1e-6, "{} and {free}", interior.area_m2());
    let none = Owned::new(hall.width, hall.height, |_, _| false);
    let candidates = interior.candidates(&hall.view(), &none.view(), 0.5, 1.0).unwrap();
    let on_west_wall = |&&[x, y]: &&[u16; 2]| within([41, 60, 61, 250], x.into(), y.into());
    assert_eq!(candidates.iter().find(on_west_wall), None);
    assert!(candidates.len() > 2000, "{}", candidates.len());
}

#[test]
fn regions_and_points_add_up() {
    let flat = flat();
    let mut places = points(&[at(100, 100)]);
    places.regions = vec![[-5.0, 20.0, -3.0, 22.0], [-5.0, 20.0, -4.0, 23.0]];
    let both = found(&flat, places).unwrap();
    let inside = found(&flat, points(&[at(100, 100)])).unwrap();
    assert!((both.area_m2() - inside.area_m2() - 5.0).abs() < 1e-6);
    assert!(both.is_inside_px(3, 3) && both.is_inside_px(3, 25) && !both.is_inside_px(15, 25));
}

#[test]
fn a_point_reaches_other_rooms_through_doors() {
    let flat = flat();
    let interior = found(&flat, points(&[at(100, 100)])).unwrap();
    assert_eq!(interior.max_gap_m(), 1.5, "the front door is closed");
    assert!(interior.is_inside_px(230, 60) && interior.is_inside_px(60, 140), "both rooms");
    assert!((185.0..195.0).contains(&interior.area_m2()), "{}", interior.area_m2());
    assert!(!interior.is_inside_px(85, 40) && !interior.is_inside_px(10, 10));
}

#[test]
fn a_closed_room_is_only_that_room() {
    let rooms = Owned::new(300, 200, |x, y| {
        is_outline([50, 50, 150, 150], x, y) || is_outline([148, 50, 250, 150], x, y)
    });
    let one = found(&rooms, points(&[at(200, 100)])).unwrap();
    assert_eq!(one.max_gap_m(), 0.0);
    assert!(one.is_inside_px(200, 60) && !one.is_inside_px(100, 60));
    let two = found(&rooms, points(&[at(200, 100), at(60, 60)])).unwrap();
    assert!(two.is_inside_px(200, 60) && two.is_inside_px(100, 60));
}

#[test]
fn a_gate_is_closed_when_told_how_wide_it_is() {
    let gate = gate();
    let point = at(150, 130);
    assert_eq!(
        refused(&gate, points(&[point])),
        PlacesError::PointNotEnclosed { at: point, max_gap_m: 12.0 }
    );
    let options =
        InteriorOptions { max_gap_m: Some(15.0), ..InteriorOptions::with_places(points(&[point]), ORIGIN) };
    let none = Owned::new(gate.width, gate.height, |_, _| false);
    let interior = find(&gate.view(), &none.view(), RESOLUTION_M, &options).unwrap();
    assert_eq!(interior.max_gap_m(), 15.0);
    // The disc bulges into the gate by 4.8 m.
    assert!(interior.is_inside_px(150, 110) && interior.is_inside_px(60, 200));
    assert!((245.0..262.0).contains(&interior.area_m2()), "{}", interior.area_m2());
}

#[test]
fn an_open_point_asks_for_a_region() {
    // A terrace of 6 m x 4 m in the corner of two walls.
    let terrace =
        Owned::new(200, 200, |x, y| within([30, 30, 170, 33], x, y) || within([30, 30, 33, 170], x, y));
    for (plan, point) in [(hall(), at(200, 150)), (terrace, at(70, 70))] {
        let error = refused(&plan, points(&[point]));
        assert!(matches!(error, PlacesError::PointNotEnclosed { .. }), "{error:?}");
        assert!(error.to_string().contains("--region X0,Y0,X1,Y1"), "{error}");
    }
}

#[test]
fn places_off_the_plan_and_in_walls_are_named() {
    let flat = flat();
    for off in [[-5.1, 30.0], [25.1, 30.0], [0.0, 19.9], [0.0, 40.1], [f64::NAN, 30.0]] {
        let error = refused(&flat, points(&[off]));
        assert!(matches!(error, PlacesError::PointOffPlan { .. }), "{error:?}");
        assert!(error.to_string().contains("x -5.00 to 25.00 m, y 20.00 to 40.00 m"), "{error}");
    }
    let wall = at(51, 100);
    assert_eq!(
        refused(&flat, points(&[at(100, 100), wall])),
        PlacesError::PointOccupied { at: wall, cell_m: 0.1 }
    );
    for off in [[-9.0, 20.0, -5.0, 30.0], [25.0, 20.0, 30.0, 30.0], [0.0, 40.0, 1.0, 41.0]] {
        assert!(matches!(refused(&flat, region(off)), PlacesError::RegionOffPlan { .. }));
    }
    for flat_region in [[0.0, 25.0, 0.0, 30.0], [0.0, 25.0, 9.0, 25.0], [0.0, f64::INFINITY, 9.0, 25.0]] {
        let error = refused(&flat, region(flat_region));
        assert_eq!(error, PlacesError::NoRectangle { region: flat_region });
    }
    let in_wall = [0.0, 25.0, 9.0, 25.2];
    let error = refused(&Owned::new(300, 200, |_, y| (50..52).contains(&y)), region(in_wall));
    assert_eq!(error, PlacesError::RegionOccupied { region: in_wall });
}

#[test]
fn a_duct_is_no_place() {
    let duct = Owned::new(100, 100, |x, y| is_outline([40, 40, 51, 51], x, y));
    let error = refused(&duct, points(&[at(45, 45)]));
    assert!(matches!(error, PlacesError::PointInSmallPlace { area_m2, .. } if area_m2 < 0.5), "{error:?}");
}

#[test]
fn the_ladder_is_climbed_for_each_point() {
    // A closed room, and one with a double door of 2.5 m.
    let plan = Owned::new(400, 200, |x, y| {
        is_outline([50, 50, 150, 150], x, y)
            || (is_outline([200, 50, 300, 150], x, y) && !within([220, 50, 245, 52], x, y))
    });
    let interior = found(&plan, points(&[at(100, 100), at(250, 100)])).unwrap();
    assert_eq!(interior.max_gap_m(), 3.0);
    assert!(interior.is_inside_px(60, 60) && interior.is_inside_px(290, 140));
    assert!(!interior.is_inside_px(175, 100), "between the two buildings");
}
