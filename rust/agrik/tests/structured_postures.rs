//! Closed forms where random postures never stand and people do: joints at zero, at right
//! angles, at their limits, in the middle. Whatever the posture, its pose is reachable, so it
//! is never said to be out of reach, and nearly all of them are solved.

mod common;

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use agrik::call::{Aim, Answers, Goals, Request, Starts, Status, Tolerance, solve};
use agrik::chain::{Chain, DhConvention, DhRow, JointKind};
use agrik::closed_form::{ArmAngle, Choice, ClosedForm, Query, all};
use agrik::solvers::Solver;
use agrik::task::Task;
use common::{Sampler, plain_poses};
use nalgebra::{IsometryMatrix3, Matrix4, Rotation3, Vector3};

/// a, alpha, d, theta and limits of each joint.
type Row = [f64; 6];

fn chain_of(rows: &[Row]) -> Chain {
    let joints = rows.iter().enumerate().map(|(i, &[a, alpha, d, theta, lower, upper])| {
        let row = DhRow { a, alpha, d, theta };
        row.joint(DhConvention::Standard, format!("q{i}"), JointKind::Revolute, lower, upper)
    });
    let none = IsometryMatrix3::identity();
    Chain::new("arm", joints.collect(), none, none, None).expect("a chain")
}

/// Each joint at 0, a quarter or an eighth of a turn, a limit, the middle, or anywhere.
fn structured(chain: &Chain, sampler: &mut Sampler) -> Vec<f64> {
    let value = |v: &agrik::chain::Variable| {
        let x = match (8.0 * sampler.unit()) as u32 {
            0 => 0.0,
            1 => FRAC_PI_2,
            2 => -FRAC_PI_2,
            3 => FRAC_PI_4,
            4 => v.lower,
            5 => v.upper,
            6 => 0.5 * (v.lower + v.upper),
            _ => v.lower + (v.upper - v.lower) * sampler.unit(),
        };
        x.clamp(v.lower, v.upper)
    };
    chain.variables().iter().map(value).collect()
}

fn pose_of(chain: &Chain, q: &[f64]) -> Matrix4<f64> {
    *plain_poses(chain, q).last().expect("the tool")
}

fn rows_of(poses: &[Matrix4<f64>]) -> Vec<[f64; 16]> {
    poses.iter().map(|m| std::array::from_fn(|i| m[(i / 4, i % 4)])).collect()
}

fn request<'a>(chain: &'a Chain, goals: &'a [[f64; 16]], starts: Starts<'a>) -> Request<'a> {
    let aim = Aim::new(chain, Task::Pose, Tolerance::default(), None).expect("an aim");
    Request::new(chain, aim, Goals::Poses(goals), starts).expect("a request")
}

fn query_of<'a>(chain: &'a Chain, goals: &'a [[f64; 16]], starts: Starts<'a>) -> Query<'a> {
    let request = request(chain, goals, starts);
    Query::new(request, ArmAngle::Free, Choice::Nearest).expect("a closed form")
}

/// What became of a set of targets.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Tally {
    solved: usize,
    not_found: usize,
    out_of_reach: usize,
}

impl Tally {
    fn of(status: &[u8]) -> Self {
        let count = |wanted: Status| status.iter().filter(|s| **s == wanted as u8).count();
        Self {
            solved: count(Status::Converged),
            not_found: count(Status::NotFound),
            out_of_reach: count(Status::OutOfReach),
        }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            solved: self.solved + other.solved,
            not_found: self.not_found + other.not_found,
            out_of_reach: self.out_of_reach + other.out_of_reach,
        }
    }
}

/// Every answer that counts as solved is inside the limits and reaches, by plain matrices.
fn check_answer(chain: &Chain, q: &[f64], pose: &Matrix4<f64>) {
    assert!(chain.within_limits(q), "{q:?}");
    let off = pose_of(chain, q) - pose;
    let way = off.fixed_view::<3, 1>(0, 3).norm();
    // Three axes count each rotation twice.
    let turn = off.fixed_view::<3, 3>(0, 0).norm() / 2f64.sqrt();
    assert!(way < 1.001e-6 && turn < 1.001e-6, "{way:e} m, {turn:e} rad at {q:?}");
}

