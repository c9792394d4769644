//! The bundled sample building: an office floor drawn by the project itself, from the tables below.
//!
//! No file is read and nothing is random, so every caller gets the same bits. The floor is
//! 30 m x 20 m with a corridor loop around a structural core, cellular rooms on the south, west and
//! north facades, an open-plan area in the east and one facade corner at 45 degrees. It has no
//! global symmetry. Rooms S2 and S3 are alike in shape, door and surroundings and differ only in
//! windows: without the glazing class they are easily confused.
//!
//! # Formats
//! The tables are in metres from the outer south-west corner of the building. Masks and
//! [`DEMO_POSE`] count from the corner of the image, [`MARGIN_M`] further out to the south-west.

use crate::plan_import::PlanRaster;
use image::{Rgb, RgbImage};

/// Side of a pixel in metres.
pub const RESOLUTION_M: f64 = 0.01;

/// White border around the building in metres.
pub const MARGIN_M: f64 = 1.0;

/// A free pose in room S3, with the window bay and, through the doorway, the corridor in view.
///
/// `[x, y]` in metres from the bottom-left corner of the image, then the heading in degrees,
/// counter-clockwise from east.
pub const DEMO_POSE: ([f64; 2], f64) = ([13.37, 3.68], 74.0);

/// A free pose in the hall in the north-west, from which frames are rendered: position, then heading as above.
pub const FRAME_POSE: ([f64; 2], f64) = ([4.12, 17.77], 288.6);

/// Pixels along x and y of those frames.
pub const FRAME_PIXELS: (u32, u32) = (736, 720);

/// Height of cam0 above the floor there, metres.
pub const FRAME_HEIGHT_M: f64 = 1.6;

/// Pitch and roll of cam0 there, degrees: it looks up a little and hangs upside down with some roll.
pub const FRAME_PITCH_ROLL_DEG: [f64; 2] = [4.0, 187.0];

/// Width and height of the image in pixels: building and margin on both sides.
const SIZE_PX: (u32, u32) = (3200, 2200);
/// Thickness of the facade.
const FACADE: f64 = 0.4;
/// Thickness of the walls of the core.
const CORE: f64 = 0.3;
/// Thickness of the walls within the core.
const INNER: f64 = 0.2;
/// Thickness of partitions.
const PARTITION: f64 = 0.12;
/// Thickness of glass, centred in its wall.
const GLASS: f64 = 0.12;

/// The sample floor as masks of [`compass_core::base::raster::BitMask`] layout.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SampleBuilding {
    /// Pixels along x (east).
    pub width: u32,
    /// Pixels along y (north).
    pub height: u32,
    /// Opaque structure: walls, pillars, columns. Row 0 is the southernmost.
    pub walls: Vec<u8>,
    /// Glazing. Shares no pixel with `walls`.
    pub windows: Vec<u8>,
}

impl From<SampleBuilding> for PlanRaster {
    fn from(building: SampleBuilding) -> Self {
        let SampleBuilding { width, height, walls, windows } = building;
        Self { width, height, walls, windows, resolution_m: RESOLUTION_M, origin: [0.0, 0.0] }
    }
}

/// An interruption of a wall from one coordinate to another.
#[derive(Debug, Clone, Copy)]
enum Opening {
    /// Open through the whole thickness.
    Door(f64, f64),
    /// Glass in the middle of the thickness.
    Glazing(f64, f64),
}
use Opening::{Door, Glazing};

/// A straight wall about a centre line, with square ends.
#[derive(Debug, Clone, Copy)]
struct Wall {
    from: [f64; 2],
    to: [f64; 2],
    thickness: f64,
    /// Coordinate of `from` in the scale in which `openings` are given.
    origin: f64,
    openings: &'static [Opening],
}

/// A wall running east at `y` from `x0` to `x1`; openings are given by their x.
const fn along_x(y: f64, (x0, x1): (f64, f64), thickness: f64, openings: &'static [Opening]) -> Wall {
    Wall { from: [x0, y], to: [x1, y], thickness, origin: x0, openings }
}

