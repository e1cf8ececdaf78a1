//! Bodies of two arms at 100 postures each in six scenes, against numbers worked out beside
//! this library.
#![allow(clippy::unwrap_used)]

mod common;

use agrik_motion::body::Reason;
use common::{Arm, bodies, chain, collider, metres, read};

#[test]
fn every_answer_is_that_of_the_reference() {
    for (name, scenes) in
        [("cucumber", "scene greenhouse1 greenhouse2"), ("panda", "bench wall greenhouse5")]
    {
        let (arm, chain) = (Arm::read(name), chain(name));
        let postures = read(&format!("postures_{name}.json"));
        for scene in scenes.split(' ') {
            let collider = collider(name, scene);
            let rows: Vec<_> = postures
                .as_array()
                .unwrap()
                .iter()
                .filter(|posture| posture.get(scene).is_some())
                .collect();
            assert_eq!(rows.len(), 100);
            let q: Vec<f64> =
                rows.iter().flat_map(|row| metres(&chain, arm.unit, &row["q"])).collect();
            let go = &mut || true;
            let found = collider.distances(&q, f64::INFINITY, 1, go).unwrap();
            let least = collider.clearances(&q, f64::INFINITY, false, 1, go).unwrap();
            let with_own = collider.clearances(&q, f64::INFINITY, true, 1, go).unwrap();
            let hits = collider.collides(&q, 0.0, 1, go).unwrap();
            let count = arm.bodies.len();
            for (i, row) in rows.iter().enumerate() {
                let near = |found: f64, known: f64| {
                    let off = found / arm.unit - known;
                    assert!(off.abs() < 1.01e-7, "{name}, {scene}, posture {i}: {off}");
                };
                let of_bodies = &found.bodies[i * count..(i + 1) * count];
                for (body, one) in of_bodies.iter().enumerate() {
                    match row[scene]["D"][body].as_f64() {
                        Some(known) => near(one.distance, known),
                        None => assert_eq!(one.distance, f64::INFINITY),
                    }
                }
                let nearest =
                    of_bodies.iter().min_by(|a, b| a.distance.total_cmp(&b.distance)).unwrap();
                let object = &collider.scene().objects()[nearest.object.unwrap()].name;
                assert_eq!(object, row[scene]["object"].as_str().unwrap());
                let own = found.own[i];
                near(own.distance, row["self"].as_f64().unwrap());
                let (a, b) = own.pair.unwrap();
                assert_eq!(row["self_pair"][0], arm.bodies[a].name.as_str());
                assert_eq!(row["self_pair"][1], arm.bodies[b].name.as_str());
                assert_eq!(least[i], nearest.distance);
                assert_eq!(with_own[i], least[i].min(own.distance));
                assert_eq!(hits[i], with_own[i] <= 0.0);
            }
        }
    }
}

#[test]
fn the_rules_find_the_pairs_of_the_reference() {
    let names = |name: &str, listed: bool| -> Vec<(String, String)> {
        let bodies = bodies(name, listed);
        let name = |body: usize| bodies.bodies()[body].name.clone();
        bodies.self_pairs().iter().map(|(i, j)| (name(*i), name(*j))).collect()
    };
    assert_eq!(names("panda", false), names("panda", true));
    // The list of the other arm leaves out neighbours but one, whether or not they can hit.
    let listed = names("cucumber", true);
    let mut more = names("cucumber", false);
    more.retain(|pair| !listed.contains(pair));
    let expected = [("base", "upper_arm"), ("shoulder", "elbow"), ("elbow", "wrist")];
    assert_eq!(more, expected.map(|(a, b)| (a.to_owned(), b.to_owned())));

    let panda = bodies("panda", false);
    let pairs = panda.len() * (panda.len() - 1) / 2;
    assert_eq!(panda.self_pairs().len() + panda.excluded_pairs().len(), pairs);
    let reason = |a: &str, b: &str| {
        let pair = (panda.body(a).unwrap(), panda.body(b).unwrap());
        panda.excluded_pairs().iter().find(|excluded| excluded.pair == pair).unwrap().reason
    };
    assert_eq!(reason("hand", "fingers"), Reason::SameLink);
    assert_eq!(reason("link6", "link7"), Reason::Adjacent);
    assert!(matches!(reason("elbow", "forearm"), Reason::Structural(s) if (s - 0.43).abs() < 0.03));
    assert!(matches!(reason("wrist5", "link7"), Reason::Structural(s) if s > 0.25));
}
