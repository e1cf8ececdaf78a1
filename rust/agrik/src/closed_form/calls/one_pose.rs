//! One target at a time: its branches stand side by side in the lanes, so that a single
//! call takes hardly longer than one branch would. A branch gets, bit for bit, the values
//! that it gets in a batch, where a lane holds a target.

use super::any_arm::AnyArm;
use super::branches::BranchesMut;
use super::last_resort;
use super::query::{Query, Target};
use crate::call::{Request, Status};
use crate::closed_form::branch::check::{is_exact, without_rough};
use crate::closed_form::branch::choice::Choice;
use crate::closed_form::branch::group::Job;
use crate::closed_form::branch::unreachable::is_out_of_reach;
use crate::closed_form::families::every::Every;
use crate::closed_form::geometry::candidate::{JOINTS, MOST_BRANCHES};
use crate::lanes::{Kernel, Lanes, Level, Real, dispatch};
use crate::task::Goal;

/// The branches of one target.
#[derive(Debug, Clone)]
pub struct Alone {
    joints: usize,
    branches: usize,
    q: [f64; MOST_BRANCHES * JOINTS],
    /// One bit a branch.
    pub(crate) reached: Lanes,
    inside: Lanes,
    exact: Lanes,
    singular: [u8; MOST_BRANCHES],
    /// The same of branches that are not reached.
    flags: [u8; MOST_BRANCHES],
    status: Status,
    /// Bits of [`super::warning`].
    warnings: u8,
    free: i8,
}

/// What is left between each branch and the target, and what the branch costs.
#[derive(Debug, Clone)]
pub(crate) struct Left {
    /// Squared distance, m^2.
    pub position2: [f64; MOST_BRANCHES],
    /// Squared chord between the wanted and the present axes.
    pub chord2: [f64; MOST_BRANCHES],
    /// Cost by a choice.
    pub cost: [f64; MOST_BRANCHES],
}

impl Left {
    /// Nothing known.
    pub fn new() -> Self {
        let far = [f64::INFINITY; MOST_BRANCHES];
        Self { position2: far, chord2: far, cost: far }
    }
}

impl Alone {
    /// No branch yet.
    pub(crate) fn new(job: &Job<'_>) -> Self {
        Self::blank(job.variables().len(), job.form.branches())
    }

    fn blank(joints: usize, branches: usize) -> Self {
        Self {
            joints,
            branches,
            q: [0.0; MOST_BRANCHES * JOINTS],
            reached: 0,
            inside: 0,
            exact: 0,
            singular: [0; MOST_BRANCHES],
            flags: [0; MOST_BRANCHES],
            status: Status::BadInput,
            warnings: 0,
            free: -1,
        }
    }

