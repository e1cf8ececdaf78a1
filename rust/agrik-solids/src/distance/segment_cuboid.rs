//! A segment and a box.
//!
//! Along the segment the square of the distance to the box is convex, and its slope is made
//! of straight pieces, which meet where the segment passes a plane of a face. The piece in
//! which the slope changes its sign is found by looking at all six of those places, and its
//! zero by one division.

use agrik_compute::lanes::{Arithmetic, axpy, sub};

use super::{Closest, point_cuboid};
use crate::shapes::{Cuboid, Segment};

/// Share of the way along a segment at which it comes nearest to a box, all in the frame of
/// the box: `from` is the first end, `way` leads to the second.
#[inline(always)]
pub fn share<N: Arithmetic>(from: &[N; 3], way: &[N; 3], half: &[N; 3]) -> N {
    let (zero, one) = (N::splat(0.0), N::splat(1.0));
    // Half the slope of the square of the distance, without one axis.
    let slope = |t: N, without: usize| {
        let mut sum = zero;
        for k in (0..3).filter(|k| *k != without) {
            let at = way[k].mul_add(t, from[k]);
            let within = at.max(-half[k]).min(half[k]);
            sum = way[k].mul_add(at - within, sum);
        }
        sum
    };
    let (mut low, mut high) = (zero, one);
    let (at_start, at_end) = (slope(zero, 3), slope(one, 3));
    let (mut low_slope, mut high_slope) = (at_start, at_end);
    let mut look = |t: N, slope: N| {
        let later = N::and(slope.le(zero), low.lt(t));
        low = N::select(later, t, low);
        low_slope = N::select(later, slope, low_slope);
        let sooner = N::and(zero.le(slope), t.lt(high));
        high = N::select(sooner, t, high);
        high_slope = N::select(sooner, slope, high_slope);
    };
    look(zero, at_start);
    look(one, at_end);
    let (mut enters, mut leaves) = (zero, one);
    for k in 0..3 {
        let (t, u) = ((half[k] - from[k]) / way[k], (-half[k] - from[k]) / way[k]);
        enters = t.min(u).max(enters);
        leaves = t.max(u).min(leaves);
        for t in [t, u] {
            // Where it passes a plane of this axis, the axis has no part in the slope: what
            // rounding makes of it may be larger than all the rest. A place that is not on the
            // segment, or no number where it lies along the plane, decides nothing.
            let on = N::and(zero.lt(t), t.lt(one));
            let decides = N::select(on, slope(t, k), N::splat(f64::NAN));
            look(N::select(on, t, zero), decides);
        }
    }
    let part = (-low_slope / (high_slope - low_slope)).max(zero).min(one);
    let outside = (high - low).mul_add(part, low);
    // Within the box the slope is nothing but rounding: there the middle is as good as any.
    N::select(enters.lt(leaves), (enters + leaves) * N::splat(0.5), outside)
}

/// Where a segment and a box come nearest; a point that they share where they meet.
pub fn closest(segment: &Segment, cuboid: &Cuboid) -> Closest {
    let from = cuboid.local(segment.a);
    let way = sub(cuboid.local(segment.b), from);
    let t = share(&from, &way, &cuboid.half());
    point_cuboid::closest_at(segment.at(t), axpy(way, t, from), cuboid)
}
