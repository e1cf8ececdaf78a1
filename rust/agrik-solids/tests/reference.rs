//! Distances of all bodies of two arms at 100 postures each from everything in six scenes,
//! against numbers worked out beside this library, and checked with another one.

#![allow(clippy::unwrap_used)]

mod common;

use agrik_solids::lanes::Level;
use agrik_solids::{Exemption, Scene, closest, distance};
use common::arm::{Arm, numbers, objects, read};
use common::{norm, sub};

#[test]
fn every_body_is_as_far_from_the_scene_as_the_reference_says() {
    for name in ["cucumber", "panda"] {
        let arm = Arm::read(name);
        let scenes = read(&format!("scenes_{name}.json"));
        let postures = read(&format!("postures_{name}.json"));
        let mut compared = 0;
        for level in Level::ALL.into_iter().filter(|level| level.is_available()) {
            for (scene_name, scene) in scenes.as_object().unwrap() {
                let scene = Scene::new(objects(scene, arm.unit)).unwrap().at_level(level);
                let exempt = arm.exemptions(&scene);
                for posture in postures.as_array().unwrap() {
                    let Some(expected) = posture.get(scene_name) else { continue };
                    let mut nearest = (f64::INFINITY, String::new());
                    for (i, body) in arm.placed(&numbers(&posture["q"])).iter().enumerate() {
                        // What stands on the ground touches it.
                        let Some(known) = expected["D"][i].as_f64() else { continue };
                        let found = scene.nearest(body, &exempt[i], f64::INFINITY).unwrap();
                        let off = found.distance / arm.unit - known;
                        assert!(off.abs() < 1.01e-7, "{name}, {scene_name}, body {i}: {off}");
                        assert_eq!(scene.hits(body, &exempt[i], 0.0), found.distance <= 0.0);
                        if found.distance > 0.0 {
                            let apart = norm(sub(found.on_solid, found.on_object));
                            assert!((apart - found.distance).abs() < 1e-12);
                        }
                        if found.distance < nearest.0 {
                            let object = &scene.objects()[found.object].name;
                            nearest = (found.distance, object.clone());
                        }
                        compared += 1;
                    }
                    let off = nearest.0 / arm.unit - expected["min"].as_f64().unwrap();
                    assert!(off.abs() < 1.01e-7, "{name}, {scene_name}: {off}");
                    assert_eq!(nearest.1, expected["object"].as_str().unwrap());
                }
            }
        }
        assert!(compared >= 2 * 100 * 3 * arm.bodies.len() - 600, "only {compared} compared");
    }
}

#[test]
fn bodies_are_as_far_from_each_other_as_the_reference_says() {
    for name in ["cucumber", "panda"] {
        let arm = Arm::read(name);
        for posture in read(&format!("postures_{name}.json")).as_array().unwrap() {
            let bodies = arm.placed(&numbers(&posture["q"]));
            let pairs = arm.self_pairs.iter().map(|(i, j)| {
                let found = closest(&bodies[*i], &bodies[*j]).distance;
                assert_eq!(found, distance(&bodies[*i], &bodies[*j]));
                (found, (*i, *j))
            });
            let (least, (i, j)) = pairs.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
            let off = least / arm.unit - posture["self"].as_f64().unwrap();
            assert!(off.abs() < 1.01e-7, "{name}: {off}");
            let (i, j) = (arm.bodies[i].name.as_str(), arm.bodies[j].name.as_str());
            let expected = posture["self_pair"].as_array().unwrap();
            assert!(expected[0] == i && expected[1] == j, "{i}, {j}, not {expected:?}");
        }
    }
}

#[test]
fn exempt_objects_are_passed_over() {
    let arm = Arm::read("cucumber");
    let scene = &read("scenes_cucumber.json")["scene"];
    let scene = Scene::new(objects(scene, arm.unit)).unwrap();
    let all: Vec<&str> = scene.objects().iter().map(|object| object.name.as_str()).collect();
    let none = scene.exempt(all.iter().copied()).unwrap();
    for posture in read("postures_cucumber.json").as_array().unwrap().iter().take(20) {
        for body in arm.placed(&numbers(&posture["q"])) {
            assert_eq!(scene.distance(&body, &none, f64::INFINITY), f64::INFINITY);
            // The nearest, the nearest without it, and so on, is the list of all.
            let everything = scene.all_within(&body, &Exemption::none(), f64::INFINITY);
            assert_eq!(everything.len(), all.len());
            let mut left_out = Vec::new();
            for expected in &everything[..6] {
                let exempt = scene.exempt(left_out.iter().copied()).unwrap();
                let found = scene.nearest(&body, &exempt, f64::INFINITY).unwrap();
                assert_eq!(found.distance, expected.distance);
                assert_eq!(found.object, expected.object);
                left_out.push(all[found.object]);
            }
        }
    }
}
