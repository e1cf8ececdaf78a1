//! Many targets on several threads.

use agrik_compute::threads::share;

use super::aim::Target;
use super::blockers::{Blockers, blockers};
use super::decide::{Decision, decide, full};
use super::settings::Settings;
use super::station::Station;
use crate::{Error, Result};

/// Targets that a thread takes at a time: their times differ much.
const RUN: usize = 4;

/// Decisions for targets on `threads` threads (0: the number in force), by [`decide`], or with
/// `scan_all` by [`full`]; `poll` is asked now and then whether to go on. Answers do not
/// depend on the number of threads.
///
/// # Errors
///
/// A setting is out of its range, a target names no object, or `poll` said no.
pub fn plan(
    station: &Station,
    targets: &[Target],
    settings: &Settings,
    scan_all: bool,
    threads: usize,
    poll: &mut dyn FnMut() -> bool,
) -> Result<Vec<Decision>> {
    settings.check()?;
    let one = if scan_all { full } else { decide };
    each(targets, threads, poll, |target| one(station, target, settings))
}

/// [`blockers`] of targets; see [`plan`].
///
/// # Errors
///
/// As [`plan`].
pub fn plan_blockers(
    station: &Station,
    targets: &[Target],
    settings: &Settings,
    threads: usize,
    poll: &mut dyn FnMut() -> bool,
) -> Result<Vec<Option<Blockers>>> {
    settings.check()?;
    each(targets, threads, poll, |target| blockers(station, target, settings))
}

fn each<T: Send>(
    targets: &[Target],
    threads: usize,
    poll: &mut dyn FnMut() -> bool,
    one: impl Fn(&Target) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let mut out: Vec<Option<Result<T>>> = targets.iter().map(|_| None).collect();
    let work = |(targets, out): (&[Target], &mut [Option<Result<T>>])| {
        for (target, to) in targets.iter().zip(out) {
            *to = Some(one(target));
        }
    };
    let runs = targets.chunks(RUN).zip(out.chunks_mut(RUN)).collect();
    if !share(runs, threads, &work, poll) {
        return Err(Error::Interrupted);
    }
    out.into_iter().map(|one| one.unwrap_or(Err(Error::Interrupted))).collect()
}
