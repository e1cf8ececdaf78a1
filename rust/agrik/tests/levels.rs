//! Every instruction set of this machine gives the same answers: bit for bit where the
//! roundings are the same, within tolerance and at the same success where they are not; and
//! each gives them whatever the threads and the pieces.

#[path = "common/arms.rs"]
mod arms;

use agrik::call::{Answers, Goals, Starts, Status, Tolerance, solve_at};
use agrik::chain::Chain;
use agrik::kinematics::{Workspace, tool_pose};
use agrik::lanes::Level;
use agrik::solve::{Plan, Settings};
use agrik::task::{MaskFrame, Task};
use arms::{ARMS, arm, points, poses, postures};

/// More than one run of the batch engine, and not a whole number of them.
const TARGETS: usize = 290;
/// Every step; of most few passes and attempts, since targets that are not reached have an
/// answer too.
fn all_settings() -> Vec<Settings> {
    let few = |settings| Settings { max_iterations: 12, max_restarts: 2, ..settings };
    vec![
        Settings::LEVENBERG_MARQUARDT,
        few(Settings::DAMPED),
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

fn tasks() -> [Task; 4] {
    [
        Task::Pose,
        Task::Position,
        Task::Axis { tool_axis: [1.0, 0.0, 0.0] },
        Task::Masked { weights: [1.0, 1.0, 1.0, 0.5, 0.0, 0.0], frame: MaskFrame::Tool },
    ]
}

fn available() -> Vec<Level> {
    Level::ALL.into_iter().filter(|level| level.is_available()).collect()
}

/// Reachable poses, every 50th out of reach and every 90th not a number.
fn mixed_targets(chain: &Chain) -> Vec<[f64; 16]> {
    let mut targets = poses(chain, TARGETS, 11);
    for (i, pose) in targets.iter_mut().enumerate() {
        if i % 50 == 3 {
            pose[3] += 5.0;
        }
        if i % 90 == 7 {
            pose[0] = f64::NAN;
        }
    }
    targets
}

struct Call<'a> {
    chain: &'a Chain,
    task: Task,
    settings: Settings,
    targets: &'a [[f64; 16]],
    starts: Option<&'a [f64]>,
}

impl Call<'_> {
    /// Solves the rows from `first` on, as rows of the whole.
    fn piece(&self, level: Level, threads: usize, first: usize, count: usize) -> Answers {
        let rows = &self.targets[first..first + count];
        let dof = self.chain.dof();
        let starts = self
            .starts
            .map_or(Starts::Free, |q| Starts::Each(&q[first * dof..(first + count) * dof]));
        let goals = Goals::Poses(rows);
        let request = arms::request(self.chain, self.task, Tolerance::default(), goals, starts)
            .with_seed(5, first as u64);
        let plan = Plan::new(request, self.settings.clone()).expect("settings in range");
        solve_at(level, &plan, threads, &mut || true).expect("nobody interrupts")
    }

    fn whole(&self, level: Level) -> Answers {
        self.piece(level, 1, 0, self.targets.len())
    }

    /// The whole, one call after the other with at most `size` rows each.
    fn in_pieces(&self, level: Level, threads: usize, size: usize) -> Answers {
        let mut joined = Answers::default();
        for first in (0..self.targets.len()).step_by(size) {
            let count = size.min(self.targets.len() - first);
            let part = self.piece(level, threads, first, count);
            joined.q.extend(part.q);
            joined.status.extend(part.status);
            joined.position_error.extend(part.position_error);
            joined.orientation_error.extend(part.orientation_error);
            joined.iterations.extend(part.iterations);
            joined.restarts.extend(part.restarts);
        }
        joined
    }
}

/// Fails at the first row that differs, with its number.
fn assert_identical(one: &Answers, other: &Answers, what: &str) {
    assert_eq!(one.status, other.status, "{what}: status");
    assert_eq!(one.iterations, other.iterations, "{what}: iterations");
    assert_eq!(one.restarts, other.restarts, "{what}: restarts");
    let bits = |numbers: &[f64]| numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    for (name, a, b) in [
        ("q", &one.q, &other.q),
        ("position_error", &one.position_error, &other.position_error),
        ("orientation_error", &one.orientation_error, &other.orientation_error),
    ] {
        let differs = bits(a).iter().zip(bits(b)).position(|(a, b)| *a != b);
        assert_eq!(differs, None, "{what}: {name}, the first number that differs");
    }
}

/// Gains stand on fixed axes, and coordinate descent turns towards points alone.
fn suits(settings: &Settings, task: Task) -> bool {
    match task {
        Task::Position => true,
        Task::Pose => settings.step.name() != "ccd",
        _ => !settings.plain,
    }
}

