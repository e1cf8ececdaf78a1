//! A look at a posture: how far it is from the goal, and bounds of that nearby.

use super::{Short, TURNING, Wish};
use crate::closed_form::geometry::rigid::Rigid;
use crate::lanes::{Kernel, Level, Real, V3, axpy, cross, dispatch, dot, norm, scale, splat3, sub};
use crate::task::rotation_between;

/// Passes over the joints in which steps within a cell are looked for.
const PASSES: usize = 3;

/// A posture as it stands to the goal.
pub(super) struct Look<R> {
    /// Way from the tool point to the goal, m: what the slide leaves of it.
    pub way: V3<R>,
    /// The turn to the goal, rad.
    pub turn: V3<R>,
    /// The tool's third axis.
    pub axis: V3<R>,
    /// Way of the tool point by a radian of each joint, m.
    pub ways: [V3<R>; TURNING],
    /// Axes of the joints.
    pub axes: [V3<R>; TURNING],
    /// Value of the slide.
    pub slide: R,
    /// The slide is not at an end of its range.
    pub slides: bool,
}

impl Short {
    /// Looks at joint values.
    #[inline(always)]
    pub(super) fn look<R: Real>(
        &self,
        q: &[R; TURNING],
        goal: &Rigid<f64>,
        range: (f64, f64),
    ) -> Look<R> {
        let (tool, axes, places) = self.serial.forward(q);
        let mut way = sub(splat3(goal.shift), tool.shift);
        let mut slide = R::zero();
        let mut slides = false;
        if let Some(along) = self.slide {
            let wanted = dot(way, splat3(along)) * R::splat(1.0 / dot(along, along));
            slide = wanted.max(R::splat(range.0)).min(R::splat(range.1));
            // Asked of single numbers alone.
            slides = slide.lane(0) == wanted.lane(0);
            way = axpy(splat3(along), -slide, way);
        }
        let turn = match self.wish {
            Wish::Point => [R::zero(); 3],
            Wish::Pose => rotation_between(
                tool.axes,
                [splat3(goal.axes[0]), splat3(goal.axes[1]), splat3(goal.axes[2])],
            ),
            Wish::Axis => turn_between(tool.axes[2], splat3(goal.axes[2])),
        };
        let mut ways = [[R::zero(); 3]; TURNING];
        for k in 0..TURNING {
            ways[k] = cross(axes[k], sub(tool.shift, places[k]));
        }
        Look { way, turn, axis: tool.axes[2], ways, axes, slide, slides }
    }
}

/// The least turn that takes one direction to another one.
#[inline(always)]
fn turn_between<R: Real>(from: V3<R>, to: V3<R>) -> V3<R> {
    // As of frames that share the axis across both.
    let across = cross(from, to);
    let length = norm(across);
    let tiny = length.lt(R::splat(1e-150));
    let [x, y, z] = from;
    // Opposite or the same: any direction across will do.
    let helper = R::bits(tiny) != 0;
    let mut unit = scale(across, R::splat(1.0) / R::select(tiny, R::splat(1.0), length));
    if helper {
        let mixed = [y.neg_mul_add(R::splat(1.0), z), z - x, x - y];
        let other = cross(from, mixed);
        let size = norm(other).max(R::splat(1e-150));
        let other = scale(other, R::splat(1.0) / size);
        for k in 0..3 {
            unit[k] = R::select(tiny, other[k], unit[k]);
        }
    }
    rotation_between([from, unit, cross(from, unit)], [to, unit, cross(to, unit)])
}

/// What is known of a cell of joint values.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Bound {
    /// Error in its middle, m.
    pub error: f64,
    /// No posture in it has a smaller one.
    pub least: f64,
}

/// Cells of one size, by their middles.
struct Cells<'a> {
    short: &'a Short,
    goal: &'a Rigid<f64>,
    range: (f64, f64),
    half: [f64; TURNING],
    middles: &'a [[f64; TURNING]],
    out: &'a mut Vec<Bound>,
}

impl Short {
    /// Bounds of cells of one size.
    pub(super) fn bounds(
        &self,
        level: Level,
        (goal, range): (&Rigid<f64>, (f64, f64)),
        half: [f64; TURNING],
        middles: &[[f64; TURNING]],
        out: &mut Vec<Bound>,
    ) {
        dispatch(level, Cells { short: self, goal, range, half, middles, out });
    }
}

impl Kernel for Cells<'_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        let Self { short, goal, range, half, middles, out } = self;
        out.clear();
        for some in middles.chunks(R::WIDTH) {
            let mut q = [R::zero(); TURNING];
            for lane in 0..R::WIDTH {
                let middle = &some[lane.min(some.len() - 1)];
                for k in 0..TURNING {
                    q[k].set_lane(lane, middle[k]);
                }
            }
            let look = short.look(&q, goal, range);
            let (error, least) = short.bound(&look, &half);
            for lane in 0..some.len() {
                out.push(Bound { error: error.lane(lane), least: least.lane(lane) });
            }
        }
    }
}

