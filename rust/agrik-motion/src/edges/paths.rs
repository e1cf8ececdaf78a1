//! Many ways on several threads, and paths of several pieces.

use agrik_compute::threads::share;

use super::certifier::Certifier;
use super::verdict::{Keep, Verdict};
use crate::body::check_postures;
use crate::{Collider, Error, Result};

/// Ways that a thread takes at a time: their times differ much.
const RUN: usize = 8;

/// Rows where ways begin, and rows where they end.
type Ends<'q> = (&'q [f64], &'q [f64]);

/// [`Certifier::explained`] for each way from a row of `from` to that of `to` (as many numbers
/// as joint values each, rad and m), on `threads` threads (0: the number in force); `poll` is
/// asked now and then whether to go on. Answers do not depend on the number of threads.
///
/// # Errors
///
/// `from` or `to` is no whole number of rows, they have not as many, or a number is not finite;
/// a number of `keep` is out of its range; or `poll` said no.
pub fn check_segments(
    collider: &Collider,
    keep: Keep,
    from: &[f64],
    to: &[f64],
    threads: usize,
    poll: &mut dyn FnMut() -> bool,
) -> Result<Vec<Verdict>> {
    keep.check()?;
    let chain = collider.bodies().chain();
    let dof = chain.dof();
    check_postures(chain, from)?;
    check_postures(chain, to)?;
    if from.len() != to.len() {
        let expected = format!("as many rows as from has, {}", from.len() / dof);
        return Err(Error::argument("to", expected, to.len() / dof));
    }
    let mut out: Vec<Option<Verdict>> = vec![None; from.len() / dof];
    let work = |((from, to), out): (Ends<'_>, &mut [Option<Verdict>])| {
        let mut certifier = Certifier::new(collider, keep);
        for ((from, to), out) in from.chunks(dof).zip(to.chunks(dof)).zip(out) {
            *out = Some(certifier.explained(from, to));
        }
    };
    let rows = from.chunks(dof * RUN).zip(to.chunks(dof * RUN));
    if !share(rows.zip(out.chunks_mut(RUN)).collect(), threads, &work, poll) {
        return Err(Error::Interrupted);
    }
    out.into_iter().map(|one| one.ok_or(Error::Interrupted)).collect()
}

/// The answers for the pieces of a path, whose waypoints are the rows of `path`: one less than
/// waypoints; of a single waypoint that for the posture.
///
/// # Errors
///
/// As [`check_segments`]; the path has no waypoint.
pub fn check_path(
    collider: &Collider,
    keep: Keep,
    path: &[f64],
    threads: usize,
    poll: &mut dyn FnMut() -> bool,
) -> Result<Vec<Verdict>> {
    let dof = collider.bodies().chain().dof();
    if path.is_empty() {
        return Err(Error::argument("path", "one waypoint or more", "none"));
    }
    if path.len() == dof {
        return check_segments(collider, keep, path, path, threads, poll);
    }
    let inner = path.len().saturating_sub(dof);
    check_segments(collider, keep, &path[..inner], &path[dof.min(path.len())..], threads, poll)
}
