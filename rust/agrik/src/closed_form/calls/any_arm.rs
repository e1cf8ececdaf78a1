//! All branches of arms of six joints that turn, and of seven with one of them locked.

use super::added::Added;
use super::branches::{Branches, BranchesMut};
use super::locked::Values;
use super::warning;
use crate::call::{AnswersMut, Outcome, Request, Starts, Status};
use crate::closed_form::families::every::Every;
use crate::closed_form::families::postures::{Set, whole};
use crate::closed_form::families::ring::Work;
use crate::closed_form::families::six::Six;
use crate::closed_form::geometry::enclosure::Margin;
use crate::closed_form::geometry::limit::{Limit, SLACK};
use crate::closed_form::geometry::rigid::Rigid;
use crate::error::{Error, Result};
use crate::kinematics::{Workspace, forward};
use crate::lanes::{Level, norm, sub};
use crate::task::Task;
use crate::threads::share;
use smallvec::SmallVec;
use std::f64::consts::TAU;

/// Targets that a thread takes at a time.
const RUN: usize = 32;

/// A call: the arm, and which joint is locked where.
pub struct AnyArm<'a> {
    /// Targets, tool, start values, tolerances.
    pub request: Request<'a>,
    /// The arm's axes.
    pub every: &'a Every,
    /// Joint along the chain and its values.
    pub lock: Option<(usize, Values<'a>)>,
    /// Joints that the arm lacks.
    pub added: Option<Added>,
}

/// Targets with what was found for them.
#[derive(Default)]
struct Solved {
    goals: Few<Rigid<f64>>,
    near: Few<[f64; 6]>,
    sets: Few<Set>,
    bad: Few<bool>,
}

/// Of a single target without asking for memory.
type Few<T> = SmallVec<[T; 1]>;

