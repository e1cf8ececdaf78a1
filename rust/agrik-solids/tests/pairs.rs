//! Distances of all pairs of kinds against a proof that stands by itself.
//!
//! The two points of an answer lie in their solids, so the true distance is not longer; one
//! point that lies in both proves contact. A plane across their connection, with all of one
//! solid on one side and all of the other on the other, proves that there is a distance; how
//! long it is tells a search through all corners, edges and triangles.

#![allow(clippy::unwrap_used)]

mod common;

use agrik_solids::distance::cuboid_cuboid;
use agrik_solids::{
    Closest, Core, Cuboid, HalfSpace, Hull, Point, Pose, Segment, Solid, closest, distance,
    overlaps, within,
};
use common::{add, cross, dot, norm, rotation, scale, sub};
use proptest::prelude::*;

/// A core as the test knows it: its extreme points, and how to tell that a point lies in it.
#[derive(Debug, Clone)]
enum Known {
    Points(Vec<Point>),
    Box { centre: Point, half: Point, rotation: [[f64; 3]; 3] },
}

impl Known {
    fn extremes(&self) -> Vec<Point> {
        match self {
            Self::Points(points) => points.clone(),
            Self::Box { centre, half, rotation } => (0..8)
                .map(|corner| {
                    let mut p = *centre;
                    for k in 0..3 {
                        let side = if corner >> k & 1 == 0 { -half[k] } else { half[k] };
                        for row in 0..3 {
                            p[row] += rotation[row][k] * side;
                        }
                    }
                    p
                })
                .collect(),
        }
    }

    /// How far outside a point lies.
    fn outside(&self, p: Point) -> f64 {
        match self {
            Self::Points(points) => distance_from_hull(p, points),
            Self::Box { centre, half, rotation } => {
                let from = sub(p, *centre);
                let over = |k: usize| {
                    let axis = [rotation[0][k], rotation[1][k], rotation[2][k]];
                    (dot(axis, from).abs() - half[k]).max(0.0)
                };
                norm([over(0), over(1), over(2)])
            }
        }
    }
}

/// Distance of a point from the hull of points: 0 inside one of their tetrahedra, else the
/// least of those from all their triangles. Slow, and shares nothing with what is tested.
fn distance_from_hull(p: Point, points: &[Point]) -> f64 {
    let n = points.len();
    let at = |i: usize| sub(points[i], p);
    let mut nearest = f64::INFINITY;
    for i in 0..n {
        for j in 0..=i {
            for k in 0..=j {
                nearest = nearest.min(triangle([at(i), at(j), at(k)]));
                if nearest < 1e-13 {
                    return nearest;
                }
            }
        }
    }
    let volume = |[a, b, c]: [Point; 3]| dot(a, cross(b, c));
    for i in 0..n {
        for j in 0..i {
            for k in 0..j {
                for l in 0..k {
                    let [a, b, c, d] = [at(i), at(j), at(k), at(l)];
                    let parts = [
                        volume([b, d, c]),
                        volume([a, c, d]),
                        volume([a, d, b]),
                        volume([a, b, c]),
                    ];
                    if parts.iter().all(|v| *v > 0.0) || parts.iter().all(|v| *v < 0.0) {
                        return 0.0;
                    }
                }
            }
        }
    }
    nearest
}

/// Distance of the origin from a triangle, which may be a line or a point.
fn triangle([a, b, c]: [Point; 3]) -> f64 {
    let side = |a: Point, b: Point| {
        let way = sub(b, a);
        let t = if a == b { 0.0 } else { (-dot(a, way) / dot(way, way)).clamp(0.0, 1.0) };
        norm(add(a, scale(way, t)))
    };
    let rim = side(a, b).min(side(b, c)).min(side(c, a));
    let normal = cross(sub(b, a), sub(c, a));
    let above = |a: Point, b: Point| dot(cross(a, b), normal) > 0.0;
    if above(a, b) && above(b, c) && above(c, a) {
        return rim.min(dot(a, normal).abs() / norm(normal));
    }
    rim
}

