//! What stands in the way: the fewest removable objects without which a target can be picked.
//!
//! A posture becomes admissible just when all removable objects are gone that it touches or
//! comes too near to. So the fewest objects over all postures of the grid are the smallest
//! set, without any search through sets.

use std::collections::BTreeSet;

use agrik::kinematics::{FRAME, moving_frames};
use agrik_compute::allowed::is_measure;

use super::aim::{Aim, Approach, Target, last_frame};
use super::openings::{gather, needed_by_the_gripper};
use super::settings::{Settings, evenly};
use super::station::Station;
use super::table::{Room, Row, postures};
use crate::Result;

/// After so many postures looked at the search is broken off.
const MOST_POSTURES: usize = 200_000;

/// Objects to be taken out of the way.
#[derive(Debug, Clone, PartialEq)]
pub struct Blockers {
    /// Their indices, in order; none where the target can be picked as things are.
    pub objects: Vec<usize>,
    /// It is proven that no smaller set does, at the approaches and places of the grid.
    pub exact: bool,
    /// The posture that they make admissible; its distance and score are those after their
    /// removal.
    pub row: Row,
}

/// The smallest set of removable objects without which a target can be picked at an approach,
/// a place of the slide and a branch of the grid; of several sets of that size the one that
/// leaves the best score. `None` where no set does.
///
/// # Errors
///
/// An object of the target is none of the scene's.
pub fn blockers(
    station: &Station,
    target: &Target,
    settings: &Settings,
) -> Result<Option<Blockers>> {
    if !target.point.iter().all(|x| is_measure(*x)) {
        return Ok(None);
    }
    let aim = Aim::new(station, target)?;
    let mut approaches: Vec<(BTreeSet<usize>, Approach)> = Vec::new();
    for psi in settings.psis() {
        let approach = Approach::level(psi);
        if let Some(set) = needed_by_the_gripper(&aim, &approach, settings) {
            approaches.push((set, approach));
        }
    }
    approaches.sort_by_key(|(set, _)| set.len());
    let slide = &station.chain().variables()[station.lead()?.variable()];
    let slides = evenly(slide.lower, slide.upper, settings.slides);
    let mut search = Search { aim, settings, room: None, best: None, looks: 0 };
    let mut exact = true;
    for (set, approach) in &approaches {
        if search.most() < set.len() {
            break;
        }
        if search.looks > MOST_POSTURES {
            exact = false;
            break;
        }
        let table = postures(&search.aim, approach, &slides, settings)?;
        search.look(approach, set, &table.rows);
    }
    Ok(search.best.map(|(objects, row)| Blockers {
        objects: objects.into_iter().collect(),
        exact,
        row,
    }))
}

struct Search<'a, 's> {
    aim: Aim<'a>,
    settings: &'s Settings,
    room: Option<(Room, Vec<f64>)>,
    best: Option<(BTreeSet<usize>, Row)>,
    looks: usize,
}

impl Search<'_, '_> {
    /// The most objects that a set may have to be of interest.
    fn most(&self) -> usize {
        self.best.as_ref().map_or(usize::MAX, |(set, _)| set.len())
    }

    /// Looks at the postures of an approach, whose gripper needs the removal of `hard`.
    fn look(&mut self, approach: &Approach, hard: &BTreeSet<usize>, rows: &[Row]) {
        let station = self.aim.station;
        let size = FRAME * station.chain().compiled().links.len();
        let (mut room, mut frames) =
            self.room.take().unwrap_or_else(|| (Room::new(&self.aim), Vec::new()));
        let q: Vec<f64> = rows.iter().flat_map(|row| row.q).collect();
        frames.resize(size * rows.len(), 0.0);
        moving_frames(station.chain(), &q, &mut frames);
        for (row, frames) in rows.iter().zip(frames.chunks(size)) {
            self.looks += 1;
            if row.freedom < self.settings.min_freedom {
                continue;
            }
            room.placed.fill(&station.around.bodies, frames);
            if station.around.hits_itself(&room.placed) {
                continue;
            }
            let mut set = hard.clone();
            let most = self.most();
            let possible = station.rest.iter().all(|body| {
                let solid = &room.placed.solids()[*body];
                gather(&self.aim, *body, solid, self.settings.min_distance, most, &mut set)
            });
            if !possible {
                continue;
            }
            let row = self.after(row, approach, &set, &room);
            let better = match &self.best {
                None => true,
                Some((best, other)) => {
                    set.len() < best.len()
                        || set.len() == best.len() && super::table::better(&row, other)
                }
            };
            if better {
                self.best = Some((set, row));
            }
        }
        self.room = Some((room, frames));
    }

    /// A posture once a set of objects is gone.
    fn after(&self, row: &Row, approach: &Approach, set: &BTreeSet<usize>, room: &Room) -> Row {
        let station = self.aim.station;
        let last = last_frame(&approach.pose(self.aim.point), &station.chain().compiled().tail);
        let mut distance = self.settings.enough;
        let all = station.rest.iter().map(|body| (*body, room.placed.solids()[*body].clone()));
        for (body, solid) in all.chain(station.hard(&last)) {
            let exempt = self.aim.exempt_and(body, set);
            distance = station.around.distance(body, &solid, &exempt, distance);
        }
        let score = self.settings.score(distance, row.freedom);
        Row { distance, score, admissible: true, ..*row }
    }
}
