//! Solving on random chains: every answer is finite and inside the limits, success is true
//! by the plain product of matrices, and most reachable targets are reached.

mod common;

use agrik::call::{Goals, Starts, Status, Tolerance, solve};
use agrik::chain::{Chain, JointKind};
use agrik::solve::{Plan, Settings};
use agrik::task::{MaskFrame, Task};
use common::random_chain::chain;
use common::{Sampler, plain_poses, random_q};
use nalgebra::{Matrix4, Rotation3};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

const CHAINS: usize = 1000;
const TARGETS: usize = 4;
/// Loose enough for chains of a hundred metres, whose poses carry 1e-13 m of rounding.
const TOLERANCE: Tolerance = Tolerance { position: 1e-5, orientation: 1e-5, axes: None };

fn row_major(pose: &Matrix4<f64>) -> [f64; 16] {
    std::array::from_fn(|i| pose[(i / 4, i % 4)])
}

fn tasks() -> [Task; 4] {
    [
        Task::Position,
        Task::Pose,
        Task::Axis { tool_axis: [0.0, 0.6, 0.8] },
        Task::Masked { weights: [1.0, 1.0, 0.0, 0.0, 0.5, 1.0], frame: MaskFrame::Tool },
    ]
}

/// The task's errors at `reached`, in m and rad, written out with nalgebra.
fn errors(task: &Task, reached: &Matrix4<f64>, wanted: &Matrix4<f64>) -> (f64, f64) {
    let rotation = |m: &Matrix4<f64>| {
        Rotation3::from_matrix_unchecked(m.fixed_view::<3, 3>(0, 0).into_owned())
    };
    let (from, to) = (rotation(reached), rotation(wanted));
    let way = (wanted - reached).fixed_view::<3, 1>(0, 3).into_owned();
    // `angle` loses small angles to the arc cosine; the vector's sine keeps them.
    let turn = to * from.inverse();
    let m = turn.matrix();
    let sine =
        nalgebra::Vector3::new(m[(2, 1)] - m[(1, 2)], m[(0, 2)] - m[(2, 0)], m[(1, 0)] - m[(0, 1)]);
    let angle = sine.norm().atan2(m.trace() - 1.0);
    match *task {
        // An orientation is told, not asked for.
        Task::Position | Task::PositionFirst => (way.norm(), 0.0),
        Task::Pose => (way.norm(), angle),
        Task::Axis { tool_axis } => {
            let axis = nalgebra::Vector3::from(tool_axis);
            let (a, b) = (from * axis, to * axis);
            (way.norm(), a.cross(&b).norm().atan2(a.dot(&b)))
        }
        Task::Masked { .. } => {
            let local = from.inverse() * way;
            let vector = if sine.norm() < 1e-300 { sine } else { sine * (angle / sine.norm()) };
            let turn = from.inverse() * vector;
            (local[0].hypot(local[1]), turn[1].hypot(turn[2]))
        }
    }
}

fn check(chain: &Chain, task: Task, sampler: &mut Sampler) -> usize {
    let poses: Vec<Matrix4<f64>> = (0..TARGETS)
        .map(|_| {
            let q = random_q(chain, sampler);
            plain_poses(chain, &q).pop().expect("a tool pose")
        })
        .collect();
    let rows: Vec<[f64; 16]> = poses.iter().map(row_major).collect();
    let settings = Settings { max_restarts: 30, ..Settings::default() };
    let goals = Goals::Poses(&rows);
    let request = common::arms::request(chain, task, TOLERANCE, goals, Starts::Free);
    let plan = Plan::new(request, settings).expect("settings in range");
    let answers = solve(&plan, 1, &mut || true).expect("not interrupted");
    let dof = chain.dof();
    let mut solved = 0;
    for (row, wanted) in poses.iter().enumerate() {
        let q = &answers.q[row * dof..(row + 1) * dof];
        assert!(q.iter().all(|x| x.is_finite()));
        assert!(chain.within_limits(q), "{q:?} outside the limits");
        let continuous = chain.variables().iter().zip(q);
        for (v, x) in continuous.filter(|(v, _)| v.kind == JointKind::Continuous) {
            assert!(x.abs() <= std::f64::consts::PI + 1e-12, "{} at {x}", v.name);
        }
        assert!(!answers.position_error[row].is_nan() && !answers.orientation_error[row].is_nan());
        assert_ne!(answers.status[row], Status::OutOfReach as u8, "the target was reached before");
        if answers.success(row) {
            let reached = plain_poses(chain, q).pop().expect("a tool pose");
            let (distance, angle) = errors(&task, &reached, wanted);
            assert!(distance <= TOLERANCE.position, "{task:?}: {distance:e} m off");
            assert!(angle <= TOLERANCE.orientation, "{task:?}: {angle:e} rad off");
            solved += 1;
        }
    }
    solved
}

#[test]
fn answers_on_random_chains_are_true() {
    // A generator of its own rather than `proptest!`: the shares are counted over all cases.
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let mut runner = TestRunner::new_with_rng(Config::default(), rng);
    let mut sampler = Sampler(1);
    let mut solved = [0; 4];
    for _ in 0..CHAINS {
        let chain = chain().new_tree(&mut runner).expect("a chain").current();
        for (count, task) in solved.iter_mut().zip(tasks()) {
            *count += check(&chain, task, &mut sampler);
        }
    }
    for (count, task) in solved.iter().zip(tasks()) {
        let share = *count as f64 / (CHAINS * TARGETS) as f64;
        println!("{task:?}: {:.2} % solved", 100.0 * share);
        assert!(share > 0.97, "{task:?}: only {share} solved");
    }
}