impl<'a> AnyArm<'a> {
    /// The arm that stands for all values of the lock.
    fn like(&self) -> Result<&'a Six> {
        let why = |why: &str| {
            let text = format!("'{}' has no branches here: {why}", self.request.chain().name());
            Error::argument("solver", "an arm of joints that turn", text)
        };
        match &self.lock {
            None if self.added.is_none() => self.every.six().map_err(why),
            None => Err(why("it has no six joints")),
            Some((joint, _)) => self.every.locked(*joint).map_err(why),
        }
    }

    /// All branches, on `threads` threads.
    pub fn solve(&self, threads: usize, poll: &mut dyn FnMut() -> bool) -> Result<Branches> {
        let like = match &self.added {
            Some(added) => &added.six,
            None => self.like()?,
        };
        let count = like.branches();
        let rows = self.request.len();
        let dof = self.request.chain().dof();
        let mut q = vec![0.0; rows * count * dof];
        let mut branches = Branches::new(rows, count);
        branches.warnings = vec![0; rows];
        branches.free = vec![-1; rows];
        if self.added.as_ref().is_some_and(|added| added.counts) {
            branches.left = vec![f64::INFINITY; rows];
            branches.off = vec![f64::INFINITY; rows];
        }
        let level = Level::in_use();
        let work = |mut rows: BranchesMut<'_>| self.run(level, like, &mut rows);
        let all = branches.as_mut_with(&mut q);
        if rows <= RUN {
            work(all);
        } else if !share(all.split(RUN), threads, &work, poll) {
            return Err(Error::Interrupted);
        }
        branches.q = q;
        Ok(branches)
    }

    /// Joints that are free along the chain, the first ones of the six.
    fn free(&self) -> ([usize; 6], usize) {
        let locked = self.lock.as_ref().map_or(usize::MAX, |(joint, _)| *joint);
        let free = std::array::from_fn(|k| if k < locked { k } else { k + 1 });
        (free, self.added.as_ref().map_or(6, |added| added.joints))
    }

    /// The branches of a run.
    pub(super) fn run(&self, level: Level, like: &Six, rows: &mut BranchesMut<'_>) {
        let mut solved = Solved::default();
        self.solve_into(level, like, rows.first, rows.len(), &mut solved);
        let Solved { goals, near, sets, bad } = &mut solved;
        for i in 0..rows.len() {
            let least = self.added.as_ref().map(|added| {
                let wish = (&near[i], self.request.tolerance().orientation);
                added.drop(self.every, &goals[i], wish, &mut sets[i])
            });
            self.write(rows, i, &sets[i], &near[i], bad[i]);
            let Some(least) = least.filter(|_| !rows.left.is_empty() && !bad[i]) else { continue };
            let mut told = least.all;
            if rows.status[i] == Status::NotFound as u8 && told.angle.is_finite() {
                told = least.within.unwrap_or(told);
                rows.status[i] = Status::Overdetermined as u8;
                self.write_nearest(rows, i, &told.q, &near[i]);
            }
            (rows.left[i], rows.off[i]) = (told.angle, told.distance);
        }
    }

    /// Writes one posture to all places of target `i` of a run, none of which reaches it.
    fn write_nearest(&self, rows: &mut BranchesMut<'_>, i: usize, q: &[f64; 6], near: &[f64; 6]) {
        let dof = self.request.chain().dof();
        let count = rows.valid.len() / rows.status.len();
        let (free, joints) = self.free();
        for to in rows.q[i * count * dof..][..count * dof].chunks_exact_mut(dof) {
            for (k, joint) in free.into_iter().take(joints).enumerate() {
                let limit = &self.every.limits[joint];
                to[self.every.order[joint]] = representative(limit, q[k], near[k]).0;
            }
        }
    }

    /// The postures of targets `first..first + count`. Sets are large: they are made where they
    /// stay.
    fn solve_into(&self, level: Level, like: &Six, first: usize, count: usize, out: &mut Solved) {
        let (every, (free, joints)) = (self.every, self.free());
        let mut work = Work::default();
        let Solved { goals, near, sets, bad } = out;
        sets.resize(count, Set::EMPTY);
        bad.resize(count, false);
        let unit = Rigid::<f64>::identity();
        let margin = self.margin();
        let given = !matches!(self.request.starts(), Starts::Free);
        let last = every.joints() - 1;
        for (i, bad) in bad.iter_mut().enumerate() {
            let row = first + i;
            let goal = self.goal(row);
            *bad = goal.is_none();
            let mut goal = goal.unwrap_or(unit);
            if let Some((joint, values)) = &self.lock {
                let value = values.row(row);
                let screw = every.screws.joints[*joint];
                if !value.is_finite() {
                    *bad = true;
                } else if *joint == 0 {
                    goal = screw.turn(-value).after(&goal);
                } else if *joint == last {
                    // The tool turns with it, and its own frame with the tool.
                    let seen = screw.moved(&every.screws.tool.inverse());
                    goal = goal.after(&seen.turn(-value));
                }
            }
            goals.push(goal);
            let q0 = self.request.start(row).filter(|_| !*bad);
            let most = self.request.well_known(row);
            let mut about = [0.0; 6];
            for (x, k) in about.iter_mut().zip(&free[..joints]) {
                let limit = &every.limits[*k];
                *x = q0.map_or(limit.middle, |q0| limit.reference(q0[every.order[*k]], most));
            }
            near.push(about);
        }
        match &self.lock {
            Some((joint, values)) if *joint != 0 && *joint != last => {
                // Neighbours with the same value are solved together.
                let mut begin = 0;
                while begin < count {
                    let value = values.row(first + begin);
                    let mut end = begin + 1;
                    while end < count && values.row(first + end) == value {
                        end += 1;
                    }
                    if value.is_finite()
                        && let Ok(six) = Six::new(&every.screws.locked(*joint, value), Some(like))
                    {
                        let range = begin..end;
                        let sets = &mut sets[range.clone()];
                        let near = (&near[range.clone()], given);
                        six.solve(level, (&goals[range], margin), near, sets, &mut work);
                    }
                    begin = end;
                }
            }
            _ => {
                let spread = |added: &Added| near.iter().map(|q| added.spread(q)).collect();
                let wider: Option<Vec<[f64; 6]>> = self.added.as_ref().map(spread);
                let near = wider.as_deref().unwrap_or(near);
                like.solve(level, (goals, margin), (near, given), sets, &mut work);
            }
        }
    }

    /// The branch within the limits that is nearest to the start values (else the middle of the
    /// limits) as the answer to each row of a run; open where there is none.
    pub(crate) fn answer(&self, level: Level, like: &Six, rows: &mut AnswersMut<'_>) {
        let chain = self.request.chain();
        let mut workspace = Workspace::<f64>::new(chain.compiled());
        let (free, _) = self.free();
        let bounds = Bounds::new(free.map(|joint| &self.every.limits[joint]));
        let mut q = vec![0.0; chain.dof()];
        let mut begin = 0;
        while begin < rows.len() {
            let count = RUN.min(rows.len() - begin);
            let mut found = Solved::default();
            self.solve_into(level, like, rows.first + begin, count, &mut found);
            for i in 0..count {
                let row = begin + i;
                let mut best: Option<(f64, [f64; 6])> = None;
                for posture in found.sets[i].postures() {
                    let (one, inside) = bounds.representatives(posture, &found.near[i]);
                    let far = apart(&one, &found.near[i]);
                    if inside && best.is_none_or(|(known, _)| far < known) {
                        best = Some((far, one));
                    }
                }
                let goal = self.request.goal(rows.first + row);
                let (Some((_, posture)), Some(goal)) = (best, goal) else {
                    let status = if found.bad[i] { Status::BadInput } else { Status::NotFound };
                    let answer = rows.finish(row, Outcome::unanswered(status));
                    answer.copy_from_slice(&chain.near_zero());
                    continue;
                };
                for (k, x) in posture.into_iter().enumerate() {
                    q[self.every.order[free[k]]] = x;
                }
                forward(chain.compiled(), &q, &mut workspace);
                let left = self.request.left(&workspace, &goal);
                let near = self.request.aim().is_met(&left);
                let outcome = Outcome {
                    position_error: left.position2.sqrt(),
                    orientation_error: left.orientation2.sqrt(),
                    ..Outcome::unanswered(if near { Status::Converged } else { Status::NotFound })
                };
                rows.finish(row, outcome).copy_from_slice(&q);
            }
            begin += count;
        }
    }

    /// What the tolerances leave to the pose of the last joint's frame.
    fn margin(&self) -> Margin {
        let tolerance = self.request.tolerance();
        // The tool is part of an arm with added joints.
        let tool = if self.added.is_some() { 0.0 } else { norm(self.request.tail().translation) };
        let turn = tolerance.orientation;
        Margin { position: tolerance.position + tool * turn, turn }
    }

    /// Where the last joint's frame has to be; `None` for bad input.
    fn goal(&self, row: usize) -> Option<Rigid<f64>> {
        if let Some((_, values)) = &self.lock
            && !values.row(row).is_finite()
        {
            return None;
        }
        let goal = self.request.goal(row)?;
        if self.added.is_some() {
            let pointed = self.request.task() == Task::Position;
            let axes = if pointed { Rigid::<f64>::identity().axes } else { goal.axes };
            return Some(Rigid { axes, shift: goal.position });
        }
        let pose = Rigid { axes: goal.axes, shift: [0.0; 3] };
        let tool = pose.turn(self.request.tail().translation);
        Some(Rigid { axes: goal.axes, shift: sub(goal.position, tool) })
    }

    /// Writes the postures of target `i` of a run.
    fn write(&self, rows: &mut BranchesMut<'_>, i: usize, set: &Set, near: &[f64; 6], bad: bool) {
        let (every, dof) = (self.every, self.request.chain().dof());
        let count = rows.valid.len() / rows.status.len();
        let (free, joints) = self.free();
        let lock = self.lock.as_ref().map(|(joint, values)| {
            let value = values.row(rows.first + i);
            (every.order[*joint], if value.is_finite() { value } else { 0.0 })
        });
        let mut limits = [&Limit::FREE; 6];
        let mut variables = [0; 6];
        for (k, joint) in free.into_iter().take(joints).enumerate() {
            (limits[k], variables[k]) = (&every.limits[joint], every.order[joint]);
        }
        let bounds = Bounds::new(limits);
        let (mut any, mut reached) = (false, 0);
        let all = &mut rows.q[i * count * dof..][..count * dof];
        for (b, q) in all.chunks_exact_mut(dof).enumerate() {
            if let Some((variable, value)) = lock {
                q[variable] = value;
            }
            let exists = !bad && b < set.count;
            // The place of a branch that does not exist holds what it would be near.
            let (values, within) =
                bounds.representatives(if exists { &set.q[b] } else { near }, near);
            for (variable, x) in variables.iter().zip(&values[..joints]) {
                q[*variable] = *x;
            }
            let inside = exists && within;
            rows.reached[i * count + b] = exists;
            rows.valid[i * count + b] = inside;
            rows.singular[i * count + b] = if exists { set.singular[b] } else { 0 };
            any |= inside;
            reached += u32::from(exists);
        }
        let free_joint =
            (0..joints).find(|k| set.free >> k & 1 != 0).filter(|_| !bad && reached > 0);
        rows.status[i] = if bad {
            Status::BadInput
        } else if any && free_joint.is_some() {
            Status::SingularFamily
        } else if any {
            Status::Converged
        } else if reached > 0 {
            Status::JointLimits
        } else if set.none {
            Status::OutOfReach
        } else {
            Status::NotFound
        } as u8;
        let singular = set.singular[..set.count.min(count)].iter().any(|flags| *flags != 0);
        let mut warnings = 0;
        // Of a pose that asks for too much one posture is the rule.
        let pairs = self.added.is_none() || !self.request.task().fixes_pose();
        for (is, bit) in [
            (pairs && !set.count.is_multiple_of(2), warning::FOLD),
            (singular, warning::NEAR_SINGULAR),
            (set.second, warning::SECOND_CUT),
            (free_joint.is_some(), warning::SINGULAR_FAMILY),
            (set.more, warning::MORE),
        ] {
            warnings |= if is && !bad { bit } else { 0 };
        }
        rows.warnings[i] = warnings;
        rows.free[i] = free_joint.map_or(-1, |k| every.order[free[k]] as i8);
    }
}

