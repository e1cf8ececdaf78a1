//! What the covers of the paper promise: the box lies in every level, a level is nearer to
//! anything than its box by no more than is said, levels of equal cells come nearer and
//! nearer, and the way through the levels gives what all pairs give.

#![allow(clippy::unwrap_used)]

mod common;

use agrik_solids::cover::FINEST;
use agrik_solids::distance::point_cuboid;
use agrik_solids::{Cloud, Cover, Cuboid, Exemption, Object, Point, Scene, Solid, Spheres, Split};
use common::{Random, norm, rotation, sub};

const SPLITS: [Split; 2] = [Split::Equal, Split::NearCubic];

/// Long boxes, flat ones, cubes, lines and points.
fn cuboid(random: &mut Random) -> Cuboid {
    let mut half = [0, 1, 2].map(|_| random.between(0.02, 0.3));
    match random.below(6) {
        0 => half = [half[0]; 3],
        1 => half[0] *= 10.0,
        2 => half[1] = 0.0,
        _ => {}
    }
    let turn = rotation([0, 1, 2, 3].map(|_| random.between(-1.0, 1.0)));
    let centre = [0, 1, 2].map(|_| random.between(-1.0, 1.0));
    Cuboid::new(centre, half, turn).unwrap()
}

fn at(cuboid: &Cuboid, share: Point) -> Point {
    let half = cuboid.half();
    cuboid.point([share[0] * half[0], share[1] * half[1], share[2] * half[2]])
}

#[test]
fn every_point_of_a_box_is_in_a_sphere_of_its_parents() {
    let mut random = Random::new(1);
    for _ in 0..40 {
        let cuboid = cuboid(&mut random);
        for split in SPLITS {
            let cover = Cover::new(&cuboid, split);
            for _ in 0..200 {
                let p = at(&cuboid, [0, 1, 2].map(|_| random.between(-1.0, 1.0)));
                let mut spheres = vec![0];
                for level in 0..=FINEST {
                    assert_eq!(cover.centres(level).len(), 8_usize.pow(level as u32));
                    assert_eq!(Cover::count(level), cover.centres(level).len());
                    let inside = |sphere: &usize| {
                        let centre = cuboid.point(cover.centres(level)[*sphere]);
                        norm(sub(p, centre)) <= cover.radius(level) * (1.0 + 1e-12)
                    };
                    // Of the spheres that it is in, one holds it at every level above.
                    spheres.retain(inside);
                    assert!(!spheres.is_empty(), "{split:?}, level {level}: {cuboid:?}");
                    spheres = spheres.iter().flat_map(|s| 8 * s..8 * s + 8).collect();
                }
            }
        }
    }
}

#[test]
fn equal_cells_are_those_of_the_paper() {
    // The spheres of the table, by level.
    let arm = Cuboid::upright([0.0; 3], [0.204, 0.0885, 0.1495]).unwrap();
    let cover = Cover::new(&arm, Split::Equal);
    for (level, printed) in [268.0, 134.0, 67.0, 34.0].into_iter().enumerate() {
        assert!((cover.radius(level) * 1e3 - printed).abs() < 0.52);
    }
    assert!((cover.overestimate(3) * 1e3 - 22.4).abs() < 0.05);
    for level in 1..=FINEST {
        assert!((cover.radius(level) - cover.radius(0) / f64::from(1 << level)).abs() < 1e-15);
        for (child, centre) in cover.centres(level).iter().enumerate() {
            let parent = cover.centres(level - 1)[child / 8];
            let reach = norm(sub(*centre, parent)) + cover.radius(level);
            assert!((reach - cover.radius(level - 1)).abs() < 1e-15, "a child beyond its parent");
        }
    }
    // Halving the longest side makes smaller spheres of the same number of cells.
    let cubic = Cover::new(&arm, Split::NearCubic);
    for level in 1..=FINEST {
        assert!(cubic.radius(level) < cover.radius(level), "level {level}");
    }
}

