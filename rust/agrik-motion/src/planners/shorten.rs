//! Detours are taken out of paths; what stays is proven free as before.

use super::ask::{Ask, uniform};

/// Which of a plan's streams draws places.
const STREAM: u64 = 2;
/// After so many tries in vain it ends.
const IN_VAIN: u32 = 15;
/// A way that saves less than this share of itself is no shorter.
const SAVES: f64 = 1e-3;

/// Leaves out waypoints, then goes straight between places drawn at random along the path.
/// The last `tail` pieces are left as they are.
pub(super) fn shorten(ask: &mut Ask<'_>, path: &mut Vec<Vec<f64>>, tail: usize) {
    skip(ask, path, tail);
    let mut state = ask.key(STREAM, 0);
    let mut in_vain = 0;
    for _ in 0..ask.settings.shortcuts {
        if path.len() < 3 + tail || in_vain >= IN_VAIN || ask.is_spent() {
            return;
        }
        let ways = ways(ask, &path[..path.len() - tail]);
        let all = ways[ways.len() - 1];
        let (a, b) = (all * uniform(&mut state), all * uniform(&mut state));
        let (a, b) = (place(path, &ways, a.min(b)), place(path, &ways, a.max(b)));
        in_vain += 1;
        if a.0 == b.0 {
            continue;
        }
        let straight = ask.metric.between(&a.1, &b.1);
        let along = b.2 - a.2;
        if straight > along * (1.0 - SAVES) || !ask.free(&a.1, &b.1) {
            continue;
        }
        in_vain = 0;
        path.splice(a.0 + 1..=b.0, [a.1, b.1]);
        path.dedup();
    }
    skip(ask, path, tail);
}

/// Leaves out waypoints as far ahead as the straight way is free.
fn skip(ask: &mut Ask<'_>, path: &mut Vec<Vec<f64>>, tail: usize) {
    let mut at = 0;
    while at + 2 + tail < path.len() {
        let ahead = (at + 2..path.len() - tail).rev();
        let mut found = None;
        for to in ahead {
            if ask.is_spent() {
                return;
            }
            if ask.free(&path[at], &path[to]) {
                found = Some(to);
                break;
            }
        }
        if let Some(to) = found {
            path.drain(at + 1..to);
        }
        at += 1;
    }
}

/// Length of the path up to each waypoint, m of the metric.
fn ways(ask: &Ask<'_>, path: &[Vec<f64>]) -> Vec<f64> {
    let mut all = vec![0.0];
    for pair in path.windows(2) {
        all.push(all[all.len() - 1] + ask.metric.between(&pair[0], &pair[1]));
    }
    all
}

/// The waypoint before a place along the path, the posture there, and its way.
fn place(path: &[Vec<f64>], ways: &[f64], way: f64) -> (usize, Vec<f64>, f64) {
    let piece = ways.partition_point(|w| *w <= way).clamp(1, ways.len() - 1) - 1;
    let length = ways[piece + 1] - ways[piece];
    let share = if length > 0.0 { (way - ways[piece]) / length } else { 0.0 };
    let (a, b) = (&path[piece], &path[piece + 1]);
    (piece, a.iter().zip(b).map(|(a, b)| a + share * (b - a)).collect(), way)
}