/// Distance of two hulls that do not meet: the least of those of the points of one from all
/// triangles of the other, and of all connections of two points from one another.
fn distance_of_hulls(a: &[Point], b: &[Point]) -> f64 {
    let mut nearest = f64::INFINITY;
    for (points, others) in [(a, b), (b, a)] {
        for p in points {
            for (i, x) in others.iter().enumerate() {
                for (j, y) in others[..=i].iter().enumerate() {
                    for z in &others[..=j] {
                        let corners = [sub(*x, *p), sub(*y, *p), sub(*z, *p)];
                        nearest = nearest.min(triangle(corners));
                    }
                }
            }
        }
    }
    for (i, p) in a.iter().enumerate() {
        for q in &a[..i] {
            for (j, r) in b.iter().enumerate() {
                for s in &b[..j] {
                    nearest = nearest.min(across([*p, *q], [*r, *s]));
                }
            }
        }
    }
    nearest
}

/// Distance of two lines between points where the common perpendicular meets both within
/// them; infinite where it does not.
fn across([p, q]: [Point; 2], [r, s]: [Point; 2]) -> f64 {
    let normal = cross(sub(q, p), sub(s, r));
    let square = dot(normal, normal);
    if square < 1e-20 {
        return f64::INFINITY;
    }
    let t = dot(cross(sub(r, p), sub(s, r)), normal) / square;
    let u = dot(cross(sub(r, p), sub(q, p)), normal) / square;
    if (0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&u) {
        return dot(sub(r, p), normal).abs() / square.sqrt();
    }
    f64::INFINITY
}

/// Numbers of which some are the same as others, as they are in real scenes.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![-1.0..1.0, prop::sample::select(vec![-1.0, -0.5, 0.0, 0.25, 0.5, 1.0])]
}

fn length() -> impl Strategy<Value = f64> {
    prop_oneof![0.0..0.7, prop::sample::select(vec![0.0, 1e-9, 0.25, 0.5])]
}

fn triple(of: impl Strategy<Value = f64> + Clone) -> impl Strategy<Value = Point> {
    [of.clone(), of.clone(), of]
}

fn turn() -> impl Strategy<Value = [[f64; 3]; 3]> {
    let any = [-1.0..1.0, -1.0..1.0, -1.0..1.0, -1.0..1.0];
    // Upright, a quarter turn, nearly upright, anything.
    prop_oneof![
        Just(rotation([1.0, 0.0, 0.0, 0.0])),
        Just(rotation([1.0, 0.0, 0.0, 1.0])),
        (-1e-7..1e-7_f64).prop_map(|x| rotation([1.0, x, 0.0, -x])),
        any.prop_map(rotation),
    ]
}

/// A core with bounds, of every kind, and the same as the test knows it.
fn core() -> impl Strategy<Value = (Core, Known)> {
    let number = || number().boxed();
    prop_oneof![
        triple(number()).prop_map(|p| (Core::Point(p), Known::Points(vec![p]))),
        (triple(number()), triple(number())).prop_map(|(a, b)| {
            (Core::Segment(Segment::new(a, b).unwrap()), Known::Points(vec![a, b]))
        }),
        (triple(number()), triple(length().boxed()), turn()).prop_map(
            |(centre, half, rotation)| {
                let cuboid = Cuboid::new(centre, half, rotation).unwrap();
                (Core::Cuboid(cuboid), Known::Box { centre, half, rotation })
            }
        ),
        prop::collection::vec(triple(number()), 1..11).prop_map(|points| {
            (Core::Hull(Hull::new(points.clone()).unwrap()), Known::Points(points))
        }),
    ]
}

/// Fails unless the answer proves itself.
fn prove(a: &Known, b: &Known, found: &Closest) -> Result<(), TestCaseError> {
    let Closest { distance, on_a, on_b, normal } = *found;
    prop_assert!(a.outside(on_a) < 1e-11, "on_a is {} outside", a.outside(on_a));
    prop_assert!(b.outside(on_b) < 1e-11, "on_b is {} outside", b.outside(on_b));
    let apart = norm(sub(on_b, on_a));
    prop_assert!((apart - distance).abs() < 1e-14, "{apart} between points, not {distance}");
    if distance < 1e-12 {
        return Ok(());
    }
    prop_assert!((norm(normal) - 1.0).abs() < 1e-14);
    let far = |points: Vec<Point>, sign: f64| {
        points.iter().map(|p| sign * dot(normal, *p)).fold(f64::NEG_INFINITY, f64::max)
    };
    let gap = -far(b.extremes(), -1.0) - far(a.extremes(), 1.0);
    // The plane is as good as its direction, which has the digits of the connection.
    // The plane is enough to prove that there is a distance at all. How long it is must be
    // told otherwise: of flat solids the direction has half the digits of the length.
    let slack = 1e-6 + 1e-12 / distance;
    prop_assert!((gap - distance).abs() < slack, "gap {gap}, distance {distance}");
    let expected = distance_of_hulls(&a.extremes(), &b.extremes());
    let off = (distance - expected).abs();
    prop_assert!(off < 1e-9 * distance + 1e-14, "{distance}, not {expected}");
    Ok(())
}

