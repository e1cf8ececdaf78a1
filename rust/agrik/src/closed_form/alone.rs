//! One target at a time: its branches stand side by side in the lanes, so that a single
//! call takes hardly longer than one branch would. A branch gets, bit for bit, the values
//! that it gets in a batch, where a lane holds a target.

use super::candidates::{BRANCHES, JOINTS, Lanes};
use super::choose::Choice;
use super::last_resort;
use super::query::{ArmAngle, arm_angles};
use super::settle::{Job, Near};
use super::{ClosedForm, query};
use crate::chain::{Chain, Tail};
use crate::error::{Error, Result};
use crate::lanes::{Kernel, Level, Real, dispatch};
use crate::solve::{Status, Tolerance};
use crate::task::{Goal, pose_goal};

/// Pairs of branches: the two ways to turn a wrist at the end of an arm.
const PAIRS: usize = BRANCHES / 2;

/// The branches of one target.
#[derive(Debug, Clone)]
pub struct Alone {
    joints: usize,
    q: [f64; BRANCHES * JOINTS],
    /// One bit a branch.
    pub(super) reached: Lanes,
    inside: Lanes,
    singular: [u8; BRANCHES],
    /// The same of branches that are not reached.
    flags: [u8; BRANCHES],
    status: Status,
}

/// What is left between each branch and the target, and what the branch costs.
#[derive(Debug, Clone)]
pub(super) struct Left {
    /// Squared distance, m^2.
    pub position2: [f64; BRANCHES],
    /// Squared chord between the wanted and the present axes.
    pub chord2: [f64; BRANCHES],
    /// Cost by a choice.
    pub cost: [f64; BRANCHES],
}

impl Left {
    /// Nothing known.
    pub fn new() -> Self {
        let far = [f64::INFINITY; BRANCHES];
        Self { position2: far, chord2: far, cost: far }
    }
}

impl Alone {
    /// No branch yet.
    pub(super) fn new(joints: usize) -> Self {
        Self {
            joints,
            q: [0.0; BRANCHES * JOINTS],
            reached: 0,
            inside: 0,
            singular: [0; BRANCHES],
            flags: [0; BRANCHES],
            status: Status::BadInput,
        }
    }

    /// Joint values, [`BRANCHES`] rows of `dof`, rad; as in [`super::Branches`].
    #[inline(always)]
    pub fn q(&self) -> &[f64] {
        &self.q[..BRANCHES * self.joints]
    }