/// A wall running north at `x` from `y0` to `y1`; openings are given by their y.
const fn along_y(x: f64, (y0, y1): (f64, f64), thickness: f64, openings: &'static [Opening]) -> Wall {
    Wall { from: [x, y0], to: [x, y1], thickness, origin: y0, openings }
}

/// A wall in any direction; openings are given by their distance from `from`.
const fn slanted(from: [f64; 2], to: [f64; 2], thickness: f64, openings: &'static [Opening]) -> Wall {
    Wall { from, to, thickness, origin: 0.0, openings }
}

/// The outer shell, counter-clockwise from the south. It has glazing but no doorway.
const FACADE_WALLS: &[Wall] = &[
    along_x(
        0.2,
        (0.0, 30.0),
        FACADE,
        &[
            // S1
            Glazing(0.9, 2.5),
            Glazing(2.9, 4.5),
            Glazing(4.9, 6.4),
            // S2: two bays, S3: a single wide one
            Glazing(7.2, 8.4),
            Glazing(8.8, 10.0),
            Glazing(10.9, 13.5),
            // Lobby: glazed entrance, closed
            Glazing(14.4, 16.0),
            Glazing(16.2, 17.1),
            Glazing(17.3, 18.3),
            // S5, S6, S7
            Glazing(19.1, 21.5),
            Glazing(22.5, 23.3),
            Glazing(23.7, 24.5),
            Glazing(25.4, 27.2),
            Glazing(27.6, 29.0),
        ],
    ),
    along_y(
        29.8,
        (0.0, 15.5),
        FACADE,
        &[
            Glazing(0.9, 2.3),
            Glazing(2.7, 4.7),
            Glazing(5.8, 7.0),
            Glazing(7.6, 9.8),
            Glazing(10.2, 12.4),
            Glazing(12.8, 15.0),
        ],
    ),
    slanted([29.86, 15.36], [25.36, 19.86], FACADE, &[Glazing(0.5, 2.9), Glazing(3.4, 5.8)]),
    along_x(
        19.8,
        (0.0, 25.5),
        FACADE,
        &[
            // N1
            Glazing(0.8, 3.0),
            Glazing(3.4, 5.0),
            Glazing(5.4, 6.4),
            // N2, N3, N4, N5
            Glazing(7.3, 9.8),
            Glazing(10.7, 11.9),
            Glazing(12.4, 13.9),
            Glazing(14.8, 16.0),
            Glazing(16.3, 17.2),
            Glazing(18.3, 19.3),
            // Open plan
            Glazing(20.5, 22.5),
            Glazing(22.9, 24.9),
        ],
    ),
    along_y(
        0.2,
        (0.0, 20.0),
        FACADE,
        &[
            // S1
            Glazing(0.8, 2.6),
            Glazing(3.0, 4.8),
            // W1, W2, W3
            Glazing(6.0, 8.3),
            Glazing(9.2, 10.0),
            Glazing(10.5, 11.3),
            Glazing(12.3, 13.3),
            // N1
            Glazing(14.4, 16.4),
            Glazing(16.9, 19.1),
        ],
    ),
];

/// The core: stairs in the west, two lifts over a closed shaft and a store, washrooms in the east.
const CORE_WALLS: &[Wall] = &[
    along_x(7.45, (7.1, 17.6), CORE, &[]),
    along_x(11.95, (7.1, 17.6), CORE, &[Door(11.2, 12.1), Door(13.2, 14.1)]),
    along_y(7.25, (7.3, 12.1), CORE, &[Door(10.4, 11.4)]),
    along_y(17.45, (7.3, 12.1), CORE, &[Door(8.2, 9.1), Door(10.4, 11.3)]),
    // Stairs and the spine between their flights
    along_y(10.55, (7.4, 12.0), CORE, &[]),
    along_x(9.7, (8.8, 10.5), INNER, &[]),
    // Lifts, shaft, store
    along_x(9.45, (10.6, 14.8), CORE, &[]),
    along_y(12.65, (9.4, 12.0), INNER, &[]),
    along_y(12.35, (7.4, 9.5), CORE, &[]),
    along_y(14.75, (7.4, 12.0), CORE, &[Door(8.0, 8.9)]),
    // Washrooms with their cubicles
    along_x(9.76, (14.8, 17.4), PARTITION, &[]),
    along_y(15.96, (10.9, 11.9), PARTITION, &[]),
    along_x(10.86, (14.8, 16.02), PARTITION, &[Door(15.0, 15.7)]),
];

