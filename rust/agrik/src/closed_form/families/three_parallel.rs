//! Six joints of which axes 2, 3 and 4 are parallel and axes 5 and 6 meet, as in the arms of
//! Universal Robots: three linear equations in one angle each, and a two-link arm.
//!
//! The point where axes 5 and 6 meet moves across the three parallel axes by the first joint
//! alone; then the direction of axis 6 gives the fifth, that of the parallel axes the sixth, and
//! joints 2 to 4 are a planar arm. Two values for each of the first, the fifth and the third
//! joint: eight postures.

use super::postures::{Candidates, Set};
use crate::closed_form::geometry::enclosure::{Arc, Margin, linear_arcs};
use crate::closed_form::geometry::range::Range;
use crate::closed_form::geometry::rigid::{Rigid, turn_about, turned_about};
use crate::closed_form::geometry::screws::{EXACT, Screws};
use crate::closed_form::geometry::serial::Serial;
use crate::closed_form::geometry::turn::{Root, Side, Turn, linear, minus, unit_pair, unit_turn};
use crate::lanes::{
    Kernel, Lanes, Level, Real, V3, atan2, atan2_each, axpy, cross, dispatch, dot, norm, splat3,
    sub,
};

/// Lengths (arm lengths) below which an equation leaves its angle open.
const OPEN: f64 = 1e-9;

/// An arm with three parallel axes, in arm lengths.
#[derive(Debug, Clone, PartialEq)]
pub struct ThreeParallel {
    serial: Serial<6>,
    untool: Rigid<f64>,
    axes: [V3<f64>; 6],
    first: V3<f64>,
    /// Where axes 5 and 6 meet.
    meeting: V3<f64>,
    /// Axis 2 to 3 and 3 to 4, across the axes, and points on axes 2, 4 and 5.
    upper: V3<f64>,
    fore: V3<f64>,
    second: V3<f64>,
    fourth: V3<f64>,
    /// Whether axes 3 and 4 point as axis 2 does, 1 or -1.
    signs: [f64; 2],
    across: V3<f64>,
    length: f64,
    /// Arm lengths and rad by which the axes are off from what they are taken for, at most.
    misfit: f64,
}

/// Sine of the angle between axis 6 and the parallel ones below which nothing decides joint 6: an
/// angle of 0 comes out of its cosine to half the digits.
const IN_LINE: f64 = 3e-8;

impl ThreeParallel {
    /// The arm, or why it is none.
    pub fn new(screws: &Screws) -> Result<Self, String> {
        let screws = screws.gathered();
        let length = screws.length();
        let arm = screws.scaled(1.0 / length);
        let serial = Serial::<6>::new(&arm).ok_or("it has no six joints")?;
        let tilt = arm.tilt(1, 2).max(arm.tilt(2, 3)).max(arm.tilt(1, 3));
        if tilt > EXACT {
            return Err(format!("its axes 2, 3 and 4 are {tilt:.1e} rad from parallel"));
        }
        let (meeting, gap) = arm.meeting(4..6).ok_or("its axes 5 and 6 are parallel")?;
        if gap > EXACT {
            return Err(format!("its axes 5 and 6 pass by {:.3} mm", 1e3 * gap * length));
        }
        let joint = |k: usize| arm.joints[k];
        let n = joint(1).axis;
        let flat = |v: V3<f64>| axpy(n, -dot(n, v), v);
        let upper = flat(sub(joint(2).point, joint(1).point));
        let fore = flat(sub(joint(3).point, joint(2).point));
        if norm(upper) < EXACT || norm(fore) < EXACT {
            return Err("two of its three parallel axes are one line".to_owned());
        }
        for (one, two) in [(0, 1), (3, 4)] {
            if arm.tilt(one, two) < 1e-3 {
                return Err(format!("its axes {} and {} are parallel too", one + 1, two + 1));
            }
        }
        let guess = if n[0].abs() < 0.8 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let across = flat(guess);
        let size = norm(across);
        Ok(Self {
            serial,
            untool: arm.tool.inverse(),
            axes: [0, 1, 2, 3, 4, 5].map(|k| joint(k).axis),
            first: joint(0).point,
            meeting,
            upper,
            fore,
            second: joint(1).point,
            fourth: joint(3).point,
            signs: [2, 3].map(|k| dot(n, joint(k).axis).signum()),
            across: across.map(|x| x / size),
            length,
            // Four axes are shifted or turned, and levers are three arm lengths at most.
            misfit: 12.0 * tilt.max(gap),
        })
    }

