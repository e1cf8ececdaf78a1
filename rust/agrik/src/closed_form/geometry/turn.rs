//! Angles as sine and cosine: what the closed forms compute with until the very end.

use crate::lanes::{Real, V3, blend, dot, scale};

/// Sine and cosine of an angle.
pub type Turn<R> = (R, R);

/// Below this sine two branches of an equation are one, and the second is dropped.
const MERGED: f64 = 1e-9;
/// Below this sine nothing decides the turn of the first of three joints.
const OPEN: f64 = 1e-12;
/// Below this sine a solution is reported as singular.
pub const SINGULAR: f64 = 1e-6;

/// The constant way from one axis to the next: along the axis, then along the common
/// normal, then about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Link {
    /// Angle of the common normal at joint value 0, rad; from the one before.
    pub theta: f64,
    /// Way along the axis to the common normal, m.
    pub d: f64,
    /// Length of the common normal, m.
    pub a: f64,
    /// Sine of the angle to the next axis.
    pub sine: f64,
    /// Cosine of the angle to the next axis.
    pub cosine: f64,
}

/// Which of the two solutions of an equation each lane takes.
#[derive(Debug, Clone, Copy)]
pub struct Side<R> {
    /// 1 for the first, -1 for the second.
    pub sign: R,
    /// Lanes that take the second.
    pub second: u32,
}

impl<R: Real> Side<R> {
    /// The first in every lane.
    #[inline(always)]
    pub fn first() -> Self {
        Self { sign: R::splat(1.0), second: 0 }
    }

    /// The second in every lane.
    #[inline(always)]
    pub fn second() -> Self {
        Self { sign: R::splat(-1.0), second: u32::MAX }
    }

    /// Both, one after the other.
    #[inline(always)]
    pub fn both() -> [Self; 2] {
        [Self::first(), Self::second()]
    }

    /// The side of a sign, 1 or -1.
    #[inline(always)]
    pub fn of(sign: R) -> Self {
        Self { sign, second: R::bits(sign.lt(R::zero())) }
    }

    /// The second in the lanes `i` for which bit `bit` of `first + i` is set: lanes count
    /// through the ways to take several sides.
    #[inline(always)]
    pub fn by_bit(first: usize, bit: usize) -> Self {
        let mut side = Self::first();
        for lane in 0..R::WIDTH {
            if (first + lane) >> bit & 1 != 0 {
                side.sign.set_lane(lane, -1.0);
                side.second |= 1 << lane;
            }
        }
        side
    }
}

/// One solution of an equation in one angle, and how near it is to the other.
#[derive(Debug, Clone, Copy)]
pub struct Root<R> {
    /// The angle.
    pub turn: Turn<R>,
    /// Lanes where this is the second of two that are the same: one bit each.
    pub merged: u32,
    /// Lanes where they nearly are.
    pub singular: u32,
}

impl<R: Real> Root<R> {
    /// Angle 0, apart from any other.
    #[inline(always)]
    pub fn none() -> Self {
        Self { turn: (R::zero(), R::splat(1.0)), merged: 0, singular: 0 }
    }
}

/// Unit length for `(y, x)`; `fallback` where its length is below `least`.
#[inline(always)]
pub fn unit_turn<R: Real>(y: R, x: R, least: f64, fallback: Turn<R>) -> Turn<R> {
    let square = y.mul_add(y, x * x);
    let inverse = R::splat(1.0) / square.max(R::splat(f64::MIN_POSITIVE)).sqrt();
    let lost = square.lt(R::splat(least * least));
    (R::select(lost, fallback.0, y * inverse), R::select(lost, fallback.1, x * inverse))
}

/// `(sine, cosine)` in the direction of a pair.
#[inline(always)]
pub fn unit_pair<R: Real>(y: R, x: R) -> (R, R) {
    let square = y.mul_add(y, x * x).max(R::splat(f64::MIN_POSITIVE));
    let inverse = R::splat(1.0) / square.sqrt();
    (y * inverse, x * inverse)
}

/// The angle `turn - by`.
#[inline(always)]
pub fn minus<R: Real>(turn: Turn<R>, by: Turn<R>) -> Turn<R> {
    (turn.0.mul_add(by.1, -(turn.1 * by.0)), turn.1.mul_add(by.1, turn.0 * by.0))
}

/// An angle with `a cos + b sin = c`, of the two the one of a side; where `c` is out of
/// range, the angle that comes nearest. Where `a` and `b` vanish, any angle does: `fallback`.
#[inline(always)]
pub fn linear<R: Real>(a: R, b: R, c: R, least: f64, fallback: Turn<R>, side: Side<R>) -> Root<R> {
    let square = a.mul_add(a, b * b);
    let length = square.sqrt();
    let lost = length.lt(R::splat(least));
    let inverse = R::splat(1.0) / length.max(R::splat(f64::MIN_POSITIVE));
    let (a, b, c) = (a * inverse, b * inverse, c * inverse);
    let one = R::splat(1.0);
    let c = c.min(one).max(-one);
    // (1 - c)(1 + c) keeps the digits that 1 - c^2 loses.
    let h = ((one - c) * (one + c)).max(R::zero()).sqrt();
    let away = h * side.sign;
    Root {
        turn: unless(lost, fallback, (b.mul_add(c, a * away), a.mul_add(c, -(b * away)))),
        merged: R::bits(R::or(lost, h.lt(R::splat(MERGED)))) & side.second,
        singular: R::bits(R::or(lost, h.lt(R::splat(SINGULAR)))),
    }
}

/// `turn`, but `fallback` where `lost`.
#[inline(always)]
fn unless<R: Real>(lost: R::Mask, fallback: Turn<R>, turn: Turn<R>) -> Turn<R> {
    (R::select(lost, fallback.0, turn.0), R::select(lost, fallback.1, turn.1))
}

