//! The appearance of a building's surfaces.

use rand::{RngExt as _, SeedableRng as _};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A colour, linear: 1 is white at the exposure of the style.
pub(super) type Colour = [f32; 3];

/// The style: all random choices made once for a whole building. Lengths in metres.
#[derive(Debug, Clone)]
pub(super) struct Look {
    pub(super) seed: u32,
    pub(super) ceiling: f32,
    pub(super) wall: Colour,
    pub(super) plaster: Colour,
    /// Share of the wall faces that are plastered.
    pub(super) plastered: f32,
    pub(super) floor: Colour,
    pub(super) slab: Colour,
    /// Width and height of a formwork panel, and of the bays of floor and ceiling.
    pub(super) panel: [f32; 2],
    pub(super) floor_bay: [f32; 2],
    pub(super) slab_bay: [f32; 2],
    /// How dark joints are, 0 to 1.
    pub(super) joint: f32,
    pub(super) mottle: f32,
    pub(super) frame: Colour,
    pub(super) frame_width: f32,
    pub(super) mullions: f32,
    sills: [f32; 2],
    lintel_drop: [f32; 2],
    /// Brightness of the sky, and of the vegetation before it.
    pub(super) outside: f32,
    pub(super) green: Colour,
    /// Share of haze over what is outside.
    pub(super) haze: f32,
    /// A horizontal direction from which walls get more light.
    pub(super) sun: [f32; 2],
    /// Mean brightness that the exposure aims at, and noise.
    pub(super) exposure: f32,
    pub(super) noise: f32,
}

impl Look {
    pub(super) fn new(style: u64, ceiling_m: f64) -> Self {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(style ^ 0x5eed_0f5c_e7e5);
        let mut draw = |from: f32, to: f32| from + (to - from) * rng.random::<f32>();
        let gray = |value: f32, warm: f32| [value * (1.0 + warm), value, value * (1.0 - warm)];
        let dark_frame = draw(0.0, 1.0) < 0.5;
        let low_sills = draw(0.0, 1.0) < 0.5;
        let angle = draw(0.0, std::f32::consts::TAU);
        let bay = draw(2.4, 5.0);
        let slab = draw(2.5, 6.0);
        Self {
            seed: style as u32 ^ (style >> 32) as u32,
            ceiling: ceiling_m as f32,
            wall: gray(draw(0.33, 0.48), draw(-0.01, 0.04)),
            plaster: gray(draw(0.58, 0.72), draw(0.0, 0.03)),
            plastered: draw(0.15, 0.6),
            floor: gray(draw(0.22, 0.36), draw(0.0, 0.05)),
            slab: gray(draw(0.32, 0.48), draw(-0.01, 0.04)),
            panel: [draw(1.2, 2.7), draw(1.2, 2.75)],
            floor_bay: [bay, bay * draw(0.8, 1.3)],
            slab_bay: [slab, slab * draw(0.6, 1.4)],
            joint: draw(0.35, 0.75),
            mottle: draw(0.09, 0.2),
            frame: if dark_frame { gray(draw(0.02, 0.07), 0.0) } else { gray(draw(0.45, 0.7), 0.0) },
            frame_width: draw(0.05, 0.08),
            mullions: draw(0.9, 1.6),
            sills: if low_sills { [0.0, 0.15] } else { [0.0, 0.9] },
            lintel_drop: [draw(0.02, 0.1), draw(0.15, 0.45)],
            outside: draw(1.6, 4.0),
            green: [draw(0.14, 0.3), draw(0.34, 0.5), draw(0.08, 0.2)],
            haze: draw(0.0, 0.35),
            sun: [libm::cosf(angle), libm::sinf(angle)],
            exposure: draw(0.17, 0.27),
            noise: draw(0.8, 2.2),
        }
    }

    /// Height of a sill, by a number from 0 to 1.
    pub(super) fn sill(&self, at: f32) -> f32 {
        let sill = self.sills[0] + (self.sills[1] - self.sills[0]) * at;
        if sill < 0.05 { 0.0 } else { sill.min(self.ceiling * 0.4) }
    }

    /// Height of a lintel, by a number from 0 to 1.
    pub(super) fn lintel(&self, at: f32) -> f32 {
        let [least, most] = self.lintel_drop;
        (self.ceiling - least - (most - least) * at).max(self.ceiling * 0.6)
    }
}
