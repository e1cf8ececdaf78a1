//! Postures that a target has once removable objects are gone, with what has to go for each.

use std::collections::BTreeSet;

use agrik::kinematics::{FRAME, moving_frames};
use agrik_solids::Solid;

use super::aim::{Aim, Approach, Target, last_frame};
use super::settings::{Settings, evenly};
use super::station::Station;
use super::table::{Room, Row, postures};
use crate::Result;

/// Postures, and for each the removable objects that it is too near to.
#[derive(Debug, Default)]
pub(super) struct Openings {
    pub rows: Vec<Row>,
    pub needs: Vec<BTreeSet<usize>>,
}

/// All postures of some approaches that are admissible once removable objects are gone: those
/// that ask for the fewest first, then those with the most freedom.
pub(super) fn openings(
    station: &Station,
    target: &Target,
    approaches: &[Approach],
    settings: &Settings,
) -> Result<Openings> {
    let aim = Aim::new(station, target)?;
    let chain = station.chain();
    let slide = &chain.variables()[station.lead()?.variable()];
    let slides = evenly(slide.lower, slide.upper, settings.slides);
    let size = FRAME * chain.compiled().links.len();
    let (mut room, mut frames) = (Room::new(&aim), Vec::new());
    let mut found: Vec<(BTreeSet<usize>, Row)> = Vec::new();
    for approach in approaches {
        let Some(hard) = needed_by_the_gripper(&aim, approach, settings) else { continue };
        let rows = postures(&aim, approach, &slides, settings)?.rows;
        let q: Vec<f64> = rows.iter().flat_map(|row| row.q).collect();
        frames.resize(size * rows.len(), 0.0);
        moving_frames(chain, &q, &mut frames);
        for (row, frames) in rows.iter().zip(frames.chunks(size)) {
            if row.freedom < settings.min_freedom {
                continue;
            }
            room.placed.fill(&station.around.bodies, frames);
            if station.around.hits_itself(&room.placed) {
                continue;
            }
            let mut set = hard.clone();
            let possible = station.rest.iter().all(|body| {
                let solid = &room.placed.solids()[*body];
                gather(&aim, *body, solid, settings.min_distance, usize::MAX, &mut set)
            });
            if possible {
                found.push((set, *row));
            }
        }
    }
    found.sort_by(|(a, one), (b, other)| {
        a.len().cmp(&b.len()).then(other.freedom.total_cmp(&one.freedom))
    });
    let (needs, rows) = found.into_iter().unzip();
    Ok(Openings { rows, needs })
}

/// The removable objects that the bodies of the last link are too near to at an approach, which
/// no other joint changes; `None` where anything else is too near.
pub(super) fn needed_by_the_gripper(
    aim: &Aim<'_>,
    approach: &Approach,
    settings: &Settings,
) -> Option<BTreeSet<usize>> {
    let station = aim.station;
    let last = last_frame(&approach.pose(aim.point), &station.chain().compiled().tail);
    let bodies: Vec<(usize, Solid)> = station.hard(&last).collect();
    let mut set = BTreeSet::new();
    let free = bodies.iter().all(|(body, solid)| {
        !station.around.hits_static(*body, solid)
            && gather(aim, *body, solid, settings.min_distance, usize::MAX, &mut set)
    });
    free.then_some(set)
}

/// Adds the removable objects that a body has within a distance; false where another object is
/// within it as well, or there are more than `most`.
pub(super) fn gather(
    aim: &Aim<'_>,
    body: usize,
    solid: &Solid,
    within: f64,
    most: usize,
    set: &mut BTreeSet<usize>,
) -> bool {
    let objects = aim.station.around.scene.objects();
    let mut possible = true;
    aim.station.around.each_within((body, solid), aim.exempt(body), within, |object| {
        if objects[object].removable {
            set.insert(object);
        } else {
            possible = false;
        }
    });
    possible && set.len() <= most
}
