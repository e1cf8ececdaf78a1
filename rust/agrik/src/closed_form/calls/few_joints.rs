//! Arms of fewer joints than a task needs, or just as many where no closed form is at hand:
//! every posture that reaches a target, else those that miss it by least.

use super::any_arm::representative;
use super::branches::{Branches, BranchesMut};
use super::warning;
use crate::call::{Request, Status, Tolerance};
use crate::chain::Reach;
use crate::closed_form::families::short::{Found, Lines, Posture, Room, Short, TURNING, Wish};
use crate::closed_form::geometry::limit::{Limit, SLACK};
use crate::closed_form::geometry::rigid::Rigid;
use crate::error::{Error, Result};
use crate::lanes::Level;
use crate::task::{Task, axis_goal, rotation_scale};
use crate::threads::share;
use std::f64::consts::TAU;

/// Branches of a target in the record.
pub const BRANCHES: usize = 8;
/// Errors up to this share of the arm's size are small enough for a search that proves that
/// there are no other postures; with wider tolerances the nearest ones are answers.
const EXACT: f64 = 1e-4;
/// Joint values in order are told apart by this, rad or m.
const ORDER: f64 = 1e-8;
/// A posture that can move the tool by less than this share of its levers in some way is near a
/// singularity.
const SINGULAR: f64 = 1e-6;

/// A request to an arm of few joints.
pub(super) struct FewJoints<'a> {
    request: Request<'a>,
    lines: &'a Lines,
    short: Short,
    reach: Reach,
    /// The task needs no more joints than there are.
    determined: bool,
    /// Limits of the joints that turn, at the last places, and of the slide.
    limits: [Limit; TURNING],
    slide: Limit,
    /// Largest error that counts as none, m.
    most: f64,
    /// The tolerances leave more than that.
    wide: bool,
}

/// Where joints are that nothing decides: those that turn, at the last places, and the slide.
struct Near {
    q: [f64; TURNING],
    slide: f64,
}

impl<'a> FewJoints<'a> {
    /// The request, if it is one to such an arm.
    pub fn new(request: Request<'a>) -> Option<Self> {
        let chain = request.chain();
        let lines = Lines::of(chain).ok()?;
        let (wish, needed) = match request.task() {
            Task::Position => (Wish::Point, 3),
            Task::Axis { .. } => (Wish::Axis, 5),
            Task::Pose => (Wish::Pose, 6),
            _ => return None,
        };
        let (turning, joints) = (lines.screws.joints.len(), lines.order.len());
        if joints > needed.min(5) || turning > TURNING {
            return None;
        }
        let tail = request.tail();
        let axes = match request.task() {
            Task::Axis { tool_axis } => axis_goal([0.0; 3], tail.direction(tool_axis)).axes,
            _ => Rigid::<f64>::identity().axes,
        };
        let tool = Rigid { axes, shift: tail.translation };
        let reach = Reach::with_tail(chain.compiled(), chain.variables(), tail);
        let per_radian = rotation_scale(reach.size);
        let short = Short::new(lines, &tool, (wish, per_radian), reach.size)?;
        let mut limits = [Limit::FREE; TURNING];
        let mut slide = Limit::FREE;
        for (k, variable) in lines.order.iter().enumerate() {
            let limit = Limit::of(&chain.variables()[*variable]);
            match (TURNING + k).checked_sub(joints) {
                Some(place) if joints - k <= turning => limits[place] = limit,
                _ => slide = limit,
            }
        }
        let allowed = |tolerance: Tolerance| {
            let turn = if wish == Wish::Point { 0.0 } else { per_radian * tolerance.orientation };
            tolerance.position.hypot(turn)
        };
        // Branches keep the smallest of three numbers, proofs hold for the whole of them.
        let most = allowed(request.tolerance().inner()).min(EXACT * reach.size);
        let determined = joints == needed;
        let wide = most < allowed(request.tolerance());
        Some(Self { request, lines, short, reach, determined, limits, slide, most, wide })
    }

