//! What stands in the way of a path: few removable objects without which there is one.

use super::ask::Settings;
use super::plan::{Planned, plan};
use super::words::PathStatus;
use crate::edges::check_path;
use crate::{Collider, Result};

/// Objects to be taken out of the way.
#[derive(Debug, Clone, PartialEq)]
pub struct PathBlockers {
    /// Their indices, in order.
    pub objects: Vec<usize>,
    /// The path that there is without them.
    pub path: Planned,
}

/// Few of some removable objects without which a path is found, from one of which more can be
/// left standing: a path is looked for without all of them; those that it meets are put back
/// one by one as long as another path is found. `without` gives the arm in its scene with some
/// objects gone. `None` where no path is found without all of them.
///
/// # Errors
///
/// As [`plan`], and those of `without`.
pub fn blockers(
    without: impl Fn(&[usize]) -> Result<Collider>,
    start: &[f64],
    goals: &[f64],
    removable: &[usize],
    settings: &Settings,
) -> Result<Option<PathBlockers>> {
    let settings = Settings { prove: false, ..*settings };
    let look = |gone: &[usize]| -> Result<Option<PathBlockers>> {
        let path = plan(&without(gone)?, start, goals, &settings)?;
        if path.status != PathStatus::Ok {
            return Ok(None);
        }
        let objects = met(&without, &path.path, gone, &settings)?;
        Ok(Some(PathBlockers { objects, path }))
    };
    let Some(mut best) = look(removable)? else { return Ok(None) };
    // One alone is the least that there can be.
    for object in best.objects.clone() {
        if best.objects.len() > 1
            && let Some(found) = look(&[object])?
        {
            best = found;
        }
    }
    let mut at = 0;
    while best.objects.len() > 1 && at < best.objects.len() {
        let mut fewer = best.objects.clone();
        fewer.remove(at);
        match look(&fewer)? {
            // What it does not meet any more may stay as well.
            Some(found) if found.objects.len() < best.objects.len() => {
                best = found;
                at = 0;
            }
            _ => at += 1,
        }
    }
    Ok(Some(best))
}

/// Which of the objects that are gone a path meets.
fn met(
    without: &impl Fn(&[usize]) -> Result<Collider>,
    path: &[f64],
    gone: &[usize],
    settings: &Settings,
) -> Result<Vec<usize>> {
    let keep = settings.keep.with_cap(settings.keep.clear);
    let mut found = Vec::new();
    for object in gone {
        let others: Vec<usize> = gone.iter().copied().filter(|other| other != object).collect();
        let collider = without(&others)?;
        let checked = check_path(&collider, keep, path, 1, &mut || true)?;
        if !checked.iter().all(crate::edges::Verdict::is_safe) {
            found.push(*object);
        }
    }
    Ok(found)
}
