//! Calls: all branches of every target, or, as a [`Solve`], the best branch of each.

use super::branches::{Branches, BranchesMut};
use super::candidates::{BRANCHES, Lanes};
use super::choose::Choice;
use super::settle::Group;
use super::{ClosedForm, arm_angle};
use crate::batch::share;
use crate::chain::Chain;
use crate::error::{Error, Result};
use crate::kinematics::Workspace;
use crate::lanes::{Kernel, Level, Real, dispatch, dispatch_single};
use crate::solve::{AnswersMut, Outcome, Plan, Solve, Starts, Status};
use crate::task::{Goal, rotation_between};

/// Targets of one run: what a thread takes at a time.
const RUN: usize = 256;
/// Up to this many targets are solved one after the other.
const FEW: usize = 2;

/// The arm angles of a call, rad; of no account for arms without one.
#[derive(Debug, Clone, Copy)]
pub enum ArmAngle<'a> {
    /// That of the start values; for the best branch, the best of all arm angles.
    Free,
    /// The same for all targets.
    One(f64),
    /// One a target.
    Each(&'a [f64]),
}

/// A call of a closed form.
#[derive(Debug, Clone)]
pub struct Query<'a> {
    plan: &'a Plan<'a>,
    form: &'a ClosedForm,
    angle: ArmAngle<'a>,
    choice: Choice,
}

impl<'a> Query<'a> {
    /// A checked call for the targets, starts and tolerances of a plan, whose solver
    /// settings are of no account.
    pub fn new(plan: &'a Plan<'a>, angle: ArmAngle<'a>, choice: Choice) -> Result<Self> {
        if !plan.task().fixes_pose() {
            return Err(Error::argument("task", "the full pose, for closed forms", "another task"));
        }
        let form = ClosedForm::of(plan.chain())
            .map_err(|why| Error::argument("solver", "an arm with a closed form", why))?;
        let angles: &[f64] = match &angle {
            ArmAngle::Free => &[],
            ArmAngle::One(x) => std::slice::from_ref(x),
            ArmAngle::Each(all) => all,
        };
        if matches!(angle, ArmAngle::Each(_)) && angles.len() != plan.len() {
            let expected = format!("{} numbers, one a target", plan.len());
            return Err(Error::argument("arm_angle", expected, angles.len()));
        }
        if let Some(bad) = angles.iter().find(|x| !x.is_finite()) {
            return Err(Error::argument("arm_angle", "finite numbers", bad));
        }
        if !angles.is_empty() && !matches!(form, ClosedForm::Srs(_)) {
            let expected = "none, as the arm is not redundant";
            return Err(Error::argument("arm_angle", expected, "arm angles"));
        }
        Ok(Self { plan, form, angle, choice })
    }

    fn chain(&self) -> &'a Chain {
        self.plan.chain()
    }

    #[inline(always)]
    fn group<R: Real>(&self) -> Group<'a, R> {
        Group::new(self.chain(), self.form, *self.plan.tail(), self.plan.tolerance())
    }

    /// Loads targets `first..` into the lanes of a group; returns the lanes that hold a
    /// target and those whose target or start is not finite.
    #[inline(always)]
    fn load<R: Real>(&self, group: &mut Group<'_, R>, first: usize, end: usize) -> (Lanes, Lanes) {
        let dof = self.chain().dof();
        let (mut used, mut bad) = (0, 0);
        for lane in 0..R::WIDTH {
            let row = first + lane;
            if row >= end {
                break;
            }
            used |= 1 << lane;
            let Some(goal) = self.plan.goal(row) else {
                bad |= 1 << lane;
                continue;
            };
            group.goal.set_lane(lane, &goal);
            if let Some(q0) = self.plan.starts().row(row, dof) {
                group.set_centre(lane, q0);
            }
            let angle = match (self.angle, self.form) {
                (ArmAngle::One(x), _) => x,
                (ArmAngle::Each(all), _) => all[row],
                (ArmAngle::Free, ClosedForm::Srs(arm)) => {
                    self.plan.starts().row(row, dof).map_or(0.0, |q0| arm.arm_angle(q0))
                }
                _ => continue,
            };
            let (s, c) = angle.sin_cos();
            group.angle.0.set_lane(lane, s);
            group.angle.1.set_lane(lane, c);
        }
        if !matches!(self.plan.starts(), Starts::Free) {
            group.prefer();
        }
        (used, bad)
    }
}

/// All branches of every target, on `threads` threads (0: the number in force); `poll` as
/// for [`crate::batch::solve`].
pub fn all(query: &Query<'_>, threads: usize, poll: &mut dyn FnMut() -> bool) -> Result<Branches> {
    all_at(Level::in_use(), query, threads, poll)
}

/// [`all`] with the instructions of a given level.
pub fn all_at(
    level: Level,
    query: &Query<'_>,
    threads: usize,
    poll: &mut dyn FnMut() -> bool,
) -> Result<Branches> {
    let mut q = vec![0.0; query.plan.len() * BRANCHES * query.chain().dof()];
    let mut branches = all_into_at(level, query, &mut q, threads, poll)?;
    branches.q = q;
    Ok(branches)
}

