//! What every closed form does with its candidates: whole turns that bring each joint
//! inside its limits, and the check by forward kinematics.

use std::f64::consts::TAU;

use super::candidates::{BRANCHES, Candidate, JOINTS, Lanes};
use super::srs::{Reached, Srs};
use super::turn::Turn;
use super::{ClosedForm, geometry::Geometry};
use crate::chain::{Chain, Compiled, Tail, Variable};
use crate::kinematics::{Workspace, forward};
use crate::lanes::{Real, dot, sub};
use crate::solve::Tolerance;
use crate::task::Goal;

/// A joint value this far past a limit is rounding, and is put on the limit, rad.
pub(super) const SLACK: f64 = 1e-10;

/// A joint's limits and the value that it stays near.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limit {
    pub lower: f64,
    pub upper: f64,
    /// Middle of the limits; 0 where there are none.
    pub middle: f64,
    /// Half their distance; infinite where there are none.
    pub half: f64,
}

impl Limit {
    fn of(v: &Variable) -> Self {
        let bounded = v.lower.is_finite() && v.upper.is_finite();
        let middle = if bounded { 0.5 * (v.lower + v.upper) } else { 0.0 };
        let half = if bounded { 0.5 * (v.upper - v.lower) } else { f64::INFINITY };
        Self { lower: v.lower, upper: v.upper, middle, half }
    }
}

/// One lane group at work: goals in, checked branches out.
pub(super) struct Group<'a, R> {
    pub form: &'a ClosedForm,
    pub compiled: &'a Compiled,
    geometry: &'a Geometry,
    tail: Tail,
    position_limit2: f64,
    chord_limit2: f64,
    /// Limits along the chain.
    pub limits: [Limit; JOINTS],
    pub joints: usize,
    /// Values along the chain that the answers stay near.
    pub centre: [R; JOINTS],
    preferred: [Turn<R>; JOINTS],
    pub goal: Goal<R>,
    /// Sine and cosine of the arm angle.
    pub angle: Turn<R>,
    pub candidates: [Candidate<R>; BRANCHES],
    pub reached: [Lanes; BRANCHES],
    pub inside: [Lanes; BRANCHES],
    /// Squared distance left, m^2.
    pub position2: [R; BRANCHES],
    /// Squared chord left between the wanted and the present axes.
    pub chord2: [R; BRANCHES],
    workspace: Workspace<R>,
    /// Values in the order of `q`.
    ordered: [R; JOINTS],
}

impl<'a, R: Real> Group<'a, R> {
    #[inline(always)]
    pub fn new(chain: &'a Chain, form: &'a ClosedForm, tail: Tail, tolerance: Tolerance) -> Self {
        let geometry = form.geometry();
        let none = Limit { lower: 0.0, upper: 0.0, middle: 0.0, half: f64::INFINITY };
        let mut limits = [none; JOINTS];
        for (limit, variable) in limits.iter_mut().zip(&geometry.variables) {
            *limit = Limit::of(&chain.variables()[*variable]);
        }
        let turn = (R::zero(), R::splat(1.0));
        let mut group = Self {
            form,
            compiled: chain.compiled(),
            geometry,
            tail,
            position_limit2: tolerance.position * tolerance.position,
            // A rotation by x moves the three unit axes by 2 sin(x / 2) sqrt(2) in all.
            chord_limit2: 8.0 * (0.5 * tolerance.orientation.min(3.0)).sin().powi(2),
            limits,
            joints: geometry.variables.len(),
            centre: [R::zero(); JOINTS],
            preferred: [turn; JOINTS],
            goal: Goal::zero(),
            angle: turn,
            candidates: [Candidate::none(); BRANCHES],
            reached: [0; BRANCHES],
            inside: [0; BRANCHES],
            position2: [R::zero(); BRANCHES],
            chord2: [R::zero(); BRANCHES],
            workspace: Workspace::new(chain.compiled()),
            ordered: [R::zero(); JOINTS],
        };
        for (centre, limit) in group.centre.iter_mut().zip(&group.limits) {
            *centre = R::splat(limit.middle);
        }
        group.prefer();
        group
    }

