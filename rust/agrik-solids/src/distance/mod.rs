//! How far two solids are apart, and where: one file a pair of kinds of cores.
//!
//! All is worked out in doubles and exact but for rounding. Distances of cores are lengths
//! between two points that lie in them, so rounding makes them too long rather than too
//! short; only a half-space, whose depth has a meaning, gives negative ones.

pub mod cloud_any;
pub mod cuboid_cuboid;
pub mod half_space_any;
pub mod hull_any;
pub mod point_cuboid;
pub mod point_point;
pub mod point_segment;
pub mod segment_cuboid;
pub mod segment_segment;
mod simplex;

pub(crate) use agrik_compute::lanes::norm;
use agrik_compute::lanes::{axpy, sub};

use crate::shapes::{Core, Point, Solid};

/// Where two solids come nearest to each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closest {
    /// Distance, m; 0 or less in contact. Of two solids in contact its size has a meaning
    /// only where one is a half-space or both cores are points or segments.
    pub distance: f64,
    /// The point of the first solid, m.
    pub on_a: Point,
    /// The point of the second solid, m.
    pub on_b: Point,
    /// Unit vector from the first to the second, along which they would part; zeros where
    /// the cores themselves meet.
    pub normal: Point,
}

impl Closest {
    /// Of two cores, by the points found.
    pub(crate) fn between(on_a: Point, on_b: Point) -> Self {
        let way = sub(on_b, on_a);
        let distance = norm(way);
        let normal = if distance > 0.0 { way.map(|x| x / distance) } else { [0.0; 3] };
        Self { distance, on_a, on_b, normal }
    }

    /// The same with the solids exchanged.
    pub fn swapped(self) -> Self {
        Self {
            distance: self.distance,
            on_a: self.on_b,
            on_b: self.on_a,
            normal: self.normal.map(|x| -x),
        }
    }
}

/// Where two solids come nearest, and how near. Of two half-spaces the distance is minus
/// infinity unless they face each other.
///
/// ```
/// use agrik_solids::{Cuboid, Solid, closest};
///
/// let ball = Solid::sphere([0.0, 0.0, 1.0], 0.25)?;
/// let table = Solid::from(Cuboid::upright([0.0; 3], [1.0, 1.0, 0.25])?);
/// let found = closest(&ball, &table);
/// assert_eq!(found.distance, 0.5);
/// assert_eq!(found.on_b, [0.0, 0.0, 0.25]);
/// # Ok::<(), agrik_solids::Error>(())
/// ```
pub fn closest(a: &Solid, b: &Solid) -> Closest {
    let cores = closest_cores(a.core(), b.core());
    Closest {
        distance: cores.distance - a.radius() - b.radius(),
        on_a: axpy(cores.normal, a.radius(), cores.on_a),
        on_b: axpy(cores.normal, -b.radius(), cores.on_b),
        normal: cores.normal,
    }
}

/// Distance of two solids, m: that of [`closest`].
pub fn distance(a: &Solid, b: &Solid) -> f64 {
    closest_cores(a.core(), b.core()).distance - a.radius() - b.radius()
}

/// True where two solids have a point in common: exactly where [`distance`] is 0 or less.
pub fn overlaps(a: &Solid, b: &Solid) -> bool {
    within(a, b, 0.0)
}

/// True where [`distance`] is `reach` (m) or less. Quicker than the distance, where spheres
/// round the solids or planes between two boxes tell.
pub fn within(a: &Solid, b: &Solid, reach: f64) -> bool {
    let radii = a.radius() + b.radius();
    match Rough::of(a.core(), b.core(), reach + radii) {
        Rough::Farther => false,
        Rough::Meeting => -radii <= reach,
        Rough::Near => distance(a, b) <= reach,
    }
}

/// [`distance`], or infinity where spheres round the solids or planes between two boxes tell
/// that it is above `reach` (m).
pub fn distance_within(a: &Solid, b: &Solid, reach: f64) -> f64 {
    let radii = a.radius() + b.radius();
    match Rough::of(a.core(), b.core(), reach + radii) {
        Rough::Farther => f64::INFINITY,
        Rough::Meeting => -radii,
        Rough::Near => distance(a, b),
    }
}

/// What can be told of two cores without their distance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Rough {
    /// They are farther apart than was asked.
    Farther,
    /// They have points in common, and their distance is 0.
    Meeting,
    /// They may be near enough.
    Near,
}

impl Rough {
    /// Of two cores and a distance, m.
    #[inline]
    pub(crate) fn of(a: &Core, b: &Core, reach: f64) -> Self {
        let ((p, size), (q, other)) = (a.bounding_sphere(), b.bounding_sphere());
        let apart = norm(sub(p, q));
        // Wider than any rounding of either.
        let slack = 1e-12 * (apart + size + other);
        if apart - size - other > reach + slack {
            return Self::Farther;
        }
        if let (Core::Cuboid(a), Core::Cuboid(b)) = (a, b) {
            let gap = cuboid_cuboid::gap_up_to(a, b, reach + slack);
            if gap > reach + slack {
                return Self::Farther;
            }
            if gap < -slack {
                return Self::Meeting;
            }
        }
        Self::Near
    }
}

/// Where two cores come nearest.
pub fn closest_cores(a: &Core, b: &Core) -> Closest {
    use Core::{Cuboid, HalfSpace, Hull, Point, Segment};
    match (a, b) {
        (Point(p), Point(q)) => point_point::closest(*p, *q),
        (Point(p), Segment(s)) => point_segment::closest(*p, s),
        (Segment(s), Point(p)) => point_segment::closest(*p, s).swapped(),
        (Point(p), Cuboid(c)) => point_cuboid::closest(*p, c),
        (Cuboid(c), Point(p)) => point_cuboid::closest(*p, c).swapped(),
        (Segment(s), Segment(t)) => segment_segment::closest(s, t),
        (Segment(s), Cuboid(c)) => segment_cuboid::closest(s, c),
        (Cuboid(c), Segment(s)) => segment_cuboid::closest(s, c).swapped(),
        (Cuboid(c), Cuboid(d)) => cuboid_cuboid::closest(c, d),
        (HalfSpace(h), HalfSpace(g)) => half_space_any::closest_half_spaces(h, g),
        (HalfSpace(h), other) => half_space_any::closest(h, other),
        (other, HalfSpace(h)) => half_space_any::closest(h, other).swapped(),
        (Hull(_), _) | (_, Hull(_)) => hull_any::closest(a, b),
    }
}

/// Distance of a core and a point, m: that of [`closest_cores`], without the places.
pub fn point_to_core(p: Point, core: &Core) -> f64 {
    match core {
        Core::Point(q) => norm(sub(*q, p)),
        Core::Segment(segment) => point_segment::distance(p, segment),
        Core::Cuboid(cuboid) => point_cuboid::distance(p, cuboid),
        other => closest_cores(&Core::Point(p), other).distance,
    }
}
