//! What bodies in a scene say of postures: threads, gradients, touch zones, attached bodies,
//! covers, and what is refused.
#![allow(clippy::unwrap_used)]

mod common;

use std::sync::Arc;

use agrik_motion::{Bodies, Body, Collider, Error, Other, Shape, Touch};
use agrik_solids::{Core, Cuboid, Object, Scene, Solid, Split, distance};
use common::{bodies, chain, collider, random_postures};

const GO: fn() -> bool = || true;

#[test]
fn answers_do_not_depend_on_threads_or_company() {
    for (name, scene) in [("cucumber", "greenhouse1"), ("panda", "bench")] {
        let collider = collider(name, scene);
        let dof = collider.bodies().chain().dof();
        let q = random_postures(collider.bodies().chain(), 600, 3);
        let ask = |q: &[f64], threads| {
            (
                collider.collides(q, 0.01, threads, &mut { GO }).unwrap(),
                collider.clearances(q, f64::INFINITY, true, threads, &mut { GO }).unwrap(),
                collider.distances(q, 0.2, threads, &mut { GO }).unwrap(),
                collider.gradients(q, 0.5, true, threads, &mut { GO }).unwrap(),
            )
        };
        let all = ask(&q, 1);
        for threads in [2, 7] {
            assert_eq!(ask(&q, threads), all);
        }
        let count = collider.bodies().len();
        for (row, q) in q.chunks(dof).enumerate().step_by(7) {
            let alone = ask(q, 1);
            assert_eq!(alone.0[0], all.0[row]);
            assert_eq!(alone.1[0].to_bits(), all.1[row].to_bits());
            assert_eq!(alone.2.bodies, all.2.bodies[row * count..(row + 1) * count]);
            assert_eq!(alone.2.own[0], all.2.own[row]);
            assert_eq!(alone.3.1, all.3.1[row * dof..(row + 1) * dof]);
        }
        let stopped = collider.collides(&q, 0.0, 1, &mut || false);
        assert!(matches!(stopped, Err(Error::Interrupted)));
    }
}

#[test]
fn bodies_may_be_shifted() {
    let arm = collider("cucumber", "greenhouse1");
    let (bodies, count) = (arm.bodies(), arm.bodies().len());
    let rows = 200;
    let q = random_postures(bodies.chain(), rows, 5);
    let plain = arm.clearances(&q, f64::INFINITY, false, 1, &mut { GO }).unwrap();
    let shifted = |by: [f64; 3], threads| {
        let shifts = vec![by; rows * count];
        arm.shifted_clearances(&q, &shifts, threads, &mut { GO }).unwrap()
    };
    for (found, wanted) in shifted([0.0; 3], 1).iter().zip(&plain) {
        assert!((found - wanted).abs() < 1e-12, "{found} {wanted}");
    }
    // All bodies shifted alike are those of an arm that stands elsewhere.
    let by = [0.02, -0.03, 0.01];
    let moved = Collider::new(Arc::new(bodies.moved(by).unwrap()), arm.scene().clone(), &[], None);
    let there = Collider::new(arm.bodies().clone(), arm.scene().clone(), &[], None).unwrap();
    let wanted = moved.unwrap().clearances(&q, f64::INFINITY, false, 1, &mut { GO }).unwrap();
    let shifts = vec![by; rows * count];
    let found = there.shifted_clearances(&q, &shifts, 1, &mut { GO }).unwrap();
    for (found, wanted) in found.iter().zip(&wanted) {
        // The size of a depth depends on how two bodies lie in each other.
        assert!((found.max(0.0) - wanted.max(0.0)).abs() < 1e-9, "{found} {wanted}");
    }
    assert_eq!(shifted(by, 1), shifted(by, 3));
    let few = arm.shifted_clearances(&q, &shifts[1..], 1, &mut { GO });
    assert!(few.unwrap_err().to_string().starts_with("shifts: expected"));
    let wrong = vec![[f64::NAN; 3]; rows * count];
    assert!(arm.shifted_clearances(&q, &wrong, 1, &mut { GO }).is_err());
}

