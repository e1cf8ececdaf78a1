//! A convex hull and any core with bounds: the method of Gilbert, Johnson and Keerthi.
//!
//! The differences of all points of two cores are a convex set, whose distance from the
//! origin is theirs. A simplex of up to four of its extreme points is drawn towards the
//! origin until no extreme point lies nearer. Source: Gilbert, Johnson and Keerthi, "A fast
//! procedure for computing the distance between complex objects in three-dimensional space",
//! IEEE Journal of Robotics and Automation 4 (1988).

use agrik_compute::lanes::{dot, sub};

use super::simplex::{Corner, Weighted, nearest};
use super::{Closest, norm};
use crate::shapes::{Core, Point};

/// No pair of polyhedra of a few thousand corners takes a tenth of it.
const ROUNDS: usize = 1000;

/// Steps without any gain before the best so far stands.
const IN_VAIN: usize = 12;

/// Where two cores with bounds come nearest; a point that they share where they meet.
pub fn closest(a: &Core, b: &Core) -> Closest {
    // All from the middle of one of them, whatever the distance of both from the origin.
    let (origin, size) = a.bounding_sphere();
    let (other, other_size) = b.bounding_sphere();
    let extreme = |direction: Point| {
        let on_a = sub(a.support(direction.map(|x| -x)), origin);
        let on_b = sub(b.support(direction), origin);
        Corner { difference: sub(on_b, on_a), on_a, on_b }
    };
    // What rounding makes of nothing.
    let reach = size + other_size + norm(sub(other, origin));
    let nothing = 1e-15 * reach;

    let mut simplex = Vec::with_capacity(4);
    simplex.push(extreme(sub(origin, other)));
    let mut found = nearest(&simplex);
    let mut best = Found::of(&found, &simplex);
    let mut in_vain = 0;
    for _ in 0..ROUNDS {
        if best.square <= nothing * nothing {
            break;
        }
        // Nothing lies nearer than the plane through the next corner. The second direction is
        // for simplices so thin that the first has lost its digits.
        let next = [found.direction, found.point].into_iter().find_map(|direction| {
            let next = extreme(direction.map(|x| -x));
            let gain = dot(direction, sub(found.point, next.difference));
            let known = simplex.iter().any(|corner| corner.difference == next.difference);
            (gain > 1e-15 * found.square && !known).then_some(next)
        });
        let Some(next) = next else { break };
        simplex.push(next);
        found = nearest(&simplex);
        reduce(&mut simplex, &mut found);
        // Of several corners that are equally far out the first may be of no use by itself.
        if found.square < best.square {
            best = Found::of(&found, &simplex);
        } else {
            in_vain += 1;
            if in_vain > IN_VAIN {
                break;
            }
        }
    }
    let at = |p: Point| [p[0] + origin[0], p[1] + origin[1], p[2] + origin[2]];
    if best.square <= nothing * nothing {
        return Closest::between(at(best.on_a), at(best.on_a));
    }
    let distance = best.square.sqrt();
    let normal = best.point.map(|x| x / distance);
    Closest { distance, on_a: at(best.on_a), on_b: at(best.on_b), normal }
}

/// Points of both cores.
struct Found {
    square: f64,
    point: Point,
    on_a: Point,
    on_b: Point,
}

impl Found {
    fn of(found: &Weighted, simplex: &[Corner]) -> Self {
        Self {
            square: found.square,
            point: found.point,
            on_a: found.on_core(simplex, |corner| corner.on_a),
            on_b: found.on_core(simplex, |corner| corner.on_b),
        }
    }
}

/// Leaves in the simplex the corners that the point is made of.
fn reduce(simplex: &mut Vec<Corner>, found: &mut Weighted) {
    let kept = found.corners.map(|corner| simplex[corner]);
    simplex.clear();
    simplex.extend_from_slice(&kept[..found.count]);
    found.corners = [0, 1, 2, 3];
}