/// The same distance within what rounding does to it.
fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs()) + 1e-13 || a == b
}

const CASES: u32 = 30_000;

proptest! {
    #![proptest_config(ProptestConfig { cases: CASES, ..ProptestConfig::default() })]

    #[test]
    fn every_distance_proves_itself((a, known_a) in core(), (b, known_b) in core()) {
        let (a, b) = (Solid::new(a, 0.0).unwrap(), Solid::new(b, 0.0).unwrap());
        let found = closest(&a, &b);
        prove(&known_a, &known_b, &found)?;
        prop_assert_eq!(found.distance, distance(&a, &b));
        prop_assert_eq!(overlaps(&a, &b), found.distance <= 0.0);
        if let (Core::Cuboid(a), Core::Cuboid(b)) = (a.core(), b.core()) {
            let gap = cuboid_cuboid::gap_between_planes(a, b);
            prop_assert!(gap <= found.distance + 1e-12);
            prop_assert!(gap.abs() < 1e-12 || (gap < 0.0) == (found.distance == 0.0));
        }
        // The other way round.
        let swapped = closest(&b, &a);
        prove(&known_b, &known_a, &swapped)?;
        prop_assert!(same(swapped.distance, found.distance));
    }

    #[test]
    fn radii_are_taken_off_and_witnesses_lie_on_the_surfaces(
        (a, _) in core(), (b, _) in core(), radii in [0.0..0.3, 0.0..0.3], reach in -0.5..1.0
    ) {
        let bare = closest(&Solid::new(a.clone(), 0.0).unwrap(), &Solid::new(b.clone(), 0.0).unwrap());
        let (a, b) = (Solid::new(a, radii[0]).unwrap(), Solid::new(b, radii[1]).unwrap());
        let found = closest(&a, &b);
        prop_assert_eq!(found.distance, bare.distance - radii[0] - radii[1]);
        prop_assert_eq!(within(&a, &b, reach), found.distance <= reach);
        if bare.distance > 0.0 {
            let way = sub(found.on_b, found.on_a);
            let along = dot(way, found.normal);
            prop_assert!((along - found.distance).abs() < 1e-13, "{along} {}", found.distance);
            prop_assert!((norm(sub(found.on_a, bare.on_a)) - radii[0]).abs() < 1e-13);
            prop_assert!((norm(sub(found.on_b, bare.on_b)) - radii[1]).abs() < 1e-13);
        }
    }

    #[test]
    fn moving_both_changes_nothing_and_moving_one_no_more_than_the_way(
        (a, _) in core(), (b, _) in core(), turn in turn(), translation in triple((-3.0..3.0).boxed())
    ) {
        // Hulls as flat as 1e-9 that touch may seem to be apart by less than that.
        let hull = matches!(a, Core::Hull(_)) || matches!(b, Core::Hull(_));
        let slack = if hull { 1e-9 } else { 1e-11 };
        let (a, b) = (Solid::new(a, 0.01).unwrap(), Solid::new(b, 0.02).unwrap());
        let before = distance(&a, &b);
        let pose = Pose { rotation: turn, translation };
        let after = distance(&a.placed(&pose), &b.placed(&pose));
        prop_assert!((before - after).abs() < 1e-9 * before.abs() + slack, "{before} {after}");
        let shift = Pose { translation, ..Pose::IDENTITY };
        let shifted = distance(&a.placed(&shift), &b);
        prop_assert!((before - shifted).abs() <= norm(translation) + 1e-12);
    }

    #[test]
    fn a_half_space_is_as_far_as_the_lowest_point(
        (core, known) in core(), normal in triple((-1.0..1.0).boxed()), offset in -1.0..1.0, radius in 0.0..0.2
    ) {
        prop_assume!(norm(normal) > 0.1);
        let half_space = Solid::from(HalfSpace::new(normal, offset).unwrap());
        let solid = Solid::new(core, radius).unwrap();
        let unit = scale(normal, 1.0 / norm(normal));
        let heights = known.extremes().into_iter().map(|p| dot(unit, p) - offset / norm(normal));
        let expected = heights.fold(f64::INFINITY, f64::min) - radius;
        let found = closest(&half_space, &solid);
        prop_assert!((found.distance - expected).abs() < 1e-13);
        prop_assert!((dot(unit, found.on_a) - offset / norm(normal)).abs() < 1e-13);
        prop_assert!((dot(sub(found.on_b, found.on_a), unit) - expected).abs() < 1e-13);
        let swapped = closest(&solid, &half_space);
        prop_assert_eq!(swapped.distance, found.distance);
        prop_assert_eq!(swapped.normal, found.normal.map(|x| -x));
        prop_assert_eq!(overlaps(&solid, &half_space), found.distance <= 0.0);
    }
}

