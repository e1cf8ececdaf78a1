use super::*;

/// J. Where a single beta near 0 is feasible, rounding of the target in its last place
/// or a slide a hair past its limit decides beta in its sixth digit.
const CORNER: f64 = 5e-7;

fn arm() -> Arm {
    Arm::new(Parameters::default()).unwrap()
}

/// Numbers in [0, 1), the same ones every time.
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1u64 << 53) as f64
}

/// A target of random joint values; often one or more slides at a limit.
fn reachable(arm: &Arm, state: &mut u64) -> [f64; 3] {
    let p = arm.parameters();
    let mut q = [0.0; 5];
    for i in 0..5 {
        let share = (random(state) * 2.0 - 0.5).clamp(0.0, 1.0);
        q[i] = p.lower[i] + share * (p.upper[i] - p.lower[i]);
    }
    arm.fk(&q)
}

/// The least energy on a grid over theta and beta, refined around its best point.
fn by_grid(arm: &Arm, target: [f64; 3]) -> Option<f64> {
    let p = *arm.parameters();
    let mut best: Option<(f64, f64, f64)> = None;
    let (mut t, mut b) = ([p.lower[3], p.upper[3]], [p.lower[4], p.upper[4]]);
    for round in 0..12 {
        let n = if round == 0 { 150 } else { 30 };
        let steps = [(t[1] - t[0]) / f64::from(n), (b[1] - b[0]) / f64::from(n)];
        for i in 0..=n {
            for k in 0..=n {
                let theta = t[0] + steps[0] * f64::from(i);
                let beta = b[0] + steps[1] * f64::from(k);
                let q = arm.slides(target, theta, beta);
                // Strictly: a slide a hair past its limit buys some energy at a corner.
                if !arm.within(&q) {
                    continue;
                }
                let energy = arm.energy_index(&q);
                if best.is_none_or(|(least, ..)| energy < least) {
                    best = Some((energy, theta, beta));
                }
            }
        }
        let (_, theta, beta) = best?;
        t = [(theta - 4.0 * steps[0]).max(p.lower[3]), (theta + 4.0 * steps[0]).min(p.upper[3])];
        b = [(beta - 4.0 * steps[1]).max(p.lower[4]), (beta + 4.0 * steps[1]).min(p.upper[4])];
    }
    best.map(|(energy, ..)| energy)
}

#[test]
fn free_pose_of_the_paper_arm() {
    let free = arm().free().unwrap();
    assert!((free.theta - -0.515_611_703_332_910_8).abs() < 1e-12);
    assert!((free.beta - 0.387_445_636_540_562_24).abs() < 1e-12);
}

#[test]
fn exact_is_never_worse_than_a_grid_and_misses_nothing() {
    let hardware = Parameters {
        lower: {
            let mut q = Parameters::default().lower;
            q[4] = (-85.0f64).to_radians();
            q
        },
        ..Parameters::default()
    };
    for (arm, mut state) in [(arm(), 1u64), (Arm::new(hardware).unwrap(), 2)] {
        arm.check_certificate().unwrap();
        let mut constrained = 0;
        for _ in 0..300 {
            let target = reachable(&arm, &mut state);
            let q = arm
                .solve(target, &Method::Exact)
                .expect("made from joint values within the limits");
            let back = arm.fk(&q);
            for i in 0..3 {
                assert!((back[i] - target[i]).abs() < 1e-11);
            }
            assert!(
                (0..5).all(|i| arm.parameters.lower[i] <= q[i] && q[i] <= arm.parameters.upper[i])
            );
            let free = arm.free().unwrap();
            constrained += u32::from(q[3] != free.theta || q[4] != free.beta);
            let energy = arm.energy_index(&q);
            if let Some(grid) = by_grid(&arm, target) {
                assert!(energy <= grid + CORNER, "{target:?}: {energy} against {grid}");
            }
        }
        assert!(constrained >= 150, "{constrained} constrained targets");
    }
}

#[test]
fn nothing_is_reported_out_of_reach_that_a_grid_reaches() {
    let arm = arm();
    let [low, high] = arm.target_box();
    let mut state = 5u64;
    let (mut refused, mut solved) = (0, 0);
    for _ in 0..400 {
        let target = [0, 1, 2].map(|i| {
            let margin = 0.03;
            low[i] - margin + random(&mut state) * (high[i] - low[i] + 2.0 * margin)
        });
        match arm.solve(target, &Method::Exact) {
            Ok(_) => solved += 1,
            Err(gap) => {
                refused += 1;
                assert_eq!(gap.status, Status::OutOfReach);
                assert!(gap.amount != 0.0);
                let p = arm.parameters();
                for i in 0..=150 {
                    for k in 0..=80 {
                        let theta = p.lower[3] + (p.upper[3] - p.lower[3]) * f64::from(i) / 150.0;
                        let beta = p.lower[4] + (p.upper[4] - p.lower[4]) * f64::from(k) / 80.0;
                        assert!(!arm.within(&arm.slides(target, theta, beta)));
                    }
                }
            }
        }
    }
    assert!(refused > 50 && solved > 200, "{refused} refused, {solved} solved");
}

