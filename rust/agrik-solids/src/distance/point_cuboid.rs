//! A point and a box: in its frame, what of each coordinate is beyond the half length.

use agrik_compute::lanes::{Arithmetic, axpy, scale};

use super::{Closest, norm};
use crate::shapes::{Cuboid, Point};

/// How far each coordinate is beyond the half length, 0 within it.
#[inline(always)]
pub fn beyond<N: Arithmetic>(local: &[N; 3], half: &[N; 3]) -> [N; 3] {
    let zero = N::splat(0.0);
    [
        (local[0].abs() - half[0]).max(zero),
        (local[1].abs() - half[1]).max(zero),
        (local[2].abs() - half[2]).max(zero),
    ]
}

/// Where a point and a box come nearest; the point itself where it is inside.
pub fn closest(p: Point, cuboid: &Cuboid) -> Closest {
    closest_at(p, cuboid.local(p), cuboid)
}

/// The same, of a point whose coordinates in the frame of the box are known.
pub(super) fn closest_at(p: Point, local: Point, cuboid: &Cuboid) -> Closest {
    let over = beyond(&local, &cuboid.half());
    if over == [0.0; 3] {
        return Closest::between(p, p);
    }
    // All from the frame of the box: the difference of two points far from the origin has
    // fewer digits.
    let distance = norm(over);
    let side = |k: usize| -over[k].copysign(local[k]) / distance;
    let [x, y, z] = cuboid.axes();
    let normal = axpy(x, side(0), axpy(y, side(1), scale(z, side(2))));
    Closest { distance, on_a: p, on_b: axpy(normal, distance, p), normal }
}

/// Distance of a point and a box, m.
pub fn distance(p: Point, cuboid: &Cuboid) -> f64 {
    norm(beyond(&cuboid.local(p), &cuboid.half()))
}
