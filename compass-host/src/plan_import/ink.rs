//! What the colour of a pixel means: paper, wall, glazing or a door.

pub(super) const FREE: u8 = 0;
pub(super) const WALL: u8 = 1;
pub(super) const DOUBTFUL_WALL: u8 = 2;
pub(super) const WINDOW: u8 = 3;
pub(super) const FAINT_DARK: u8 = 4;
pub(super) const FAINT_LIGHT: u8 = 5;

/// How gray levels become levels of dark ink on light paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tone {
    /// They are: dark is occupied.
    Positive,
    /// Light is occupied.
    Negative,
    /// Occupancy in percent, as `map_server` saves it in mode raw: occupied from here to 100, unknown above.
    Raw {
        /// The lowest occupied percentage.
        from: u8,
    },
}

/// Thresholds and colours.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ink {
    /// How gray levels are read.
    pub tone: Tone,
    /// Whether gray is the mean of the channels, as to `map_server`, in place of their luma.
    pub mean: bool,
    /// The lowest level that is not dark, 0..=256, of dark ink on light paper.
    pub dark_below: u16,
    /// The least redness of glazing, where no colour of it is named.
    pub red_excess: u8,
    /// The colour of glazing.
    pub glazing: Option<[u8; 3]>,
    /// The colour of doors, which are free.
    pub door: Option<[u8; 3]>,
}

impl Ink {
    /// The level of a gray pixel.
    pub(super) fn level(&self, gray: u8) -> u8 {
        match self.tone {
            Tone::Positive => gray,
            Tone::Negative => 255 - gray,
            Tone::Raw { from } if (from..=100).contains(&gray) => 0,
            Tone::Raw { .. } => 255,
        }
    }

    /// The level of a colour pixel.
    pub(super) fn level_of(&self, rgb: [u8; 3]) -> u8 {
        self.level(if self.mean { mean_of(rgb) } else { luma_of(rgb) })
    }

    /// Whether a level is dark.
    pub(super) fn is_dark(&self, level: u8) -> bool {
        u16::from(level) < self.dark_below
    }

    /// First pass for a colour pixel.
    pub(super) fn judge(&self, rgb: [u8; 3]) -> u8 {
        if self.door.is_some_and(|door| self.share_of(door, rgb).is_some()) {
            return FREE;
        }
        let level = self.level_of(rgb);
        let dark = self.is_dark(level);
        match (self.glazing_at(rgb), dark) {
            (Some(true), _) => return WINDOW,
            (Some(false), true) => return FAINT_DARK,
            (Some(false), false) => return FAINT_LIGHT,
            (None, _) => {}
        }
        let plain = 4 * u16::from(level) < 3 * self.dark_below && redness(rgb) <= self.red_excess / 4;
        match (dark, plain) {
            (false, _) => FREE,
            (true, true) => WALL,
            (true, false) => DOUBTFUL_WALL,
        }
    }

    /// Whether a pixel has a colour that means glazing or a door.
    pub(super) fn is_named(&self, rgb: [u8; 3]) -> bool {
        self.glazing_at(rgb).is_some() || self.door.is_some_and(|door| self.share_of(door, rgb).is_some())
    }

    /// Whether a pixel is glazing, and then whether it is so beyond doubt.
    fn glazing_at(&self, rgb: [u8; 3]) -> Option<bool> {
        if let Some(colour) = self.glazing {
            return self.share_of(colour, rgb).map(|share| share >= FULL_SHARE);
        }
        let (redness, least) = (u16::from(redness(rgb)), u16::from(self.red_excess));
        (redness > 0 && redness >= least).then_some(redness >= 2 * least)
    }

