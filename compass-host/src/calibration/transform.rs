//! Rigid transforms as calibrations write them.

use super::error::Refusal;
use super::node::Node;
use nalgebra::{Matrix3, Matrix4, Quaternion, UnitQuaternion, Vector3};

/// Largest deviation of a rotation in the file from orthonormal: allows for values rounded to three decimals.
const ORTHONORMAL: f64 = 2e-3;

/// Largest deviation of a quaternion's length from 1: allows for values rounded to two decimals.
const UNIT: f64 = 0.02;

/// The rotation of a transform.
pub(super) fn rotation(t: &Matrix4<f64>) -> Matrix3<f64> {
    t.fixed_view::<3, 3>(0, 0).into_owned()
}

/// The translation of a transform.
pub(super) fn translation(t: &Matrix4<f64>) -> Vector3<f64> {
    t.fixed_view::<3, 1>(0, 3).into_owned()
}

fn rigid(rotation: &Matrix3<f64>, translation: &Vector3<f64>) -> Matrix4<f64> {
    let mut t = rotation.to_homogeneous();
    t.fixed_view_mut::<3, 1>(0, 3).copy_from(translation);
    t
}

/// The transform the other way round.
pub(super) fn inverse(t: &Matrix4<f64>) -> Matrix4<f64> {
    let back = rotation(t).transpose();
    rigid(&back, &-(back * translation(t)))
}

/// A transform from four rows of four in the field `name`; its rotation is made exactly orthonormal.
pub(super) fn from_rows(name: &str, node: &Node) -> Result<Matrix4<f64>, Refusal> {
    let wrong = |problem: String| Refusal::new(name, problem);
    let rows = node.rows_of_4().filter(|rows| rows.len() == 4 && rows.iter().all(|row| row.len() == 4));
    let rows = rows.ok_or_else(|| wrong("is no matrix of four rows of four numbers".to_owned()))?;
    if let Some(row) = rows.iter().find(|row| row.iter().any(|value| !value.is_finite())) {
        return Err(wrong(format!("is {row:?}; finite numbers are needed")));
    }
    let t = Matrix4::from_fn(|row, column| rows[row][column]);
    if rows[3] != [0.0, 0.0, 0.0, 1.0] {
        return Err(wrong(format!("last row is {:?}; [0, 0, 0, 1] is needed", rows[3])));
    }
    let turn = rotation(&t);
    let off = (turn * turn.transpose() - Matrix3::identity()).amax();
    if off > ORTHONORMAL {
        return Err(wrong(format!("is no rotation: its rows are off orthonormal by {off:.4}")));
    }
    if turn.determinant() < 0.0 {
        return Err(wrong("is no rotation: it mirrors".to_owned()));
    }
    Ok(rigid(&orthonormal(&turn), &translation(&t)))
}

/// A transform from px, py, pz, qx, qy, qz and qw in the field `name`.
pub(super) fn from_quaternion(name: &str, node: &Node) -> Result<Matrix4<f64>, Refusal> {
    let part = |key: &str| {
        let number = node.get(key).and_then(Node::number).filter(|number| number.is_finite());
        number.ok_or_else(|| Refusal::new(format!("{name}.{key}"), "is missing or no finite number"))
    };
    let quaternion = Quaternion::new(part("qw")?, part("qx")?, part("qy")?, part("qz")?);
    if (quaternion.norm() - 1.0).abs() > UNIT {
        return Err(Refusal::new(
            name,
            format!("quaternion has length {:.3} instead of 1", quaternion.norm()),
        ));
    }
    let rotation = UnitQuaternion::from_quaternion(quaternion).to_rotation_matrix().into_inner();
    Ok(rigid(&rotation, &Vector3::new(part("px")?, part("py")?, part("pz")?)))
}

/// The closest rotation, by Newton's iteration for the polar decomposition, from one already near.
fn orthonormal(near: &Matrix3<f64>) -> Matrix3<f64> {
    (0..4).fold(*near, |r, _| 1.5 * r - 0.5 * r * r.transpose() * r)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_decimals_make_a_rotation() {
        let rounded = Matrix3::new(0.766, -0.643, 0.0, 0.643, 0.766, 0.0, 0.0, 0.0, 1.0);
        let exact = orthonormal(&rounded);
        assert!((exact * exact.transpose() - Matrix3::identity()).amax() < 1e-14);
        assert!((exact - rounded).amax() < 1e-3);
    }
}