    /// Makes `q` (in the order of `q`) the centre of one lane; [`Self::prefer`] is due.
    #[inline(always)]
    pub fn set_centre(&mut self, lane: usize, q: &[f64]) {
        for (j, variable) in self.geometry.variables.iter().enumerate() {
            let Limit { lower, upper, .. } = self.limits[j];
            self.centre[j].set_lane(lane, q[*variable].clamp(lower, upper));
        }
    }

    /// Angles that nothing decides are taken from the centre from now on.
    #[inline(always)]
    pub fn prefer(&mut self) {
        let g = self.geometry;
        for j in 0..self.joints {
            let offset = if j + 1 < self.joints { g.links[j].theta } else { g.last_theta };
            self.preferred[j] = (self.centre[j] + R::splat(offset)).sin_cos();
        }
    }

    /// Solves the goals.
    #[inline(always)]
    pub fn solve(&mut self) {
        let tool = self.tail.translation;
        self.form.solve(&self.goal, tool, self.angle, &self.preferred, &mut self.candidates);
        for b in 0..BRANCHES {
            self.wrap(b);
            self.check(b);
        }
    }

    /// Solves the goal of a group of one lane; its branches are brought within limits and
    /// checked in the lanes of another group.
    #[inline(always)]
    pub fn solve_with<W: Real>(&mut self, wide: &mut Group<'_, W>) {
        let tool = self.tail.translation;
        self.form.solve(&self.goal, tool, self.angle, &self.preferred, &mut self.candidates);
        for i in 0..3 {
            wide.goal.position[i] = W::splat(self.goal.position[i].lane(0));
            for k in 0..3 {
                wide.goal.axes[k][i] = W::splat(self.goal.axes[k][i].lane(0));
            }
        }
        for j in 0..self.joints {
            wide.centre[j] = W::splat(self.centre[j].lane(0));
        }
        let mut first = 0;
        while first < BRANCHES {
            wide.candidates[0].merged = 0;
            for lane in 0..W::WIDTH.min(BRANCHES - first) {
                let from = &self.candidates[first + lane];
                wide.candidates[0].merged |= (from.merged & 1) << lane;
                for (to, x) in wide.candidates[0].q.iter_mut().zip(&from.q) {
                    to.set_lane(lane, x.lane(0));
                }
            }
            wide.wrap(0);
            wide.check(0);
            for lane in 0..W::WIDTH.min(BRANCHES - first) {
                let b = first + lane;
                for (to, x) in self.candidates[b].q.iter_mut().zip(&wide.candidates[0].q) {
                    to.set_lane(0, x.lane(lane));
                }
                self.reached[b] = wide.reached[0] >> lane & 1;
                self.inside[b] = wide.inside[0] >> lane & 1;
            }
            first += W::WIDTH;
        }
    }

    /// Branches at an arm angle, not yet within limits nor checked.
    #[inline(always)]
    pub fn solve_at(&mut self, arm: &Srs, at: &Reached<R>, angle: Turn<R>) {
        arm.solve_at(at, angle, &self.preferred, &mut self.candidates);
    }

    /// Brings the joints of a branch within limits by whole turns.
    #[inline(always)]
    pub fn wrap(&mut self, b: usize) {
        let candidate = &mut self.candidates[b];
        let mut inside = R::mask_from_bits(u32::MAX);
        for j in 0..self.joints {
            let limit = self.limits[j];
            let (lower, upper) = (R::splat(limit.lower), R::splat(limit.upper));
            let turn = R::splat(TAU);
            let x = candidate.q[j];
            let turns = ((self.centre[j] - x) * R::splat(1.0 / TAU)).round();
            let x = turns.mul_add(turn, x);
            // The nearest to the centre may be just outside, and the next one inside.
            let slack = R::splat(SLACK);
            let x = R::select((upper + slack).lt(x), x - turn, x);
            let x = R::select(x.lt(lower - slack), x + turn, x);
            let held = x.max(lower).min(upper);
            let near = (x - held).abs().le(slack);
            inside = R::and(inside, near);
            let x = R::select(near, held, x);
            candidate.q[j] = x;
        }
        self.inside[b] = R::bits(inside);
    }

