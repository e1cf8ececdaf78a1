//! Two boxes: the nearest of the edges of one and the other as a whole.
//!
//! Where boxes meet, an edge of one meets the other; where they do not, the nearest points
//! lie on a corner or an edge of one of them.

use agrik_compute::lanes::{cross, dot, sub};

use super::{Closest, norm, segment_cuboid};
use crate::shapes::{Cuboid, Segment};

/// Distance, by the measure of sizes, that is nothing but rounding.
const TOUCHING: f64 = 1e-14;

/// Where two boxes come nearest; a point that they share where they meet.
pub fn closest(a: &Cuboid, b: &Cuboid) -> Closest {
    let mut best =
        Closest { distance: f64::INFINITY, on_a: a.centre(), on_b: b.centre(), normal: [0.0; 3] };
    edges_to_box(a, b, &mut best);
    if best.distance > 0.0 {
        best = best.swapped();
        edges_to_box(b, a, &mut best);
        best = best.swapped();
    }
    // The edge that meets the other box may lie in a face of it, and rounding beside it.
    let size = norm(a.half()) + norm(b.half()) + norm(sub(a.centre(), b.centre()));
    if best.distance <= TOUCHING * size {
        return Closest::between(best.on_a, best.on_a);
    }
    best
}

/// Puts into `best` where an edge of `a` comes nearer to `b` than it.
fn edges_to_box(a: &Cuboid, b: &Cuboid, best: &mut Closest) {
    let half = b.half();
    let corners = a.corners();
    let local = corners.map(|corner| b.local(corner));
    for (from, to) in Cuboid::EDGES {
        // The box round the edge, along the axes of `b`, is mostly too far away.
        let (p, q) = (local[from], local[to]);
        let off = |k: usize| {
            let (low, high) = if p[k] < q[k] { (p[k], q[k]) } else { (q[k], p[k]) };
            (low - half[k]).max(-half[k] - high).max(0.0)
        };
        if norm([off(0), off(1), off(2)]) < best.distance {
            let edge = Segment { a: corners[from], b: corners[to] };
            let found = segment_cuboid::closest(&edge, b);
            if found.distance < best.distance {
                *best = found;
                if best.distance == 0.0 {
                    return;
                }
            }
        }
    }
}

/// The widest gap between two boxes along the 15 directions that can part them, m: never
/// more than their distance, and negative exactly where they overlap (but for rounding).
pub fn gap_between_planes(a: &Cuboid, b: &Cuboid) -> f64 {
    let way = sub(b.centre(), a.centre());
    let turned = a.axes().map(|x| b.axes().map(|y| dot(x, y)));
    let (h, g) = (a.half(), b.half());
    let mut widest = f64::NEG_INFINITY;
    for k in 0..3 {
        let mine = h[k] + (0..3).map(|j| g[j] * turned[k][j].abs()).sum::<f64>();
        widest = widest.max(dot(a.axes()[k], way).abs() - mine);
        let theirs = g[k] + (0..3).map(|j| h[j] * turned[j][k].abs()).sum::<f64>();
        widest = widest.max(dot(b.axes()[k], way).abs() - theirs);
    }
    for x in a.axes() {
        for y in b.axes() {
            let direction = cross(x, y);
            let length = norm(direction);
            // Of nearly parallel edges the direction is one of those above.
            if length > 1e-6 {
                let spread = |c: &Cuboid| {
                    let [u, v, w] = c.axes().map(|axis| dot(axis, direction).abs());
                    c.half()[0] * u + c.half()[1] * v + c.half()[2] * w
                };
                let gap = dot(direction, way).abs() - spread(a) - spread(b);
                widest = widest.max(gap / length);
            }
        }
    }
    widest
}
