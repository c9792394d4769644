//! Drawing of the panorama: gray levels of both cameras by azimuth and elevation in the level frame.
//!
//! Cells are stored column by column, so that the cells of a column between two rows are contiguous. Columns run clockwise
//! from azimuth 180 degrees at the left border of the first, rows downwards.

use crate::base::num::count_as_i32;
use crate::base::raster::GrayImage;
use crate::vision::panorama::{Resolution, TOP_DEG};
use crate::vision::projector::{CameraView, Node, Projector};
use crate::vision::sample::{ExclusionMask, around, between};

/// Stride of the projection grid in cells, 2 or 4 degrees; positions between its nodes are interpolated.
const SIDE: usize = 8;
/// Largest number of rows of the grid, both borders included.
const GRID_ROWS: usize = Resolution::FINE.rows().div_ceil(SIDE) + 1;

/// Draws one camera's image into the panorama: gray levels 1 to 255, 0 where excluded. Leaves the cells of the other camera
/// unchanged: a cell belongs to the camera whose axis is nearest.
#[inline(always)]
pub(super) fn draw(cells: &mut [u8], resolution: Resolution, seen: &CameraView<'_>) {
    let Some(projector) = Projector::new(seen) else { return };
    let grid = count_as_i32(SIDE) / resolution.per_degree_i32();
    let angle = |from: i32, node: usize| {
        libm::sincosf((from - count_as_i32(node) * grid) as f32 * (core::f32::consts::PI / 180.0))
    };
    let elevations: [_; GRID_ROWS] = core::array::from_fn(|row| angle(TOP_DEG, row));
    let rows = resolution.rows().div_ceil(SIDE);
    let nodes = |column: usize| {
        let azimuth = angle(180, column);
        let mut nodes = [Node::default(); GRID_ROWS];
        for (node, elevation) in nodes.iter_mut().zip(elevations).take(rows + 1) {
            *node = projector.node(azimuth, elevation);
        }
        nodes
    };
    let mut left = nodes(0);
    for column in 0..resolution.columns() / SIDE {
        let right = nodes(column + 1);
        let pairs = left.windows(2).zip(right.windows(2)).take(rows).enumerate();
        for (row, (left, right)) in pairs {
            let (&[a, c], &[b, d]) = (left, right) else { continue };
            let corners = [a, b, c, d];
            if corners.iter().all(|n| n.usable) && corners.iter().any(|n| n.lead > 0) {
                draw_patch(cells, resolution, (column, row), &corners, seen.image, seen.excluded);
            }
        }
        left = right;
    }
}

/// Draws the `SIDE` x `SIDE` cells between four nodes: upper left, upper right, lower left, lower right.
///
/// Arrays of one column: positions and levels are computed by vector instructions, only pixels are loaded one by one.
#[inline(always)]
#[expect(clippy::indexing_slicing, reason = "u and v are below `SIDE`, the length of the arrays")]
fn draw_patch(
    cells: &mut [u8],
    resolution: Resolution,
    (column, row): (usize, usize),
    [a, b, c, d]: &[Node; 4],
    image: &GrayImage<'_>,
    excluded: ExclusionMask<'_>,
) {
    // Cell centres lie at odd multiples of half a cell, so that weights sum to `2 SIDE`, a power of two.
    let bits = SIDE.trailing_zeros() + 1;
    let twice = 2 * count_as_i32(SIDE);
    let top = row * SIDE;
    let height = SIDE.min(resolution.rows().saturating_sub(top));
    // Exclusion is tested at every other cell of every other column and applies to its 2 x 2 cells.
    let mut hidden = [false; SIDE];
    for u in 0..SIDE {
        let wx = 2 * count_as_i32(u) + 1;
        let blend = |left: i32, right: i32| left * (twice - wx) + right * wx;
        let down = |upper: i32, lower: i32| {
            let mut places = [0; SIDE];
            for (v, place) in places.iter_mut().enumerate() {
                let wy = 2 * count_as_i32(v) + 1;
                *place = (upper * (twice - wy) + lower * wy) >> (2 * bits);
            }
            places
        };
        let x = down(blend(a.x, b.x), blend(c.x, d.x));
        let y = down(blend(a.y, b.y), blend(c.y, d.y));
        let lead = down(blend(a.lead, b.lead), blend(c.lead, d.lead));
        let [mut upper_left, mut upper_right, mut lower_left, mut lower_right] = [[0; SIDE]; 4];
        let mut seen = [0; SIDE];
        for v in 0..height {
            if v % 2 == 0 && u % 2 == 0 {
                hidden[v] = excluded.at(x[v], y[v]);
            }
            if lead[v] > 0
                && !hidden[v & !1]
                && let Some(four) = around(image, x[v], y[v])
            {
                [upper_left[v], upper_right[v], lower_left[v], lower_right[v]] = four;
                seen[v] = u8::MAX;
            }
        }
        let mut levels = [0; SIDE];
        for (v, level) in levels.iter_mut().enumerate() {
            let four = [upper_left[v], upper_right[v], lower_left[v], lower_right[v]];
            *level = between(four, x[v], y[v]) & seen[v];
        }
        let start = (column * SIDE + u) * resolution.rows() + top;
        let cells = cells.get_mut(start..start + height).unwrap_or(&mut []);
        for ((cell, level), lead) in cells.iter_mut().zip(levels).zip(lead) {
            *cell = if lead > 0 { level } else { *cell };
        }
    }
}
