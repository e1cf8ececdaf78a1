//! Step 2: the slide is scanned at one approach, and every branch becomes a row of a table.

use std::cmp::Ordering;

use agrik::call::{Aim as Reaching, Goals, Request, Starts, Tolerance};
use agrik::closed_form::{ArmAngle, Choice, Query, all};
use agrik::kinematics::{FRAME, moving_frames};
use agrik::task::Task;

use super::aim::{Aim, Approach, last_frame};
use super::settings::Settings;
use crate::Result;
use crate::body::Placed;

/// Joint values of an arm on a slide.
pub const DOF: usize = 7;

/// Below this sine of its middle angle a wrist is reported as nearly straight.
pub(super) const STRAIGHT: f64 = 1e-3;

/// A wrist this far outside its reach has no posture within the tolerances, m.
const TOLERANCE: f64 = 1e-5;

/// One posture at one approach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Approach angle, rad.
    pub psi: f64,
    /// Place of the slide, m.
    pub slide: f64,
    /// Which branch of the arm behind the slide.
    pub branch: usize,
    /// Joint values, m and rad.
    pub q: [f64; DOF],
    /// Bodies touch each other or a static thing; the distance is 0 then.
    pub hits_itself: bool,
    /// Distance from the crop, m.
    pub distance: f64,
    /// Joint freedom: distance of the worst turning joint from its limits, as a share of half
    /// its range.
    pub freedom: f64,
    /// What the choice goes by.
    pub score: f64,
    /// Free, far enough from the crop and from the limits.
    pub admissible: bool,
}

/// All postures of the arm at one approach.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    /// Those within the limits.
    pub rows: Vec<Row>,
    /// Postures without regard to limits.
    pub reached: usize,
    /// Places of the slide at which the shoulder is singular; they are skipped.
    pub singular: usize,
}

impl Table {
    /// How many rows are admissible.
    pub fn admissible(&self) -> usize {
        self.rows.iter().filter(|row| row.admissible).count()
    }

    /// The best admissible row: by score, then distance, freedom and the lower branch; of
    /// rows that are alike the first.
    pub fn best(&self) -> Option<&Row> {
        self.rows.iter().filter(|row| row.admissible).fold(None, |best, row| match best {
            Some(best) if !better(row, best) => Some(best),
            _ => Some(row),
        })
    }
}

/// One row is to be preferred to another.
pub(super) fn better(row: &Row, other: &Row) -> bool {
    order(row, other).is_lt()
}

/// Rows that are to be preferred come first.
pub(super) fn order(row: &Row, other: &Row) -> Ordering {
    let order = other.score.total_cmp(&row.score);
    let order = order.then(other.distance.total_cmp(&row.distance));
    let order = order.then(other.freedom.total_cmp(&row.freedom));
    order.then(row.branch.cmp(&other.branch))
}

/// The postures that an approach has at some places of the slide, without regard to the crop.
pub(super) fn postures(
    aim: &Aim<'_>,
    approach: &Approach,
    slides: &[f64],
    settings: &Settings,
) -> Result<Table> {
    let chain = aim.station.chain();
    let lead = aim.station.lead()?;
    let rest = lead.rest();
    let pose = approach.pose(aim.point);
    let seen = slides.iter().map(|slide| (*slide, lead.seen(&pose, *slide)));
    // The wrist does not depend on the branch: where it cannot be there is none.
    let within = |(_, goal): &(f64, [f64; 16])| {
        let wrist = last_frame(goal, &rest.compiled().tail).translation;
        rest.last_joint_reach().is_none_or(|reach| reach.excess(wrist) <= TOLERANCE)
    };
    let (slides, goals): (Vec<f64>, Vec<[f64; 16]>) = seen.filter(within).unzip();
    let reaching = Reaching::new(rest, Task::Pose, Tolerance::default(), None)?;
    let request = Request::new(rest, reaching, Goals::Poses(&goals), Starts::Free)?;
    let query = Query::new(request, ArmAngle::Free, Choice::default())?.without_last_search();
    let found = all(&query, 1, &mut || true)?;
    let mut table = Table::default();
    let variables = chain.variables();
    for (k, slide) in slides.iter().enumerate() {
        let of = k * found.branches..(k + 1) * found.branches;
        let shoulder = |b: &usize| found.singular[*b] & agrik::closed_form::SHOULDER != 0;
        if of.clone().any(|b| found.reached[b] && shoulder(&b)) {
            table.singular += 1;
            continue;
        }
        for b in of {
            table.reached += usize::from(found.reached[b]);
            if !found.valid[b] {
                continue;
            }
            let mut q = [0.0; DOF];
            let behind = &found.q[b * (DOF - 1)..(b + 1) * (DOF - 1)];
            let others = (0..DOF).filter(|variable| *variable != lead.variable());
            for (variable, x) in others.zip(behind) {
                q[variable] = *x;
            }
            q[lead.variable()] = *slide;
            let freedom = variables
                .iter()
                .zip(q)
                .enumerate()
                .filter(|(variable, (v, _))| {
                    *variable != lead.variable() && v.lower.is_finite() && v.upper.is_finite()
                })
                .map(|(_, (v, x))| {
                    (x - v.lower).min(v.upper - x) / (0.5 * (v.upper - v.lower)).max(1e-9)
                })
                .fold(1.0, f64::min);
            table.rows.push(Row {
                psi: approach.psi,
                slide: *slide,
                branch: b % found.branches,
                q,
                hits_itself: false,
                distance: 0.0,
                freedom,
                score: settings.score(0.0, freedom),
                admissible: false,
            });
        }
    }
    Ok(table)
}

/// Fills in what the crop says to postures; `hard` is the distance of the last link's bodies.
pub(super) fn judge(
    aim: &Aim<'_>,
    rows: &mut [Row],
    hard: f64,
    settings: &Settings,
    room: &mut Room,
) {
    let station = aim.station;
    let (bodies, chain) = (&station.around.bodies, station.chain());
    let size = FRAME * chain.compiled().links.len();
    let q: Vec<f64> = rows.iter().flat_map(|row| row.q).collect();
    room.frames.resize(size * rows.len(), 0.0);
    moving_frames(chain, &q, &mut room.frames);
    for (row, frames) in rows.iter_mut().zip(room.frames.chunks(size)) {
        room.placed.fill(bodies, frames);
        row.hits_itself = station.around.hits_itself(&room.placed);
        row.distance = 0.0;
        if !row.hits_itself {
            let solids = room.placed.solids();
            row.distance = station.rest.iter().fold(hard, |least, &body| {
                if least <= 0.0 {
                    return least;
                }
                station.around.distance(body, &solids[body], aim.exempt(body), least)
            });
        }
        row.score = settings.score(row.distance, row.freedom);
        row.admissible = !row.hits_itself
            && row.distance >= settings.min_distance
            && row.freedom >= settings.min_freedom;
    }
}

/// Memory of one thread at work.
pub(super) struct Room {
    pub placed: Placed,
    frames: Vec<f64>,
}

impl Room {
    pub fn new(aim: &Aim<'_>) -> Self {
        Self { placed: aim.station.around.bodies.room(), frames: Vec::new() }
    }
}
