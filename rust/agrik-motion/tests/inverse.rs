//! Inverse kinematics that keeps clear, of every solver, checked beside it: poses by products of
//! matrices, distances of every body from every solid of the scene.
#![allow(clippy::unwrap_used)]

mod common;

use std::sync::Arc;

use agrik::call::{Aim, Answers, Goals, Guard, Prefer, Request, Starts, Status, Tolerance, solve};
use agrik::chain::{Chain, DhConvention, DhRow, JointKind};
use agrik::kinematics::tool_poses;
use agrik::solvers::Solver;
use agrik::task::Task;
use agrik_motion::{Bodies, Body, Collider, Free};
use agrik_solids::{Object, Point, Pose, Scene, Solid, distance};
use common::{collider, random_postures};
use nalgebra::IsometryMatrix3;

/// What a posture is nearest to, worked out without the tree, lanes or compiled chain: the
/// distance from the scene, and that of the arm from itself.
fn plain_distances(collider: &Collider, q: &[f64]) -> (f64, f64) {
    let bodies = collider.bodies();
    let chain = bodies.chain();
    let poses = chain.link_poses(q);
    let base = chain.base().to_homogeneous();
    let placed: Vec<Solid> = bodies
        .bodies()
        .iter()
        .map(|body| {
            let m = if body.frame == 0 { base } else { poses[body.frame - 1] };
            let row = |k: usize| [m[(k, 0)], m[(k, 1)], m[(k, 2)]];
            let pose = Pose {
                rotation: [row(0), row(1), row(2)],
                translation: [m[(0, 3)], m[(1, 3)], m[(2, 3)]],
            };
            let agrik_motion::Shape::Exact(solid) = &body.shape else { unreachable!() };
            solid.placed(&pose)
        })
        .collect();
    let mut scene = f64::INFINITY;
    for (b, body) in placed.iter().enumerate().filter(|(b, _)| bodies.bodies()[*b].frame > 0) {
        let name = &bodies.bodies()[b].name;
        for object in collider.scene().objects().iter().filter(|o| !is_exempt(name, &o.name)) {
            for solid in &object.solids {
                scene = scene.min(distance(body, solid));
            }
            for [x, y, z, r] in object.clouds.iter().flat_map(|cloud| cloud.spheres()) {
                scene = scene.min(distance(body, &Solid::sphere([x, y, z], r).unwrap()));
            }
        }
    }
    let pairs = bodies.self_pairs().iter();
    let own = pairs.map(|(i, j)| distance(&placed[*i], &placed[*j])).fold(f64::INFINITY, f64::min);
    (scene, own)
}

/// What one arm of the data does not mind.
fn is_exempt(body: &str, object: &str) -> bool {
    ["base", "shoulder"].contains(&body) && ["slide", "vehicle"].contains(&object)
}

/// An arm of standard rows with a capsule along each link.
fn of_rows(name: &str, rows: &[[f64; 3]], limit: f64, thick: f64) -> Arc<Bodies> {
    let joints = rows.iter().enumerate().map(|(i, &[a, alpha, d])| {
        let row = DhRow { a, alpha: alpha.to_radians(), d, theta: 0.0 };
        let name = format!("q{}", i + 1);
        row.joint(DhConvention::Standard, name, JointKind::Revolute, -limit, limit)
    });
    let here = IsometryMatrix3::identity();
    let chain = Arc::new(Chain::new(name, joints.collect(), here, here, None).unwrap());
    let mut bodies = Vec::new();
    for (i, &[a, alpha, d]) in rows.iter().enumerate() {
        // From the origin of a frame back along its link.
        let (s, c) = alpha.to_radians().sin_cos();
        let back: Point = [-a, -d * s, -d * c];
        if a != 0.0 || d != 0.0 {
            let link = Solid::capsule([0.0; 3], back, thick).unwrap();
            bodies.push(Body::new(format!("link{}", i + 1), i + 1, link));
        }
    }
    Arc::new(Bodies::new(chain, bodies, None).unwrap())
}

