//! One target at a time, as in a control loop, into answers that are there already and with a
//! setup made before: nothing is allocated after the first call, whatever the level, the
//! step, the task and the fate of the target.

#[path = "common/arms.rs"]
mod arms;

use agrik::call::{Aim, Answers, Goals, Starts, Status, Tolerance, solve_at, solve_into};
use agrik::chain::Chain;
use agrik::lanes::Level;
use agrik::solve::{Plan, Settings, Setup};
use agrik::task::{MaskFrame, Task};
use allocation_counter::measure;
use arms::{ARMS, arm, points, poses, postures};

const TARGETS: usize = 40;

fn all_settings() -> Vec<Settings> {
    let few = |settings| Settings { max_iterations: 12, max_restarts: 2, ..settings };
    vec![
        Settings::LEVENBERG_MARQUARDT,
        Settings::DAMPED,
        few(Settings::PSEUDO_INVERSE),
        few(Settings::CLOSED_PSEUDO_INVERSE),
        few(Settings::TRANSPOSE),
        few(Settings::DESCENT),
        few(Settings::IK_PID),
        few(Settings::STATE_SPACE),
        few(Settings::STATIC_GAIN),
        few(Settings::BROYDEN),
    ]
}

fn suits(settings: &Settings, task: Task) -> bool {
    matches!(task, Task::Position)
        || !settings.plain && (settings.step.name() != "ccd" || task == Task::Pose)
}

/// Solves each target on its own and returns how many of each status there were.
fn one_by_one(
    level: Level,
    chain: &Chain,
    task: Task,
    settings: &Settings,
    targets: &[[f64; 16]],
    starts: Option<&[f64]>,
    answers: &mut Answers,
) -> [usize; 6] {
    let points = points(targets);
    let mut counts = [0; 6];
    let aim = Aim::new(chain, task, Tolerance::default(), None).expect("a task in range");
    let setup = Setup::new(chain, aim, settings.clone()).expect("settings in range");
    let mut measured = Vec::new();
    for (row, point) in points.iter().enumerate() {
        let allocated = measure(|| {
            let goals = if task == Task::Position {
                Goals::Positions { points: std::slice::from_ref(point), direction: None }
            } else {
                Goals::Poses(&targets[row..=row])
            };
            let starts = starts.map_or(Starts::Free, |q| {
                Starts::One(&q[row * chain.dof()..(row + 1) * chain.dof()])
            });
            let plan = setup.plan(chain, goals, starts, 7, 0).expect("targets that fit");
            solve_into(level, &plan, 1, answers, &mut || true).expect("nobody interrupts");
        });
        measured.push(allocated.count_total);
        counts[usize::from(answers.status[0])] += 1;
    }
    let allocating = measured.iter().filter(|count| **count > 0).count();
    // Where nobody says where the arm stands, answers at a limit are looked for elsewhere.
    let most = if starts.is_none() { TARGETS / 4 } else { 0 };
    assert!(allocating <= most, "{level:?}, {task:?}, {}: {measured:?}", settings.step.name());
    counts
}

#[test]
fn the_counting_itself() {
    let made = measure(|| drop(std::hint::black_box(vec![0.0; 100])));
    assert_eq!((made.count_total, made.count_current), (1, 0));
}

#[test]
fn a_single_target_allocates_nothing_after_the_first_call() {
    let tasks = [
        Task::Pose,
        Task::Position,
        Task::Axis { tool_axis: [1.0, 0.0, 0.0] },
        Task::Masked { weights: [1.0, 1.0, 1.0, 0.5, 0.0, 0.0], frame: MaskFrame::Tool },
    ];
    for name in ARMS {
        let chain = arm(name);
        let mut targets = poses(&chain, TARGETS, 31);
        targets[3][3] += 5.0;
        targets[4][3] = f64::NAN;
        let starts = postures(&chain, TARGETS, 32);
        for level in Level::ALL.into_iter().filter(|level| level.is_available()) {
            for task in tasks {
                for settings in all_settings() {
                    if !suits(&settings, task) {
                        continue;
                    }
                    // The first call may make tables that the chain keeps.
                    let goals = Goals::Poses(&targets[..1]);
                    let tolerance = Tolerance::default();
                    let first = arms::request(&chain, Task::Pose, tolerance, goals, Starts::Free);
                    let first = Plan::new(first, Settings::default()).expect("settings in range");
                    let mut answers =
                        solve_at(level, &first, 1, &mut || true).expect("nobody interrupts");
                    for starts in [None, Some(&starts[..])] {
                        let counts = one_by_one(
                            level,
                            &chain,
                            task,
                            &settings,
                            &targets,
                            starts,
                            &mut answers,
                        );
                        assert_eq!(counts[Status::OutOfReach as usize], 1);
                        assert_eq!(counts[Status::BadInput as usize], 1);
                        if settings.step.name() == "lm" {
                            assert_eq!(counts[Status::Converged as usize], TARGETS - 2);
                        }
                    }
                }
            }
        }
    }
}
