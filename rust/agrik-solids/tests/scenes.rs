//! Scenes against a search through everything they hold: booleans, distances, nearest
//! objects, with and without exemptions, at every level of instructions.

#![allow(clippy::unwrap_used)]

mod common;

use agrik_solids::lanes::Level;
use agrik_solids::{
    Cloud, Core, Cuboid, Exemption, HalfSpace, Hull, Object, Point, Scene, Segment, Solid, closest,
};
use common::{Random, norm, rotation, sub};

fn levels() -> Vec<Level> {
    Level::ALL.into_iter().filter(|level| level.is_available()).collect()
}

/// A body of any kind about a place.
fn body(random: &mut Random, at: Point, size: f64) -> Solid {
    let mut near = |spread: f64| at.map(|x| x + random.between(-spread, spread));
    let (a, b) = (near(size), near(size));
    let points = (0..9).map(|_| near(size)).collect();
    let turn = rotation([0, 1, 2, 3].map(|_| random.between(-1.0, 1.0)));
    let half = [0, 1, 2].map(|_| random.between(0.0, size));
    let core = match random.below(4) {
        0 => Core::Point(a),
        1 => Core::Segment(Segment::new(a, b).unwrap()),
        2 => Core::Cuboid(Cuboid::new(a, half, turn).unwrap()),
        _ => Core::Hull(Hull::new(points).unwrap()),
    };
    let radius = random.between(0.0, size);
    Solid::new(core, if random.below(3) == 0 { 0.0 } else { radius }).unwrap()
}

/// Objects of all kinds in a cube of 2 m.
fn objects(random: &mut Random, count: usize) -> Vec<Object> {
    (0..count)
        .map(|index| {
            let at = [0, 1, 2].map(|_| random.between(-1.0, 1.0));
            let mut object = Object::new(format!("object{index}"), "thing");
            for _ in 0..1 + random.below(3) {
                object = object.with(body(random, at, 0.2));
            }
            let rows = (0..random.below(40)).map(|_| {
                let [x, y, z] = at.map(|x| x + random.between(-0.3, 0.3));
                [x, y, z, 0.02 * random.between(0.0, 1.0)]
            });
            object.with_cloud(Cloud::of(rows.collect::<Vec<_>>()).unwrap())
        })
        .collect()
}

/// All solids of an object.
fn parts(object: &Object) -> impl Iterator<Item = Solid> {
    let spheres = object.clouds.iter().flat_map(|cloud| cloud.spheres());
    let spheres = spheres.map(|[x, y, z, r]| Solid::sphere([x, y, z], r).unwrap());
    object.solids.iter().cloned().chain(spheres)
}

/// Distance of each object, by asking every solid.
fn everything(scene: &Scene, solid: &Solid) -> Vec<f64> {
    let of = |object: &Object| {
        parts(object).map(|part| closest(solid, &part).distance).fold(f64::INFINITY, f64::min)
    };
    scene.objects().iter().map(of).collect()
}

/// Fails unless a scene says of a body what the search through everything says.
fn compare(scene: &Scene, solid: &Solid, exempt: &Exemption, left_out: &[usize]) {
    let mut all = everything(scene, solid);
    for index in left_out {
        all[*index] = f64::INFINITY;
    }
    let least = all.iter().copied().fold(f64::INFINITY, f64::min);
    let same = |a: f64, b: f64| (a - b).abs() < 1e-12 || a == b;
    let found = scene.nearest(solid, exempt, f64::INFINITY);
    let distance = found.map_or(f64::INFINITY, |found| found.distance);
    assert!(same(distance, least), "{distance}, not {least}: {solid:?}");
    if let Some(found) = found {
        assert!(same(all[found.object], least), "object {}", found.object);
        if found.distance > 0.0 {
            let apart = norm(sub(found.on_solid, found.on_object));
            assert!((apart - least).abs() < 1e-9, "{apart} between the points, not {least}");
        }
    }
    for cap in [-0.05, 0.0, 0.05, 0.3] {
        assert_eq!(scene.distance(solid, exempt, cap), distance.min(cap));
        assert_eq!(scene.hits(solid, exempt, cap), distance <= cap.max(0.0));
        assert_eq!(scene.nearest(solid, exempt, cap).is_some(), distance <= cap);
    }
    // A reach that ends just before and just behind the nearest.
    let grain = 1e-9;
    if least > grain && least.is_finite() {
        assert!(scene.hits(solid, exempt, least + grain), "{least}: {solid:?}");
        assert!(!scene.hits(solid, exempt, least - grain), "{least}: {solid:?}");
    }
    let near = scene.all_within(solid, exempt, 0.3);
    let expected = all.iter().filter(|distance| **distance <= 0.3).count();
    assert_eq!(near.len(), expected);
    assert!(near.iter().all(|near| same(near.distance, all[near.object])));
    assert!(near.is_sorted_by(|a, b| a.distance <= b.distance));
}

