//! Rigid motions in lanes.

use crate::lanes::{Real, V3, axpy, cross, dot, scale, splat3, sub};

/// A rotation (columns) and the shift after it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rigid<R> {
    /// Images of the unit vectors.
    pub axes: [V3<R>; 3],
    /// Image of the origin, m.
    pub shift: V3<R>,
}

impl<R: Real> Rigid<R> {
    /// No motion at all.
    #[inline(always)]
    pub fn identity() -> Self {
        let (o, i) = (R::zero(), R::splat(1.0));
        Self { axes: [[i, o, o], [o, i, o], [o, o, i]], shift: [o, o, o] }
    }

    /// The same motion in every lane.
    #[inline(always)]
    pub fn splat(one: &Rigid<f64>) -> Self {
        let axes = [splat3(one.axes[0]), splat3(one.axes[1]), splat3(one.axes[2])];
        Self { axes, shift: splat3(one.shift) }
    }

    /// Makes a motion that of one lane.
    #[inline(always)]
    pub fn set_lane(&mut self, lane: usize, one: &Rigid<f64>) {
        for k in 0..3 {
            self.shift[k].set_lane(lane, one.shift[k]);
            for i in 0..3 {
                self.axes[i][k].set_lane(lane, one.axes[i][k]);
            }
        }
    }

    /// A direction turned.
    #[inline(always)]
    pub fn turn(&self, v: V3<R>) -> V3<R> {
        axpy(self.axes[2], v[2], axpy(self.axes[1], v[1], scale(self.axes[0], v[0])))
    }

    /// A direction turned back.
    #[inline(always)]
    pub fn turn_back(&self, v: V3<R>) -> V3<R> {
        [dot(self.axes[0], v), dot(self.axes[1], v), dot(self.axes[2], v)]
    }

    /// A point moved.
    #[inline(always)]
    pub fn apply(&self, p: V3<R>) -> V3<R> {
        axpy(self.axes[2], p[2], axpy(self.axes[1], p[1], axpy(self.axes[0], p[0], self.shift)))
    }

    /// `self` after `first`.
    #[inline(always)]
    pub fn after(&self, first: &Self) -> Self {
        Self {
            axes: [self.turn(first.axes[0]), self.turn(first.axes[1]), self.turn(first.axes[2])],
            shift: self.apply(first.shift),
        }
    }

    /// The way back.
    #[inline(always)]
    pub fn inverse(&self) -> Self {
        let [x, y, z] = self.axes;
        let back = self.turn_back(self.shift);
        Self {
            axes: [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]],
            shift: [-back[0], -back[1], -back[2]],
        }
    }
}

/// A direction turned about a unit axis by an angle given as sine and cosine.
#[inline(always)]
pub fn turned_about<R: Real>(axis: V3<R>, (s, c): (R, R), v: V3<R>) -> V3<R> {
    let along = dot(axis, v) * (R::splat(1.0) - c);
    axpy(axis, along, axpy(cross(axis, v), s, scale(v, c)))
}

/// A turn about a line through `point`.
#[inline(always)]
pub fn turn_about<R: Real>(axis: V3<R>, point: V3<R>, turn: (R, R)) -> Rigid<R> {
    let unit = Rigid::<R>::identity().axes;
    let axes = [
        turned_about(axis, turn, unit[0]),
        turned_about(axis, turn, unit[1]),
        turned_about(axis, turn, unit[2]),
    ];
    Rigid { axes, shift: sub(point, turned_about(axis, turn, point)) }
}
