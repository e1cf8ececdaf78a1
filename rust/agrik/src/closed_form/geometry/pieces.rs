//! Three joints whose axes meet along an angle that turns what they have to bring about: where
//! the limits allow them.
//!
//! What they bring about is `C + A cos(psi) + B sin(psi)` with constant matrices. A joint
//! stands at a given value where one product of an axis with such a matrix has a given size:
//! an equation `k0 + k1 cos(psi) + k2 sin(psi) = 0` with at most two roots. Between
//! neighbouring roots of all limits nothing crosses a limit, so one look at the middle of each
//! piece settles it.

use std::f64::consts::{PI, TAU};

use super::limit::{Limit, SLACK};
use super::turn::{Meeting, Side};
use crate::lanes::{V3, atan2, hypotenuse};

/// Roots that neighbour one another by less are one, rad.
pub const SAME: f64 = 1e-12;
/// An equation that misses zero by less just touches it.
const TOUCHING: f64 = 1e-9;

/// A closed interval of angles, rad, `lower` in [-pi, pi), at most a turn long.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// First angle.
    pub lower: f64,
    /// Last angle; above pi where the interval goes through half a turn.
    pub upper: f64,
}

/// A matrix (columns) for each of the constant, cosine and sine parts.
pub type Parts = [[V3<f64>; 3]; 3];

/// The pieces of the turn in which three joints keep within their limits on one of their
/// two branches; each limit comes with the offset of its joint.
pub fn pieces(
    meeting: &Meeting,
    parts: &Parts,
    branch: usize,
    limits: &[(Limit, f64); 3],
) -> Vec<Interval> {
    let (s1, c1) = (meeting.one.sine, meeting.one.cosine);
    let (s2, c2) = (meeting.two.sine, meeting.two.cosine);
    let mut cuts = Vec::with_capacity(16);
    limit_cuts(meeting, parts, limits, &mut cuts);
    // The branches trade places where first and third axis are in line.
    for wanted in [c1 * c2 - s1 * s2, c1 * c2 + s1 * s2] {
        let [k0, k1, k2] = [0, 1, 2].map(|p| parts[p][2][2]);
        let size = hypotenuse(k1, k2);
        let off = (k0 - wanted).abs() - size;
        if off.abs() < 1e-9 {
            let top = k2.atan2(k1);
            cuts.push(wrap(if k0 < wanted { top } else { top + PI }));
        }
    }
    cuts.sort_by(f64::total_cmp);
    cuts.dedup_by(|a, b| (*a - *b).abs() < SAME);
    let inside = |psi: f64| {
        let (s, c) = psi.sin_cos();
        let column =
            |k: usize| [0, 1, 2].map(|i| parts[0][k][i] + c * parts[1][k][i] + s * parts[2][k][i]);
        let side = Side::both()[branch];
        let found = meeting.solve(column(0), column(2), (0.0, 1.0), side);
        found
            .turns
            .iter()
            .zip(limits)
            .all(|(turn, (limit, offset))| allows(limit, atan2(turn.0, turn.1) - offset))
    };
    let Some(&start) = cuts.first() else {
        let whole = Interval { lower: -PI, upper: PI };
        return if inside(0.3) { vec![whole] } else { Vec::new() };
    };
    let mut out: Vec<Interval> = Vec::new();
    for (i, &lower) in cuts.iter().enumerate() {
        let upper = cuts.get(i + 1).copied().unwrap_or(start + TAU);
        if inside(0.5 * (lower + upper)) {
            match out.last_mut() {
                Some(before) if before.upper == lower => before.upper = upper,
                _ => out.push(Interval { lower, upper }),
            }
        }
    }
    // The last piece goes over into the first.
    if out.len() > 1
        && let (Some(first), Some(last)) = (out.first().copied(), out.last_mut())
        && first.lower + TAU == last.upper
    {
        last.upper = first.upper + TAU;
        out.remove(0);
    }
    out
}

/// Where one of three joints is at a limit, on either branch; limits as for [`pieces`].
pub fn limit_cuts(
    meeting: &Meeting,
    parts: &Parts,
    limits: &[(Limit, f64); 3],
    cuts: &mut Vec<f64>,
) {
    let (s1, c1) = (meeting.one.sine, meeting.one.cosine);
    let (s2, c2) = (meeting.two.sine, meeting.two.cosine);
    for (j, (limit, offset)) in limits.iter().enumerate() {
        if 2.0 * limit.half >= TAU {
            continue;
        }
        for value in [limit.lower, limit.upper] {
            let (s, c) = (value + offset).sin_cos();
            // m[column][row]
            let product = |m: &[V3<f64>; 3]| match j {
                0 => -s1 * (c * m[2][1] - s * m[2][0]) + c1 * m[2][2],
                1 => m[2][2],
                _ => s2 * (s * m[0][2] + c * m[1][2]) + c2 * m[2][2],
            };
            let wanted = [c2, c1 * c2 - s1 * s2 * c, c1][j];
            roots(product(&parts[0]) - wanted, product(&parts[1]), product(&parts[2]), cuts);
        }
    }
}

/// Roots of `k0 + k1 cos + k2 sin`, also those that rounding has parted from the real ones.
fn roots(k0: f64, k1: f64, k2: f64, out: &mut Vec<f64>) {
    let size = hypotenuse(k1, k2);
    if size > TOUCHING && k0.abs() < size + TOUCHING {
        let (top, half) = (k2.atan2(k1), (-k0 / size).clamp(-1.0, 1.0).acos());
        out.push(wrap(top + half));
        out.push(wrap(top - half));
    }
}

pub fn wrap(angle: f64) -> f64 {
    let x = angle - TAU * (angle / TAU).round();
    if x >= PI { x - TAU } else { x }
}

/// Some whole number of turns brings the value inside the limits.
pub fn allows(limit: &Limit, value: f64) -> bool {
    if !limit.half.is_finite() {
        return true;
    }
    let off = value - limit.middle;
    (off - TAU * (off / TAU).round()).abs() <= limit.half + SLACK
}
