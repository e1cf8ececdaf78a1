//! What rules out at little cost that balls are near anything: outlines in singles.
//!
//! A lane holds a ball. Whatever is said to be far is far, as what singles round away is added
//! to reaches; what may be near is left to those who decide in doubles. So answers do not
//! depend on what is seen here, nor on when a scene gets its [`Field`].

mod boxed;
mod field;
mod surroundings;

pub use boxed::{Block, Boxed};
pub use field::Field;
pub use surroundings::{Surroundings, Thing, View};

use agrik_compute::lanes::{Real32, sub};

use crate::distance::{norm, point_segment};
use crate::probe::{CuboidProbe, PointProbe, Probe, SegmentProbe};
use crate::shapes::{Core, Cuboid, Point, Solid};

/// Rounding errors of singles that a distance adds up to, in half units of the last place of
/// the largest length that comes into it: those of a pose, of a point in it, of a distance.
const ROUNDINGS: f64 = 128.0 / 16_777_216.0;

/// Most balls that stand for a segment, but for one, and for a box.
const ALONG: f64 = 8.0;
const CELLS: u32 = 18;

/// Reaches are rounded by so much at most, in shares of themselves.
const ROUNDED: f64 = 1.0 + 1e-12;

/// What singles may be off by where no length is more than this, m.
pub fn roundings(length: f64) -> f64 {
    ROUNDINGS * length
}

/// The next single above a number, or itself.
pub fn single_above(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) < x { near.next_up() } else { near }
}

/// A vector in singles.
fn singles(v: Point) -> [f32; 3] {
    v.map(|x| x as f32)
}

#[inline(always)]
fn splat<R: Real32>(v: [f32; 3]) -> [R; 3] {
    [R::splat(f64::from(v[0])), R::splat(f64::from(v[1])), R::splat(f64::from(v[2]))]
}

/// The core of a solid, and its radius.
#[derive(Debug, Clone)]
pub struct Outline {
    core: Kind,
    radius: f32,
}

#[derive(Debug, Clone)]
enum Kind {
    Point([f32; 3]),
    Segment { from: [f32; 3], way: [f32; 3], inverse: f32 },
    Cuboid { axes: [[f32; 3]; 3], centre: [f32; 3], half: [f32; 3] },
    HalfSpace { normal: [f32; 3], offset: f32 },
}

impl Outline {
    /// Of a solid, whose coordinates count from `origin`, m; of a hull that of the box round it.
    pub fn new(solid: &Solid, origin: Point) -> Self {
        let of = |cuboid: &Cuboid| Kind::Cuboid {
            axes: cuboid.axes().map(singles),
            centre: singles(sub(cuboid.centre(), origin)),
            half: cuboid.half().map(single_above),
        };
        let core = match solid.core() {
            Core::Point(p) => Kind::Point(singles(sub(*p, origin))),
            Core::Segment(segment) => {
                let way = sub(segment.b, segment.a);
                // A segment that is short by the measure of singles is one point by the same.
                let inverse = point_segment::inverse_square(way);
                let inverse = if inverse < 1e30 { inverse as f32 } else { 0.0 };
                let from = singles(sub(segment.a, origin));
                Kind::Segment { from, way: singles(way), inverse }
            }
            Core::Cuboid(cuboid) => of(cuboid),
            Core::Hull(hull) => of(&hull.bounding_box()),
            Core::HalfSpace(half_space) => Kind::HalfSpace {
                normal: singles(half_space.normal()),
                offset: -half_space.height(origin) as f32,
            },
        };
        Self { core, radius: single_above(solid.radius()) }
    }

    /// Lanes, a bit each, whose points may be within `reach` (m) of the solid.
    #[inline(always)]
    pub fn maybe<R: Real32>(&self, p: &[R; 3], reach: R) -> u32 {
        let reach = reach + R::splat(f64::from(self.radius));
        let square = match &self.core {
            Kind::Point(point) => PointProbe { point: splat(*point) }.square(p),
            Kind::Segment { from, way, inverse } => {
                let inverse = R::splat(f64::from(*inverse));
                SegmentProbe { from: splat(*from), way: splat(*way), inverse }.square(p)
            }
            Kind::Cuboid { axes, centre, half } => {
                let centre = splat::<R>(*centre);
                let from = [p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]];
                let zero = R::splat(0.0);
                CuboidProbe {
                    axes: [splat(axes[0]), splat(axes[1]), splat(axes[2])],
                    shift: [zero; 3],
                    half: splat(*half),
                    centre: [zero; 3],
                    size: zero,
                }
                .square(&from)
            }
            Kind::HalfSpace { normal, offset } => {
                let [x, y, z] = splat::<R>(*normal);
                let along = x.mul_add(p[0], y.mul_add(p[1], z * p[2]));
                return R::bits((along - R::splat(f64::from(*offset))).le(reach));
            }
        };
        R::bits(square.le(reach * reach))
    }
}

/// Balls (x, y, z, radius, m) that cover a solid with bounds between them, their centres in
/// its core.
pub fn balls(solid: &Solid) -> Vec<[f64; 4]> {
    let more = solid.radius();
    match solid.core() {
        Core::Segment(segment) => {
            let length = norm(sub(segment.b, segment.a));
            if length <= 0.0 {
                return one(solid);
            }
            let pieces = (length / more).min(ALONG).ceil().max(1.0);
            let half = length / (2.0 * pieces);
            let radius = (half * half + more * more).sqrt() * ROUNDED;
            (0..=pieces as u32)
                .map(|piece| {
                    let [x, y, z] = segment.at(f64::from(piece) / pieces);
                    [x, y, z, radius]
                })
                .collect()
        }
        Core::Cuboid(cuboid) => cells(cuboid, more),
        Core::Hull(hull) => cells(&hull.bounding_box(), more),
        Core::Point(_) | Core::HalfSpace(_) => one(solid),
    }
}

fn one(solid: &Solid) -> Vec<[f64; 4]> {
    let ([x, y, z], radius) = solid.bounding_sphere();
    vec![[x, y, z, radius]]
}

/// The balls round cells of a box, which are about as long as they are wide.
fn cells(cuboid: &Cuboid, more: f64) -> Vec<[f64; 4]> {
    let mut counts = [1_u32; 3];
    loop {
        let cell = |k: usize| cuboid.half()[k] / f64::from(counts[k]);
        let mut next = counts;
        let longest = if cell(1) > cell(0) { 1 } else { 0 };
        next[if cell(2) > cell(longest) { 2 } else { longest }] += 1;
        if next.iter().product::<u32>() > CELLS {
            break;
        }
        counts = next;
    }
    let half = [0, 1, 2].map(|k| cuboid.half()[k] / f64::from(counts[k]));
    let radius = (norm(half) + more) * ROUNDED;
    let at = |k: usize, i: u32| half[k] * (1.0 + 2.0 * f64::from(i)) - cuboid.half()[k];
    let mut made = Vec::with_capacity(CELLS as usize);
    for i in 0..counts[0] {
        for j in 0..counts[1] {
            for k in 0..counts[2] {
                let [x, y, z] = cuboid.point([at(0, i), at(1, j), at(2, k)]);
                made.push([x, y, z, radius]);
            }
        }
    }
    made
}
