//! Questions to a call's guard: several postures in one, and every answer what it is alone.

#[path = "common/arms.rs"]
mod arms;

use std::sync::atomic::{AtomicUsize, Ordering};

use agrik::call::{
    Accept, Answers, Goals, Guard, Prefer, Starts, Status, TOGETHER, Tolerance, solve_at,
};
use agrik::chain::Chain;
use agrik::lanes::{Lanes, Level};
use agrik::solve::Settings;
use agrik::solvers::Solver;
use agrik::task::Task;
use arms::{ARMS, arm, points, poses, postures, request};

/// Accepts about every third posture, and counts what it is asked.
#[derive(Debug, Default)]
struct Picky {
    dof: usize,
    questions: AtomicUsize,
    postures: AtomicUsize,
}

impl Accept for Picky {
    fn accepts(&self, q: &[f64]) -> Lanes {
        let rows = q.len() / self.dof;
        assert!((1..=TOGETHER).contains(&rows));
        self.questions.fetch_add(1, Ordering::Relaxed);
        self.postures.fetch_add(rows, Ordering::Relaxed);
        let each = q.chunks(self.dof).enumerate();
        each.fold(0, |all, (i, q)| all | Lanes::from(self.margin(q, 9.0) > 0.0) << i)
    }

    fn margin(&self, q: &[f64], cap: f64) -> f64 {
        let sum: f64 = q.iter().map(|x| 5.0 * x).sum();
        (sum.rem_euclid(3.0) - 2.0).min(cap)
    }

    fn slope(&self, q: &[f64], rates: &mut [f64]) -> f64 {
        rates.fill(0.0);
        self.margin(q, 9.0)
    }

    fn is_way_sure(&self, _: &[f64], _: &[f64]) -> bool {
        false
    }
}

fn ask(
    level: Level,
    (chain, accept, prefer): (&Chain, &Picky, Prefer),
    (goals, starts): (Goals<'_>, Starts<'_>),
    first: usize,
) -> Answers {
    let task = if matches!(goals, Goals::Poses(_)) { Task::Pose } else { Task::Position };
    let request = request(chain, task, Tolerance::default(), goals, starts);
    let request = request.with_seed(5, first as u64).with_guard(Guard { accept, prefer });
    // Few enough that some targets end refused, others with no end at all.
    let settings = Settings { max_restarts: 6, max_iterations: 12, ..Settings::default() };
    let call = Solver::Step(settings).call(request).expect("fits");
    solve_at(level, &call, 1, &mut || true).expect("nobody interrupts")
}

fn bits(answers: &Answers, rows: std::ops::Range<usize>, dof: usize) -> Vec<Vec<u64>> {
    let of = |i: usize| {
        let q = answers.q[i * dof..(i + 1) * dof].iter();
        let q = q.chain([&answers.position_error[i], &answers.orientation_error[i]]);
        let told = [u32::from(answers.status[i]), answers.iterations[i], answers.restarts[i]];
        q.map(|x| x.to_bits()).chain(told.map(u64::from)).collect()
    };
    rows.map(of).collect()
}

/// Holds all rows of a call against calls for some of them.
fn compare_parts(level: Level, chain: &Chain, prefer: Prefer, goals: Goals<'_>, starts: &[f64]) {
    let dof = chain.dof();
    let accept = Picky { dof, ..Picky::default() };
    let part = |first: usize, count: usize| {
        let own = match starts {
            [] => Starts::Free,
            all => Starts::Each(&all[first * dof..(first + count) * dof]),
        };
        let goals = match goals {
            Goals::Poses(poses) => Goals::Poses(&poses[first..first + count]),
            Goals::Positions { points, direction } => {
                Goals::Positions { points: &points[first..first + count], direction }
            }
        };
        ask(level, (chain, &accept, prefer), (goals, own), first)
    };
    let all = part(0, 90);
    let ended = |status| all.status.iter().filter(|s| **s == status as u8).count();
    assert!(ended(Status::Converged) > 20 && ended(Status::InCollision) > 0);
    for count in [1, 2, 9, 45] {
        for first in (0..90).step_by(count) {
            let same = bits(&part(first, count), 0..count, dof);
            assert_eq!(same, bits(&all, first..first + count, dof), "{first} {count}");
        }
    }
    for (q, status) in all.q.chunks(dof).zip(&all.status) {
        assert!(*status != Status::Converged as u8 || accept.margin(q, 1.0) > 0.0);
        assert!(*status != Status::InCollision as u8 || accept.margin(q, 1.0) <= 0.0);
    }
}

#[test]
fn what_others_are_asked_about_changes_no_answer() {
    for name in ARMS {
        let chain = arm(name);
        let (poses, starts) = (poses(&chain, 90, 1), postures(&chain, 90, 2));
        let points = points(&poses);
        for level in Level::ALL.into_iter().filter(|level| level.is_available()) {
            for (_, prefer) in Prefer::ALL {
                let places = Goals::Positions { points: &points, direction: None };
                compare_parts(level, &chain, prefer, Goals::Poses(&poses), &[]);
                compare_parts(level, &chain, prefer, places, &starts);
            }
        }
    }
}

#[test]
fn a_batch_asks_about_many_postures_at_a_time() {
    let chain = arm("redundant7");
    let targets = poses(&chain, 600, 4);
    let accept = Picky { dof: chain.dof(), ..Picky::default() };
    let asked = (&chain, &accept, Prefer::First);
    let goals = Goals::Poses(&targets);
    let answers = ask(Level::in_use(), asked, (goals, Starts::Free), 0);
    assert!(answers.status.contains(&(Status::Converged as u8)));
    let questions = accept.questions.load(Ordering::Relaxed);
    let postures = accept.postures.load(Ordering::Relaxed);
    assert!(postures > 900, "{postures}");
    assert!(8 * questions < postures, "{questions} questions about {postures} postures");
}
