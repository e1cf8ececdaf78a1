//! Plans: against the problems of the reference, and what a path has to be.
#![allow(clippy::unwrap_used)]

mod common;

use std::path::Path;

use agrik_motion::edges::{Keep, check_path};
use agrik_motion::planners::{How, PathStatus, Settings, plan};
use agrik_motion::{Collider, Touch};
use common::{Arm, chain, collider, metres};
use serde_json::Value;

fn problems(name: &str) -> Vec<Value> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    let text = std::fs::read_to_string(path.join(format!("problems_{name}.json"))).unwrap();
    serde_json::from_str::<Value>(&text).unwrap().as_array().unwrap().clone()
}

/// The arm among the things of a problem, where the fruit may be touched near it alone.
fn around(name: &str, problem: &Value, radius: f64) -> Collider {
    let free = collider(name, problem["scene"].as_str().unwrap());
    let Some(target) = problem["target"].as_str() else { return free };
    let (bodies, scene) = (free.bodies().clone(), free.scene().clone());
    let body = |name: &str| bodies.body(name).unwrap();
    let objects = [target.to_owned(), format!("stalk_{target}"), format!("{target}_stalk")];
    let objects: Vec<usize> = objects.iter().filter_map(|one| scene.object(one).ok()).collect();
    let pairs = ["gripper", "flange"]
        .iter()
        .flat_map(|name| objects.iter().map(|object| (body(name), *object)))
        .collect();
    let point = problem["target_point"].as_array().unwrap();
    let target = [0, 1, 2].map(|k| 1e-3 * point[k].as_f64().unwrap());
    let skip: Vec<(usize, usize)> = ["base", "shoulder"]
        .iter()
        .flat_map(|name| ["slide", "vehicle"].map(|object| (body(name), object)))
        .filter_map(|(body, object)| Some((body, scene.object(object).ok()?)))
        .collect();
    Collider::new(bodies, scene, &skip, Some(&Touch { pairs, target, radius })).unwrap()
}

fn rows(chain: &agrik::chain::Chain, unit: f64, rows: &Value) -> Vec<f64> {
    rows.as_array().into_iter().flatten().flat_map(|q| metres(chain, unit, q)).collect()
}

#[test]
fn problems_of_the_reference_have_their_statuses() {
    for name in ["cucumber", "panda"] {
        let (arm, chain) = (Arm::read(name), chain(name));
        for problem in problems(name) {
            if problem["robot"] != name {
                continue;
            }
            let goals = rows(&chain, arm.unit, &problem["goals"]);
            let status = problem["status"].as_str().unwrap();
            if name == "cucumber" && goals.is_empty() {
                // Those that have no posture are the harvest's.
                continue;
            }
            let collider = around(name, &problem, 0.15);
            let start = metres(&chain, arm.unit, &problem["start"]);
            let settings = Settings::default();
            let found = plan(&collider, &start, &goals, &settings).unwrap();
            println!(
                "{} {} {}: {} {} checks {} rounds {} waypoints {} nearest {:.3}",
                name,
                problem["scene"],
                problem.get("target").unwrap_or(&problem["name"]),
                found.status.name(),
                found.how.name(),
                found.checks,
                found.rounds,
                found.path.len() / chain.dof(),
                found.nearest
            );
            // What was not found with the effort of then may be found.
            if status != "NO_PATH_FOUND" {
                assert_eq!(found.status.name(), status);
            }
            if found.status != PathStatus::Ok {
                continue;
            }
            let dof = chain.dof();
            assert_eq!(found.path[..dof], start);
            let goal = found.goal.unwrap();
            assert_eq!(found.path[found.path.len() - dof..], goals[goal * dof..][..dof]);
            let keep = Keep::clear(0.002).with_cap(0.05);
            let checked = check_path(&collider, keep, &found.path, 1, &mut || true).unwrap();
            assert!(checked.iter().all(|one| one.is_safe()));
            assert_eq!(checked.len(), found.clearance.len());
            for (one, told) in checked.iter().zip(&found.clearance) {
                assert!((one.clearance - told).abs() < 1e-12 || *told == 0.002);
                assert!(*told >= 0.002);
            }
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_path() {
    let problem = problems("panda").into_iter().find(|one| one["name"] == "bench0").unwrap();
    let (chain, collider) = (chain("panda"), collider("panda", "bench"));
    let start = metres(&chain, 1.0, &problem["start"]);
    let goals = rows(&chain, 1.0, &problem["goals"]);
    let of = |seed: u64| {
        let settings = Settings { seed, ..Settings::default() };
        plan(&collider, &start, &goals, &settings).unwrap()
    };
    assert_eq!(of(3), of(3));
    for seed in 0..10 {
        assert_eq!(of(seed).status, PathStatus::Ok);
    }
}

#[test]
fn starts_and_goals_are_judged_before_anything_else() {
    let (chain, collider) = (chain("panda"), collider("panda", "bench"));
    let problem = problems("panda").into_iter().find(|one| one["name"] == "bench0").unwrap();
    let start = metres(&chain, 1.0, &problem["start"]);
    let goals = rows(&chain, 1.0, &problem["goals"]);
    let of =
        |start: &[f64], goals: &[f64]| plan(&collider, start, goals, &Settings::default()).unwrap();
    let mut out = start.clone();
    out[1] = 3.0;
    assert_eq!(of(&out, &goals).status, PathStatus::StartOutOfLimits);
    assert_eq!(of(&start, &[]).status, PathStatus::NoGoal);
    assert_eq!(of(&start, &out).status, PathStatus::JointLimits);
    // A start that is the goal is a path of one posture.
    let found = of(&start, &start);
    assert_eq!((found.status, found.how), (PathStatus::Ok, How::Straight));
    assert_eq!(found.path, start);
    assert_eq!(found.clearance.len(), 1);
    let hits: Vec<f64> = common::random_postures(&chain, 100, 5);
    let hit = hits.chunks(7).find(|q| collider.collides(q, 0.0, 1, &mut || true).unwrap()[0]);
    let found = of(hit.unwrap(), &goals);
    assert_eq!(found.status, PathStatus::StartInCollision);
    assert!(found.contact.unwrap().distance <= 0.002);
    assert_eq!(of(&start, hit.unwrap()).status, PathStatus::NoCollisionFree);
    assert!(plan(&collider, &start[..6], &goals, &Settings::default()).is_err());
    assert!(plan(&collider, &start, &goals[..6], &Settings::default()).is_err());
    let bad = Settings { step: 0.0, ..Settings::default() };
    assert!(plan(&collider, &start, &goals, &bad).is_err());
}
