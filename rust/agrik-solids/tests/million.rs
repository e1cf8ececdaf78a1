//! A million points: the tree against all of them, at places that matter and places that
//! do not.

#![allow(clippy::unwrap_used)]

mod common;

use agrik_solids::distance::point_to_core;
use agrik_solids::{Cloud, Core, Cuboid, Exemption, Object, Scene, Segment, Solid};
use common::{Random, rotation};

#[test]
fn a_tree_of_a_million_points_is_as_good_as_all_of_them() {
    let mut random = Random::new(1);
    let count = 1_000_000;
    // Leaves: thin clouds about places in a row, of two objects by turns.
    let rows: Vec<[f64; 4]> = (0..count)
        .map(|_| {
            let leaf = random.below(500) as f64;
            let x = leaf % 10.0 * 0.3 + random.between(-0.1, 0.1);
            let y = (leaf / 10.0).floor() * 0.25 + random.between(-0.1, 0.1);
            [x, y, leaf % 7.0 * 0.2 + 0.1 * x * y, 0.002]
        })
        .collect();
    let half = |which: usize| {
        let rows = rows.iter().skip(which).step_by(2).copied();
        Cloud::of(rows.collect::<Vec<_>>()).unwrap()
    };
    let objects = ["even", "odd"]
        .into_iter()
        .enumerate()
        .map(|(i, name)| Object::new(name, "leaf").with_cloud(half(i)));
    let scene = Scene::new(objects.collect()).unwrap();
    let odd = scene.exempt(["odd"]).unwrap();
    for round in 0..60 {
        let at = [random.between(-0.5, 3.5), random.between(-0.5, 13.0), random.between(-0.5, 3.0)];
        let to = at.map(|x| x + random.between(-0.3, 0.3));
        let turn = rotation([0, 1, 2, 3].map(|_| random.between(-1.0, 1.0)));
        let core = match round % 3 {
            0 => Core::Point(at),
            1 => Core::Segment(Segment::new(at, to).unwrap()),
            _ => Core::Cuboid(Cuboid::new(at, [0.1, 0.2, 0.05], turn).unwrap()),
        };
        let radius = random.between(0.0, 0.05);
        let least = |from: usize, step: usize| {
            let distance =
                |[x, y, z, r]: &[f64; 4]| point_to_core([*x, *y, *z], &core) - radius - r;
            rows.iter().skip(from).step_by(step).map(distance).fold(f64::INFINITY, f64::min)
        };
        let (all, even) = (least(0, 1), least(0, 2));
        let solid = Solid::new(core.clone(), radius).unwrap();
        assert_eq!(scene.distance(&solid, &Exemption::none(), f64::INFINITY), all);
        assert_eq!(scene.distance(&solid, &odd, f64::INFINITY), even);
        for clear in [0.0, 0.05] {
            assert_eq!(scene.hits(&solid, &Exemption::none(), clear), all <= clear);
            assert_eq!(scene.hits(&solid, &odd, clear), even <= clear);
        }
    }
}
