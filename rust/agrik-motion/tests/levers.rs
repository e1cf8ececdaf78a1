//! Bounds of motion: against numbers worked out beside this library, and against motion.
#![allow(clippy::unwrap_used)]

mod common;

use std::path::Path;

use agrik::chain::JointKind;
use agrik_solids::Core;
use common::solids::{Random, norm, sub};
use common::{Arm, bodies, chain, metres, numbers};
use serde_json::Value;

fn read(name: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name);
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// Levers in rows, in the units of the file.
fn near(found: &[f64], rows: &Value, arm: &Arm, slides: &[bool], what: &str) {
    for (joint, row) in rows.as_array().unwrap().iter().enumerate() {
        for (body, known) in numbers(row).into_iter().enumerate() {
            let unit = if slides[joint] { 1.0 } else { arm.unit };
            let off = found[joint * arm.bodies.len() + body] / unit - known;
            assert!(off.abs() < 1.01e-9 * (1.0 + known.abs()), "{what}, {joint}, {body}: {off}");
        }
    }
}

#[test]
fn levers_are_those_of_the_reference() {
    for name in ["cucumber", "panda"] {
        let (arm, chain, bodies) = (Arm::read(name), chain(name), bodies(name, true));
        let slides: Vec<bool> =
            chain.variables().iter().map(|v| v.kind == JointKind::Prismatic).collect();
        let file = read(&format!("levers_{name}.json"));
        near(&bodies.levers(), &file["rho_global"], &arm, &slides, "global");

        let mut placed = bodies.room();
        let segments = read(&format!("segments_{name}.json"));
        for segment in segments.as_array().unwrap() {
            let (a, b) = (
                metres(&chain, arm.unit, &segment["qa"]),
                metres(&chain, arm.unit, &segment["qb"]),
            );
            let middle: Vec<f64> = a.iter().zip(&b).map(|(a, b)| 0.5 * (a + b)).collect();
            let half: Vec<f64> = a.iter().zip(&b).map(|(a, b)| 0.5 * (b - a)).collect();
            bodies.place(&middle, &mut placed).unwrap();
            let levers = bodies.local_levers(&placed, &half);
            near(&levers, &segment["rho_mid"], &arm, &slides, "local");
            for (body, known) in numbers(&segment["M_mid"]).into_iter().enumerate() {
                let off = bodies.motion_bound(&levers, body, &half) / arm.unit - known;
                assert!(off.abs() < 1.01e-9 * (1.0 + known), "{name}, body {body}: {off}");
            }
        }
    }
}

#[test]
fn no_core_point_moves_farther_than_its_bound() {
    let mut random = Random::new(5);
    let mut tightest = 0.0_f64;
    for name in ["cucumber", "panda"] {
        let (chain, bodies) = (chain(name), bodies(name, true));
        let (mut before, mut after) = (bodies.room(), bodies.room());
        let globally = bodies.levers();
        for _ in 0..4_000 {
            let size = 10.0_f64.powf(random.between(-3.0, 0.0));
            let (mut q, mut change) = (Vec::new(), Vec::new());
            for v in chain.variables() {
                let d = size * (v.upper - v.lower) * random.between(-0.5, 0.5);
                // Both ends lie within the limits.
                q.push(random.between(v.lower + d.abs(), v.upper - d.abs()));
                change.push(d);
            }
            let to: Vec<f64> = q.iter().zip(&change).map(|(x, d)| x + d).collect();
            bodies.place(&q, &mut before).unwrap();
            bodies.place(&to, &mut after).unwrap();
            let locally = bodies.local_levers(&before, &change);
            for body in 0..bodies.len() {
                let points = |core: &Core| core.extreme_points();
                let from = points(before.solids()[body].core());
                let to = points(after.solids()[body].core());
                let moved =
                    from.iter().zip(&to).map(|(p, q)| norm(sub(*p, *q))).fold(0.0, f64::max);
                for levers in [&globally, &locally] {
                    let bound = bodies.motion_bound(levers, body, &change);
                    assert!(moved <= bound * (1.0 + 1e-12) + 1e-15, "{name}: {moved} > {bound}");
                }
                let bound = bodies.motion_bound(&locally, body, &change);
                tightest = tightest.max(moved / bound.max(1e-300));
            }
        }
    }
    // Bounds that were too long by a factor would not be noticed otherwise.
    assert!(tightest > 0.9, "{tightest}");
}