/// Partitions between rooms and towards the corridors.
const PARTITIONS: &[Wall] = &[
    // South corridor: S1, S2, S3, then the open lobby, then S5, S6, S7
    along_x(5.46, (0.2, 14.06), PARTITION, &[Door(5.6, 6.5), Door(9.0, 9.95), Door(12.6, 13.55)]),
    along_x(5.46, (18.54, 29.7), PARTITION, &[Door(19.0, 19.95), Door(23.8, 24.7), Door(25.5, 26.5)]),
    along_y(6.8, (0.3, 5.5), PARTITION, &[]),
    along_y(10.4, (0.3, 5.5), PARTITION, &[]),
    along_y(14.0, (0.3, 5.5), PARTITION, &[]),
    along_y(18.6, (0.3, 5.5), PARTITION, &[Glazing(1.6, 3.8)]),
    along_y(22.0, (0.3, 5.5), PARTITION, &[]),
    along_y(25.0, (0.3, 5.5), PARTITION, &[]),
    // West corridor: W1, W2, W3
    along_y(5.26, (5.4, 14.02), PARTITION, &[Door(7.5, 8.4), Door(9.2, 10.1), Door(12.7, 13.6)]),
    along_x(8.8, (0.3, 5.3), PARTITION, &[]),
    along_x(11.6, (0.3, 5.3), PARTITION, &[]),
    // North corridor: N1 to N4, and N5, the kitchen, which opens to the east
    along_x(
        13.96,
        (0.2, 20.06),
        PARTITION,
        &[Door(5.6, 6.5), Door(7.3, 8.25), Door(13.1, 14.0), Door(14.8, 15.7)],
    ),
    along_y(6.9, (13.9, 19.7), PARTITION, &[]),
    along_y(10.2, (13.9, 19.7), PARTITION, &[]),
    along_y(14.4, (13.9, 19.7), PARTITION, &[Door(17.9, 18.8)]),
    along_y(17.6, (13.9, 19.7), PARTITION, &[]),
    along_y(20.0, (13.9, 19.7), PARTITION, &[Door(14.5, 15.5)]),
    // Archive between the east corridor and the open plan
    along_y(19.46, (7.4, 10.0), PARTITION, &[Door(8.6, 9.5)]),
    along_x(7.46, (19.4, 22.3), PARTITION, &[]),
    along_x(9.96, (19.4, 22.3), PARTITION, &[]),
    along_y(22.24, (7.4, 10.02), PARTITION, &[]),
    // Meeting room, glazed on three sides
    along_x(9.46, (23.4, 27.9), PARTITION, &[]),
    along_x(12.94, (23.4, 27.9), PARTITION, &[Glazing(23.52, 25.5), Glazing(25.62, 27.78)]),
    along_y(23.46, (9.4, 13.0), PARTITION, &[Door(9.7, 10.65), Glazing(10.77, 12.88)]),
    along_y(27.84, (9.4, 13.0), PARTITION, &[Glazing(9.52, 11.2), Glazing(11.32, 12.88)]),
    // Project corner in the open plan
    along_y(24.86, (16.6, 18.6), PARTITION, &[]),
    along_x(16.66, (24.8, 26.2), PARTITION, &[]),
];

