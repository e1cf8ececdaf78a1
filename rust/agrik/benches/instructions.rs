//! One call of the solver for `make callgrind`, which counts its instructions.
//!
//! Arguments: robot, task (pose, position, or evolution: poses by the published differential
//! evolution), number of targets. The instruction set is the environment's, `AGRIK_SIMD`. Prints what was solved; only [`measured`] is counted, so the
//! program's start and the making of targets are not.

mod common;

use std::hint::black_box;
use std::process::ExitCode;

use agrik::call::{Answers, Goals, Solve, Starts, Tolerance, solve};
use agrik::lanes::Level;
use agrik::solve::population::{Evolution, Settings};
use agrik::solve::{Plan, Settings as StepSettings};
use agrik::task::Task;
use common::arms::{arm, points, poses, request};

/// The counted call; `benches/instructions.py` knows it by this name.
#[inline(never)]
fn measured(call: &impl Solve) -> Option<Answers> {
    solve(black_box(call), 1, &mut || true).ok()
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let [robot, task, count] = &words[..] else {
        eprintln!("usage: instructions ROBOT pose|position|evolution TARGETS");
        return ExitCode::from(2);
    };
    let Ok(count) = count.parse() else {
        eprintln!("instructions: '{count}' is no number of targets");
        return ExitCode::from(2);
    };
    let chain = arm(robot);
    let poses = poses(&chain, count, 6);
    let points = points(&poses);
    let (wanted, goals) = if task == "position" {
        (Task::Position, Goals::Positions { points: &points, direction: None })
    } else {
        (Task::Pose, Goals::Poses(&poses))
    };
    let request = request(&chain, wanted, Tolerance::default(), goals, Starts::Free);
    let answers = match task.as_str() {
        "evolution" => {
            Evolution::new(request, Settings::PUBLISHED).ok().and_then(|search| measured(&search))
        }
        _ => Plan::new(request, StepSettings::default()).ok().and_then(|plan| measured(&plan)),
    };
    let Some(answers) = answers else { return ExitCode::FAILURE };
    let solved = (0..answers.len()).filter(|&row| answers.success(row)).count();
    println!("level {} solved {solved} of {count}", Level::in_use().name());
    ExitCode::SUCCESS
}
