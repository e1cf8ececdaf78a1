//! Cores asked in lanes against the same cores asked one point at a time, in doubles and in
//! singles, at every level of instructions.

#![allow(clippy::unwrap_used)]

mod common;

use agrik_solids::distance::{cloud_any, point_to_core};
use agrik_solids::lanes::{Kernel32, Level, Real32, dispatch_eights, dispatch_singles};
use agrik_solids::probe::{CuboidProbe, PointProbe, Probe, SegmentProbe};
use agrik_solids::{Cloud, Core, Cuboid, HalfSpace, Hull, Point, Segment, Solid, closest};
use common::{Random, norm, rotation, sub};

fn levels() -> Vec<Level> {
    Level::ALL.into_iter().filter(|level| level.is_available()).collect()
}

fn core(random: &mut Random, kind: usize, centre: Point) -> Core {
    let mut near = || centre.map(|x| x + random.between(-0.3, 0.3));
    let (a, b) = (near(), near());
    let points = (0..6).map(|_| near()).collect();
    let half = [0, 1, 2].map(|_| random.between(0.0, 0.3));
    let turn = rotation([0, 1, 2, 3].map(|_| random.between(-1.0, 1.0)));
    match kind {
        0 => Core::Point(a),
        1 => Core::Segment(Segment::new(a, b).unwrap()),
        // So short that singles see one point.
        2 => Core::Segment(Segment::new(a, a.map(|x| x + 1e-20)).unwrap()),
        3 => Core::Cuboid(Cuboid::new(a, half, turn).unwrap()),
        4 => Core::Hull(Hull::new(points).unwrap()),
        _ => Core::HalfSpace(HalfSpace::new(turn[0], 0.3).unwrap()),
    }
}

/// Distances of points from a core, in lanes of singles.
struct Singles<'a> {
    core: &'a Core,
    origin: Point,
    points: &'a [Point],
}

impl Kernel32 for Singles<'_> {
    type Output = Vec<f32>;
    #[inline(always)]
    fn run<R: Real32>(self) -> Vec<f32> {
        match self.core {
            Core::Point(p) => self.each::<R, _>(&PointProbe::new(*p, self.origin)),
            Core::Segment(s) => self.each::<R, _>(&SegmentProbe::new(s, self.origin)),
            Core::Cuboid(c) => self.each::<R, _>(&CuboidProbe::new(c, self.origin)),
            _ => Vec::new(),
        }
    }
}

impl Singles<'_> {
    #[inline(always)]
    fn each<R: Real32, P: Probe<R>>(&self, probe: &P) -> Vec<f32> {
        let mut found = Vec::new();
        for points in self.points.chunks(R::WIDTH) {
            let mut columns = [[0.0; 16]; 3];
            for (lane, p) in points.iter().enumerate() {
                for k in 0..3 {
                    columns[k][lane] = (p[k] - self.origin[k]) as f32;
                }
            }
            let [x, y, z] = &columns;
            let mut away = [0.0; 16];
            probe.square(&[R::load(x), R::load(y), R::load(z)]).sqrt().store(&mut away);
            found.extend_from_slice(&away[..points.len()]);
        }
        found
    }
}

#[test]
fn singles_are_off_by_less_than_half_of_what_is_granted_to_them() {
    let mut random = Random::new(1);
    let mut worst = 0.0_f64;
    for round in 0..3000 {
        let origin = [0, 1, 2].map(|_| random.between(-5e3, 5e3));
        let spread = [0.3, 3.0, 300.0][round % 3];
        let place = origin.map(|x| x + random.between(-spread, spread));
        let core = core(&mut random, round % 4, place);
        let (centre, size) = core.bounding_sphere();
        let points: Vec<Point> =
            (0..50).map(|_| origin.map(|x| x + random.between(-spread, spread))).collect();
        let extent = points.iter().map(|p| norm(sub(*p, origin))).fold(0.0, f64::max);
        // As the tree has it.
        let granted = 64.0 / 16_777_216.0 * (extent + norm(sub(centre, origin)) + size);
        for level in levels() {
            let ask = || Singles { core: &core, origin, points: &points };
            for found in [dispatch_eights(level, ask()), dispatch_singles(level, ask())] {
                for (p, found) in points.iter().zip(found) {
                    let off = (f64::from(found) - point_to_core(*p, &core)).abs();
                    worst = worst.max(off / granted);
                }
            }
        }
    }
    assert!(worst < 0.5 && worst > 0.0, "{worst}");
}

#[test]
fn a_cloud_in_lanes_is_as_far_as_its_spheres_one_by_one() {
    let mut random = Random::new(2);
    for count in [0, 1, 2, 3, 7, 8, 9, 40, 333] {
        for kind in 0..6 {
            let core = core(&mut random, kind, [0.2, 0.0, -0.1]);
            let solid = Solid::new(core, 0.05).unwrap();
            let rows: Vec<[f64; 4]> = (0..count)
                .map(|i| {
                    // Some of them twice: the first is the one to be found.
                    let mut at = || random.between(-1.0, 1.0);
                    let fresh = [at(), at(), at(), 0.02];
                    if i % 3 == 2 { [0.9, 0.9, 0.9, 0.02] } else { fresh }
                })
                .collect();
            let each = rows
                .iter()
                .map(|[x, y, z, r]| closest(&Solid::sphere([*x, *y, *z], *r).unwrap(), &solid));
            let expected =
                each.enumerate().min_by(|(_, a), (_, b)| a.distance.total_cmp(&b.distance));
            let cloud = Cloud::of(rows.iter().copied()).unwrap();
            for level in levels() {
                assert_eq!(cloud_any::closest_at(level, &cloud, &solid), expected, "{level:?}");
            }
        }
    }
}
