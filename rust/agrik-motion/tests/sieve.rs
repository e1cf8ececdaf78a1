//! What the sieve before doubles may do: nothing but save time.
#![allow(clippy::unwrap_used)]

mod common;

use std::sync::Arc;

use agrik::call::Accept;
use agrik::kinematics::{FRAME, frames_abreast, moving_frames};
use agrik_motion::edges::{Certifier, Keep, Outcome};
use agrik_motion::{Bodies, Body, Collider, Free, Shape, Touch};
use agrik_solids::{Core, Object, Scene, Solid, Split};
use common::{collider, random_postures};

const GO: fn() -> bool = || true;

const SCENES: [(&str, &str); 2] =
    [("cucumber", "scene greenhouse1 greenhouse2"), ("panda", "bench wall greenhouse5")];

/// Hits one by one and in doubles alone.
fn one_by_one(collider: &Collider, q: &[f64], clear: f64) -> Vec<bool> {
    let bodies = collider.bodies();
    let mut placed = bodies.room();
    let mut hits = |q: &[f64]| {
        bodies.place(q, &mut placed).unwrap();
        collider.hits(&placed, clear)
    };
    q.chunks(bodies.chain().dof()).map(&mut hits).collect()
}

/// Postures anywhere, and some that lie close together.
fn postures(collider: &Collider, count: usize, seed: u64) -> Vec<f64> {
    let chain = collider.bodies().chain();
    let mut q = random_postures(chain, count, seed);
    for row in 0..count / 2 {
        let first = row / 8 * 8 * chain.dof();
        for k in 0..chain.dof() {
            let at = row * chain.dof() + k;
            q[at] = q[first + k] + 0.03 * (q[at] - q[first + k]);
        }
    }
    q
}

#[test]
fn frames_abreast_are_those_one_by_one() {
    for name in ["cucumber", "panda"] {
        let chain = common::chain(name);
        let size = FRAME * chain.compiled().links.len();
        for rows in 1..=8 {
            let q = random_postures(&chain, rows, rows as u64);
            let (mut wanted, mut found) = (vec![0.0; rows * size], vec![[0.0; 8]; size]);
            moving_frames(&chain, &q, &mut wanted);
            frames_abreast(&chain, &q, &mut found);
            for (k, lanes) in found.iter().enumerate() {
                for (lane, x) in lanes.iter().enumerate() {
                    assert_eq!(x.to_bits(), wanted[lane.min(rows - 1) * size + k].to_bits());
                }
            }
        }
    }
}

#[test]
fn hits_are_those_of_doubles() {
    let mut found = [0; 2];
    for (name, scenes) in SCENES {
        for scene in scenes.split(' ') {
            let collider = collider(name, scene);
            // Enough of them for a field of the crowd to be made on the way.
            let q = postures(&collider, 2500, 8);
            for clear in [0.0, 0.03] {
                let wanted = one_by_one(&collider, &q, clear);
                let hits = collider.collides(&q, clear, 1, &mut { GO }).unwrap();
                assert_eq!(hits, wanted, "{name}, {scene}");
                let accept = Free::new(&collider, clear).unwrap();
                let dof = collider.bodies().chain().dof();
                for (q, wanted) in q.chunks(11 * dof).zip(wanted.chunks(11)).take(20) {
                    let accepted = accept.accepts(q);
                    for (row, hits) in wanted.iter().enumerate() {
                        assert_eq!(accepted >> row & 1 == 0, *hits);
                    }
                    assert_eq!(accepted >> wanted.len(), 0);
                }
                for hit in wanted {
                    found[usize::from(hit)] += 1;
                }
            }
        }
    }
    assert!(found.iter().all(|count| *count > 1000), "{found:?}");
}

