//! Seven revolute joints of which the first three axes meet in a point, the shoulder, and
//! the last three in another, the wrist: spherical - revolute - spherical.
//!
//! The distance from shoulder to wrist fixes the fourth joint, two ways. What is left free
//! is a turn of the elbow about the line from shoulder to wrist: the arm angle. It is zero
//! where the elbow leans towards the first axis, and grows by the right hand about the
//! direction to the wrist. With it the orientations of upper arm and forearm are known,
//! and each spherical joint has two ways to take them on.

use super::Family;
use super::spherical_wrist::wrist_center;
use crate::closed_form::geometry::axes::Geometry;
use crate::closed_form::geometry::candidate::{Candidate, MOST_BRANCHES, value, values};
use crate::closed_form::geometry::turn::{
    Link, Meeting, Root, Side, Turn, Turned, advance, components, direction, identity, linear,
    minus,
};
use crate::lanes::{Real, V3, axpy, blend, cross, dot, hypotenuse, scale, select3, splat3, sub};
use crate::task::Goal;

/// A recognised arm.
#[derive(Debug, Clone, PartialEq)]
pub struct Srs {
    geometry: Geometry,
    shoulder: Meeting,
    wrist: Meeting,
    /// Distance of the wrist from the fourth axis, m.
    radius: f64,
    /// Direction of the wrist about the fourth axis at `t4 = 0`.
    phase: f64,
    /// Height of the wrist along the fourth axis, m.
    height: f64,
}

/// The elbow of a lane group: one of the two ways to bend it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Elbow<R> {
    /// Turn of the fourth joint.
    pub turn: Turn<R>,
    /// Its value, rad.
    pub fourth: R,
    /// Frame of the third link's directions: to the wrist, to the elbow at right angles to
    /// it, and the product of both; seen from the third joint.
    pub frame: [V3<R>; 3],
    pub merged: u32,
    pub singular: u32,
}

impl<R: Real> Elbow<R> {
    /// This one where the mask holds, else another.
    #[inline(always)]
    pub fn or(&self, mask: R::Mask, other: &Self) -> Self {
        let lanes = R::bits(mask);
        let pick = |a: u32, b: u32| (a & lanes) | (b & !lanes);
        let (f, g) = (&self.frame, &other.frame);
        Self {
            turn: (
                R::select(mask, self.turn.0, other.turn.0),
                R::select(mask, self.turn.1, other.turn.1),
            ),
            fourth: R::select(mask, self.fourth, other.fourth),
            frame: [
                select3::<R>(mask, f[0], g[0]),
                select3::<R>(mask, f[1], g[1]),
                select3::<R>(mask, f[2], g[2]),
            ],
            merged: pick(self.merged, other.merged),
            singular: pick(self.singular, other.singular),
        }
    }
}

/// What does not depend on the arm angle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reached<R> {
    pub elbows: [Elbow<R>; 2],
    pub line: Line<R>,
}

/// What does not depend on the elbow either.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line<R> {
    /// Distance from shoulder to wrist, m.
    pub length: R,
    /// Directions seen from the base: to the wrist, that of the elbow at arm angle zero,
    /// and the product of both.
    pub frame: [V3<R>; 3],
    /// The wanted axes of the last joint's frame, seen from the base.
    pub wanted: [V3<R>; 3],
}

/// Three joints whose axes meet.
#[derive(Debug, Clone, Copy)]
struct Three<R> {
    q: [R; 3],
    merged: u32,
    singular: u32,
}

/// Two ways to turn the shoulder, the elbow and the wrist each.
impl Family for Srs {
    const BRANCHES: usize = 8;
}

impl Srs {
    /// The arm of a geometry of seven axes, or why it is none.
    pub fn new(geometry: Geometry) -> Result<Self, String> {
        for (first, name) in [(0, "first"), (4, "last")] {
            let gap = geometry.gap(first);
            if gap > 0.0 {
                return Err(if gap.is_finite() {
                    format!("its {name} three axes miss a common point by {:.3} mm", 1e3 * gap)
                } else {
                    format!("two of its {name} three axes are parallel")
                });
            }
        }
        let [three, four, five] = [2, 3, 4].map(|i| geometry.links[i]);
        let (x, y) = (four.a, -four.sine * five.d);
        let radius = hypotenuse(x, y);
        let to_axis = hypotenuse(three.a, three.sine * three.d);
        if radius < geometry.tolerance || to_axis < geometry.tolerance {
            return Err("its fourth axis goes through shoulder or wrist".to_owned());
        }
        Ok(Self {
            shoulder: Meeting { one: geometry.links[0], two: geometry.links[1] },
            wrist: Meeting { one: geometry.links[4], two: geometry.links[5] },
            radius,
            phase: y.atan2(x),
            height: four.d + four.cosine * five.d,
            geometry,
        })
    }