#[test]
fn forms_of_a_question_agree() {
    for (name, scene) in [("cucumber", "scene"), ("panda", "greenhouse5")] {
        let collider = collider(name, scene);
        let bodies = collider.bodies();
        let dof = bodies.chain().dof();
        let q = random_postures(bodies.chain(), 300, 4);
        let least = collider.clearances(&q, f64::INFINITY, true, 1, &mut { GO }).unwrap();
        let capped = collider.clearances(&q, 0.05, true, 1, &mut { GO }).unwrap();
        let contacts = collider.nearest_of_each(&q, 1, &mut { GO }).unwrap();
        let mut placed = bodies.room();
        for (row, q) in q.chunks(dof).enumerate() {
            assert_eq!(capped[row], least[row].min(0.05));
            let contact = contacts[row].unwrap();
            assert_eq!(contact.distance, least[row]);
            bodies.place(q, &mut placed).unwrap();
            for clear in [0.0, 0.02, 0.2] {
                let scene = collider.clearance(&placed, f64::INFINITY, false);
                assert_eq!(collider.hits_scene(&placed, clear), scene <= clear);
                let own = collider.own_clearance(&placed, f64::INFINITY);
                assert_eq!(collider.hits_itself(&placed), own <= 0.0);
                assert_eq!(collider.hits(&placed, clear), scene <= clear || own <= 0.0);
            }
            // The points lie as far apart as is said, where that has a meaning.
            if contact.distance > 0.0 {
                let way = common::solids::sub(contact.on_body, contact.on_other);
                assert!((common::solids::norm(way) - contact.distance).abs() < 1e-12);
            }
            if let Other::Body(other) = contact.other {
                let solids = placed.solids();
                assert_eq!(contact.distance, distance(&solids[contact.body], &solids[other]));
            }
        }
    }
}

#[test]
fn gradients_are_those_of_the_distance() {
    let h = 1e-6;
    for (name, scene) in [("cucumber", "greenhouse2"), ("panda", "wall")] {
        let collider = collider(name, scene);
        let dof = collider.bodies().chain().dof();
        let q = random_postures(collider.bodies().chain(), 200, 5);
        let (least, rates) = collider.gradients(&q, f64::INFINITY, true, 1, &mut { GO }).unwrap();
        let mut near = 0;
        for (row, q) in q.chunks(dof).enumerate() {
            for joint in 0..dof {
                let shifted = |by: f64| {
                    let mut q = q.to_vec();
                    q[joint] += by;
                    collider.clearances(&q, f64::INFINITY, true, 1, &mut { GO }).unwrap()[0]
                };
                let (more, less) = (shifted(h), shifted(-h));
                let rate = rates[row * dof + joint];
                // Where another pair is as near, or a core is met, the slopes of both sides
                // differ.
                let bend = (more - 2.0 * least[row] + less).abs() / h;
                if least[row].abs() > 1e-3 && bend < 1e-4 {
                    near += 1;
                    let slope = (more - less) / (2.0 * h);
                    assert!((slope - rate).abs() < 2e-4, "{name}, {row}, {joint}: {slope} {rate}");
                }
            }
        }
        assert!(near > 200 * dof / 2, "{near} compared");
    }
}

#[test]
fn a_target_may_be_touched_near_by_alone() {
    let arm = bodies("panda", true);
    let chain = chain("panda");
    let (hand, fingers) = (arm.body("hand").unwrap(), arm.body("fingers").unwrap());
    let q = [0.1, 0.3, -0.2, -1.8, 0.1, 2.0, 0.6];
    let mut placed = arm.room();
    arm.place(&q, &mut placed).unwrap();
    let tool = placed.tool();
    let fruit = Object::new("fruit", "fruit").with(Solid::sphere(tool, 0.03).unwrap());
    let scene = Arc::new(Scene::new(vec![fruit]).unwrap());
    let pairs = vec![(hand, 0), (fingers, 0)];
    let with = |exemptions: &[(usize, usize)], touch: Option<Touch>| {
        Collider::new(Arc::clone(&arm), Arc::clone(&scene), exemptions, touch.as_ref()).unwrap()
    };
    let touch = |target| Touch { pairs: pairs.clone(), target, radius: 0.15 };
    let hits = |collider: &Collider| collider.collides(&q, 0.0, 1, &mut { GO }).unwrap()[0];
    assert!(hits(&with(&[], None)));
    assert!(!hits(&with(&pairs, None)));
    assert!(!hits(&with(&[], Some(touch(tool)))));
    let away = [tool[0] + 0.2, tool[1], tool[2]];
    assert!(hits(&with(&[], Some(touch(away)))));
    assert!(!hits(&with(&pairs, Some(touch(away)))));
    for (touch, says) in [
        (Touch { pairs: vec![(99, 0)], ..touch(tool) }, "touch pairs"),
        (touch([f64::NAN; 3]), "touch target"),
        (Touch { radius: -1.0, ..touch(tool) }, "touch radius"),
    ] {
        let error = Collider::new(Arc::clone(&arm), Arc::clone(&scene), &[], Some(&touch));
        assert!(error.unwrap_err().to_string().contains(says));
    }
    assert_eq!(chain.dof(), 7);
}

