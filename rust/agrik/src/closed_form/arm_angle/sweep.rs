//! Three joints whose axes meet, as functions of the arm angle, in lanes.
//!
//! What the three bring about is `M = Rot(w, psi) M0`: each entry is
//! `C + A cos(psi) + B sin(psi)`, and all three turns follow from the third column and the
//! third row. `M` turns with unit rate about `w = t1' z + t2' n + t3' m` (`z`, `n` and `m`
//! the three axes), which gives the rates, and its derivative the second ones.

use std::f64::consts::{PI, TAU};

use crate::closed_form::branch::choice::Choice;
use crate::closed_form::families::srs::{Elbow, Line, Srs};
use crate::closed_form::geometry::limit::{Limit, SLACK};
use crate::closed_form::geometry::turn::{Meeting, Turn, advance, components, identity};
use crate::lanes::{Real, V3, atan2_each, atan2_rough, axpy, cross, dot, negate, scale};

/// The entries of `M` in use: third column, and the first two of the third row.
type Entries<R> = [R; 5];
const IN_USE: [(usize, usize); 5] = [(0, 2), (1, 2), (2, 2), (2, 0), (2, 1)];
const IN_USE_TRANSPOSED: [(usize, usize); 5] = [(2, 0), (2, 1), (2, 2), (0, 2), (1, 2)];

/// A joint's limits, and how its distance from a centre counts. Values are counted from the
/// middle of the limits here.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Weight<R> {
    /// Turn at the middle of the limits.
    middle: R,
    /// Half the range.
    half: R,
    centre: R,
    factor: R,
    /// Less than a turn from limit to limit.
    narrow: bool,
}

impl<R: Real> Weight<R> {
    #[inline(always)]
    pub fn of(choice: Choice, limit: &Limit, offset: f64, centre: R) -> Self {
        Self {
            middle: R::splat(offset + limit.middle),
            half: R::splat(limit.half),
            centre: centre - R::splat(limit.middle),
            factor: R::splat(if choice == Choice::Nearest { 1.0 } else { limit.shares() }),
            narrow: limit.half <= PI,
        }
    }

    /// The value of a turn: of those a whole turn apart the one nearest to the centre that is
    /// inside the limits, if any is.
    #[inline(always)]
    fn value(&self, turn: R) -> R {
        let x = turn - self.middle;
        if self.narrow {
            // Only one of them can be inside: that nearest to the middle.
            return whole_turns_off(x);
        }
        let tau = R::splat(TAU);
        let x = whole_turns_off(x - self.centre) + self.centre;
        let x = R::select(self.half.lt(x), x - tau, x);
        R::select(x.lt(-self.half), x + tau, x)
    }

    /// How far a value is past a limit, negative inside.
    #[inline(always)]
    fn past(&self, x: R) -> R {
        x.abs() - self.half
    }

    #[inline(always)]
    fn cost(&self, x: R, margin: bool) -> R {
        let off = (x - self.centre) * self.factor;
        if margin { off.abs() } else { off * off }
    }
}

/// An angle in half a turn to either side.
#[inline(always)]
fn whole_turns_off<R: Real>(angle: R) -> R {
    (angle * R::splat(1.0 / TAU)).round().neg_mul_add(R::splat(TAU), angle)
}

/// The cost of several joints from that of one and another.
#[inline(always)]
pub(crate) fn joined<R: Real>(a: R, b: R, margin: bool) -> R {
    if margin { a.max(b) } else { a + b }
}

/// A cost, infinite where joints are past a limit.
#[inline(always)]
fn allowed<R: Real>(cost: R, past: R, slack: f64) -> R {
    R::select(past.le(R::splat(slack)), cost, R::splat(f64::INFINITY))
}

/// The cost of a joint at a value; infinite outside its limits.
#[inline(always)]
pub(crate) fn cost_of_one<R: Real>(weight: &Weight<R>, q: R, margin: bool) -> R {
    let x = weight.value(q);
    allowed(weight.cost(x, margin), weight.past(x), SLACK)
}

