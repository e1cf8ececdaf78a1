//! The first three joints of an arm with a spherical wrist: where they have to stand so
//! that the wrist's centre is at a point (Pieper's reduction).
//!
//! With `w` the wrist's centre seen from the third joint, `v = A2 Rz(t3) w` the centre
//! seen from the second and `p` the centre wanted, seen from the first,
//! `p = Rz(t1) A1 Rz(t2) v`. Its height along the first axis and its distance from that
//! axis hold two equations in `t2` and `t3`. They fall apart into two that hold one angle
//! each where axes 2 and 3 or 1 and 2 are parallel, or where axes 1 and 2 meet; in
//! general they leave one equation of the fourth degree in `tan(t3 / 2)`.

use crate::closed_form::geometry::axes::{Geometry, TOLERANCE};
use crate::closed_form::geometry::quartic;
use crate::closed_form::geometry::turn::Link;
use crate::closed_form::geometry::turn::{
    Root, SINGULAR, Side, Turn, linear, minus, turned, unit_turn,
};
use crate::lanes::{Real, V3, hypotenuse};

/// Which equations come apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Axes 2 and 3 are parallel: upper arm and forearm move in a plane.
    ParallelElbow,
    /// Axes 1 and 2 are parallel.
    ParallelBase,
    /// Axes 1 and 2 meet.
    MeetingBase,
    /// None of these: an equation of the fourth degree.
    General,
}

/// The first three joints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shoulder {
    kind: Kind,
    pub(crate) one: Link,
    pub(crate) two: Link,
    /// Distance of the wrist's centre from the third axis, m.
    pub(crate) radius: f64,
    /// Direction of the wrist's centre about the third axis at `t3 = 0`.
    phase: (f64, f64),
    /// Height of the wrist's centre along the third axis, m.
    pub(crate) height: f64,
    /// Length below which a distance leaves an angle open, m.
    least: f64,
    /// Length below which an arm counts as singular, m.
    near: f64,
}

/// One way to put the wrist's centre where it is wanted.
#[derive(Debug, Clone, Copy)]
pub struct Arm<R> {
    /// Turns of the three joints.
    pub turns: [Turn<R>; 3],
    /// Lanes (one bit each) where this arm is the one before over again, or none.
    pub merged: u32,
    /// Lanes whose wrist centre is near the first axis, or at the rim of its ring.
    pub shoulder: u32,
    /// Lanes whose arm is stretched or folded.
    pub elbow: u32,
}

impl Shoulder {
    /// The first three joints of a geometry whose last three axes meet, or why they
    /// cannot place the wrist's centre.
    pub fn new(geometry: &Geometry) -> Result<Self, String> {
        let [one, two, three, four] = [0, 1, 2, 3].map(|i| geometry.links[i]);
        let (x, y) = (three.a, -three.sine * four.d);
        let radius = hypotenuse(x, y);
        let height = three.d + three.cosine * four.d;
        let tolerance = geometry.tolerance;
        if radius < tolerance {
            return Err("its wrist's centre lies on the third axis, which cannot move it".into());
        }
        let kind = if two.sine == 0.0 && one.sine == 0.0 {
            return Err("its first three axes are parallel".into());
        } else if two.sine == 0.0 {
            Kind::ParallelElbow
        } else if one.sine == 0.0 {
            Kind::ParallelBase
        } else if one.a == 0.0 {
            if two.a == 0.0 && two.d == 0.0 {
                return Err("its first three axes meet in a point".into());
            }
            Kind::MeetingBase
        } else {
            Kind::General
        };
        Ok(Self {
            kind,
            one,
            two,
            radius,
            phase: (y / radius, x / radius),
            height,
            least: 1e-6 * tolerance,
            near: tolerance * SINGULAR / TOLERANCE,
        })
    }

    /// Direction of the wrist's centre about the third axis where the third joint's turn is 0.
    pub(crate) fn phase_angle(&self) -> f64 {
        self.phase.0.atan2(self.phase.1)
    }