/// The best branch, all branches, and a few targets alone, of structured postures.
fn tally(chain: &Chain, count: usize, sampler: &mut Sampler) -> [Tally; 2] {
    assert!(ClosedForm::of(chain).is_ok(), "{:?}", ClosedForm::of(chain));
    let dof = chain.dof();
    let postures: Vec<Vec<f64>> = (0..count).map(|_| structured(chain, sampler)).collect();
    let poses: Vec<_> = postures.iter().map(|q| pose_of(chain, q)).collect();
    let goals = rows_of(&poses);
    let query = query_of(chain, &goals, Starts::Free);
    let best = solve(&query, 1, &mut || true).expect("not interrupted");
    for row in 0..count {
        if best.success(row) {
            check_answer(chain, &best.q[row * dof..][..dof], &poses[row]);
        } else if shows() {
            println!("{} {:?}", best.status[row], postures[row]);
        }
        assert_ne!(best.status[row], Status::OutOfReach as u8, "{:?}", postures[row]);
    }
    // From the postures themselves, which an arm angle is taken from.
    let starts: Vec<f64> = postures.concat();
    let query = query_of(chain, &goals, Starts::Each(&starts));
    let branches = all(&query, 1, &mut || true).expect("not interrupted");
    for (row, pose) in poses.iter().enumerate() {
        for b in (row * 8..(row + 1) * 8).filter(|b| branches.valid[*b]) {
            check_answer(chain, &branches.q[b * dof..][..dof], pose);
        }
        assert_ne!(branches.status[row], Status::OutOfReach as u8, "{:?}", postures[row]);
    }
    [Tally::of(&best.status), Tally::of(&branches.status)]
}

/// A wrist whose axes cross at right angles, or miss that a little.
fn wrist(miss: f64, tilt: f64, limits: [f64; 3], length: f64) -> [Row; 3] {
    let [four, five, six] = limits;
    let right = FRAC_PI_2 + tilt;
    [
        [miss, -right, length, 0.0, -four, four],
        [-miss, right, 0.0, 0.0, -five, five],
        [0.0, 0.0, 0.1, 0.0, -six, six],
    ]
}

const MISSES: [f64; 5] = [0.0, 1e-12, 1e-10, 1e-9, 1e-7];
/// What a right angle is off by as files round it.
const TILTS: [f64; 3] = [0.0, 3.673_205_103_432e-6, 2.040_8e-9];

fn limit(sampler: &mut Sampler) -> f64 {
    [FRAC_PI_2, 1.57, 1.8, 2.0, 2.3, 2.9, 2.967, PI, 2.0 * PI][(9.0 * sampler.unit()) as usize]
}

fn spherical(sampler: &mut Sampler) -> Chain {
    let pick = |sampler: &mut Sampler, of: &[f64]| of[(of.len() as f64 * sampler.unit()) as usize];
    let mut limits = || [limit(sampler), limit(sampler), limit(sampler)];
    let ([a, b, c], behind) = (limits(), limits());
    let (miss, tilt) = (pick(sampler, &MISSES), pick(sampler, &TILTS));
    let right = FRAC_PI_2 + pick(sampler, &TILTS);
    let first = pick(sampler, &[0.0, 0.0, 0.15, -0.05]);
    let shift = pick(sampler, &[0.0, 0.0, 0.1]);
    let twist = pick(sampler, &[0.0, 0.0, PI, 1e-9, FRAC_PI_2]);
    let fore = pick(sampler, &[0.0, 0.02, -0.03]);
    let (lean, upper) = (pick(sampler, &[0.0, FRAC_PI_2]), pick(sampler, &[0.45, 0.45, 0.45, 0.4]));
    let ahead = [
        [first, right, 0.3, 0.0, -a, a],
        [upper, twist, shift, lean, -b, b],
        [fore, right, 0.0, 0.0, -c, c],
    ];
    chain_of(&[ahead, wrist(miss, tilt, behind, 0.4)].concat())
}

