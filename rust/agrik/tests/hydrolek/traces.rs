//! Status, iterations and joint values of `reference.json`.

use std::sync::Arc;

use agrik::call::Status;
use agrik::solve::{Pid, StartRule, Step};

use crate::arms::{
    from_paper, gains, hydrolek, numbers, paper_units, plain, reference, state_space,
};
use crate::solve;

fn step(solver: &str) -> Step {
    let gains = gains();
    let name = match solver {
        "jt" => return Step::Transpose,
        "dls_lambda_200mm" => return Step::Damped { damping: 0.2 },
        "pid_tuned_deg_per_mm" => return Step::IkPid(Pid::PUBLISHED),
        "ss_trial_deg_per_cm" => "trial_published",
        other => other.strip_prefix("ss_").expect("a solver"),
    };
    let set = state_space(&gains["hydrolek_ss"][name], paper_units(0.01));
    Step::StateSpace(Some(Arc::new(set)))
}

#[test]
fn all_traces_are_repeated() {
    let chain = hydrolek();
    let reference = reference();
    let traces = reference["traces"].as_array().expect("traces");
    assert_eq!(traces.len(), 42);
    for trace in traces {
        let solver = trace["solver"].as_str().expect("a name");
        let start = match trace["start"].as_str() {
            Some("zero") => StartRule::Zero,
            _ => StartRule::Middle,
        };
        let goal = from_paper(&numbers(&trace["goal_paper_mm"]));
        let answer = solve(&chain, &[goal], plain(step(solver), start), 1e-3);
        let status = match trace["status"].as_str() {
            Some("converged") => Status::Converged,
            Some("stalled") => Status::Stalled,
            _ => Status::NotFound,
        };
        let place = format!("{solver} {start:?} {goal:?}");
        assert_eq!(answer.status[0], status as u8, "{place}");
        let iterations = trace["iters"].as_u64().expect("a count");
        assert!(iterations.abs_diff(answer.iterations[0].into()) <= 1, "{place}");
        for (got, wanted) in answer.q.iter().zip(numbers(&trace["q"])) {
            assert!((got - wanted).abs() < 1e-9, "{place}: {got} for {wanted}");
        }
        let left = 1e-3 * trace["err"].as_f64().expect("a number");
        assert!((answer.position_error[0] - left).abs() < 1e-9, "{place}");
    }
}

#[test]
fn full_passes_and_turned_tools_agree() {
    let chain = hydrolek();
    let goals = crate::arms::joint_uniform(&chain, 200, 1);
    let run = |full_passes| {
        let step = Step::IkPid(Pid { full_passes, ..Pid::PUBLISHED });
        solve(&chain, &goals, plain(step, StartRule::Zero), 1e-3)
    };
    let (turned, full) = (run(false), run(true));
    assert_eq!(turned.status, full.status);
    assert_eq!(turned.iterations, full.iterations);
}