#[test]
fn a_scene_says_what_a_search_through_everything_says() {
    let mut random = Random::new(1);
    for count in [1, 2, 7, 60, 150] {
        let scene = Scene::new(objects(&mut random, count)).unwrap();
        for level in levels() {
            let scene = scene.clone().at_level(level);
            for _ in 0..60 {
                let at = [0, 1, 2].map(|_| random.between(-1.3, 1.3));
                let solid = body(&mut random, at, 0.15);
                compare(&scene, &solid, &Exemption::none(), &[]);
                // More labels than there are bits to a word are left out one by one.
                let left_out: Vec<usize> = (0..count).filter(|_| random.below(2) == 0).collect();
                let names = left_out.iter().map(|i| scene.objects()[*i].name.as_str());
                let exempt = scene.exempt(names).unwrap();
                compare(&scene, &solid, &exempt, &left_out);
            }
        }
    }
}

#[test]
fn half_spaces_count_and_may_ask_themselves() {
    let mut random = Random::new(2);
    let mut made = objects(&mut random, 5);
    made.push(Object::new("ground", "ground").with(HalfSpace::new([0.0, 0.1, 1.0], -1.2).unwrap()));
    let scene = Scene::new(made).unwrap();
    for _ in 0..100 {
        let at = [0, 1, 2].map(|_| random.between(-1.5, 1.5));
        compare(&scene, &body(&mut random, at, 0.2), &Exemption::none(), &[]);
    }
    let wall = Solid::from(HalfSpace::new([1.0, 0.0, 0.0], -1.5).unwrap());
    let exempt = scene.exempt(["ground"]).unwrap();
    compare(&scene, &wall, &exempt, &[5]);
}

#[test]
fn points_in_odd_places_are_found_as_others_are() {
    let mut random = Random::new(3);
    let mut anywhere = || [0, 1, 2].map(|_| random.between(-1.0, 1.0));
    let line = |k: usize| [k as f64 * 0.01, 0.0, 0.0];
    let clouds: Vec<(&str, Vec<Point>)> = vec![
        ("none", Vec::new()),
        ("one", vec![[0.1, 0.2, 0.3]]),
        ("all the same", vec![[0.1, 0.2, 0.3]; 1000]),
        ("in a line", (0..1000).map(line).collect()),
        ("in a plane", (0..1000).map(|_| anywhere()).map(|[x, y, _]| [x, y, 0.5]).collect()),
        ("anywhere", (0..20_000).map(|_| anywhere()).collect()),
    ];
    for (what, points) in clouds {
        let cloud = Cloud::new(&points, 0.01).unwrap();
        let scene = Scene::new(vec![Object::new(what, "cloud").with_cloud(cloud)]).unwrap();
        for level in levels() {
            let scene = scene.clone().at_level(level);
            for _ in 0..30 {
                let at = [0, 1, 2].map(|_| random.between(-1.5, 1.5));
                compare(&scene, &body(&mut random, at, 0.1), &Exemption::none(), &[]);
            }
        }
    }
}

#[test]
fn an_empty_scene_is_infinitely_far() {
    let scene = Scene::new(Vec::new()).unwrap();
    let ball = Solid::sphere([0.0; 3], 1.0).unwrap();
    let none = Exemption::none();
    assert_eq!(scene.distance(&ball, &none, f64::INFINITY), f64::INFINITY);
    assert_eq!(scene.distance(&ball, &none, 0.5), 0.5);
    assert!(scene.nearest(&ball, &none, f64::INFINITY).is_none());
    assert!(!scene.hits(&ball, &none, 1e9));
    assert!(scene.all_within(&ball, &none, f64::INFINITY).is_empty());
}

