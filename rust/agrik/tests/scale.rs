//! Solving depends neither on the unit of length nor on where the tool is, and limits that
//! mean none are none: gantries, rails, far tools, scaled arms, wide limits and tolerances,
//! postures as people make them, nearest postures.

mod common;

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use agrik::call::{Aim, Answers, Goals, Request, Starts, Status, Tolerance, solve};
use agrik::chain::{Chain, DhConvention, DhRow, JointKind, Tail};
use agrik::solve::{Plan, Settings};
use agrik::task::Task;
use common::{Sampler, plain_poses};
use nalgebra::{IsometryMatrix3, Matrix4, Rotation3, Vector3};

/// A joint: its D-H row (a, alpha, d, theta) and limits; a slide or not.
type Row = ([f64; 4], [f64; 2], bool);

fn chain(rows: &[Row]) -> Chain {
    let joints =
        rows.iter().enumerate().map(|(i, &([a, alpha, d, theta], [lower, upper], slides))| {
            let kind = if slides { JointKind::Prismatic } else { JointKind::Revolute };
            let row = DhRow { a, alpha, d, theta };
            row.joint(DhConvention::Standard, format!("joint_{i}"), kind, lower, upper)
        });
    let none = IsometryMatrix3::identity();
    Chain::new("arm", joints.collect(), none, none, None).expect("a chain")
}

/// An arm with the lengths of a UR5e, times a factor.
fn arm(scale: f64, limit: f64) -> Vec<Row> {
    [
        [0.0, FRAC_PI_2, 0.1625, 0.0],
        [-0.425, 0.0, 0.0, 0.0],
        [-0.3922, 0.0, 0.0, 0.0],
        [0.0, FRAC_PI_2, 0.1333, 0.0],
        [0.0, -FRAC_PI_2, 0.0997, 0.0],
        [0.0, 0.0, 0.0996, 0.0],
    ]
    .map(|[a, alpha, d, theta]| ([a * scale, alpha, d * scale, theta], [-limit, limit], false))
    .to_vec()
}

/// Joint values inside the limits, and at most `within` from zero.
fn postures(chain: &Chain, count: usize, within: f64, seed: u64) -> Vec<Vec<f64>> {
    let mut sampler = Sampler(seed);
    let mut value = |v: &agrik::chain::Variable| {
        let (lower, upper) = (v.lower.max(-within), v.upper.min(within));
        lower + (upper - lower) * sampler.unit()
    };
    (0..count).map(|_| chain.variables().iter().map(&mut value).collect()).collect()
}

fn poses(chain: &Chain, postures: &[Vec<f64>]) -> Vec<Matrix4<f64>> {
    postures.iter().map(|q| plain_poses(chain, q).pop().expect("a tool pose")).collect()
}

fn row_major(pose: &Matrix4<f64>) -> [f64; 16] {
    std::array::from_fn(|i| pose[(i / 4, i % 4)])
}

struct Call<'a> {
    chain: &'a Chain,
    task: Task,
    tolerance: Tolerance,
    starts: Starts<'a>,
    tail: Option<Tail>,
}

impl<'a> Call<'a> {
    fn new(chain: &'a Chain, task: Task) -> Self {
        let tolerance = Tolerance::default();
        Self { chain, task, tolerance, starts: Starts::Free, tail: None }
    }

    fn solve(&self, targets: &[Matrix4<f64>]) -> Answers {
        let rows: Vec<[f64; 16]> = targets.iter().map(row_major).collect();
        let aim = Aim::new(self.chain, self.task, self.tolerance, self.tail).expect("valid");
        let request = Request::new(self.chain, aim, Goals::Poses(&rows), self.starts);
        let plan = Plan::new(request.expect("valid"), Settings::default()).expect("valid");
        solve(&plan, 1, &mut || true).expect("not interrupted")
    }
}

