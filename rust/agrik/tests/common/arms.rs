//! Two arms from DH rows, as in the package's robot files, and targets they can reach.

use agrik::call::{Aim, Goals, Request, Starts, Tolerance};
use agrik::chain::{Chain, DhConvention, DhRow, JointKind};
use agrik::kinematics::{Workspace, tool_pose};
use agrik::task::Task;
use nalgebra::IsometryMatrix3;

/// Names that [`arm`] knows.
pub const ARMS: [&str; 2] = ["redundant7", "puma560"];

/// a (m), alpha (deg), d (m), lower and upper limit (deg) of each joint.
type Row = [f64; 5];

const REDUNDANT7: [Row; 7] = [
    [0.0, -90.0, 0.34, -170.0, 170.0],
    [0.0, 90.0, 0.0, -120.0, 120.0],
    [0.0, -90.0, 0.4, -170.0, 170.0],
    [0.0, 90.0, 0.0, -120.0, 120.0],
    [0.0, -90.0, 0.4, -170.0, 170.0],
    [0.0, 90.0, 0.0, -120.0, 120.0],
    [0.0, 0.0, 0.126, -175.0, 175.0],
];

const PUMA560: [Row; 6] = [
    [0.0, 90.0, 0.6718, -160.0, 160.0],
    [0.4318, 0.0, 0.0, -110.0, 110.0],
    [0.0203, -90.0, 0.15005, -135.0, 135.0],
    [0.0, 90.0, 0.4318, -266.0, 266.0],
    [0.0, -90.0, 0.0, -100.0, 100.0],
    [0.0, 0.0, 0.0, -266.0, 266.0],
];

/// The arm of a name; any name but "redundant7" gives the Puma.
pub fn arm(name: &str) -> Chain {
    let rows: &[Row] = if name == "redundant7" { &REDUNDANT7 } else { &PUMA560 };
    let joint = |(i, &[a, alpha, d, lower, upper]): (usize, &Row)| {
        let row = DhRow { a, alpha: alpha.to_radians(), d, theta: 0.0 };
        row.joint(
            DhConvention::Standard,
            format!("q{}", i + 1),
            JointKind::Revolute,
            lower.to_radians(),
            upper.to_radians(),
        )
    };
    let joints = rows.iter().enumerate().map(joint).collect();
    let here = IsometryMatrix3::identity();
    Chain::new(name, joints, here, here, None).expect("the rows are sound")
}

/// `count` postures drawn evenly from the limits (SplitMix64), one after the other.
pub fn postures(chain: &Chain, count: usize, seed: u64) -> Vec<f64> {
    let mut state = seed;
    let mut unit = || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    let variables = chain.variables();
    (0..count).flat_map(|_| variables).map(|v| v.lower + (v.upper - v.lower) * unit()).collect()
}

/// The tool's poses at `count` postures: 4x4 matrices, row by row.
pub fn poses(chain: &Chain, count: usize, seed: u64) -> Vec<[f64; 16]> {
    let mut workspace = Workspace::new(chain.compiled());
    postures(chain, count, seed)
        .chunks(chain.dof())
        .map(|q| {
            let pose = tool_pose(chain, q, &mut workspace);
            std::array::from_fn(|i| pose[(i / 4, i % 4)])
        })
        .collect()
}

/// The places of poses, m.
pub fn points(poses: &[[f64; 16]]) -> Vec<[f64; 3]> {
    poses.iter().map(|m| [m[3], m[7], m[11]]).collect()
}

/// A request for a task of a chain, starts chosen by seed 0 where they are free.
pub fn request<'a>(
    chain: &'a Chain,
    task: Task,
    tolerance: Tolerance,
    goals: Goals<'a>,
    starts: Starts<'a>,
) -> Request<'a> {
    let aim = Aim::new(chain, task, tolerance, None).expect("a task and tolerances in range");
    Request::new(chain, aim, goals, starts).expect("targets and starts that fit")
}
