//! The two-step method on the made-up scene of the cucumber data.
#![allow(clippy::unwrap_used)]

mod common;

use std::sync::Arc;

use agrik_motion::Bodies;
use agrik_motion::harvest::{
    DIFFERENTIAL, Decision, GENETIC, Mode, Programme, Roles, Settings, Stage, Station, Status,
    Target, Weights, blockers, decide, full, plan,
};
use agrik_solids::{Cloud, Cuboid, Object, Scene, Split};
use common::{bodies, numbers};
use serde_json::Value;

const TREE: Mode = Mode::Tree { level: 3, split: Split::Equal };

fn file(name: &str) -> Value {
    let path = format!("{}/../../tests/data/cucumber/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn three(value: &Value) -> [f64; 3] {
    let v = numbers(value);
    [v[0] * 1e-3, v[1] * 1e-3, v[2] * 1e-3]
}

struct Made {
    scene: Arc<Scene>,
    targets: Vec<Target>,
    roles: Roles,
    bodies: Arc<Bodies>,
}

/// A scene in metres, without some objects and with more points.
fn made(name: &str, without: &[&str], more: &[[f64; 3]]) -> Made {
    let file = file(name);
    let bodies = bodies("cucumber", true);
    let mut objects: Vec<Object> = Vec::new();
    for object in file["objects"].as_array().unwrap() {
        let name = object["name"].as_str().unwrap();
        if without.contains(&name) {
            continue;
        }
        let points: Vec<[f64; 3]> =
            object["points"].as_array().unwrap().iter().map(three).collect();
        let cloud = Cloud::new(&points, object["radius"].as_f64().unwrap() * 1e-3).unwrap();
        let mut made = Object::new(name, object["kind"].as_str().unwrap()).with_cloud(cloud);
        made.removable = made.kind == "leaf";
        objects.push(made);
    }
    if !more.is_empty() {
        let points: Vec<[f64; 3]> = more.iter().map(|p| p.map(|x| x * 1e-3)).collect();
        let mut extra =
            Object::new("extra", "leaf").with_cloud(Cloud::new(&points, 0.025).unwrap());
        extra.removable = true;
        objects.push(extra);
    }
    let first = objects.len();
    for fixed in file["static_boxes"].as_array().unwrap() {
        let cuboid = Cuboid::upright(three(&fixed["centre"]), three(&fixed["half"])).unwrap();
        objects.push(Object::new(fixed["name"].as_str().unwrap(), "machine").with(cuboid));
    }
    let statics = (first..objects.len()).collect();
    let scene = Scene::new(objects).unwrap();
    let skip = file["static_skip"].as_array().unwrap().iter().map(|pair| {
        let body = bodies.body(pair[0].as_str().unwrap()).unwrap();
        (body, scene.object(pair[1].as_str().unwrap()).unwrap())
    });
    let skip = skip.collect();
    let mut targets = Vec::new();
    for key in ["targets", "extra_targets"] {
        for (name, point) in file[key].as_object().unwrap() {
            let fruit = file["target_fruit"][name].as_str();
            let own = fruit.map(|fruit| [fruit.to_owned(), format!("stalk_{fruit}")]);
            let index = |name: &String| scene.object(name).ok();
            let objects = own.iter().flatten().filter_map(index).collect();
            targets.push(Target { name: name.clone(), point: three(point), objects });
        }
    }
    let touching = ["gripper", "flange"].map(|name| bodies.body(name).unwrap()).to_vec();
    let roles = Roles { statics, skip, touching, moved: [0.0; 3] };
    Made { scene: Arc::new(scene), targets, roles, bodies }
}

impl Made {
    fn station(&self, mode: Mode) -> Station {
        let (bodies, scene) = (Arc::clone(&self.bodies), Arc::clone(&self.scene));
        Station::new(bodies, scene, &self.roles, mode).unwrap()
    }

    fn target(&self, name: &str) -> &Target {
        self.targets.iter().find(|target| target.name == name).unwrap()
    }
}

const STATUSES: [(&str, Status); 6] = [
    ("C1", Status::Ok),
    ("C2", Status::NoCollisionFree),
    ("C3", Status::ApproachBlocked),
    ("C4", Status::Ok),
    ("too_far", Status::OutOfReach),
    ("too_low", Status::OutOfReach),
];

/// What every posture keeps, by other means than those that found it.
fn check(made: &Made, station: &Station, target: &Target, found: &Decision, settings: &Settings) {
    let row = found.row.unwrap();
    let chain = station.chain();
    assert!(chain.within_limits(&row.q));
    let poses = chain.link_poses(&row.q);
    let tool = poses.last().unwrap();
    let off = [0, 1, 2].map(|k| tool[(k, 3)] - target.point[k]);
    assert!(off.iter().all(|off| off.abs() < 1e-12), "{off:?}");
    assert!((tool[(2, 0)] + 1.0).abs() < 1e-12);
    let mut least = f64::INFINITY;
    for (index, body) in station.around().bodies().bodies().iter().enumerate() {
        let mut placed = station.around().bodies().room();
        station.around().bodies().place(&row.q, &mut placed).unwrap();
        let solid = &placed.solids()[index];
        for (object, of) in made.scene.objects().iter().enumerate() {
            let fixed = made.roles.statics.contains(&object);
            let own = target.objects.contains(&object);
            if fixed || own && (body.name == "gripper" || body.name == "flange") {
                continue;
            }
            for [x, y, z, r] in of.clouds.iter().flat_map(|cloud| cloud.spheres()) {
                let ball = agrik_solids::Solid::sphere([x, y, z], r).unwrap();
                least = least.min(agrik_solids::distance(solid, &ball));
            }
        }
    }
    assert!((least - found.exact).abs() < 1e-12, "{least} {}", found.exact);
    assert!(row.distance <= found.exact + 1e-12);
    assert!(row.distance >= settings.min_distance && row.freedom >= settings.min_freedom);
}

#[test]
fn statuses_of_the_scene() {
    let made = made("scene", &[], &[]);
    for mode in [TREE, Mode::Exact] {
        let station = made.station(mode);
        for (recovery, refine) in [(true, false), (false, false), (true, true)] {
            let settings = Settings { refine, recovery, ..Settings::default() };
            for (name, status) in STATUSES {
                let target = made.target(name);
                let found = decide(&station, target, &settings).unwrap();
                assert_eq!(found.status, status, "{name}, {mode:?}");
                assert_eq!(found.row.is_some(), status == Status::Ok);
                if status == Status::Ok {
                    check(&made, &station, target, &found, &settings);
                }
            }
        }
    }
}

#[test]
fn the_full_scan_agrees_and_is_never_worse() {
    let made = made("scene", &[], &[]);
    let settings = Settings::default();
    for mode in [TREE, Mode::Exact] {
        let station = made.station(mode);
        for target in &made.targets {
            let (two, all) = (
                decide(&station, target, &settings).unwrap(),
                full(&station, target, &settings).unwrap(),
            );
            let status = match two.status {
                Status::ApproachBlocked => Status::NoCollisionFree,
                other => other,
            };
            assert_eq!(all.status, status, "{}", target.name);
            if let (Some(two), Some(all)) = (two.row, all.row) {
                assert!(all.score >= two.score);
            }
        }
    }
}

#[test]
fn numbers_of_the_reference() {
    let made = made("scene", &[], &[]);
    let station = made.station(Mode::Exact);
    let settings = Settings::default();
    let near = |a: f64, b: f64, by: f64| assert!((a - b).abs() <= by, "{a}, {b}");
    let c1 = full(&station, made.target("C1"), &settings).unwrap();
    near(1e3 * c1.row.unwrap().distance, 23.3, 0.05);
    near(c1.row.unwrap().freedom, 0.64, 0.005);
    let c4 = full(&station, made.target("C4"), &settings).unwrap();
    near(1e3 * c4.row.unwrap().distance, 60.5, 0.05);
    near(c4.row.unwrap().freedom, 0.30, 0.005);
    let settings = Settings { refine: true, ..settings };
    let c1 = decide(&station, made.target("C1"), &settings).unwrap();
    near(1e3 * c1.row.unwrap().distance, 23.6, 0.05);
    let tree = made.station(TREE);
    let c1 = decide(&tree, made.target("C1"), &settings).unwrap();
    let row = c1.row.unwrap();
    near(1e3 * row.distance, 18.4, 0.05);
    near(1e3 * c1.exact, 23.2, 0.05);
    near(row.psi.to_degrees(), 37.2, 0.05);
    near(1e3 * row.slide, 806.0, 0.5);
    assert!(c1.refined);
}

#[test]
fn recovery_finds_another_angle() {
    let spoiled = [[183.8, 62.3, 1253.3], [166.5, -180.2, 1288.6], [191.8, -317.7, 1192.5]];
    let made = made("scene", &[], &spoiled);
    let target = made.target("C1");
    let station = made.station(Mode::Exact);
    let without = Settings { recovery: false, ..Settings::default() };
    let found = decide(&station, target, &without).unwrap();
    assert_eq!(found.status, Status::NoCollisionFree);
    assert_eq!(found.attempts.len(), 1);
    assert!((found.attempts[0].psi.to_degrees() - 37.5).abs() < 1e-9);
    let found = decide(&station, target, &Settings::default()).unwrap();
    let row = found.row.unwrap();
    assert_eq!((found.stage, found.attempts.len()), (Stage::NextAngle, 4));
    check(&made, &station, target, &found, &Settings::default());
    assert!(1e3 * row.distance < 7.0);
    // It is free by little, which the spheres of the cells use up: they find none, and never
    // one that is not free.
    let tree = decide(&made.station(TREE), target, &Settings::default()).unwrap();
    assert_eq!(tree.status, Status::NoCollisionFree);
    // Angle after angle, however near they are, it takes longer.
    let near = Settings { spread: 0.0, most_angles: 73, ..Settings::default() };
    assert!(decide(&station, target, &near).unwrap().attempts.len() > 4);
}

#[test]
fn what_blocks_is_named_and_its_removal_helps() {
    for (name, count) in [("C2", 1), ("C3", 3)] {
        let made = self::made("scene", &[], &[]);
        for mode in [TREE, Mode::Exact] {
            let station = made.station(mode);
            let settings = Settings::default();
            let found = blockers(&station, made.target(name), &settings).unwrap().unwrap();
            assert!(found.exact);
            assert_eq!(found.objects.len(), count);
            let objects = made.scene.objects();
            assert!(found.objects.iter().all(|index| objects[*index].kind == "leaf"));
            let gone: Vec<&str> =
                found.objects.iter().map(|index| objects[*index].name.as_str()).collect();
            let after = self::made("scene", &gone, &[]);
            let station = after.station(mode);
            let decision = decide(&station, after.target(name), &settings).unwrap();
            assert_eq!(decision.status, Status::Ok, "{name} without {gone:?}");
            let all = full(&station, after.target(name), &settings).unwrap();
            assert!((all.row.unwrap().score - found.row.score).abs() < 1e-12);
            // No smaller set does.
            for left in 0..gone.len() {
                let fewer: Vec<&str> =
                    gone.iter().enumerate().filter(|(i, _)| *i != left).map(|x| *x.1).collect();
                let made = self::made("scene", &fewer, &[]);
                let station = made.station(mode);
                let decision = full(&station, made.target(name), &settings).unwrap();
                assert_ne!(decision.status, Status::Ok);
            }
        }
    }
    let made = made("scene", &[], &[]);
    let station = made.station(Mode::Exact);
    let free = blockers(&station, made.target("C1"), &Settings::default()).unwrap().unwrap();
    assert!(free.objects.is_empty());
    let far = blockers(&station, made.target("too_far"), &Settings::default()).unwrap();
    assert_eq!(far, None);
}

#[test]
fn the_same_on_any_number_of_threads() {
    let made = made("scene", &[], &[]);
    let station = made.station(TREE);
    let targets: Vec<Target> = (0..40)
        .map(|k| {
            let mut target = made.targets[k % made.targets.len()].clone();
            target.point[1] += 1e-3 * k as f64;
            target
        })
        .collect();
    let settings = Settings { refine: true, tilt: 0.17, shift: 0.02, ..Settings::default() };
    let one = plan(&station, &targets, &settings, false, 1, &mut || true).unwrap();
    let four = plan(&station, &targets, &settings, false, 4, &mut || true).unwrap();
    assert_eq!(one, four);
    assert!(one.iter().any(|d| d.status == Status::Ok));
}

#[test]
fn a_gripper_that_may_tilt_finds_more() {
    let made = made("scene", &[], &[]);
    let station = made.station(Mode::Exact);
    let settings = Settings { tilt: 0.17, shift: 0.02, ..Settings::default() };
    let found = decide(&station, made.target("C2"), &settings).unwrap();
    if let Some(row) = found.row {
        assert_eq!(found.stage, Stage::TiltShift);
        let pose = station.chain().link_poses(&row.q).pop().unwrap();
        let target = made.target("C2").point;
        assert!((pose[(2, 3)] - target[2] - found.shift).abs() < 1e-12);
        assert!((pose[(2, 2)] - found.tilt.sin()).abs() < 1e-12);
    }
    assert!(found.attempts.iter().any(|attempt| attempt.stage == Stage::TiltShift));
}

#[test]
fn bad_settings_are_refused() {
    let made = made("scene", &[], &[]);
    let station = made.station(TREE);
    let go = &mut || true;
    let mut refused = |settings: Settings, word: &str| {
        let error = plan(&station, &made.targets, &settings, false, 1, go).unwrap_err();
        assert!(error.to_string().contains(word), "{error}");
    };
    let usual = Settings::default();
    refused(Settings { distance_weight: 0.0, freedom_weight: 0.0, ..usual }, "all zero");
    refused(Settings { angles: 0, ..usual }, "angles");
    refused(Settings { enough: f64::NAN, ..usual }, "enough");
    let lost = Target { name: "lost".into(), point: [f64::NAN, 0.0, 0.0], objects: vec![] };
    let found = plan(&station, &[lost], &usual, false, 1, &mut || true).unwrap();
    assert_eq!(found[0].status, Status::BadInput);
}

#[test]
fn the_programme_finds_what_the_scan_finds() {
    let made = made("scene_thin", &[], &[]);
    let station = made.station(Mode::Exact);
    let target = made.target("C1");
    let programme = Programme::new(station.around(), target, Weights::default()).unwrap();
    // The scan is exact in position and orientation, so that distance alone counts.
    let settings = Settings {
        distance_weight: 1.0,
        freedom_weight: 0.0,
        min_distance: 0.0,
        min_freedom: 0.0,
        ..Settings::default()
    };
    let scan = full(&station, target, &settings).unwrap().row.unwrap();
    let terms = programme.terms(&scan.q).unwrap();
    println!("scan {terms:?}");
    assert!(terms.cost < 1e-9 && terms.distance > 0.075);
    assert!((terms.distance - scan.distance).abs() < 1e-12);
    for (name, settings) in [("de", DIFFERENTIAL), ("ga", GENETIC)] {
        let start = std::time::Instant::now();
        let runs = programme.searches(&settings, &[0, 1, 2, 3], 1, &mut || true).unwrap();
        println!("{name} {:.2} s", start.elapsed().as_secs_f64());
        for run in &runs {
            println!("   {:?} {}", run.terms, run.generations);
            assert!(run.history.windows(2).all(|pair| pair[1] <= pair[0]));
            assert!((run.terms.cost - run.history.last().unwrap()).abs() < 1e-12);
        }
        let again = programme.searches(&settings, &[2], 2, &mut || true).unwrap();
        assert_eq!(again[0], runs[2]);
    }
}
