//! The arms of the data beside `agrik-solids`, as chains with bodies.
#![allow(
    dead_code,
    clippy::panic,
    clippy::unwrap_used,
    reason = "test data are sound, and each user takes a part"
)]

#[path = "../../../agrik-solids/tests/common/mod.rs"]
pub mod solids;

use std::sync::Arc;

use agrik::chain::{Chain, Joint, JointKind};
use agrik_motion::{Bodies, Body, Collider};
use agrik_solids::Scene;
use nalgebra::{IsometryMatrix3, Matrix3, Rotation3, Translation3};
use serde_json::Value;

pub use solids::arm::{Arm, numbers, objects, read};

fn isometry(value: &Value, unit: f64) -> IsometryMatrix3<f64> {
    let row = |k: usize| numbers(&value[k]);
    let rotation = Matrix3::from_fn(|i, j| row(i)[j]);
    let shift = Translation3::new(row(0)[3] * unit, row(1)[3] * unit, row(2)[3] * unit);
    IsometryMatrix3::from_parts(shift, Rotation3::from_matrix_unchecked(rotation))
}

/// The chain of a file.
pub fn chain(name: &str) -> Arc<Chain> {
    let file = read(&format!("{name}.json"));
    let unit = if file["unit"] == "mm" { 1e-3 } else { 1.0 };
    let joints = file["joints"].as_array().unwrap().iter().enumerate().map(|(i, joint)| {
        let slides = joint["type"] == "P";
        let kind = if slides { JointKind::Prismatic } else { JointKind::Revolute };
        let scale = if slides { unit } else { 1.0 };
        let limit = |key: &str| joint[key].as_f64().unwrap() * scale;
        let mut made = Joint::new(format!("q{}", i + 1), kind, limit("lo"), limit("hi"));
        made.origin = isometry(&joint["C"], unit);
        made
    });
    let (base, tool) = (isometry(&file["base"], unit), isometry(&file["tool"], unit));
    Arc::new(Chain::new(name, joints.collect(), base, tool, None).unwrap())
}

/// The bodies of a file, with the pairs that it lists or those of the rules.
pub fn bodies(name: &str, listed: bool) -> Arc<Bodies> {
    let arm = Arm::read(name);
    let bodies = arm.bodies.iter().map(|b| Body::new(&b.name, b.frame, b.solid.clone()));
    let pairs = listed.then_some(&arm.self_pairs[..]);
    Arc::new(Bodies::new(chain(name), bodies.collect(), pairs).unwrap())
}

/// An arm in one of its scenes, with what the file says it does not mind there.
pub fn collider(name: &str, scene: &str) -> Collider {
    let (arm, bodies) = (Arm::read(name), bodies(name, true));
    let scene = &read(&format!("scenes_{name}.json"))[scene];
    let scene = Arc::new(Scene::new(objects(scene, arm.unit)).unwrap());
    let skip = read(&format!("{name}.json"))["static_skip"].clone();
    let skip: Vec<(usize, usize)> = skip
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(|pair| {
            let body = bodies.body(pair[0].as_str().unwrap()).unwrap();
            Some((body, scene.object(pair[1].as_str().unwrap()).ok()?))
        })
        .collect();
    Collider::new(bodies, scene, &skip, None).unwrap()
}

/// Joint values of a file's posture, m and rad.
pub fn metres(chain: &Chain, unit: f64, q: &Value) -> Vec<f64> {
    let scale = |kind: JointKind| if kind == JointKind::Prismatic { unit } else { 1.0 };
    numbers(q).iter().zip(chain.variables()).map(|(x, v)| x * scale(v.kind)).collect()
}

/// Joint values drawn from the limits.
pub fn random_postures(chain: &Chain, count: usize, seed: u64) -> Vec<f64> {
    let mut random = solids::Random::new(seed);
    let each = |_| chain.variables().iter().map(|v| (v.lower, v.upper)).collect::<Vec<_>>();
    (0..count).flat_map(each).map(|(lower, upper)| random.between(lower, upper)).collect()
}