fn srs(sampler: &mut Sampler) -> Chain {
    let pick = |sampler: &mut Sampler, of: &[f64]| of[(of.len() as f64 * sampler.unit()) as usize];
    let miss = pick(sampler, &MISSES);
    let (tilt, bend) = (pick(sampler, &TILTS), pick(sampler, &[0.0, 0.0, 0.0825]));
    let limits: Vec<f64> = (0..7).map(|_| limit(sampler)).collect();
    let right = FRAC_PI_2 + tilt;
    let row = |j: usize, a: f64, alpha: f64, d: f64| [a, alpha, d, 0.0, -limits[j], limits[j]];
    chain_of(&[
        row(0, miss, -right, 0.34),
        row(1, 0.0, right, 0.0),
        row(2, bend, -right, 0.4),
        row(3, -bend, right, 0.0),
        row(4, 0.0, -right, 0.4),
        row(5, miss, right, 0.0),
        row(6, 0.0, 0.0, 0.126),
    ])
}

/// Prints what is not solved, by hand: `SHOW=1`.
fn shows() -> bool {
    std::env::var_os("SHOW").is_some()
}

/// How many postures an arm: more by hand, `POSTURES=20000`.
fn postures(usual: usize) -> usize {
    std::env::var("POSTURES").ok().and_then(|n| n.parse().ok()).unwrap_or(usual)
}

fn puma() -> Chain {
    let d = PI / 180.0;
    chain_of(&[
        [0.0, FRAC_PI_2, 0.6718, 0.0, -160.0 * d, 160.0 * d],
        [0.4318, 0.0, 0.0, 0.0, -110.0 * d, 110.0 * d],
        [0.0203, -FRAC_PI_2, 0.15005, 0.0, -135.0 * d, 135.0 * d],
        [0.0, FRAC_PI_2, 0.4318, 0.0, -266.0 * d, 266.0 * d],
        [0.0, -FRAC_PI_2, 0.0, 0.0, -100.0 * d, 100.0 * d],
        [0.0, 0.0, 0.0, 0.0, -266.0 * d, 266.0 * d],
    ])
}

fn redundant7() -> Chain {
    let row = |alpha: f64, d: f64, limit: f64| {
        let limit = limit.to_radians();
        [0.0, alpha.to_radians(), d, 0.0, -limit, limit]
    };
    chain_of(&[
        row(-90.0, 0.34, 170.0),
        row(90.0, 0.0, 120.0),
        row(-90.0, 0.4, 170.0),
        row(90.0, 0.0, 120.0),
        row(-90.0, 0.4, 170.0),
        row(90.0, 0.0, 120.0),
        row(0.0, 0.126, 175.0),
    ])
}

/// A straight wrist without a shoulder's offset, and wrist limits below half a turn.
fn straight() -> Chain {
    let limits = [3.0, 2.0, 2.3, 2.967, 2.0, 2.9];
    let rows = [
        [0.0, FRAC_PI_2, 0.3],
        [0.4, 0.0, 0.0],
        [0.02, FRAC_PI_2, 0.0],
        [0.0, -FRAC_PI_2, 0.4],
        [0.0, FRAC_PI_2, 0.0],
        [0.0, 0.0, 0.1],
    ];
    let rows: Vec<Row> = rows
        .iter()
        .zip(limits)
        .map(|(&[a, alpha, d], limit)| [a, alpha, d, 0.0, -limit, limit])
        .collect();
    chain_of(&rows)
}

