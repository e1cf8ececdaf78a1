//! Where a frame lies.

use agrik_compute::lanes::dot;

use crate::shapes::Point;

/// A rotation followed by a shift: the coordinates of one frame in another.
///
/// All numbers are finite; it is for those who make poses to see to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// The rows of the rotation, orthonormal.
    pub rotation: [[f64; 3]; 3],
    /// Origin of the inner frame, m.
    pub translation: Point,
}

impl Pose {
    /// The frame itself.
    pub const IDENTITY: Self = Self {
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [0.0; 3],
    };

    /// A point of the inner frame in the outer one, m.
    pub fn point(&self, p: Point) -> Point {
        let turned = self.direction(p);
        [
            turned[0] + self.translation[0],
            turned[1] + self.translation[1],
            turned[2] + self.translation[2],
        ]
    }

    /// A direction of the inner frame in the outer one.
    pub fn direction(&self, d: Point) -> Point {
        [dot(self.rotation[0], d), dot(self.rotation[1], d), dot(self.rotation[2], d)]
    }

    /// A direction of the outer frame in the inner one.
    pub fn inner_direction(&self, d: Point) -> Point {
        let [x, y, z] = self.rotation;
        let turned = |k: usize| x[k] * d[0] + y[k] * d[1] + z[k] * d[2];
        [turned(0), turned(1), turned(2)]
    }

    /// `self` after `inner`: where a frame lies that `inner` places in this frame.
    pub fn of(&self, inner: &Self) -> Self {
        let column = |k: usize| {
            self.direction([inner.rotation[0][k], inner.rotation[1][k], inner.rotation[2][k]])
        };
        let [x, y, z] = [column(0), column(1), column(2)];
        Self {
            rotation: [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]],
            translation: self.point(inner.translation),
        }
    }
}