    /// All postures of goals (m); an angle that nothing decides is taken from `near`.
    pub fn solve(&self, level: Level, goals: &[Rigid<f64>], near: &[[f64; 6]], sets: &mut [Set]) {
        dispatch(level, All { arm: self, goals, near, sets });
    }

    /// No posture comes within a margin of a goal (m), whatever the limits: proven. The equations
    /// of [`Self::solve`] with arcs for angles, which hold those of all postures that do.
    pub fn is_out_of_reach(&self, goal: &Rigid<f64>, margin: Margin) -> bool {
        let mut goal = *goal;
        goal.shift = goal.shift.map(|x| x / self.length);
        let margin = margin.widened(self.length, self.misfit, 3.0 + norm(goal.shift));
        if margin.is_wide() {
            return false;
        }
        let all = goal.after(&self.untool);
        // How far a point of the last link may be from where it is taken to be.
        let off = |x: V3<f64>| margin.at(norm(self.untool.apply(x)));
        let (axis, n) = (self.axes[0], self.axes[1]);
        let p = sub(all.apply(self.meeting), self.first);
        let (nw, wp) = (dot(n, axis), dot(axis, p));
        let (a, b) = (dot(n, p) - nw * wp, -dot(n, cross(axis, p)));
        let c = dot(n, sub(self.meeting, self.first)) - nw * wp;
        let wide = off(self.meeting);
        let Some(firsts) = linear_arcs(a, b, wide, Range::about(c, wide)) else { return true };
        let none = |one: Arc| {
            let back = turn_about(axis, self.first, (-one.middle).sin_cos());
            let rest = back.after(&all);
            let turn = (margin.turn + one.off).min(2.0);
            let (w5, w6) = (self.axes[4], self.axes[5]);
            let (nw, ww) = (dot(n, w5), dot(w5, w6));
            let (a, b) = (dot(n, w6) - nw * ww, dot(n, cross(w5, w6)));
            let c = dot(n, rest.turn(w6)) - nw * ww;
            let Some(fifths) = linear_arcs(a, b, 0.0, Range::about(c, turn)) else { return true };
            fifths.into_iter().all(|five| {
                let to = turned_about(w5, (-five.middle).sin_cos(), n);
                let from = rest.turn_back(n);
                let guess = if w6[0].abs() < 0.8 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
                let u = cross(w6, guess);
                let u = u.map(|x| x / norm(u));
                let v = cross(w6, u);
                let toward = |x: V3<f64>, off: f64| Arc::toward(dot(x, u), dot(x, v), off);
                let six = toward(to, five.chord()).minus(toward(from, turn));
                let arm = sub(self.fourth, self.meeting);
                let at = turned_about(w5, (-five.middle).sin_cos(), arm);
                let at = turned_about(w6, (-six.middle).sin_cos(), at);
                let at = axpy(self.meeting, 1.0, at);
                let far = norm(sub(all.apply(at), self.first));
                let wide = off(at) + far * one.chord() + norm(arm) * (five.chord() + six.chord());
                let d = sub(rest.apply(at), self.second);
                let way = norm(axpy(n, -dot(n, d), d));
                let (u, f) = (self.upper, self.fore);
                let (a, b) = (dot(u, f), dot(u, cross(self.axes[2], f)));
                let (low, high) = ((way - wide).max(0.0), way + wide);
                let fixed = dot(u, u) + dot(f, f);
                let c = Range { low: low * low - fixed, high: high * high - fixed };
                linear_arcs(a, b, 0.0, c.by(0.5)).is_none()
            })
        };
        firsts.into_iter().all(none)
    }

