//! What balls are told to be far from is far: things, crowds before and with their field.
#![allow(clippy::unwrap_used)]

mod common;

use agrik_compute::lanes::{Kernel32, Level, Real32, dispatch_eights};
use agrik_solids::outline::{Block, Boxed, Outline, View, balls, roundings, single_above};
use agrik_solids::{Core, Cuboid, Exemption, HalfSpace, Object, Point, Scene, Solid, distance};
use common::{Random, norm, rotation};

/// Lanes in which eight balls of a radius may be within reach of a scene.
struct Ask<'a> {
    view: &'a View<'a>,
    points: [Point; 8],
    radius: f64,
}

impl Kernel32 for Ask<'_> {
    type Output = u32;
    fn run<R: Real32>(self) -> u32 {
        let origin = self.view.origin();
        let lanes = |k: usize| R::load(&self.points.map(|p| (p[k] - origin[k]) as f32));
        let p = [lanes(0), lanes(1), lanes(2)];
        let far = |p: &Point| [0, 1, 2].map(|k| (p[k] - origin[k]).abs());
        let away = self.points.iter().flat_map(far).fold(0.0, f64::max);
        let more = roundings(self.view.extent() + 2.0 * away);
        let reach = R::splat(f64::from(single_above(self.radius + more)));
        let mut maybe = self.view.maybe_crowd(&p, reach);
        for thing in self.view.things() {
            let near = thing.maybe(&p, reach);
            let outlined = thing.outline().maybe(&p, reach);
            assert_eq!(outlined & !near, 0, "what is near a solid is near its box");
            maybe |= outlined;
        }
        maybe
    }
}

fn scenes(random: &mut Random) -> Vec<(&'static str, Scene)> {
    let mut point = |scale: f64| [0, 1, 2].map(|_| random.between(-scale, scale));
    let capsule = |a: Point, b: Point, r: f64| Solid::capsule(a, b, r).unwrap();
    let mut few = Object::new("few", "thing");
    let mut many = Object::new("many", "thing");
    for k in 0..120 {
        let (a, b) = (point(1.0), point(0.3));
        let half = [0.02 + b[0].abs(), 0.02 + b[1].abs(), 0.02 + b[2].abs()];
        let (s, c) = a[0].sin_cos();
        let turn = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]];
        let solid = match k % 3 {
            0 => Solid::sphere(a, 0.05).unwrap(),
            1 => capsule(a, [a[0] + b[0], a[1] + b[1], a[2] + b[2]], 0.03),
            _ => Cuboid::new(a, half, turn).unwrap().into(),
        };
        if k < 12 {
            few = few.with(solid.clone());
        }
        many = many.with(solid);
    }
    few = few.with(HalfSpace::new([0.1, 0.2, 1.0], -1.1).unwrap());
    let mut crowd = Object::new("crowd", "leaf");
    for k in 0..900 {
        let r = if k % 50 == 0 { 0.15 } else { 0.004 + 0.00004 * f64::from(k) };
        crowd = crowd.with(Solid::sphere(point(0.8), r).unwrap());
    }
    let flat: Vec<Solid> = (0..300)
        .map(|_| point(1.0))
        .map(|[x, y, _]| Solid::sphere([x, y, 5000.0], 0.002).unwrap())
        .collect();
    let mut sheet = Object::new("sheet", "leaf");
    sheet.solids = flat;
    // Most of it is out of sight.
    let mut row = Object::new("row", "leaf");
    for k in 0..4000 {
        let [x, y, z] = point(0.8);
        row = row.with(Solid::sphere([x, y + 0.01 * f64::from(k - 2000), z], 0.01).unwrap());
    }
    let made = |object: &Object| Scene::new(vec![object.clone()]).unwrap();
    vec![
        ("few", made(&few)),
        ("many", made(&many)),
        ("crowd", made(&crowd)),
        ("row", made(&row)),
        ("both", Scene::new(vec![few.clone(), crowd.clone()]).unwrap()),
        ("sheet", made(&sheet)),
        ("nothing", Scene::new(Vec::new()).unwrap()),
    ]
}

#[test]
fn what_is_said_to_be_far_is_far() {
    let mut random = Random::new(5);
    for (name, scene) in scenes(&mut random) {
        let (mut near, mut seen, mut far) = (0, 0, 0);
        let height = if name == "sheet" { 5000.0 } else { 0.0 };
        let (mut seen_last, mut far_last) = (0, 0);
        for questions in [1, 100_000] {
            (seen_last, far_last) = (0, 0);
            let view = scene.view(questions);
            for _ in 0..400 {
                let mut points = [[0.0; 3]; 8];
                for p in &mut points {
                    *p = [0, 1, 2].map(|_| random.between(-1.6, 1.6));
                    p[2] += height;
                }
                let radius = random.between(0.0, 0.2);
                let of = |level| dispatch_eights(level, Ask { view: &view, points, radius });
                let maybe = of(Level::Scalar);
                for (lane, p) in points.iter().enumerate() {
                    let ball = Solid::sphere(*p, radius).unwrap();
                    let hits = scene.hits(&ball, &Exemption::none(), 0.0);
                    if hits {
                        near += 1;
                        for level in Level::ALL.into_iter().filter(|level| level.is_available()) {
                            assert!(of(level) >> lane & 1 != 0, "{name}: {p:?} {radius}");
                        }
                    } else {
                        seen += maybe >> lane & 1;
                        far += 1;
                        seen_last += maybe >> lane & 1;
                        far_last += 1;
                    }
                }
            }
        }
        assert!(name == "nothing" || near > 50, "{name}: {near}");
        // A sieve that lets all through would be right, and of no use.
        assert!(4 * seen < 3 * far, "{name}: {seen} of {far}");
        // With its field a crowd is hardly larger than it is.
        let crowded = matches!(name, "crowd" | "row");
        assert!(!crowded || 5 * seen_last < far_last, "{name}: {seen_last} of {far_last}");
    }
}