#[test]
fn what_is_attached_counts() {
    let arm = bodies("panda", true);
    let tool_frame = arm.chain().joints().len() + 1;
    let stick = Solid::capsule([0.0; 3], [0.0, 0.0, 0.3], 0.01).unwrap();
    let more = arm.with_attached([Body::new("stick", tool_frame, stick)]).unwrap();
    assert_eq!(more.len(), arm.len() + 1);
    assert!(more.bodies()[arm.len()].attached && !more.bodies()[0].attached);
    assert_eq!(more.self_pairs()[..arm.self_pairs().len()], *arm.self_pairs());
    let stick = more.body("stick").unwrap();
    assert!(more.self_pairs().contains(&(1, stick)));
    assert!(more.excluded_pairs().iter().any(|e| e.pair == (stick - 1, stick)));
    // It ends 0.3 m in front of the tool point, along its z axis.
    let q = [0.4, -0.3, 0.2, -1.5, 0.3, 1.9, 0.1];
    let mut placed = more.room();
    more.place(&q, &mut placed).unwrap();
    let pose = more.chain().link_poses(&q).pop().unwrap();
    let Core::Segment(segment) = placed.solids()[stick].core() else { panic!("no capsule") };
    for k in 0..3 {
        assert!((segment.a[k] - placed.tool()[k]).abs() < 1e-12);
        assert!((segment.b[k] - (pose[(k, 3)] + 0.3 * pose[(k, 2)])).abs() < 1e-12);
    }
    let twice =
        arm.with_attached([Body::new("hand", tool_frame, Solid::sphere([0.0; 3], 0.1).unwrap())]);
    assert!(twice.unwrap_err().to_string().contains("names"));
}

#[test]
fn covers_meet_the_scene_as_all_their_spheres() {
    let exact = collider("cucumber", "greenhouse1");
    let arm = exact.bodies();
    let q = random_postures(arm.chain(), 25, 6);
    let dof = arm.chain().dof();
    let truth = exact.clearances(&q, f64::INFINITY, false, 1, &mut { GO }).unwrap();
    for split in [Split::Equal, Split::NearCubic] {
        let mut before = vec![f64::NEG_INFINITY; truth.len()];
        for level in 0..=3 {
            let of = |body: &Body| {
                let solid = match &body.shape {
                    Shape::Exact(solid) => solid.clone(),
                    Shape::Cover { .. } => unreachable!("the arm has boxes"),
                };
                let Core::Cuboid(cuboid) = *solid.core() else { unreachable!("a box") };
                Body::new(&body.name, body.frame, Shape::cover(cuboid, level, split, 0.0).unwrap())
            };
            let covered = arm.bodies().iter().map(of).collect();
            let covered =
                Arc::new(Bodies::new(Arc::clone(arm.chain()), covered, Some(&[])).unwrap());
            let skip: Vec<(usize, usize)> = (0..arm.len())
                .flat_map(|b| (0..exact.scene().objects().len()).map(move |o| (b, o)))
                .filter(|(b, o)| {
                    *b < 2
                        && ["slide", "vehicle"].contains(&exact.scene().objects()[*o].name.as_str())
                })
                .collect();
            let collider =
                Collider::new(Arc::clone(&covered), Arc::clone(exact.scene()), &skip, None)
                    .unwrap();
            let found = collider.clearances(&q, f64::INFINITY, false, 1, &mut { GO }).unwrap();
            let hits = collider.collides(&q, 0.0, 1, &mut { GO }).unwrap();
            let mut placed = covered.room();
            for (row, q) in q.chunks(dof).enumerate() {
                covered.place(q, &mut placed).unwrap();
                let mut brute = f64::INFINITY;
                for (body, solid) in placed.solids().iter().enumerate() {
                    let Shape::Cover { cover, .. } = &covered.bodies()[body].shape else {
                        unreachable!("a cover")
                    };
                    let Core::Cuboid(cuboid) = solid.core() else { unreachable!("a box") };
                    for centre in cover.centres(level) {
                        let centre = cuboid.point(*centre);
                        let sphere = Solid::sphere(centre, cover.radius(level)).unwrap();
                        let exempt = collider.exemption(&placed, body);
                        brute = collider.scene().distance(&sphere, exempt, brute);
                    }
                }
                assert_eq!(found[row], brute, "level {level}, posture {row}");
                assert_eq!(hits[row], found[row] <= 0.0);
                assert!(found[row] <= truth[row] + 1e-12, "a cover is never farther away");
                if split == Split::Equal {
                    assert!(found[row] >= before[row] - 1e-12, "a finer cover is no nearer");
                    before[row] = found[row];
                }
            }
        }
    }
}