/// Solid rectangles `[west, south, east, north]`: free-standing columns and facade pillars.
const SOLIDS: &[[f64; 4]] = &[
    // Columns of the lobby and of the open plan
    [15.0, 4.3, 15.4, 4.7],
    [17.2, 4.3, 17.6, 4.7],
    [20.4, 11.7, 20.8, 12.1],
    [22.2, 14.2, 22.6, 14.6],
    [26.4, 14.2, 26.8, 14.6],
    [22.2, 17.4, 22.6, 17.8],
    [24.6, 7.2, 25.0, 7.6],
    // Pillars which stand out of the facade on the structural axes
    [6.6, 0.3, 7.0, 0.6],
    [10.2, 0.3, 10.6, 0.6],
    [13.8, 0.3, 14.2, 0.6],
    [21.8, 0.3, 22.2, 0.6],
    [6.7, 19.4, 7.1, 19.7],
    [14.2, 19.4, 14.6, 19.7],
    [19.8, 19.4, 20.2, 19.7],
    [0.3, 8.6, 0.6, 9.0],
    [0.3, 13.76, 0.6, 14.16],
    [29.4, 5.26, 29.7, 5.66],
    [29.4, 9.8, 29.7, 10.2],
];

/// Draws the sample building.
///
/// # Cost
/// Visits the bounding box of every element: 1.02 million pixels. The two masks take 1.76 MB.
/// # Panics
/// Never.
#[must_use]
pub fn building() -> SampleBuilding {
    let (width, height) = SIZE_PX;
    let mut plan = Canvas { walls: Mask::new(width, height), windows: Mask::new(width, height) };
    for wall in [FACADE_WALLS, CORE_WALLS, PARTITIONS].into_iter().flatten() {
        plan.wall(wall);
    }
    for &solid in SOLIDS {
        plan.rect(solid);
    }
    SampleBuilding { width, height, walls: plan.walls.bits, windows: plan.windows.bits }
}

/// Renders a building as an architect's image: white free, black walls, pure red glazing, north up.
#[must_use]
pub fn image(building: &SampleBuilding) -> RgbImage {
    let row_bytes = row_bytes(building.width);
    RgbImage::from_fn(building.width, building.height, |x, row| {
        let y = building.height - 1 - row;
        if get(&building.walls, row_bytes, x, y) {
            Rgb([0, 0, 0])
        } else if get(&building.windows, row_bytes, x, y) {
            Rgb([255, 0, 0])
        } else {
            Rgb([255, 255, 255])
        }
    })
}

/// Bytes of one mask row.
const fn row_bytes(width: u32) -> usize {
    compass_core::base::raster::BitMask::row_bytes(width)
}

/// The pixel at column `x`, row `y`; beyond the data it is unset.
fn get(bits: &[u8], row_bytes: usize, x: u32, y: u32) -> bool {
    bits.get(y as usize * row_bytes + x as usize / 8).is_some_and(|byte| byte >> (x % 8) & 1 == 1)
}

/// A bit mask under construction.
struct Mask {
    bits: Vec<u8>,
    row_bytes: usize,
}

impl Mask {
    fn new(width: u32, height: u32) -> Self {
        let row_bytes = row_bytes(width);
        Self { bits: vec![0; row_bytes * height as usize], row_bytes }
    }

    fn get(&self, x: u32, y: u32) -> bool {
        get(&self.bits, self.row_bytes, x, y)
    }

    fn set(&mut self, x: u32, y: u32, value: bool) {
        if let Some(byte) = self.bits.get_mut(y as usize * self.row_bytes + x as usize / 8) {
            let bit = 1 << (x % 8);
            *byte = if value { *byte | bit } else { *byte & !bit };
        }
    }
}

/// Both masks; where elements overlap, a wall wins over glazing, whichever is drawn first.
struct Canvas {
    walls: Mask,
    windows: Mask,
}

