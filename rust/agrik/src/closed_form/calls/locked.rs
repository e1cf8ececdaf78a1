//! All branches of arms some of whose joints are kept at given values: what is left must be
//! an arm with a closed form.

use std::collections::BTreeMap;

use nalgebra::{IsometryMatrix3, Matrix3, Rotation3, Translation3, Vector3};

use super::all_branches::all;
use super::any_arm::AnyArm;
use super::arm_angle::{ArmAngle, form_of};
use super::branches::Branches;
use super::every_branch::solved_without_locks;
use super::query::Query;
use crate::allowed::is_measure;
use crate::call::{Aim, Goals, Request, Starts};
use crate::chain::{Chain, Tail};
use crate::closed_form::branch::choice::Choice;
use crate::closed_form::families::Lead;
use crate::closed_form::families::every::Every;
use crate::error::{Error, Result};

/// Values of a locked joint, rad or m.
#[derive(Debug, Clone, Copy)]
pub enum Values<'a> {
    /// The same for all targets.
    One(f64),
    /// One a target.
    Each(&'a [f64]),
}

impl Values<'_> {
    pub(super) fn row(&self, row: usize) -> f64 {
        match self {
            Self::One(value) => *value,
            Self::Each(all) => all[row],
        }
    }
}

/// A joint that is kept where it is.
#[derive(Debug, Clone, Copy)]
pub struct Lock<'a> {
    /// Which entry of `q`.
    pub variable: usize,
    /// Where.
    pub values: Values<'a>,
}