/// A frame (columns) turned about its z axis, then about its new x axis onto the next
/// joint's axis. Shifts are left to the caller.
#[inline(always)]
pub fn advance<R: Real>(frame: [V3<R>; 3], turn: Turn<R>, link: &Link) -> [V3<R>; 3] {
    let [x, y, z] = frame;
    let (s, c) = turn;
    let (x, y) = (blend(x, c, y, s), blend(y, c, x, -s));
    let (s, c) = (R::splat(link.sine), R::splat(link.cosine));
    [x, blend(y, c, z, s), blend(z, c, y, -s)]
}

/// Unit frame.
#[inline(always)]
pub fn identity<R: Real>() -> [V3<R>; 3] {
    let (o, i) = (R::zero(), R::splat(1.0));
    [[i, o, o], [o, i, o], [o, o, i]]
}

/// Components of `v` along the columns of a frame.
#[inline(always)]
pub fn components<R: Real>(frame: [V3<R>; 3], v: V3<R>) -> V3<R> {
    [dot(frame[0], v), dot(frame[1], v), dot(frame[2], v)]
}

/// Turns of three joints whose axes meet in a point: the link from the first to the
/// second, and from the second to the third.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Meeting {
    /// First to second axis.
    pub one: Link,
    /// Second to third axis.
    pub two: Link,
}

/// One way to turn three joints.
pub type Triple<R> = [Turn<R>; 3];

/// One way to turn three joints, and how near it is to the other.
#[derive(Debug, Clone, Copy)]
pub struct Turned<R> {
    /// The turns.
    pub turns: Triple<R>,
    /// Lanes where this is the second of two ways that are the same: one bit each.
    pub merged: u32,
    /// Lanes where first and third axis are all but in line.
    pub singular: u32,
}

impl Meeting {
    /// The turns with `Rz(t1) Rx(alpha1) Rz(t2) Rx(alpha2) Rz(t3) = M`, of which the columns
    /// `mx` and `mz` are given; of the two ways that of a side. Where the first and the
    /// third axis are in line the first joint takes `preferred`.
    #[inline(always)]
    pub fn solve<R: Real>(
        &self,
        mx: V3<R>,
        mz: V3<R>,
        preferred: Turn<R>,
        side: Side<R>,
    ) -> Turned<R> {
        let (s1, c1) = (self.one.sine, self.one.cosine);
        let (s2, c2) = (self.two.sine, self.two.cosine);
        let k = R::splat(1.0 / (s1 * s2));
        // m33 = c1 c2 - s1 s2 cos t2.
        let cosine = (R::splat(c1 * c2) - mz[2]) * k;
        // Rx(alpha1) Rz(t2) Rx(alpha2) z = (s2 sin t2, uy, m33) has mz's distance from z.
        let uy = cosine.mul_add(R::splat(-c1 * s2), R::splat(-s1 * c2));
        let off = mz[0].mul_add(mz[0], mz[1] * mz[1]);
        let ux = (off - uy * uy).max(R::zero()).sqrt();
        let sine = ux * R::splat(1.0 / s2);
        let second = unit_turn(sine, cosine, 1e-300, (R::zero(), R::splat(1.0)));
        let merged = R::bits(second.0.lt(R::splat(MERGED))) & side.second;
        let singular = R::bits(second.0.lt(R::splat(SINGULAR)));
        let second = (second.0 * side.sign, second.1);
        let turns = self.with_second(mx, mz, second, ux * side.sign, uy, preferred);
        Turned { turns, merged, singular }
    }

    /// The first and the third turn for a second one; `ux`, `uy` as in [`Self::solve`].
    #[inline(always)]
    fn with_second<R: Real>(
        &self,
        mx: V3<R>,
        mz: V3<R>,
        second: Turn<R>,
        ux: R,
        uy: R,
        preferred: Turn<R>,
    ) -> Triple<R> {
        // Both (ux, uy) and mz are as long as the sine of the second angle where that is
        // small, so the length here is its square.
        let first = unit_turn(
            mz[1].mul_add(ux, -(mz[0] * uy)),
            mz[0].mul_add(ux, mz[1] * uy),
            OPEN * OPEN,
            preferred,
        );
        // The third from the first two, so that their errors cancel near the singularity:
        // x and y columns of Rz(t1) Rx(alpha1) Rz(t2) Rx(alpha2).
        let (s, c) = first;
        let (sine, cosine) = second;
        let toward = mx[1].mul_add(s, mx[0] * c);
        let aside = mx[1].mul_add(c, -(mx[0] * s));
        let (sa, ca) = (R::splat(self.one.sine), R::splat(self.one.cosine));
        let lifted = aside.mul_add(ca, mx[2] * sa);
        let height = mx[2].mul_add(ca, -(aside * sa));
        let along = toward.mul_add(cosine, lifted * sine);
        let across = lifted.mul_add(cosine, -(toward * sine));
        let (s2, c2) = (R::splat(self.two.sine), R::splat(self.two.cosine));
        let across = across.mul_add(c2, height * s2);
        [first, second, (across, along)]
    }
}

/// `v` turned about z.
#[inline(always)]
pub fn turned<R: Real>(v: [R; 2], turn: Turn<R>) -> [R; 2] {
    let (s, c) = turn;
    [v[0].mul_add(c, -(v[1] * s)), v[0].mul_add(s, v[1] * c)]
}

/// Unit vector along `v`, and its length.
#[inline(always)]
pub fn direction<R: Real>(v: V3<R>) -> (V3<R>, R) {
    let length = dot(v, v).sqrt();
    let inverse = R::splat(1.0) / length.max(R::splat(f64::MIN_POSITIVE));
    (scale(v, inverse), length)
}