    /// Percentage of a colour in a pixel that it shares with the paper, as on the rim of a smoothed line: `None` below
    /// half, and for any other colour.
    fn share_of(&self, colour: [u8; 3], rgb: [u8; 3]) -> Option<i32> {
        let paper = if self.tone == Tone::Negative { 0 } else { 255 };
        let from_paper = |rgb: [u8; 3]| rgb.map(|value| i32::from(value) - paper);
        let dot = |a: [i32; 3], b: [i32; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<i32>();
        let (full, seen) = (from_paper(colour), from_paper(rgb));
        let share = 100 * dot(seen, full) / dot(full, full).max(1);
        let off: [i32; 3] = std::array::from_fn(|c| seen[c] - full[c] * share / 100);
        let near = dot(off, off) <= MOST_COLOUR_ERROR * MOST_COLOUR_ERROR;
        ((50..=125).contains(&share) && near).then_some(share)
    }
}

/// Percentage of a named colour from which a pixel is that beyond doubt.
const FULL_SHARE: i32 = 75;

/// Levels that a pixel may lie beside the mixtures of paper and a named colour.
const MOST_COLOUR_ERROR: i32 = 60;

/// R less the larger of G and B.
pub(super) fn redness([r, g, b]: [u8; 3]) -> u8 {
    r.saturating_sub(g.max(b))
}

fn mean_of(rgb: [u8; 3]) -> u8 {
    let sum: u32 = rgb.map(u32::from).iter().sum();
    ((sum + 1) / 3) as u8
}

/// BT.601 luma in 16-bit fixed point, rounded to nearest; the weights sum to 65536.
fn luma_of([r, g, b]: [u8; 3]) -> u8 {
    let sum = 19_595 * u32::from(r) + 38_470 * u32::from(g) + 7_471 * u32::from(b) + 32_768;
    sum.to_le_bytes()[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    const INK: Ink =
        Ink { tone: Tone::Positive, mean: false, dark_below: 128, red_excess: 60, glazing: None, door: None };

    #[test]
    fn judges_single_colours() {
        assert_eq!(INK.judge([255, 255, 255]), FREE);
        assert_eq!(INK.judge([0, 0, 0]), WALL);
        assert_eq!(INK.judge([255, 0, 0]), WINDOW);
        assert_eq!(INK.judge([255, 180, 180]), FAINT_LIGHT, "pink rim");
        assert_eq!(INK.judge([90, 0, 0]), FAINT_DARK, "chroma bled into black");
        assert_eq!(INK.judge([120, 120, 120]), DOUBTFUL_WALL);
        assert_eq!(INK.judge([128, 128, 128]), FREE);
        assert_eq!(INK.judge([0, 0, 255]), WALL, "blue ink is dark");
        let negated = Ink { tone: Tone::Negative, ..INK };
        assert_eq!((negated.judge([255; 3]), negated.judge([0; 3])), (WALL, FREE));
        let any = Ink { red_excess: 0, ..INK };
        assert_eq!((any.judge([0; 3]), any.judge([255; 3])), (WALL, FREE), "gray is never red");
    }

    #[test]
    fn named_colours_are_glazing_and_doors() {
        let ink = Ink { glazing: Some([0, 0, 255]), door: Some([255, 0, 0]), ..INK };
        assert_eq!(ink.judge([0, 0, 255]), WINDOW);
        assert_eq!(ink.judge([20, 30, 240]), WINDOW, "compressed");
        assert_eq!(ink.judge([100, 100, 255]), FAINT_DARK, "the smoothed rim of a line");
        assert_eq!(ink.judge([200, 200, 255]), FREE, "paler than half");
        assert_eq!((ink.judge([0; 3]), ink.judge([255; 3])), (WALL, FREE));
        assert_eq!(ink.judge([255, 0, 0]), FREE, "a door");
        assert_eq!(ink.judge([255, 100, 100]), FREE);
        let gray = Ink { glazing: Some([128; 3]), ..INK };
        assert_eq!((gray.judge([128; 3]), gray.judge([0; 3])), (WINDOW, WALL));
        let on_black = Ink { tone: Tone::Negative, glazing: Some([0, 255, 255]), ..INK };
        assert_eq!((on_black.judge([0, 250, 240]), on_black.judge([255; 3])), (WINDOW, WALL));
    }

    #[test]
    fn gray_is_luma_or_the_mean_of_the_channels() {
        assert_eq!((luma_of([0; 3]), luma_of([255; 3]), luma_of([255, 0, 0])), (0, 255, 76));
        assert!((0..=255).all(|v| luma_of([v; 3]) == v && mean_of([v; 3]) == v));
        assert_eq!(Ink { mean: true, ..INK }.level_of([0, 200, 0]), 67);
    }

    #[test]
    fn raw_is_occupied_up_to_a_hundred_percent() {
        let raw = Ink { tone: Tone::Raw { from: 66 }, ..INK };
        assert_eq!(
            [0, 65, 66, 100, 101, 255].map(|v| raw.is_dark(raw.level(v))),
            [false, false, true, true, false, false]
        );
    }
}
