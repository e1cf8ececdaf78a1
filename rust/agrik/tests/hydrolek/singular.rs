//! The stretched planar arm with a goal on its own line: who gets stuck, who gets away.

use std::sync::Arc;

use agrik::call::{Goals, Starts, Status, Tolerance};
use agrik::solve::{GainUnits, Pid, Plan, Settings, StartRule, Step};
use agrik::task::Task;

use crate::arms::{gains, numbers, plain, planar, reference, state_space};
use crate::{common, solve};

const GOAL: [f64; 3] = [5.0, 0.0, 0.0];

fn law(solver: &str) -> Settings {
    let step = match solver {
        "jt" => Step::Transpose,
        "pinv" => Step::PseudoInverse { cutoff: 1e-9 },
        "dls_1" => Step::Damped { damping: 1.0 },
        "pid_5deg" => Step::IkPid(Pid {
            proportional: 5f64.to_radians(),
            integral: 0.0,
            derivative: 0.0,
            ..Pid::PUBLISHED
        }),
        other => {
            let name = other.strip_prefix("ss_").expect("a set");
            let set = state_space(&gains()["planar3_ss"][name], GainUnits::default());
            Step::StateSpace(Some(Arc::new(set)))
        }
    };
    plain(step, StartRule::Zero)
}

#[test]
fn statuses_iterations_and_angles_are_those_of_the_reference() {
    let chain = planar();
    for trace in reference()["planar_traces"].as_array().expect("traces") {
        let solver = trace["solver"].as_str().expect("a name");
        let answer = solve(&chain, &[GOAL], law(solver), 1e-6);
        let status = match trace["status"].as_str() {
            Some("converged") => Status::Converged,
            _ => Status::Stalled,
        };
        assert_eq!(answer.status[0], status as u8, "{solver}");
        let iterations = trace["iters"].as_u64().expect("a count");
        assert!(iterations.abs_diff(answer.iterations[0].into()) <= 1, "{solver}");
        for (got, wanted) in answer.q.iter().zip(numbers(&trace["q_deg"])) {
            assert!((got - wanted.to_radians()).abs() < 1e-9, "{solver}");
        }
    }
}

#[test]
fn a_nudge_is_enough_for_the_transpose_and_damped_steps() {
    let chain = planar();
    let nudged = |solver: &str| {
        let tolerance = Tolerance { position: 1e-6, ..Default::default() };
        let goals = Goals::Positions { points: &[GOAL], direction: None };
        let q0 = [1e-6, -2e-6, 1e-6];
        let request =
            common::arms::request(&chain, Task::Position, tolerance, goals, Starts::One(&q0));
        let plan = Plan::new(request, law(solver)).expect("settings in range");
        agrik::call::solve(&plan, 1, &mut || true).expect("answers")
    };
    for solver in ["jt", "dls_1"] {
        let answer = nudged(solver);
        assert!(answer.success(0), "{solver}");
        assert!(answer.iterations[0] < 60, "{solver}: {}", answer.iterations[0]);
    }
}
