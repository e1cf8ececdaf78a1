//! Which speeds a run takes where: spans of pieces, each of them one stretch of at most seven
//! phases, chosen so that the whole is as quick as such spans can be.

use agrik::chain::MotionLimits;

use super::caps::Caps;
use super::path::Piece;
use super::profile::{Phase, Profile};

/// Pieces that one stretch may go over; the whole run may always be one.
const LONGEST_SPAN: usize = 12;
/// Shares of the highest speed that are looked at between two pieces.
const SHARES: [f64; 3] = [1.0, 0.6, 0.36];

/// How a span is gone over.
#[derive(Debug, Clone, Copy)]
enum Stretch {
    /// At an even speed.
    Even { length: f64, speed: f64 },
    /// From one speed to another.
    Ramps(Profile),
}

impl Stretch {
    fn time(&self) -> f64 {
        match self {
            Self::Even { length, speed } => length / speed,
            Self::Ramps(profile) => profile.time(),
        }
    }

    fn phases(&self, start: f64, out: &mut Vec<Phase>) {
        match self {
            Self::Even { speed, .. } => {
                out.push(Phase { duration: self.time(), at: [start, *speed, 0.0, 0.0] });
            }
            Self::Ramps(profile) => profile.phases(start, out),
        }
    }
}

/// The quickest way found to a place between two pieces at one speed.
#[derive(Debug, Clone, Copy)]
struct Best {
    time: f64,
    /// Place and number of the speed there, and how it went on from there.
    from: Option<(usize, usize, Stretch)>,
}

/// Appends the phases of a run of pieces from rest to rest. `most` is a speed along the way
/// that is never passed, `start` the place at which the run begins.
pub(super) fn append_run(
    pieces: &[Piece],
    start: f64,
    limits: &[MotionLimits],
    most: f64,
    out: &mut Vec<Phase>,
) {
    let count = pieces.len();
    let speeds = speeds(pieces, start, limits, most);
    let mut best: Vec<Vec<Best>> = speeds
        .iter()
        .map(|speeds| vec![Best { time: f64::INFINITY, from: None }; speeds.len()])
        .collect();
    best[0][0].time = 0.0;
    let place = |at: usize| if at == 0 { start } else { pieces[at - 1].end() };
    for from in 0..count {
        if best[from].iter().all(|best| best.time.is_infinite()) {
            continue;
        }
        let near = from + 1..=count.min(from + LONGEST_SPAN);
        let far = (from == 0 && count > LONGEST_SPAN).then_some(count);
        for to in near.chain(far) {
            let span = &pieces[from..to];
            let caps = Caps::over(span.iter(), limits, most);
            let even = span.iter().map(|piece| Caps::even(piece, limits)).fold(most, f64::min);
            let length = place(to) - place(from);
            for (i, &enters) in speeds[from].iter().enumerate() {
                let before = best[from][i].time;
                if before.is_infinite() {
                    continue;
                }
                for (k, &leaves) in speeds[to].iter().enumerate() {
                    if before + length / even.max(caps.velocity) >= best[to][k].time {
                        continue;
                    }
                    let stretch = if enters == leaves && enters > 0.0 && enters <= even {
                        Some(Stretch::Even { length, speed: enters })
                    } else {
                        Profile::new(length, enters, leaves, &caps).map(Stretch::Ramps)
                    };
                    if let Some(stretch) = stretch
                        && before + stretch.time() < best[to][k].time
                    {
                        let time = before + stretch.time();
                        best[to][k] = Best { time, from: Some((from, i, stretch)) };
                    }
                }
            }
        }
    }
    let mut spans = Vec::new();
    let mut at = (count, 0);
    while let Some((from, speed, stretch)) = best[at.0][at.1].from {
        spans.push((from, stretch));
        at = (from, speed);
    }
    for (from, stretch) in spans.into_iter().rev() {
        stretch.phases(place(from), out);
    }
}

/// Speeds to look at before, between and behind the pieces of a run; 0 at its ends.
fn speeds(pieces: &[Piece], start: f64, limits: &[MotionLimits], most: f64) -> Vec<Vec<f64>> {
    let count = pieces.len();
    let mut speeds = vec![vec![0.0]; count + 1];
    let length = pieces.last().map_or(start, Piece::end) - start;
    let even: Vec<f64> = pieces.iter().map(|piece| Caps::even(piece, limits).min(most)).collect();
    for at in 1..count {
        let mut top = even[at - 1].min(even[at]);
        if !top.is_finite() {
            // Nobody limits the speed: as fast as the acceleration makes it on half of the run.
            let caps = Caps::over(pieces.iter(), limits, most);
            top = (caps.acceleration * length).sqrt();
        }
        speeds[at] = SHARES.iter().map(|share| share * top).collect();
    }
    speeds
}