/// Three joints along the arm angle.
pub(crate) struct Sweep<'a, R> {
    meeting: &'a Meeting,
    weights: [Weight<R>; 3],
    parts: [Entries<R>; 3],
    /// What `M` turns about.
    about: V3<R>,
}

/// Values of three joints within their limits, and their rates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moving<R> {
    pub weights: [Weight<R>; 3],
    value: [R; 3],
    rate: [R; 3],
    /// Half the second derivative.
    bend: [R; 3],
}

impl<'a, R: Real> Sweep<'a, R> {
    /// The first three joints and the last three where the fourth stands as `elbow`.
    #[inline(always)]
    pub fn both(
        arm: &'a Srs,
        line: &Line<R>,
        elbow: &Elbow<R>,
        weights: &[[Weight<R>; 3]; 2],
    ) -> [Self; 2] {
        let (one, two) = arm.meetings();
        let links = &arm.geometry().links;
        let none = (R::zero(), R::splat(1.0));
        let start = identity::<R>();
        // From the third link's frame to what the last three joints start from.
        let after = advance(advance(start, none, &links[2]), elbow.turn, &links[3]);
        let [f0, f1, f2] = elbow.frame;
        let seen = [components(after, f0), components(after, f1), components(after, f2)];
        let [w0, w1, w2] = line.frame;
        let wanted =
            [components(line.wanted, w0), components(line.wanted, w1), components(line.wanted, w2)];
        [
            Self {
                meeting: one,
                weights: weights[0],
                parts: parts(line.frame, elbow.frame, IN_USE),
                about: line.frame[0],
            },
            Self {
                meeting: two,
                weights: weights[1],
                // `seen` times the transpose of `wanted`: the same the other way round.
                parts: parts(wanted, seen, IN_USE_TRANSPOSED),
                about: negate(seen[0]),
            },
        ]
    }

    #[inline(always)]
    fn at(&self, angle: Turn<R>) -> Entries<R> {
        let (s, c) = angle;
        let [k, a, b] = &self.parts;
        let mut out = *k;
        for i in 0..5 {
            out[i] = b[i].mul_add(s, a[i].mul_add(c, out[i]));
        }
        out
    }

    /// Sines and cosines of the three turns, of the side of a sign; the first and the third
    /// times a positive number.
    #[inline(always)]
    fn turns(&self, m: &Entries<R>, sign: R) -> ([R; 3], [R; 3]) {
        let (s1, c1) = (self.meeting.one.sine, self.meeting.one.cosine);
        let (s2, c2) = (self.meeting.two.sine, self.meeting.two.cosine);
        let one = R::splat(1.0);
        let cosine = (R::splat(c1 * c2) - m[2]) * R::splat(1.0 / (s1 * s2));
        let cosine = cosine.min(one).max(-one);
        let sine = ((one - cosine) * (one + cosine)).sqrt() * sign * R::splat(s2.signum());
        // Third column before the first turn, third row before the third.
        let (ux, uy) =
            (sine * R::splat(s2), cosine.mul_add(R::splat(-c1 * s2), R::splat(-s1 * c2)));
        let (vx, vy) = (sine * R::splat(s1), cosine.mul_add(R::splat(c2 * s1), R::splat(s2 * c1)));
        (
            [m[1].mul_add(ux, -(m[0] * uy)), sine, m[3].mul_add(vy, -(m[4] * vx))],
            [m[0].mul_add(ux, m[1] * uy), cosine, m[3].mul_add(vx, m[4] * vy)],
        )
    }

    /// The lesser cost of the two sides at an arm angle, and the side's sign; a look, with
    /// turns to 1e-5 rad.
    #[inline(always)]
    pub fn glance(&self, angle: Turn<R>, margin: bool) -> (R, R) {
        let m = self.at(angle);
        let (one, two) = (R::splat(1.0), R::splat(-1.0));
        let (y, x) = self.turns(&m, one);
        let turns = atan2_rough(y, x);
        let first = self.cost(turns, margin);
        let right = self.meeting.one.cosine.abs().max(self.meeting.two.cosine.abs()) < 1e-9;
        let others = if right {
            // Half a turn of the outer axes and the inner one mirrored.
            let half = R::splat(PI);
            [turns[0] + half, -turns[1], turns[2] + half]
        } else {
            let (y, x) = self.turns(&m, two);
            atan2_rough(y, x)
        };
        let second = self.cost(others, margin);
        let better = second.lt(first);
        (R::select(better, second, first), R::select(better, two, one))
    }