    /// Checks a branch by forward kinematics.
    #[inline(always)]
    fn check(&mut self, b: usize) {
        let candidate = &self.candidates[b];
        for (x, variable) in candidate.q.iter().zip(&self.geometry.variables) {
            self.ordered[*variable] = *x;
        }
        forward(self.compiled, &self.ordered, &mut self.workspace);
        let axes = self.workspace.joint_axes();
        let mut chord2 = R::zero();
        for (axis, wanted) in axes.iter().zip(&self.goal.axes) {
            let d = sub(*axis, *wanted);
            chord2 += dot(d, d);
        }
        let d = sub(self.workspace.tool_point(self.tail.translation), self.goal.position);
        let position2 = dot(d, d);
        let near = R::and(
            position2.le(R::splat(self.position_limit2)),
            chord2.le(R::splat(self.chord_limit2)),
        );
        self.position2[b] = position2;
        self.chord2[b] = chord2;
        self.reached[b] = R::bits(near) & !candidate.merged;
    }

    /// The tool point in the last joint's frame.
    #[inline(always)]
    pub fn tool(&self) -> [f64; 3] {
        self.tail.translation
    }

    /// Where angles stand that nothing decides.
    #[inline(always)]
    pub fn preferred(&self) -> &[Turn<R>] {
        &self.preferred
    }

    /// One lane of this group as a group of its own.
    pub fn one_lane(&self, lane: usize) -> Group<'a, f64> {
        let of = |x: &R| x.lane(lane);
        let turn = |t: &Turn<R>| (of(&t.0), of(&t.1));
        let none = (0.0, 1.0);
        let mut centre = [0.0; JOINTS];
        let mut preferred = [none; JOINTS];
        for j in 0..JOINTS {
            centre[j] = of(&self.centre[j]);
            preferred[j] = turn(&self.preferred[j]);
        }
        let goal = Goal {
            position: [0, 1, 2].map(|i| of(&self.goal.position[i])),
            axes: [0, 1, 2].map(|k| [0, 1, 2].map(|i| of(&self.goal.axes[k][i]))),
        };
        Group {
            form: self.form,
            compiled: self.compiled,
            geometry: self.geometry,
            tail: self.tail,
            position_limit2: self.position_limit2,
            chord_limit2: self.chord_limit2,
            limits: self.limits,
            joints: self.joints,
            centre,
            preferred,
            goal,
            angle: turn(&self.angle),
            candidates: [Candidate::none(); BRANCHES],
            reached: [0; BRANCHES],
            inside: [0; BRANCHES],
            position2: [0.0; BRANCHES],
            chord2: [0.0; BRANCHES],
            workspace: Workspace::new(self.compiled),
            ordered: [0.0; JOINTS],
        }
    }

    /// Which entry of `q` each joint along the chain is.
    pub fn variables(&self) -> &'a [usize] {
        &self.geometry.variables
    }

    /// Joint values inside the limits, in place of an answer.
    pub fn stand_in(&self, q: &mut [f64]) {
        for (variable, limit) in self.geometry.variables.iter().zip(&self.limits) {
            q[*variable] = 0.0_f64.clamp(limit.lower, limit.upper);
        }
    }

    /// Axes of the last joint's frame and the tool point at `q`.
    pub fn pose(&self, q: &[f64]) -> ([[f64; 3]; 3], [f64; 3]) {
        let mut workspace = Workspace::new(self.compiled);
        forward(self.compiled, q, &mut workspace);
        (workspace.joint_axes(), workspace.tool_point(self.tail.translation))
    }

    /// A branch of a single target is within the tolerances, whether or not it is another
    /// branch over again.
    pub fn reaches(&self, b: usize) -> bool {
        self.position2[b].lane(0) <= self.position_limit2
            && self.chord2[b].lane(0) <= self.chord_limit2
    }

    /// Lanes in which a branch is reached and inside the limits.
    #[inline(always)]
    pub fn valid(&self, b: usize) -> Lanes {
        self.reached[b] & self.inside[b]
    }
}
