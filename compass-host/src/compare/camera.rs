//! Lenses: the core's `f32` against the reference, over the whole image circle.

use super::Stage;
use crate::reference::camera::Camera as Reference;
use compass_core::vision::camera::{
    BEARING_ERROR, Bearing, Camera, DoubleSphere, Eucm, Intrinsics, KannalaBrandt, Omni, PROJECTION_ERROR_PX,
    Pixel, ROUND_TRIP_PX, Radtan,
};

/// Sampled radii of the image circle; not a divisor of anything.
const RINGS: u32 = 397;

/// Sampled directions at each radius.
const DIRECTIONS: u32 = 73;

/// Share of the field in which bearings are compared; see [`BEARING_ERROR`].
const BEARING_SHARE: f64 = 0.98;

/// Differences over the image circles of some lenses of one model.
#[derive(Debug, Default)]
struct Differences {
    projection_px: Vec<f64>,
    bearing: Vec<f64>,
    round_trip_px: Vec<f64>,
}

/// An invented lens of each model of a calibration, with a typical size and field: 200 degrees on 1440 pixels.
///
/// # Panics
/// Never: the parameters are valid.
#[must_use]
pub fn nominal() -> Vec<Camera> {
    let intrinsics = Intrinsics { fx: 431.5, fy: 430.25, cx: 727.25, cy: 716.5 };
    let polynomial = KannalaBrandt::new(intrinsics, [0.03, -0.012, -0.001, 0.0001]);
    let unified = Eucm::new(intrinsics, 0.66, 0.92);
    let spheres = DoubleSphere::new(intrinsics, -0.19, 0.59);
    let wide = Intrinsics { fx: 1035.5, fy: 1032.75, ..intrinsics };
    let distortion = Radtan { k1: -0.02, k2: 0.003, p1: 4e-4, p2: -7e-4, k3: 0.0 };
    vec![
        Camera::KannalaBrandt(polynomial.expect("nominal polynomial lens")),
        Camera::Eucm(unified.expect("nominal unified lens")),
        Camera::DoubleSphere(spheres.expect("nominal double sphere")),
        Camera::Omni(Omni::new(wide, 1.4, distortion).expect("nominal omnidirectional lens")),
    ]
}

