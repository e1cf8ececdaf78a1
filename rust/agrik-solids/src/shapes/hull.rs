//! The convex hull of points.

use std::sync::Arc;

use agrik_compute::lanes::{dot, sub};
use agrik_compute::{Error, Result};

use super::{Cuboid, Point, check};
use crate::distance::norm;
use crate::pose::Pose;

/// The points, and what holds in their own frame. Shared by all placings of a hull.
#[derive(Debug, PartialEq)]
struct Vertices {
    points: Vec<Point>,
    /// Middle of the box along the axes round the points.
    centre: Point,
    /// Half lengths of that box.
    half: Point,
    /// Distance of the farthest point from the middle.
    radius: f64,
}

/// The convex hull of points. Points inside it do no harm, but cost time.
#[derive(Debug, Clone, PartialEq)]
pub struct Hull {
    vertices: Arc<Vertices>,
    pose: Pose,
}

impl Hull {
    /// The hull of `points`, m: one or more, in any order, in any position.
    ///
    /// # Errors
    ///
    /// There is no point, or a coordinate is not finite or beyond [`super::LARGEST`].
    pub fn new(points: Vec<Point>) -> Result<Self> {
        let Some(first) = points.first() else {
            return Err(Error::argument("points", "one point or more", "none"));
        };
        let (mut lower, mut upper) = (*first, *first);
        for (i, p) in points.iter().enumerate() {
            check::point(|| format!("points[{i}]"), *p)?;
            for k in 0..3 {
                lower[k] = lower[k].min(p[k]);
                upper[k] = upper[k].max(p[k]);
            }
        }
        let middle = |k: usize| (lower[k] + upper[k]) / 2.0;
        let centre = [middle(0), middle(1), middle(2)];
        let half = sub(upper, centre);
        let radius = points.iter().map(|p| norm(sub(*p, centre))).fold(0.0, f64::max);
        let vertices = Arc::new(Vertices { points, centre, half, radius });
        Ok(Self { vertices, pose: Pose::IDENTITY })
    }

    /// The points, m.
    pub fn vertices(&self) -> impl Iterator<Item = Point> {
        self.vertices.points.iter().map(|p| self.pose.point(*p))
    }

    /// A box round the hull, along the axes of the frame that its points were given in.
    pub fn bounding_box(&self) -> Cuboid {
        let Vertices { centre, half, .. } = *self.vertices;
        let axis = |k: usize| {
            let rows = self.pose.rotation;
            [rows[0][k], rows[1][k], rows[2][k]]
        };
        // A little larger, since turning it rounds.
        let half = half.map(|h| h + 1e-15 * (h + norm(centre) + norm(self.pose.translation)));
        Cuboid::of(self.pose.point(centre), [axis(0), axis(1), axis(2)], half)
    }

    pub(super) fn placed(&self, pose: &Pose) -> Self {
        Self { vertices: Arc::clone(&self.vertices), pose: pose.of(&self.pose) }
    }

    pub(super) fn support(&self, direction: Point) -> Point {
        let inner = self.pose.inner_direction(direction);
        let mut best = (f64::NEG_INFINITY, [0.0; 3]);
        for p in &self.vertices.points {
            let along = dot(inner, *p);
            if along > best.0 {
                best = (along, *p);
            }
        }
        self.pose.point(best.1)
    }

    pub(super) fn bounding_sphere(&self) -> (Point, f64) {
        (self.pose.point(self.vertices.centre), self.vertices.radius)
    }
}