/// A wall with posts in front of it, on a floor.
fn posts() -> Arc<Scene> {
    let post = |i: usize, x: f64, y: f64| {
        let solid = Solid::capsule([x, y, 0.0], [x, y, 1.2], 0.04).unwrap();
        Object::new(format!("post{i}"), "post").with(solid)
    };
    let floor = agrik_solids::HalfSpace::new([0.0, 0.0, 1.0], -0.15).unwrap();
    let wall = agrik_solids::Cuboid::upright([0.7, 0.0, 0.5], [0.02, 1.0, 0.6]).unwrap();
    Arc::new(
        Scene::new(vec![
            post(1, 0.35, 0.3),
            post(2, 0.4, -0.25),
            post(3, -0.45, 0.1),
            Object::new("floor", "ground").with(floor),
            Object::new("wall", "wall").with(wall),
        ])
        .unwrap(),
    )
}

fn redundant7() -> Collider {
    let rows = [
        [0.0, -90.0, 0.34],
        [0.0, 90.0, 0.0],
        [0.0, -90.0, 0.4],
        [0.0, 90.0, 0.0],
        [0.0, -90.0, 0.4],
        [0.0, 90.0, 0.0],
        [0.0, 0.0, 0.126],
    ];
    Collider::new(of_rows("redundant7", &rows, 2.09, 0.05), posts(), &[], None).unwrap()
}

fn ur5() -> Collider {
    let rows = [
        [0.0, 90.0, 0.089159],
        [-0.425, 0.0, 0.0],
        [-0.39225, 0.0, 0.0],
        [0.0, 90.0, 0.10915],
        [0.0, -90.0, 0.09465],
        [0.0, 0.0, 0.0823],
    ];
    Collider::new(of_rows("ur5", &rows, 3.1, 0.04), posts(), &[], None).unwrap()
}

fn puma() -> Collider {
    let rows = [
        [0.0, 90.0, 0.6718],
        [0.4318, 0.0, 0.0],
        [0.0203, -90.0, 0.15005],
        [0.0, 90.0, 0.4318],
        [0.0, -90.0, 0.0],
        [0.0, 0.0, 0.0],
    ];
    Collider::new(of_rows("puma560", &rows, 2.6, 0.04), posts(), &[], None).unwrap()
}

/// Poses of postures that keep clear, with the postures.
fn targets(collider: &Collider, count: usize, clear: f64) -> (Vec<f64>, Vec<[f64; 16]>) {
    let chain = collider.bodies().chain();
    let q = random_postures(chain, 40 * count, 11);
    let hits = collider.collides(&q, clear, 1, &mut || true).unwrap();
    let free: Vec<f64> = q
        .chunks(chain.dof())
        .zip(hits)
        .filter(|(_, hit)| !hit)
        .take(count)
        .flat_map(|(q, _)| q)
        .copied()
        .collect();
    let mut poses = vec![0.0; free.len() / chain.dof() * 16];
    tool_poses(chain, &free, &mut poses);
    (free, poses.as_chunks().0.to_vec())
}

#[derive(Clone)]
struct Asked<'a> {
    collider: &'a Collider,
    solver: Solver,
    task: Task,
    prefer: Prefer,
    clear: f64,
    threads: usize,
}

impl<'a> Asked<'a> {
    fn new(collider: &'a Collider, solver: Solver) -> Self {
        let prefer = Prefer::First;
        Self { collider, solver, task: Task::Pose, prefer, clear: 0.0, threads: 1 }
    }

    fn ask(&self, poses: &[[f64; 16]], starts: Starts<'_>) -> Answers {
        let chain = self.collider.bodies().chain();
        let aim = Aim::new(chain, self.task, Tolerance::default(), None).unwrap();
        let request = Request::new(chain, aim, Goals::Poses(poses), starts).unwrap();
        let accept = Free::new(self.collider, self.clear).unwrap();
        let guard = Guard { accept: &accept, prefer: self.prefer };
        let call = self.solver.call(request.with_guard(guard)).unwrap();
        solve(&call, self.threads, &mut || true).unwrap()
    }

    /// Asks, checks every answer by other means, and returns the share of free ones.
    fn checked(&self, poses: &[[f64; 16]]) -> (f64, Answers) {
        let answers = self.ask(poses, Starts::Free);
        let chain = self.collider.bodies().chain();
        let mut free = 0;
        for (row, (q, pose)) in answers.q.chunks(chain.dof()).zip(poses).enumerate() {
            let found = chain.link_poses(q).pop().unwrap();
            let off = (0..3).map(|k| (found[(k, 3)] - pose[4 * k + 3]).powi(2)).sum::<f64>().sqrt();
            let (scene, own) = plain_distances(self.collider, q);
            let status = answers.status[row];
            if status == Status::Converged as u8 {
                assert!(off < 1.1e-6 && chain.within_limits(q), "row {row}: {off}");
                assert!(scene > self.clear - 1e-12 && own > -1e-12, "row {row}: {scene}, {own}");
                free += 1;
            } else if status == Status::InCollision as u8 {
                assert!(off < 1.1e-6 && chain.within_limits(q), "row {row}: {off}");
                assert!(scene <= self.clear + 1e-12 || own <= 1e-12, "row {row}: {scene}, {own}");
            }
        }
        (f64::from(free) / poses.len() as f64, answers)
    }
}