/// All branches of the targets of a request (full poses) with some joints locked, on `threads`
/// threads; see [`all`]. The record holds the locked joints' values as well.
///
/// A value that is no number makes its target bad input; one outside the limits is refused.
pub fn all_locked(
    request: &Request<'_>,
    locks: &[Lock<'_>],
    angle: ArmAngle<'_>,
    threads: usize,
    poll: &mut dyn FnMut() -> bool,
) -> Result<Branches> {
    let poses = checked(request, locks)?;
    let rows: Vec<usize> = (0..poses.len()).collect();
    let lead = match locks {
        [one] => Lead::of(request.chain()).ok().filter(|lead| lead.variable() == one.variable),
        _ => None,
    };
    if let Some(lead) = lead {
        // One chain for all values of its first joint.
        let seen = |row: &usize| lead.seen(&poses[*row], locks[0].values.row(*row));
        let seen: Vec<[f64; 16]> = rows.iter().map(seen).collect();
        let part = Part { request, locks, rows: &rows, angle };
        let branches = part.solve(lead.rest(), &seen, threads, poll)?;
        return Ok(scattered(request, &[(part, branches)]));
    }
    let mut groups: BTreeMap<Vec<u64>, Vec<usize>> = BTreeMap::new();
    for row in rows {
        let key = locks.iter().map(|lock| lock.values.row(row).to_bits()).collect();
        groups.entry(key).or_default().push(row);
    }
    let mut parts = Vec::with_capacity(groups.len());
    for (bits, rows) in &groups {
        let values: Vec<f64> = bits.iter().map(|bits| f64::from_bits(*bits)).collect();
        let known = values.iter().all(|value| is_measure(*value));
        let goal = |row: &usize| if known { poses[*row] } else { [f64::NAN; 16] };
        let goals: Vec<[f64; 16]> = rows.iter().map(goal).collect();
        let fixed = locks.iter().zip(&values).map(|(lock, x)| (lock.variable, *x));
        let fixed = fixed.map(|(of, x)| (of, known_or_near_zero(request.chain(), of, x)));
        let chain = request.chain().locked(&fixed.collect::<Vec<_>>())?;
        let part = Part { request, locks, rows, angle };
        let branches = part.solve(&chain, &goals, threads, poll)?;
        parts.push((part, branches));
    }
    Ok(scattered(request, &parts))
}

/// A joint value; where it is no number to count with, one within the limits.
fn known_or_near_zero(chain: &Chain, variable: usize, value: f64) -> f64 {
    if is_measure(value) { value } else { chain.variables()[variable].near_zero() }
}

/// The poses of a request whose locks make sense.
pub(super) fn checked<'a>(request: &Request<'a>, locks: &[Lock<'_>]) -> Result<&'a [[f64; 16]]> {
    let (chain, rows) = (request.chain(), request.len());
    let Goals::Poses(poses) = request.goals() else {
        return Err(Error::argument("targets", "poses (4x4 matrices)", "points"));
    };
    for (i, lock) in locks.iter().enumerate() {
        let all: &[f64] = match &lock.values {
            Values::One(value) => std::slice::from_ref(value),
            Values::Each(all) if all.len() == rows => all,
            Values::Each(all) => {
                let expected = format!("{rows} values, one a target");
                return Err(Error::argument("locked", expected, all.len()));
            }
        };
        for value in all.iter().filter(|value| !value.is_nan()) {
            chain.check_lock(lock.variable, *value)?;
        }
        if locks[..i].iter().any(|other| other.variable == lock.variable) {
            let name = &chain.variables()[lock.variable].name;
            return Err(Error::argument("locked", "each joint once", format!("'{name}' twice")));
        }
    }
    if locks.len() >= chain.dof() {
        return Err(Error::argument("locked", "at least one free joint", "none"));
    }
    Ok(poses)
}

/// Targets that share a chain.
struct Part<'k, 'a> {
    request: &'k Request<'a>,
    locks: &'k [Lock<'k>],
    rows: &'k [usize],
    angle: ArmAngle<'k>,
}

impl Part<'_, '_> {
    fn is_locked(&self, variable: usize) -> bool {
        self.locks.iter().any(|lock| lock.variable == variable)
    }

    /// The entry of `q` that one of the chain without the locked joints is.
    fn entry(&self, rest: usize) -> usize {
        let free = (0..self.request.chain().dof()).filter(|variable| !self.is_locked(*variable));
        let mut free = free;
        free.nth(rest).unwrap_or_default()
    }

    /// All branches of the chain without the locked joints.
    fn solve(
        &self,
        chain: &Chain,
        goals: &[[f64; 16]],
        threads: usize,
        poll: &mut dyn FnMut() -> bool,
    ) -> Result<Branches> {
        let form = form_of(chain).map_err(|error| match error {
            Error::Argument { received, .. } => Error::argument(
                "locked",
                "joints that leave an arm whose branches are known",
                received,
            ),
            other => other,
        });
        let aim = self.request.aim();
        let tail = moved_tail(self.request.chain(), chain, aim.tail());
        let aim = Aim::new(chain, aim.task(), aim.tolerance(), tail)?;
        let dof = self.request.chain().dof();
        let free = |q: &[f64]| -> Vec<f64> {
            let kept = q.iter().enumerate().filter(|(i, _)| !self.is_locked(i % dof));
            kept.map(|(_, x)| *x).collect()
        };
        let q0 = match self.request.starts() {
            Starts::Free => Vec::new(),
            Starts::One(q) => free(q),
            Starts::Each(q) => {
                self.rows.iter().flat_map(|row| free(&q[row * dof..(row + 1) * dof])).collect()
            }
        };
        let starts = match self.request.starts() {
            Starts::Free => Starts::Free,
            Starts::One(_) => Starts::One(&q0),
            Starts::Each(_) => Starts::Each(&q0),
        };
        let picked: Vec<f64>;
        let angle = match self.angle {
            ArmAngle::Each(all) => {
                let wanted = self.request.len();
                if all.len() != wanted {
                    let expected = format!("{wanted} numbers, one a target");
                    return Err(Error::argument("arm_angle", expected, all.len()));
                }
                picked = self.rows.iter().map(|row| all[*row]).collect();
                ArmAngle::Each(&picked)
            }
            other => other,
        };
        let request = Request::new(chain, aim, Goals::Poses(goals), starts)?;
        if let Err(error) = form {
            return match Every::of(chain) {
                Ok(every) if every.joints() == 6 => {
                    AnyArm { request, every, lock: None, added: None }.solve(threads, poll)
                }
                _ if chain.dof() < 6 => match solved_without_locks(&request, threads, poll)? {
                    Some(found) => Ok(found),
                    None => Err(error),
                },
                _ => Err(error),
            };
        }
        all(&Query::new(request, angle, Choice::default())?, threads, poll)
    }

    /// Writes the branches with the locked joints' values to the rows' places in the whole record,
    /// which has at least as many branches a target.
    fn scatter(&self, part: &Branches, whole: &mut Branches) {
        let (dof, rows) = (self.request.chain().dof(), self.request.len());
        let (few, count) = (part.branches, whole.branches);
        let rest = dof - self.locks.len();
        for (i, row) in self.rows.iter().enumerate() {
            for b in 0..count {
                // Places of branches that do not exist hold what the last one does.
                let from = (i * few + b.min(few.saturating_sub(1))) * rest;
                let mut from = part.q[from..].iter();
                let q = &mut whole.q[(row * count + b) * dof..][..dof];
                for (variable, x) in q.iter_mut().enumerate() {
                    *x = match self.locks.iter().find(|lock| lock.variable == variable) {
                        Some(lock) => lock.values.row(*row),
                        None => from.next().copied().unwrap_or_default(),
                    };
                    *x = known_or_near_zero(self.request.chain(), variable, *x);
                }
            }
            let (to, here) = (row * count..row * count + few, i * few..(i + 1) * few);
            whole.valid[to.clone()].copy_from_slice(&part.valid[here.clone()]);
            whole.reached[to.clone()].copy_from_slice(&part.reached[here.clone()]);
            whole.singular[to].copy_from_slice(&part.singular[here]);
            whole.status[*row] = part.status[i];
            if let Some(bits) = part.warnings.get(i) {
                whole.warnings.resize(rows, 0);
                whole.warnings[*row] = *bits;
            }
            if let Some(free) = part.free.get(i) {
                whole.free.resize(rows, -1);
                whole.free[*row] = usize::try_from(*free).map_or(-1, |k| self.entry(k) as i8);
            }
            for (from, to) in [(&part.left, &mut whole.left), (&part.off, &mut whole.off)] {
                if let Some(error) = from.get(i) {
                    to.resize(rows, 0.0);
                    to[*row] = *error;
                }
            }
        }
    }
}

/// The record of all targets of a request from those of parts of them.
fn scattered(request: &Request<'_>, parts: &[(Part<'_, '_>, Branches)]) -> Branches {
    // Arms locked at special values may have fewer branches than others.
    let count = parts.iter().map(|(_, found)| found.branches).max().unwrap_or(0);
    let rows = request.len();
    let q = vec![0.0; rows * count * request.chain().dof()];
    let mut whole = Branches { q, ..Branches::new(rows, count) };
    for (part, found) in parts {
        part.scatter(found, &mut whole);
    }
    whole
}

/// The tool of a call in the last joint's frame of a chain some of whose joints are locked;
/// `None` for the robot's own.
pub(super) fn moved_tail(whole: &Chain, rest: &Chain, tail: &Tail) -> Option<Tail> {
    let own = whole.compiled().tail;
    if *tail == own {
        return None;
    }
    let pose = |tail: &Tail| {
        let columns = tail.rotation.map(Vector3::from);
        IsometryMatrix3::from_parts(
            Translation3::from(Vector3::from(tail.translation)),
            Rotation3::from_matrix_unchecked(Matrix3::from_columns(&columns)),
        )
    };
    Some(rest.compiled().tail_with(&(pose(&own).inverse() * pose(tail))))
}
