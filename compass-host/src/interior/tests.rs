//! ASCII-art plans (`#` wall, `o` window, north up), and the real plans if available.

mod places;

use std::time::Instant;

use super::*;

/// A mask that owns its bits.
struct Owned {
    bits: Vec<u8>,
    width: u32,
    height: u32,
}

impl Owned {
    fn new(width: u32, height: u32, set: impl Fn(u32, u32) -> bool) -> Self {
        let stride = BitMask::row_bytes(width);
        let mut bits = vec![0; stride * height as usize];
        for y in 0..height {
            for x in (0..width).filter(|&x| set(x, y)) {
                bits[y as usize * stride + x as usize / 8] |= 1 << (x % 8);
            }
        }
        Self { bits, width, height }
    }

    fn art(rows: &[&str], mark: u8) -> Self {
        let (width, height) = (rows[0].len() as u32, rows.len() as u32);
        Self::new(width, height, |x, y| rows[(height - 1 - y) as usize].as_bytes()[x as usize] == mark)
    }

    fn view(&self) -> BitMask<'_> {
        BitMask::new(&self.bits, self.width, self.height).unwrap()
    }
}

/// Finds the interior of ASCII art and draws it: `.` inside, blank outside.
fn drawn(rows: &[&str], resolution_m: f64, options: &InteriorOptions) -> Result<Vec<String>, InteriorError> {
    let (walls, windows) = (Owned::art(rows, b'#'), Owned::art(rows, b'o'));
    let interior = find(&walls.view(), &windows.view(), resolution_m, options)?;
    let height = rows.len() as u32;
    let cell = |x: usize, row: usize, c: char| match c {
        ' ' if interior.is_inside_px(x as u32, height - 1 - row as u32) => '.',
        c => c,
    };
    let line = |(row, line): (usize, &&str)| line.chars().enumerate().map(|(x, c)| cell(x, row, c)).collect();
    Ok(rows.iter().enumerate().map(line).collect())
}

#[test]
fn closes_a_room_with_a_door() {
    let room = [
        "                ",
        "  #####oooo###  ",
        "  #          #  ",
        "  #    ##    #  ",
        "  #    ##    #  ",
        "  #          #  ",
        "  ######   ###  ",
        "                ",
    ];
    let want = [
        "                ",
        "  #####oooo###  ",
        "  #..........#  ",
        "  #....##....#  ",
        "  #....##....#  ",
        "  #..........#  ",
        "  ######   ###  ",
        "                ",
    ];
    let got = drawn(&room, 0.3, &InteriorOptions::with_max_gap_m(1.5)).unwrap();
    for (got, want) in got.iter().zip(want).skip(1).take(5) {
        assert_eq!(got, want);
    }
    assert!(!got[7].contains('.') && !got[0].contains('.'), "{got:#?}");
}

#[test]
fn ladder_takes_the_smallest_gap_that_works() {
    let gap = |side: u32, door: u32| {
        let walls = Owned::new(side + 40, side + 40, |x, y| {
            let (on, span) = ([20, side + 19], 20..side + 20);
            let frame = (on.contains(&x) && span.contains(&y)) || (on.contains(&y) && span.contains(&x));
            frame && !(y == 20 && (40..40 + door).contains(&x))
        });
        let none = Owned::new(side + 40, side + 40, |_, _| false);
        find(&walls.view(), &none.view(), 0.1, &InteriorOptions::default()).unwrap().max_gap_m()
    };
    assert_eq!(gap(100, 0), 0.5);
    assert_eq!(gap(100, 10), 1.5);
    assert_eq!(gap(100, 25), 3.0);
    assert_eq!(gap(100, 45), 6.0);
    assert_eq!(gap(200, 100), 12.0);
}

#[test]
fn court_of_a_u_shaped_building_is_outside() {
    let plan = [
        "                    ",
        " ######      ###### ",
        " #    #      #    # ",
        " #    #      #    # ",
        " #    #      #    # ",
        " #    #      #    # ",
        " #    ########    # ",
        " #                # ",
        " #                # ",
        " ################## ",
        "                    ",
    ];
    let got = drawn(&plan, 0.5, &InteriorOptions::default()).unwrap();
    for (row, line) in got.iter().enumerate() {
        assert!(row > 5 || !line[7..13].contains('.'), "court in row {row}: {got:#?}");
    }
    assert_eq!(got[3], " #....#      #....# ");
    assert_eq!(got[7], " #................# ");
}