    /// Which equations came apart.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// All arms that put the wrist's centre at `p`, seen from the first joint. An angle
    /// that nothing decides is taken from `preferred`.
    #[inline(always)]
    pub fn solve<R: Real>(&self, p: V3<R>, preferred: &[Turn<R>; 3]) -> [Arm<R>; 4] {
        let roots = match self.kind {
            Kind::General => self.third_turns(p, R::WIDTH),
            _ => [Root::none(); 4],
        };
        let [one, two] = Side::both();
        [
            self.arm(p, [one, one], roots[0], preferred),
            self.arm(p, [one, two], roots[1], preferred),
            self.arm(p, [two, one], roots[2], preferred),
            self.arm(p, [two, two], roots[3], preferred),
        ]
    }

    /// The same arms for one `p` that is in every lane: the arm `first + i` in lane `i`, over
    /// again from the fifth.
    #[inline(always)]
    pub fn side_by_side<R: Real>(
        &self,
        p: V3<R>,
        first: usize,
        preferred: &[Turn<R>; 3],
    ) -> Arm<R> {
        let mut root = Root::<R>::none();
        if self.kind == Kind::General {
            let all = self.third_turns(p, 1);
            for lane in 0..R::WIDTH {
                let of = &all[(first + lane) % 4];
                root.turn.0.set_lane(lane, of.turn.0.lane(0));
                root.turn.1.set_lane(lane, of.turn.1.lane(0));
                root.merged |= (of.merged & 1) << lane;
                root.singular |= (of.singular & 1) << lane;
            }
        }
        self.arm(p, [Side::by_bit(first, 1), Side::by_bit(first, 0)], root, preferred)
    }

    /// One arm a lane: of a side for each of two equations, or for a root of the general
    /// one.
    #[inline(always)]
    fn arm<R: Real>(
        &self,
        p: V3<R>,
        sides: [Side<R>; 2],
        root: Root<R>,
        preferred: &[Turn<R>; 3],
    ) -> Arm<R> {
        let mut arm = match self.kind {
            Kind::ParallelElbow => self.parallel_elbow(p, sides, preferred),
            Kind::ParallelBase | Kind::MeetingBase => self.separate(p, sides, preferred),
            Kind::General => self.general(p, root, preferred),
        };
        let phase = (R::splat(self.phase.0), R::splat(self.phase.1));
        arm.turns[2] = minus(arm.turns[2], phase);
        arm
    }

    /// The wrist's centre seen from the second joint, for a turn of the third (counted
    /// from the direction of the wrist's centre).
    #[inline(always)]
    pub(crate) fn seen_from_second<R: Real>(&self, third: Turn<R>) -> V3<R> {
        let Link { d, a, sine, cosine, .. } = self.two;
        let r = R::splat(self.radius);
        let (y, x) = (third.0 * r, third.1 * r);
        [
            x + R::splat(a),
            y.mul_add(R::splat(cosine), R::splat(-sine * self.height)),
            y.mul_add(R::splat(sine), R::splat(d + cosine * self.height)),
        ]
    }

    /// The first joint's turn from the centre after the second joint's, `(x, y)` seen
    /// along the first axis.
    #[inline(always)]
    fn first<R: Real>(&self, p: V3<R>, x: R, y: R, preferred: Turn<R>) -> Turn<R> {
        // In squared metres: both points count.
        let least = self.least * self.least;
        unit_turn(p[1].mul_add(x, -(p[0] * y)), p[0].mul_add(x, p[1] * y), least, preferred)
    }