#[test]
fn targets_of_free_postures_are_reached_freely() {
    let arms = [
        ("panda bench", collider("panda", "bench")),
        ("panda wall", collider("panda", "wall")),
        ("panda greenhouse5", collider("panda", "greenhouse5")),
        ("cucumber scene", collider("cucumber", "scene")),
        ("cucumber greenhouse1", collider("cucumber", "greenhouse1")),
        ("redundant7", redundant7()),
        ("ur5", ur5()),
    ];
    for (name, collider) in &arms {
        let (_, poses) = targets(collider, 300, 0.0);
        assert_eq!(poses.len(), 300, "{name}");
        for solver in [Solver::default(), Solver::Auto] {
            let (free, _) = Asked::new(collider, solver).checked(&poses);
            assert_eq!(free, 1.0, "{name}");
        }
    }
}

#[test]
fn every_solver_and_task_keeps_clear() {
    let collider = collider("panda", "bench");
    let (_, poses) = targets(&collider, 40, 0.0);
    let names = ["dls", "pinv", "de", "ga"];
    for name in names {
        let (free, _) = Asked::new(&collider, Solver::named(name).unwrap()).checked(&poses[..10]);
        assert!(free >= 0.9, "{name}: {free}");
    }
    // The others are for places alone, and may end elsewhere.
    for name in ["transpose", "ccd", "ik-pid", "state-space", "static-gain", "broyden"] {
        let asked =
            Asked { task: Task::Position, ..Asked::new(&collider, Solver::named(name).unwrap()) };
        let (free, _) = asked.checked(&poses);
        assert!(free > 0.5, "{name}: {free}");
    }
    for task in [
        Task::Position,
        Task::Axis { tool_axis: [0.0, 0.0, 1.0] },
        Task::Masked {
            weights: [1.0, 1.0, 1.0, 1.0, 1.0, 0.0],
            frame: agrik::task::MaskFrame::Tool,
        },
    ] {
        let (free, _) = Asked { task, ..Asked::new(&collider, Solver::default()) }.checked(&poses);
        assert_eq!(free, 1.0, "{task:?}");
    }
}

#[test]
fn closed_forms_choose_among_their_branches() {
    for (name, collider) in [("puma560", puma()), ("redundant7", redundant7())] {
        let (_, poses) = targets(&collider, 200, 0.0);
        for prefer in [Prefer::First, Prefer::Near, Prefer::Clearance] {
            let solver = Solver::named(Solver::CLOSED_FORM).unwrap();
            let asked = Asked { prefer, ..Asked::new(&collider, solver) };
            let (free, answers) = asked.checked(&poses);
            // A branch is free of every target, but of a free arm angle those looked at may
            // miss the place.
            assert!(free >= if name == "puma560" { 1.0 } else { 0.97 }, "{name}: {free}");
            for threads in [2, 3] {
                assert_eq!(Asked { threads, ..asked.clone() }.ask(&poses, Starts::Free), answers);
            }
        }
    }
}

#[test]
fn preferences_are_met() {
    let collider = collider("panda", "greenhouse5");
    let (_, poses) = targets(&collider, 60, 0.0);
    let chain = collider.bodies().chain();
    let middle: Vec<f64> = chain.variables().iter().map(|v| v.middle()).collect();
    let of = |prefer| {
        let asked = Asked { prefer, ..Asked::new(&collider, Solver::default()) };
        let (free, answers) = asked.checked(&poses);
        assert_eq!(free, 1.0);
        let away = |q: &[f64]| q.iter().zip(&middle).map(|(x, m)| (x - m).powi(2)).sum::<f64>();
        let near = answers.q.chunks(7).map(away).sum::<f64>() / poses.len() as f64;
        let clear = collider.clearances(&answers.q, 0.5, true, 1, &mut || true).unwrap();
        (near, clear.iter().sum::<f64>() / clear.len() as f64)
    };
    let (first, near, clear) = (of(Prefer::First), of(Prefer::Near), of(Prefer::Clearance));
    assert!(near.0 < 0.9 * first.0 && near.0 < clear.0, "{first:?} {near:?} {clear:?}");
    assert!(clear.1 > 1.15 * first.1 && clear.1 > 1.15 * near.1, "{first:?} {near:?} {clear:?}");
}