/// All targets are solved, inside the limits, by the plain product of matrices.
fn assert_solved(call: &Call<'_>, targets: &[Matrix4<f64>], what: &str) -> Answers {
    let answers = call.solve(targets);
    let dof = call.chain.dof();
    for (i, target) in targets.iter().enumerate() {
        let q = &answers.q[i * dof..(i + 1) * dof];
        assert!(answers.success(i), "{what}: row {i} is {}", answers.status[i]);
        assert!(call.chain.within_limits(q), "{what}: {q:?}");
        if call.tail.is_none() {
            let reached = plain_poses(call.chain, q).pop().expect("a tool pose");
            let way = (target - reached).fixed_view::<3, 1>(0, 3).norm();
            let rounding = 1e-15 * target.fixed_view::<3, 1>(0, 3).norm();
            assert!(way <= call.tolerance.position + 8.0 * rounding, "{what}: {way:e} off");
        }
    }
    answers
}

fn mean(numbers: &[u32]) -> f64 {
    numbers.iter().map(|x| f64::from(*x)).sum::<f64>() / numbers.len() as f64
}

#[test]
fn gantries_of_any_length_and_unit_reach_all() {
    for length in [1e-3, 1.0, 3e3, 1e4, 1e7] {
        let slides = [[0.0, FRAC_PI_2, 0.0, FRAC_PI_2]; 2].into_iter().chain([[0.0; 4]]);
        let mut rows: Vec<Row> = slides.map(|row| (row, [0.0, length], true)).collect();
        for wrist in [false, true] {
            if wrist {
                for (alpha, d) in [(FRAC_PI_2, 0.0), (-FRAC_PI_2, 0.0), (0.0, 0.1)] {
                    rows.push(([0.0, alpha, d, 0.0], [-3.0, 3.0], false));
                }
            }
            let chain = chain(&rows);
            let targets = poses(&chain, &postures(&chain, 100, f64::INFINITY, 1));
            for task in [Task::Position, Task::Pose] {
                let answers = assert_solved(&Call::new(&chain, task), &targets, "gantry");
                let most = if wrist { 30.0 } else { 3.0 };
                assert!(
                    mean(&answers.iterations) < most,
                    "{length}: {}",
                    mean(&answers.iterations)
                );
            }
        }
    }
}

#[test]
fn arms_on_rails_of_any_length_reach_all() {
    for (length, scale) in [(1.0, 1.0), (1e2, 1.0), (1e4, 1.0), (1e3, 1e3), (1e7, 1e3)] {
        let mut rows = vec![([0.0, FRAC_PI_2, 0.0, 0.0], [0.0, length], true)];
        rows.extend(arm(scale, 3.0));
        let chain = chain(&rows);
        let targets = poses(&chain, &postures(&chain, 100, f64::INFINITY, 2));
        for task in [Task::Position, Task::Pose] {
            let mut call = Call::new(&chain, task);
            call.tolerance.position = 1e-6 * scale;
            assert_solved(&call, &targets, &format!("rail {length}, arm {scale}"));
        }
    }
}

#[test]
fn far_tools_reach_as_the_flange_does() {
    let bare = chain(&arm(1.0, 3.0));
    let flange =
        Call::new(&bare, Task::Pose).solve(&poses(&bare, &postures(&bare, 200, f64::INFINITY, 3)));
    for far in [0.3, 3.0, 30.0] {
        let mut rows = arm(1.0, 3.0);
        rows[5].0[0] += 0.6 * far;
        rows[5].0[2] += 0.8 * far;
        let long = chain(&rows);
        let targets = poses(&long, &postures(&long, 200, f64::INFINITY, 3));
        let own = assert_solved(&Call::new(&long, Task::Pose), &targets, "tool of the chain");
        assert!(mean(&own.iterations) < 2.0 * mean(&flange.iterations), "{far}");
        assert_solved(&Call::new(&long, Task::Position), &targets, "tool of the chain");

        let offset = IsometryMatrix3::translation(0.6 * far, 0.0, 0.8 * far);
        let mut call = Call::new(&bare, Task::Pose);
        call.tail = Some(bare.compiled().tail_with(&offset));
        let targets = poses(&bare, &postures(&bare, 200, f64::INFINITY, 3));
        let targets: Vec<_> = targets.iter().map(|pose| pose * offset.to_homogeneous()).collect();
        assert_solved(&call, &targets, "tool of the call");
    }
}