#[test]
fn a_level_is_too_near_by_no_more_than_is_said() {
    let mut random = Random::new(2);
    let mut compared = 0;
    for _ in 0..300 {
        let cuboid = cuboid(&mut random);
        for split in SPLITS {
            let cover = Cover::new(&cuboid, split);
            for _ in 0..20 {
                let [x, y, z] = [0, 1, 2].map(|_| random.between(-1.5, 1.5));
                let exact = point_cuboid::distance([x, y, z], &cuboid);
                if exact == 0.0 {
                    continue;
                }
                let mut before = f64::NEG_INFINITY;
                for level in 0..=FINEST {
                    let sphere = [[x, y, z, 0.0]];
                    let found = cover.brute_force(level, &cuboid, &sphere, f64::INFINITY);
                    assert!(found <= exact + 1e-13, "{split:?}, {level}: {found} > {exact}");
                    let short = exact - found;
                    assert!(short <= cover.overestimate(level) + 1e-13, "{split:?}: {short}");
                    if split == Split::Equal {
                        assert!(found >= before - 1e-13, "level {level} is farther off");
                        before = found;
                    }
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 20_000);
}

#[test]
fn the_way_through_the_levels_gives_what_all_pairs_give() {
    let mut random = Random::new(3);
    for round in 0..60 {
        let cuboid = cuboid(&mut random);
        let spread = random.between(0.05, 1.0);
        let centre = [0, 1, 2].map(|_| random.between(-1.0, 1.0));
        let spheres: Vec<[f64; 4]> = (0..[0, 1, 20, 100][round % 4])
            .map(|_| {
                let [x, y, z] = centre.map(|x| x + random.between(-spread, spread));
                [x, y, z, random.between(0.0, 0.05)]
            })
            .collect();
        for split in SPLITS {
            let cover = Cover::new(&cuboid, split);
            for level in 0..=FINEST {
                for cap in [f64::INFINITY, 0.3, 0.0] {
                    let all = cover.brute_force(level, &cuboid, &spheres, cap);
                    let found = cover.distance(level, &cuboid, &spheres, cap);
                    assert_eq!(found, all, "{split:?}, level {level}, cap {cap}");
                }
            }
        }
    }
}

#[test]
fn spheres_ask_a_scene_as_all_pairs_would() {
    let mut random = Random::new(9);
    for _ in 0..30 {
        let cuboid = cuboid(&mut random);
        let point = |random: &mut Random| [0, 1, 2].map(|_| random.between(-2.0, 2.0));
        let points: Vec<Point> = (0..60).map(|_| point(&mut random)).collect();
        let radius = random.between(0.0, 0.05);
        let capsule = [point(&mut random), point(&mut random)];
        let scene = Scene::new(vec![
            Object::new("cloud", "leaf").with_cloud(Cloud::new(&points, radius).unwrap()),
            Object::new("stem", "stem").with(Solid::capsule(capsule[0], capsule[1], 0.02).unwrap()),
        ])
        .unwrap();
        let balls: Vec<[f64; 4]> = points.iter().map(|p| [p[0], p[1], p[2], radius]).collect();
        for (split, level) in SPLITS.iter().flat_map(|split| (0..=FINEST).map(move |k| (split, k)))
        {
            let cover = Cover::new(&cuboid, *split);
            let more = random.between(0.0, 0.02);
            let spheres = Spheres::new(&cover, level, cuboid, more);
            let to_stem = |centre: &Point| {
                let ball = Solid::sphere(cuboid.point(*centre), cover.radius(level)).unwrap();
                agrik_solids::distance(&ball, &scene.objects()[1].solids[0])
            };
            let stem = cover.centres(level).iter().map(to_stem).fold(f64::INFINITY, f64::min);
            let all = cover.brute_force(level, &cuboid, &balls, f64::INFINITY).min(stem) - more;
            let none = Exemption::none();
            let found = scene.spheres_distance(&spheres, &none, f64::INFINITY);
            assert!((found - all).abs() < 1e-12, "{split:?} {level}: {found} {all}");
            assert_eq!(scene.spheres_distance(&spheres, &none, all - 0.01), all - 0.01);
            assert!(scene.spheres_hit(&spheres, &none, all.max(0.0) + 1e-9));
            assert!(all <= 0.0 || !scene.spheres_hit(&spheres, &none, all - 1e-9));
            let mut within = Vec::new();
            scene.each_within_spheres(&spheres, &none, stem - more + 1e-9, |o| within.push(o));
            assert!(within.contains(&1));
        }
    }
}
