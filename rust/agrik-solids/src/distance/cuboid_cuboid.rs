//! Two boxes: the nearest of the edges of one and the other as a whole.
//!
//! Where boxes meet, an edge of one meets the other; where they do not, the nearest points
//! lie on a corner or an edge of one of them.

use agrik_compute::lanes::{dot, sub};

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
    gap_up_to(a, b, f64::INFINITY)
}

/// The same, or some gap that is wider than `enough` (m) where there is one: most boxes that
/// are apart are so along one of the first directions.
pub fn gap_up_to(a: &Cuboid, b: &Cuboid, enough: f64) -> f64 {
    let way = sub(b.centre(), a.centre());
    let (mine, theirs, h, g) = (a.axes(), b.axes(), a.half(), b.half());
    // All in the frame of the first box.
    let to = [dot(mine[0], way), dot(mine[1], way), dot(mine[2], way)];
    let mut turned = [[0.0; 3]; 3];
    let mut size = [[0.0; 3]; 3];
    let mut widest = f64::NEG_INFINITY;
    for k in 0..3 {
        for j in 0..3 {
            turned[k][j] = dot(mine[k], theirs[j]);
            size[k][j] = turned[k][j].abs();
        }
        let reach = h[k] + (g[0] * size[k][0] + g[1] * size[k][1] + g[2] * size[k][2]);
        widest = widest.max(to[k].abs() - reach);
    }
    if widest > enough {
        return widest;
    }
    for j in 0..3 {
        let reach = g[j] + (h[0] * size[0][j] + h[1] * size[1][j] + h[2] * size[2][j]);
        widest = widest.max(dot(theirs[j], way).abs() - reach);
    }
    if widest > enough {
        return widest;
    }
    // The cross products of two axes, by their two components that are not zero.
    for k in 0..3 {
        let (k1, k2) = ((k + 1) % 3, (k + 2) % 3);
        for j in 0..3 {
            let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
            let length = (turned[k1][j] * turned[k1][j] + turned[k2][j] * turned[k2][j]).sqrt();
            let reach = h[k1] * size[k2][j]
                + h[k2] * size[k1][j]
                + (g[j1] * size[k][j2] + g[j2] * size[k][j1]);
            let gap = (to[k2] * turned[k1][j] - to[k1] * turned[k2][j]).abs() - reach;
            // Of nearly parallel edges the direction is one of those above.
            if length > 1e-6 && gap > widest * length {
                widest = gap / length;
            }
        }
    }
    widest
}