#[test]
fn methods_are_ordered_and_reach() {
    let arm = arm();
    let rules = Rules::default();
    let mut state = 9u64;
    let mut solved = [0; 3];
    for _ in 0..2000 {
        let target = reachable(&arm, &mut state);
        let exact = arm.energy_index(&arm.solve(target, &Method::Exact).unwrap());
        solved[0] += 1;
        let suboptimal =
            arm.solve(target, &Method::Suboptimal(rules)).map(|q| arm.energy_index(&q));
        let analytic = arm.solve(target, &Method::Analytic(rules)).map(|q| arm.energy_index(&q));
        if let Ok(energy) = suboptimal {
            solved[1] += 1;
            let found = (
                arm.solve(target, &Method::Exact),
                arm.solve(target, &Method::Suboptimal(rules)),
                target,
            );
            assert!(exact <= energy + CORNER, "{exact} {energy} {found:?}");
            if let Ok(analytic) = analytic {
                assert!(energy <= analytic + 1e-12, "{energy} {analytic}");
            }
        }
        if let Ok(energy) = analytic {
            solved[2] += 1;
            let found = (
                arm.solve(target, &Method::Exact),
                arm.solve(target, &Method::Suboptimal(rules)),
                target,
            );
            assert!(exact <= energy + CORNER, "{exact} {energy} {found:?}");
        }
    }
    // AS tries a single beta: it misses some of what can be reached.
    assert!(solved[0] == 2000 && solved[1] >= solved[2] && solved[2] > 1600, "{solved:?}");
    assert!(solved[2] < 2000, "{solved:?}");
}

#[test]
fn slopes_match_finite_differences() {
    let arm = arm();
    let p = *arm.parameters();
    let h = 1e-7;
    for (theta, beta) in [(0.3, 0.5), (-0.4, 1.1), (0.7, 0.2), (-0.9, 0.9)] {
        let q = [0.3, 0.5, 0.15, theta, beta];
        let target = arm.fk(&q);
        for case in [SlopeCase::Fixed, SlopeCase::OnS21, SlopeCase::OnS32] {
            let at = |s10: f64| {
                let beta = ((target[1] - s10 - p.l1 + p.d[1]) / p.l3).asin();
                let r = arm.reach(beta);
                let r0 = arm.reach(q[4]);
                let theta = match case {
                    SlopeCase::Fixed => theta,
                    SlopeCase::OnS21 => (r0 * theta.sin() / r).asin(),
                    SlopeCase::OnS32 => (r0 * theta.cos() / r).acos().copysign(theta),
                };
                arm.energy_index(&arm.slides(target, theta, beta))
            };
            let difference = (at(q[0] + h) - at(q[0] - h)) / (2.0 * h);
            let [friction, potential] = arm.energy_slopes(theta, beta, case);
            assert!((friction + potential - difference).abs() < 2e-7, "{case:?}");
        }
        // (26) as printed has l2 for l1 and is off by far more than rounding.
        let printed = -1.0 / (p.l3.powi(2) - (target[1] - q[0] - p.l2 + p.d[1]).powi(2)).sqrt();
        assert!((printed / arm.beta_slope(beta) - 1.0).abs() > 0.01);
    }
}

#[test]
fn shifts_bring_in_reach_and_smaller_ones_do_not() {
    let arm = arm();
    let [low, high] = arm.target_box();
    let mut state = 77u64;
    let mut shifted = 0;
    for _ in 0..300 {
        let target =
            [0, 1, 2].map(|i| low[i] - 0.1 + random(&mut state) * (high[i] - low[i] + 0.2));
        let shift = arm.suggest_base_shift(target, [true; 3], CERTIFIED).unwrap();
        let moved = |v: [f64; 3]| [target[0] - v[0], target[1] - v[1], target[2] - v[2]];
        let length = shift.iter().map(|v| v * v).sum::<f64>().sqrt();
        assert!(arm.exact(moved(shift)).is_ok(), "{target:?} {shift:?}");
        if length == 0.0 {
            continue;
        }
        shifted += 1;
        for _ in 0..200 {
            let mut v = [0.0; 3].map(|_: f64| random(&mut state) * 2.0 - 1.0);
            let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
            for (x, s) in v.iter_mut().zip(shift) {
                // Around the suggested direction, and 1e-5 shorter.
                *x = s / length + 0.3 * *x / norm;
            }
            let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
            let shorter = v.map(|x| x / norm * (length * (1.0 - 1e-5) - 1e-7));
            assert!(arm.exact(moved(shorter)).is_err(), "{target:?} {shift:?} {shorter:?}");
        }
    }
    assert!(shifted > 100);
}