impl Canvas {
    /// Paints the pixels whose centres `material` maps to something, within a box in metres.
    fn paint(
        &mut self,
        [west, south, east, north]: [f64; 4],
        material: impl Fn([f64; 2]) -> Option<Material>,
    ) {
        let (width, height) = SIZE_PX;
        for y in pixel(south).min(height)..=pixel(north).min(height - 1) {
            for x in pixel(west).min(width)..=pixel(east).min(width - 1) {
                match material([metres(x), metres(y)]) {
                    Some(Material::Wall) => {
                        self.walls.set(x, y, true);
                        self.windows.set(x, y, false);
                    }
                    Some(Material::Glass) if !self.walls.get(x, y) => self.windows.set(x, y, true),
                    Some(Material::Glass) | None => {}
                }
            }
        }
    }

    /// Paints a wall with its openings.
    fn wall(&mut self, wall: &Wall) {
        let ([ax, ay], [bx, by], half) = (wall.from, wall.to, wall.thickness / 2.0);
        // `sqrt` is exactly rounded on every platform, `hypot` is not.
        let length = ((bx - ax) * (bx - ax) + (by - ay) * (by - ay)).sqrt();
        let [dx, dy] = [(bx - ax) / length, (by - ay) / length];
        let bounds = [ax.min(bx) - half, ay.min(by) - half, ax.max(bx) + half, ay.max(by) + half];
        self.paint(bounds, |[x, y]| {
            let along = (x - ax) * dx + (y - ay) * dy;
            let across = ((y - ay) * dx - (x - ax) * dy).abs();
            if !(0.0..length).contains(&along) || across > half {
                return None;
            }
            let at = wall.origin + along;
            for opening in wall.openings {
                match *opening {
                    Door(start, end) if (start..end).contains(&at) => return None,
                    Glazing(start, end) if (start..end).contains(&at) => {
                        return (across <= GLASS / 2.0).then_some(Material::Glass);
                    }
                    Door(..) | Glazing(..) => {}
                }
            }
            Some(Material::Wall)
        });
    }

    /// Paints a solid rectangle `[west, south, east, north]`.
    fn rect(&mut self, bounds: [f64; 4]) {
        let [west, south, east, north] = bounds;
        self.paint(bounds, |[x, y]| {
            ((west..east).contains(&x) && (south..north).contains(&y)).then_some(Material::Wall)
        });
    }
}

/// Material of a pixel.
#[derive(Debug, Clone, Copy)]
enum Material {
    Wall,
    Glass,
}

/// The pixel at a building coordinate, rounded down; coordinates beyond the margin clamp to 0.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "float casts saturate, and the caller clamps to the image"
)]
fn pixel(metres: f64) -> u32 {
    ((metres + MARGIN_M) / RESOLUTION_M).floor() as u32
}

/// The building coordinate of a pixel's centre.
fn metres(pixel: u32) -> f64 {
    (f64::from(pixel) + 0.5) * RESOLUTION_M - MARGIN_M
}

#[cfg(test)]
mod tests {
    use super::*;
    use compass_core::base::raster::BitMask;

    fn demo_pixel() -> (u32, u32) {
        let ([x, y], _) = DEMO_POSE;
        (pixel(x - MARGIN_M), pixel(y - MARGIN_M))
    }

    fn views(plan: &SampleBuilding) -> (BitMask<'_>, BitMask<'_>) {
        (
            BitMask::new(&plan.walls, plan.width, plan.height).unwrap(),
            BitMask::new(&plan.windows, plan.width, plan.height).unwrap(),
        )
    }

    /// Pixels reached from `start` over free pixels, 4-connected.
    fn flood(plan: &SampleBuilding, start: (u32, u32)) -> Mask {
        let (walls, windows) = views(plan);
        let mut reached = Mask::new(plan.width, plan.height);
        let mut open = vec![start];
        while let Some((x, y)) = open.pop() {
            let outside = x >= plan.width || y >= plan.height;
            if outside || walls.get(x, y) || windows.get(x, y) || reached.get(x, y) {
                continue;
            }
            reached.set(x, y, true);
            open.extend([(x + 1, y), (x, y + 1)]);
            open.extend(x.checked_sub(1).map(|x| (x, y)));
            open.extend(y.checked_sub(1).map(|y| (x, y)));
        }
        reached
    }