fn check(name: &str, tallies: [Tally; 2], shares: [f64; 2]) {
    for ((tally, share), what) in tallies.iter().zip(shares).zip(["best", "all"]) {
        let all = tally.solved + tally.not_found + tally.out_of_reach;
        println!("{name} {what}: {tally:?}");
        assert_eq!(tally.out_of_reach, 0, "{name} {what}");
        let solved = tally.solved as f64 / all as f64;
        assert!(solved >= share, "{name} {what}: {solved}");
    }
}

#[test]
fn known_arms_find_structured_postures() {
    for (name, chain) in [("puma", puma()), ("redundant7", redundant7()), ("straight", straight())]
    {
        let tallies = tally(&chain, postures(4000), &mut Sampler(7));
        check(name, tallies, [0.9999, 0.9999]);
    }
}

#[test]
fn random_spherical_wrists_find_structured_postures() {
    let mut sampler = Sampler(3);
    let mut sum = [Tally::default(); 2];
    for _ in 0..60 {
        let chain = spherical(&mut sampler);
        let one = tally(&chain, postures(400), &mut sampler);
        sum = [sum[0].plus(one[0]), sum[1].plus(one[1])];
    }
    // What is left is singular, at a limit, and of arms whose axes miss one another.
    check("spherical wrists", sum, [0.998, 0.998]);
}

#[test]
fn random_srs_arms_find_structured_postures() {
    let mut sampler = Sampler(5);
    let mut sum = [Tally::default(); 2];
    for _ in 0..30 {
        let chain = srs(&mut sampler);
        let one = tally(&chain, postures(400), &mut sampler);
        sum = [sum[0].plus(one[0]), sum[1].plus(one[1])];
    }
    // All branches stand at the arm angle of the start, which a stretched arm whose axes are
    // a little off their right angles does not determine well.
    check("S-R-S arms", sum, [0.999, 0.99]);
}

/// A split of the last and the first joint of a straight wrist that the limits allow.
#[test]
fn a_straight_wrist_shares_its_turn_inside_the_limits() {
    let chain = straight();
    let q = [0.0, 0.5, -0.5, 1.5, 0.0, 1.5];
    let goals = rows_of(&[pose_of(&chain, &q)]);
    for (low, start) in [(true, None), (false, Some([0.0, 0.5, -0.5, 2.9, 0.0, 0.1]))] {
        let starts = start.as_ref().map_or(Starts::Free, |q| Starts::One(q));
        let query = query_of(&chain, &goals, starts);
        let answers: Answers = solve(&query, 1, &mut || true).expect("not interrupted");
        assert!(answers.success(0));
        let sum = answers.q[3] + answers.q[5];
        assert!((sum - 3.0).abs() < 1e-9, "{:?}", answers.q);
        // As near as the limits allow to the middle of the fourth joint's, or to the start.
        let wanted = if low { 0.1 } else { 2.9 };
        assert!((answers.q[3] - wanted).abs() < 1e-9, "{:?}", answers.q);
    }
}

/// Where the closed form leaves a target open the step solver goes on; no answer depends on
/// the others of its batch.
#[test]
fn auto_solves_what_the_closed_form_leaves_open() {
    let mut sampler = Sampler(11);
    let mut sum = Tally::default();
    for i in 0..24 {
        let chain = if i % 3 == 0 { srs(&mut sampler) } else { spherical(&mut sampler) };
        let dof = chain.dof();
        let count = postures(400);
        let poses: Vec<_> =
            (0..count).map(|_| pose_of(&chain, &structured(&chain, &mut sampler))).collect();
        let goals = rows_of(&poses);
        let call = Solver::Auto.call(request(&chain, &goals, Starts::Free).with_seed(3, 0));
        let auto = solve(&call.expect("a call"), 2, &mut || true).expect("not interrupted");
        let query = query_of(&chain, &goals, Starts::Free);
        let closed = solve(&query, 1, &mut || true).expect("not interrupted");
        for (row, pose) in poses.iter().enumerate() {
            let q = &auto.q[row * dof..][..dof];
            if auto.success(row) {
                check_answer(&chain, q, pose);
            } else if shows() {
                println!("auto {} at {row}", auto.status[row]);
            }
            if closed.success(row) {
                assert_eq!(q, &closed.q[row * dof..][..dof]);
            } else {
                let one = &goals[row..=row];
                let alone = request(&chain, one, Starts::Free).with_seed(3, row as u64);
                let call = Solver::Auto.call(alone).expect("a call");
                let alone = solve(&call, 1, &mut || true).expect("not interrupted");
                assert_eq!((&alone.q[..], alone.status[0]), (q, auto.status[row]));
            }
        }
        sum = sum.plus(Tally::of(&auto.status));
    }
    println!("auto: {sum:?}");
    assert_eq!(sum.out_of_reach, 0);
    assert!(sum.not_found as f64 <= 1e-4 * (sum.solved + sum.not_found) as f64);
}

