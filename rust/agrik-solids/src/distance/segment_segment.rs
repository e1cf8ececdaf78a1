//! Two segments: the pair of points within both where the connection is perpendicular to
//! both, or an end of one.

use agrik_compute::lanes::{dot, sub};

use super::{Closest, point_segment};
use crate::shapes::{Point, Segment};

/// Square of the sine of the angle below which segments are taken for parallel: then an end
/// of one is as near as anything.
const PARALLEL: f64 = 1e-14;

/// Where two segments come nearest.
pub fn closest(s: &Segment, t: &Segment) -> Closest {
    let ends = [
        point_segment::closest(s.a, t),
        point_segment::closest(s.b, t),
        point_segment::closest(t.a, s).swapped(),
        point_segment::closest(t.b, s).swapped(),
    ];
    let mut best = ends[0];
    for found in ends.into_iter().skip(1).chain(between(s, t)) {
        if found.distance < best.distance {
            best = found;
        }
    }
    best
}

/// Where the connection is perpendicular to both segments, if that is within them.
fn between(s: &Segment, t: &Segment) -> Option<Closest> {
    let (u, v) = (sub(s.b, s.a), sub(t.b, t.a));
    let (a, b, c) = (dot(u, u), dot(u, v), dot(v, v));
    let determinant = a * c - b * b;
    if determinant <= PARALLEL * a * c {
        return None;
    }
    // What is left of the conditions at a pair of shares, and the step that meets them. Of
    // nearly parallel segments the first step loses digits, which the second finds again.
    let step = |at: [f64; 2]| {
        let from: Point = sub(t.at(at[1]), s.at(at[0]));
        let (d, e) = (dot(u, from), dot(v, from));
        [at[0] + (d * c - b * e) / determinant, at[1] + (b * d - a * e) / determinant]
    };
    let [x, y] = step(step([0.5, 0.5]));
    if !(0.0..=1.0).contains(&x) || !(0.0..=1.0).contains(&y) {
        return None;
    }
    Some(Closest::between(s.at(x), t.at(y)))
}