    /// The axes.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// The parts of the solution that hold for every arm angle.
    #[inline(always)]
    pub(crate) fn reach<R: Real>(
        &self,
        goal: &Goal<R>,
        tool: [f64; 3],
        preferred: &[Turn<R>],
    ) -> Reached<R> {
        let line = self.line(goal, tool);
        let [one, two] = Side::both();
        let elbows = [self.bent(&line, preferred[3], one), self.bent(&line, preferred[3], two)];
        Reached { elbows, line }
    }

    /// The line from shoulder to wrist.
    #[inline(always)]
    fn line<R: Real>(&self, goal: &Goal<R>, tool: [f64; 3]) -> Line<R> {
        let g = &self.geometry;
        let base = [splat3::<R>(g.axes[0]), splat3(g.axes[1]), splat3(g.axes[2])];
        let center = sub(wrist_center(g, goal, tool), splat3(g.origin));
        let mut p = components(base, center);
        p[2] -= R::splat(g.links[0].d);
        let (to_wrist, length) = direction(p);
        // Above the shoulder any direction will do: the robot's x.
        let z = [R::zero(), R::zero(), R::splat(1.0)];
        let x = [R::splat(1.0), R::zero(), R::zero()];
        let (up, upright) = upright_part(z, to_wrist);
        let upside = upright.lt(R::splat(1e-9));
        let lean_x = if R::bits(upside) == 0 { up } else { upright_part(x, to_wrist).0 };
        let zero = select3::<R>(upside, lean_x, up);
        Line {
            length,
            frame: [to_wrist, zero, cross(to_wrist, zero)],
            wanted: [
                components(base, goal.axes[0]),
                components(base, goal.axes[1]),
                components(base, goal.axes[2]),
            ],
        }
    }

    /// The elbow that brings shoulder and wrist as far apart as they are.
    #[inline(always)]
    fn bent<R: Real>(&self, line: &Line<R>, preferred: Turn<R>, side: Side<R>) -> Elbow<R> {
        let [a, b, fixed] = self.elbow_equation();
        let c = line.length.mul_add(line.length, R::splat(-fixed));
        self.elbow(&linear(R::splat(a), R::splat(b), c, 0.0, preferred, side))
    }

    #[inline(always)]
    fn elbow<R: Real>(&self, bend: &Root<R>) -> Elbow<R> {
        let three = self.geometry.links[2];
        let (s, c) = bend.turn;
        let r = R::splat(self.radius);
        let (y, x) = (s * r, c * r);
        let v = [
            x + R::splat(three.a),
            y.mul_add(R::splat(three.cosine), R::splat(-three.sine * self.height)),
            y.mul_add(R::splat(three.sine), R::splat(three.d + three.cosine * self.height)),
        ];
        let (along, _) = direction(v);
        let (side, out) = upright_part(self.elbow_point(), along);
        // A stretched elbow leans nowhere: where it would, bent a little.
        let straight = out.lt(R::splat(1e-9));
        let hinge = splat3::<R>([0.0, -three.sine, three.cosine]);
        let (bent, _) = direction(cross(hinge, along));
        let side = select3::<R>(straight, bent, side);
        let phase = self.phase.sin_cos();
        let turn = minus((s, c), (R::splat(phase.0), R::splat(phase.1)));
        Elbow {
            turn,
            fourth: value(turn, self.geometry.links[3].theta),
            frame: [along, side, cross(along, side)],
            merged: bend.merged,
            singular: bend.singular,
        }
    }

    /// Direction of the elbow, a point of the third link, seen from the shoulder.
    #[inline(always)]
    fn elbow_point<R: Real>(&self) -> V3<R> {
        let three = self.geometry.links[2];
        let length = hypotenuse(three.a, three.d);
        splat3::<R>([three.a / length, 0.0, three.d / length])
    }

    /// The orientation of the third link at an arm angle (sine and cosine).
    #[inline(always)]
    pub(crate) fn third_link<R: Real>(
        &self,
        line: &Line<R>,
        elbow: &Elbow<R>,
        angle: Turn<R>,
    ) -> [V3<R>; 3] {
        let (s, c) = angle;
        let side = blend(line.frame[1], c, line.frame[2], s);
        let third = cross(line.frame[0], side);
        let frame = [line.frame[0], side, third];
        [outer(frame, elbow.frame, 0), outer(frame, elbow.frame, 1), outer(frame, elbow.frame, 2)]
    }