/// A random arm of either family, of every kind of shoulder.
fn any_arm(sampler: &mut Sampler) -> Vec<Row> {
    let pick = |sampler: &mut Sampler, of: &[f64]| of[(of.len() as f64 * sampler.unit()) as usize];
    let any = |sampler: &mut Sampler| 0.5 + 1.2 * sampler.unit();
    let twist = |sampler: &mut Sampler| {
        let any = any(sampler);
        pick(sampler, &[FRAC_PI_2, -FRAC_PI_2, any]) + pick(sampler, &TILTS)
    };
    let length = |sampler: &mut Sampler| 0.05 + 0.5 * sampler.unit();
    let mut rows: Vec<Row> = Vec::new();
    let mut push = |a: f64, alpha: f64, d: f64, sampler: &mut Sampler| {
        rows.push([a, alpha, d, 2.0 * PI * sampler.unit() - PI, 0.0, 0.0]);
    };
    let miss = pick(sampler, &MISSES);
    if sampler.unit() < 0.3 {
        let (offset, twists) = (length(sampler), [0; 7].map(|_| twist(sampler)));
        let offset = pick(sampler, &[0.0, offset]);
        let lengths = [0; 4].map(|_| length(sampler));
        for (j, (a, d)) in [
            (miss, lengths[0]),
            (0.0, 0.0),
            (offset, lengths[1]),
            (-offset, 0.0),
            (0.0, lengths[2]),
            (miss, 0.0),
            (0.0, lengths[3]),
        ]
        .into_iter()
        .enumerate()
        {
            push(a, twists[j], d, sampler);
        }
        return rows;
    }
    let lengths = [0; 6].map(|_| length(sampler));
    let twists = [0; 5].map(|_| twist(sampler));
    let shift = pick(sampler, &[0.0, lengths[3]]);
    let parallel = pick(sampler, &[0.0, PI, 1e-9]);
    let (one, two) = match (4.0 * sampler.unit()) as u32 {
        0 => ((pick(sampler, &[0.0, lengths[0]]), twists[0]), (lengths[1], parallel)),
        1 => ((lengths[0], parallel), (lengths[1], twists[1])),
        2 => ((0.0, twists[0]), (lengths[1], twists[1])),
        _ => ((lengths[0], twists[0]), (lengths[1], twists[1])),
    };
    let fore = pick(sampler, &[0.0, lengths[4]]);
    push(one.0, one.1, lengths[2], sampler);
    push(two.0, two.1, shift, sampler);
    push(fore, twists[2], 0.0, sampler);
    push(miss, twists[3], lengths[5], sampler);
    push(-miss, twists[4], 0.0, sampler);
    push(0.0, 0.0, 0.1, sampler);
    rows
}