/// A segment along a sheet that it is all but parallel to: where it leaves the sheet, rounding is
/// more than the slope of the distance (found by the cases above).
#[test]
fn a_segment_along_a_sheet_is_as_far_as_its_nearest_point() {
    let t = 4.394803724810822e-8;
    let rotation = [
        [0.999_999_999_999_999, -t, -9.657149889805546e-16],
        [t, 0.999_999_999_999_998_1, t],
        [-9.657149889805546e-16, -t, 0.999_999_999_999_999],
    ];
    let (centre, half) = ([0.0, -0.33598122052266943, 0.0], [0.0, 0.25, 0.25]);
    let sheet = Solid::from(Cuboid::new(centre, half, rotation).unwrap());
    let known = Known::Box { centre, half, rotation };
    let (a, b) = ([0.0, -0.8091655812356102, -0.763084308416915], [0.0, -0.5, 0.35862167962255764]);
    let found = distance(&capsule(a, b, 0.0), &sheet);
    let expected = distance_of_hulls(&known.extremes(), &[a, b]);
    assert!((found - expected).abs() < 1e-6 * expected, "{found} {expected}");
}

fn capsule(a: Point, b: Point, radius: f64) -> Solid {
    Solid::capsule(a, b, radius).unwrap()
}

fn upright(centre: Point, half: Point) -> Solid {
    Solid::from(Cuboid::upright(centre, half).unwrap())
}

#[test]
fn distances_that_can_be_told_by_heart() {
    let unit = upright([0.0; 3], [1.0; 3]);
    let ball = |x, r| Solid::sphere([x, 0.0, 0.0], r).unwrap();
    let cube = |side: f64, shift: f64| {
        let corners = (0..8).map(|k| {
            let at = |bit: usize| shift + if k >> bit & 1 == 0 { -side } else { side };
            [at(0), at(1), at(2)]
        });
        Solid::from(Hull::new(corners.collect()).unwrap())
    };
    let cases = [
        ("spheres", ball(0.0, 0.5), ball(2.0, 0.25), 1.25),
        ("spheres touching", ball(0.0, 1.0), ball(2.0, 1.0), 0.0),
        ("spheres nested", ball(0.0, 1.0), ball(0.25, 0.25), -1.0),
        ("a sphere on a box", ball(1.5, 0.5), unit.clone(), 0.0),
        ("a sphere in a box", ball(0.5, 0.25), unit.clone(), -0.25),
        ("boxes touching", upright([2.0, 0.0, 0.0], [1.0; 3]), unit.clone(), 0.0),
        ("boxes nested", upright([0.0; 3], [0.5; 3]), unit.clone(), 0.0),
        ("boxes across a corner", upright([3.0, 3.0, 3.0], [1.0; 3]), unit.clone(), 3.0_f64.sqrt()),
        ("a flat box above", upright([0.0, 0.0, 1.5], [9.0, 9.0, 0.0]), unit.clone(), 0.5),
        // A rod through the middle of a plate: no corner of one is in the other.
        (
            "a rod through a plate",
            upright([0.0; 3], [0.1, 0.1, 5.0]),
            upright([0.0; 3], [2.0, 2.0, 0.1]),
            0.0,
        ),
        (
            "capsules crossing",
            capsule([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], 0.1),
            capsule([0.0, -1.0, 1.0], [0.0, 1.0, 1.0], 0.1),
            0.8,
        ),
        (
            "capsules parallel",
            capsule([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], 0.1),
            capsule([0.5, 1.0, 0.0], [3.0, 1.0, 0.0], 0.1),
            0.8,
        ),
        (
            "capsules in a row",
            capsule([0.0; 3], [1.0, 0.0, 0.0], 0.25),
            capsule([2.0, 0.0, 0.0], [3.0, 0.0, 0.0], 0.25),
            0.5,
        ),
        (
            "capsules without length",
            capsule([0.0; 3], [0.0; 3], 0.25),
            capsule([0.0, 3.0, 4.0], [0.0, 3.0, 4.0], 0.25),
            4.5,
        ),
        (
            "a capsule along a face",
            capsule([-3.0, 0.0, 2.0], [3.0, 0.0, 2.0], 0.5),
            unit.clone(),
            0.5,
        ),
        (
            "a capsule through a box",
            capsule([-3.0, 0.0, 0.0], [3.0, 0.0, 0.0], 0.5),
            unit.clone(),
            -0.5,
        ),
        (
            "a capsule past an edge",
            capsule([2.0, 0.0, -3.0], [0.0, 2.0, -3.0], 0.0),
            unit.clone(),
            2.0,
        ),
        ("hulls", cube(1.0, 0.0), cube(1.0, 3.0), 3.0_f64.sqrt()),
        ("hulls touching", cube(1.0, 0.0), cube(1.0, 2.0), 0.0),
        ("a hull in a box", cube(0.5, 0.0), unit.clone(), 0.0),
        ("a hull that is a box", cube(1.0, 3.0), unit.clone(), 3.0_f64.sqrt()),
    ];
    for (what, a, b, expected) in cases {
        for (a, b) in [(&a, &b), (&b, &a)] {
            let found = distance(a, b);
            assert!((found - expected).abs() < 1e-14, "{what}: {found}, not {expected}");
            assert_eq!(overlaps(a, b), found <= 0.0, "{what}");
        }
    }
}

