//! Step 1: the approach angles at which the last links are free, ranked.

use agrik_solids::Pose;

use super::aim::{Aim, Approach, last_frame};

/// An approach angle at which the gripper is free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Open {
    pub approach: Approach,
    /// Distance of the bodies of the last link from the crop, which no other joint changes, m.
    pub hard: f64,
    /// The same of the wrist's other links, as they would be with the wrist straight, m.
    pub soft: f64,
}

/// Distance of the bodies of the last link, m; `None` where one touches something or comes
/// nearer than `least`.
pub(super) fn hard_distance(aim: &Aim<'_>, last: &Pose, least: f64) -> Option<f64> {
    let station = aim.station;
    let mut distance = f64::INFINITY;
    for (body, solid) in station.hard(last) {
        distance = station.around.distance(body, &solid, aim.exempt(body), distance);
        if distance < least || distance <= 0.0 || station.around.hits_static(body, &solid) {
            return None;
        }
    }
    Some(distance)
}

/// The angles that are open, best first: by the distance of all links looked at, then by how
/// small the angle is.
pub(super) fn open(aim: &Aim<'_>, approaches: &[Approach]) -> Vec<Open> {
    let station = aim.station;
    let tail = &station.chain().compiled().tail;
    let mut found = Vec::with_capacity(approaches.len());
    for approach in approaches {
        let last = last_frame(&approach.pose(aim.point), tail);
        let Some(hard) = hard_distance(aim, &last, 0.0) else { continue };
        // What is farther than the gripper does not count in the rank.
        let soft = station.soft(&last).fold(hard, |least, (body, solid)| {
            station.around.distance(body, &solid, aim.exempt(body), least)
        });
        found.push(Open { approach: *approach, hard, soft });
    }
    found.sort_by(|a, b| {
        let (of_a, of_b) = (a.hard.min(a.soft), b.hard.min(b.soft));
        let angle = |open: &Open| open.approach.psi.abs();
        of_b.total_cmp(&of_a).then(angle(a).total_cmp(&angle(b)))
    });
    found
}