#[test]
fn open_plans_have_no_interior() {
    let columns = ["          ", "  #    #  ", "          ", "  #    #  ", "          "];
    let none = Err(InteriorError::NoInterior { max_gap_m: 12.0 });
    assert_eq!(drawn(&columns, 0.5, &InteriorOptions::default()), none);
    assert_eq!(drawn(&["    ", "    "], 0.5, &InteriorOptions::default()), none);
    assert_eq!(drawn(&["####", "####"], 0.5, &InteriorOptions::default()), none);
    // A closed duct of 0.25 m2 is not a room.
    let duct = drawn(&["###", "# #", "###"], 0.5, &InteriorOptions::default());
    assert!(matches!(duct, Err(InteriorError::NoInterior { .. })), "{duct:?}");
    let message = InteriorError::NoInterior { max_gap_m: 12.0 }.to_string();
    assert!(message.starts_with("plan has no interior: ") && !message.contains('\n'), "{message}");
}

#[test]
fn refuses_unusable_input() {
    let room = ["####", "#  #", "#  #", "####"];
    let options = InteriorOptions::default();
    for resolution in [0.0, -1.0, f64::INFINITY] {
        assert_eq!(drawn(&room, resolution, &options), Err(InteriorError::Resolution(resolution)));
    }
    assert!(matches!(drawn(&room, f64::NAN, &options), Err(InteriorError::Resolution(_))));
    for gap in [0.0, -1.0, 101.0] {
        let asked = InteriorOptions::with_max_gap_m(gap);
        assert_eq!(drawn(&room, 1.0, &asked), Err(InteriorError::Gap(gap)));
    }
    let (walls, small) = (Owned::art(&room, b'#'), Owned::new(3, 4, |_, _| false));
    let got = find(&walls.view(), &small.view(), 1.0, &options).unwrap_err();
    assert_eq!(got, InteriorError::Size(4, 4, 3, 4));

    let walls = walls.view();
    let interior = find(&walls, &walls, 1.0, &options).unwrap();
    assert_eq!(interior.area_m2(), 4.0);
    assert_eq!(interior.candidates(&walls, &walls, 0.0, 0.2), Err(InteriorError::Spacing(0.0)));
    assert!(matches!(interior.candidates(&walls, &walls, f64::NAN, 0.2), Err(InteriorError::Spacing(_))));
    assert_eq!(interior.candidates(&walls, &walls, 1.0, -0.1), Err(InteriorError::Clearance(-0.1)));
    let small = small.view();
    assert_eq!(interior.candidates(&small, &small, 1.0, 0.2), Err(InteriorError::Size(3, 4, 4, 4)));
}

#[test]
fn distances_match_brute_force() {
    let mask = Owned::new(37, 23, |x, y| (x * 7 + y * 13 + x * y) % 41 == 0);
    let grid = Grid::new(&mask.view(), &mask.view(), 1, 3);
    let got = grid.distance2(&grid.occupied);
    let place = |at: usize| ((at % grid.columns) as i32, (at / grid.columns) as i32);
    for (at, &got) in got.iter().enumerate() {
        let (x, y) = place(at);
        let marked = (0..grid.occupied.len()).filter(|&other| grid.occupied[other]).map(place);
        let want = marked.map(|(u, v)| (x - u).pow(2) + (y - v).pow(2)).min().unwrap();
        assert_eq!(got, want, "at {x}, {y}");
    }
}

#[test]
fn enclosure_matches_stepping_along_rays() {
    let mask = Owned::new(70, 90, |x, y| (x / 6 * 31 + y / 6 * 17 + (x / 6) * (y / 6)) % 37 == 0);
    let grid = Grid::new(&mask.view(), &mask.view(), 1, 2);
    let hits = enclosure::hits(&grid);
    let occupied = |x: f64, y: f64| {
        let on_grid = x >= 0.0 && y >= 0.0 && x < grid.columns as f64 && y < grid.rows as f64;
        on_grid.then(|| grid.occupied[y as usize * grid.columns + x as usize])
    };
    let mut error = 0.0;
    for (at, &got) in hits.iter().enumerate().filter(|(at, _)| !grid.occupied[*at]) {
        let (x, y) = ((at % grid.columns) as f64 + 0.5, (at / grid.columns) as f64 + 0.5);
        let meets = |ray: &u8| {
            let (dy, dx) = ((f64::from(*ray) + 0.5) * core::f64::consts::TAU / 64.0).sin_cos();
            (0..2000)
                .map_while(|step| occupied(x + 0.1 * f64::from(step) * dx, y + 0.1 * f64::from(step) * dy))
                .any(|occupied| occupied)
        };
        let want = (0..64_u8).filter(meets).count() as f64;
        assert!((f64::from(got) - want).abs() <= 10.0, "cell {at}: {got} for {want}");
        error += (f64::from(got) - want).abs() / hits.len() as f64;
    }
    assert!(error < 2.0, "mean difference {error} rays");
}

