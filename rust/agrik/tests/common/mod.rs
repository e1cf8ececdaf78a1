//! What the integration tests share: plain kinematics, random values, random chains.
#![allow(dead_code, reason = "each test file uses a part")]

#[path = "arms.rs"]
pub mod arms;
pub mod random_chain;

use agrik::chain::{Chain, Joint, JointKind};
use agrik::kinematics::{Workspace, tool_pose};
use nalgebra::{Matrix3, Matrix4, Vector3};

/// Evenly spread numbers from a seed (SplitMix64).
pub struct Sampler(pub u64);

impl Sampler {
    /// A number in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Joint values inside the limits; free joints in [-pi, pi], and every eighth value at
/// one of its limits.
pub fn random_q(chain: &Chain, sampler: &mut Sampler) -> Vec<f64> {
    let value = |v: &agrik::chain::Variable| {
        let lower =
            v.lower.max(-std::f64::consts::PI * if v.lower.is_finite() { 1e9 } else { 1.0 });
        let upper = v.upper.min(std::f64::consts::PI * if v.upper.is_finite() { 1e9 } else { 1.0 });
        match (sampler.unit() * 16.0) as u32 {
            0 => lower,
            1 => upper,
            _ => (lower + (upper - lower) * sampler.unit()).clamp(lower, upper),
        }
    };
    chain.variables().iter().map(value).collect()
}

/// Poses of all links and of the tool, by a product of homogeneous matrices.
pub fn plain_poses(chain: &Chain, q: &[f64]) -> Vec<Matrix4<f64>> {
    let value_of = |name: &str| {
        let i = chain.variables().iter().position(|v| v.name == name).expect("a variable");
        q[i]
    };
    let mut pose = chain.base().to_homogeneous();
    let mut poses = Vec::new();
    for joint in chain.joints() {
        let value = match (&joint.mimic, joint.kind) {
            (_, JointKind::Fixed) => 0.0,
            (Some(mimic), _) => mimic.multiplier * value_of(&mimic.source) + mimic.offset,
            (None, _) => value_of(&joint.name),
        };
        pose = pose
            * joint.origin.to_homogeneous()
            * plain_motion(joint, value)
            * joint.after.to_homogeneous();
        poses.push(pose);
    }
    poses.push(pose * chain.tool().to_homogeneous());
    poses
}

/// Rodrigues' formula, or a slide.
fn plain_motion(joint: &Joint, value: f64) -> Matrix4<f64> {
    let axis = joint.axis.into_inner();
    match joint.kind {
        JointKind::Fixed => Matrix4::identity(),
        JointKind::Prismatic => Matrix4::new_translation(&(axis * value)),
        JointKind::Revolute | JointKind::Continuous => {
            let k = axis.cross_matrix();
            let (s, c) = value.sin_cos();
            (Matrix3::identity() + k * s + k * k * (1.0 - c)).to_homogeneous()
        }
    }
}

/// One metre and all lengths of a chain.
pub fn size(chain: &Chain) -> f64 {
    let lengths = chain.joints().iter().map(|joint| {
        let slide = if joint.kind == JointKind::Prismatic {
            joint.lower.abs().max(joint.upper.abs())
        } else {
            0.0
        };
        joint.origin.translation.vector.norm() + joint.after.translation.vector.norm() + slide
    });
    let ends = chain.base().translation.vector.norm() + chain.tool().translation.vector.norm();
    1.0 + ends + lengths.sum::<f64>()
}

/// Derivative of the tool pose by central differences of step `h`: one column (linear,
/// angular) per entry of `q`.
pub fn difference_jacobian(chain: &Chain, q: &[f64], h: f64) -> Vec<[f64; 6]> {
    let mut workspace = Workspace::new(chain.compiled());
    let mut pose_at = |i: usize, value: f64| {
        let mut moved = q.to_vec();
        moved[i] = value;
        tool_pose(chain, &moved, &mut workspace)
    };
    (0..q.len())
        .map(|i| {
            let (ahead, behind) = (pose_at(i, q[i] + h), pose_at(i, q[i] - h));
            let way: Vector3<f64> =
                (ahead - behind).fixed_view::<3, 1>(0, 3).into_owned() / (2.0 * h);
            let turn: Matrix3<f64> = ahead.fixed_view::<3, 3>(0, 0)
                * behind.fixed_view::<3, 3>(0, 0).transpose()
                / (4.0 * h);
            [
                way[0],
                way[1],
                way[2],
                turn[(2, 1)] - turn[(1, 2)],
                turn[(0, 2)] - turn[(2, 0)],
                turn[(1, 0)] - turn[(0, 1)],
            ]
        })
        .collect()
}
