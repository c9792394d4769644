//! Pixels to walls and glazing.
//!
//! **First pass**, each pixel alone. Redness is `R - max(G, B)`, luma is that of BT.601.
//! - glazing: redness at least `red_excess`, *faint* when below twice that; or the named colour, *faint* when paler than 3/4
//!   of it
//! - a door, where its colour is named: free
//! - wall: luma below `dark_below`; *plain* when below 3/4 of that with redness below a quarter of
//!   `red_excess` (black or dark gray ink), else *doubtful*
//! - free: the rest
//!
//! In a pair, glazing is also what is dark in the plan and not dark in the walls image, faint when the two lumas
//! differ by less than [`FAINT_STEP`]; the walls image alone defines the walls, and all of them are plain.
//!
//! **Second pass**, for doubtful and faint pixels, by their eight neighbours. Smoothed edges and
//! JPEG's coarse chroma turn the rim of a red line dark and the rim of a black line reddish:
//! - a doubtful wall pixel that touches glazing, but no wall that is plain or away from glazing, is
//!   the rim of that glazing
//! - a faint glazing pixel that touches more wall than glazing, or at least three wall pixels and
//!   less glazing than the straight rim of a line does, is the rim of that wall: wall when dark,
//!   else free
//!
//! All pixels are judged by the first-pass class of their neighbours, so the order does not matter. Plain and full
//! pixels never change: clean drawings keep every pixel. Cost: one pass, and 3 x 3 or 5 x 5 pixels for each doubtful
//! or faint one; gray images need neither map nor second pass.

use super::ink::{DOUBTFUL_WALL, FAINT_DARK, FAINT_LIGHT, FREE, Ink, WALL, WINDOW};
use crate::image_file::{Pixels, Samples};

/// Luma difference between the two images of a pair from which glazing is certain.
const FAINT_STEP: u8 = 64;

/// Glazing neighbours of a pixel on the straight rim of glazing: three within, two along the rim.
const STRAIGHT_RIM: u32 = 5;

/// Walls and glazing in the layout of `BitMask`, south row first.
#[derive(Debug)]
pub(super) struct Masks {
    pub walls: Vec<u8>,
    pub windows: Vec<u8>,
}

impl Masks {
    /// How many pixels are wall.
    pub(super) fn wall_pixels(&self) -> u64 {
        self.walls.iter().map(|byte| u64::from(byte.count_ones())).sum()
    }
}

/// Walls and glazing of one image.
pub(super) fn one_image(plan: &Pixels, ink: &Ink) -> Masks {
    let width = plan.width as usize;
    match &plan.samples {
        Samples::Gray(gray) => {
            let walls = pack(gray, width, |v| ink.is_dark(ink.level(v)));
            Masks { windows: vec![0; walls.len()], walls }
        }
        Samples::Rgb(rgb) => {
            resolve_doubtful(&rgb.as_chunks::<3>().0.iter().map(|&p| ink.judge(p)).collect::<Vec<_>>(), width)
        }
    }
}

/// Walls from `walls`, and as glazing what `plan` has beyond them. Both have the same size.
pub(super) fn pair(plan: &Pixels, walls: &Pixels, ink: &Ink) -> Masks {
    let (plan_luma, walls_luma) = (levels(plan, ink), levels(walls, ink));
    let mut classes: Vec<u8> = plan_luma
        .iter()
        .zip(&walls_luma)
        .map(|(&p, &w)| match (ink.is_dark(w), ink.is_dark(p)) {
            (true, _) => WALL,
            (false, false) => FREE,
            (false, true) if w - p >= FAINT_STEP => WINDOW,
            (false, true) => FAINT_LIGHT,
        })
        .collect();
    if let Samples::Rgb(rgb) = &plan.samples {
        for (class, &pixel) in classes.iter_mut().zip(rgb.as_chunks::<3>().0) {
            *class = match (*class, ink.judge(pixel)) {
                (FREE | FAINT_LIGHT, WINDOW) => WINDOW,
                (FREE, FAINT_DARK | FAINT_LIGHT) => FAINT_LIGHT,
                (class, _) => class,
            };
        }
    }
    resolve_doubtful(&classes, plan.width as usize)
}

fn levels(pixels: &Pixels, ink: &Ink) -> Vec<u8> {
    match &pixels.samples {
        Samples::Gray(gray) => gray.iter().map(|&v| ink.level(v)).collect(),
        Samples::Rgb(rgb) => rgb.as_chunks::<3>().0.iter().map(|&p| ink.level_of(p)).collect(),
    }
}

/// Packs rows of `width` values, top row first, into a mask, bottom row first.
fn pack(values: &[u8], width: usize, set: impl Fn(u8) -> bool + Copy) -> Vec<u8> {
    let mut packed = Vec::with_capacity(width.div_ceil(8) * (values.len() / width));
    for row in values.rchunks_exact(width) {
        let (eights, rest) = row.as_chunks::<8>();
        let byte = |bits: &[u8]| bits.iter().rev().fold(0, |byte, &v| byte << 1 | u8::from(set(v)));
        packed.extend(eights.iter().map(|eight| byte(eight)));
        if !rest.is_empty() {
            packed.push(byte(rest));
        }
    }
    packed
}