/// [`all`] with the joint values written to `q` ([`BRANCHES`] times `dof` numbers a
/// target) and not to the record.
pub fn all_into(
    query: &Query<'_>,
    q: &mut [f64],
    threads: usize,
    poll: &mut dyn FnMut() -> bool,
) -> Result<Branches> {
    all_into_at(Level::in_use(), query, q, threads, poll)
}

fn all_into_at(
    level: Level,
    query: &Query<'_>,
    q: &mut [f64],
    threads: usize,
    poll: &mut dyn FnMut() -> bool,
) -> Result<Branches> {
    let wanted = query.plan.len() * BRANCHES * query.chain().dof();
    if q.len() != wanted {
        return Err(Error::argument("q", format!("room for {wanted} numbers"), q.len()));
    }
    let mut branches = Branches::new(query.plan.len());
    let rows = branches.as_mut_with(q);
    let runs = if rows.len() <= RUN { vec![rows] } else { rows.split(RUN) };
    let few = query.plan.len() <= FEW;
    let work = |mut rows: BranchesMut<'_>| {
        if few {
            dispatch(level, AllFew { query, rows: &mut rows });
        } else {
            dispatch(level, All { query, rows: &mut rows });
        }
    };
    if share(runs, threads, &work, poll) { Ok(branches) } else { Err(Error::Interrupted) }
}

impl Solve for Query<'_> {
    fn rows(&self) -> usize {
        self.plan.len()
    }
    fn dof(&self) -> usize {
        self.chain().dof()
    }
    fn run_length(&self) -> usize {
        RUN
    }
    /// The best branch of every target.
    fn run<'a>(
        &self,
        level: Level,
        next: &mut dyn FnMut() -> Option<AnswersMut<'a>>,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> bool {
        while let Some(mut rows) = next() {
            // One call may hand out all of its rows at once.
            let mut done = 0;
            while done < rows.len() {
                let end = rows.len().min(done + RUN);
                let kernel = One { query: self, rows: &mut rows, begin: done, end };
                if end - done <= FEW {
                    dispatch_single(level, kernel);
                } else {
                    dispatch(level, kernel);
                }
                done = end;
                if !keep_going() {
                    return false;
                }
            }
        }
        true
    }
}

/// [`all`] as a kernel.
struct All<'k, 'a> {
    query: &'k Query<'k>,
    rows: &'k mut BranchesMut<'a>,
}

impl Kernel for All<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        let (query, rows) = (self.query, self.rows);
        let mut group = query.group::<R>();
        let end = rows.first + rows.len();
        let mut row = rows.first;
        while row < end {
            let (used, bad) = query.load(&mut group, row, end);
            group.solve();
            for lane in 0..R::WIDTH {
                if used >> lane & 1 != 0 {
                    let bad = bad >> lane & 1 != 0;
                    write(&group, lane, bad, rows, row - rows.first + lane);
                }
            }
            row += R::WIDTH;
        }
    }
}

/// [`all`] for a few targets: one at a time, its branches checked side by side.
struct AllFew<'k, 'a> {
    query: &'k Query<'k>,
    rows: &'k mut BranchesMut<'a>,
}

impl Kernel for AllFew<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        let (query, rows) = (self.query, self.rows);
        let mut group = query.group::<R::Single>();
        let mut workspace = Workspace::<R>::new(query.chain().compiled());
        let end = rows.first + rows.len();
        for row in rows.first..end {
            let (_, bad) = query.load(&mut group, row, end);
            if bad == 0 {
                group.solve_with(&mut workspace);
            }
            write(&group, 0, bad != 0, rows, row - rows.first);
        }
    }
}

/// Writes one lane as target `i` of a run.
#[inline(always)]
fn write<R: Real>(
    group: &Group<'_, R>,
    lane: usize,
    bad: bool,
    rows: &mut BranchesMut<'_>,
    i: usize,
) {
    let joints = group.joints;
    let q = &mut rows.q[i * BRANCHES * joints..(i + 1) * BRANCHES * joints];
    if bad {
        rows.status[i] = Status::BadInput as u8;
        for one in q.chunks_exact_mut(joints) {
            group.stand_in(one);
        }
        return;
    }
    let variables = group.variables();
    let (mut any_valid, mut any_reached) = (false, false);
    for (b, one) in q.chunks_exact_mut(joints).enumerate() {
        let candidate = &group.candidates[b];
        for (x, variable) in candidate.q.iter().zip(variables) {
            one[*variable] = x.lane(lane);
        }
        let reached = group.reached[b] >> lane & 1 != 0;
        let valid = reached && group.inside[b] >> lane & 1 != 0;
        any_reached |= reached;
        any_valid |= valid;
        rows.reached[i * BRANCHES + b] = reached;
        rows.valid[i * BRANCHES + b] = valid;
        rows.singular[i * BRANCHES + b] = if reached { candidate.flags(lane) } else { 0 };
    }
    rows.status[i] = status(group.form, any_valid, any_reached) as u8;
}

