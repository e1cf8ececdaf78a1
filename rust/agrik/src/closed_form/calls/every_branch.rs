//! All branches of any arm: which family is asked, joints locked or swept, and values a whole
//! turn apart.

use std::f64::consts::TAU;

use super::added::Added;
use super::all_branches::all;
use super::any_arm::AnyArm;
use super::arm_angle::ArmAngle;
use super::branches::Branches;
use super::family::Family;
use super::few_joints::FewJoints;
use super::locked::{Lock, Values, all_locked};
use super::query::Query;
use super::wrap::wrapped;
use crate::call::{Goals, Request, Starts, Status};
use crate::chain::{Chain, Reach};
use crate::closed_form::branch::choice::Choice;
use crate::closed_form::families::every::Every;
use crate::closed_form::families::six::Way;
use crate::closed_form::families::{ClosedForm, Lead};
use crate::closed_form::geometry::limit::Limit;
use crate::error::{Error, Result};
use crate::task::{Goal, Task};

/// Most values of a sweep.
pub const MOST_VALUES: usize = 100_000;

/// What is asked besides the targets.
#[derive(Debug, Clone, Copy)]
pub struct Ask<'a> {
    /// Joints that stand still.
    pub locks: &'a [Lock<'a>],
    /// Arm angle of an S-R-S arm.
    pub angle: ArmAngle<'a>,
    /// So many values of the free joint or arm angle, over its limits.
    pub sweep: Option<usize>,
    /// Every value a whole turn apart that the limits allow is a branch of its own.
    pub wrap: bool,
}

/// All branches of the targets of a request, on `threads` threads; `poll` as for
/// [`crate::call::solve`].
pub fn every(
    request: &Request<'_>,
    ask: &Ask<'_>,
    threads: usize,
    poll: &mut dyn FnMut() -> bool,
) -> Result<Branches> {
    let found = match ask.sweep {
        None => at_values(request, ask.locks, ask.angle, threads, poll)?,
        Some(count) => swept(request, ask, count, threads, poll)?,
    };
    Ok(if ask.wrap { wrapped(request, ask.locks, found) } else { found })
}

