//! What the tuner pays for a set of gains.

use std::sync::Arc;

use agrik::call::{Goals, Tolerance};
use agrik::solve::{GainUnits, StartRule, StateSpace, StaticGain, Step};
use agrik::tune::{Cost, Family, Problem, Shape};

use crate::arms::{gains, hydrolek, joint_uniform, paper_units, state_space};

fn set(name: &str) -> StateSpace {
    state_space(&gains()["hydrolek_ss"][name], paper_units(0.01))
}

fn family(set: StateSpace, shape: Shape) -> Family {
    let active = vec![true, true, true, true, true, false];
    Family::new(Step::StateSpace(Some(Arc::new(set))), shape, active).expect("a family")
}

fn points(points: &[[f64; 3]]) -> Goals<'_> {
    Goals::Positions { points, direction: None }
}

/// Calls `test` with the tuner's problem on 400 goals.
fn with_problem(family: &Family, test: impl FnOnce(&Problem<'_>)) {
    let chain = hydrolek();
    let goals = joint_uniform(&chain, 400, 100);
    test(&Problem {
        chain: &chain,
        family,
        goals: points(&goals),
        start: StartRule::Zero,
        max_iterations: 400,
        tolerance: Tolerance { position: 1e-3, ..Tolerance::default() },
        cost: Cost::default(),
    });
}

#[test]
fn a_cost_is_cut_short_only_where_it_is_too_high() {
    let family = family(set("k15_pso"), Shape::Input);
    with_problem(&family, |problem| {
        let x = family.start();
        let whole = problem.score(&x, 1, &mut || true).expect("a score").cost;
        let below = |bound: f64| problem.cost_below(&x, bound, 1, &mut || true).expect("a cost");
        assert!((below(f64::INFINITY) - whole).abs() < 1e-12);
        assert!((below(1.001 * whole) - whole).abs() < 1e-12);
        for share in [0.999, 0.5, 0.0] {
            let cost = below(share * whole);
            assert!(cost >= share * whole && cost <= whole + 1e-12, "{cost} of {whole}");
        }
        assert!(below(0.0) < whole);
    });
}

#[test]
fn the_hardest_goals_come_first_and_none_is_lost() {
    let family = family(set("trial_published"), Shape::Diagonal);
    with_problem(&family, |problem| {
        let x = family.start();
        let Goals::Positions { points: all, .. } = problem.goals else { panic!("points") };
        let order = problem.hardest_first(&x, 2, &mut || true).expect("an order");
        let sorted: Vec<[f64; 3]> = order.iter().map(|i| all[*i]).collect();
        let cost = |goals: &[[f64; 3]]| {
            let problem = Problem { goals: points(goals), ..problem.clone() };
            problem.score(&x, 1, &mut || true).expect("a score").cost
        };
        let quarters: Vec<f64> = sorted.chunks(100).map(cost).collect();
        assert!(quarters.windows(2).all(|pair| pair[0] >= pair[1]), "{quarters:?}");
        assert!((cost(&sorted) - cost(all)).abs() < 1e-12);
    });
}

#[test]
fn states_that_grow_unheard_are_charged() {
    let calm = set("full90_pso");
    let mut growing = calm.clone();
    // Joint 6 moves nothing, and here its state moves nothing either.
    let n = growing.a.columns;
    for k in 0..n {
        growing.a.values[5 * n + k] = 0.0;
        growing.a.values[k * n + 5] = 0.0;
        growing.c.values[k * n + 5] = 0.0;
    }
    let mut quiet = growing.clone();
    growing.a.values[5 * n + 5] = 1.01;
    quiet.a.values[5 * n + 5] = 0.5;
    let cost = |set: StateSpace| {
        let family = family(set, Shape::Full);
        let mut found = (false, 0.0);
        with_problem(&family, |problem| {
            let x = family.start();
            let score = problem.score(&x, 1, &mut || true).expect("a score");
            found = (family.is_stable(&x), score.cost);
        });
        found
    };
    assert!(cost(calm).0);
    let (quiet, growing) = (cost(quiet), cost(growing));
    assert!(quiet.0 && !growing.0);
    assert!((growing.1 - quiet.1 - Cost::default().broken).abs() < 1e-9);
}

#[test]
fn poses_are_charged_for_their_orientation_too() {
    let chain = hydrolek();
    let n = chain.dof();
    let limits = chain.variables();
    let q: Vec<f64> = (0..40 * n)
        .map(|i| {
            let v = &limits[i % n];
            v.lower + (v.upper - v.lower) * ((i * 37 % 101) as f64 / 101.0)
        })
        .collect();
    let mut flat = vec![0.0; 16 * 40];
    agrik::kinematics::tool_poses(&chain, &q, &mut flat);
    let poses: &[[f64; 16]] = flat.as_chunks().0;
    let gain = agrik::solve::frozen_gain(&chain, Some(0.3)).expect("a gain");
    assert_eq!((gain.rows(), gain.columns), (6, 6));
    let units = GainUnits { per_radian: Some(0.3), ..GainUnits::default() };
    let step = Step::StaticGain(Some(Arc::new(StaticGain { gain, units })));
    let family = Family::new(step, Shape::Full, vec![true; n]).expect("a family");
    assert_eq!(family.start().len(), 36);
    let score = |orientation: f64, per_radian: f64| {
        let problem = Problem {
            chain: &chain,
            family: &family,
            goals: Goals::Poses(poses),
            start: StartRule::Zero,
            max_iterations: 50,
            tolerance: Tolerance { position: 10.0, orientation, axes: None },
            cost: Cost { per_radian, ..Cost::default() },
        };
        problem.score(&family.start(), 1, &mut || true).expect("a score")
    };
    // However far off a goal is, it counts as reached if its orientation may be anything.
    assert_eq!(score(4.0, 5.0).solved, 40);
    let (free, charged) = (score(1e-9, 0.0), score(1e-9, 5.0));
    assert!(free.solved < 40 && free.solved == charged.solved);
    assert!(charged.cost > free.cost + 0.01, "{} {}", charged.cost, free.cost);
    assert!(charged.cost < free.cost + 5.0 * std::f64::consts::PI);
}