/// What the branches of a target say about it. Where even without limits there is none,
/// or the branches are all there is, no solution exists.
fn status(form: &ClosedForm, any_valid: bool, any_reached: bool) -> Status {
    match (any_valid, any_reached, form) {
        (true, ..) => Status::Converged,
        (_, true, ClosedForm::Srs(_)) => Status::NotFound,
        _ => Status::OutOfReach,
    }
}

/// The best branch of rows `begin..end` of a run.
struct One<'k, 'a> {
    query: &'k Query<'k>,
    rows: &'k mut AnswersMut<'a>,
    begin: usize,
    end: usize,
}

impl Kernel for One<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        let (query, rows) = (self.query, self.rows);
        let mut group = query.group::<R>();
        let free = match (query.form, query.angle) {
            (ClosedForm::Srs(arm), ArmAngle::Free) => Some(arm),
            _ => None,
        };
        let mut i = self.begin;
        while i < self.end {
            let (used, bad) = query.load(&mut group, rows.first + i, rows.first + self.end);
            let mut proven = 0;
            if let Some(arm) = free {
                proven = arm_angle::search(arm, &mut group, query.choice, used & !bad);
            }
            group.solve();
            let mut valid = [0; BRANCHES];
            for (b, lanes) in valid.iter_mut().enumerate() {
                *lanes = group.valid(b);
            }
            let best = query.choice.pick(&group, &valid);
            for lane in 0..R::WIDTH {
                if used >> lane & 1 == 0 {
                    continue;
                }
                let branch = (best.found >> lane & 1 != 0).then(|| best.branch.lane(lane) as usize);
                let row = i + lane;
                if bad >> lane & 1 != 0 {
                    group.stand_in(rows.finish(row, unfinished(Status::BadInput)));
                } else {
                    answer(&group, lane, branch, proven >> lane & 1 != 0, rows, row);
                }
            }
            i += R::WIDTH;
        }
    }
}

fn unfinished(status: Status) -> Outcome {
    Outcome {
        status,
        position_error: f64::INFINITY,
        orientation_error: f64::INFINITY,
        iterations: 0,
        restarts: 0,
    }
}

/// Writes the chosen branch of a lane; without any, the one that violates least, held
/// inside the limits. `proven`: no arm angle has a branch inside the limits.
#[inline(always)]
fn answer<R: Real>(
    group: &Group<'_, R>,
    lane: usize,
    branch: Option<usize>,
    proven: bool,
    rows: &mut AnswersMut<'_>,
    i: usize,
) {
    let Some(b) = branch else {
        return nearest(group, lane, proven, rows, i);
    };
    let mut outcome = unfinished(Status::Converged);
    outcome.position_error = group.position2[b].lane(lane).sqrt();
    outcome.orientation_error = 2.0 * (0.125 * group.chord2[b].lane(lane)).sqrt().min(1.0).asin();
    let q = rows.finish(i, outcome);
    for (x, variable) in group.candidates[b].q.iter().zip(group.variables()) {
        q[*variable] = x.lane(lane);
    }
}

#[inline(never)]
fn nearest<R: Real>(
    group: &Group<'_, R>,
    lane: usize,
    proven: bool,
    rows: &mut AnswersMut<'_>,
    i: usize,
) {
    let joints = group.joints;
    let any_reached = group.reached.iter().any(|lanes| lanes >> lane & 1 != 0);
    let mut best = (f64::INFINITY, 0);
    for (b, candidate) in group.candidates.iter().enumerate() {
        let outside = (0..joints).map(|j| {
            let (x, limit) = (candidate.q[j].lane(lane), group.limits[j]);
            (limit.lower - x).max(x - limit.upper).max(0.0)
        });
        let total: f64 = outside.sum();
        if total < best.0 {
            best = (total, b);
        }
    }
    let status = if proven { Status::OutOfReach } else { status(group.form, false, any_reached) };
    let mut q = [0.0; super::JOINTS];
    let candidate = &group.candidates[best.1];
    for (j, variable) in group.variables().iter().enumerate() {
        let limit = group.limits[j];
        q[*variable] = candidate.q[j].lane(lane).clamp(limit.lower, limit.upper);
    }
    let goal = Goal {
        position: group.goal.position.map(|x| x.lane(lane)),
        axes: group.goal.axes.map(|axis| axis.map(|x| x.lane(lane))),
    };
    let mut outcome = unfinished(status);
    let (axes, point) = group.pose(&q[..joints]);
    let way = crate::lanes::sub(point, goal.position);
    let turn = rotation_between(axes, goal.axes);
    outcome.position_error = crate::lanes::dot(way, way).sqrt();
    outcome.orientation_error = crate::lanes::dot(turn, turn).sqrt();
    rows.finish(i, outcome).copy_from_slice(&q[..joints]);
}