    /// What the first joint leaves to the others, on a side.
    #[inline(always)]
    fn shoulder<R: Real>(&self, goal: &Rigid<R>, near: &Near<R>, side: Side<R>) -> Shoulder<R> {
        let (axis, n) = (splat3::<R>(self.axes[0]), splat3::<R>(self.axes[1]));
        let all = goal.after(&Rigid::splat(&self.untool));
        let (first, meeting) = (splat3::<R>(self.first), splat3::<R>(self.meeting));
        // The meeting point across the parallel axes.
        let p = sub(all.apply(meeting), first);
        let (nw, wp) = (dot(n, axis), dot(axis, p));
        let a = dot(n, p) - nw * wp;
        let b = -dot(n, cross(axis, p));
        let c = dot(n, sub(meeting, first)) - nw * wp;
        let one = linear(a, b, c, OPEN, near[0], side);
        let back = (-one.turn.0, one.turn.1);
        let axes = [
            turned_about(axis, back, all.axes[0]),
            turned_about(axis, back, all.axes[1]),
            turned_about(axis, back, all.axes[2]),
        ];
        let shift = turned_about(axis, back, sub(all.shift, first));
        let shift = [shift[0] + first[0], shift[1] + first[1], shift[2] + first[2]];
        let open = R::bits(a.mul_add(a, b * b).lt(R::splat(OPEN * OPEN)));
        let q1 = atan2(one.turn.0, one.turn.1);
        Shoulder { one, q1, rest: Rigid { axes, shift }, open }
    }

    /// What the fifth and the sixth joint leave to the planar arm, on a side.
    #[inline(always)]
    fn wrist<R: Real>(&self, rest: &Rigid<R>, near: &Near<R>, side: Side<R>) -> Wrist<R> {
        let n = splat3::<R>(self.axes[1]);
        let (axis5, axis6) = (splat3::<R>(self.axes[4]), splat3::<R>(self.axes[5]));
        let meeting = splat3::<R>(self.meeting);
        // The direction of axis 6 along the parallel axes.
        let (nw, ww) = (dot(n, axis5), dot(axis5, axis6));
        let a = dot(n, axis6) - nw * ww;
        let b = dot(n, cross(axis5, axis6));
        let c = dot(n, rest.turn(axis6)) - nw * ww;
        let five = linear(a, b, c, OPEN, near[4], side);
        let back5 = (-five.turn.0, five.turn.1);
        // The direction of the parallel axes about axis 6.
        let (from, to) = (rest.turn_back(n), turned_about(axis5, back5, n));
        let y = dot(axis6, cross(from, to));
        let x = dot(from, to) - dot(axis6, from) * dot(axis6, to);
        // Both directions are as far from the axis as the sine, so this is its square.
        let least = IN_LINE * IN_LINE;
        let open = R::bits((y * y + x * x).lt(R::splat(least * least)));
        let six = unit_turn(y, x, least, near[5]);
        let back6 = (-six.0, six.1);
        // All three parallel joints together, and where they have to put axis 4.
        let across = splat3::<R>(self.across);
        let v = rest.turn(turned_about(axis6, back6, turned_about(axis5, back5, across)));
        let at = sub(splat3(self.fourth), meeting);
        let at = turned_about(axis6, back6, turned_about(axis5, back5, at));
        let at = [at[0] + meeting[0], at[1] + meeting[1], at[2] + meeting[2]];
        let d = sub(rest.apply(at), splat3(self.second));
        let sum = (dot(n, cross(across, v)), dot(across, v));
        let angles = atan2_each([sum.0, five.turn.0, six.0], [sum.1, five.turn.1, six.1]);
        let sum = unit_pair(sum.0, sum.1);
        Wrist { five, six, sum, angles, way: axpy(n, -dot(n, d), d), open }
    }

    /// A posture, by the planar arm's side.
    #[inline(always)]
    fn posture<R: Real>(
        &self,
        shoulder: &Shoulder<R>,
        wrist: &Wrist<R>,
        near: &Near<R>,
        side: Side<R>,
    ) -> (Candidates<R>, [Turn<R>; 6]) {
        let (n, axis) = (splat3::<R>(self.axes[1]), splat3::<R>(self.axes[2]));
        let (u, f, d) = (splat3::<R>(self.upper), splat3::<R>(self.fore), wrist.way);
        let a = dot(u, f);
        let b = dot(u, cross(axis, f));
        let half = R::splat(0.5);
        let c = half * (dot(d, d) - dot(u, u) - dot(f, f));
        let three = linear(a, b, c, OPEN, near[2], side);
        let reach = turned_about(axis, three.turn, f);
        let reach = [reach[0] + u[0], reach[1] + u[1], reach[2] + u[2]];
        let (y, x) = (dot(n, cross(reach, d)), dot(reach, d));
        let two = unit_turn(y, x, OPEN * OPEN, near[1]);
        let (one, five) = (&shoulder.one, &wrist.five);
        let [q2, q3] = atan2_each([two.0, three.turn.0], [two.1, three.turn.1]);
        let (q1, [sum, q5, q6]) = (shoulder.q1, wrist.angles);
        let (s3, s4) = (R::splat(self.signs[0]), R::splat(self.signs[1]));
        let q4 = s4 * (sum - q2 - s3 * q3);
        let rest = minus(minus(wrist.sum, two), (s3 * three.turn.0, three.turn.1));
        let turns = [one.turn, two, three.turn, (s4 * rest.0, rest.1), five.turn, wrist.six];
        let found = Candidates {
            q: [q1, q2, q3, q4, q5, q6],
            merged: one.merged | five.merged | three.merged,
            singular: [one.singular, three.singular, five.singular | wrist.open],
            open: [(shoulder.open, 1), (wrist.open, 1 << 5)],
        };
        (found, turns)
    }

