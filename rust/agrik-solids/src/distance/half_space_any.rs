//! A half-space and anything else: the lowest point of the other above the surface.

use agrik_compute::lanes::{axpy, dot, scale};

use super::Closest;
use crate::shapes::{Core, HalfSpace};

/// Where a half-space and a core come nearest; the distance is negative where the core
/// reaches into it, and then the depth of its lowest point.
pub fn closest(half_space: &HalfSpace, other: &Core) -> Closest {
    let lowest = other.support(half_space.normal().map(|x| -x));
    let distance = half_space.height(lowest);
    let on_a = axpy(half_space.normal(), -distance, lowest);
    Closest { distance, on_a, on_b: lowest, normal: half_space.normal() }
}

/// Two half-spaces: the gap of two that face each other, else minus infinity.
pub fn closest_half_spaces(h: &HalfSpace, g: &HalfSpace) -> Closest {
    let facing = dot(h.normal(), g.normal()) <= -1.0 + 1e-15;
    let distance = if facing { -h.offset() - g.offset() } else { f64::NEG_INFINITY };
    let on_a = scale(h.normal(), h.offset());
    Closest { distance, on_a, on_b: g.foot(on_a), normal: h.normal() }
}
