//! What is tried after the best approach angle has failed, in this order: other angles, a
//! finer grid round near misses, a tilted gripper or a shifted grip point where they are
//! tolerated, and all that is left.

use super::aim::Approach;
use super::approach::{self, Open};
use super::decide::{Stage, Status, Work, best_of};
use crate::Result;

/// Rounding of approach angles, rad.
const SLACK: f64 = 1e-9;

/// Takes out the angle that is to be tried next: the best that is `spread` away from all
/// those tried; the best where none is.
pub(super) fn next_angle(left: &mut Vec<Open>, tried: &[f64], spread: f64) -> Option<Open> {
    let away =
        |open: &Open| tried.iter().all(|psi| (open.approach.psi - psi).abs() >= spread - SLACK);
    let at = left.iter().position(away).unwrap_or(0);
    (at < left.len()).then(|| left.remove(at))
}

/// Recovery after the approach angles one by one; `left` are those that are left.
pub(super) fn go_on(work: &mut Work<'_>, left: Vec<Open>) -> Result<()> {
    for step in [finer_grid, tilt_and_shift] {
        if work.is_late() {
            work.decision.status = Status::TimeLimit;
            return Ok(());
        }
        step(work)?;
        if work.decision.row.is_some() {
            return Ok(());
        }
    }
    scan_all(work, &left)
}

/// Looks at the places between those of the grid, round the rows that came nearest to being
/// admissible.
fn finer_grid(work: &mut Work<'_>) -> Result<()> {
    let settings = work.settings;
    let turn = settings.range / (settings.angles.max(2) - 1) as f64;
    let (low, high) = (work.slides[0], work.slides[work.slides.len() - 1]);
    let way = 0.25 * (high - low) / (settings.slides.max(2) - 1) as f64;
    let mut best = None;
    for (approach, row) in std::mem::take(&mut work.misses) {
        let psis = [-1.0, 0.0, 1.0].map(|k| Approach { psi: approach.psi + k * turn, ..approach });
        let slides: Vec<f64> = (-4..=4)
            .map(|k| row.slide + f64::from(k) * way)
            .filter(|slide| (low..=high).contains(slide))
            .collect();
        for open in approach::open(&work.aim, &psis) {
            if let Some(table) = work.attempt(&open, &slides, Stage::FinerGrid)?
                && let Some(row) = table.best()
            {
                best = best_of(best, open.approach, row);
            }
        }
    }
    if let Some((approach, row)) = best {
        work.take(row, &approach, Stage::FinerGrid);
    }
    Ok(())
}

/// Tries the gripper tilted and the grip point shifted, the least change first.
fn tilt_and_shift(work: &mut Work<'_>) -> Result<()> {
    let settings = work.settings;
    let slides = work.slides.clone();
    let either = |x: f64| if x > 0.0 { vec![0.0, x, -x] } else { vec![0.0] };
    for tilt in either(settings.tilt) {
        for shift in either(settings.shift) {
            if tilt == 0.0 && shift == 0.0 {
                continue;
            }
            let psis = settings.psis().into_iter();
            let approaches: Vec<Approach> = psis.map(|psi| Approach { psi, tilt, shift }).collect();
            let mut left = approach::open(&work.aim, &approaches);
            let mut tried = Vec::new();
            while let Some(open) = next_angle(&mut left, &tried, settings.spread) {
                if work.is_late() {
                    return Ok(());
                }
                let table = work.attempt(&open, &slides, Stage::TiltShift)?;
                let Some(table) = table else { continue };
                if let Some(row) = table.best() {
                    work.take(*row, &open.approach, Stage::TiltShift);
                    return Ok(());
                }
                tried.push(open.approach.psi);
                if tried.len() >= settings.most_angles {
                    break;
                }
            }
        }
    }
    Ok(())
}

/// The best row of all open approaches.
pub(super) fn scan_all(work: &mut Work<'_>, left: &[Open]) -> Result<()> {
    let slides = work.slides.clone();
    let mut best = None;
    let mut late = false;
    for open in left {
        late = work.is_late();
        if late {
            break;
        }
        if let Some(table) = work.attempt(open, &slides, Stage::FullScan)?
            && let Some(row) = table.best()
        {
            best = best_of(best, open.approach, row);
        }
    }
    if let Some((approach, row)) = best {
        work.take(row, &approach, Stage::FullScan);
    }
    if late {
        work.decision.status = Status::TimeLimit;
    }
    Ok(())
}
