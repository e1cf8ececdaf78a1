//! A lane group at work: what every closed form does with its goals and candidates.

use super::check::{Exact, Pair, wrap_one, wrap_pair};
use super::choice::Choice;
use super::open_angles::{self, Open};
use super::polish::{Polished, is_rough, polished};
use crate::call::Request;
use crate::closed_form::families::ClosedForm;
use crate::closed_form::families::srs::{Elbow, Line, Reached, Srs};
use crate::closed_form::geometry::axes::Geometry;
use crate::closed_form::geometry::candidate::{Candidate, JOINTS, MOST_BRANCHES};
use crate::closed_form::geometry::limit::Limit;
use crate::closed_form::geometry::turn::{Side, Turn};
use crate::kinematics::{Workspace, forward};
use crate::lanes::{Lanes, Real};
use crate::task::Goal;

/// What all targets of a call share: the arm, its limits, and when it is near enough.
#[derive(Clone, Copy)]
pub(crate) struct Job<'a> {
    pub form: &'a ClosedForm,
    pub geometry: &'a Geometry,
    pub exact: Exact<'a>,
    /// A branch may be brought nearer by steps: not where they would change an arm angle that
    /// was asked for.
    pub steps: bool,
}

impl<'a> Job<'a> {
    pub fn new(form: &'a ClosedForm, request: &Request<'a>) -> Self {
        let geometry = form.geometry();
        let (compiled, aim) = (request.chain().compiled(), request.aim());
        let exact = Exact::new(compiled, &geometry.variables, *aim.tail(), aim.tolerance());
        Self { form, geometry, exact, steps: true }
    }

    /// Limits along the chain.
    #[inline(always)]
    pub fn limits(&self) -> &'a [Limit] {
        &self.geometry.limits
    }

    /// Which entry of `q` each joint along the chain is.
    #[inline(always)]
    pub fn variables(&self) -> &'a [usize] {
        &self.geometry.variables
    }

    /// The tool point in the last joint's frame.
    #[inline(always)]
    pub fn tool(&self) -> [f64; 3] {
        self.exact.tail.translation
    }

    /// Joint values inside the limits, in place of an answer.
    pub fn stand_in(&self, q: &mut [f64]) {
        for (variable, limit) in self.variables().iter().zip(self.limits()) {
            q[*variable] = 0.0_f64.clamp(limit.lower, limit.upper);
        }
    }

    /// Brings a pair of branches within limits by whole turns, and checks it: for each branch
    /// the lanes in which it is inside, and the squared distance and chord that are left.
    #[inline(always)]
    pub fn settle<R: Real>(
        &self,
        pair: &mut Pair<R>,
        goal: &Goal<R>,
        centre: &[R; JOINTS],
    ) -> ([Lanes; 2], [(R, R); 2]) {
        let mut inside = wrap_pair(self.limits(), pair, centre);
        let mut missed = self.exact.miss_pair(pair, goal);
        let (digits, misfit) = (self.form.loses_digits(), self.misfits());
        for way in 0..2 {
            let ((position2, chord2), branch) = (missed[way], &pair[way]);
            let near = self.exact.is_near(position2, chord2);
            // In line or stretched, inside only with other shares of the open angles.
            let [shoulder, elbow, wrist] = branch.singular;
            let mut mend = (shoulder | elbow | wrist) & near & !inside[way];
            if digits || misfit {
                let rough = R::bits(is_rough(position2, chord2));
                mend |= rough & if digits { Lanes::MAX } else { !near };
            }
            mend &= !branch.merged;
            while mend != 0 {
                let lane = mend.trailing_zeros() as usize;
                mend &= mend - 1;
                let (mut q, mut near) = ([0.0; JOINTS], [0.0; JOINTS]);
                for j in 0..JOINTS {
                    (q[j], near[j]) = (pair[way].q[j].lane(lane), centre[j].lane(lane));
                }
                let found = self.mended(
                    Polished {
                        q,
                        inside: inside[way] >> lane & 1 != 0,
                        position2: missed[way].0.lane(lane),
                        chord2: missed[way].1.lane(lane),
                    },
                    &goal.of_lane(lane),
                    &near,
                    pair[way].singular.map(|lanes| lanes >> lane & 1 != 0),
                    way,
                );
                for (x, to) in pair[way].q.iter_mut().zip(found.q) {
                    x.set_lane(lane, to);
                }
                missed[way].0.set_lane(lane, found.position2);
                missed[way].1.set_lane(lane, found.chord2);
                inside[way] = inside[way] & !(1 << lane) | u32::from(found.inside) << lane;
            }
        }
        (inside, missed)
    }

    /// The recognised geometry differs from the chain's so much that a branch may miss.
    #[inline(always)]
    fn misfits(&self) -> bool {
        let misfit = &self.geometry.misfit;
        misfit.position.max(misfit.orientation) > 1e-10
    }

    /// A branch of one target that lost digits, or whose open angles are outside the limits.
    #[inline(never)]
    fn mended(
        &self,
        mut branch: Polished,
        goal: &Goal<f64>,
        centre: &[f64; JOINTS],
        singular: [bool; 3],
        way: usize,
    ) -> Polished {
        let near = |b: &Polished| self.exact.is_near(b.position2, b.chord2) & 1 != 0;
        if self.form.loses_digits() || !near(&branch) {
            branch = polished(&self.exact, self.limits(), branch, goal, centre);
        }
        if near(&branch) && !branch.inside && singular != [false; 3] {
            let open = Open { q: branch.q, singular, way, centre };
            if let Some(open) = open_angles::inside(self, goal, &open) {
                // Angles that nothing decides leave other joints what they are by fewer digits.
                let fine = polished(&self.exact, self.limits(), open, goal, centre);
                branch = if fine.inside { fine } else { open };
            }
        }
        branch
    }

    /// The arm at `q`.
    pub fn at(&self, q: &[f64]) -> Workspace<f64> {
        let mut workspace = Workspace::new(self.exact.compiled);
        forward(self.exact.compiled, q, &mut workspace);
        workspace
    }
}