#[test]
fn distances_that_are_asked_for_are_kept() {
    let collider = collider("panda", "bench");
    let (_, poses) = targets(&collider, 100, 0.03);
    let asked = Asked { clear: 0.03, ..Asked::new(&collider, Solver::default()) };
    let (free, _) = asked.checked(&poses);
    assert_eq!(free, 1.0);
    assert!(Free::new(&collider, -0.1).is_err() && Free::new(&collider, f64::NAN).is_err());
}

#[test]
fn what_cannot_be_free_says_so_with_the_least_bad_posture() {
    // A ball round the place of the hand: every posture that reaches it is inside.
    let panda = collider("panda", "bench");
    let (_, poses) = targets(&panda, 5, 0.0);
    let ball = |pose: &[f64; 16]| {
        let at = [pose[3], pose[7], pose[11]];
        Object::new("ball", "ball").with(Solid::sphere(at, 0.1).unwrap())
    };
    for pose in &poses {
        let scene = Arc::new(Scene::new(vec![ball(pose)]).unwrap());
        let collider = Collider::new(Arc::clone(panda.bodies()), scene, &[], None).unwrap();
        for solver in [Solver::default(), Solver::Auto, Solver::named("de").unwrap()] {
            let (free, answers) = Asked::new(&collider, solver).checked(std::slice::from_ref(pose));
            assert_eq!((free, answers.status[0]), (0.0, Status::InCollision as u8));
            assert!(answers.position_error[0] < 1e-6);
            assert!(!answers.success(0));
        }
    }
    // Out of reach stays out of reach, and bad input bad.
    let mut far = poses[0];
    far[3] = 9.0;
    let mut bad = poses[0];
    bad[7] = f64::NAN;
    for solver in [Solver::default(), Solver::Auto] {
        let answers = Asked::new(&panda, solver).ask(&[far, bad], Starts::Free);
        assert_eq!(answers.status, [Status::OutOfReach as u8, Status::BadInput as u8]);
    }
}

#[test]
fn answers_are_the_same_for_any_threads_slices_and_no_guard_at_all() {
    for collider in [collider("panda", "bench"), collider("cucumber", "scene"), redundant7()] {
        let (q, poses) = targets(&collider, 150, 0.0);
        let dof = collider.bodies().chain().dof();
        for (solver, prefer) in [
            (Solver::default(), Prefer::First),
            (Solver::default(), Prefer::Clearance),
            (Solver::Auto, Prefer::Near),
        ] {
            let asked = Asked { prefer, ..Asked::new(&collider, solver) };
            let all = asked.ask(&poses[..40], Starts::Free);
            for threads in [2, 7] {
                let same = Asked { threads, ..asked.clone() };
                assert_eq!(same.ask(&poses[..40], Starts::Free), all);
            }
            // From a free posture that reaches the target there is nothing to do.
            if prefer != Prefer::Clearance {
                let near = asked.ask(&poses[..40], Starts::Each(&q[..40 * dof]));
                assert!((0..40).all(|row| near.success(row)));
            }
        }
        // What is accepted anyway is answered as without a guard.
        let empty = Arc::new(Scene::new(Vec::new()).unwrap());
        let chain = collider.bodies().chain();
        let nothing = Arc::new(Bodies::new(Arc::clone(chain), Vec::new(), None).unwrap());
        let nothing = Collider::new(nothing, empty, &[], None).unwrap();
        // Of an arm on a slide `auto` sweeps the slide only where nothing is to be kept clear of.
        let same = if chain.name() == "redundant7" { 2 } else { 1 };
        for solver in [Solver::default(), Solver::Auto].into_iter().take(same) {
            let with = Asked::new(&nothing, solver.clone()).ask(&poses, Starts::Free);
            let aim = Aim::new(chain, Task::Pose, Tolerance::default(), None).unwrap();
            let request = Request::new(chain, aim, Goals::Poses(&poses), Starts::Free).unwrap();
            let plain = solve(&solver.call(request).unwrap(), 1, &mut || true).unwrap();
            assert_eq!(with, plain);
        }
    }
}