    /// A record whose row is filled as those of a batch are: no memory is asked for but its own.
    pub(super) fn filled(
        joints: usize,
        branches: usize,
        fill: impl FnOnce(&mut BranchesMut<'_>),
    ) -> Box<Self> {
        let mut out = Box::new(Self::blank(joints, branches));
        let (mut valid, mut reached) = ([false; MOST_BRANCHES], [false; MOST_BRANCHES]);
        let mut status = [Status::BadInput as u8];
        let Self { q, singular, warnings, free, .. } = &mut *out;
        fill(&mut BranchesMut {
            first: 0,
            q: &mut q[..branches * joints],
            valid: &mut valid[..branches],
            reached: &mut reached[..branches],
            singular: &mut singular[..branches],
            status: &mut status,
            warnings: std::slice::from_mut(warnings),
            free: std::slice::from_mut(free),
            left: &mut [],
            off: &mut [],
        });
        for b in 0..branches {
            out.reached |= Lanes::from(reached[b]) << b;
            out.inside |= Lanes::from(valid[b]) << b;
        }
        let known = Status::ALL.into_iter().find(|one| *one as u8 == status[0]);
        out.status = known.unwrap_or(Status::BadInput);
        out
    }

    /// What else is to be said of the target, as in [`super::Branches::warnings`].
    pub fn warnings(&self) -> u8 {
        self.warnings
    }

    /// Entry of `q` that a singularity leaves free, -1 for none.
    pub fn free_joint(&self) -> i8 {
        self.free
    }

    /// How many branches, existing or not.
    pub fn branches(&self) -> usize {
        self.branches
    }

    /// Joint values, a row of `dof` for each branch, rad; as in [`super::Branches`].
    #[inline(always)]
    pub fn q(&self) -> &[f64] {
        &self.q[..self.branches * self.joints]
    }

    /// Joint values of a branch, rad.
    #[inline(always)]
    pub(crate) fn branch(&self, b: usize) -> &[f64] {
        &self.q[b * self.joints..(b + 1) * self.joints]
    }

    /// Whether forward kinematics confirms a branch, limits aside.
    #[inline(always)]
    pub fn reached(&self, b: usize) -> bool {
        self.reached >> b & 1 != 0
    }

    /// Whether a branch is reached and inside the limits.
    #[inline(always)]
    pub fn valid(&self, b: usize) -> bool {
        (self.reached & self.inside) >> b & 1 != 0
    }

    /// Singularities of a branch, as in [`super::Branches::singular`].
    #[inline(always)]
    pub fn singular(&self, b: usize) -> u8 {
        self.singular[b]
    }

    /// What became of the target.
    pub fn status(&self) -> Status {
        self.status
    }

    /// The valid branch of least cost, the first of several.
    #[inline(always)]
    pub(crate) fn best(&self, left: &Left) -> Option<usize> {
        let mut best = (f64::INFINITY, None);
        for (b, cost) in left.cost.iter().enumerate() {
            if self.valid(b) && *cost < best.0 {
                best = (*cost, Some(b));
            }
        }
        best.1
    }

    /// Fills the record for a goal, and `left` if it is wanted, with costs by a choice.
    #[inline(always)]
    pub(crate) fn solve<R: Real>(
        &mut self,
        job: &Job<'_>,
        target: &Target<R>,
        last_search: bool,
        mut left: Option<(&mut Left, Choice)>,
    ) {
        let variables = job.variables();
        let goal = everywhere::<R>(&target.goal);
        let (near, (sine, cosine)) = (&target.near, target.angle.sin_cos());
        let angle = (R::splat(sine), R::splat(cosine));
        (self.reached, self.inside, self.exact) = (0, 0, 0);
        // Both families have two ways to turn the wrist at the end of each arm.
        let pairs = job.form.branches() / 2;
        let mut first = 0;
        while first < pairs {
            let mut pair = job.form.side_by_side(&goal, job.tool(), angle, &near.preferred, first);
            let (inside, missed) = job.settle(&mut pair, &goal, &near.centre);
            let lanes = R::WIDTH.min(pairs - first);
            for (way, candidate) in pair.iter().enumerate() {
                let (position2, chord2) = missed[way];
                let reached = job.exact.is_near(position2, chord2) & !candidate.merged;
                let exact = is_exact(position2, chord2);
                let rows = &mut self.q[(2 * first + way) * self.joints..];
                for (x, variable) in candidate.q.iter().zip(variables) {
                    for lane in 0..lanes {
                        rows[2 * lane * self.joints + variable] = x.lane(lane);
                    }
                }
                for lane in 0..lanes {
                    let b = 2 * (first + lane) + way;
                    let hit = reached >> lane & 1;
                    self.reached |= hit << b;
                    self.inside |= (inside[way] >> lane & 1) << b;
                    self.exact |= (exact >> lane & 1) << b;
                    self.flags[b] = candidate.flags(lane);
                    self.singular[b] = if hit != 0 { self.flags[b] } else { 0 };
                }
                if let Some((left, choice)) = &mut left {
                    let cost = choice.cost(&candidate.q, &near.centre, job.limits());
                    for lane in 0..lanes {
                        let b = 2 * (first + lane) + way;
                        left.position2[b] = position2.lane(lane);
                        left.chord2[b] = chord2.lane(lane);
                        left.cost[b] = cost.lane(lane);
                    }
                }
            }
            first += R::WIDTH;
        }
        self.status = if self.reached & self.inside != 0 {
            Status::Converged
        } else if !last_search {
            Status::NotFound
        } else {
            let centre = near.centre.map(|x| x.lane(0));
            self.none(job, &target.goal, &centre, left.map(|(left, _)| left))
        };
    }

    /// Leaves only branches that are such beside the others, see [`without_rough`].
    #[inline(always)]
    pub(crate) fn drop_rough(&mut self) {
        let dropped = self.reached & !without_rough(self.reached, self.inside, self.exact);
        self.reached &= !dropped;
        for (b, singular) in self.singular.iter_mut().enumerate() {
            if dropped >> b & 1 != 0 {
                *singular = 0;
            }
        }
    }

    /// Looks once more at a target without a valid branch.
    #[inline(never)]
    fn none(
        &mut self,
        job: &Job<'_>,
        goal: &Goal<f64>,
        centre: &[f64; JOINTS],
        left: Option<&mut Left>,
    ) -> Status {
        if is_out_of_reach(job, goal, false) {
            return Status::OutOfReach;
        }
        let mut branches = [[0.0; JOINTS]; MOST_BRANCHES];
        for (b, branch) in branches.iter_mut().enumerate() {
            for (x, variable) in branch.iter_mut().zip(job.variables()) {
                *x = self.branch(b)[*variable];
            }
        }
        let Some((b, posture)) = last_resort::found(job, goal, centre, &branches) else {
            return Status::NotFound;
        };
        for (x, variable) in posture.q.iter().zip(job.variables()) {
            self.q[b * self.joints + variable] = *x;
        }
        self.reached |= 1 << b;
        self.inside |= 1 << b;
        self.singular[b] = self.flags[b];
        if let Some(left) = left {
            (left.position2[b], left.chord2[b]) = (posture.position2, posture.chord2);
            // The only one: any cost will do.
            left.cost[b] = 0.0;
        }
        Status::Converged
    }

    /// The record of a target that is no pose.
    pub(crate) fn stand_in(&mut self, job: &Job<'_>) {
        for one in self.q.chunks_exact_mut(self.joints).take(self.branches) {
            job.stand_in(one);
        }
        (self.reached, self.inside, self.singular) = (0, 0, [0; MOST_BRANCHES]);
        self.status = Status::BadInput;
    }
}

/// One goal in every lane.
#[inline(always)]
fn everywhere<R: Real>(goal: &Goal<f64>) -> Goal<R> {
    let mut out = Goal::<R>::zero();
    for i in 0..3 {
        out.position[i] = R::splat(goal.position[i]);
        for k in 0..3 {
            out.axes[k][i] = R::splat(goal.axes[k][i]);
        }
    }
    out
}

/// All branches of the first target of a call.
pub fn alone(query: &Query<'_>) -> Box<Alone> {
    let job = query.job();
    // Half a kilobyte that is handed on a few times.
    let mut out = Box::new(Alone::new(&job));
    dispatch(Level::in_use(), Branching { job: &job, query, out: &mut out });
    out
}

/// All branches of the only target of a request for the pose of an arm of six joints with a closed
/// form (eight branches at most) that is none of [`ClosedForm`]; `None` for others.
pub fn alone_of_six(request: &Request<'_>) -> Option<Box<Alone>> {
    let every = Every::of(request.chain()).ok()?;
    if request.len() != 1 || !request.task().fixes_pose() || every.joints() != 6 {
        return None;
    }
    let arm = every.closed()?;
    let call = AnyArm { request: *request, every, lock: None, added: None };
    let level = Level::in_use();
    Some(Alone::filled(6, arm.branches(), |row| call.run(level, arm, row)))
}

struct Branching<'a> {
    job: &'a Job<'a>,
    query: &'a Query<'a>,
    out: &'a mut Alone,
}

impl Kernel for Branching<'_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        match self.query.alone::<R>(self.job, 0) {
            Some(target) => {
                self.out.solve(self.job, &target, self.query.last_search, None);
                self.out.drop_rough();
            }
            None => self.out.stand_in(self.job),
        }
    }
}
