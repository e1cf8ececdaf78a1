//! Targets between those of a path.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion};

use crate::call::{Copies, Goals, Request};

/// A target a share of the way from one target of a request to another: on the straight line
/// between their points, turned about one axis between their orientations.
pub(super) fn between(request: &Request<'_>, from: usize, to: usize, share: f64) -> Copies {
    let point = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k| a[k] + share * (b[k] - a[k]));
    match request.goals() {
        Goals::Positions { points, direction } => {
            Copies::Points(vec![point(points[from], points[to])], direction)
        }
        Goals::Poses(poses) => {
            let (a, b) = (&poses[from], &poses[to]);
            let (from, to) = (turned(a), turned(b));
            let turn = from.try_slerp(&to, share, 1e-9).unwrap_or(to).to_rotation_matrix();
            let place = point([a[3], a[7], a[11]], [b[3], b[7], b[11]]);
            let mut pose = [0.0; 16];
            for i in 0..3 {
                for j in 0..3 {
                    pose[4 * i + j] = turn[(i, j)];
                }
                pose[4 * i + 3] = place[i];
            }
            pose[15] = 1.0;
            // Both ends are what they are, to the last bit.
            Copies::Poses(vec![if share >= 1.0 { *b } else { pose }])
        }
    }
}

/// The rotation of a pose. Half turns, between which no way is the shortest, take some way.
fn turned(m: &[f64; 16]) -> UnitQuaternion<f64> {
    let matrix = Matrix3::new(m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix))
}
