//! The way between two points.

use agrik_compute::Result;
use agrik_compute::lanes::{dot, sub};

use super::{Point, check};
use crate::distance::norm;
use crate::pose::Pose;

/// All points between two, which may be the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// One end, m.
    pub a: Point,
    /// The other end, m.
    pub b: Point,
}

impl Segment {
    /// The segment from `a` to `b`, m.
    ///
    /// # Errors
    ///
    /// A coordinate is not finite or beyond [`super::LARGEST`].
    pub fn new(a: Point, b: Point) -> Result<Self> {
        check::point(|| "a", a)?;
        check::point(|| "b", b)?;
        Ok(Self { a, b })
    }

    /// The point a share `t` of the way from `a` to `b`, m; exactly `b` for 1.
    pub fn at(&self, t: f64) -> Point {
        let s = 1.0 - t;
        let [a, b] = [self.a, self.b];
        [a[0] * s + b[0] * t, a[1] * s + b[1] * t, a[2] * s + b[2] * t]
    }

    pub(super) fn placed(&self, pose: &Pose) -> Self {
        Self { a: pose.point(self.a), b: pose.point(self.b) }
    }

    pub(super) fn support(&self, direction: Point) -> Point {
        if dot(direction, sub(self.b, self.a)) > 0.0 { self.b } else { self.a }
    }

    pub(super) fn bounding_sphere(&self) -> (Point, f64) {
        (self.at(0.5), norm(sub(self.b, self.a)) / 2.0)
    }
}