/// Resolves doubtful and faint pixels by their neighbours and packs the two masks.
fn resolve_doubtful(classes: &[u8], width: usize) -> Masks {
    let walls = pack(classes, width, |class| matches!(class, WALL | DOUBTFUL_WALL));
    let windows = pack(classes, width, |class| matches!(class, WINDOW | FAINT_DARK | FAINT_LIGHT));
    let mut masks = Masks { walls, windows };
    let map = Classes { classes, width };
    let row_bytes = width.div_ceil(8);
    for (south, row) in classes.rchunks_exact(width).enumerate() {
        let north = classes.len() / width - 1 - south;
        for (x, &class) in row.iter().enumerate() {
            let Some(resolved) = map.resolve(class, x, north) else { continue };
            let (at, bit) = (south * row_bytes + x / 8, 1_u8 << (x % 8));
            masks.walls[at] &= !bit;
            masks.windows[at] &= !bit;
            match resolved {
                WALL => masks.walls[at] |= bit,
                WINDOW => masks.windows[at] |= bit,
                _ => {}
            }
        }
    }
    masks
}

/// The first-pass class of every pixel, top row first.
#[derive(Clone, Copy)]
struct Classes<'a> {
    classes: &'a [u8],
    width: usize,
}

impl Classes<'_> {
    /// The class of the pixel when its neighbours overrule the first pass.
    fn resolve(self, class: u8, x: usize, y: usize) -> Option<u8> {
        match class {
            DOUBTFUL_WALL => (self.touches_glazing(x, y) && !self.touches_sound_wall(x, y)).then_some(WINDOW),
            FAINT_DARK if self.is_wall_rim(x, y) => Some(WALL),
            FAINT_LIGHT if self.is_wall_rim(x, y) => Some(FREE),
            _ => None,
        }
    }

    fn touches_glazing(self, x: usize, y: usize) -> bool {
        self.around(x, y).any(|(class, ..)| is_glazing(class))
    }

    fn touches_sound_wall(self, x: usize, y: usize) -> bool {
        self.around(x, y)
            .any(|(class, x, y)| class == WALL || (class == DOUBTFUL_WALL && !self.touches_glazing(x, y)))
    }

    fn is_wall_rim(self, x: usize, y: usize) -> bool {
        let (mut walls, mut glazing) = (0, 0);
        for (class, ..) in self.around(x, y) {
            walls += u32::from(matches!(class, WALL | DOUBTFUL_WALL));
            glazing += u32::from(is_glazing(class));
        }
        walls > glazing || (walls >= 3 && glazing < STRAIGHT_RIM)
    }

    /// The neighbours of (x, y) inside the image, with their positions.
    fn around(self, x: usize, y: usize) -> impl Iterator<Item = (u8, usize, usize)> {
        let height = self.classes.len() / self.width;
        let rows = y.saturating_sub(1)..(y + 2).min(height);
        let columns = x.saturating_sub(1)..(x + 2).min(self.width);
        rows.flat_map(move |v| columns.clone().map(move |u| (u, v)))
            .filter(move |&at| at != (x, y))
            .map(move |(u, v)| (self.classes[v * self.width + u], u, v))
    }
}

fn is_glazing(class: u8) -> bool {
    matches!(class, WINDOW | FAINT_DARK | FAINT_LIGHT)
}

#[cfg(test)]
mod tests {
    use compass_core::base::raster::BitMask;

    use super::*;

    /// Resolves a drawing: `#` wall, `d` doubtful, `W` glazing, `f` faint dark, `l` faint light.
    fn resolved(drawing: &[&str]) -> Vec<String> {
        let width = drawing[0].len();
        let classes: Vec<u8> =
            drawing.concat().bytes().map(|c| ".#dWfl".find(char::from(c)).unwrap() as u8).collect();
        let masks = resolve_doubtful(&classes, width);
        let height = u32::try_from(drawing.len()).unwrap();
        let columns = u32::try_from(width).unwrap();
        let walls = BitMask::new(&masks.walls, columns, height).unwrap();
        let windows = BitMask::new(&masks.windows, columns, height).unwrap();
        let pixel = |x, y| match (walls.get(x, y), windows.get(x, y)) {
            (true, false) => '#',
            (false, true) => 'W',
            (false, false) => '.',
            (true, true) => 'X',
        };
        (0..height).rev().map(|y| (0..columns).map(|x| pixel(x, y)).collect()).collect()
    }

    #[test]
    fn dark_rim_of_glazing_joins_it() {
        let drawing = [
            ".............", //
            "##ddddddddd##",
            "##WWWWWWWWW##",
            "##WWWWWWWWW##",
            ".............",
        ];
        let wanted = [
            ".............", //
            "##dWWWWWWWd##",
            "##WWWWWWWWW##",
            "##WWWWWWWWW##",
            ".............",
        ];
        assert_eq!(resolved(&drawing), wanted.map(|row| row.replace('d', "#")));
    }

    #[test]
    fn clean_ink_is_never_changed() {
        let drawing = ["##W#WW#", "..W....", "#WW####", "#W#W#W#"];
        assert_eq!(resolved(&drawing), drawing);
    }

    #[test]
    fn reddish_rim_of_a_wall_is_dropped_or_joins_it() {
        let drawing = ["llllll", "######", "######", "ffffff", "......"];
        assert_eq!(resolved(&drawing), ["......", "######", "######", "######", "......"]);
    }

    #[test]
    fn faint_glazing_lives_in_the_open_and_beside_full_glazing() {
        let drawing = ["#lll#", ".....", "#lWl#", "....."];
        assert_eq!(resolved(&drawing), ["#WWW#", ".....", "#WWW#", "....."]);
    }

    #[test]
    fn packs_least_bit_first_and_bottom_row_first() {
        let values = [1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 1, 0];
        assert_eq!(pack(&values, 9, |v| v == 1), [0b1000_0010, 0, 1, 1]);
    }
}