#[test]
fn scaled_arms_take_the_same_steps() {
    let mut sampler = Sampler(4);
    for _ in 0..10 {
        let shapes: Vec<Row> = (0..7)
            .map(|_| {
                let mut any = |size: f64| size * (2.0 * sampler.unit() - 1.0);
                let row = [any(0.5), any(2.0), any(0.5), any(3.0)];
                let slides = any(1.0) > 0.6;
                (row, if slides { [-1.0, 1.0] } else { [-2.5, 2.5] }, slides)
            })
            .collect();
        let counts = [1e-3, 1.0, 1e3].map(|scale| {
            let rows: Vec<Row> = shapes
                .iter()
                .map(|&([a, alpha, d, theta], limits, slides)| {
                    let limits = if slides { limits.map(|x| x * scale) } else { limits };
                    ([a * scale, alpha, d * scale, theta], limits, slides)
                })
                .collect();
            let chain = chain(&rows);
            let targets = poses(&chain, &postures(&chain, 100, f64::INFINITY, 5));
            let mut call = Call::new(&chain, Task::Pose);
            call.tolerance.position *= scale;
            let answers = call.solve(&targets);
            let solved = (0..targets.len()).filter(|i| answers.success(*i)).count();
            (solved, mean(&answers.iterations))
        });
        for (solved, steps) in counts {
            assert!(solved.abs_diff(counts[1].0) <= 1, "{counts:?}");
            assert!((steps / counts[1].1 - 1.0).abs() < 0.1, "{counts:?}");
        }
    }
}

#[test]
fn limits_far_out_mean_none() {
    for limit in [1e4, 1e10, 1e16, f64::INFINITY] {
        let free = chain(&arm(1.0, limit));
        let targets = poses(&free, &postures(&free, 100, PI, 6));
        let answers = assert_solved(&Call::new(&free, Task::Pose), &targets, "free");
        assert!(answers.q.iter().all(|x| x.abs() <= PI + 1e-12));

        // A base that turns and drives, and an arm on it.
        let mut rows = vec![
            ([0.0, FRAC_PI_2, 0.0, FRAC_PI_2], [-limit, limit], false),
            ([0.0, -FRAC_PI_2, 0.0, 0.0], [-limit, limit], true),
        ];
        rows.extend(arm(1.0, 3.0));
        let mobile = chain(&rows);
        let targets = poses(&mobile, &postures(&mobile, 100, 2.0, 7));
        for task in [Task::Position, Task::Pose] {
            let answers = assert_solved(&Call::new(&mobile, task), &targets, "mobile base");
            assert!(answers.q.iter().all(|x| x.abs() < 20.0));
        }
    }
}

#[test]
fn of_angles_a_turn_apart_the_nearest_is_given() {
    let chain = chain(&arm(1.0, TAU));
    let wanted = postures(&chain, 200, f64::INFINITY, 8);
    let targets = poses(&chain, &wanted);
    let free = assert_solved(&Call::new(&chain, Task::Pose), &targets, "no start");
    assert!(free.q.iter().all(|x| x.abs() <= PI + 1e-9), "nearest to the middle");

    let starts: Vec<f64> = wanted.iter().flatten().copied().collect();
    let mut call = Call::new(&chain, Task::Pose);
    call.starts = Starts::Each(&starts);
    let from = assert_solved(&call, &targets, "from a solution");
    assert!(from.q.iter().zip(&starts).all(|(a, b)| (a - b).abs() < 1e-3), "the start itself");
}

#[test]
fn wide_tolerances_are_used() {
    // Five joints, and a wrist that turns about two axes alone.
    let shapes = [
        (0.0, FRAC_PI_2, 0.1),
        (0.12, 0.0, 0.0),
        (0.13, 0.0, 0.0),
        (0.0, FRAC_PI_2, 0.0),
        (0.0, 0.0, 0.1),
    ];
    let rows: Vec<Row> = shapes
        .iter()
        .enumerate()
        .map(|(i, &(a, alpha, d))| {
            let theta = if i == 3 { FRAC_PI_2 } else { 0.0 };
            ([a, alpha, d, theta], [-1.7, 1.7], false)
        })
        .collect();
    let chain = chain(&rows);
    let mut sampler = Sampler(9);
    for off in [2.0_f64, 10.0] {
        let mut targets = poses(&chain, &postures(&chain, 200, f64::INFINITY, 9));
        for target in &mut targets {
            let axis = Vector3::from_fn(|_, _| sampler.unit() - 0.5).normalize();
            let turn = Rotation3::new(axis * off.to_radians()).to_homogeneous();
            let turned = turn.fixed_view::<3, 3>(0, 0) * target.fixed_view::<3, 3>(0, 0);
            target.fixed_view_mut::<3, 3>(0, 0).copy_from(&turned);
        }
        let mut call = Call::new(&chain, Task::Pose);
        call.tolerance = Tolerance {
            position: 1e-3,
            orientation: 2.0 * off.to_radians(),
            ..Tolerance::default()
        };
        assert_solved(&call, &targets, "wide");
    }
}