    /// Joint values of a branch, rad.
    #[inline(always)]
    pub(super) fn branch(&self, b: usize) -> &[f64] {
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
    pub(super) fn best(&self, left: &Left) -> Option<usize> {
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
    pub(super) fn solve<R: Real>(
        &mut self,
        job: &Job<'_>,
        target: &Target<R>,
        mut left: Option<(&mut Left, Choice)>,
    ) {
        let variables = job.variables();
        let goal = everywhere::<R>(&target.goal);
        let (near, (sine, cosine)) = (&target.near, target.angle.sin_cos());
        let angle = (R::splat(sine), R::splat(cosine));
        (self.reached, self.inside) = (0, 0);
        let mut first = 0;
        while first < PAIRS {
            let mut pair = job.form.side_by_side(&goal, job.tool(), angle, &near.preferred, first);
            let (inside, missed) = job.settle(&mut pair, &goal, &near.centre);
            let lanes = R::WIDTH.min(PAIRS - first);
            for (way, candidate) in pair.iter().enumerate() {
                let (position2, chord2) = missed[way];
                let reached = job.exact.is_near(position2, chord2) & !candidate.merged;
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
        } else {
            self.none(job, &target.goal, left.map(|(left, _)| left))
        };
    }

    /// Looks once more at a target without a valid branch.
    #[inline(never)]
    fn none(&mut self, job: &Job<'_>, goal: &Goal<f64>, left: Option<&mut Left>) -> Status {
        let mut branches = [[0.0; JOINTS]; BRANCHES];
        for (b, branch) in branches.iter_mut().enumerate() {
            for (x, variable) in branch.iter_mut().zip(job.variables()) {
                *x = self.branch(b)[*variable];
            }
        }
        let Some((b, posture)) = last_resort::found(job, goal, &branches, job.may_step()) else {
            return last_resort::status(job, goal, false);
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
    pub(super) fn stand_in(&mut self, job: &Job<'_>) {
        for one in self.q.chunks_exact_mut(self.joints).take(BRANCHES) {
            job.stand_in(one);
        }
        (self.reached, self.inside, self.singular) = (0, 0, [0; BRANCHES]);
        self.status = Status::BadInput;
    }
}

/// One target, and what its answers stay near.
pub(super) struct Target<R> {
    pub goal: Goal<f64>,
    pub near: Near<R>,
    /// Arm angle, rad.
    pub angle: f64,
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

/// A call for the branches of one pose.
#[derive(Debug, Clone, Copy)]
pub struct Single<'a> {
    /// The arm.
    pub chain: &'a Chain,
    /// The target, a 4x4 matrix row by row.
    pub pose: &'a [f64; 16],
    /// Tool in the last joint's frame, in place of the chain's own.
    pub tail: Option<Tail>,
    /// How near is near enough.
    pub tolerance: Tolerance,
    /// What the answers stay near, rad.
    pub q0: Option<&'a [f64]>,
    /// Arm angle of an S-R-S arm, rad; else that of `q0`, or 0.
    pub arm_angle: Option<f64>,
}

impl Single<'_> {
    /// The call, checked.
    pub(super) fn job(&self) -> Result<Job<'_>> {
        let chain = self.chain;
        let form = query::form_of(chain)?;
        self.tolerance.check()?;
        if let Some(q0) = self.q0
            && q0.len() != chain.dof()
        {
            return Err(Error::argument("q0", format!("{} numbers", chain.dof()), q0.len()));
        }
        arm_angles(form, self.arm_angle.map_or(ArmAngle::Free, ArmAngle::One), 1)?;
        let tail = self.tail.unwrap_or(chain.compiled().tail);
        Ok(Job::new(chain, form, tail, self.tolerance))
    }

    /// The target in every lane; `None` where it or its start is not finite.
    #[inline(always)]
    pub(super) fn target<R: Real>(&self, job: &Job<'_>) -> Option<Target<R>> {
        let m = self.pose;
        let finite = |numbers: &[f64]| numbers.iter().all(|x| x.is_finite());
        if !finite(m) || !self.q0.is_none_or(finite) {
            return None;
        }
        let rotation = [0, 1, 2].map(|j| [m[j], m[4 + j], m[8 + j]]);
        let angle = match (self.arm_angle, job.form, self.q0) {
            (Some(angle), ..) => angle,
            (None, ClosedForm::Srs(arm), Some(q0)) => arm.arm_angle(q0),
            _ => 0.0,
        };
        Some(Target {
            goal: pose_goal([m[3], m[7], m[11]], rotation, &job.exact.tail),
            near: Near::to(job.geometry, self.q0),
            angle,
        })
    }
}

/// All branches of one pose: what [`super::all`] finds, without a plan.
pub fn alone(single: &Single<'_>) -> Result<Box<Alone>> {
    let job = single.job()?;
    // Half a kilobyte that is handed on a few times.
    let mut out = Box::new(Alone::new(job.variables().len()));
    dispatch(Level::in_use(), Branching { job: &job, single, out: &mut out });
    Ok(out)
}

struct Branching<'a> {
    job: &'a Job<'a>,
    single: &'a Single<'a>,
    out: &'a mut Alone,
}

impl Kernel for Branching<'_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        match self.single.target::<R>(self.job) {
            Some(target) => self.out.solve(self.job, &target, None),
            None => self.out.stand_in(self.job),
        }
    }
}