#[test]
fn a_scene_far_away_keeps_its_digits() {
    let mut random = Random::new(4);
    let shift = [7e3, -7e3, 1e3];
    let moved: Vec<Object> = objects(&mut random, 20)
        .into_iter()
        .map(|mut object| {
            let pose = agrik_solids::Pose { translation: shift, ..agrik_solids::Pose::IDENTITY };
            for solid in &mut object.solids {
                *solid = solid.placed(&pose);
            }
            object.clouds.clear();
            object
        })
        .collect();
    let scene = Scene::new(moved).unwrap();
    for _ in 0..200 {
        let at = shift.map(|x| x + random.between(-1.3, 1.3));
        let solid = body(&mut random, at, 0.15);
        let least = everything(&scene, &solid).into_iter().fold(f64::INFINITY, f64::min);
        let found = scene.distance(&solid, &Exemption::none(), f64::INFINITY);
        assert!((found - least).abs() < 1e-11);
        assert!(scene.hits(&solid, &Exemption::none(), least + 1e-9));
        assert!(least < 1e-9 || !scene.hits(&solid, &Exemption::none(), least - 1e-9));
    }
    // From where the origin is, all of it is 10 km away.
    let here = body(&mut random, [0.0; 3], 0.1);
    let least = everything(&scene, &here).into_iter().fold(f64::INFINITY, f64::min);
    let found = scene.distance(&here, &Exemption::none(), f64::INFINITY);
    assert!((found - least).abs() < 1e-9 && least > 9e3);
}

#[test]
fn clearances_of_objects_are_kept() {
    let mut wire = Object::new("wire", "wire")
        .with(Solid::capsule([0.0, -1.0, 0.0], [0.0, 1.0, 0.0], 0.0).unwrap());
    wire.clearance = 0.1;
    let leaf = Object::new("leaf", "leaf").with(Solid::sphere([1.0, 0.0, 0.0], 0.0).unwrap());
    let scene = Scene::new(vec![wire, leaf]).unwrap();
    let none = Exemption::none();
    let ball = |x: f64| Solid::sphere([x, 0.0, 0.0], 0.01).unwrap();
    for (x, clear, expected) in [
        (0.05, 0.0, Some(0)),
        (0.12, 0.0, None),
        (0.95, 0.0, None),
        (0.95, 0.05, Some(1)),
        (0.3, 0.3, Some(0)),
    ] {
        assert_eq!(scene.hit(&ball(x), &none, clear), expected, "{x}, {clear}");
    }
    // A clearance is no part of the distance.
    assert!((scene.distance(&ball(0.05), &none, 1.0) - 0.04).abs() < 1e-15);
}

#[test]
fn answers_are_the_same_at_every_level_of_instructions() {
    let mut random = Random::new(5);
    let scene = Scene::new(objects(&mut random, 100)).unwrap();
    let scenes: Vec<Scene> =
        levels().into_iter().map(|level| scene.clone().at_level(level)).collect();
    for _ in 0..500 {
        let at = [0, 1, 2].map(|_| random.between(-1.0, 1.0));
        let solid = body(&mut random, at, 0.1);
        let none = Exemption::none();
        let answers: Vec<_> = scenes
            .iter()
            .map(|s| (s.nearest(&solid, &none, 1.0), s.hit(&solid, &none, 0.02)))
            .collect();
        assert!(answers.iter().all(|answer| *answer == answers[0]), "{answers:?}");
    }
}

#[test]
fn what_makes_no_scene_is_refused_by_name() {
    let twice = vec![Object::new("a", "leaf"), Object::new("b", "leaf"), Object::new("a", "stem")];
    let text = Scene::new(twice).unwrap_err().to_string();
    assert!(text.starts_with("objects: expected") && text.contains("\"a\" twice"), "{text}");
    let text = Scene::new(vec![Object::new("", "leaf")]).unwrap_err().to_string();
    assert!(text.starts_with("name: expected"), "{text}");
    for clearance in [f64::NAN, -0.1, f64::INFINITY] {
        let object = Object { clearance, ..Object::new("a", "leaf") };
        let text = Scene::new(vec![object]).unwrap_err().to_string();
        assert!(text.starts_with("clearance of \"a\": expected"), "{text}");
    }
    let scene = Scene::new(vec![Object::new("a", "leaf"), Object::new("b", "leaf")]).unwrap();
    let text = scene.exempt(["b", "c"]).unwrap_err().to_string();
    assert_eq!(text, "object: expected one of a, b, got \"c\"");
    let rows = [[0.0, 0.0, 0.0, 0.1], [0.0, f64::NAN, 0.0, 0.1]];
    assert!(Cloud::of(rows).unwrap_err().to_string().starts_with("points[1]: "));
    assert!(Cloud::of([[0.0, 0.0, 0.0, -0.1]]).unwrap_err().to_string().starts_with("radii[0]: "));
    assert!(Cloud::new(&[[0.0; 3]], f64::NAN).unwrap_err().to_string().starts_with("radius: "));
    let text = Cloud::with_radii(&[[0.0; 3]], &[]).unwrap_err().to_string();
    assert!(text.starts_with("radii: expected one radius for each of 1 points"), "{text}");
}