/// What the answers stay near, where they can choose.
#[derive(Clone, Copy)]
pub(crate) struct Near<R> {
    /// Values along the chain.
    pub centre: [R; JOINTS],
    /// Their turns from the common normals: what angles take that nothing decides.
    pub preferred: [Turn<R>; JOINTS],
}

impl<R: Real> Near<R> {
    /// The middle of the limits.
    #[inline(always)]
    pub fn middle(geometry: &Geometry) -> Self {
        let mut near =
            Self { centre: [R::zero(); JOINTS], preferred: [(R::zero(), R::splat(1.0)); JOINTS] };
        for (j, (limit, turn)) in geometry.limits.iter().zip(&geometry.middle).enumerate() {
            near.centre[j] = R::splat(limit.middle);
            near.preferred[j] = (R::splat(turn.0), R::splat(turn.1));
        }
        near
    }

    /// The start values of one of a call's targets in every lane, or the middle of the limits.
    #[inline(always)]
    pub fn to(geometry: &Geometry, request: &Request<'_>, row: usize) -> Self {
        let mut near = Self::middle(geometry);
        if let Some(q0) = request.start(row) {
            let most = request.well_known(row);
            for lane in 0..R::WIDTH {
                near.set(geometry, lane, q0, most);
            }
            near.turn(geometry);
        }
        near
    }

    /// Makes `q` (in the order of `q`) the centre of one lane; [`Self::turn`] is due.
    #[inline(always)]
    pub fn set(&mut self, geometry: &Geometry, lane: usize, q: &[f64], most: f64) {
        let joints = geometry.variables.iter().zip(&geometry.limits);
        for (centre, (variable, limit)) in self.centre.iter_mut().zip(joints) {
            centre.set_lane(lane, limit.reference(q[*variable], most));
        }
    }

    /// A choice that does not look at the start values takes the values nearest to the
    /// middle of the limits.
    #[inline(always)]
    pub fn judged_by(&mut self, choice: Choice, geometry: &Geometry) {
        if choice != Choice::Nearest {
            for (centre, limit) in self.centre.iter_mut().zip(&geometry.limits) {
                *centre = R::splat(limit.middle);
            }
        }
    }

    /// Turns the joints to the centre.
    #[inline(always)]
    pub fn turn(&mut self, geometry: &Geometry) {
        for j in 0..geometry.limits.len() {
            self.preferred[j] = (self.centre[j] + R::splat(geometry.offset(j))).sin_cos();
        }
    }
}

/// The best of the branches of each lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Best<R> {
    /// Its cost; infinite where no branch is valid.
    pub cost: R,
    /// Its number.
    pub branch: R,
    /// Lanes that have one.
    pub found: Lanes,
}

/// One lane group at work: goals in, checked branches out.
pub(crate) struct Group<'a, R> {
    pub job: Job<'a>,
    pub near: Near<R>,
    pub goal: Goal<R>,
    /// Sine and cosine of the arm angle.
    pub angle: Turn<R>,
    pub candidates: [Candidate<R>; MOST_BRANCHES],
    pub reached: [Lanes; MOST_BRANCHES],
    pub inside: [Lanes; MOST_BRANCHES],
    /// Squared distance left, m^2.
    pub position2: [R; MOST_BRANCHES],
    /// Squared chord left between the wanted and the present axes.
    pub chord2: [R; MOST_BRANCHES],
}