#[test]
#[allow(clippy::approx_constant, reason = "limits as files of robots have them")]
fn postures_as_people_make_them_are_found() {
    let limits =
        [[-2.87, 3.13], [0.0, 3.66], [0.0, 3.13], [-1.57, 1.57], [-1.57, 1.57], [-1.57, 1.57]];
    let shapes = [
        [0.02, FRAC_PI_2, 0.06, 0.0],
        [0.264, PI, 0.0, PI],
        [0.245, 0.0, 0.0, -0.4],
        [0.068, FRAC_PI_2, 0.0, 0.0],
        [0.0, -FRAC_PI_2, 0.0, FRAC_PI_2],
        [0.0, 0.0, 0.1, 0.0],
    ];
    let rows: Vec<Row> = shapes.into_iter().zip(limits).map(|(s, l)| (s, l, false)).collect();
    let chain = chain(&rows);
    let mut sampler = Sampler(10);
    let postures: Vec<Vec<f64>> = (0..2000)
        .map(|_| {
            let value = |[lower, upper]: [f64; 2]| {
                let any = lower + (upper - lower) * sampler.unit();
                let middle = 0.5 * (lower + upper);
                let places = [0.0, FRAC_PI_2, -FRAC_PI_2, FRAC_PI_4, lower, upper, middle, any];
                places[(8.0 * sampler.unit()) as usize].clamp(lower, upper)
            };
            limits.map(value).to_vec()
        })
        .collect();
    let targets = poses(&chain, &postures);
    for task in [Task::Position, Task::Pose] {
        let answers = Call::new(&chain, task).solve(&targets);
        let missed = (0..targets.len()).filter(|i| !answers.success(*i)).count();
        assert!(missed <= 1, "{task:?}: {missed} missed");
    }
}

#[test]
fn what_is_out_of_reach_is_approached_as_near_as_can_be() {
    let rows = [
        ([0.0, FRAC_PI_2, 0.3, 0.0], [-2.5, 2.5], false),
        ([0.4, 0.0, 0.0, 0.0], [-1.5, 1.5], false),
        ([0.3, 0.0, 0.0, 0.0], [-2.0, 2.0], false),
    ];
    let chain = chain(&rows);
    let mut sampler = Sampler(11);
    let targets: Vec<Matrix4<f64>> = (0..30)
        .map(|_| {
            let way = Vector3::from_fn(|_, _| sampler.unit() - 0.5).normalize();
            Matrix4::new_translation(&(way * (0.75 + 0.5 * sampler.unit()) + Vector3::z() * 0.3))
        })
        .collect();
    let answers = Call::new(&chain, Task::Position).solve(&targets);
    // A grid over the three joints, fine enough for a bound from above.
    const STEPS: usize = 60;
    let mut places = Vec::new();
    for cell in 0..STEPS.pow(3) {
        let share = |i: u32| (cell / STEPS.pow(i) % STEPS) as f64 / (STEPS - 1) as f64;
        let q = [0, 1, 2].map(|i| {
            let [lower, upper] = rows[i].1;
            lower + (upper - lower) * share(i as u32)
        });
        let pose = plain_poses(&chain, &q).pop().expect("a tool pose");
        places.push(pose.fixed_view::<3, 1>(0, 3).into_owned());
    }
    let mut out = 0;
    for (i, target) in targets.iter().enumerate() {
        let point = target.fixed_view::<3, 1>(0, 3);
        let grid = places.iter().map(|p| (p - point).norm()).fold(f64::INFINITY, f64::min);
        let error = answers.position_error[i];
        assert!(error <= grid + 1e-9, "row {i}: {error} with {grid} at hand");
        out += usize::from(answers.status[i] == Status::OutOfReach as u8);
    }
    assert!(out > 10, "only {out} proven out of reach");
}
