//! Boxes, one in each lane, and whether a plane is sure to part them from other solids.
//!
//! Two boxes are apart exactly where a plane across a face of one of them parts them, or one
//! along an edge of each. Along every other direction a gap is no more than the distance, so a gap
//! that is larger than a reach rules out that they are within it. Directions along two edges are
//! no longer than one, which makes gaps along them less and never more.

use agrik_compute::lanes::{Real32, dot, sub};

use super::{Kind, Outline, single_above, singles, splat};
use crate::distance::norm;
use crate::shapes::{Core, Cuboid, Solid};

/// A box in the frame of a body.
#[derive(Debug, Clone)]
pub struct Block {
    /// The middle, m.
    pub centre: [f32; 3],
    /// Unit vectors along its edges.
    pub axes: [[f32; 3]; 3],
    /// Half lengths, m.
    pub half: [f32; 3],
    /// How far the solid reaches beyond it, m.
    pub radius: f32,
}

/// A box where it lies, one in each lane.
#[derive(Debug, Clone, Copy)]
pub struct Boxed<R> {
    /// The middle, m.
    pub centre: [R; 3],
    /// Unit vectors along its edges.
    pub axes: [[R; 3]; 3],
    /// Half lengths, m.
    pub half: [R; 3],
}

impl Block {
    /// Of a box, or of a hull by the box round it; of other solids none.
    pub fn new(solid: &Solid) -> Option<Self> {
        let of = |cuboid: &Cuboid| Self {
            centre: singles(cuboid.centre()),
            axes: cuboid.axes().map(singles),
            half: cuboid.half().map(single_above),
            radius: single_above(solid.radius()),
        };
        match solid.core() {
            Core::Cuboid(cuboid) => Some(of(cuboid)),
            Core::Hull(hull) => Some(of(&hull.bounding_box())),
            Core::Point(_) | Core::Segment(_) | Core::HalfSpace(_) => None,
        }
    }
}

/// The two axes after one.
const NEXT: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];

impl<R: Real32> Boxed<R> {
    /// How far the boxes reach from their middles along the axes of the world, m.
    #[inline(always)]
    pub fn extent(&self) -> [R; 3] {
        let mut extent = [R::splat(0.0); 3];
        for (axis, half) in self.axes.iter().zip(&self.half) {
            for (sum, x) in extent.iter_mut().zip(axis) {
                *sum = x.abs().mul_add(*half, *sum);
            }
        }
        extent
    }

    /// A vector by its parts along the axes.
    #[inline(always)]
    fn along(&self, v: &[R; 3]) -> [R; 3] {
        [dot(*v, self.axes[0]), dot(*v, self.axes[1]), dot(*v, self.axes[2])]
    }

    /// Lanes, a bit each, in which another box may be within `reach` (m).
    #[inline(always)]
    pub fn maybe(&self, other: &Self, reach: R) -> u32 {
        let (h, g) = (&self.half, &other.half);
        let way = sub(other.centre, self.centre);
        let (t, u) = (self.along(&way), other.along(&way));
        let b = &other.axes;
        let c = [self.along(&b[0]), self.along(&b[1]), self.along(&b[2])];
        let mut size = c;
        for row in &mut size {
            for x in row {
                *x = x.abs();
            }
        }
        let mut gap = t[0].abs() - h[0];
        for i in 0..3 {
            let of_other = size[0][i].mul_add(g[0], size[1][i].mul_add(g[1], size[2][i] * g[2]));
            gap = if i == 0 { gap - of_other } else { gap.max(t[i].abs() - h[i] - of_other) };
            let of_this = size[i][0].mul_add(h[0], size[i][1].mul_add(h[1], size[i][2] * h[2]));
            gap = gap.max(u[i].abs() - g[i] - of_this);
        }
        if R::bits(gap.le(reach)) == 0 {
            return 0;
        }
        for i in 0..3 {
            let [i1, i2] = NEXT[i];
            for j in 0..3 {
                let [j1, j2] = NEXT[j];
                let apart = (t[i2] * c[j][i1] - t[i1] * c[j][i2]).abs();
                let of_this = h[i1].mul_add(size[j][i2], h[i2] * size[j][i1]);
                let of_other = g[j1].mul_add(size[j2][i], g[j2] * size[j1][i]);
                gap = gap.max(apart - of_this - of_other);
            }
        }
        R::bits(gap.le(reach))
    }
}

impl Outline {
    /// Lanes, a bit each, in which a box may be within `reach` (m, 0 or more) of the solid.
    #[inline(always)]
    pub fn maybe_box<R: Real32>(&self, boxed: &Boxed<R>, reach: R) -> u32 {
        let reach = reach + R::splat(f64::from(self.radius));
        let h = &boxed.half;
        let zero = R::splat(0.0);
        match &self.core {
            Kind::Point(point) => {
                let t = boxed.along(&sub(splat(*point), boxed.centre));
                let mut square = zero;
                for k in 0..3 {
                    let over = (t[k].abs() - h[k]).max(zero);
                    square = over.mul_add(over, square);
                }
                R::bits(square.le(reach * reach))
            }
            Kind::Segment { from, way, .. } => {
                let half = way.map(|x| 0.5 * x);
                let middle = [0, 1, 2].map(|k| from[k] + half[k]);
                let t = boxed.along(&sub(splat(middle), boxed.centre));
                let w = boxed.along(&splat(half));
                let length = norm(half.map(f64::from));
                let (mut faces, mut edges) = (t[0].abs() - h[0] - w[0].abs(), zero - reach);
                for k in 0..3 {
                    faces = faces.max(t[k].abs() - h[k] - w[k].abs());
                    let [k1, k2] = NEXT[k];
                    let apart = (t[k1] * w[k2] - t[k2] * w[k1]).abs();
                    let of_box = h[k1].mul_add(w[k2].abs(), h[k2] * w[k1].abs());
                    edges = edges.max(apart - of_box);
                }
                // What is across the segment is no longer than it.
                let near = edges.le(reach * R::splat(length));
                R::bits(R::and(faces.le(reach), near))
            }
            Kind::Cuboid { axes, centre, half } => {
                let axes = [splat(axes[0]), splat(axes[1]), splat(axes[2])];
                let this = Boxed { centre: splat(*centre), axes, half: splat(*half) };
                boxed.maybe(&this, reach)
            }
            Kind::HalfSpace { normal, offset } => {
                let n = splat(*normal);
                let along = boxed.along(&n);
                let low = along[0].abs().mul_add(h[0], along[1].abs() * h[1]);
                let low = along[2].abs().mul_add(h[2], low);
                let height = dot(n, boxed.centre) - low - R::splat(f64::from(*offset));
                R::bits(height.le(reach))
            }
        }
    }
}