impl<'a, R: Real> Group<'a, R> {
    #[inline(always)]
    pub fn new(job: Job<'a>) -> Self {
        Self {
            near: Near::middle(job.geometry),
            goal: Goal::zero(),
            angle: (R::zero(), R::splat(1.0)),
            candidates: [Candidate::none(); MOST_BRANCHES],
            reached: [0; MOST_BRANCHES],
            inside: [0; MOST_BRANCHES],
            position2: [R::zero(); MOST_BRANCHES],
            chord2: [R::zero(); MOST_BRANCHES],
            job,
        }
    }

    /// Solves the goals.
    #[inline(always)]
    pub fn solve(&mut self) {
        let (form, tool) = (self.job.form, self.job.tool());
        form.solve(&self.goal, tool, self.angle, &self.near.preferred, &mut self.candidates);
        let job = self.job;
        for (i, pair) in self.candidates.as_chunks_mut::<2>().0.iter_mut().enumerate() {
            let (inside, missed) = job.settle(pair, &self.goal, &self.near.centre);
            for (way, (position2, chord2)) in missed.into_iter().enumerate() {
                let b = 2 * i + way;
                self.inside[b] = inside[way];
                self.reached[b] = job.exact.is_near(position2, chord2) & !pair[way].merged;
                self.position2[b] = position2;
                self.chord2[b] = chord2;
            }
        }
    }

    /// One branch of an S-R-S arm at the arm angle in place of the first of all, checked.
    #[inline(always)]
    pub fn solve_one(&mut self, arm: &Srs, line: &Line<R>, elbow: &Elbow<R>, sides: [Side<R>; 2]) {
        let preferred = &self.near.preferred;
        let mut one = arm.one(line, elbow, sides, self.angle, preferred);
        self.inside[0] = wrap_one(self.job.limits(), &mut one, &self.near.centre);
        let (position2, chord2) = self.job.exact.miss(&one.q, &self.goal);
        // The only branch: that it may be another one over again does not matter.
        self.reached[0] = self.job.exact.is_near(position2, chord2);
        (self.position2[0], self.chord2[0]) = (position2, chord2);
        self.candidates[0] = one;
    }

    /// Branches at an arm angle, not yet within limits nor checked.
    #[inline(always)]
    pub fn solve_at(&mut self, arm: &Srs, at: &Reached<R>, angle: Turn<R>) {
        arm.solve_at(at, angle, &self.near.preferred, &mut self.candidates);
    }

    /// Brings the joints of all branches within limits by whole turns.
    #[inline(always)]
    pub fn wrap(&mut self) {
        let pairs = self.candidates.as_chunks_mut::<2>().0.iter_mut();
        for (pair, inside) in pairs.zip(self.inside.as_chunks_mut::<2>().0) {
            *inside = wrap_pair(self.job.limits(), pair, &self.near.centre);
        }
    }

    /// One lane of this group as a group of its own.
    pub fn one_lane(&self, lane: usize) -> Group<'a, f64> {
        let of = |x: &R| x.lane(lane);
        let turn = |t: &Turn<R>| (of(&t.0), of(&t.1));
        let mut single = Group::<f64>::new(self.job);
        for j in 0..JOINTS {
            single.near.centre[j] = of(&self.near.centre[j]);
            single.near.preferred[j] = turn(&self.near.preferred[j]);
        }
        single.goal = self.goal.of_lane(lane);
        single.angle = turn(&self.angle);
        single
    }

    /// A branch of a single target is within the tolerances, whether or not it is another
    /// branch over again.
    pub fn reaches(&self, b: usize) -> bool {
        self.job.exact.is_near(self.position2[b].lane(0), self.chord2[b].lane(0)) & 1 != 0
    }

    /// Lanes in which a branch is reached and inside the limits.
    #[inline(always)]
    pub fn valid(&self, b: usize) -> Lanes {
        self.reached[b] & self.inside[b]
    }

    /// The best of the branches that are among `valid`, one mask of lanes a branch.
    #[inline(always)]
    pub fn pick(&self, choice: Choice, valid: &[Lanes; MOST_BRANCHES]) -> Best<R> {
        let mut best = Best { cost: R::splat(f64::INFINITY), branch: R::zero(), found: 0 };
        for (b, lanes) in valid.iter().enumerate() {
            if *lanes == 0 {
                continue;
            }
            let cost = choice.cost(&self.candidates[b].q, &self.near.centre, self.job.limits());
            let better = R::and(cost.lt(best.cost), R::mask_from_bits(*lanes));
            best.cost = R::select(better, cost, best.cost);
            best.branch = R::select(better, R::splat(b as f64), best.branch);
            best.found |= lanes;
        }
        best
    }
}
