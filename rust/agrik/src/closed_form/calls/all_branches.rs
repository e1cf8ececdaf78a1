//! All branches of every target.

use super::branches::{Branches, BranchesMut};
use super::last_resort;
use super::one_pose::Alone;
use super::query::{FEW, Query, RUN};
use crate::call::Status;
use crate::closed_form::branch::check::{is_exact, without_rough};
use crate::closed_form::branch::group::Group;
use crate::closed_form::branch::unreachable::is_out_of_reach;
use crate::error::{Error, Result};
use crate::lanes::{Kernel, Lanes, Level, Real, dispatch};
use crate::threads::share;

/// All branches of every target, on `threads` threads (0: the number in force); `poll` as
/// for [`crate::call::solve`].
pub fn all(query: &Query<'_>, threads: usize, poll: &mut dyn FnMut() -> bool) -> Result<Branches> {
    let mut q = vec![0.0; query.request.len() * query.form.branches() * query.chain().dof()];
    let mut branches = all_into(query, &mut q, threads, poll)?;
    branches.q = q;
    Ok(branches)
}

/// [`all`] with the joint values written to `q` (branches of the family times `dof` numbers
/// a target) and not to the record.
pub fn all_into(
    query: &Query<'_>,
    q: &mut [f64],
    threads: usize,
    poll: &mut dyn FnMut() -> bool,
) -> Result<Branches> {
    let count = query.form.branches();
    let wanted = query.request.len() * count * query.chain().dof();
    if q.len() != wanted {
        return Err(Error::argument("q", format!("room for {wanted} numbers"), q.len()));
    }
    let level = Level::in_use();
    let mut branches = Branches::new(query.request.len(), count);
    let rows = branches.as_mut_with(q);
    let few = rows.len() <= FEW;
    let work = |mut rows: BranchesMut<'_>| fill(level, query, &mut rows, few);
    if share(rows.split(RUN), threads, &work, poll) {
        Ok(branches)
    } else {
        Err(Error::Interrupted)
    }
}

/// Works out all branches of some targets, a few of them one by one.
pub(super) fn fill(level: Level, query: &Query<'_>, rows: &mut BranchesMut<'_>, few: bool) {
    if few {
        dispatch(level, OneByOne { query, rows });
    } else {
        dispatch(level, InLanes { query, rows });
    }
}

/// A target in each lane.
struct InLanes<'k, 'a> {
    query: &'k Query<'k>,
    rows: &'k mut BranchesMut<'a>,
}

impl Kernel for InLanes<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        let (query, rows) = (self.query, self.rows);
        let mut group = Group::<R>::new(query.job());
        let end = rows.first + rows.len();
        let mut row = rows.first;
        while row < end {
            let (used, bad) = query.load(&mut group, row, end);
            group.solve();
            for lane in 0..R::WIDTH {
                if used >> lane & 1 != 0 {
                    let bad = bad >> lane & 1 != 0;
                    write(query, &group, lane, bad, rows, row - rows.first + lane);
                }
            }
            row += R::WIDTH;
        }
    }
}

/// Writes one lane as target `i` of a run.
#[inline(always)]
fn write<R: Real>(
    query: &Query<'_>,
    group: &Group<'_, R>,
    lane: usize,
    bad: bool,
    rows: &mut BranchesMut<'_>,
    i: usize,
) {
    let variables = group.job.variables();
    let (joints, count) = (variables.len(), group.job.form.branches());
    let q = &mut rows.q[i * count * joints..(i + 1) * count * joints];
    if bad {
        rows.status[i] = Status::BadInput as u8;
        for one in q.chunks_exact_mut(joints) {
            group.job.stand_in(one);
        }
        return;
    }
    let mut any_valid = false;
    let left = kept(group, lane, count);
    for (b, one) in q.chunks_exact_mut(joints).enumerate() {
        let candidate = &group.candidates[b];
        for (x, variable) in candidate.q.iter().zip(variables) {
            one[*variable] = x.lane(lane);
        }
        let reached = left >> b & 1 != 0;
        let valid = reached && group.inside[b] >> lane & 1 != 0;
        any_valid |= valid;
        rows.reached[i * count + b] = reached;
        rows.valid[i * count + b] = valid;
        rows.singular[i * count + b] = if reached { candidate.flags(lane) } else { 0 };
    }
    rows.status[i] = match (any_valid, query.last_search) {
        (true, _) => Status::Converged as u8,
        (false, true) => none(query, group, lane, rows, i) as u8,
        (false, false) => Status::NotFound as u8,
    };
}

/// The branches of a lane that are such beside the others, a bit each.
#[inline(always)]
fn kept<R: Real>(group: &Group<'_, R>, lane: usize, count: usize) -> Lanes {
    let (mut reached, mut inside, mut exact) = (0, 0, 0);
    for b in 0..count {
        reached |= (group.reached[b] >> lane & 1) << b;
        inside |= (group.inside[b] >> lane & 1) << b;
        exact |= (is_exact(group.position2[b], group.chord2[b]) >> lane & 1) << b;
    }
    without_rough(reached, inside, exact)
}

/// Looks once more at a target without a valid branch.
#[inline(never)]
fn none<R: Real>(
    query: &Query<'_>,
    group: &Group<'_, R>,
    lane: usize,
    rows: &mut BranchesMut<'_>,
    i: usize,
) -> Status {
    let (job, goal) = (&group.job, group.goal.of_lane(lane));
    let branches = group.candidates.map(|candidate| candidate.q.map(|x| x.lane(lane)));
    if !query.reached && is_out_of_reach(job, &goal, false) {
        return Status::OutOfReach;
    }
    let centre = group.near.centre.map(|x| x.lane(lane));
    let Some((b, posture)) = last_resort::found(job, &goal, &centre, &branches) else {
        return Status::NotFound;
    };
    let (joints, count) = (job.variables().len(), job.form.branches());
    let q = &mut rows.q[(i * count + b) * joints..][..joints];
    for (x, variable) in posture.q.iter().zip(job.variables()) {
        q[*variable] = *x;
    }
    let flags = group.candidates[b].flags(lane);
    (rows.reached[i * count + b], rows.valid[i * count + b]) = (true, true);
    rows.singular[i * count + b] = flags;
    Status::Converged
}

/// A few targets, each with its branches in the lanes.
struct OneByOne<'k, 'a> {
    query: &'k Query<'k>,
    rows: &'k mut BranchesMut<'a>,
}

impl Kernel for OneByOne<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        let (query, rows) = (self.query, self.rows);
        let job = query.job();
        let (joints, count) = (job.variables().len(), job.form.branches());
        for i in 0..rows.len() {
            let mut found = Alone::new(&job);
            match query.alone::<R>(&job, rows.first + i) {
                Some(target) => {
                    found.solve(&job, &target, query.last_search, None);
                    found.drop_rough();
                }
                None => found.stand_in(&job),
            }
            let room = count * joints;
            rows.q[i * room..(i + 1) * room].copy_from_slice(found.q());
            for b in 0..count {
                rows.reached[i * count + b] = found.reached(b);
                rows.valid[i * count + b] = found.valid(b);
                rows.singular[i * count + b] = found.singular(b);
            }
            rows.status[i] = found.status() as u8;
        }
    }
}
