//! A point and a segment: the foot of the perpendicular, or an end.

use agrik_compute::lanes::{Arithmetic, dot, sub};

use super::{Closest, norm};
use crate::shapes::{Point, Segment};

/// Share of the way along a segment at which it comes nearest to a point: `way` leads from
/// its first end to the second, `from` from the first end to the point, and `inverse` is one
/// over the square of the length, 0 of a segment without any.
#[inline(always)]
pub fn share<N: Arithmetic>(from: &[N; 3], way: &[N; 3], inverse: N) -> N {
    let along = from[0].mul_add(way[0], from[1].mul_add(way[1], from[2] * way[2]));
    (along * inverse).max(N::splat(0.0)).min(N::splat(1.0))
}

/// One over the square of a length; 0 where that is no number to work with.
pub(crate) fn inverse_square(way: Point) -> f64 {
    let square = dot(way, way);
    if square > f64::MIN_POSITIVE { 1.0 / square } else { 0.0 }
}

/// The point of the segment that is nearest.
fn foot(p: Point, segment: &Segment) -> Point {
    let way = sub(segment.b, segment.a);
    segment.at(share(&sub(p, segment.a), &way, inverse_square(way)))
}

/// Where a point and a segment come nearest.
pub fn closest(p: Point, segment: &Segment) -> Closest {
    Closest::between(p, foot(p, segment))
}

/// Distance of a point and a segment, m.
pub fn distance(p: Point, segment: &Segment) -> f64 {
    norm(sub(foot(p, segment), p))
}