fn for_all_calls(mut check: impl FnMut(&Call<'_>, &str)) {
    for name in ARMS {
        let chain = arm(name);
        let targets = mixed_targets(&chain);
        let starts = postures(&chain, TARGETS, 12);
        for task in tasks() {
            for settings in all_settings() {
                if !suits(&settings, task) {
                    continue;
                }
                for starts in [None, Some(&starts[..])] {
                    let call = Call {
                        chain: &chain,
                        task,
                        settings: settings.clone(),
                        targets: &targets,
                        starts,
                    };
                    let step = settings.step.name();
                    check(&call, &format!("{name}, {task:?}, {step}, {}", starts.is_some()));
                }
            }
        }
    }
}

#[test]
fn levels_that_fuse_agree_bit_for_bit_and_with_lone_targets() {
    let fused: Vec<Level> =
        available().into_iter().filter(|level| *level != Level::Scalar).collect();
    for_all_calls(|call, what| {
        let Some((first, others)) = fused.split_first() else { return };
        let answers = call.whole(*first);
        for level in others {
            assert_identical(&answers, &call.whole(*level), &format!("{what}, {level:?}"));
        }
        // One and two targets are solved without lanes.
        for (level, size) in fused.iter().zip([1, 2]) {
            let lone = call.in_pieces(*level, 1, size);
            assert_identical(&answers, &lone, &format!("{what}, {level:?} by {size}"));
        }
    });
}

#[test]
fn each_level_gives_the_same_for_any_threads_and_pieces() {
    for level in available() {
        for_all_calls(|call, what| {
            // The steps share their loop: one that always ends and one that is given up.
            if !matches!(call.settings.step.name(), "lm" | "transpose") {
                return;
            }
            let answers = call.whole(level);
            let what = format!("{what}, {level:?}");
            assert_identical(&answers, &call.piece(level, 3, 0, TARGETS), &what);
            assert_identical(&answers, &call.in_pieces(level, 2, 270), &what);
        });
    }
}

#[test]
fn every_level_solves_the_same_share_within_tolerance() {
    let tolerance = Tolerance::default();
    for name in ARMS {
        let chain = arm(name);
        let targets = poses(&chain, 1000, 13);
        let mut workspace = Workspace::new(chain.compiled());
        for level in available() {
            let call = Call {
                chain: &chain,
                task: Task::Pose,
                settings: Settings::default(),
                targets: &targets,
                starts: None,
            };
            let answers = call.whole(level);
            let solved = (0..targets.len()).filter(|&row| answers.success(row)).count();
            assert!(solved >= 999, "{name}, {level:?}: {solved} of 1000 solved");
            for (row, target) in targets.iter().enumerate().filter(|(row, _)| answers.success(*row))
            {
                let q = &answers.q[row * chain.dof()..(row + 1) * chain.dof()];
                assert!(chain.within_limits(q), "{name}, {level:?}, row {row}: {q:?}");
                let pose = tool_pose(&chain, q, &mut workspace);
                let off = |k: usize| pose[(k / 4, k % 4)] - target[k];
                let away = [3, 7, 11].map(off).iter().map(|x| x * x).sum::<f64>().sqrt();
                assert!(away <= tolerance.position, "{name}, {level:?}, row {row}: {away} m");
                // |A - B| of two rotations is 2 sqrt(2) sin(angle / 2).
                let turned = [0, 1, 2, 4, 5, 6, 8, 9, 10].map(off);
                let turned = turned.iter().map(|x| x * x).sum::<f64>().sqrt() / 2f64.sqrt();
                assert!(turned <= 1.01 * tolerance.orientation, "{level:?}, row {row}: {turned}");
            }
        }
    }
}

#[test]
fn bad_and_unreachable_rows_are_the_same_at_every_level() {
    for name in ARMS {
        let chain = arm(name);
        let targets = mixed_targets(&chain);
        let settings = Settings::default();
        let call =
            Call { chain: &chain, task: Task::Pose, settings, targets: &targets, starts: None };
        for level in available() {
            let answers = call.whole(level);
            for row in 0..TARGETS {
                let status = answers.status[row];
                let expected = if row % 90 == 7 {
                    Status::BadInput
                } else if row % 50 == 3 {
                    Status::OutOfReach
                } else {
                    Status::Converged
                };
                assert_eq!(status, expected as u8, "{name}, {level:?}, row {row}");
            }
        }
    }
}

#[test]
fn points_are_solved_alike_at_every_level() {
    for name in ARMS {
        let chain = arm(name);
        let points = points(&poses(&chain, 1000, 14));
        for level in available() {
            let goals = Goals::Positions { points: &points, direction: None };
            let tolerance = Tolerance::default();
            let request = arms::request(&chain, Task::Position, tolerance, goals, Starts::Free);
            let plan = Plan::new(request, Settings::default()).unwrap();
            let answers = solve_at(level, &plan, 1, &mut || true).unwrap();
            let solved = (0..points.len()).filter(|&row| answers.success(row)).count();
            assert_eq!(solved, points.len(), "{name}, {level:?}");
        }
    }
}