    #[inline(always)]
    fn cost(&self, turns: [R; 3], margin: bool) -> R {
        let mut cost = R::zero();
        let mut past = R::splat(-1.0);
        for (weight, turn) in self.weights.iter().zip(turns) {
            let x = weight.value(turn);
            past = past.max(weight.past(x));
            cost = joined(cost, weight.cost(x, margin), margin);
        }
        allowed(cost, past, 0.0)
    }

    /// Values and rates at an arm angle, on the side of a sign.
    #[inline(always)]
    pub fn moving(&self, angle: Turn<R>, sign: R) -> Moving<R> {
        let m = self.at(angle);
        let (y, x) = self.turns(&m, sign);
        let turns = atan2_each(y, x);
        let mut value = turns;
        for i in 0..3 {
            value[i] = self.weights[i].value(turns[i]);
        }
        let length2 = y[0].mul_add(y[0], x[0] * x[0]).max(R::splat(f64::MIN_POSITIVE));
        let unit = R::splat(1.0) / length2.sqrt();
        let (s1, c1) = (R::splat(self.meeting.one.sine), R::splat(self.meeting.one.cosine));
        let n = [s1 * y[0] * unit, -(s1 * x[0] * unit), c1];
        let z = [R::zero(), R::zero(), R::splat(1.0)];
        let third = [m[0], m[1], m[2]];
        let duals = [cross(n, third), cross(third, z), cross(z, n)];
        let volume = duals[0][2];
        // In line, nothing bounds the rates: they are large, and not of much use.
        let least = R::splat(1e-9);
        let volume = R::select(volume.abs().lt(least), least, volume);
        let inverse = R::splat(1.0) / volume;
        let w = self.about;
        let mut rate = [R::zero(); 3];
        for i in 0..3 {
            rate[i] = dot(w, duals[i]) * inverse;
        }
        let force = axpy(cross(z, n), rate[1] * rate[0], scale(cross(w, third), rate[2]));
        let half = inverse * R::splat(-0.5);
        let mut bend = [R::zero(); 3];
        for i in 0..3 {
            bend[i] = dot(force, duals[i]) * half;
        }
        Moving { weights: self.weights, value, rate, bend }
    }
}

impl<R: Real> Moving<R> {
    /// Cost a little way on, and how far joints are past their limits there, less `room`;
    /// by the first two derivatives.
    #[inline(always)]
    pub fn ahead(&self, way: R, room: R, margin: bool) -> (R, R) {
        let (mut cost, mut past) = (R::zero(), R::splat(-1.0));
        for i in 0..3 {
            let weight = &self.weights[i];
            let x = way.mul_add(way.mul_add(self.bend[i], self.rate[i]), self.value[i]);
            past = past.max(weight.past(x) + room);
            cost = joined(cost, weight.cost(x, margin), margin);
        }
        (cost, past)
    }
}

/// Entries (row, column) of `to[0] f0' + (to[1] cos + to[2] sin) f1' + (to[2] cos - to[1] sin)
/// f2'`, of which `from` holds the `f`.
#[inline(always)]
fn parts<R: Real>(
    to: [V3<R>; 3],
    from: [V3<R>; 3],
    entries: [(usize, usize); 5],
) -> [Entries<R>; 3] {
    let mut out = [[R::zero(); 5]; 3];
    for (n, (i, k)) in entries.into_iter().enumerate() {
        out[0][n] = to[0][i] * from[0][k];
        out[1][n] = to[1][i].mul_add(from[1][k], to[2][i] * from[2][k]);
        out[2][n] = to[2][i].mul_add(from[1][k], -(to[1][i] * from[2][k]));
    }
    out
}
