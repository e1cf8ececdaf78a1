//! Ways between postures: against answers worked out beside this library, and against samples.
#![allow(clippy::unwrap_used)]

mod common;

use std::path::Path;

use agrik_motion::edges::{Certifier, Keep, Outcome, check_corners, check_path, check_segments};
use agrik_motion::{Collider, Touch};
use common::{Arm, chain, collider, metres, random_postures};
use serde_json::Value;

fn segments(name: &str) -> Vec<Value> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    let text = std::fs::read_to_string(path.join(format!("segments_{name}.json"))).unwrap();
    serde_json::from_str::<Value>(&text).unwrap().as_array().unwrap().clone()
}

const SCENES: [(&str, &str); 2] =
    [("cucumber", "scene greenhouse1 greenhouse2"), ("panda", "bench wall greenhouse5")];

/// Postures along a way.
fn along(from: &[f64], to: &[f64], count: usize) -> Vec<f64> {
    let at = |k: usize| k as f64 / (count - 1) as f64;
    let each = |k: usize| from.iter().zip(to).map(move |(a, b)| a + at(k) * (b - a));
    (0..count).flat_map(each).collect()
}

/// The least distance of postures, pairs of bodies included.
fn least(collider: &Collider, q: &[f64]) -> f64 {
    let all = collider.clearances(q, f64::INFINITY, true, 1, &mut || true).unwrap();
    all.into_iter().fold(f64::INFINITY, f64::min)
}

#[test]
fn answers_are_those_of_the_reference() {
    for name in ["cucumber", "panda"] {
        let (arm, chain) = (Arm::read(name), chain(name));
        for segment in segments(name) {
            let collider = collider(name, segment["scene"].as_str().unwrap());
            let (a, b) = (
                metres(&chain, arm.unit, &segment["qa"]),
                metres(&chain, arm.unit, &segment["qb"]),
            );
            for cap in [0.0, 0.05, f64::INFINITY] {
                let mut certifier = Certifier::new(&collider, Keep::clear(0.0).with_cap(cap));
                let found = certifier.explained(&a, &b);
                assert_eq!(found.outcome.name(), segment["status"], "{name}, {segment}");
                assert_eq!(certifier.explained(&b, &a).outcome, found.outcome);
                let sampled = segment["sampled_min"].as_f64().unwrap() * arm.unit;
                match found.outcome {
                    Outcome::Safe => {
                        assert!(found.clearance <= sampled + 1e-9, "{found:?}, {sampled}");
                        assert!(found.clearance >= (sampled / 3.0).min(cap), "{found:?}");
                    }
                    _ => {
                        let contact = found.contact.unwrap();
                        assert!(contact.distance <= 0.0, "{contact:?}");
                        let q = along(&a, &b, 2);
                        let at: Vec<f64> =
                            (0..a.len()).map(|k| q[k] + found.at * (b[k] - a[k])).collect();
                        assert!(least(&collider, &at) <= 0.0);
                    }
                }
            }
        }
    }
}

#[test]
fn samples_contradict_no_proof() {
    let (mut safe, mut hit, mut tightest) = (0, 0, 0.0_f64);
    for (name, scenes) in SCENES {
        for scene in scenes.split(' ') {
            let collider = collider(name, scene);
            let chain = collider.bodies().chain();
            let dof = chain.dof();
            let ends = random_postures(chain, 64, 11);
            for (k, pair) in ends.chunks(2 * dof).enumerate() {
                let (from, to) = pair.split_at(dof);
                // Long ways and short ones.
                let share = 0.5_f64.powi(k as i32 % 4);
                let to: Vec<f64> = from.iter().zip(to).map(|(a, b)| a + share * (b - a)).collect();
                for clear in [0.0, 0.01] {
                    let keep = Keep::clear(clear);
                    for keep in [keep, keep.with_cap(clear)] {
                        let found = Certifier::new(&collider, keep).explained(from, &to);
                        let q = along(from, &to, 201);
                        let sampled = least(&collider, &q);
                        if found.is_safe() {
                            safe += 1;
                            assert!(found.clearance <= sampled + 1e-12, "{found:?} {sampled}");
                            assert!(sampled > clear.min(keep.own));
                            let scene = collider.clearances(&q, 1.0, false, 1, &mut || true);
                            assert!(scene.unwrap().into_iter().all(|d| d > clear));
                            if keep.cap > clear {
                                tightest = tightest.max(found.clearance / sampled);
                            }
                        } else {
                            hit += 1;
                            let contact = found.contact.unwrap();
                            let own = matches!(contact.other, agrik_motion::Other::Body(_));
                            let kept = if own { keep.own } else { clear };
                            assert!(contact.distance <= kept + 1e-4, "{found:?}");
                        }
                    }
                }
            }
        }
    }
    assert!(safe > 60 && hit > 60, "{safe} {hit}");
    // Bounds that were too long by a factor would not be noticed otherwise.
    assert!(tightest > 0.9, "{tightest}");
}