#[test]
fn odd_scenes_and_arms_have_answers() {
    let q = random_postures(&chain("panda"), 5, 7);
    let arm = bodies("panda", true);
    let empty = Arc::new(Scene::new(Vec::new()).unwrap());
    let nothing = Collider::new(Arc::clone(&arm), empty, &[], None).unwrap();
    let scene = nothing.clearances(&q, f64::INFINITY, false, 1, &mut { GO }).unwrap();
    assert!(scene.iter().all(|d| *d == f64::INFINITY));
    let found = nothing.distances(&q, f64::INFINITY, 1, &mut { GO }).unwrap();
    assert!(found.bodies.iter().all(|one| one.object.is_none() && one.distance == f64::INFINITY));

    // Ten kilometres away.
    let far = Object::new("far", "rock").with(Solid::sphere([1e4, 0.0, 0.0], 1.0).unwrap());
    let far = Arc::new(Scene::new(vec![far]).unwrap());
    let far = Collider::new(Arc::clone(&arm), far, &[], None).unwrap();
    let away = far.clearances(&q, f64::INFINITY, false, 1, &mut { GO }).unwrap();
    assert!(away.iter().all(|d| (d - 9_998.0).abs() < 3.0), "{away:?}");
    assert_eq!(
        far.collides(&q, 0.0, 1, &mut { GO }).unwrap(),
        nothing.collides(&q, 0.0, 1, &mut { GO }).unwrap()
    );

    // No bodies at all: nothing to hit with.
    let bare = Arc::new(Bodies::new(chain("panda"), Vec::new(), None).unwrap());
    let bare = Collider::new(bare, Arc::clone(far.scene()), &[], None).unwrap();
    assert_eq!(bare.collides(&q, 0.0, 1, &mut { GO }).unwrap(), [false; 5]);
    assert!(bare.collides(&[], 0.0, 1, &mut { GO }).unwrap().is_empty());
}

#[test]
fn what_makes_no_sense_is_refused_by_name() {
    let arm = collider("panda", "bench");
    let q = random_postures(arm.bodies().chain(), 3, 8);
    let says = |error: Error, what: &str| {
        assert!(error.to_string().starts_with(what), "{error}");
    };
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
        let mut q = q.clone();
        q[7 + 3] = x;
        let error = arm.collides(&q, 0.0, 1, &mut { GO }).unwrap_err();
        assert!(error.to_string().contains("row 1"), "{error}");
        says(error, "q: ");
        says(arm.distances(&q, 1.0, 1, &mut { GO }).unwrap_err(), "q: ");
        says(arm.gradients(&q, 1.0, true, 1, &mut { GO }).unwrap_err(), "q: ");
    }
    says(arm.collides(&q[1..], 0.0, 1, &mut { GO }).unwrap_err(), "q: ");
    says(arm.collides(&q, -1.0, 1, &mut { GO }).unwrap_err(), "clear: ");
    says(arm.collides(&q, f64::NAN, 1, &mut { GO }).unwrap_err(), "clear: ");
    says(arm.clearances(&q, f64::NAN, true, 1, &mut { GO }).unwrap_err(), "cap: ");

    let sphere = || Shape::from(Solid::sphere([0.0; 3], 0.1).unwrap());
    let of = |bodies: Vec<Body>, pairs: Option<&[(usize, usize)]>| {
        Bodies::new(chain("panda"), bodies, pairs).unwrap_err()
    };
    says(of(vec![Body::new("", 0, sphere())], None), "names[0]: ");
    says(of(vec![Body::new("a", 0, sphere()), Body::new("a", 1, sphere())], None), "names: ");
    says(of(vec![Body::new("a", 9, sphere())], None), "frames[0]: ");
    for pair in [(0, 0), (0, 1), (7, 0)] {
        says(of(vec![Body::new("a", 0, sphere())], Some(&[pair])), "self_pairs: ");
    }
    let scene = arm.scene();
    let error = Collider::new(Arc::clone(arm.bodies()), Arc::clone(scene), &[(0, 99)], None);
    says(error.unwrap_err(), "exemptions: ");
    let cuboid = Cuboid::upright([0.0; 3], [0.1; 3]).unwrap();
    says(Shape::cover(cuboid, 4, Split::Equal, 0.0).unwrap_err(), "level: ");
    says(Shape::cover(cuboid, 1, Split::Equal, -1.0).unwrap_err(), "radius: ");
}
