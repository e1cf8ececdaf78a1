//! All on one side of a plane.

use agrik_compute::lanes::{axpy, dot};
use agrik_compute::{Allowed, Error, Result};

use super::{LARGEST, Point, check};
use crate::distance::norm;
use crate::pose::Pose;

/// All points `p` with `normal . p <= offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfSpace {
    normal: Point,
    offset: f64,
}

impl HalfSpace {
    /// The half-space with an outward `normal`, which need not be of unit length, and
    /// `offset` times that length.
    ///
    /// # Errors
    ///
    /// A number is not finite or beyond [`LARGEST`], or the normal has no direction.
    pub fn new(normal: Point, offset: f64) -> Result<Self> {
        check::point(|| "normal", normal)?;
        let length = norm(normal);
        if length < 1e-9 {
            let received = format!("{normal:?}");
            return Err(Error::argument("normal", "a vector that is not zero", received));
        }
        let offset = offset / length;
        Allowed::between(-LARGEST, LARGEST).check("offset", offset)?;
        Ok(Self { normal: normal.map(|x| x / length), offset })
    }

    /// The unit vector out of the solid.
    pub fn normal(&self) -> Point {
        self.normal
    }

    /// Distance of the surface from the origin along the normal, m.
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// Height of a point above the surface, m; negative inside.
    pub fn height(&self, p: Point) -> f64 {
        dot(self.normal, p) - self.offset
    }

    /// The point of the surface below or above a point, m.
    pub fn foot(&self, p: Point) -> Point {
        axpy(self.normal, -self.height(p), p)
    }

    pub(super) fn placed(&self, pose: &Pose) -> Self {
        let normal = pose.direction(self.normal);
        Self { normal, offset: self.offset + dot(normal, pose.translation) }
    }
}