#[test]
fn many_ways_have_the_answers_of_one_at_any_number_of_threads() {
    let collider = collider("panda", "bench");
    let chain = collider.bodies().chain();
    let path = random_postures(chain, 60, 3);
    let inner = path.len() - chain.dof();
    let keep = Keep::clear(0.002);
    let of = |threads: usize| {
        let (from, to) = (&path[..inner], &path[chain.dof()..]);
        check_segments(&collider, keep, from, to, threads, &mut || true).unwrap()
    };
    let one = of(1);
    assert!(one.iter().any(|found| found.outcome == Outcome::Safe));
    assert_eq!(one, of(2));
    assert_eq!(one, of(7));
    assert_eq!(one, check_path(&collider, keep, &path, 1, &mut || true).unwrap());
    let posture = check_path(&collider, keep, &path[..chain.dof()], 1, &mut || true).unwrap();
    assert_eq!(posture.len(), 1);
    assert!(check_path(&collider, keep, &[], 1, &mut || true).is_err());
}

#[test]
fn what_may_be_touched_counts_only_near_the_target() {
    let free = collider("cucumber", "greenhouse1");
    let (bodies, scene) = (free.bodies(), free.scene());
    let (arm, chain) = (Arm::read("cucumber"), chain("cucumber"));
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/problems_cucumber.json");
    let problems: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let problem = problems
        .as_array()
        .unwrap()
        .iter()
        .find(|one| one["target"] == "F0_0" && one["scene"] == "greenhouse1")
        .unwrap();
    let ends: Vec<Vec<f64>> =
        problem["path"].as_array().unwrap().iter().map(|q| metres(&chain, arm.unit, q)).collect();
    let (from, to) = (&ends[0], &ends[1]);
    let touching = ["gripper", "flange"].map(|name| bodies.body(name).unwrap());
    let objects = ["F0_0", "stalk_F0_0"].map(|name| scene.object(name).unwrap());
    let pairs: Vec<(usize, usize)> =
        touching.iter().flat_map(|body| objects.iter().map(|object| (*body, *object))).collect();
    let point = problem["target_point"].as_array().unwrap();
    let target = [0, 1, 2].map(|k| 1e-3 * point[k].as_f64().unwrap());
    let skip: Vec<(usize, usize)> = ["base", "shoulder"]
        .iter()
        .flat_map(|body| ["slide", "vehicle"].map(|object| (*body, object)))
        .map(|(body, object)| (bodies.body(body).unwrap(), scene.object(object).unwrap()))
        .collect();
    let within = |radius: f64| {
        let touch = Touch { pairs: pairs.clone(), target, radius };
        let collider = Collider::new(bodies.clone(), scene.clone(), &skip, Some(&touch)).unwrap();
        let found = Certifier::new(&collider, Keep::clear(0.002)).explained(from, to);
        let contact = found.contact.map(|one| collider.names(&one).map(str::to_owned));
        (found.outcome, contact)
    };
    // The whole way, where it is safe; only at its end; nowhere.
    assert_eq!(within(10.0), (Outcome::Safe, None));
    assert_eq!(within(0.15), (Outcome::Safe, None));
    assert_eq!(within(0.0).0, Outcome::Hit);
}

