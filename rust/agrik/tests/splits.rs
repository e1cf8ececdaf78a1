//! A target gets the same bits alone, in a batch and in any piece of one: on random chains
//! (continuous, prismatic and mimic joints), for every solver and task, with starts far off.

mod common;

use agrik::call::{Aim, Answers, Goals, Request, Starts, Tolerance, solve_at};
use agrik::chain::{Chain, JointKind};
use agrik::lanes::Level;
use agrik::solve::{Settings, population};
use agrik::solvers::Solver;
use agrik::task::{MaskFrame, Task};
use common::random_chain::chain;
use common::{Sampler, plain_poses, random_q};
use proptest::prelude::*;

/// More than the lanes of any vector, and not a multiple of them.
const ROWS: usize = 19;

/// Every solver, with caps that also end attempts of reachable targets: what a row does after
/// its first attempt is where company could matter.
fn solvers() -> Vec<Solver> {
    let few = |solver| match solver {
        Solver::Step(settings) => {
            Solver::Step(Settings { max_iterations: 9, max_restarts: 4, ..settings })
        }
        Solver::Population(settings) => Solver::Population(population::Settings {
            population: 12,
            generations: 3,
            max_restarts: 1,
            ..settings
        }),
        other => other,
    };
    Solver::names().filter_map(Solver::named).map(few).collect()
}

fn tasks() -> [Task; 6] {
    let weights = [1.0, 0.5, 1.0, 0.0, 0.0, 2.0];
    [
        Task::Position,
        Task::Pose,
        Task::Axis { tool_axis: [0.6, 0.0, 0.8] },
        Task::Masked { weights, frame: MaskFrame::Tool },
        Task::Masked { weights, frame: MaskFrame::Base },
        Task::PositionFirst,
    ]
}

/// Poses of the chain, one in three moved out of the way, and starts for each: near, or some
/// turns and then more turns than a number resolves well away.
fn targets_and_starts(chain: &Chain, seed: u64) -> (Vec<[f64; 16]>, Vec<f64>) {
    let mut sampler = Sampler(seed);
    let mut poses = Vec::new();
    let mut starts = Vec::new();
    for row in 0..ROWS {
        let q = random_q(chain, &mut sampler);
        let pose = plain_poses(chain, &q).pop().expect("a chain has a tool");
        let mut pose: [f64; 16] = std::array::from_fn(|i| pose[(i / 4, i % 4)]);
        if row % 3 == 1 {
            for i in [3, 7, 11] {
                pose[i] += 0.6 * sampler.unit();
            }
        }
        poses.push(pose);
        let away = [0.2, 40.0, 1e6, 1e17][row % 4];
        let far = |(x, v): (f64, &agrik::chain::Variable)| {
            let way = if v.kind == JointKind::Prismatic { 0.2 } else { away };
            x + way * (2.0 * sampler.unit() - 1.0)
        };
        let near: Vec<f64> = q.into_iter().zip(chain.variables()).map(far).collect();
        starts.extend(near);
    }
    (poses, starts)
}

/// Rows from `first` on as a call of their own; nothing where the solver refuses.
fn piece(
    level: Level,
    (chain, task, solver): (&Chain, Task, &Solver),
    (poses, starts): (&[[f64; 16]], Option<&[f64]>),
    (first, count): (usize, usize),
) -> Option<Answers> {
    let dof = chain.dof();
    let goals = Goals::Poses(&poses[first..first + count]);
    let starts =
        starts.map_or(Starts::Free, |q| Starts::Each(&q[first * dof..(first + count) * dof]));
    let aim = Aim::new(chain, task, Tolerance::default(), None).expect("in range");
    let request = Request::new(chain, aim, goals, starts).expect("fits").with_seed(3, first as u64);
    let call = solver.call(request).ok()?;
    Some(solve_at(level, &call, 1, &mut || true).expect("nobody interrupts"))
}

fn bits(answers: &Answers, row: usize, dof: usize) -> Vec<u64> {
    let numbers = answers.q[row * dof..(row + 1) * dof].iter();
    let numbers = numbers.chain([&answers.position_error[row], &answers.orientation_error[row]]);
    let counts = [u64::from(answers.status[row]), u64::from(answers.iterations[row])];
    let all = numbers.map(|x| x.to_bits()).chain(counts);
    all.chain([u64::from(answers.restarts[row])]).collect()
}

fn levels() -> impl Iterator<Item = Level> {
    Level::ALL.into_iter().filter(|level| level.is_available())
}

/// Compares every row of a call with the same row in pieces of it.
fn compare_pieces(
    level: Level,
    (chain, task, solver): (&Chain, Task, &Solver),
    (poses, starts): (&[[f64; 16]], Option<&[f64]>),
    sizes: &[usize],
) -> Result<(), TestCaseError> {
    let (call, targets) = ((chain, task, solver), (poses, starts));
    let Some(whole) = piece(level, call, targets, (0, ROWS)) else { return Ok(()) };
    for size in sizes {
        for first in (0..ROWS).step_by(*size) {
            let count = (*size).min(ROWS - first);
            let part = piece(level, call, targets, (first, count)).expect("as the whole");
            for row in 0..count {
                prop_assert_eq!(
                    bits(&part, row, chain.dof()),
                    bits(&whole, first + row, chain.dof()),
                    "row {} in pieces of {}, {:?}, {:?}, starts {}, {}",
                    first + row,
                    size,
                    solver,
                    task,
                    starts.is_some(),
                    level.name()
                );
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 12,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn company_changes_nothing(chain in chain(), seed in any::<u64>()) {
        let (poses, starts) = targets_and_starts(&chain, seed);
        for (i, solver) in solvers().into_iter().enumerate() {
            // Two tasks a solver, others for each chain.
            for task in tasks().into_iter().cycle().skip((seed as usize % 6) + i).take(2) {
                for starts in [None, Some(&starts[..])] {
                    for level in levels() {
                        let targets = (&poses[..], starts);
                        compare_pieces(level, (&chain, task, &solver), targets, &[1, 7])?;
                    }
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 200,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// Rows at a limit look for other solutions together, and draw numbers on the way.
    #[test]
    fn rows_at_limits_look_elsewhere_each_for_itself(chain in chain(), seed in any::<u64>()) {
        let (poses, _) = targets_and_starts(&chain, seed);
        let solver = solvers().into_iter().find(|solver| {
            matches!(solver, Solver::Step(settings) if settings.step.name() == "pinv-closed")
        });
        let call = (&chain, Task::PositionFirst, &solver.expect("a solver of that name"));
        compare_pieces(Level::Scalar, call, (&poses, None), &[7])?;
    }
}