    #[test]
    fn masks_are_disjoint_and_fit_their_view() {
        let plan = building();
        views(&plan);
        assert_eq!(plan.walls.len(), row_bytes(plan.width) * plan.height as usize);
        assert_eq!(plan.windows.len(), plan.walls.len());
        assert!(plan.walls.iter().zip(&plan.windows).all(|(a, b)| a & b == 0));
    }

    #[test]
    fn demo_pose_has_room_for_a_robot() {
        let plan = building();
        let (walls, windows) = views(&plan);
        let (x, y) = demo_pixel();
        for y in y - 40..y + 40 {
            for x in x - 40..x + 40 {
                assert!(!walls.get(x, y) && !windows.get(x, y), "({x}, {y})");
            }
        }
    }

    #[test]
    fn facade_is_closed_and_rooms_are_connected() {
        let plan = building();
        let (x, y) = demo_pixel();
        let outside = flood(&plan, (0, 0));
        assert!(!outside.get(x, y));
        let inside = flood(&plan, (x, y));
        // Every room by a point in it: S1..S7, W1..W3, N1..N5, meeting room, archive, stairs,
        // lifts, store and washrooms.
        for [x, y] in [
            [3.0, 3.0],
            [8.0, 3.0],
            [16.0, 3.0],
            [20.0, 3.0],
            [23.0, 3.0],
            [28.0, 3.0],
            [3.0, 7.0],
            [3.0, 10.0],
            [3.0, 13.0],
            [3.0, 17.0],
            [8.0, 17.0],
            [12.0, 17.0],
            [16.0, 17.0],
            [19.0, 17.0],
            [25.0, 11.0],
            [21.0, 9.0],
            [9.0, 9.0],
            [11.5, 10.5],
            [13.5, 10.5],
            [13.5, 8.5],
            [16.5, 8.5],
            [15.5, 11.5],
        ] {
            assert!(inside.get(pixel(x), pixel(y)), "({x}, {y}) is not reached");
        }
        assert!(!inside.get(pixel(11.5), pixel(8.5)), "the shaft is closed");
        assert!(!outside.get(pixel(11.5), pixel(8.5)), "the shaft is closed");
    }

    #[test]
    fn alike_rooms_differ_only_in_their_windows() {
        let plan = building();
        let (walls, windows) = views(&plan);
        let offset = pixel(10.465) - pixel(6.865);
        let mut glass = [0_u32; 2];
        for x in pixel(6.865)..pixel(10.345) {
            for y in pixel(0.405)..pixel(7.305) {
                assert_eq!(walls.get(x, y), walls.get(x + offset, y), "({x}, {y})");
            }
            glass[0] += u32::from(windows.get(x, pixel(0.2)));
            glass[1] += u32::from(windows.get(x + offset, pixel(0.2)));
        }
        assert_eq!(glass, [240, 260]);
    }

    #[test]
    fn image_is_north_up_in_three_colours() {
        let plan = building();
        let picture = image(&plan);
        assert_eq!(picture.dimensions(), SIZE_PX);
        let at = |x, y| picture.get_pixel(pixel(x), plan.height - 1 - pixel(y)).0;
        assert_eq!(at(11.0, 0.2), [255, 0, 0], "glazing of S3");
        assert_eq!(at(0.1, 0.1), [0, 0, 0], "south-west corner");
        assert_eq!(at(29.5, 19.5), [255, 255, 255], "the slanted corner is cut off");
        if let Some(path) = std::env::var_os("COMPASS_SAMPLE_PNG") {
            picture.save(path).unwrap();
        }
    }

    #[test]
    fn drawing_is_deterministic() {
        let plan = building();
        // FNV-1a, 64 bits.
        let sum = plan.walls.iter().chain(&plan.windows).fold(0xcbf2_9ce4_8422_2325_u64, |sum, &byte| {
            (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        assert_eq!(sum, 0x742f_6172_e199_d21c, "the drawing changed: {sum:#018x}");
    }
}
