//! Success counts on the goal set J of the specification, at four tolerances, and the
//! tests of units and of the integral gain.

use std::sync::Arc;

use agrik::solve::{Pid, StartRule, StaticGain, Step};
use nalgebra::DMatrix;

use crate::arms::{gains, hydrolek, joint_uniform, numbers, paper_units, plain, state_space};
use crate::solve;

const TOLERANCES_M: [f64; 4] = [5e-3, 2e-3, 1e-3, 1e-4];

fn pid(kp: f64, ki: f64, kd: f64) -> Pid {
    let unit = std::f64::consts::PI / 180.0 * 1000.0;
    Pid { proportional: kp * unit, integral: ki * unit, derivative: kd * unit, ..Pid::PUBLISHED }
}

fn set(name: &str, length: f64) -> Step {
    let set = state_space(&gains()["hydrolek_ss"][name], paper_units(length));
    Step::StateSpace(Some(Arc::new(set)))
}

/// The static gain that a set settles to, `C (I - A)^-1 B`.
fn settled(name: &str) -> Arc<StaticGain> {
    let set = state_space(&gains()["hydrolek_ss"][name], paper_units(0.01));
    let dense = |m: &agrik::solve::Matrix| DMatrix::from_row_slice(m.rows(), m.columns, &m.values);
    let n = set.a.columns;
    let inverse = (DMatrix::identity(n, n) - dense(&set.a)).try_inverse().expect("regular");
    let gain = dense(&set.c) * inverse * dense(&set.b);
    let values = gain.transpose().as_slice().to_vec();
    Arc::new(StaticGain { gain: agrik::solve::Matrix { columns: 3, values }, units: set.units })
}

/// Goals reached and mean steps over them, with goals drawn by the seed.
fn reached(step: Step, tolerance: f64, seed: u64) -> (usize, f64) {
    let chain = hydrolek();
    let goals = joint_uniform(&chain, 1000, seed);
    let answers = solve(&chain, &goals, plain(step, StartRule::Zero), tolerance);
    let solved: Vec<usize> = (0..1000).filter(|row| answers.success(*row)).collect();
    let steps: f64 = solved.iter().map(|row| f64::from(answers.iterations[*row])).sum();
    (solved.len(), steps / solved.len() as f64)
}

#[test]
fn goals_are_those_of_the_specification() {
    let reference = crate::arms::reference();
    let goals = joint_uniform(&hydrolek(), 5, 1);
    let wanted = numbers(&reference["bench_goals_first5_paper_mm"]);
    for (goal, wanted) in goals.iter().zip(wanted.chunks(3)) {
        let wanted = crate::arms::from_paper(wanted);
        for k in 0..3 {
            assert!((goal[k] - wanted[k]).abs() < 1e-12);
        }
    }
}

#[test]
fn success_counts_are_those_of_the_specification() {
    let gains = gains();
    let fine = &gains["hydrolek_pid"]["retuned_fine"];
    let number = |key: &str| fine[key].as_f64().expect("a number");
    let fine = pid(number("kp"), number("ki"), number("kd"));
    let broyden = Step::Broyden { gain: Some(settled("k15_cma")), patience: 8 };
    let table = [
        ("transpose", Step::Transpose, [996, 989, 984, 974]),
        ("pseudo-inverse", Step::ClosedPseudoInverse, [995, 994, 994, 993]),
        ("pseudo-inverse by SVD", Step::PseudoInverse { cutoff: 1e-9 }, [995, 994, 994, 993]),
        ("damped, 200 mm", Step::Damped { damping: 0.2 }, [996, 994, 992, 987]),
        ("IK-PID, Kp 0.02", Step::IkPid(pid(0.02, 0.0, 0.0)), [952, 945, 944, 944]),
        ("IK-PID published", Step::IkPid(Pid::PUBLISHED), [995, 993, 993, 975]),
        ("IK-PID fine", Step::IkPid(fine), [998, 996, 995, 994]),
        ("state space by trial", set("trial_published", 0.01), [742, 740, 739, 736]),
        ("state space, 90", set("full90_pso", 0.01), [991, 990, 990, 988]),
        ("state space, 15", set("k15_cma", 0.01), [991, 991, 991, 990]),
        ("static gain", Step::StaticGain(Some(settled("k15_cma"))), [991, 991, 991, 991]),
        ("Broyden", broyden, [992, 991, 991, 991]),
    ];
    let mut off = Vec::new();
    for (name, step, wanted) in table {
        for (tolerance, wanted) in TOLERANCES_M.into_iter().zip(wanted) {
            let (solved, steps) = reached(step.clone(), tolerance, 1);
            println!("{name}, {tolerance} m: {solved} for {wanted}, {steps:.1} steps");
            if solved.abs_diff(wanted) > 3 {
                off.push(format!("{name} at {tolerance}: {solved} for {wanted}"));
            }
        }
    }
    assert!(off.is_empty(), "{off:#?}");
}

#[test]
fn only_degrees_per_millimetre_order_the_published_gains() {
    // Hot gain, cold gain, tuned: 0.0847 reaches few goals, 0.02 many, the tuned most.
    let ordered = |unit: f64| {
        let scaled = |kp, ki, kd| {
            let mut pid = pid(kp, ki, kd);
            pid.proportional *= unit;
            pid.integral *= unit;
            pid.derivative *= unit;
            reached(Step::IkPid(pid), 1e-3, 1).0
        };
        [scaled(0.0847, 0.0, 0.0), scaled(0.02, 0.0, 0.0), scaled(0.012, 1e-7, 0.08)]
    };
    let [hot, cold, tuned] = ordered(1.0);
    assert!(hot < 600 && hot < cold && cold < tuned, "{hot} {cold} {tuned}");
    assert!(tuned >= 990, "{tuned}");
    let [hot, cold, _] = ordered(0.1);
    assert!(hot > cold && hot > 990, "degrees per centimetre: {hot} {cold}");
}

#[test]
fn the_integral_gain_puts_a_floor_under_the_step() {
    let with = reached(Step::IkPid(Pid::PUBLISHED), 1e-4, 1).0;
    let without = reached(Step::IkPid(Pid::FINE), 1e-4, 1).0;
    assert!(without >= with + 10, "{with} with, {without} without");
}

#[test]
fn trial_gains_need_centimetres_to_be_slow() {
    let (slow, many) = reached(set("trial_published", 0.01), 1e-3, 1);
    let (fast, few) = reached(set("trial_published", 0.001), 1e-3, 1);
    assert!(many > 5.0 * few, "{slow} in {many}, {fast} in {few}");
}