    /// What is left to the wrist, as columns x and z, where the third link stands so.
    #[inline(always)]
    pub(crate) fn left_to_wrist<R: Real>(
        &self,
        line: &Line<R>,
        elbow: &Elbow<R>,
        third: [V3<R>; 3],
    ) -> [V3<R>; 2] {
        // `third` is turned by the third joint already: only its twist is left.
        let none = (R::zero(), R::splat(1.0));
        let fourth = advance(third, none, &self.geometry.links[2]);
        let fifth = advance(fourth, elbow.turn, &self.geometry.links[3]);
        [components(fifth, line.wanted[0]), components(fifth, line.wanted[2])]
    }

    /// All branches at an arm angle (sine and cosine); `preferred` as for
    /// [`super::SphericalWrist::solve`].
    #[inline(always)]
    pub fn solve<R: Real>(
        &self,
        goal: &Goal<R>,
        tool: [f64; 3],
        angle: Turn<R>,
        preferred: &[Turn<R>],
        out: &mut [Candidate<R>; MOST_BRANCHES],
    ) {
        let at = self.reach(goal, tool, preferred);
        self.solve_at(&at, angle, preferred, out);
    }

    /// [`Self::solve`] after [`Self::reach`].
    #[inline(always)]
    pub(crate) fn solve_at<R: Real>(
        &self,
        at: &Reached<R>,
        angle: Turn<R>,
        preferred: &[Turn<R>],
        out: &mut [Candidate<R>; MOST_BRANCHES],
    ) {
        let [one, two] = Side::both();
        for (elbow, four) in at.elbows.iter().zip(out.as_chunks_mut::<4>().0) {
            let at = self.at(&at.line, elbow, angle);
            let wrists =
                [self.last_three(&at, preferred, one), self.last_three(&at, preferred, two)];
            for (pair, side) in four.as_chunks_mut::<2>().0.iter_mut().zip([one, two]) {
                let shoulder = self.first_three(&at, preferred, side);
                *pair = [
                    Self::branch(elbow, &shoulder, &wrists[0]),
                    Self::branch(elbow, &shoulder, &wrists[1]),
                ];
            }
        }
    }

    /// The branches `2 (first + i)` and the one after it in lane `i`, for one goal and arm
    /// angle that are in every lane; over again from the fifth pair.
    #[inline(always)]
    pub fn side_by_side<R: Real>(
        &self,
        goal: &Goal<R>,
        tool: [f64; 3],
        angle: Turn<R>,
        preferred: &[Turn<R>],
        first: usize,
    ) -> [Candidate<R>; 2] {
        let line = self.line(goal, tool);
        let elbow = self.bent(&line, preferred[3], Side::by_bit(first, 1));
        let at = self.at(&line, &elbow, angle);
        let shoulder = self.first_three(&at, preferred, Side::by_bit(first, 0));
        let [one, two] = Side::both();
        [
            Self::branch(&elbow, &shoulder, &self.last_three(&at, preferred, one)),
            Self::branch(&elbow, &shoulder, &self.last_three(&at, preferred, two)),
        ]
    }

    /// One branch at an arm angle (sine and cosine): that of an elbow and of the sides of
    /// shoulder and wrist.
    #[inline(always)]
    pub(crate) fn one<R: Real>(
        &self,
        line: &Line<R>,
        elbow: &Elbow<R>,
        sides: [Side<R>; 2],
        angle: Turn<R>,
        preferred: &[Turn<R>],
    ) -> Candidate<R> {
        let at = self.at(line, elbow, angle);
        let first = self.first_three(&at, preferred, sides[0]);
        Self::branch(elbow, &first, &self.last_three(&at, preferred, sides[1]))
    }

    /// What the shoulder and the wrist have to bring about at an arm angle.
    #[inline(always)]
    fn at<R: Real>(&self, line: &Line<R>, elbow: &Elbow<R>, angle: Turn<R>) -> [[V3<R>; 2]; 2] {
        let third = self.third_link(line, elbow, angle);
        [[third[0], third[2]], self.left_to_wrist(line, elbow, third)]
    }

    #[inline(always)]
    fn first_three<R: Real>(
        &self,
        at: &[[V3<R>; 2]; 2],
        preferred: &[Turn<R>],
        side: Side<R>,
    ) -> Three<R> {
        let [mx, mz] = at[0];
        self.three(&self.shoulder.solve(mx, mz, preferred[0], side), 0)
    }