    #[inline(always)]
    fn parallel_elbow<R: Real>(
        &self,
        p: V3<R>,
        [front, bend]: [Side<R>; 2],
        preferred: &[Turn<R>; 3],
    ) -> Arm<R> {
        let Link { d, a, sine, cosine, .. } = self.one;
        // The centre's way along axes 2 and 3 never changes.
        let along = self.two.d + self.two.cosine * self.height;
        let across = (p[2] - R::splat(d + cosine * along)) * R::splat(1.0 / sine);
        let y1 = across.mul_add(R::splat(cosine), R::splat(-sine * along));
        let ring = p[0].mul_add(p[0], p[1] * p[1]);
        let x1 = (ring - y1 * y1).max(R::zero()).sqrt();
        let rim = R::bits(x1.lt(R::splat(self.least)));
        let shoulder = R::bits(x1.lt(R::splat(self.near)));
        let (upper, fore) = (self.two.a, self.radius);
        let scale = R::splat(0.5 / (upper * fore));
        let x1 = x1 * front.sign;
        let first = self.first(p, x1, y1, preferred[0]);
        let x = x1 - R::splat(a);
        let span = x.mul_add(x, across * across);
        let cosine = (span - R::splat(upper * upper + fore * fore)) * scale;
        let elbow = linear(R::splat(1.0), R::zero(), cosine, 0.0, preferred[2], bend);
        let third = elbow.turn;
        let (vy, vx) = (
            third.0 * R::splat(self.two.cosine) * R::splat(fore),
            third.1.mul_add(R::splat(fore), R::splat(upper)),
        );
        let second = unit_turn(
            across.mul_add(vx, -(x * vy)),
            x.mul_add(vx, across * vy),
            self.least * self.least,
            preferred[1],
        );
        Arm {
            turns: [first, second, third],
            merged: rim & front.second | elbow.merged,
            shoulder,
            elbow: elbow.singular,
        }
    }

    /// Parallel or meeting first axes: an equation for the third angle, then one for the
    /// second.
    #[inline(always)]
    fn separate<R: Real>(
        &self,
        p: V3<R>,
        [bend, lean]: [Side<R>; 2],
        preferred: &[Turn<R>; 3],
    ) -> Arm<R> {
        let (one, two) = (self.one, self.two);
        let up = p[2] - R::splat(one.d);
        let ring = p[0].mul_add(p[0], p[1] * p[1]);
        let r = self.radius;
        let third = if self.kind == Kind::ParallelBase {
            // up = +-v_z
            let c = up * R::splat(one.cosine) - R::splat(two.d + two.cosine * self.height);
            linear(R::zero(), R::splat(two.sine * r), c, 0.0, preferred[2], bend)
        } else {
            // |p|^2 = |v|^2
            let fixed = two.a * two.a
                + two.d * two.d
                + r * r
                + self.height * self.height
                + 2.0 * two.d * two.cosine * self.height;
            let c = up.mul_add(up, ring) - R::splat(fixed);
            let (a, b) = (2.0 * two.a * r, 2.0 * two.d * two.sine * r);
            linear(R::splat(a), R::splat(b), c, 0.0, preferred[2], bend)
        };
        let v = self.seen_from_second(third.turn);
        let second = if self.kind == Kind::ParallelBase {
            // ring = a^2 + vx^2 + vy^2 + 2 a (vx cos t2 - vy sin t2)
            let c = ring - R::splat(one.a * one.a) - v[0].mul_add(v[0], v[1] * v[1]);
            let c = c * R::splat(0.5 / one.a);
            linear(v[0], -v[1], c, self.least, preferred[1], lean)
        } else {
            // up = sine (vx sin t2 + vy cos t2) + cosine vz
            let c = (up - v[2] * R::splat(one.cosine)) * R::splat(1.0 / one.sine);
            linear(v[1], v[0], c, self.least, preferred[1], lean)
        };
        let first = self.first_after(p, v, second.turn, preferred[0]);
        let near = R::bits(ring.lt(R::splat(self.near * self.near)));
        Arm {
            turns: [first, second.turn, third.turn],
            merged: third.merged | second.merged,
            shoulder: second.singular | near,
            elbow: third.singular,
        }
    }

    #[inline(always)]
    fn first_after<R: Real>(
        &self,
        p: V3<R>,
        v: V3<R>,
        second: Turn<R>,
        preferred: Turn<R>,
    ) -> Turn<R> {
        let [x, y] = turned([v[0], v[1]], second);
        let (s, c) = (R::splat(self.one.sine), R::splat(self.one.cosine));
        let y = y.mul_add(c, -(v[2] * s));
        self.first(p, x + R::splat(self.one.a), y, preferred)
    }

