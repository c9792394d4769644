//! The pictures of `docs/displays.md` match the output of `compass_core::draw` on two common displays.
//!
//! `REGENERATE=1 cargo test -p compass-tests --test displays` rewrites them.

use compass_core::base::confidence::Confidence;
use compass_core::base::num::{BINS, Metres, Point as Place, Score, Turn};
use compass_core::base::scan::{STEPS_PER_METRE, Scan};
use compass_core::descriptor::Descriptor;
use compass_core::descriptor::matching::Board;
use compass_core::descriptor::similarity::{Query, Similarity, Weights};
use compass_core::draw::{self, HitColors};
use compass_core::map::site::Site;
use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::framebuffer::{Framebuffer, buffer_size};
use embedded_graphics::geometry::{OriginDimensions as _, Point, Size};
use embedded_graphics::image::GetPixel;
use embedded_graphics::pixelcolor::raw::{LittleEndian, RawU1, RawU16};
use embedded_graphics::pixelcolor::{BinaryColor, Rgb565, Rgb888, RgbColor as _, WebColors as _};
use embedded_graphics::primitives::Rectangle;
use image::{Rgb, RgbImage};
use std::convert::Infallible;
use std::path::Path;

/// The robot's pose: the demo pose of the sample building.
const AT: Place = Place::new(Metres::lit("13.37"), Metres::lit("3.68"));
const HEADING: Turn = Turn::from_ratio(74, 360);
/// Range at the border of a drawn scan.
const FULL_SCALE: u16 = 5 * STEPS_PER_METRE;

type Monochrome =
    Framebuffer<BinaryColor, RawU1, LittleEndian, 128, 64, { buffer_size::<BinaryColor>(128, 64) }>;
type Colour = Framebuffer<Rgb565, RawU16, LittleEndian, 240, 240, { buffer_size::<Rgb565>(240, 240) }>;

/// The data of a robot there.
struct Known {
    scan: Scan,
    descriptor: Descriptor,
    /// The map's scan at the place found, rotated to the heading found.
    found: Scan,
    /// The score of that place, by heading.
    scores: [Score; BINS],
}

impl Known {
    fn new() -> Self {
        let file = |name: &str| {
            std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("vectors").join(name)).unwrap()
        };
        let bytes = file("sample.site");
        let site = Site::new(&bytes).unwrap();
        let floor = site.floor(0).unwrap();
        let (plan, map) = (floor.plan(0).unwrap(), *floor.map());
        let mut scan = Scan::OPEN;
        plan.scan(AT, HEADING, &mut scan).unwrap();
        let descriptor = Descriptor::from(&scan);
        let mut query = Query::EMPTY;
        query.set(&descriptor, &Confidence::CERTAIN, Weights::EQUAL, Similarity::Centred);
        let mut board = Board::new();
        board.load(&query);
        let mut scores_of = |candidate| *board.scores(&query, &map, candidate);
        let candidate =
            (0..map.len()).max_by_key(|candidate| scores_of(*candidate).into_iter().max()).unwrap();
        let scores = scores_of(candidate);
        let heading = (0..BINS).max_by_key(|heading| scores[*heading]).unwrap();
        let mut found = Scan::OPEN;
        let at = map.position(candidate).unwrap();
        plan.scan(at, Turn::from_ratio(heading as i64, BINS as u32), &mut found).unwrap();
        Self { scan, descriptor, found, scores }
    }
}

/// The colours of a display: of the observed scan, and of the map's.
#[derive(Clone, Copy)]
struct Palette<C> {
    seen: HitColors<C>,
    mapped: HitColors<C>,
    bars: C,
}

/// A rectangle of a display.
fn area(x: i32, y: i32, width: u32, height: u32) -> Rectangle {
    Rectangle::new(Point::new(x, y), Size::new(width, height))
}

/// The observed scan over the map's at the place found; beside or below that, the scores by heading.
fn matched<D: DrawTarget<Error = Infallible>>(
    display: &mut D,
    known: &Known,
    [scans, scores]: [Rectangle; 2],
    palette: &Palette<D::Color>,
) {
    let Ok(()) = draw::scan(display, scans, &known.found, FULL_SCALE, &palette.mapped);
    let Ok(()) = draw::scan(display, scans, &known.scan, FULL_SCALE, &palette.seen);
    let Ok(()) = draw::scores(display, scores, &known.scores, palette.bars);
}

/// A picture of a display, scaled by whole pixels.
fn picture<D: GetPixel>(display: &D, size: Size, scale: u32) -> RgbImage
where
    Rgb888: From<D::Color>,
{
    RgbImage::from_fn(size.width * scale, size.height * scale, |x, y| {
        let pixel = display.pixel(Point::new((x / scale) as i32, (y / scale) as i32)).unwrap();
        let color = Rgb888::from(pixel);
        Rgb([color.r(), color.g(), color.b()])
    })
}

fn compare(name: &str, picture: &RgbImage) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/displays").join(name);
    if std::env::var_os("REGENERATE").is_some() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        picture.save(&path).unwrap();
    }
    let committed = image::open(&path).map(image::DynamicImage::into_rgb8);
    assert!(
        committed.is_ok_and(|committed| committed == *picture),
        "{name} is not what the code draws: if that is meant, REGENERATE=1 cargo test -p compass-tests --test displays"
    );
}

#[test]
fn a_monochrome_display_of_128_by_64() {
    let known = Known::new();
    let on = HitColors { wall: BinaryColor::On, window: BinaryColor::On, open: BinaryColor::Off };
    let palette = Palette { seen: on, mapped: on, bars: BinaryColor::On };
    let show = |name: &str, draw: &dyn Fn(&mut Monochrome)| {
        let mut display = Monochrome::new();
        draw(&mut display);
        let size = display.size();
        compare(name, &picture(&display, size, 3));
    };
    show("monochrome_descriptor.png", &|display| {
        let Ok(()) = draw::descriptor(display, area(0, 0, 128, 64), &known.descriptor, BinaryColor::On);
    });
    show("monochrome_scan.png", &|display| {
        let Ok(()) = draw::scan(display, area(32, 0, 64, 64), &known.scan, FULL_SCALE, &palette.seen);
    });
    show("monochrome_match.png", &|display| {
        matched(display, &known, [area(0, 0, 64, 64), area(68, 0, 60, 64)], &palette);
    });
}

#[test]
fn a_colour_display_of_240_by_240() {
    let known = Known::new();
    let gray = Rgb565::CSS_DIM_GRAY;
    let palette = Palette {
        seen: HitColors { wall: Rgb565::WHITE, window: Rgb565::CSS_DEEP_SKY_BLUE, open: Rgb565::BLACK },
        mapped: HitColors { wall: gray, window: gray, open: Rgb565::BLACK },
        bars: Rgb565::CSS_ORANGE,
    };
    let show = |name: &str, draw: &dyn Fn(&mut Colour)| {
        let mut display = Colour::new();
        draw(&mut display);
        let size = display.size();
        compare(name, &picture(&display, size, 1));
    };
    show("colour_descriptor.png", &|display| {
        let Ok(()) = draw::descriptor(display, area(0, 0, 240, 240), &known.descriptor, palette.bars);
    });
    show("colour_scan.png", &|display| {
        let Ok(()) = draw::scan(display, area(0, 0, 240, 240), &known.scan, FULL_SCALE, &palette.seen);
    });
    show("colour_match.png", &|display| {
        matched(display, &known, [area(30, 0, 180, 180), area(0, 184, 240, 56)], &palette);
    });
}
