//! Drawn shapes at 0.02 m a pixel, 12 m x 9 m; lengths in metres.

use super::*;
use proptest::prelude::*;

const PIXEL_M: f64 = 0.02;
const SIZE: [u32; 2] = [600, 450];
/// The least thickness asked for.
const THICKNESS_M: f64 = 0.1;

type Shape = Box<dyn Fn(f64, f64) -> bool>;

/// A filled rectangle `x0, y0, x1, y1`.
fn block(x0: f64, y0: f64, x1: f64, y1: f64) -> Shape {
    Box::new(move |x, y| (x0..x1).contains(&x) && (y0..y1).contains(&y))
}

/// The outline of a rectangle, in lines of a thickness that lie within it.
fn outline(x0: f64, y0: f64, x1: f64, y1: f64, thick: f64) -> Shape {
    let (outer, inner) = (block(x0, y0, x1, y1), block(x0 + thick, y0 + thick, x1 - thick, y1 - thick));
    Box::new(move |x, y| outer(x, y) && !inner(x, y))
}

/// A stroke between two points with square ends.
fn stroke(from: [f64; 2], to: [f64; 2], thick: f64) -> Shape {
    let along = [to[0] - from[0], to[1] - from[1]];
    let length = along[0].hypot(along[1]);
    Box::new(move |x, y| {
        let off = [x - from[0], y - from[1]];
        let forward = (off[0] * along[0] + off[1] * along[1]) / length;
        let aside = (off[0] * along[1] - off[1] * along[0]) / length;
        (0.0..length).contains(&forward) && (-thick / 2.0..thick / 2.0).contains(&aside)
    })
}

/// A quarter of a circle in a line of 2 pixels, and the leaf of the door.
fn door(hinge: [f64; 2], radius: f64) -> Shape {
    let leaf = block(hinge[0], hinge[1], hinge[0] + 0.04, hinge[1] + radius);
    Box::new(move |x, y| {
        let (u, v) = (x - hinge[0], y - hinge[1]);
        leaf(x, y) || (u >= 0.0 && v >= 0.0 && (u.hypot(v) - radius).abs() <= 0.02)
    })
}

/// A letter O in strokes of 3 pixels, and one that is a bar.
fn letters(x0: f64, y0: f64) -> Shape {
    let (round, bar) = (outline(x0, y0, x0 + 0.2, y0 + 0.3, 0.06), block(x0 + 0.3, y0, x0 + 0.36, y0 + 0.3));
    Box::new(move |x, y| round(x, y) || bar(x, y))
}

fn mask(shapes: &[Shape]) -> Bits {
    let mut mask = Bits::empty(SIZE[0], SIZE[1]);
    for (x, y) in (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y))) {
        let metres = |at: u32| (f64::from(at) + 0.5) * PIXEL_M;
        if shapes.iter().any(|shape| shape(metres(x), metres(y))) {
            mask.set_run(y, x, x + 1);
        }
    }
    mask
}

fn cleaned_with(walls: &[Shape], windows: &[Shape]) -> (Bits, Cleaned) {
    let windows = mask(windows);
    let walls = mask(walls).without(&windows);
    let mut masks = Masks { walls: walls.to_bytes(), windows: windows.to_bytes() };
    let side = square(THICKNESS_M, PIXEL_M).unwrap();
    let done = clean(&mut masks, SIZE, side, PIXEL_M);
    assert_eq!(masks.windows, windows.to_bytes(), "glazing stays");
    (Bits::new(&masks.walls, SIZE[0], SIZE[1]), done)
}

fn cleaned(walls: &[Shape]) -> Bits {
    cleaned_with(walls, &[]).0
}

/// How many pixels of a shape are set, of all of it.
fn share(mask: &Bits, shape: Shape) -> f64 {
    let shape = super::tests::mask(&[shape]);
    1.0 - shape.without(mask).count() as f64 / shape.count() as f64
}

#[test]
fn walls_stay_to_the_pixel() {
    let walls = || vec![outline(1.0, 1.0, 11.0, 8.0, 0.3), block(5.0, 1.0, 5.1, 8.0)];
    assert!(cleaned(&walls()) == mask(&walls()), "an outer wall of 0.3 m and a partition of 0.1 m");
}