    /// The branches of all targets, on `threads` threads. Of those in `known` only targets are
    /// looked at for which nothing was found.
    pub fn solve(
        &self,
        known: Option<Branches>,
        threads: usize,
        poll: &mut dyn FnMut() -> bool,
    ) -> Result<Branches> {
        let (rows, dof) = (self.request.len(), self.request.chain().dof());
        let mut found = known.unwrap_or_else(|| Branches {
            q: vec![0.0; rows * BRANCHES * dof],
            ..Branches::new(rows, BRANCHES)
        });
        found.warnings.resize(rows, 0);
        found.free.resize(rows, -1);
        found.left.resize(rows, 0.0);
        found.off.resize(rows, 0.0);
        let mut q = std::mem::take(&mut found.q);
        let level = Level::in_use();
        let work = |mut rows: BranchesMut<'_>| {
            for i in 0..rows.len() {
                let known = [Status::Converged, Status::JointLimits];
                let known = known.iter().any(|status| *status as u8 == rows.status[i]);
                if !known || rows.warnings[i] & warning::NEAR_SINGULAR != 0 {
                    self.row(level, &mut rows, i);
                }
            }
        };
        let all = found.as_mut_with(&mut q);
        if rows <= 1 {
            work(all);
        } else if !share(all.split(1), threads, &work, poll) {
            return Err(Error::Interrupted);
        }
        found.q = q;
        Ok(found)
    }

    fn near(&self, row: usize) -> Near {
        let (start, most) = (self.request.start(row), self.request.well_known(row));
        let value = |limit: &Limit, variable: usize| match start {
            Some(q0) => limit.reference(q0[variable], most),
            None => limit.middle,
        };
        let mut near = Near { q: [0.0; TURNING], slide: 0.0 };
        let turning = self.lines.screws.joints.len();
        let sliding = self.lines.order.len() - turning;
        for (k, variable) in self.lines.order[sliding..].iter().enumerate() {
            let place = TURNING - turning + k;
            near.q[place] = value(&self.limits[place], *variable);
        }
        if sliding == 1 {
            let variable = self.lines.order[0];
            let value = start.map_or(self.slide.middle, |q0| q0[variable]);
            near.slide = value.clamp(self.slide.lower, self.slide.upper);
        }
        near
    }

    /// What the limits leave to the joints; a whole turn is no limit.
    fn room(&self) -> Room {
        let whole = |limit: &Limit| limit.upper - limit.lower >= TAU;
        Room {
            lower: self.limits.map(|l| if whole(&l) { f64::NEG_INFINITY } else { l.lower }),
            upper: self.limits.map(|l| if whole(&l) { f64::INFINITY } else { l.upper }),
            slide: (self.slide.lower, self.slide.upper),
        }
    }

    /// The branches of target `i` of a run.
    fn row(&self, level: Level, rows: &mut BranchesMut<'_>, i: usize) {
        let row = rows.first + i;
        (rows.warnings[i], rows.free[i]) = (0, -1);
        let count = rows.valid.len() / rows.status.len();
        rows.singular[i * count..(i + 1) * count].fill(0);
        let Some(goal) = self.request.goal(row) else {
            let (dof, rest) = (self.request.chain().dof(), self.request.chain().near_zero());
            for q in rows.q[i * count * dof..][..count * dof].chunks_exact_mut(dof) {
                q.copy_from_slice(&rest);
            }
            rows.status[i] = Status::BadInput as u8;
            (rows.left[i], rows.off[i]) = (f64::INFINITY, f64::INFINITY);
            return;
        };
        let goal = Rigid { axes: goal.axes, shift: goal.position };
        let near = self.near(row);
        let (mut found, free) = self.exact(level, &goal, &near);
        let unproven = found.unproven;
        found.postures.retain(|one| self.is_met(one));
        if found.postures.is_empty() {
            let least = self.short.least(level, &goal, &self.room(), &near.q);
            let met = least.postures.iter().any(|one| self.is_met(one));
            self.write(rows, i, &near, &least, met);
            rows.status[i] = if met {
                Status::Converged
            } else if self.reach.excess(goal.shift) > self.request.tolerance().position {
                Status::OutOfReach
            } else if !self.determined {
                Status::Overdetermined
            } else if unproven || self.wide {
                Status::NotFound
            } else {
                Status::OutOfReach
            } as u8;
            return;
        }
        let weak = |one: &Posture| self.short.weakest(&goal, &Room::FREE, &one.q).0 < SINGULAR;
        let singular = found.postures.iter().any(weak);
        let any = self.write(rows, i, &near, &found, true);
        let variable = free.map(|place| self.lines.order[self.lines.order.len() + place - TURNING]);
        rows.status[i] = match (any, variable) {
            (false, _) => Status::JointLimits,
            (true, Some(_)) => Status::SingularFamily,
            (true, None) => Status::Converged,
        } as u8;
        rows.free[i] = variable.map_or(-1, |variable| variable as i8);
        rows.warnings[i] |= if variable.is_some() { warning::SINGULAR_FAMILY } else { 0 };
        rows.warnings[i] |= if singular { warning::NEAR_SINGULAR } else { 0 };
    }

    fn is_met(&self, one: &Posture) -> bool {
        let tolerance = self.request.tolerance().inner();
        one.position <= tolerance.position && one.orientation <= tolerance.orientation
    }

    /// The postures that reach a goal whatever the limits, and a joint that turns freely: it is
    /// held where it is wanted, if the others can follow it there.
    fn exact(&self, level: Level, goal: &Rigid<f64>, near: &Near) -> (Found, Option<usize>) {
        let mut room = Room::FREE;
        let (mut free, mut kept) = (None, Vec::new());
        for _ in 0..=TURNING {
            let mut found = self.short.exact(level, goal, &room, &near.q, self.most);
            let Some(joint) = found.free else {
                if free.is_some() && found.postures.is_empty() {
                    found.postures = kept;
                }
                return (found, free);
            };
            (room.lower[joint], room.upper[joint]) = (near.q[joint], near.q[joint]);
            free.get_or_insert(joint);
            kept = found.postures;
        }
        (Found { postures: kept, ..Found::default() }, free)
    }

    /// Writes postures as branches (all those that are not `reached` are of least error, the
    /// nearest first), and the first one over again where there are no more; whether
    /// any is within the limits.
    fn write(
        &self,
        rows: &mut BranchesMut<'_>,
        i: usize,
        near: &Near,
        found: &Found,
        reached: bool,
    ) -> bool {
        let (dof, order) = (self.request.chain().dof(), &self.lines.order);
        let count = rows.valid.len() / rows.status.len();
        let turning = self.lines.screws.joints.len();
        let sliding = order.len() - turning;
        let mut each: Vec<(Vec<f64>, bool, f64, &Posture)> = Vec::new();
        for one in &found.postures {
            let (mut q, mut inside, mut far) = (vec![0.0; dof], true, 0.0);
            for (k, variable) in order[sliding..].iter().enumerate() {
                let place = TURNING - turning + k;
                let (centre, limit) = (near.q[place], &self.limits[place]);
                let (x, within) = representative(limit, one.q[place], centre);
                q[*variable] = x;
                inside &= within;
                far += (x - centre).powi(2);
            }
            if sliding == 1 {
                let (lower, upper) = (self.slide.lower, self.slide.upper);
                inside &= lower - SLACK <= one.slide && one.slide <= upper + SLACK;
                q[order[0]] = if inside { one.slide.clamp(lower, upper) } else { one.slide };
                far += (one.slide - near.slide).powi(2);
            }
            each.push((q, inside, far, one));
        }
        // The nearest ones where there are too many, or where none reaches the goal.
        each.sort_by(|a, b| a.2.total_cmp(&b.2));
        if each.len() > count {
            each.truncate(count);
            rows.warnings[i] |= if reached { warning::MORE } else { 0 };
        }
        if reached {
            let place =
                |q: &[f64]| -> Vec<i64> { q.iter().map(|x| (x / ORDER).round() as i64).collect() };
            each.sort_by_cached_key(|one| place(&one.0));
        }
        let best = each.iter().map(|one| one.3).min_by(|a, b| a.error.total_cmp(&b.error));
        let (off, left) =
            best.map_or((f64::INFINITY, f64::INFINITY), |one| (one.position, one.orientation));
        (rows.off[i], rows.left[i]) = (off, left);
        rows.warnings[i] |= if found.unproven { warning::UNPROVEN } else { 0 };
        let mut any = false;
        for b in 0..count {
            let exists = reached && b < each.len();
            let Some((q, inside, ..)) = each.get(b).or(each.first()) else { break };
            rows.q[(i * count + b) * dof..][..dof].copy_from_slice(q);
            rows.reached[i * count + b] = exists;
            rows.valid[i * count + b] = exists && *inside;
            any |= exists && *inside;
        }
        any
    }
}