#[test]
fn half_spaces_face_each_other_or_meet() {
    let below = |z: f64| Solid::from(HalfSpace::new([0.0, 0.0, 2.0], 2.0 * z).unwrap());
    let above = Solid::from(HalfSpace::new([0.0, 0.0, -1.0], -1.5).unwrap());
    assert_eq!(distance(&below(1.0), &above), 0.5);
    assert_eq!(distance(&below(2.0), &above), -0.5);
    assert_eq!(distance(&below(1.0), &below(-5.0)), f64::NEG_INFINITY);
}

#[test]
fn far_from_the_origin_the_digits_are_those_of_the_coordinates() {
    // 10 km away a coordinate has a grain of 1.8e-12 m.
    let shift = Pose { translation: [7e3, -7e3, 2e3], ..Pose::IDENTITY };
    let a = upright([0.0; 3], [0.3, 0.2, 0.1]);
    let turned = Cuboid::new([1.0, 0.5, 0.25], [0.2; 3], rotation([0.9, 0.1, -0.3, 0.4])).unwrap();
    let corners = turned.corners().to_vec();
    for b in [Solid::from(turned), Solid::from(Hull::new(corners).unwrap())] {
        let near = distance(&a, &b);
        let far = distance(&a.placed(&shift), &b.placed(&shift));
        assert!((near - far).abs() < 1e-11, "{near} {far}");
    }
}

#[test]
fn shapes_that_make_no_sense_are_refused_by_name() {
    let nan = f64::NAN;
    let tilted = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.1], [0.0, 0.0, 1.0]];
    let mirrored = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
    let cases = [
        (Solid::sphere([0.0, nan, 0.0], 1.0).err(), "centre: "),
        (Solid::sphere([0.0; 3], -1.0).err(), "radius: "),
        (Solid::sphere([0.0; 3], nan).err(), "radius: "),
        (Solid::sphere([1e10, 0.0, 0.0], 1.0).err(), "centre: "),
        (Solid::capsule([0.0; 3], [f64::INFINITY, 0.0, 0.0], 1.0).err(), "b: "),
        (Cuboid::upright([0.0; 3], [1.0, -1.0, 1.0]).err(), "half: "),
        (Cuboid::new([0.0; 3], [1.0; 3], tilted).err(), "rotation: "),
        (Cuboid::new([0.0; 3], [1.0; 3], mirrored).err(), "rotation: "),
        (Cuboid::new([0.0; 3], [1.0; 3], [[nan; 3]; 3]).err(), "rotation: "),
        (HalfSpace::new([0.0; 3], 1.0).err(), "normal: "),
        (HalfSpace::new([0.0, 0.0, 1.0], nan).err(), "offset: "),
        (Hull::new(Vec::new()).err(), "points: "),
        (Hull::new(vec![[0.0; 3], [nan; 3]]).err(), "points[1]: "),
    ];
    for (error, start) in cases {
        let text = error.map(|error| error.to_string()).unwrap_or_default();
        assert!(text.starts_with(start) && text.contains("expected"), "{start}{text:?}");
    }
}