#[test]
fn text_dimensions_arcs_and_hatching_go() {
    let walls = || vec![outline(1.0, 1.0, 11.0, 8.0, 0.3)];
    let mut drawn = walls();
    drawn.extend([
        letters(3.0, 3.0),
        letters(3.5, 3.0),
        door([6.0, 1.3], 0.9),
        // A chain of dimensions with its ticks, across a wall.
        block(0.2, 0.6, 11.8, 0.62),
        stroke([0.9, 0.5], [1.1, 0.7], 0.04),
        block(5.0, 0.4, 5.02, 3.0),
        // A table, a shelf, a tiled floor.
        outline(8.0, 5.0, 9.6, 5.8, 0.04),
        outline(10.1, 2.0, 10.7, 4.0, 0.04),
    ]);
    for row in 0..12 {
        let y = 4.0 + 0.3 * f64::from(row);
        drawn.push(block(1.3, y, 4.6, y + 0.04));
        let x = 1.3 + 0.3 * f64::from(row);
        drawn.push(block(x, 4.0, x + 0.04, 7.34));
    }
    let (kept, done) = cleaned_with(&drawn, &[]);
    // Stubs of lines that meet a wall may stay, up to half of the thickness.
    let near: Vec<Shape> = vec![outline(0.94, 0.94, 11.06, 8.06, 0.46)];
    assert_eq!(kept.without(&mask(&near)).count(), 0);
    assert_eq!(mask(&walls()).without(&kept).count(), 0);
    assert_eq!((done.pieces, done.cavities), (10, 0));
    assert!(done.percent > 20, "{done:?}");
}

#[test]
fn two_lines_are_a_wall() {
    // A room of walls of 0.24 m in lines of 2 pixels, a partition that nothing closes at its end, hatching in one wall.
    let mut drawn = vec![
        outline(1.0, 1.0, 11.0, 8.0, 0.04),
        outline(1.2, 1.2, 10.8, 7.8, 0.04),
        block(5.0, 1.2, 5.04, 4.0),
        block(5.1, 1.2, 5.14, 4.0),
    ];
    let wall = || vec![outline(1.0, 1.0, 11.0, 8.0, 0.24), block(5.0, 1.2, 5.14, 4.0)];
    let (kept, done) = cleaned_with(&drawn, &[]);
    assert_eq!(kept.without(&mask(&wall())).count(), 0);
    assert_eq!(mask(&wall()).without(&kept).count(), 0);
    assert_eq!(done.cavities, 2);
    drawn.extend((0..60).map(|n| {
        let x = 1.2 + 0.15 * f64::from(n);
        stroke([x, 1.02], [x + 0.2, 1.22], 0.03)
    }));
    assert!(share(&cleaned(&drawn), outline(1.0, 1.0, 11.0, 8.0, 0.24)) > 0.99);
}

#[test]
fn stairs_and_doorways_stay_open() {
    // In walls of 0.3 m a doorway of 0.9 m with a line along either side of it and a door that swings; a stair.
    let mut drawn = vec![block(1.0, 4.0, 5.0, 4.3), block(5.9, 4.0, 11.0, 4.3), door([5.0, 4.3], 0.9)];
    drawn.extend([block(5.0, 4.0, 5.9, 4.04), block(5.0, 4.26, 5.9, 4.3)]);
    drawn.extend([block(7.0, 4.3, 7.1, 8.0), block(8.3, 4.3, 8.4, 8.0)]);
    drawn.extend((0..12).map(|n| {
        let y = 4.58 + 0.28 * f64::from(n);
        block(7.1, y, 8.3, y + 0.04)
    }));
    let kept = cleaned(&drawn);
    assert!(share(&kept, block(5.1, 4.05, 5.8, 4.25)) == 0.0, "the doorway");
    assert!(share(&kept, block(5.1, 4.4, 5.9, 5.3)) == 0.0, "the sweep of the door");
    assert!(share(&kept, block(7.2, 4.4, 8.2, 7.9)) == 0.0, "the stair");
    assert_eq!(share(&kept, block(1.0, 4.0, 5.0, 4.3)), 1.0);
    assert_eq!(share(&kept, block(7.0, 4.3, 7.1, 8.0)), 1.0);
}

#[test]
fn columns_stay_and_bold_letters_go() {
    let kept = cleaned(&[
        block(3.0, 3.0, 3.3, 3.3),
        block(5.0, 3.0, 5.14, 3.5),
        outline(6.0, 3.0, 6.4, 3.55, 0.1),
        outline(7.0, 3.0, 7.3, 3.4, 0.04),
        block(1.0, 1.0, 11.0, 1.2),
    ]);
    assert!(kept == mask(&[block(3.0, 3.0, 3.3, 3.3), block(1.0, 1.0, 11.0, 1.2)]));
}

