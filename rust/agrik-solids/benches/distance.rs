//! Booleans and distances per second, one thread: the boxes of an arm, placed at random
//! postures, against its scenes; scenes of more points; how long a scene takes to build; the
//! covers of the paper.
//!
//! One iteration of the posture benches is all bodies of 1,000 postures, so that the reported
//! rate is postures per second.

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use agrik_solids::lanes::Level;
use agrik_solids::{Cloud, Core, Cover, Cuboid, Exemption, Object, Scene, Solid, Split, within};
use common::Random;
use common::arm::{Arm, objects, read};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};

const POSTURES: usize = 1000;

/// The cap of the paper's cost, m.
const CAP: f64 = 0.075;

/// Bodies at random postures within the limits.
fn postures(name: &str, arm: &Arm) -> Vec<Vec<Solid>> {
    let file = read(&format!("{name}.json"));
    let joints: Vec<(f64, f64)> = file["joints"]
        .as_array()
        .map(|joints| {
            let number = |joint: &serde_json::Value, key| joint[key].as_f64().unwrap_or(0.0);
            joints.iter().map(|joint| (number(joint, "lo"), number(joint, "hi"))).collect()
        })
        .unwrap_or_default();
    let mut random = Random::new(1);
    (0..POSTURES)
        .map(|_| {
            let q: Vec<f64> = joints.iter().map(|(lo, hi)| random.between(*lo, *hi)).collect();
            arm.placed(&q)
        })
        .collect()
}

/// How many bodies of a posture hit the scene or each other, up to the first.
fn hits(arm: &Arm, scene: &Scene, exempt: &[Exemption], bodies: &[Solid], own: bool) -> bool {
    let scene_hit = bodies.iter().zip(exempt).any(|(body, exempt)| scene.hits(body, exempt, 0.0));
    scene_hit || (own && arm.self_pairs.iter().any(|(i, j)| within(&bodies[*i], &bodies[*j], 0.0)))
}

fn distance(scene: &Scene, exempt: &[Exemption], bodies: &[Solid], cap: f64) -> f64 {
    bodies.iter().zip(exempt).fold(cap, |least, (body, exempt)| scene.distance(body, exempt, least))
}

fn arms(criterion: &mut Criterion) {
    for (name, scenes) in [("cucumber", "scene greenhouse2"), ("panda", "bench greenhouse5 wall")] {
        let arm = Arm::read(name);
        let placed = postures(name, &arm);
        let files = read(&format!("scenes_{name}.json"));
        for scene_name in scenes.split(' ') {
            let Ok(scene) = Scene::new(objects(&files[scene_name], arm.unit)) else { continue };
            let exempt = arm.exemptions(&scene);
            let free = placed.iter().filter(|b| !hits(&arm, &scene, &exempt, b, true)).count();
            let mut group = criterion.benchmark_group(format!("{name}/{scene_name}"));
            group.throughput(Throughput::Elements(POSTURES as u64)).sample_size(30);
            println!("{name}/{scene_name}: {free} of {POSTURES} postures are free");
            for level in Level::ALL.into_iter().filter(|l| l.is_available()) {
                let scene = scene.clone().at_level(level);
                let id = |what: &str| BenchmarkId::new(what, level.name());
                let each = |of: &dyn Fn(&[Solid]) -> f64| -> f64 {
                    placed.iter().map(|bodies| of(bodies)).sum()
                };
                group.bench_function(id("hits"), |b| {
                    b.iter(|| {
                        each(&|bodies| f64::from(hits(&arm, &scene, &exempt, bodies, false)))
                    });
                });
                group.bench_function(id("hits and self"), |b| {
                    b.iter(|| each(&|bodies| f64::from(hits(&arm, &scene, &exempt, bodies, true))));
                });
                group.bench_function(id("distance"), |b| {
                    b.iter(|| each(&|bodies| distance(&scene, &exempt, bodies, f64::INFINITY)));
                });
                group.bench_function(id("capped"), |b| {
                    b.iter(|| each(&|bodies| distance(&scene, &exempt, bodies, CAP)));
                });
            }
            group.finish();
        }
    }
}

/// Points in the same volume, more and more of them.
fn points(count: usize) -> Cloud {
    let mut random = Random::new(2);
    let rows = (0..count).map(|_| {
        let mut at = |lower, upper| random.between(lower, upper);
        [at(0.4, 0.9), at(-0.7, 0.8), at(0.1, 1.9), 0.005]
    });
    Cloud::of(rows).unwrap_or_default()
}

fn growth(criterion: &mut Criterion) {
    let arm = Arm::read("cucumber");
    let placed = postures("cucumber", &arm);
    let mut group = criterion.benchmark_group("points");
    group.sample_size(20);
    for count in [1_000, 10_000, 100_000] {
        let cloud = points(count);
        let object = || Object::new("cloud", "leaf").with_cloud(cloud.clone());
        let Ok(scene) = Scene::new(vec![object()]) else { continue };
        let exempt = vec![Exemption::none(); arm.bodies.len()];
        group.throughput(Throughput::Elements(POSTURES as u64));
        group.bench_function(BenchmarkId::new("hits", count), |b| {
            b.iter(|| placed.iter().filter(|b| hits(&arm, &scene, &exempt, b, false)).count());
        });
        group.bench_function(BenchmarkId::new("distance", count), |b| {
            b.iter(|| -> f64 {
                placed.iter().map(|b| distance(&scene, &exempt, b, f64::INFINITY)).sum()
            });
        });
        group.throughput(Throughput::Elements(count as u64));
        group.bench_function(BenchmarkId::new("build", count), |b| {
            b.iter(|| Scene::new(vec![black_box(object())]));
        });
    }
    group.finish();
}

fn covers(criterion: &mut Criterion) {
    let arm = Arm::read("cucumber");
    let placed = postures("cucumber", &arm);
    let objects = objects(&read("scenes_cucumber.json")["scene"], arm.unit);
    let spheres: Vec<[f64; 4]> = objects
        .iter()
        .flat_map(|object| &object.clouds)
        .flat_map(|cloud| cloud.spheres())
        .collect();
    let boxes = |bodies: &[Solid]| -> Vec<Cuboid> {
        let cuboid = |body: &Solid| match body.core() {
            Core::Cuboid(cuboid) => Some(*cuboid),
            _ => None,
        };
        bodies.iter().filter_map(cuboid).collect()
    };
    let mut group = criterion.benchmark_group("covers");
    group.throughput(Throughput::Elements(10)).sample_size(10);
    for split in [Split::Equal, Split::NearCubic] {
        let covers: Vec<Cover> =
            boxes(&placed[0]).iter().map(|cuboid| Cover::new(cuboid, split)).collect();
        for level in 0..4 {
            group.bench_function(BenchmarkId::new(format!("{split:?}"), level), |b| {
                b.iter(|| -> f64 {
                    let posture = |bodies: &Vec<Solid>| {
                        let all = boxes(bodies);
                        covers.iter().zip(&all).fold(CAP, |least, (cover, cuboid)| {
                            cover.distance(level, cuboid, &spheres, least)
                        })
                    };
                    placed[..10].iter().map(posture).sum()
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, arms, growth, covers);
criterion_main!(benches);
