//! Closed forms on random arms: every kind of shoulder, random offsets, base and tool.

mod common;

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use agrik::call::{Goals, Starts, Status, Tolerance, solve};
use agrik::chain::{Chain, DhConvention, DhRow, JointKind};
use agrik::closed_form::{ArmAngle, Choice, ClosedForm, Kind, Query, all};
use agrik::kinematics::{Workspace, tool_pose};
use agrik::task::Task;
use common::Sampler;
use nalgebra::{IsometryMatrix3, Matrix4, Rotation3, Translation3};
use proptest::prelude::*;

/// Lengths and twists of a first three joints of each kind.
fn shoulder(kind: Kind, u: &[f64; 8]) -> [DhRow; 3] {
    let length = |x: f64| 0.1 + 0.5 * x;
    let tilt = |x: f64| 0.4 + 1.2 * x;
    let row = |a: f64, alpha: f64, d: f64| DhRow { a, alpha, d, theta: 0.0 };
    let last = row(0.3 * u[6], if u[7] < 0.5 { -FRAC_PI_2 } else { tilt(u[7]) }, 0.2 * u[5]);
    match kind {
        Kind::ParallelElbow => {
            let alpha = if u[0] < 0.5 { FRAC_PI_2 } else { tilt(u[0]) };
            let second = if u[1] < 0.5 { 0.0 } else { PI };
            [row(0.3 * u[2], alpha, u[3]), row(length(u[4]), second, 0.2 * u[1]), last]
        }
        Kind::ParallelBase => {
            let first = if u[0] < 0.5 { 0.0 } else { PI };
            [row(length(u[2]), first, u[3]), row(0.4 * u[4], tilt(u[1]), 0.3 * u[5]), last]
        }
        Kind::MeetingBase => {
            [row(0.0, tilt(u[0]), u[3]), row(length(u[4]), tilt(u[1]), 0.3 * u[2]), last]
        }
        Kind::General => {
            [row(length(u[2]), tilt(u[0]), u[3]), row(length(u[4]), tilt(u[1]), 0.2 * u[5]), last]
        }
    }
}

fn frame(u: &[f64; 6]) -> IsometryMatrix3<f64> {
    IsometryMatrix3::from_parts(
        Translation3::new(u[0] - 0.5, u[1] - 0.5, u[2] - 0.5),
        Rotation3::from_euler_angles(6.0 * u[3], 3.0 * u[4], 6.0 * u[5]),
    )
}

fn chain_of(rows: &[DhRow], sampler: &mut Sampler) -> Chain {
    let joints = rows.iter().enumerate().map(|(i, row)| {
        let row = DhRow { theta: TAU * sampler.unit() - PI, ..*row };
        let (lower, upper) = (-3.0 - sampler.unit(), 3.0 + sampler.unit());
        row.joint(DhConvention::Standard, format!("q{i}"), JointKind::Revolute, lower, upper)
    });
    let joints = joints.collect();
    let mut six = || std::array::from_fn(|_| sampler.unit());
    Chain::new("random", joints, frame(&six()), frame(&six()), None).expect("a chain")
}

fn wrist(sampler: &mut Sampler) -> [DhRow; 3] {
    let d = 0.2 + 0.5 * sampler.unit();
    let row = |alpha: f64, d: f64| DhRow { a: 0.0, alpha, d, theta: 0.0 };
    [row(FRAC_PI_2, d), row(-FRAC_PI_2, 0.0), row(0.3, 0.1)]
}

fn rows_of(poses: &[Matrix4<f64>]) -> Vec<[f64; 16]> {
    poses.iter().map(|m| std::array::from_fn(|i| m[(i / 4, i % 4)])).collect()
}

fn query<'a>(
    chain: &'a Chain,
    goals: &'a [[f64; 16]],
    starts: Starts<'a>,
    choice: Choice,
) -> Query<'a> {
    let request =
        common::arms::request(chain, Task::Pose, Tolerance::default(), Goals::Poses(goals), starts);
    Query::new(request, ArmAngle::Free, choice).expect("a closed form")
}

