//! Forward kinematics and the geometric Jacobian over any number type.

mod fk;
mod jacobian;

pub use fk::{Workspace, forward};
pub use jacobian::columns;

use nalgebra::{Matrix3, Matrix4, Vector3};

use crate::chain::Chain;
use crate::lanes::{axpy, sub};

/// Tool pose in the world at `q` (rad or m per entry), as a 4x4 matrix.
pub fn tool_pose(chain: &Chain, q: &[f64], workspace: &mut Workspace<f64>) -> Matrix4<f64> {
    forward(chain.compiled(), q, workspace);
    let tail = &chain.compiled().tail;
    let [x, y, z] = workspace.tool_axes(&tail.rotation);
    let rotation = Matrix3::from_columns(&[x, y, z].map(Vector3::from));
    let p = workspace.tool_point(tail.translation);
    let mut pose = Matrix4::identity();
    pose.fixed_view_mut::<3, 3>(0, 0).copy_from(&rotation);
    pose.fixed_view_mut::<3, 1>(0, 3).copy_from(&Vector3::from(p));
    pose
}

/// Geometric Jacobian at `q`, written as 6 rows of `dof` numbers: linear velocity of the
/// tool point, then angular velocity, both in the world frame.
pub fn tool_jacobian(chain: &Chain, q: &[f64], workspace: &mut Workspace<f64>, out: &mut [f64]) {
    let compiled = chain.compiled();
    forward(compiled, q, workspace);
    let p = workspace.tool_point(compiled.tail.translation);
    let dof = compiled.dof;
    out[..6 * dof].fill(0.0);
    columns(compiled, workspace, p, |variable, linear, angular| {
        for k in 0..3 {
            out[k * dof + variable] += linear[k];
            out[(k + 3) * dof + variable] += angular[k];
        }
    });
}

/// Numerical derivative of the tool pose, for tests: central differences of step `h`.
pub fn difference_jacobian(chain: &Chain, q: &[f64], h: f64) -> Vec<[f64; 6]> {
    let mut workspace = Workspace::new(chain.compiled());
    (0..q.len())
        .map(|i| {
            let mut moved = q.to_vec();
            moved[i] = q[i] + h;
            let ahead = tool_pose(chain, &moved, &mut workspace);
            moved[i] = q[i] - h;
            let behind = tool_pose(chain, &moved, &mut workspace);
            let scale = 0.5 / h;
            let d = ahead.fixed_view::<3, 3>(0, 0) * behind.fixed_view::<3, 3>(0, 0).transpose();
            let zero = [0.0; 3];
            let linear = sub(
                [ahead[(0, 3)], ahead[(1, 3)], ahead[(2, 3)]],
                [behind[(0, 3)], behind[(1, 3)], behind[(2, 3)]],
            );
            let linear = axpy(linear, scale, zero);
            let s = 0.5 * scale;
            [
                linear[0],
                linear[1],
                linear[2],
                s * (d[(2, 1)] - d[(1, 2)]),
                s * (d[(0, 2)] - d[(2, 0)]),
                s * (d[(1, 0)] - d[(0, 1)]),
            ]
        })
        .collect()
}