    #[inline(always)]
    fn last_three<R: Real>(
        &self,
        at: &[[V3<R>; 2]; 2],
        preferred: &[Turn<R>],
        side: Side<R>,
    ) -> Three<R> {
        let [mx, mz] = at[1];
        self.three(&self.wrist.solve(mx, mz, preferred[4], side), 4)
    }

    /// Joint values of three turns, the first of joint `first`.
    #[inline(always)]
    fn three<R: Real>(&self, of: &Turned<R>, first: usize) -> Three<R> {
        let offsets = [self.offset(first), self.offset(first + 1), self.offset(first + 2)];
        Three { q: values(&of.turns, offsets), merged: of.merged, singular: of.singular }
    }

    #[inline(always)]
    fn branch<R: Real>(elbow: &Elbow<R>, first: &Three<R>, last: &Three<R>) -> Candidate<R> {
        let (f, l) = (&first.q, &last.q);
        Candidate {
            q: [f[0], f[1], f[2], elbow.fourth, l[0], l[1], l[2]],
            merged: elbow.merged | first.merged | last.merged,
            singular: [first.singular, elbow.singular, last.singular],
        }
    }

    /// Shoulder and wrist.
    pub(crate) fn meetings(&self) -> (&Meeting, &Meeting) {
        (&self.shoulder, &self.wrist)
    }

    /// Factors of cosine and sine of the fourth joint's turn, counted from the direction of
    /// the wrist, in the squared distance from shoulder to wrist, and its constant part.
    #[inline(always)]
    pub(crate) fn elbow_equation(&self) -> [f64; 3] {
        let three = self.geometry.links[2];
        let (r, w) = (self.radius, self.height);
        let fixed = three.a * three.a
            + three.d * three.d
            + r * r
            + w * w
            + 2.0 * three.d * three.cosine * w;
        [2.0 * three.a * r, 2.0 * three.d * three.sine * r, fixed]
    }

    /// Distance of the wrist from the fourth axis, m.
    pub(crate) fn radius(&self) -> f64 {
        self.radius
    }

    /// Direction of the wrist about the fourth axis where the fourth joint's turn is 0.
    pub(crate) fn phase(&self) -> f64 {
        self.phase
    }

    /// What a joint's turn is counted from, rad.
    #[inline(always)]
    pub(crate) fn offset(&self, joint: usize) -> f64 {
        self.geometry.offset(joint)
    }

    /// The arm angle of a configuration, rad in [-pi, pi]; 0 where the elbow is stretched
    /// along the line.
    pub fn arm_angle(&self, q: &[f64]) -> f64 {
        let g = &self.geometry;
        let mut frame = identity::<f64>();
        for j in 0..3 {
            let turn = (q[g.variables[j]] + g.links[j].theta).sin_cos();
            frame = if j < 2 {
                advance(frame, turn, &g.links[j])
            } else {
                let none = Link { sine: 0.0, cosine: 1.0, ..g.links[2] };
                advance(frame, turn, &none)
            };
        }
        let t4 = q[g.variables[3]] + g.links[3].theta + self.phase;
        let elbow = self.elbow(&Root { turn: t4.sin_cos(), ..Root::none() });
        let world = |v: V3<f64>| {
            [0, 1, 2].map(|k| frame[0][k] * v[0] + frame[1][k] * v[1] + frame[2][k] * v[2])
        };
        let (along, side) = (world(elbow.frame[0]), world(elbow.frame[1]));
        let z = [0.0, 0.0, 1.0];
        let (mut zero, upright) = upright_part(z, along);
        if upright < 1e-9 {
            zero = upright_part([1.0, 0.0, 0.0], along).0;
        }
        dot(cross(along, zero), side).atan2(dot(zero, side))
    }
}

/// `v` less its part along a unit vector.
#[inline(always)]
fn less<R: Real>(v: V3<R>, along: V3<R>) -> V3<R> {
    axpy(along, -dot(along, v), v)
}

/// Direction and length of the part of `v` at right angles to a unit vector.
#[inline(always)]
fn upright_part<R: Real>(v: V3<R>, along: V3<R>) -> (V3<R>, R) {
    let (rough, length) = direction(less(v, along));
    // A short part has few digits left: a second pass makes the angle right again.
    (direction(less(rough, along)).0, length)
}

/// Column `k` of the rotation that takes the frame `from` (columns) to the frame `to`.
#[inline(always)]
fn outer<R: Real>(to: [V3<R>; 3], from: [V3<R>; 3], k: usize) -> V3<R> {
    let v = scale(to[0], from[0][k]);
    axpy(to[1], from[1][k], axpy(to[2], from[2][k], v))
}