/// Poses of random joint values, the answers of all branches, and how many of the poses
/// found their joint values again; every branch is checked to be as accurate as given.
fn check(chain: &Chain, count: usize, accuracy: f64, sampler: &mut Sampler) -> f64 {
    let dof = chain.dof();
    let mut workspace = Workspace::new(chain.compiled());
    let q: Vec<f64> = (0..count).flat_map(|_| common::random_q(chain, sampler)).collect();
    let poses: Vec<_> = q.chunks_exact(dof).map(|q| tool_pose(chain, q, &mut workspace)).collect();
    let goals = rows_of(&poses);
    let query = query(chain, &goals, Starts::Each(&q), Choice::Nearest);
    let found = all(&query, 1, &mut || true).expect("not interrupted");
    let mut again = 0;
    for (row, q) in q.chunks_exact(dof).enumerate() {
        let mut nearest = f64::INFINITY;
        for b in row * found.branches..(row + 1) * found.branches {
            if !found.reached[b] {
                continue;
            }
            let one = &found.q[b * dof..(b + 1) * dof];
            let pose = tool_pose(chain, one, &mut workspace);
            let off = (pose - poses[row]).abs().max();
            assert!(off < accuracy, "branch {b} is off by {off:e}");
            assert_eq!(found.valid[b], chain.within_limits(one), "{one:?}");
            let away = one.iter().zip(q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            nearest = nearest.min(away);
        }
        again += usize::from(nearest < 1e-6);
    }
    let nearest = solve(&query, 1, &mut || true).expect("not interrupted");
    let solved = (0..count).filter(|row| nearest.success(*row)).count();
    assert!(solved >= again, "{solved} solved of {again}");
    again as f64 / count as f64
}

fn kinds() -> impl Strategy<Value = Kind> {
    prop_oneof![
        Just(Kind::ParallelElbow),
        Just(Kind::ParallelBase),
        Just(Kind::MeetingBase),
        Just(Kind::General),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Whatever the shoulder, the joint values are among the branches and the branches reach.
    #[test]
    fn random_spherical_wrists(kind in kinds(), seed in any::<u64>()) {
        let mut sampler = Sampler(seed);
        let u = std::array::from_fn(|_| sampler.unit());
        let rows = [shoulder(kind, &u), wrist(&mut sampler)].concat();
        let chain = chain_of(&rows, &mut sampler);
        match ClosedForm::of(&chain) {
            Ok(ClosedForm::SphericalWrist(arm)) => prop_assert_eq!(arm.kind(), kind),
            other => prop_assert!(false, "{other:?}"),
        }
        // Rounding may part two branches that all but meet.
        prop_assert!(check(&chain, 200, 2e-9, &mut sampler) >= 0.99);
    }

    /// S-R-S arms with a bent elbow and any twist at it.
    #[test]
    fn random_srs_arms(seed in any::<u64>()) {
        let mut sampler = Sampler(seed);
        let row = |a: f64, alpha: f64, d: f64| DhRow { a, alpha, d, theta: 0.0 };
        let mut unit = || sampler.unit();
        let offset = if unit() < 0.5 { 0.0 } else { 0.1 * unit() };
        let twist = if unit() < 0.5 { FRAC_PI_2 } else { 0.6 + unit() };
        let rows = [
            row(0.0, -FRAC_PI_2, unit()),
            row(0.0, FRAC_PI_2, 0.0),
            row(offset, twist, 0.3 + 0.3 * unit()),
            row(-offset, -twist, 0.0),
            row(0.0, FRAC_PI_2, 0.3 + 0.3 * unit()),
            row(0.0, -FRAC_PI_2, 0.0),
            row(0.0, 0.0, 0.1),
        ];
        let chain = chain_of(&rows, &mut sampler);
        prop_assert!(matches!(ClosedForm::of(&chain), Ok(ClosedForm::Srs(_))));
        // At the arm angle of the starts, which are the joint values themselves.
        prop_assert!(check(&chain, 100, 2e-9, &mut sampler) >= 0.99);
    }

    /// A wrist whose axes miss one another by more than the tolerance is refused.
    #[test]
    fn wrists_that_miss_are_refused(seed in any::<u64>(), miss in 1e-5..0.2) {
        let mut sampler = Sampler(seed);
        let u = std::array::from_fn(|_| sampler.unit());
        let mut rows = [shoulder(Kind::ParallelElbow, &u), wrist(&mut sampler)].concat();
        rows[3].a = miss;
        let chain = chain_of(&rows, &mut sampler);
        let why = ClosedForm::of(&chain).expect_err("no common point");
        prop_assert!(why.contains("miss a common point"), "{}", why);
    }
}

/// The equation of the fourth degree left one of the first arm's branches 4.7e-9 m off, and
/// lost 1.5 % of the second's, where three of its roots are about to meet.
#[test]
fn digits_and_roots_that_the_quartic_loses_are_found_again() {
    for seed in [2_130_432_234_471_733_589, 17_957_685_919_676_723_192] {
        let mut sampler = Sampler(seed);
        let u = std::array::from_fn(|_| sampler.unit());
        let rows = [shoulder(Kind::General, &u), wrist(&mut sampler)].concat();
        let chain = chain_of(&rows, &mut sampler);
        assert!(check(&chain, 2000, 2e-10, &mut sampler) >= 0.999);
    }
}

#[test]
fn out_of_reach_is_proven() {
    let mut sampler = Sampler(1);
    let u = std::array::from_fn(|_| sampler.unit());
    let rows = [shoulder(Kind::General, &u), wrist(&mut sampler)].concat();
    let chain = chain_of(&rows, &mut sampler);
    let mut pose = Matrix4::identity();
    pose[(0, 3)] = 10.0;
    let goals = rows_of(&[pose]);
    let query = query(&chain, &goals, Starts::Free, Choice::Margin);
    let found = all(&query, 1, &mut || true).expect("not interrupted");
    assert_eq!(found.status, [Status::OutOfReach as u8]);
    let one = solve(&query, 1, &mut || true).expect("not interrupted");
    assert_eq!(one.status, [Status::OutOfReach as u8]);
    assert!(one.position_error[0] > 5.0);
    assert!(chain.within_limits(&one.q));
}

#[test]
fn targets_very_far_away_leave_no_nan() {
    let mut sampler = Sampler(1);
    for kind in [Kind::ParallelElbow, Kind::ParallelBase, Kind::MeetingBase, Kind::General] {
        let u = std::array::from_fn(|_| sampler.unit());
        let rows = [shoulder(kind, &u), wrist(&mut sampler)].concat();
        let chain = chain_of(&rows, &mut sampler);
        // Beyond 1e50 m a number means nothing.
        for (far, status) in [
            (1e49, Status::OutOfReach),
            (-1e49, Status::OutOfReach),
            (1e160, Status::BadInput),
            (-1e300, Status::BadInput),
        ] {
            for axis in 0..3 {
                let mut pose = Matrix4::identity();
                pose[(axis, 3)] = far;
                let goals = rows_of(&[pose; 5]);
                // Alone and in lanes.
                for goals in [&goals[..1], &goals[..]] {
                    let query = query(&chain, goals, Starts::Free, Choice::Margin);
                    let found = all(&query, 1, &mut || true).expect("not interrupted");
                    assert!(found.status.iter().all(|s| *s == status as u8));
                    assert!(found.q.iter().all(|x| x.is_finite()));
                    let one = solve(&query, 1, &mut || true).expect("not interrupted");
                    assert!(one.q.iter().all(|x| x.is_finite()));
                    assert!(one.position_error.iter().all(|x| *x > 1e48));
                    let told = |x: &f64| x.is_finite() || status == Status::BadInput;
                    assert!(one.orientation_error.iter().all(told));
                }
            }
        }
    }
}
