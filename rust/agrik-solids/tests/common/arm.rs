//! The arms and scenes of `tests/data`, and where the bodies of an arm are at a posture.

#![allow(
    dead_code,
    clippy::panic,
    clippy::unwrap_used,
    reason = "test data are sound, and each user takes a part"
)]

use std::path::Path;

use agrik_solids::{
    Cloud, Core, Cuboid, Exemption, HalfSpace, Object, Point, Pose, Scene, Segment, Solid,
};
use serde_json::Value;

/// A file of `tests/data`.
pub fn read(name: &str) -> Value {
    // Those of the crate above this one read them as well.
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../agrik-solids/tests/data").join(name);
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn point(value: &Value, unit: f64) -> Point {
    let [x, y, z] = numbers(value)[..] else { panic!("no point: {value}") };
    [x * unit, y * unit, z * unit]
}

fn rows(value: &Value) -> [[f64; 3]; 3] {
    std::array::from_fn(|row| point(&value[row], 1.0))
}

fn pose(value: &Value, unit: f64) -> Pose {
    let row = |k: usize| numbers(&value[k]);
    Pose {
        rotation: std::array::from_fn(|k| [row(k)[0], row(k)[1], row(k)[2]]),
        translation: std::array::from_fn(|k| row(k)[3] * unit),
    }
}

fn solid(value: &Value, unit: f64) -> Solid {
    let radius = value["radius"].as_f64().unwrap_or(0.0) * unit;
    let core = match value["shape"].as_str().unwrap_or("box") {
        "box" => {
            let turn = value.get("R").map_or(Pose::IDENTITY.rotation, rows);
            let (centre, half) = (point(&value["centre"], unit), point(&value["half"], unit));
            Core::Cuboid(Cuboid::new(centre, half, turn).unwrap())
        }
        "capsule" => {
            let (a, b) = (point(&value["a"], unit), point(&value["b"], unit));
            Core::Segment(Segment::new(a, b).unwrap())
        }
        "sphere" => Core::Point(point(&value["centre"], unit)),
        other => panic!("no shape: {other}"),
    };
    Solid::new(core, radius).unwrap()
}

/// One body of an arm.
pub struct Body {
    pub name: String,
    pub frame: usize,
    pub solid: Solid,
}

/// An arm with its bodies.
pub struct Arm {
    /// Length of the unit of the files, m.
    pub unit: f64,
    pub bodies: Vec<Body>,
    /// Pairs of bodies that may hit each other.
    pub self_pairs: Vec<(usize, usize)>,
    base: Pose,
    /// Type and constant pose of each joint.
    joints: Vec<(bool, Pose)>,
    /// Names of a body and of an object that it never minds.
    skip: Vec<(String, String)>,
}

impl Arm {
    pub fn read(name: &str) -> Self {
        let file = read(&format!("{name}.json"));
        let unit = if file["unit"] == "mm" { 1e-3 } else { 1.0 };
        let each = |value: &Value| value.as_array().cloned().unwrap_or_default();
        let name = |value: &Value| value.as_str().unwrap().to_owned();
        let bodies: Vec<Body> = each(&file["bodies"])
            .iter()
            .map(|body| Body {
                name: name(&body["name"]),
                frame: body["frame"].as_u64().unwrap() as usize,
                solid: solid(body, unit),
            })
            .collect();
        let index = |value: &Value| bodies.iter().position(|b| value == b.name.as_str()).unwrap();
        Self {
            unit,
            self_pairs: each(&file["self_pairs"])
                .iter()
                .map(|pair| (index(&pair[0]), index(&pair[1])))
                .collect(),
            base: pose(&file["base"], unit),
            joints: each(&file["joints"])
                .iter()
                .map(|joint| (joint["type"] == "P", pose(&joint["C"], unit)))
                .collect(),
            skip: each(&file["static_skip"])
                .iter()
                .map(|pair| (name(&pair[0]), name(&pair[1])))
                .collect(),
            bodies,
        }
    }

    /// Where the frames are; joint values in the units of the files.
    pub fn frames(&self, q: &[f64]) -> Vec<Pose> {
        let mut at = self.base;
        let mut frames = vec![at];
        for ((slides, fixed), q) in self.joints.iter().zip(q) {
            let moved = if *slides {
                Pose { translation: [0.0, 0.0, q * self.unit], ..Pose::IDENTITY }
            } else {
                let (s, c) = q.sin_cos();
                let rotation = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]];
                Pose { rotation, ..Pose::IDENTITY }
            };
            at = at.of(fixed).of(&moved);
            frames.push(at);
        }
        frames
    }

    /// The bodies where they are then.
    pub fn placed(&self, q: &[f64]) -> Vec<Solid> {
        let frames = self.frames(q);
        self.bodies.iter().map(|body| body.solid.placed(&frames[body.frame])).collect()
    }

    /// What each body does not mind: the foot of the arm nothing at all.
    pub fn exemptions(&self, scene: &Scene) -> Vec<Exemption> {
        let ignores = |body: &Body, object: &str| {
            let skipped = |(name, what): &(String, String)| *name == body.name && what == object;
            body.frame == 0 || self.skip.iter().any(skipped)
        };
        let of = |body: &Body| {
            let names = scene.objects().iter().map(|object| object.name.as_str());
            scene.exempt(names.filter(|name| ignores(body, name))).unwrap()
        };
        self.bodies.iter().map(of).collect()
    }
}

/// The objects of a scene of the files of an arm.
pub fn objects(scene: &Value, unit: f64) -> Vec<Object> {
    let each = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let mut objects = Vec::new();
    for object in each(&scene["objects"]) {
        let kind = object["kind"].as_str().unwrap();
        let mut made = Object::new(object["name"].as_str().unwrap(), kind);
        made.removable = object["removable"] == true;
        let spheres = each(&object["spheres"]);
        made = made.with_cloud(
            Cloud::of(spheres.iter().map(|row| {
                let row = numbers(row);
                std::array::from_fn(|k| row[k] * unit)
            }))
            .unwrap(),
        );
        for row in each(&object["capsules"]) {
            let [ax, ay, az, bx, by, bz, r] = numbers(&row)[..] else { panic!("no capsule") };
            let [a, b] = [[ax, ay, az], [bx, by, bz]].map(|p| p.map(|x| x * unit));
            made = made.with(Solid::capsule(a, b, r * unit).unwrap());
        }
        for row in each(&object["boxes"]) {
            made = made.with(solid(&row, unit));
        }
        for row in each(&object["halfspaces"]) {
            let [x, y, z, offset] = numbers(&row)[..] else { panic!("no half-space") };
            made = made.with(HalfSpace::new([x, y, z], offset * unit).unwrap());
        }
        objects.push(made);
    }
    objects
}
