//! All branches of random arms: the posture that made a pose is among them, each reaches it.

use std::f64::consts::{PI, TAU};

use agrik::call::{Aim, Goals, Request, Starts, Status, Tolerance};
use agrik::chain::{Chain, Joint, JointKind};
use agrik::closed_form::{ArmAngle, Ask, Branches, Recognised, every};
use agrik::random::Sequence;
use agrik::task::Task;
use nalgebra::{IsometryMatrix3, Rotation3, Translation3, Unit, Vector3};

/// An arm of joints about given axes, each so far behind the one before.
fn arm(axes: &[[f64; 3]], ways: &[[f64; 3]]) -> Chain {
    let joints = axes.iter().zip(ways).enumerate().map(|(i, (axis, way))| {
        let mut joint = Joint::new(format!("j{i}"), JointKind::Revolute, -7.0, 7.0);
        joint.origin = IsometryMatrix3::from_parts(
            Translation3::from(Vector3::from(*way)),
            Rotation3::identity(),
        );
        joint.axis = Unit::new_normalize(Vector3::from(*axis));
        joint
    });
    let tool = IsometryMatrix3::from_parts(
        Translation3::new(0.1, -0.05, 0.2),
        Rotation3::from_euler_angles(0.3, -0.4, 0.5),
    );
    Chain::new("arm", joints.collect(), IsometryMatrix3::identity(), tool, None).expect("an arm")
}

fn random(from: &mut Sequence) -> [f64; 3] {
    std::array::from_fn(|_| from.uniform() - 0.5)
}

fn pose(chain: &Chain, q: &[f64]) -> [f64; 16] {
    let pose = chain.link_poses(q).pop().expect("a tool");
    std::array::from_fn(|k| pose[(k / 4, k % 4)])
}

fn branches(chain: &Chain, poses: &[[f64; 16]], ask: &Ask<'_>) -> Branches {
    let aim = Aim::new(chain, Task::Pose, Tolerance::default(), None).expect("an aim");
    let request = Request::new(chain, aim, Goals::Poses(poses), Starts::Free).expect("a request");
    every(&request, ask, 1, &mut || true).expect("branches")
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    let off = |(x, y): (&f64, &f64)| {
        let off = x - y;
        (off - TAU * (off / TAU).round()).abs()
    };
    a.iter().zip(b).map(off).fold(0.0, f64::max)
}

/// Postures at random come back, and every branch reaches its pose.
fn come_back(chain: &Chain, from: &mut Sequence, ask: &Ask<'_>) {
    let dof = chain.dof();
    let all: Vec<Vec<f64>> =
        (0..40).map(|_| (0..dof).map(|_| TAU * from.uniform() - PI).collect()).collect();
    let poses: Vec<[f64; 16]> = all.iter().map(|q| pose(chain, q)).collect();
    let found = branches(chain, &poses, ask);
    for (row, (q, wanted)) in all.iter().zip(&poses).enumerate() {
        assert_eq!(found.status[row], Status::Converged as u8);
        let mut there = false;
        for b in row * found.branches..(row + 1) * found.branches {
            if !found.reached[b] {
                continue;
            }
            let one = &found.q[b * dof..(b + 1) * dof];
            there |= apart(one, q) < 1e-5;
            let there_now = pose(chain, one);
            let off = there_now.iter().zip(wanted).map(|(x, y)| (x - y).abs());
            assert!(off.fold(0.0, f64::max) < 1e-9);
        }
        assert!(there, "{q:?}");
    }
}

const PLAIN: Ask<'static> = Ask { locks: &[], angle: ArmAngle::Free, sweep: None, wrap: false };

#[test]
fn random_arms_of_six_joints() {
    let mut from = Sequence::new(31);
    for _ in 0..6 {
        let axes: Vec<_> = (0..6).map(|_| random(&mut from)).collect();
        let ways: Vec<_> = (0..6).map(|_| random(&mut from)).collect();
        let chain = arm(&axes, &ways);
        assert_eq!(Recognised::of(&chain).name, "general 6R");
        come_back(&chain, &mut from, &PLAIN);
    }
}

#[test]
fn random_arms_with_three_parallel_axes() {
    let mut from = Sequence::new(32);
    for _ in 0..6 {
        let n = random(&mut from);
        let back = n.map(|x| -x);
        let mut ways: Vec<_> = (0..6).map(|_| random(&mut from)).collect();
        ways[5] = [0.0; 3];
        let axes = [random(&mut from), n, n, back, random(&mut from), random(&mut from)];
        let chain = arm(&axes, &ways);
        assert_eq!(Recognised::of(&chain).name, "three parallel axes");
        come_back(&chain, &mut from, &PLAIN);
    }
}

#[test]
fn random_arms_whose_first_axes_meet() {
    let mut from = Sequence::new(33);
    for _ in 0..6 {
        let axes: Vec<_> = (0..6).map(|_| random(&mut from)).collect();
        let mut ways: Vec<_> = (0..6).map(|_| random(&mut from)).collect();
        (ways[1], ways[2]) = ([0.0; 3], [0.0; 3]);
        let chain = arm(&axes, &ways);
        assert_eq!(Recognised::of(&chain).name, "spherical shoulder");
        come_back(&chain, &mut from, &PLAIN);
    }
}

#[test]
fn sweeps_label_their_branches() {
    let mut from = Sequence::new(34);
    let axes: Vec<_> = (0..7).map(|_| random(&mut from)).collect();
    let ways: Vec<_> = (0..7).map(|_| random(&mut from)).collect();
    let chain = arm(&axes, &ways);
    let q: Vec<f64> = (0..7).map(|_| TAU * from.uniform() - PI).collect();
    let poses = [pose(&chain, &q)];
    let found = branches(&chain, &poses, &Ask { sweep: Some(9), ..PLAIN });
    assert_eq!(found.branches, 9 * 16);
    for b in (0..found.branches).filter(|b| found.reached[*b]) {
        let one = &found.q[7 * b..7 * b + 7];
        assert_eq!(one[6], found.values[b]);
        let reached = pose(&chain, one);
        let off = reached.iter().zip(&poses[0]).map(|(x, y)| (x - y).abs());
        assert!(off.fold(0.0, f64::max) < 1e-9);
    }
}