#[test]
fn what_is_exempt_wants_distance_or_is_covered_is_seen() {
    let plain = collider("cucumber", "greenhouse1");
    let mut objects = plain.scene().objects().to_vec();
    for object in objects.iter_mut().step_by(5) {
        if object.solids.iter().all(|solid| matches!(solid.core(), Core::Point(_))) {
            object.clearance = 0.05;
        }
    }
    assert!(objects.iter().any(|object| object.clearance > 0.0));
    let scene = Arc::new(Scene::new(objects).unwrap());
    let bodies = plain.bodies();
    let covered: Vec<Body> = bodies
        .bodies()
        .iter()
        .enumerate()
        .map(|(k, body)| match &body.shape {
            Shape::Exact(solid) => match solid.core() {
                Core::Cuboid(cuboid) if k % 2 == 0 => {
                    let shape = Shape::cover(*cuboid, k % 4, Split::Equal, 0.01).unwrap();
                    Body::new(&body.name, body.frame, shape)
                }
                _ => body.clone(),
            },
            Shape::Cover { .. } => body.clone(),
        })
        .collect();
    let pairs = Some(bodies.self_pairs());
    let covered = Arc::new(Bodies::new(Arc::clone(bodies.chain()), covered, pairs).unwrap());
    let mut exempt: Vec<(usize, usize)> =
        (0..bodies.len()).flat_map(|body| (0..9).map(move |object| (body, 3 * object))).collect();
    let stands = ["base", "shoulder"].map(|name| bodies.body(name).unwrap());
    let under = ["slide", "vehicle"].map(|name| scene.object(name).unwrap());
    exempt.extend(stands.iter().flat_map(|body| under.map(|object| (*body, object))));
    let touch = Touch {
        pairs: (0..scene.objects().len()).map(|object| (7, object)).collect(),
        target: [0.6, 0.2, 1.0],
        radius: 0.5,
    };
    for (bodies, touch) in [(bodies, None), (&covered, None), (bodies, Some(&touch))] {
        let (bodies, scene) = (Arc::clone(bodies), Arc::clone(&scene));
        let collider = Collider::new(bodies, scene, &exempt, touch).unwrap();
        let q = postures(&collider, 800, 5);
        let hits = collider.collides(&q, 0.01, 1, &mut { GO }).unwrap();
        assert_eq!(hits, one_by_one(&collider, &q, 0.01));
        assert!(hits.iter().any(|hit| *hit) && hits.iter().any(|hit| !*hit));
    }
}

#[test]
fn a_scene_without_anything_and_one_far_away_hit_nothing() {
    let arm = collider("panda", "bench");
    let far = Object::new("far", "thing").with(Solid::sphere([1e7, 0.0, 0.0], 1.0).unwrap());
    for objects in [Vec::new(), vec![far]] {
        let scene = Arc::new(Scene::new(objects).unwrap());
        let collider = Collider::new(Arc::clone(arm.bodies()), scene, &[], None).unwrap();
        let q = postures(&collider, 200, 3);
        let hits = collider.collides(&q, 0.0, 1, &mut { GO }).unwrap();
        assert_eq!(hits, one_by_one(&collider, &q, 0.0));
    }
}

#[test]
fn ways_that_a_glance_proves_are_safe_for_doubles() {
    let mut known = [0; 3];
    for (name, scenes) in SCENES {
        for scene in scenes.split(' ') {
            let collider = collider(name, scene);
            let dof = collider.bodies().chain().dof();
            let q = random_postures(collider.bodies().chain(), 600, 12);
            for (k, pair) in q.chunks(2 * dof).enumerate() {
                let (from, to) = pair.split_at(dof);
                let share = [0.02, 0.1, 0.3, 1.0][k % 4];
                let to: Vec<f64> = from.iter().zip(to).map(|(a, b)| a + share * (b - a)).collect();
                // Told with a cap, ways are proven in doubles from the beginning.
                let keep = Keep::clear(0.002);
                let quick = Certifier::new(&collider, keep.with_cap(0.002)).segment(from, &to);
                let whole = Certifier::new(&collider, keep.with_cap(0.0021)).segment(from, &to);
                if whole.outcome != Outcome::Undecided {
                    assert_eq!(
                        quick.outcome, whole.outcome,
                        "{name}, {scene}: {quick:?} {whole:?}"
                    );
                }
                if quick.is_safe() {
                    assert_eq!(quick.clearance, 0.002);
                    assert_ne!(whole.outcome, Outcome::Hit);
                }
                known[quick.outcome as usize] += 1;
            }
        }
    }
    assert!(known[0] > 200 && known[1] > 200, "{known:?}");
}

#[test]
fn what_was_asked_before_changes_nothing() {
    let ways = |collider: &Collider| -> Vec<_> {
        let dof = collider.bodies().chain().dof();
        let q = random_postures(collider.bodies().chain(), 120, 31);
        let mut certifier = Certifier::new(collider, Keep::clear(0.002).with_cap(0.002));
        let each = |pair: &[f64]| {
            let (from, to) = pair.split_at(dof);
            let to: Vec<f64> = from.iter().zip(to).map(|(a, b)| a + 0.2 * (b - a)).collect();
            certifier.explained(from, &to)
        };
        q.chunks(2 * dof).map(each).collect()
    };
    let fresh = collider("cucumber", "greenhouse2");
    let first = ways(&fresh);
    let used = collider("cucumber", "greenhouse2");
    let q = random_postures(used.bodies().chain(), 8000, 2);
    used.collides(&q, 0.0, 2, &mut { GO }).unwrap();
    assert_eq!(ways(&used), first);
}
