//! A core readied for the question how far it is from many points, in lanes of either
//! precision.
//!
//! The points stand in the frame of the core's own coordinates, counted from an origin that
//! the caller chooses: near the points, so that singles have digits enough.

use agrik_compute::lanes::{Arithmetic, dot, sub};

use crate::distance::{point_cuboid, point_segment};
use crate::shapes::{Cuboid, Point, Segment};

/// How far points are, one in each lane.
pub trait Probe<N: Arithmetic>: Copy {
    /// Square of the distance of points from the core, m^2.
    fn square(&self, p: &[N; 3]) -> N;

    /// Lanes, a bit each, whose points may be within `reach` (m, 0 or more) of the core: told
    /// by a sphere round it, where that costs less than the distance.
    #[inline(always)]
    fn maybe_within(&self, _: &[N; 3], _: N) -> u32 {
        u32::MAX
    }
}

#[inline(always)]
fn splat<N: Arithmetic>(v: Point) -> [N; 3] {
    [N::splat(v[0]), N::splat(v[1]), N::splat(v[2])]
}

#[inline(always)]
fn length_square<N: Arithmetic>(v: [N; 3]) -> N {
    v[0].mul_add(v[0], v[1].mul_add(v[1], v[2] * v[2]))
}

/// One point.
#[derive(Debug, Clone, Copy)]
pub struct PointProbe<N> {
    pub(crate) point: [N; 3],
}

impl<N: Arithmetic> PointProbe<N> {
    /// Of a point and the origin, both m.
    #[inline(always)]
    pub fn new(point: Point, origin: Point) -> Self {
        Self { point: splat(sub(point, origin)) }
    }
}

impl<N: Arithmetic> Probe<N> for PointProbe<N> {
    #[inline(always)]
    fn square(&self, p: &[N; 3]) -> N {
        let [x, y, z] = self.point;
        length_square([p[0] - x, p[1] - y, p[2] - z])
    }
}

/// A segment.
#[derive(Debug, Clone, Copy)]
pub struct SegmentProbe<N> {
    pub(crate) from: [N; 3],
    pub(crate) way: [N; 3],
    pub(crate) inverse: N,
}

impl<N: Arithmetic> SegmentProbe<N> {
    /// Of a segment and the origin, m.
    #[inline(always)]
    pub fn new(segment: &Segment, origin: Point) -> Self {
        let way = sub(segment.b, segment.a);
        // A segment that is short by the measure of singles is one point by the same.
        let inverse = point_segment::inverse_square(way);
        let inverse = if inverse < 1e30 { inverse } else { 0.0 };
        Self { from: splat(sub(segment.a, origin)), way: splat(way), inverse: N::splat(inverse) }
    }
}

impl<N: Arithmetic> Probe<N> for SegmentProbe<N> {
    #[inline(always)]
    fn square(&self, p: &[N; 3]) -> N {
        let from = [p[0] - self.from[0], p[1] - self.from[1], p[2] - self.from[2]];
        let t = -point_segment::share(&from, &self.way, self.inverse);
        length_square([
            t.mul_add(self.way[0], from[0]),
            t.mul_add(self.way[1], from[1]),
            t.mul_add(self.way[2], from[2]),
        ])
    }
}

/// A box.
#[derive(Debug, Clone, Copy)]
pub struct CuboidProbe<N> {
    pub(crate) axes: [[N; 3]; 3],
    pub(crate) shift: [N; 3],
    pub(crate) half: [N; 3],
    pub(crate) centre: [N; 3],
    /// Distance of the corners from the centre.
    pub(crate) size: N,
}

impl<N: Arithmetic> CuboidProbe<N> {
    /// Of a box and the origin, m.
    #[inline(always)]
    pub fn new(cuboid: &Cuboid, origin: Point) -> Self {
        let [x, y, z] = cuboid.axes();
        let from = sub(origin, cuboid.centre());
        Self {
            axes: [splat(x), splat(y), splat(z)],
            shift: splat([dot(x, from), dot(y, from), dot(z, from)]),
            half: splat(cuboid.half()),
            centre: splat(sub(cuboid.centre(), origin)),
            size: N::splat(cuboid.bounding_sphere().1),
        }
    }
}

impl<N: Arithmetic> Probe<N> for CuboidProbe<N> {
    #[inline(always)]
    fn maybe_within(&self, p: &[N; 3], reach: N) -> u32 {
        let [x, y, z] = self.centre;
        let far = reach + self.size;
        N::bits(length_square([p[0] - x, p[1] - y, p[2] - z]).le(far * far))
    }

    #[inline(always)]
    fn square(&self, p: &[N; 3]) -> N {
        let mut local = self.shift;
        for k in 0..3 {
            let axis = &self.axes[k];
            local[k] =
                axis[0].mul_add(p[0], axis[1].mul_add(p[1], axis[2].mul_add(p[2], local[k])));
        }
        length_square(point_cuboid::beyond(&local, &self.half))
    }
}