/// Random postures whose joints stand at their limits or a little inside, and poses as far
/// from theirs as the tolerances allow: all of them reachable.
#[test]
fn no_reachable_pose_is_proven_out_of_reach() {
    let mut sampler = Sampler(23);
    let mut counts = [Tally::default(); 2];
    for _ in 0..postures(6000) {
        let mut rows = any_arm(&mut sampler);
        let straight = sampler.unit() < 0.5;
        let posture: Vec<f64> = rows
            .iter()
            .map(|_| {
                let any = 5.0 * sampler.unit() - 2.5;
                let round =
                    [0.0, FRAC_PI_2, -FRAC_PI_2, 0.5 * any][(4.0 * sampler.unit()) as usize];
                if straight { round } else { any }
            })
            .collect();
        for (row, x) in rows.iter_mut().zip(&posture) {
            let width = [0.02, 0.3, 2.0][(3.0 * sampler.unit()) as usize];
            // Inside by nothing, hardly, or somewhere.
            let share = [0.0, 1e-9, 1e-4, sampler.unit()][(4.0 * sampler.unit()) as usize];
            let lower = x - share * width;
            (row[4], row[5]) = (lower.min(*x), (lower + width).max(*x));
            if sampler.unit() < 0.5 {
                (row[4], row[5]) = (2.0 * x - row[5], 2.0 * x - row[4]);
            }
            if straight {
                row[3] = (row[3] / FRAC_PI_2).round() * FRAC_PI_2;
            }
        }
        let chain = chain_of(&rows);
        if ClosedForm::of(&chain).is_err() {
            continue;
        }
        let size = [1e-9, 1e-6, 1e-3, 3e-2][(4.0 * sampler.unit()) as usize];
        let mut direction = || {
            let v = [0; 3].map(|_| 2.0 * sampler.unit() - 1.0);
            Vector3::from(v) / Vector3::from(v).norm().max(1e-3)
        };
        let (way, turn) = (0.99 * size * direction(), 0.99 * size * direction());
        let mut pose = pose_of(&chain, &posture);
        for i in 0..3 {
            pose[(i, 3)] += way[i];
        }
        let turned = Rotation3::from_scaled_axis(turn).into_inner() * pose.fixed_view::<3, 3>(0, 0);
        pose.fixed_view_mut::<3, 3>(0, 0).copy_from(&turned);
        let goals = rows_of(&[pose]);
        let tolerance = Tolerance { position: size, orientation: size, ..Tolerance::default() };
        let aim = Aim::new(&chain, Task::Pose, tolerance, None).expect("an aim");
        let request = Request::new(&chain, aim, Goals::Poses(&goals), Starts::Free);
        let query = Query::new(request.expect("a request"), ArmAngle::Free, Choice::Nearest);
        let query = query.expect("a closed form");
        let best = solve(&query, 1, &mut || true).expect("not interrupted");
        let every = all(&query, 1, &mut || true).expect("not interrupted");
        for status in [best.status[0], every.status[0]] {
            assert_ne!(status, Status::OutOfReach as u8, "{size} {posture:?} {rows:?}");
        }
        counts[0] = counts[0].plus(Tally::of(&best.status));
        counts[1] = counts[1].plus(Tally::of(&every.status));
    }
    println!("{counts:?}");
    assert!(counts[0].solved > counts[0].not_found);
}

/// The proofs are not there for show: of random targets without a solution most are proven.
#[test]
fn most_targets_without_a_solution_are_proven() {
    let mut sampler = Sampler(29);
    for (name, chain) in [("puma", puma()), ("redundant7", redundant7()), ("straight", straight())]
    {
        let count = postures(2000);
        let poses: Vec<_> = (0..count)
            .map(|_| {
                let q: Vec<f64> = (0..chain.dof()).map(|_| 2.0 * PI * sampler.unit()).collect();
                pose_of(&chain, &q)
            })
            .collect();
        let goals = rows_of(&poses);
        let query = query_of(&chain, &goals, Starts::Free);
        let best = solve(&query, 1, &mut || true).expect("not interrupted");
        let tally = Tally::of(&best.status);
        println!("{name} {tally:?}");
        assert!(tally.out_of_reach as f64 >= 0.97 * (tally.out_of_reach + tally.not_found) as f64);
    }
}
