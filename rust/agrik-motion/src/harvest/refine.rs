//! A pattern search in approach angle and slide from the best row of a table, on its branch.

use super::aim::Approach;
use super::approach;
use super::decide::Work;
use super::table::{Row, better, judge, postures};
use crate::Result;

/// First steps, rad and m; the last ones are those that still move the slide by [`LEAST`].
const TURN: f64 = 2.5 * std::f64::consts::PI / 180.0;
const WAY: f64 = 0.025;
const LEAST: f64 = 0.5e-3;

/// The row, or a better one that is admissible as well.
pub(super) fn refined(work: &mut Work<'_>, approach: &Approach, row: Row) -> Result<Row> {
    let (low, high) = (work.slides[0], work.slides[work.slides.len() - 1]);
    let range = work.settings.range;
    let (mut turn, mut way) = (TURN, WAY);
    let mut best = row;
    while way >= LEAST {
        if work.is_late() {
            break;
        }
        let from = best;
        for (psi, slide) in [(turn, 0.0), (-turn, 0.0), (0.0, way), (0.0, -way)] {
            let (psi, slide) = (from.psi + psi, from.slide + slide);
            if psi.abs() > range || !(low..=high).contains(&slide) {
                continue;
            }
            if let Some(row) = at(work, &Approach { psi, ..*approach }, slide, best.branch)?
                && better(&row, &best)
            {
                best = row;
            }
        }
        if best == from {
            turn *= 0.5;
            way *= 0.5;
        }
    }
    Ok(best)
}

/// The admissible row of a branch at one approach and place of the slide.
fn at(work: &mut Work<'_>, approach: &Approach, slide: f64, branch: usize) -> Result<Option<Row>> {
    let opens = approach::open(&work.aim, std::slice::from_ref(approach));
    let Some(open) = opens.first() else { return Ok(None) };
    let mut table = postures(&work.aim, approach, &[slide], work.settings)?;
    table.rows.retain(|row| row.branch == branch);
    judge(&work.aim, &mut table.rows, open.hard, work.settings, &mut work.room);
    Ok(table.best().copied())
}