#[test]
fn a_way_of_no_length_is_a_posture() {
    let collider = collider("panda", "bench");
    let q = random_postures(collider.bodies().chain(), 200, 7);
    let hits = collider.collides(&q, 0.0, 1, &mut || true).unwrap();
    let mut certifier = Certifier::new(&collider, Keep::clear(0.0));
    for (q, hit) in q.chunks(7).zip(hits) {
        assert_eq!(certifier.segment(q, q).is_safe(), !hit);
    }
}

#[test]
fn questions_may_run_out_and_numbers_are_checked() {
    let collider = collider("cucumber", "scene");
    let chain = collider.bodies().chain();
    let q = random_postures(chain, 2, 3);
    let keep = Keep { max_checks: 20, ..Keep::clear(0.0) };
    let ask = |keep: Keep| check_path(&collider, keep, &q, 1, &mut || true);
    assert_ne!(ask(keep).unwrap()[0].outcome, Outcome::Safe);
    for bad in [
        Keep { clear: -1.0, ..keep },
        Keep { clear: f64::NAN, ..keep },
        Keep { own: f64::INFINITY, ..keep },
        Keep { cap: -1.0, ..keep },
        Keep { tolerance: 0.0, ..keep },
        Keep { max_checks: 0, ..keep },
    ] {
        assert!(ask(bad).is_err(), "{bad:?}");
    }
    let nan = vec![f64::NAN; 14];
    assert!(check_path(&collider, keep, &nan, 1, &mut || true).is_err());
    assert!(check_segments(&collider, keep, &q, &q[..7], 1, &mut || true).is_err());
}

#[test]
fn no_posture_of_a_corner_that_is_proven_hits() {
    let (mut proven, mut open) = (0, 0);
    for (name, scene) in [("cucumber", "scene"), ("panda", "bench")] {
        let collider = collider(name, scene);
        let chain = collider.bodies().chain();
        let dof = chain.dof();
        let q = random_postures(chain, 120, 21);
        let keep = Keep::clear(0.005);
        for triangle in q.chunks(3 * dof) {
            let corner = &triangle[..dof];
            // Small corners, as paths have them.
            let near = |to: &[f64]| -> Vec<f64> {
                corner.iter().zip(to).map(|(a, b)| a + 0.1 * (b - a)).collect()
            };
            let (from, to) = (near(&triangle[dof..2 * dof]), near(&triangle[2 * dof..]));
            let ask = [&from[..], corner, &to[..]];
            let found = check_corners(&collider, keep, ask, 1, &mut || true).unwrap();
            let mut inside = Vec::new();
            for i in 0..=12 {
                for j in 0..=12 - i {
                    let (s, t) = (f64::from(i) / 12.0, f64::from(j) / 12.0);
                    inside.extend(
                        (0..dof).map(|k| {
                            corner[k] + s * (from[k] - corner[k]) + t * (to[k] - corner[k])
                        }),
                    );
                }
            }
            let sampled = collider.clearances(&inside, 1.0, false, 1, &mut || true).unwrap();
            let least = sampled.into_iter().fold(f64::INFINITY, f64::min);
            let own = collider.clearances(&inside, 1.0, true, 1, &mut || true).unwrap();
            let own = own.into_iter().fold(f64::INFINITY, f64::min);
            if found[0] {
                proven += 1;
                assert!(least > 0.005 && own > keep.own, "{name}: {least} {own}");
            } else {
                open += 1;
                // Nothing that is far from everything is left open.
                assert!(own < 0.02, "{name}: {own}");
            }
        }
    }
    assert!(proven > 20 && open > 5, "{proven} {open}");
    let collider = collider("panda", "bench");
    let q = [0.0; 7];
    let keep = Keep::clear(0.0);
    assert!(check_corners(&collider, keep, [&q, &q, &q[..0]], 1, &mut || true).is_err());
}
