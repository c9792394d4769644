//! Separate drawings in one model space.

use crate::drawing::Shape;
use std::collections::BTreeMap;

/// Distance in metres from which lines belong to separate drawings, about.
const APART_M: f64 = 8.0;
/// Most cells along a side of the grid.
const MAX_CELLS: f64 = 2048.0;
/// A drawing with less than this share of the longest one's lines is left out.
const LEAST_SHARE: f64 = 0.05;

/// A group of lines apart from all others.
#[derive(Debug, Clone)]
pub(super) struct Cluster {
    /// Least and greatest x and y in metres.
    pub(super) extent: [[f64; 2]; 2],
    /// Length of all lines in metres.
    pub(super) length: f64,
    /// Indices of its shapes.
    pub(super) shapes: Vec<usize>,
}

/// The drawings among `shapes`, longest lines first, and how many too small ones were left out.
pub(super) fn of(shapes: &[&Shape]) -> (Vec<Cluster>, usize) {
    let mut clusters = split(shapes, &(0..shapes.len()).collect::<Vec<_>>());
    let mut left_out = 0;
    // A far-off speck makes the cells of the first round large: split again what is kept.
    for _ in 0..3 {
        let before = clusters.len();
        let longest = clusters.iter().map(|cluster| cluster.length).fold(0.0, f64::max);
        clusters.retain(|cluster| cluster.length >= LEAST_SHARE * longest);
        left_out += before - clusters.len();
        clusters = clusters.iter().flat_map(|cluster| split(shapes, &cluster.shapes)).collect();
    }
    clusters.sort_by(|a, b| b.length.total_cmp(&a.length));
    (clusters, left_out)
}

/// Splits the shapes of these indices where nothing connects them.
fn split(shapes: &[&Shape], indices: &[usize]) -> Vec<Cluster> {
    let all = extent(indices.iter().map(|&at| shapes[at].extent()));
    let side = (all[1][0] - all[0][0]).max(all[1][1] - all[0][1]);
    let cell = (side / MAX_CELLS).max(APART_M / 2.0);
    let place = |[x, y]: [f64; 2]| [((x - all[0][0]) / cell) as u32, ((y - all[0][1]) / cell) as u32];
    let mut label = BTreeMap::<[u32; 2], usize>::new();
    for &at in indices {
        for pair in shapes[at].contours.iter().flat_map(|contour| contour.windows(2)) {
            let steps =
                ((pair[1][0] - pair[0][0]).abs().max((pair[1][1] - pair[0][1]).abs()) / cell).ceil().max(1.0);
            for step in 0..=steps as u32 {
                let share = f64::from(step) / steps;
                let point = [0, 1].map(|axis| pair[0][axis] + share * (pair[1][axis] - pair[0][axis]));
                label.insert(place(point), usize::MAX);
            }
        }
    }
    let cells: Vec<[u32; 2]> = label.keys().copied().collect();
    let mut count = 0;
    for start in cells {
        if label[&start] == usize::MAX {
            spread(&mut label, start, count);
            count += 1;
        }
    }
    let mut parts: Vec<Vec<usize>> = vec![Vec::new(); count];
    for &at in indices {
        let first = shapes[at].contours.first().and_then(|contour| contour.first());
        if let Some(part) = first.and_then(|point| label.get(&place(*point))) {
            parts[*part].push(at);
        }
    }
    let cluster = |shapes_in: Vec<usize>| Cluster {
        extent: extent(shapes_in.iter().map(|&at| shapes[at].extent())),
        length: shapes_in.iter().map(|&at| shapes[at].length()).sum(),
        shapes: shapes_in,
    };
    parts.into_iter().filter(|part| !part.is_empty()).map(cluster).collect()
}

/// Labels the cells connected to `start` over a side or a corner.
fn spread(label: &mut BTreeMap<[u32; 2], usize>, start: [u32; 2], with: usize) {
    let mut stack = vec![start];
    label.insert(start, with);
    while let Some([x, y]) = stack.pop() {
        for next_y in y.saturating_sub(1)..=y + 1 {
            for next_x in x.saturating_sub(1)..=x + 1 {
                if let Some(old) = label.get_mut(&[next_x, next_y]).filter(|old| **old == usize::MAX) {
                    *old = with;
                    stack.push([next_x, next_y]);
                }
            }
        }
    }
}

/// The extent of several.
pub(super) fn extent(extents: impl Iterator<Item = [[f64; 2]; 2]>) -> [[f64; 2]; 2] {
    extents.fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[least, most], [low, high]| {
        [[least[0].min(low[0]), least[1].min(low[1])], [most[0].max(high[0]), most[1].max(high[1])]]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::Paint;

    fn room(x: f64, y: f64, side: f64) -> Shape {
        let corners = [[x, y], [x + side, y], [x + side, y + side], [x, y + side], [x, y]];
        Shape { layer: 0, paint: Paint::Stroke(0.0), contours: vec![corners.to_vec()] }
    }

    #[test]
    fn drawings_apart_are_told_and_specks_left_out() {
        let shapes = [
            room(0.0, 0.0, 20.0),
            room(19.0, 3.0, 9.0),
            room(60.0, 0.0, 15.0),
            room(90.0, 90.0, 0.5),
            room(4e6, 5e6, 1.0),
        ];
        let shapes: Vec<&Shape> = shapes.iter().collect();
        let (clusters, left_out) = of(&shapes);
        let extents: Vec<_> = clusters.iter().map(|cluster| cluster.extent).collect();
        assert_eq!(extents, [[[0.0, 0.0], [28.0, 20.0]], [[60.0, 0.0], [75.0, 15.0]]]);
        assert_eq!(
            clusters.iter().map(|cluster| cluster.shapes.clone()).collect::<Vec<_>>(),
            [vec![0, 1], vec![2]]
        );
        assert_eq!(left_out, 2);
    }
}