/// Projection, bearing and round trip for each model present in `lenses`.
#[must_use]
pub fn stages(lenses: &[Camera]) -> Vec<Stage> {
    let names = [
        [
            "camera: projection, Kannala-Brandt",
            "camera: bearing, Kannala-Brandt",
            "camera: round trip, Kannala-Brandt",
        ],
        ["camera: projection, EUCM", "camera: bearing, EUCM", "camera: round trip, EUCM"],
        [
            "camera: projection, double sphere",
            "camera: bearing, double sphere",
            "camera: round trip, double sphere",
        ],
        [
            "camera: projection, omni-radtan",
            "camera: bearing, omni-radtan",
            "camera: round trip, omni-radtan",
        ],
        [
            "camera: projection, equidistant",
            "camera: bearing, equidistant",
            "camera: round trip, equidistant",
        ],
    ];
    let model = |lens: &Camera| match lens {
        Camera::KannalaBrandt(_) => 0,
        Camera::Eucm(_) => 1,
        Camera::DoubleSphere(_) => 2,
        Camera::Omni(_) => 3,
        Camera::Equidistant(_) => 4,
    };
    let of_model = |(number, names): (usize, [&'static str; 3])| {
        let mut found = Differences::default();
        lenses.iter().filter(|lens| model(lens) == number).for_each(|lens| found.add(lens));
        if found.projection_px.is_empty() { vec![] } else { found.stages(names) }
    };
    names.into_iter().enumerate().flat_map(of_model).collect()
}

impl Differences {
    fn add(&mut self, lens: &Camera) {
        let reference = Reference::from(lens);
        let limit = f64::from(lens.max_angle());
        for ring in 0..RINGS {
            let theta = limit * f64::from(ring) / f64::from(RINGS - 1);
            for direction in 0..DIRECTIONS {
                let azimuth = std::f64::consts::TAU * f64::from(direction) / f64::from(DIRECTIONS);
                self.add_ray(lens, &reference, theta, azimuth);
            }
        }
    }

    /// A rejection by the core counts as an infinite difference, except on the rim, where rounding decides.
    fn add_ray(&mut self, lens: &Camera, reference: &Reference, theta: f64, azimuth: f64) {
        let limit = f64::from(lens.max_angle());
        let bearing =
            [theta.sin() * azimuth.cos(), theta.sin() * azimuth.sin(), theta.cos()].map(|v| v as f32);
        let Some(exact) = reference.project(bearing.map(f64::from)) else { return };
        let refused = if theta < limit { f64::INFINITY } else { 0.0 };
        let found = lens.project(&Bearing::from(bearing));
        self.projection_px.push(found.map_or(refused, |found| distance(found, exact)));

        let pixel = Pixel { x: exact[0] as f32, y: exact[1] as f32 };
        let back = lens.unproject(pixel);
        let again = back.and_then(|back| lens.project(&back));
        let start = [f64::from(pixel.x), f64::from(pixel.y)];
        self.round_trip_px.push(again.map_or(refused, |again| distance(again, start)));
        if theta <= BEARING_SHARE * limit
            && let Some(exact) = reference.unproject(start, limit)
        {
            self.bearing.push(back.map_or(refused, |back| between(&back, exact)));
        }
    }

    fn stages(self, names: [&'static str; 3]) -> Vec<Stage> {
        vec![
            Stage::at_most(names[0], "px", self.projection_px, f64::from(PROJECTION_ERROR_PX)),
            Stage::at_most(names[1], "rad", self.bearing, f64::from(BEARING_ERROR)),
            Stage::at_most(names[2], "px", self.round_trip_px, f64::from(ROUND_TRIP_PX)),
        ]
    }
}

fn distance(found: Pixel, exact: [f64; 2]) -> f64 {
    (f64::from(found.x) - exact[0]).hypot(f64::from(found.y) - exact[1])
}

/// The angle between two bearings in radians, avoiding the cosine, which cannot resolve small angles.
fn between(found: &Bearing, exact: [f64; 3]) -> f64 {
    let chord: f64 = (0..3).map(|i| (f64::from(found[i]) - exact[i]).powi(2)).sum();
    2.0 * (0.5 * chord.sqrt()).asin()
}

#[cfg(test)]
mod tests {
    use super::*;
    use compass_core::vision::camera::Equidistant;
    use proptest::prelude::*;

    #[test]
    fn nominal_lenses_are_in_bounds() {
        let stages = stages(&nominal());
        assert_eq!(stages.len(), 12);
        for stage in stages {
            println!("{stage:?}");
            assert!(stage.in_bounds && stage.compared > 20_000, "{stage:?}");
        }
        assert!(super::stages(&[]).is_empty());
    }

    fn any_lens() -> impl Strategy<Value = Camera> {
        let intrinsics = || {
            (100.0_f32..1000.0, 0.95_f32..1.05, 0.0_f32..2000.0, 0.0_f32..2000.0)
                .prop_map(|(fx, aspect, cx, cy)| Intrinsics { fx, fy: fx * aspect, cx, cy })
        };
        let k = [-0.3_f32..0.3, -0.1..0.1, -0.05..0.05, -0.01..0.01];
        prop_oneof![
            (intrinsics(), k).prop_filter_map("field", |(i, k)| Some(Camera::KannalaBrandt(
                KannalaBrandt::new(i, k).ok()?
            ))),
            (intrinsics(), 0.0_f32..=1.0, 0.1_f32..4.0)
                .prop_filter_map("field", |(i, a, b)| Some(Camera::Eucm(Eucm::new(i, a, b).ok()?))),
            (intrinsics(), -0.5_f32..0.8, 0.0_f32..=1.0).prop_filter_map("field", |(i, xi, a)| Some(
                Camera::DoubleSphere(DoubleSphere::new(i, xi, a).ok()?)
            )),
            (intrinsics(), 0.0_f32..3.0, [-0.3_f32..0.3, -0.1..0.1, -0.005..0.005, -0.005..0.005])
                .prop_filter_map("field", |(i, xi, [k1, k2, p1, p2])| {
                    let distortion = Radtan { k1, k2, p1, p2, k3: 0.0 };
                    Some(Camera::Omni(Omni::new(i, xi, distortion).ok()?))
                }),
            intrinsics().prop_map(|i| Camera::Equidistant(Equidistant::new(i).unwrap())),
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(500))]

        /// The bounds hold for unrealistic lenses as well, on the pixels of a large image.
        #[test]
        fn any_lens_is_in_bounds(lens in any_lens()) {
            let reference = Reference::from(&lens);
            let limit = f64::from(lens.max_angle());
            let mut found = Differences::default();
            for step in 0..200_u32 {
                let theta = limit * f64::from(step) / 199.0;
                let azimuth = f64::from(step) * 2.4;
                let bearing = [theta.sin() * azimuth.cos(), theta.sin() * azimuth.sin(), theta.cos()];
                let Some(pixel) = reference.project(bearing) else { continue };
                if pixel.iter().all(|side| (0.0..4096.0).contains(side)) {
                    found.add_ray(&lens, &reference, theta, azimuth);
                }
            }
            for stage in found.stages(["projection", "bearing", "round trip"]) {
                prop_assert!(stage.in_bounds, "{stage:?}");
            }
        }
    }
}