/// The length of the shortest translation of a fine grid over theta and beta.
fn shift_by_grid(arm: &Arm, target: [f64; 3], may_move: [bool; 3]) -> f64 {
    let p = arm.parameters();
    let (rows, columns) = (400, 300);
    let mut least = f64::INFINITY;
    for i in 0..=rows {
        for k in 0..=columns {
            let share = |n: i32, of: i32| f64::from(n) / f64::from(of);
            let theta = p.lower[3] + (p.upper[3] - p.lower[3]) * share(i, rows);
            let beta = p.lower[4] + (p.upper[4] - p.lower[4]) * share(k, columns);
            let q = arm.slides(target, theta, beta);
            // Slides s21, s10, s32 move x, y, z.
            let gaps = [1, 0, 2].map(|j| q[j] - q[j].clamp(p.lower[j], p.upper[j]));
            if (0..3).all(|i| may_move[i] || gaps[i] == 0.0) {
                least = least.min(gaps.iter().map(|x| x * x).sum::<f64>().sqrt());
            }
        }
    }
    least
}

#[test]
fn no_grid_finds_a_shorter_shift() {
    let hardware = Parameters {
        lower: {
            let mut q = Parameters::default().lower;
            q[4] = (-85.0f64).to_radians();
            q
        },
        ..Parameters::default()
    };
    for (arm, mut state) in [(arm(), 3u64), (Arm::new(hardware).unwrap(), 4)] {
        let [low, high] = arm.target_box();
        let (mut shifted, mut held, mut close) = (0, 0, 0);
        for round in 0..240 {
            let mut may_move = [true; 3];
            if round % 2 == 1 {
                may_move = [0, 1, 2].map(|i| (round / 2) >> i & 1 != 0);
            }
            // Out of reach by little and by much.
            let margin = if round % 3 == 0 { 0.2 } else { 0.02 };
            let target = [0, 1, 2]
                .map(|i| low[i] - margin + random(&mut state) * (high[i] - low[i] + 2.0 * margin));
            let grid = shift_by_grid(&arm, target, may_move);
            let Some(shift) = arm.suggest_base_shift(target, may_move, CERTIFIED) else {
                assert_eq!(grid, f64::INFINITY, "{target:?} {may_move:?}");
                held += 1;
                continue;
            };
            assert!((0..3).all(|i| may_move[i] || shift[i] == 0.0));
            let moved = [0, 1, 2].map(|i| target[i] - shift[i]);
            assert!(arm.exact(moved).is_ok(), "{target:?} {may_move:?} {shift:?}");
            let length = shift.iter().map(|v| v * v).sum::<f64>().sqrt();
            assert!(length <= grid + 1.2e-8, "{length} {grid} {target:?} {may_move:?}");
            shifted += i32::from(length > 0.0);
            // The grid comes near the answer from above.
            close += i32::from(length > 0.0 && grid - length < 2e-3);
        }
        assert!(shifted > 60 && held > 20 && close > 60, "{shifted} {held} {close}");
    }
}

#[test]
fn gaps_name_the_slide_and_the_travel() {
    let arm = arm();
    let p = arm.parameters();
    let target = arm.fk(&[0.3, 0.5, 0.15, 0.1, 0.5]);
    let [low, high] = arm.target_box();
    let cases = [
        ([target[0], high[1] + 0.02, target[2]], Place::S10, 0.02),
        ([target[0], low[1] - 0.03, target[2]], Place::S10, -0.03),
        ([high[0] + 0.04, target[1], target[2]], Place::S21, 0.04),
        ([low[0] - 0.05, target[1], target[2]], Place::S21, -0.05),
        ([target[0], target[1], low[2] - 0.06], Place::S32, 0.06),
        ([target[0], target[1], high[2] + 0.07], Place::S32, -0.07),
    ];
    assert_eq!(p.lower[4], 0.0);
    for (target, place, amount) in cases {
        let gap = arm.solve(target, &Method::Exact).unwrap_err();
        assert_eq!((gap.place, gap.status), (place, Status::OutOfReach));
        assert!((gap.amount - amount).abs() < 1e-12, "{gap:?}");
    }
    assert_eq!(arm.solve([f64::NAN; 3], &Method::Exact).unwrap_err().status, Status::BadInput);
}

#[test]
fn commands_wait_above_the_plant() {
    let arm = arm();
    let q = arm.solve([0.426, 0.345, -0.3316], &Method::Exact).unwrap();
    let steps = arm.commands(&q, 0.0, 0.05).unwrap();
    // The remark's s32 + h_extra would be 50 mm deeper than the target.
    assert!((steps[1].target - (q[2] - 0.05)).abs() < 1e-15);
    assert_eq!((steps[7].axis, steps[7].target), (Axis::S32, q[2]));
    assert!(arm.commands(&q, 0.0, -0.05).is_err());
}

#[test]
fn failed_rows_hold_the_reset_pose_and_how_far_it_is_off() {
    let arm = arm();
    let targets = [[0.4, 1.2, -0.3], [f64::NAN; 3]];
    for method in [Method::Exact, Method::Analytic(Rules::default())] {
        let out = arm.solve_all(&targets, &method, &mut || true).unwrap().answers;
        assert_eq!(out.q, [arm.reset_pose(); 2].concat());
        let at = arm.fk(&arm.reset_pose());
        let off: f64 = (0..3).map(|i| (at[i] - targets[0][i]).powi(2)).sum();
        assert_eq!(out.position_error, [off.sqrt(), f64::INFINITY]);
        assert_eq!(out.orientation_error, [0.0, f64::INFINITY]);
    }
}