#[test]
fn balls_cover_their_solid() {
    let mut random = Random::new(9);
    let solids = [
        Solid::sphere([0.1, 0.2, 0.3], 0.2).unwrap(),
        Solid::capsule([0.0; 3], [0.5, 0.2, -0.1], 0.07).unwrap(),
        Solid::capsule([0.0; 3], [0.0; 3], 0.07).unwrap(),
        Solid::capsule([0.0; 3], [0.0, 0.0, 1.0], 0.0).unwrap(),
        Cuboid::upright([0.3, 0.0, 0.0], [0.2, 0.05, 0.4]).unwrap().into(),
        Cuboid::upright([0.3, 0.0, 0.0], [0.2, 0.0, 0.0]).unwrap().into(),
    ];
    for solid in &solids {
        let balls = balls(solid);
        let (centre, size) = solid.bounding_sphere();
        let mut inside = 0;
        for _ in 0..20_000 {
            let p = centre.map(|x| x + random.between(-size, size));
            let point = Solid::sphere(p, 0.0).unwrap();
            if distance(&point, solid) > 0.0 {
                continue;
            }
            inside += 1;
            let covers = |[x, y, z, r]: &[f64; 4]| {
                distance(&point, &Solid::sphere([*x, *y, *z], *r).unwrap()) <= 0.0
            };
            assert!(balls.iter().any(covers), "{solid:?} {p:?}");
        }
        assert!(inside > 100 || solid.radius() == 0.0);
        let _ = Outline::new(solid, [0.0; 3]);
    }
}

/// Whether a box may be within reach of another solid: seen by its outline, and as two boxes.
struct Part<'a> {
    block: &'a Block,
    other: &'a Solid,
    reach: f64,
}

fn boxed<R: Real32>(block: &Block) -> Boxed<R> {
    let lanes = |v: &[f32; 3]| [0, 1, 2].map(|k| R::splat(f64::from(v[k])));
    let axes = [lanes(&block.axes[0]), lanes(&block.axes[1]), lanes(&block.axes[2])];
    Boxed { centre: lanes(&block.centre), axes, half: lanes(&block.half) }
}

impl Kernel32 for Part<'_> {
    type Output = bool;
    fn run<R: Real32>(self) -> bool {
        let this = boxed::<R>(self.block);
        let reach = self.reach + f64::from(self.block.radius);
        let outline = Outline::new(self.other, [0.0; 3]);
        let mut seen = vec![outline.maybe_box(&this, R::splat(reach))];
        if let Some(block) = Block::new(self.other) {
            let other = boxed::<R>(&block);
            let reach = R::splat(reach + f64::from(block.radius));
            seen.extend([this.maybe(&other, reach), other.maybe(&this, reach)]);
        }
        assert!(seen.iter().all(|lanes| *lanes == 0 || *lanes == 255), "{seen:?}");
        seen.into_iter().all(|lanes| lanes != 0)
    }
}

#[test]
fn what_a_plane_parts_is_apart() {
    let mut random = Random::new(12);
    let (mut near, mut far, mut seen) = (0, [0; 5], [0; 5]);
    for case in 0..20_000 {
        let mut numbers = |scale: f64| [0; 4].map(|_| random.between(-scale, scale));
        let ([x, y, z, _], [along, across, up, _]) = (numbers(0.7), numbers(0.3));
        let (at, sizes) = ([x, y, z], [along.abs(), across.abs(), up.abs()]);
        let (turn, other_turn, little) = (numbers(1.0), numbers(1.0), numbers(1e-5));
        // Some have edges that are parallel, or all but so.
        let other_turn = match case % 7 {
            0 => turn,
            1 => [0, 1, 2, 3].map(|k| turn[k] + little[k]),
            _ => other_turn,
        };
        let half = [0.4 * sizes[1], 0.1, 0.02 + sizes[0]];
        let this: Solid = Cuboid::new([0.1, -0.2, 0.05], half, rotation(turn)).unwrap().into();
        let cuboid = Cuboid::new(at, sizes, rotation(other_turn)).unwrap();
        let kind = case % 5;
        let other: Solid = match kind {
            0 => cuboid.into(),
            1 => Solid::sphere(at, 0.05).unwrap(),
            2 => Solid::capsule(at, [x + along, y + across, z + up], 0.03).unwrap(),
            3 => HalfSpace::new([along, across, up], x * norm([along, across, up])).unwrap().into(),
            _ => Solid::new(Core::Cuboid(cuboid), 0.04).unwrap(),
        };
        let block = Block::new(&this).unwrap();
        let apart = distance(&this, &other);
        let reach = if case % 3 == 0 { apart.max(0.0) } else { random.between(0.0, 0.1) };
        // As those who ask have it: for the places of both, and for the axes again.
        let reach_in_singles = reach + 2.0 * roundings(4.0);
        for level in Level::ALL.into_iter().filter(|level| level.is_available()) {
            let asked = Part { block: &block, other: &other, reach: reach_in_singles };
            let maybe = dispatch_eights(level, asked);
            if apart <= reach {
                near += 1;
                assert!(maybe, "{case}: {apart} m apart, {reach} m asked about");
            } else if apart > reach + 0.01 {
                far[kind] += 1;
                seen[kind] += usize::from(maybe);
            }
        }
    }
    assert!(near > 5_000, "{near}");
    // Little is missed: corners that face corners.
    for (kind, (seen, far)) in seen.iter().zip(far).enumerate() {
        assert!(far > 500 && 5 * seen < far, "{kind}: {seen} of {far}");
    }
}