    /// Solutions of the equation of the fourth degree in the first lanes, one after the
    /// other: arms of this kind are rare.
    #[inline(always)]
    fn third_turns<R: Real>(&self, p: V3<R>, lanes: usize) -> [Root<R>; 4] {
        let up = p[2] - R::splat(self.one.d);
        let ring = p[0].mul_add(p[0], p[1] * p[1]);
        let mut out = [Root::<R>::none(); 4];
        for lane in 0..lanes {
            let roots = self.third_roots(up.lane(lane), ring.lane(lane));
            for (one, root) in out.iter_mut().zip(roots) {
                one.turn.0.set_lane(lane, root.turn.0);
                one.turn.1.set_lane(lane, root.turn.1);
                one.merged |= u32::from(root.merged) << lane;
                one.singular |= u32::from(root.singular) << lane;
            }
        }
        out
    }

    /// The arm for a solution of that equation.
    #[inline(always)]
    fn general<R: Real>(&self, p: V3<R>, root: Root<R>, preferred: &[Turn<R>; 3]) -> Arm<R> {
        let one = self.one;
        let up = p[2] - R::splat(one.d);
        let ring = p[0].mul_add(p[0], p[1] * p[1]);
        let v = self.seen_from_second(root.turn);
        // x and y of the centre after the second joint's turn.
        let square = v[0].mul_add(v[0], v[1].mul_add(v[1], v[2] * v[2]));
        let x = (up.mul_add(up, ring) - square - R::splat(one.a * one.a)) * R::splat(0.5 / one.a);
        let y = (up - v[2] * R::splat(one.cosine)) * R::splat(1.0 / one.sine);
        let second = unit_turn(
            y.mul_add(v[0], -(x * v[1])),
            x.mul_add(v[0], y * v[1]),
            self.least * self.least,
            preferred[1],
        );
        let first = self.first_after(p, v, second, preferred[0]);
        Arm {
            turns: [first, second, root.turn],
            merged: root.merged,
            shoulder: R::bits(ring.lt(R::splat(self.near * self.near))),
            elbow: root.singular,
        }
    }

    /// Roots of the equation for the third angle.
    #[inline(never)]
    fn third_roots(&self, up: f64, ring: f64) -> [quartic::Root; 4] {
        quartic::roots(&self.third_form(up, ring))
    }

    /// The equation for the third angle as a quadratic form in `(1, cos, sin)`.
    pub(crate) fn third_form(&self, up: f64, ring: f64) -> [[f64; 3]; 3] {
        let (one, two) = (self.one, self.two);
        let (r, w) = (self.radius, self.height);
        // Constant, cosine and sine parts of v and of |v|^2.
        let vx = [two.a, r, 0.0];
        let vy = [-two.sine * w, 0.0, two.cosine * r];
        let vz = [two.d + two.cosine * w, 0.0, two.sine * r];
        let fixed = two.a * two.a + two.d * two.d + r * r + w * w + 2.0 * two.d * two.cosine * w;
        let square = [fixed, 2.0 * two.a * r, 2.0 * two.d * two.sine * r];
        let known = up * up + ring - one.a * one.a;
        let k = 0.5 / one.a;
        let x = [(known - square[0]) * k, -square[1] * k, -square[2] * k];
        let m = 1.0 / one.sine;
        let y = [(up - one.cosine * vz[0]) * m, -one.cosine * vz[1] * m, -one.cosine * vz[2] * m];
        // x^2 + y^2 - vx^2 - vy^2 = 0 as a form in (1, cos, sin).
        let mut form = [[0.0; 3]; 3];
        for (v, sign) in [(x, 1.0), (y, 1.0), (vx, -1.0), (vy, -1.0)] {
            for i in 0..3 {
                for j in 0..3 {
                    form[i][j] += sign * v[i] * v[j];
                }
            }
        }
        form
    }
}
