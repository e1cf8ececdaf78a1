//! Two points.

use super::Closest;
use crate::shapes::Point;

/// The points themselves.
pub fn closest(p: Point, q: Point) -> Closest {
    Closest::between(p, q)
}