/// The branches at the values of the locks; a joint of seven that nobody locked stays where the
/// start values have it.
fn at_values(
    request: &Request<'_>,
    locks: &[Lock<'_>],
    angle: ArmAngle<'_>,
    threads: usize,
    poll: &mut dyn FnMut() -> bool,
) -> Result<Branches> {
    let chain = request.chain();
    let free = chain.dof() - locks.len().min(chain.dof());
    if !request.task().fixes_pose() || free < 6 {
        no_arm_angle(angle)?;
        return with_few_joints(request, locks, threads, poll);
    }
    let every = Every::of(chain);
    match locks {
        [] if ClosedForm::of(chain).is_ok_and(|form| !form.is_rough()) => {
            all(&Query::new(*request, angle, Choice::default())?, threads, poll)
        }
        [one] if free == 6 && ClosedForm::of(chain).is_err() && every.is_ok() => {
            super::locked::checked(request, locks)?;
            no_arm_angle(angle)?;
            let Ok(every) = every else { return unsupported(request) };
            let joint = every.order.iter().position(|variable| *variable == one.variable);
            let lock = joint.map(|joint| (joint, one.values));
            AnyArm { request: *request, every, lock, added: None }.solve(threads, poll)
        }
        [] => {
            let Ok(every) = every else {
                // A slide at the base is a joint to lock, one inside is not.
                return match Lead::of(chain) {
                    Ok(lead) if lead.way().is_some() && rest_is_known(lead.rest()) => {
                        let slide = &chain.variables()[lead.variable()].name;
                        let expected = format!("a value of the slide '{slide}', or `sweep`");
                        Err(Error::argument("locked", expected, "neither"))
                    }
                    _ => unsupported(request),
                };
            };
            no_arm_angle(angle)?;
            let values: Vec<f64>;
            let lock = match every.joints() {
                6 => None,
                7 => {
                    let joint = every.default_lock();
                    let variable = every.order[joint];
                    let limit = every.limits[joint];
                    let of = |row| {
                        let (start, most) = (request.start(row), request.well_known(row));
                        start.map_or(limit.middle, |q0| limit.reference(q0[variable], most))
                    };
                    values = (0..request.len()).map(of).collect();
                    Some((joint, Values::Each(&values)))
                }
                _ => return unsupported(request),
            };
            let chosen = lock.is_some();
            let arm = AnyArm { request: *request, every, lock, added: None };
            let mut found = arm.solve(threads, poll)?;
            if chosen {
                without_proof(&mut found, request);
            }
            Ok(found)
        }
        [one] if is_elbow(chain, one.variable) => {
            let poses = super::locked::checked(request, locks)?;
            let mut found = all(&Query::new(*request, angle, Choice::default())?, threads, poll)?;
            at_elbow(&mut found, one, poses.len(), chain.dof());
            Ok(found)
        }
        _ => all_locked(request, locks, angle, threads, poll),
    }
}

/// The entry of `q` is the elbow of an S-R-S arm: locked, it leaves the arm angle free and the
/// distance of the wrist fixed.
fn is_elbow(chain: &Chain, variable: usize) -> bool {
    let form = ClosedForm::of(chain).ok().filter(|form| matches!(form, ClosedForm::Srs(_)));
    form.is_some_and(|form| form.geometry().variables.get(3) == Some(&variable))
}

/// An elbow within this of its locked value is there, rad.
const AT_VALUE: f64 = 1e-6;

/// Leaves the branches whose elbow is at its locked value.
fn at_elbow(found: &mut Branches, lock: &Lock<'_>, rows: usize, dof: usize) {
    found.warnings = vec![0; rows];
    found.free = vec![-1; rows];
    for row in 0..rows {
        let (value, mut any) = (lock.values.row(row), false);
        for b in row * found.branches..(row + 1) * found.branches {
            let x = found.q[b * dof + lock.variable];
            let there = (x - value).abs() < AT_VALUE;
            found.reached[b] &= there;
            found.valid[b] &= there;
            any |= found.valid[b];
        }
        if found.status[row] == Status::BadInput as u8 {
            continue;
        }
        let status = match (value.is_nan(), any) {
            (true, _) => Status::BadInput,
            (_, true) => Status::SingularFamily,
            (_, false) => Status::NotFound,
        };
        found.status[row] = status as u8;
        if any {
            found.warnings[row] = super::warning::SINGULAR_FAMILY;
            found.free[row] = 0;
        }
    }
}

fn rest_is_known(rest: &Chain) -> bool {
    let six = |every: &Every| every.joints() == 6 && every.six().is_ok();
    ClosedForm::of(rest).is_ok() || Every::of(rest).is_ok_and(six)
}

fn no_arm_angle(angle: ArmAngle<'_>) -> Result<()> {
    match angle {
        ArmAngle::Free => Ok(()),
        _ => {
            let expected = "none, but for full poses of S-R-S arms";
            Err(Error::argument("arm_angle", expected, "arm angles"))
        }
    }
}

/// Tasks that ask for less than a pose, and arms that can do no more.
fn with_few_joints(
    request: &Request<'_>,
    locks: &[Lock<'_>],
    threads: usize,
    poll: &mut dyn FnMut() -> bool,
) -> Result<Branches> {
    let chain = request.chain();
    if !locks.is_empty() {
        let Goals::Positions { points, direction: None } = request.goals() else {
            return all_locked(request, locks, ArmAngle::Free, threads, poll);
        };
        // Points as poses of which the position counts.
        let pose = |p: &[f64; 3]| {
            let [x, y, z] = *p;
            [1., 0., 0., x, 0., 1., 0., y, 0., 0., 1., z, 0., 0., 0., 1.]
        };
        let poses: Vec<[f64; 16]> = points.iter().map(pose).collect();
        let goals = Goals::Poses(&poses);
        let all = Request::new(chain, *request.aim(), goals, request.starts())?;
        return all_locked(&all, locks, ArmAngle::Free, threads, poll);
    }
    if matches!(request.task(), Task::Masked { .. }) {
        return Err(Error::argument("task", "position, axis or pose", "a masked task"));
    }
    match solved_without_locks(request, threads, poll)? {
        Some(found) => Ok(found),
        None => unsupported(request),
    }
}

/// The branches of an arm of few joints, none of them locked; `None` where nothing here finds
/// them.
pub(super) fn solved_without_locks(
    request: &Request<'_>,
    threads: usize,
    poll: &mut dyn FnMut() -> bool,
) -> Result<Option<Branches>> {
    let few = FewJoints::new(*request);
    if let Ok(every) = Every::of(request.chain()) {
        if request.task() == Task::Position && every.joints() > 3 {
            return with_spare_joints(request, every, threads, poll).map(Some);
        }
        // A point that three joints cannot move in three ways makes no closed form.
        let fits = |added: &Added| few.is_none() || !matches!(added.six.way(), Way::Ring(_));
        if let Some(added) = Added::new(request, every).ok().filter(fits) {
            let arm = AnyArm { request: *request, every, lock: None, added: Some(added) };
            let found = arm.solve(threads, poll)?;
            // A pose for three joints: what reaches the point decides, where anything does.
            return match few.filter(|_| request.task().fixes_pose()) {
                Some(few) => few.solve(Some(found), threads, poll).map(Some),
                None => Ok(Some(found)),
            };
        }
    }
    if let Some(few) = few {
        return few.solve(None, threads, poll).map(Some);
    }
    with_a_spare_slide(request, threads, poll)
}

/// An arm behind a slide with a joint to spare: the slide stays where the start values have it
/// (else in the middle of its limits).
fn with_a_spare_slide(
    request: &Request<'_>,
    threads: usize,
    poll: &mut dyn FnMut() -> bool,
) -> Result<Option<Branches>> {
    let Ok(lead) = Lead::of(request.chain()) else { return Ok(None) };
    let needed = match request.task() {
        Task::Position => 3,
        Task::Axis { .. } => 5,
        _ => return Ok(None),
    };
    let rest = lead.rest().dof();
    if lead.way().is_none() || rest < needed || rest > 5 || Every::of(lead.rest()).is_err() {
        return Ok(None);
    }
    let slide = &request.chain().variables()[lead.variable()];
    let limit = Limit::of(slide);
    let of = |row: usize| {
        let place = request.start(row).map_or(limit.middle, |q0| q0[lead.variable()]);
        place.clamp(limit.lower, limit.upper)
    };
    let values: Vec<f64> = (0..request.len()).map(of).collect();
    let locks = [Lock { variable: lead.variable(), values: Values::Each(&values) }];
    let mut found = with_few_joints(request, &locks, threads, poll)?;
    said_to_be_free(&mut found, request, lead.variable());
    Ok(Some(found))
}

/// A point for more than three joints: those that move it best are free, the others stay where
/// the start values have them (else in the middle of their limits). Each of these turns freely,
/// but for those that their limits hold.
fn with_spare_joints(
    request: &Request<'_>,
    every: &Every,
    threads: usize,
    poll: &mut dyn FnMut() -> bool,
) -> Result<Branches> {
    let spare: Vec<usize> = (0..every.joints()).filter(|k| !every.movers.contains(k)).collect();
    let value = |k: usize, row: usize| {
        let limit = &every.limits[k];
        let q0 = request.start(row).map_or(limit.middle, |q0| q0[every.order[k]]);
        q0.clamp(limit.lower, limit.upper)
    };
    let column = |k: &usize| (0..request.len()).map(|row| value(*k, row)).collect();
    let values: Vec<Vec<f64>> = spare.iter().map(column).collect();
    let mut locks = Vec::with_capacity(spare.len());
    for (k, all) in spare.iter().zip(&values) {
        locks.push(Lock { variable: every.order[*k], values: Values::Each(all) });
    }
    let mut found = with_few_joints(request, &locks, threads, poll)?;
    let turns = |k: &&usize| every.limits[**k].lower < every.limits[**k].upper;
    if let Some(free) = spare.iter().find(turns) {
        said_to_be_free(&mut found, request, every.order[*free]);
    }
    Ok(found)
}

/// Reached targets whose joint `variable` could be anywhere, and others that could be reached with
/// it elsewhere.
fn said_to_be_free(found: &mut Branches, request: &Request<'_>, variable: usize) {
    let rows = request.len();
    without_proof(found, request);
    found.warnings.resize(rows, 0);
    found.free.resize(rows, -1);
    for row in 0..rows {
        let reached = [Status::Converged, Status::SingularFamily];
        if reached.iter().any(|status| *status as u8 == found.status[row]) {
            found.status[row] = Status::SingularFamily as u8;
            found.warnings[row] |= super::warning::SINGULAR_FAMILY;
            found.free[row] = variable as i8;
        }
    }
}

/// What is proven of an arm with a joint held where nobody asked for it is proven of that place
/// alone: of the whole arm that its bounds exclude the target, if they do.
fn without_proof(found: &mut Branches, request: &Request<'_>) {
    let proofs = [Status::OutOfReach, Status::JointLimits, Status::Overdetermined];
    let proofs = proofs.map(|status| status as u8);
    if !found.status.iter().any(|status| proofs.contains(status)) {
        return;
    }
    let chain = request.chain();
    let reach = Reach::with_tail(chain.compiled(), chain.variables(), request.tail());
    let most = request.tolerance().position;
    for (row, status) in found.status.iter_mut().enumerate() {
        let excluded = |goal: Goal<f64>| reach.excess(goal.position) > most;
        if proofs.contains(status) && !request.goal(row).is_some_and(excluded) {
            *status = Status::NotFound as u8;
        }
    }
}

/// Why the nearest posture is not looked for among all branches of an arm without a joint to
/// spare. Not all that [`every`] finds branches of are meant: arms of few joints are searched from
/// starts instead.
pub fn reason(request: &Request<'_>) -> Option<String> {
    let every = match Every::of(request.chain()) {
        Ok(every) => every,
        Err(why) => return Some(why.to_owned()),
    };
    match every.joints() {
        6 | 7 if request.task().fixes_pose() => None,
        4.. if request.task() == Task::Position => None,
        _ => Added::new(request, every).err(),
    }
}

/// A record that says of each target that nothing here solves the arm.
fn unsupported(request: &Request<'_>) -> Result<Branches> {
    let (rows, rest) = (request.len(), request.chain().near_zero());
    let mut branches = Branches::new(rows, 1);
    branches.q = rest.repeat(rows);
    for (row, status) in branches.status.iter_mut().enumerate() {
        let known = request.goal(row).is_some();
        *status = if known { Status::Unsupported } else { Status::BadInput } as u8;
    }
    Ok(branches)
}

/// The free quantity of a sweep.
enum Free {
    ArmAngle,
    /// An entry of `q`, with its limits.
    Joint(usize, Limit),
}

fn free_of(request: &Request<'_>, ask: &Ask<'_>) -> Result<Free> {
    let chain = request.chain();
    let refuse = |received: &str| {
        let expected = "an arm with one joint more than the pose needs, and none of them locked";
        Error::argument("sweep", expected, received)
    };
    if !ask.locks.is_empty() {
        return Err(refuse("locked joints"));
    }
    if !matches!(ask.angle, ArmAngle::Free) {
        return Err(refuse("an arm angle"));
    }
    if !request.task().fixes_pose() {
        return Err(refuse("a task other than the full pose"));
    }
    if let Ok(ClosedForm::Srs(_)) = ClosedForm::of(chain) {
        return Ok(Free::ArmAngle);
    }
    let joint = |variable: usize| Free::Joint(variable, Limit::of(&chain.variables()[variable]));
    if chain.dof() == 7
        && let Ok(every) = Every::of(chain)
    {
        return Ok(joint(every.order[every.default_lock()]));
    }
    match Lead::of(chain) {
        Ok(lead) if chain.dof() == 7 && rest_is_known(lead.rest()) => Ok(joint(lead.variable())),
        _ => Err(refuse(&format!("'{}' with {} joints", chain.name(), chain.dof()))),
    }
}

/// The branches of the targets can be asked for at each value of a free joint or arm angle.
pub fn can_sweep(request: &Request<'_>) -> bool {
    let ask = Ask { locks: &[], angle: ArmAngle::Free, sweep: None, wrap: false };
    request.aim().fixes_pose()
        && matches!(request.goals(), Goals::Poses(_))
        && free_of(request, &ask).is_ok()
        && Family::of(request.chain()).branches > 0
}

/// The values of a sweep: over the limits, ends included; over a whole turn, each once.
pub fn sweep_values(limit: &Limit, count: usize) -> Vec<f64> {
    let whole = limit.upper - limit.lower >= TAU;
    let lower = match whole {
        true if limit.lower <= -0.5 * TAU && limit.upper >= 0.5 * TAU => -0.5 * TAU,
        _ => limit.lower,
    };
    let steps = if whole { count } else { (count - 1).max(1) };
    let width = if whole { TAU } else { limit.upper - limit.lower };
    let at = |k: usize| (lower + width * k as f64 / steps as f64).min(limit.upper);
    if count == 1 { vec![limit.middle] } else { (0..count).map(at).collect() }
}

fn swept(
    request: &Request<'_>,
    ask: &Ask<'_>,
    count: usize,
    threads: usize,
    poll: &mut dyn FnMut() -> bool,
) -> Result<Branches> {
    if count == 0 || count > MOST_VALUES {
        let expected = format!("a number of values, 1 to {MOST_VALUES}");
        return Err(Error::argument("sweep", expected, count));
    }
    let free = free_of(request, ask)?;
    let Goals::Poses(poses) = request.goals() else {
        return Err(Error::argument("targets", "poses (4x4 matrices)", "points"));
    };
    let turn = Limit { lower: -0.5 * TAU, upper: 0.5 * TAU, middle: 0.0, half: 0.5 * TAU };
    let limit = if let Free::Joint(_, limit) = &free { *limit } else { turn };
    let values = sweep_values(&limit, count);
    // Values outside, targets inside: neighbours share an arm.
    let rows = poses.len();
    let all_poses: Vec<[f64; 16]> = values.iter().flat_map(|_| poses.iter().copied()).collect();
    let all_values: Vec<f64> =
        values.iter().flat_map(|value| std::iter::repeat_n(*value, rows)).collect();
    let all_starts: Vec<f64> = match request.starts() {
        Starts::Each(q) => q.repeat(count),
        _ => Vec::new(),
    };
    let starts = match request.starts() {
        Starts::Each(_) => Starts::Each(&all_starts),
        other => other,
    };
    let all = Request::new(request.chain(), *request.aim(), Goals::Poses(&all_poses), starts)?;
    let found = match free {
        Free::ArmAngle => at_values(&all, &[], ArmAngle::Each(&all_values), threads, poll)?,
        Free::Joint(variable, _) => {
            let lock = Lock { variable, values: Values::Each(&all_values) };
            at_values(&all, &[lock], ArmAngle::Free, threads, poll)?
        }
    };
    Ok(gathered(&found, rows, &values, request.chain().dof()))
}

/// The record of a sweep with all values of a target side by side.
fn gathered(found: &Branches, rows: usize, values: &[f64], dof: usize) -> Branches {
    let (each, count) = (found.branches, values.len());
    let total = each * count;
    let mut out = Branches::new(rows, total);
    out.q = vec![0.0; rows * total * dof];
    out.values = vec![0.0; rows * total];
    out.numbers = vec![0; rows * total];
    out.warnings = vec![0; rows];
    out.free = vec![-1; rows];
    for row in 0..rows {
        let mut seen = [false; Status::ALL.len()];
        for (v, value) in values.iter().enumerate() {
            let (from, to) = ((v * rows + row) * each, row * total + v * each);
            out.q[to * dof..(to + each) * dof]
                .copy_from_slice(&found.q[from * dof..(from + each) * dof]);
            out.valid[to..to + each].copy_from_slice(&found.valid[from..from + each]);
            out.reached[to..to + each].copy_from_slice(&found.reached[from..from + each]);
            out.singular[to..to + each].copy_from_slice(&found.singular[from..from + each]);
            out.values[to..to + each].fill(*value);
            for b in 0..each {
                out.numbers[to + b] = b as u32;
            }
            let at = v * rows + row;
            seen[usize::from(found.status[at])] = true;
            out.warnings[row] |= found.warnings.get(at).copied().unwrap_or_default();
            if let Some(free) = found.free.get(at).filter(|free| **free >= 0) {
                out.free[row] = *free;
            }
        }
        // What a sample of values does not find may be between them: that is no proof.
        let first = [Status::BadInput, Status::Converged, Status::SingularFamily];
        let status = first.into_iter().find(|status| seen[*status as usize]);
        out.status[row] = status.unwrap_or(Status::NotFound) as u8;
    }
    out
}