impl Short {
    /// The error of a posture, and what it is at least within `half` of it.
    ///
    /// A joint moves the tool by no more than it turns times its lever. Of the second order: the
    /// error is the length of distance and angle, so no less than their sum with the shares that
    /// they have in it here. The distance is no less than its part along the way here. The angle
    /// grows faster than the chord between the two orientations, and the chord is no less than its
    /// part along that here. What is left changes with the joint values as place and orientation
    /// do, whose second derivatives are no larger than levers and one.
    #[inline(always)]
    pub(super) fn bound<R: Real>(&self, look: &Look<R>, half: &[f64; TURNING]) -> (R, R) {
        let per_radian = R::splat(self.per_radian);
        let per_radian2 = per_radian * per_radian;
        let away = norm(look.way);
        let angle2 = dot(look.turn, look.turn);
        let error = away.mul_add(away, per_radian2 * angle2).sqrt();
        let inverse = R::splat(1.0) / error.max(R::splat(1e-300));
        let (mut first, mut second) = (R::zero(), R::zero());
        // Levers of the joints from the last one on, over the whole cell.
        let (mut farther, mut bend, mut turned) = (R::zero(), R::zero(), 0.0);
        for k in (0..TURNING).rev() {
            let h = R::splat(half[k]);
            let lever = norm(look.ways[k]);
            first = lever.mul_add(lever, per_radian2).sqrt().mul_add(h, first);
            let slope = dot(look.way, look.ways[k]) + per_radian2 * dot(look.turn, look.axes[k]);
            second = (slope * inverse).abs().mul_add(h, second);
            let most = lever + farther;
            farther = most.mul_add(h, farther);
            // The joint with itself and with those before it, each of which this one's lever moves.
            bend = (most * h).mul_add(R::splat(half[k]), bend);
            for before in half.iter().take(k) {
                bend = (most * h).mul_add(R::splat(2.0 * before), bend);
            }
            turned += half[k];
        }
        let mut curved = bend * (away * inverse);
        if self.per_radian > 0.0 {
            // Cosine of half the angle, from a series that is below it.
            let x = angle2 * R::splat(0.25);
            let cosine = half_cosine(x);
            let share = per_radian2 * angle2.sqrt() * inverse;
            let most = R::splat(turned * turned) * share;
            curved += most / cosine.max(R::splat(1e-9));
        }
        let by_first = error - first;
        let by_second = error - second - curved * R::splat(0.5);
        let aside = self.aside(look, half, bend, R::splat(turned * turned));
        (error, by_first.max(by_second).max(aside))
    }

    /// What no joint can make good within `half`, to the second order: the part of the error along
    /// any direction, here that which is left after steps within the cell, less what the joints
    /// can move along it.
    #[inline(always)]
    fn aside<R: Real>(&self, look: &Look<R>, half: &[f64; TURNING], bend: R, turned2: R) -> R {
        let across = |way: V3<R>| match self.slide {
            None => way,
            Some(along) => {
                let share = dot(way, splat3(along)) * R::splat(-1.0 / dot(along, along));
                axpy(splat3(along), share, way)
            }
        };
        let per_radian = R::splat(self.per_radian);
        // The chord between orientations is no less than the sine of the turn along its axis.
        let sine = sine_share(dot(look.turn, look.turn));
        let mut left = [across(look.way), scale(look.turn, sine * per_radian)];
        let mut columns = [[[R::zero(); 3]; 2]; TURNING];
        let mut inverse = [R::zero(); TURNING];
        for k in 0..TURNING {
            let mut turn = look.axes[k];
            if self.wish == Wish::Axis {
                // A turn about the axis leaves it where it is.
                turn = axpy(look.axis, -dot(look.axis, turn), turn);
            }
            columns[k] = [across(look.ways[k]), scale(turn, per_radian)];
            let [a, b] = columns[k];
            inverse[k] = R::splat(1.0) / (dot(a, a) + dot(b, b)).max(R::splat(1e-300));
        }
        let mut steps = [R::zero(); TURNING];
        for _ in 0..PASSES {
            for k in 0..TURNING {
                let [a, b] = columns[k];
                let wanted = (dot(a, left[0]) + dot(b, left[1])).mul_add(inverse[k], steps[k]);
                let h = R::splat(half[k]);
                let next = wanted.min(h).max(-h);
                let by = steps[k] - next;
                left = [axpy(a, by, left[0]), axpy(b, by, left[1])];
                steps[k] = next;
            }
        }
        let size = (dot(left[0], left[0]) + dot(left[1], left[1])).sqrt();
        let unit = R::splat(1.0) / size.max(R::splat(1e-300));
        let [u, v] = [scale(left[0], unit), scale(left[1], unit)];
        // What is left is what there was less the steps: the part of the whole along it.
        let mut least = size;
        for k in 0..TURNING {
            let [a, b] = columns[k];
            let slope = dot(a, u) + dot(b, v);
            least += slope * steps[k] - slope.abs() * R::splat(half[k]);
        }
        let curved = norm(u) * bend + norm(v) * per_radian * turned2;
        least - curved * R::splat(0.5)
    }
}

/// No more than the sine of an angle over the angle, given squared.
#[inline(always)]
fn sine_share<R: Real>(x2: R) -> R {
    // 1 - x^2/6 + x^4/120 - x^6/5040: the next term would be added.
    let a = x2.neg_mul_add(R::splat(1.0 / 5040.0), R::splat(1.0 / 120.0));
    let b = x2.neg_mul_add(a, R::splat(1.0 / 6.0));
    x2.neg_mul_add(b, R::splat(1.0)).max(R::zero())
}

/// No more than the cosine of an angle up to a right one, given squared.
#[inline(always)]
fn half_cosine<R: Real>(x2: R) -> R {
    // 1 - x^2/2 + x^4/24 - x^6/720: the next term would be added.
    let a = x2.neg_mul_add(R::splat(1.0 / 720.0), R::splat(1.0 / 24.0));
    let b = x2.neg_mul_add(a, R::splat(0.5));
    x2.neg_mul_add(b, R::splat(1.0))
}