#[test]
fn candidates_keep_clear_and_reach_narrow_places() {
    // A room of 3.9 m x 3.5 m and a corridor of 0.44 m along its east side that the grid misses.
    let walls = Owned::new(520, 420, |x, y| {
        let plan = (20..480).contains(&x) && (20..390).contains(&y);
        let room = (30..420).contains(&x) && (30..380).contains(&y);
        let corridor = (426..470).contains(&x) && (30..380).contains(&y);
        plan && !room && !corridor
    });
    let none = Owned::new(520, 420, |_, _| false);
    let (walls, none) = (walls.view(), none.view());
    let interior = find(&walls, &none, 0.01, &InteriorOptions::default()).unwrap();
    let points = interior.candidates(&walls, &none, 0.5, CLEARANCE_M).unwrap();
    for &[x, y] in &points {
        let (x, y) = (i32::from(x), i32::from(y));
        assert!(interior.is_inside_px(x as u32, y as u32));
        for (dx, dy) in (-19..20).flat_map(|dx| (-19..20).map(move |dy| (dx, dy))) {
            let hit = dx * dx + dy * dy < 400 && walls.get((x + dx) as u32, (y + dy) as u32);
            assert!(!hit, "occupied {dx}, {dy} from {x}, {y}");
        }
    }
    let on_grid = points.iter().filter(|point| point[0] % 50 == 25 && point[1] % 50 == 25).count();
    assert_eq!(on_grid, 7 * 6, "grid points 75..=375 by 75..=325");
    let corridor = points.iter().filter(|point| point[0] > 426).count();
    assert!((4..=8).contains(&corridor), "{corridor} in the corridor: {points:?}");
    let rows: Vec<u16> = points.iter().map(|point| point[1] / 50).collect();
    assert!(rows.is_sorted(), "row by row");
}

/// Draws plan, interior and candidates at a sixth of the size.
fn render(path: &std::path::Path, walls: &BitMask<'_>, interior: &Interior, points: &[[u16; 2]]) {
    let scale = 6;
    let (width, height) = (walls.width() / scale, walls.height() / scale);
    let mut image = image::RgbImage::from_fn(width, height, |x, y| {
        let (x0, y0) = (x * scale, (height - 1 - y) * scale);
        let wall = (0..scale * scale).any(|at| walls.get(x0 + at % scale, y0 + at / scale));
        image::Rgb(match (wall, interior.is_inside_px(x0 + 3, y0 + 3)) {
            (true, _) => [0, 0, 0],
            (_, true) => [170, 220, 255],
            _ => [255, 255, 255],
        })
    });
    for &[x, y] in points {
        let (x, y) = (u32::from(x) / scale, (height - 1).saturating_sub(u32::from(y) / scale));
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            if let Some(pixel) = image.get_pixel_mut_checked(x + dx, y + dy) {
                *pixel = image::Rgb([220, 0, 0]);
            }
        }
    }
    image.save(path).unwrap();
}

#[test]
fn real_plans() {
    let Some(data) = std::env::var_os("COMPASS_DATA") else {
        println!("skipped: COMPASS_DATA is not set");
        return;
    };
    let plans = std::path::Path::new(&data).join("hilti/floorplans/masks_with_windows");
    // Bounds of the interior from the outline of each plan, in square metres.
    for (name, least, most) in
        [("floor_1", 900.0, 1300.0), ("floor_2", 900.0, 1300.0), ("floor_UG1", 2500.0, 4500.0)]
    {
        let mut reader = image::ImageReader::open(plans.join(name).with_extension("png")).unwrap();
        reader.no_limits();
        let plan = reader.decode().unwrap().into_luma8();
        let (width, height) = plan.dimensions();
        let walls = Owned::new(width, height, |x, y| plan.get_pixel(x, height - 1 - y)[0] < 128);
        let none = Owned::new(width, height, |_, _| false);
        let (walls, none) = (walls.view(), none.view());
        let start = Instant::now();
        let interior = find(&walls, &none, 0.01, &InteriorOptions::default()).unwrap();
        let found = start.elapsed();
        let points = interior.candidates(&walls, &none, 0.5, CLEARANCE_M).unwrap();
        println!(
            "{name}: {:.0} m2, gap {} m, {} candidates, find {found:.1?}, with candidates {:.1?}",
            interior.area_m2(),
            interior.max_gap_m(),
            points.len(),
            start.elapsed()
        );
        render(&std::env::temp_dir().join(format!("interior_{name}.png")), &walls, &interior, &points);
        assert!((least..most).contains(&interior.area_m2()), "{name}: {} m2", interior.area_m2());
    }
}