/// Limits of six joints, their ends side by side.
struct Bounds<'a> {
    each: [&'a Limit; 6],
    lower: [f64; 6],
    upper: [f64; 6],
}

impl<'a> Bounds<'a> {
    #[inline(always)]
    fn new(each: [&'a Limit; 6]) -> Self {
        Self { each, lower: each.map(|limit| limit.lower), upper: each.map(|limit| limit.upper) }
    }

    /// [`representative`] of each joint of a posture; whether all are within their limits.
    #[inline(always)]
    fn representatives(&self, q: &[f64; 6], centre: &[f64; 6]) -> ([f64; 6], bool) {
        let mut out = [0.0; 6];
        let mut within = true;
        // Mostly the nearest ones are, and then there is no more to do.
        for k in 0..6 {
            out[k] = q[k] + TAU * whole((centre[k] - q[k]) * (1.0 / TAU));
            within &= (self.lower[k] <= out[k]) & (out[k] <= self.upper[k]);
        }
        if within { (out, true) } else { self.others(q, centre) }
    }

    /// The same where some nearest one is outside.
    #[inline(never)]
    fn others(&self, q: &[f64; 6], centre: &[f64; 6]) -> ([f64; 6], bool) {
        let (mut out, mut within) = ([0.0; 6], true);
        for k in 0..6 {
            let inside;
            (out[k], inside) = representative(self.each[k], q[k], centre[k]);
            within &= inside;
        }
        (out, within)
    }
}

/// A joint value less whole turns: within the limits if any is, and then the nearest to a centre
/// (else the one that is outside by the least); whether it is within them.
#[inline]
pub fn representative(limit: &Limit, x: f64, centre: f64) -> (f64, bool) {
    let mut y = x + TAU * whole((centre - x) * (1.0 / TAU));
    if y > limit.upper + SLACK {
        y -= TAU * ((y - limit.upper - SLACK) / TAU).ceil();
    }
    if y < limit.lower - SLACK {
        let up = y + TAU * ((limit.lower - SLACK - y) / TAU).ceil();
        // Outside on either side: the nearer one.
        if up <= limit.upper + SLACK || up - limit.upper < limit.lower - y {
            y = up;
        }
    }
    let held = y.clamp(limit.lower, limit.upper);
    let within = (y - held).abs() <= SLACK;
    (if within { held } else { y }, within)
}

/// Squared distance of two rows of joint values.
pub fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum()
}
