//! Forward kinematics and the geometric Jacobian over any number type.

mod batch;
mod fk;
mod jacobian;

pub use batch::{FRAME, frames_abreast, moving_frames, tool_jacobians, tool_poses};
pub(crate) use batch::{load_rows, run_rows, unload_rows};
pub use fk::{Frame, PerJoint, Workspace, forward, forward_frame};
pub use jacobian::columns;

use nalgebra::{Matrix3, Matrix4, Vector3};

use crate::chain::Chain;

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