    /// Puts a posture into the sets of its goals, see [`Candidates::settle`]. Sines and cosines
    /// are known here, so that the check computes none.
    #[inline(always)]
    fn settle<R: Real>(
        &self,
        (found, turns): &(Candidates<R>, [Turn<R>; 6]),
        goal: &Rigid<R>,
        lanes: usize,
        sets: &mut [Set],
    ) {
        let left = self.serial.left(turns, goal);
        found.settle(&self.serial, (goal, left), lanes, sets);
    }
}

/// Where a joint goes that nothing decides.
type Near<R> = [Turn<R>; 6];

/// The first joint, and the goal as the others see it.
struct Shoulder<R> {
    one: Root<R>,
    /// Its angle, rad.
    q1: R,
    rest: Rigid<R>,
    /// Lanes in which the joint is free.
    open: Lanes,
}

/// The last two joints, and what is left to the planar arm: a turn, and a way to axis 4.
struct Wrist<R> {
    five: Root<R>,
    six: Turn<R>,
    /// Of the three parallel joints together.
    sum: Turn<R>,
    /// Of the three parallel joints together, of the fifth and of the sixth, rad.
    angles: [R; 3],
    way: V3<R>,
    /// Lanes in which joint 6 is free.
    open: Lanes,
}

struct All<'a> {
    arm: &'a ThreeParallel,
    goals: &'a [Rigid<f64>],
    near: &'a [[f64; 6]],
    sets: &'a mut [Set],
}

impl Kernel for All<'_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        let Self { arm, goals, near, sets } = self;
        // Of a single goal the lanes hold its postures.
        let alone = goals.len() == 1;
        let scale = 1.0 / arm.length;
        let mut first = 0;
        while first < goals.len() {
            let count = if alone { 1 } else { R::WIDTH.min(goals.len() - first) };
            let mut goal = Rigid::<R>::identity();
            let mut near_by = [R::zero(); 6];
            let mut resting = true;
            for lane in 0..R::WIDTH {
                let row = first + if lane < count { lane } else { 0 };
                let mut one = goals[row];
                for x in &mut one.shift {
                    *x *= scale;
                }
                goal.set_lane(lane, &one);
                for k in 0..6 {
                    near_by[k].set_lane(lane, near[row][k]);
                    resting &= near[row][k] == 0.0;
                }
            }
            // Sine and cosine of 0, as they mostly are, need no computing.
            let mut about = [(R::zero(), R::splat(1.0)); 6];
            if !resting {
                for k in 0..6 {
                    about[k] = near_by[k].sin_cos();
                }
            }
            let own = &mut sets[first..first + count];
            if alone {
                let mut way = 0;
                while way < 8 {
                    let shoulder = arm.shoulder(&goal, &about, Side::by_bit(way, 2));
                    let wrist = arm.wrist(&shoulder.rest, &about, Side::by_bit(way, 1));
                    let found = arm.posture(&shoulder, &wrist, &about, Side::by_bit(way, 0));
                    arm.settle(&found, &goal, R::WIDTH.min(8), own);
                    way += R::WIDTH;
                }
            } else {
                for side in Side::both() {
                    let shoulder = arm.shoulder(&goal, &about, side);
                    for side in Side::both() {
                        let wrist = arm.wrist(&shoulder.rest, &about, side);
                        for side in Side::both() {
                            let found = arm.posture(&shoulder, &wrist, &about, side);
                            arm.settle(&found, &goal, count, own);
                        }
                    }
                }
            }
            first += count;
        }
    }
}
