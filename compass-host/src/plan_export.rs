//! A plan as files for other programs: a pair of masks and a ROS map.

use crate::output::{OutputError, create_dir, write_file, write_png};
use crate::plan_import::PlanRaster;
use image::{Rgb, RgbImage};
use std::path::Path;

const WALL: Rgb<u8> = Rgb([0, 0, 0]);
const GLAZING: Rgb<u8> = Rgb([255, 0, 0]);
const FREE: Rgb<u8> = Rgb([255, 255, 255]);

/// Writes `walls.png` (walls black), `plan.png` (the same with glazing in red) and `map.yaml`, a ROS `map_server`
/// description of `plan.png` to which glazing is occupied, into a folder that is made where it is missing.
///
/// All three read back as this plan.
///
/// # Errors
/// [`OutputError`] names the file.
pub fn export(dir: &Path, plan: &PlanRaster) -> Result<(), OutputError> {
    create_dir(dir)?;
    let picture = |colour: &dyn Fn(u32, u32) -> Rgb<u8>| {
        // Row 0 of an image is its northernmost.
        RgbImage::from_fn(plan.width, plan.height, |x, y| colour(x, plan.height - 1 - y))
    };
    let wall = |x, y| if plan.is_wall(x, y) { WALL } else { FREE };
    write_png(&dir.join("walls.png"), &picture(&wall))?;
    let all = |x, y| if plan.is_window(x, y) { GLAZING } else { wall(x, y) };
    write_png(&dir.join("plan.png"), &picture(&all))?;
    let [x, y] = plan.origin;
    // Red is 0.667 occupied to map_server, the mean of its channels.
    let description = format!(
        "image: plan.png\nresolution: {}\norigin: [{x}, {y}, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
        plan.resolution_m
    );
    write_file(&dir.join("map.yaml"), description.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan_import::{PlanOptions, load};

    #[test]
    fn an_exported_plan_reads_back() {
        let mut plan = PlanRaster::empty(90, 70, 0.05, [-3.25, 7.5]);
        (5..80).for_each(|x| [5, 6, 60].into_iter().for_each(|y| plan.set_wall(x, y)));
        (10..40).for_each(|y| [5, 6].into_iter().for_each(|x| plan.set_window(x, y)));
        let dir = tempfile::tempdir().unwrap();
        export(dir.path(), &plan).unwrap();
        assert_eq!(load(&PlanOptions::new(dir.path().join("map.yaml"))).unwrap(), plan);
        let mut pair = PlanOptions::new(dir.path().join("plan.png"));
        pair.walls = Some(dir.path().join("walls.png"));
        (pair.resolution_m, pair.origin) = (Some(0.05), Some([-3.25, 7.5]));
        assert_eq!(load(&pair).unwrap(), plan);
    }
}
