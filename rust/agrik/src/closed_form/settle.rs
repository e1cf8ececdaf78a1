//! A lane group at work: what every closed form does with its goals and candidates.

use super::candidates::{BRANCHES, Candidate, JOINTS, Lanes};
use super::check::{Exact, Limit, wrap};
use super::srs::{Reached, Srs};
use super::turn::Turn;
use super::{ClosedForm, geometry::Geometry};
use crate::chain::{Chain, Tail};
use crate::kinematics::{Workspace, forward};
use crate::lanes::Real;
use crate::solve::Tolerance;
use crate::task::Goal;

/// One lane group at work: goals in, checked branches out.
pub(super) struct Group<'a, R> {
    pub form: &'a ClosedForm,
    geometry: &'a Geometry,
    exact: Exact<'a>,
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
            exact: Exact::new(chain.compiled(), &geometry.variables, tail, tolerance),
            geometry,
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
        let tool = self.exact.tail.translation;
        self.form.solve(&self.goal, tool, self.angle, &self.preferred, &mut self.candidates);
        for b in 0..BRANCHES {
            self.wrap(b);
            self.check(b);
        }
    }

    /// Solves the goal of a group of one lane; its branches are brought within limits and
    /// checked side by side in the lanes of another number type.
    #[inline(always)]
    pub fn solve_with<W: Real>(&mut self, workspace: &mut Workspace<W>) {
        let tool = self.exact.tail.translation;
        self.form.solve(&self.goal, tool, self.angle, &self.preferred, &mut self.candidates);
        let mut goal = Goal::<W>::zero();
        for i in 0..3 {
            goal.position[i] = W::splat(self.goal.position[i].lane(0));
            for k in 0..3 {
                goal.axes[k][i] = W::splat(self.goal.axes[k][i].lane(0));
            }
        }
        let mut centre = [W::zero(); JOINTS];
        let mut q = [W::zero(); JOINTS];
        for j in 0..self.joints {
            centre[j] = W::splat(self.centre[j].lane(0));
        }
        let mut first = 0;
        while first < BRANCHES {
            let some = &mut self.candidates[first..BRANCHES.min(first + W::WIDTH)];
            for (lane, from) in some.iter().enumerate() {
                for (to, x) in q.iter_mut().zip(&from.q) {
                    to.set_lane(lane, x.lane(0));
                }
            }
            let inside = wrap(&self.limits[..self.joints], &mut q, &centre);
            let (position2, chord2) = self.exact.miss(&q, &goal, workspace);
            let near = self.exact.is_near(position2, chord2);
            for (lane, to) in some.iter_mut().enumerate() {
                for (to, x) in to.q.iter_mut().zip(&q) {
                    to.set_lane(0, x.lane(lane));
                }
                self.reached[first + lane] = near >> lane & !to.merged & 1;
                self.inside[first + lane] = inside >> lane & 1;
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
        let q = &mut self.candidates[b].q;
        self.inside[b] = wrap(&self.limits[..self.joints], q, &self.centre);
    }

    /// Checks a branch by forward kinematics.
    #[inline(always)]
    fn check(&mut self, b: usize) {
        let candidate = &self.candidates[b];
        let (position2, chord2) = self.exact.miss(&candidate.q, &self.goal, &mut self.workspace);
        self.reached[b] = self.exact.is_near(position2, chord2) & !candidate.merged;
        self.position2[b] = position2;
        self.chord2[b] = chord2;
    }

    /// The tool point in the last joint's frame.
    #[inline(always)]
    pub fn tool(&self) -> [f64; 3] {
        self.exact.tail.translation
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
            exact: self.exact,
            geometry: self.geometry,
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
            workspace: Workspace::new(self.exact.compiled),
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
        let mut workspace = Workspace::new(self.exact.compiled);
        forward(self.exact.compiled, q, &mut workspace);
        (workspace.joint_axes(), workspace.tool_point(self.exact.tail.translation))
    }

    /// A branch of a single target is within the tolerances, whether or not it is another
    /// branch over again.
    pub fn reaches(&self, b: usize) -> bool {
        self.exact.is_near(self.position2[b].lane(0), self.chord2[b].lane(0)) & 1 != 0
    }

    /// Lanes in which a branch is reached and inside the limits.
    #[inline(always)]
    pub fn valid(&self, b: usize) -> Lanes {
        self.reached[b] & self.inside[b]
    }
}
