//! What things are made of: a convex core and a radius round it.

mod check;
mod cloud;
mod cuboid;
mod half_space;
mod hull;
mod segment;

pub use cloud::Cloud;
pub use cuboid::Cuboid;
pub use half_space::HalfSpace;
pub use hull::Hull;
pub use segment::Segment;

use agrik_compute::{Allowed, Result};

use crate::pose::Pose;

/// A point or a vector of three numbers, m where it is a length.
pub type Point = [f64; 3];

/// The largest coordinate and the largest size, m: what is farther out than any place on
/// earth is a mistake, and singles could not hold its square.
pub const LARGEST: f64 = 1e9;

/// The convex set at the heart of a solid.
#[derive(Debug, Clone, PartialEq)]
pub enum Core {
    /// One point: a sphere, once it has a radius.
    Point(Point),
    /// The way between two points: a capsule.
    Segment(Segment),
    /// An oriented box.
    Cuboid(Cuboid),
    /// The convex hull of points.
    Hull(Hull),
    /// All on one side of a plane; the only core without bounds.
    HalfSpace(HalfSpace),
}

impl Core {
    /// The same core of a frame that lies at `pose`.
    pub fn placed(&self, pose: &Pose) -> Self {
        match self {
            Self::Point(p) => Self::Point(pose.point(*p)),
            Self::Segment(segment) => Self::Segment(segment.placed(pose)),
            Self::Cuboid(cuboid) => Self::Cuboid(cuboid.placed(pose)),
            Self::Hull(hull) => Self::Hull(hull.placed(pose)),
            Self::HalfSpace(half_space) => Self::HalfSpace(half_space.placed(pose)),
        }
    }

    /// The point of the core that lies farthest along a direction, m; of a half-space, which
    /// has none, the point of its surface next to the origin.
    pub fn support(&self, direction: Point) -> Point {
        match self {
            Self::Point(p) => *p,
            Self::Segment(segment) => segment.support(direction),
            Self::Cuboid(cuboid) => cuboid.support(direction),
            Self::Hull(hull) => hull.support(direction),
            Self::HalfSpace(half_space) => half_space.foot([0.0; 3]),
        }
    }

    /// Centre and radius of a sphere round the core, m; the radius of a half-space is
    /// infinite.
    #[inline]
    pub fn bounding_sphere(&self) -> (Point, f64) {
        match self {
            Self::Point(p) => (*p, 0.0),
            Self::Segment(segment) => segment.bounding_sphere(),
            Self::Cuboid(cuboid) => cuboid.bounding_sphere(),
            Self::Hull(hull) => hull.bounding_sphere(),
            Self::HalfSpace(half_space) => (half_space.foot([0.0; 3]), f64::INFINITY),
        }
    }

    /// The points whose hull the core is, m; none of a half-space. A bound that is convex in
    /// the point, such as the distance to an axis, need be looked at nowhere else.
    pub fn extreme_points(&self) -> Vec<Point> {
        match self {
            Self::Point(p) => vec![*p],
            Self::Segment(segment) => vec![segment.a, segment.b],
            Self::Cuboid(cuboid) => cuboid.corners().to_vec(),
            Self::Hull(hull) => hull.vertices().collect(),
            Self::HalfSpace(_) => Vec::new(),
        }
    }
}

/// All points within `radius` of a convex core. With the radius 0 it is the core itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    core: Core,
    radius: f64,
}

impl Solid {
    /// A solid of a core.
    ///
    /// # Errors
    ///
    /// `radius` is no finite number from 0 to [`LARGEST`].
    pub fn new(core: Core, radius: f64) -> Result<Self> {
        Allowed::between(0.0, LARGEST).check("radius", radius)?;
        Ok(Self { core, radius })
    }

    /// A sphere round `centre`, m.
    ///
    /// # Errors
    ///
    /// As [`Solid::new`]; a coordinate is not finite or beyond [`LARGEST`].
    pub fn sphere(centre: Point, radius: f64) -> Result<Self> {
        check::point(|| "centre", centre)?;
        Self::new(Core::Point(centre), radius)
    }

    /// A solid of numbers that have been checked.
    pub(crate) fn known(core: Core, radius: f64) -> Self {
        Self { core, radius }
    }

    /// A sphere of numbers that have been checked.
    pub(crate) fn known_sphere(centre: Point, radius: f64) -> Self {
        Self { core: Core::Point(centre), radius }
    }

    /// All within `radius` of the way from `a` to `b`, m.
    ///
    /// # Errors
    ///
    /// As [`Solid::new`] and [`Segment::new`].
    pub fn capsule(a: Point, b: Point, radius: f64) -> Result<Self> {
        Self::new(Core::Segment(Segment::new(a, b)?), radius)
    }

    /// The convex core.
    pub fn core(&self) -> &Core {
        &self.core
    }

    /// The radius round the core, m.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The same solid of a frame that lies at `pose`.
    pub fn placed(&self, pose: &Pose) -> Self {
        Self { core: self.core.placed(pose), radius: self.radius }
    }

    /// Centre and radius of a sphere round the solid, m.
    #[inline]
    pub fn bounding_sphere(&self) -> (Point, f64) {
        let (centre, radius) = self.core.bounding_sphere();
        (centre, radius + self.radius)
    }
}

impl From<Cuboid> for Solid {
    fn from(cuboid: Cuboid) -> Self {
        Self { core: Core::Cuboid(cuboid), radius: 0.0 }
    }
}

impl From<Hull> for Solid {
    fn from(hull: Hull) -> Self {
        Self { core: Core::Hull(hull), radius: 0.0 }
    }
}

impl From<HalfSpace> for Solid {
    fn from(half_space: HalfSpace) -> Self {
        Self { core: Core::HalfSpace(half_space), radius: 0.0 }
    }
}