#[test]
fn doorways_between_thick_walls_stay_open() {
    // A single and a double door with lines along both sides, whose arcs are too pale to be seen.
    let kept = cleaned(&[
        block(1.0, 4.0, 3.0, 4.3),
        block(3.9, 4.0, 6.0, 4.3),
        block(7.8, 4.0, 11.0, 4.3),
        block(3.0, 4.0, 3.9, 4.02),
        block(3.0, 4.28, 3.9, 4.3),
        block(6.0, 4.0, 7.8, 4.02),
        block(6.0, 4.28, 7.8, 4.3),
        block(6.89, 4.0, 6.91, 4.3),
    ]);
    assert!(share(&kept, block(3.1, 4.0, 3.8, 4.3)) == 0.0 && share(&kept, block(6.1, 4.0, 7.7, 4.3)) == 0.0);
}

#[test]
fn words_and_arrows_go() {
    // Letters in lines of 3 pixels that leave 2 pixels between them, close to a wall; the outline of an arrow.
    let mut drawn: Vec<Shape> = (0..8).map(|n| letters(3.0 + 0.42 * f64::from(n), 1.5)).collect();
    drawn.extend((0..8).map(|n| letters(3.0 + 0.42 * f64::from(n), 1.9)));
    drawn.extend([block(1.0, 1.0, 11.0, 1.3), outline(8.0, 3.0, 8.4, 4.6, 0.02)]);
    assert!(cleaned(&drawn) == mask(&[block(1.0, 1.0, 11.0, 1.3)]));
}

#[test]
fn glazing_stays_and_holds_short_walls() {
    // Panes in one line with a short pier between them, and panes between two lines of a wall.
    let walls = [block(4.0, 3.0, 4.1, 3.3), block(1.0, 5.0, 9.0, 5.02), block(1.0, 5.2, 9.0, 5.22)];
    let windows = [block(1.0, 3.1, 4.0, 3.16), block(4.1, 3.1, 7.0, 3.16), block(1.0, 5.1, 9.0, 5.12)];
    let (kept, _) = cleaned_with(&walls, &windows);
    assert!(kept == mask(&[block(4.0, 3.0, 4.1, 3.3)]));
}

#[test]
fn bounds_that_mean_nothing_are_refused() {
    for thickness in [0.0, -1.0, f64::NAN, 0.029, 2.01] {
        assert_eq!(square(thickness, PIXEL_M), None, "{thickness}");
    }
    assert_eq!([0.03, 0.1, 2.0].map(|thickness| square(thickness, PIXEL_M)), [Some(2), Some(4), Some(71)]);
}

#[test]
fn a_plan_of_lines_leaves_nothing() {
    let (kept, done) = cleaned_with(&[outline(1.0, 1.0, 11.0, 8.0, 0.04)], &[]);
    assert_eq!((kept.count(), done.percent, done.pieces), (0, 100, 1));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn strokes_stay_by_their_thickness_in_any_direction(angle in 0.0_f64..180.0, thick in 0.1_f64..0.3) {
        let (sin, cos) = angle.to_radians().sin_cos();
        let at = |along: f64| [6.0 + along * cos, 4.5 + along * sin];
        let kept = share(&cleaned(&[stroke(at(-3.0), at(3.0), thick)]), stroke(at(-3.0), at(3.0), thick));
        prop_assert!(kept > 0.97, "{thick} m at {angle} degrees: {kept}");
        let line = cleaned(&[stroke(at(-3.0), at(3.0), 0.05)]);
        prop_assert_eq!(line.count(), 0);
    }

    #[test]
    fn two_lines_are_a_wall_in_any_direction(angle in 0.0_f64..180.0, thick in 0.15_f64..0.4) {
        let (sin, cos) = angle.to_radians().sin_cos();
        let at = |along: f64| [6.0 + along * cos, 4.5 + along * sin];
        let wall = || stroke(at(-3.0), at(3.0), thick);
        let (outer, inner) = (wall(), stroke(at(-2.95), at(2.95), thick - 0.1));
        let lines: Shape = Box::new(move |x, y| outer(x, y) && !inner(x, y));
        let kept = share(&cleaned(&[lines]), wall());
        prop_assert!(kept > 0.97, "{thick} m at {angle} degrees: {kept}");
    }

    #[test]
    fn nothing_is_wall_that_was_free_but_cavities(boxes in proptest::collection::vec((0.0_f64..9.0, 0.0_f64..7.0, 0.02_f64..3.0, 0.02_f64..2.0), 1..6)) {
        let shapes = || boxes.iter().map(|&(x, y, w, h)| block(x, y, x + w, y + h)).collect::<Vec<_>>();
        let (walls, kept) = (mask(&shapes()), cleaned(&shapes()));
        let cavities = cavities::of(&walls, &mask(&[]), &mask(&[]), PIXEL_M);
        prop_assert_eq!(kept.without(&walls.or(&cavities)).count(), 0);
        prop_assert!(cavities.without(&walls) == cavities);
    }
}
