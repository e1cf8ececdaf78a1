//! An oriented box.

use agrik_compute::lanes::{cross, dot, sub};
use agrik_compute::{Allowed, Error, Result};

use super::{LARGEST, Point, check};
use crate::distance::norm;
use crate::pose::Pose;

/// How far from orthonormal the axes of a box may be given; files round them.
const SKEW: f64 = 1e-6;

/// All points whose coordinates along three orthonormal axes are within half lengths of a
/// centre. A half length may be 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cuboid {
    centre: Point,
    axes: [Point; 3],
    half: Point,
    /// Distance of the corners from the centre.
    size: f64,
}

impl Cuboid {
    /// The two corners of each of the twelve edges, by their numbers in [`Cuboid::corners`].
    pub(crate) const EDGES: [(usize, usize); 12] = [
        (0, 1),
        (2, 3),
        (4, 5),
        (6, 7),
        (0, 2),
        (1, 3),
        (4, 6),
        (5, 7),
        (0, 4),
        (1, 5),
        (2, 6),
        (3, 7),
    ];

    /// A box of centre and half lengths in m, turned by `rotation` (rows; its columns are
    /// the axes of the box), which is made orthonormal to the last digit.
    ///
    /// # Errors
    ///
    /// A coordinate is not finite or beyond [`LARGEST`], a half length is negative as well,
    /// or `rotation` is not orthonormal to 1e-6 with a determinant of 1.
    pub fn new(centre: Point, half: Point, rotation: [[f64; 3]; 3]) -> Result<Self> {
        check::point(|| "centre", centre)?;
        for length in half {
            Allowed::between(0.0, LARGEST).check("half", length)?;
        }
        let axis = |k: usize| [rotation[0][k], rotation[1][k], rotation[2][k]];
        let [x, y, z] = [axis(0), axis(1), axis(2)];
        let off = [dot(x, x) - 1.0, dot(y, y) - 1.0, dot(x, y), norm(sub(cross(x, y), z))];
        // Written so that what is no number fails as well.
        if !off.iter().all(|off| off.abs() <= SKEW) {
            return Err(Error::argument(
                "rotation",
                "orthonormal rows and a determinant of 1",
                format!("{rotation:?}"),
            ));
        }
        let unit = |v: Point| {
            let length = norm(v);
            [v[0] / length, v[1] / length, v[2] / length]
        };
        let x = unit(x);
        let along = dot(x, y);
        let y = unit([y[0] - along * x[0], y[1] - along * x[1], y[2] - along * x[2]]);
        Ok(Self::of(centre, [x, y, cross(x, y)], half))
    }

    /// A box along the axes of the frame.
    ///
    /// # Errors
    ///
    /// As [`Cuboid::new`].
    pub fn upright(centre: Point, half: Point) -> Result<Self> {
        Self::new(centre, half, Pose::IDENTITY.rotation)
    }

    /// A box that is known to be sound.
    pub(crate) fn of(centre: Point, axes: [Point; 3], half: Point) -> Self {
        Self { centre, axes, half, size: norm(half) }
    }

    /// Centre, m.
    pub fn centre(&self) -> Point {
        self.centre
    }

    /// The three unit axes.
    pub fn axes(&self) -> [Point; 3] {
        self.axes
    }

    /// Half lengths along the axes, m.
    pub fn half(&self) -> Point {
        self.half
    }

    /// Coordinates of a point along the axes, from the centre, m.
    pub fn local(&self, p: Point) -> Point {
        let from = sub(p, self.centre);
        [dot(self.axes[0], from), dot(self.axes[1], from), dot(self.axes[2], from)]
    }

    /// The point of these coordinates along the axes, m.
    pub fn point(&self, local: Point) -> Point {
        let [x, y, z] = self.axes;
        let [a, b, c] = local;
        let sum = |k: usize| x[k] * a + y[k] * b + z[k] * c + self.centre[k];
        [sum(0), sum(1), sum(2)]
    }

    /// The eight corners, m; bit `k` of a corner's number is its side along axis `k`.
    pub fn corners(&self) -> [Point; 8] {
        std::array::from_fn(|corner| {
            let side = |k: usize| if corner >> k & 1 != 0 { self.half[k] } else { -self.half[k] };
            self.point([side(0), side(1), side(2)])
        })
    }

    pub(super) fn placed(&self, pose: &Pose) -> Self {
        Self {
            centre: pose.point(self.centre),
            axes: self.axes.map(|axis| pose.direction(axis)),
            half: self.half,
            size: self.size,
        }
    }

    pub(super) fn support(&self, direction: Point) -> Point {
        let side = |k: usize| self.half[k].copysign(dot(self.axes[k], direction));
        self.point([side(0), side(1), side(2)])
    }

    #[inline]
    pub(crate) fn bounding_sphere(&self) -> (Point, f64) {
        (self.centre, self.size)
    }
}
