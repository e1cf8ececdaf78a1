//! The smallest translation of the platform that brings a target in reach.
//!
//! # Claim
//!
//! No translation along the axes that may move is shorter than the one found by more than
//! the length asked for; and where none is found, none exists.
//!
//! # Proof
//!
//! Write `r = l2 + l3 cos(beta)`, `u = r sin(theta)`, `w = r cos(theta)`. What a target at
//! (theta, beta) lacks is the vector from the slides' window, intervals of u, w and s10, to
//! `(u, w, straight - l3 sin(beta))`: the platform makes up for it. Wanted is the least
//! length over all theta and beta within their limits at which the axes that may not move
//! lack nothing.
//!
//! **One arc** (beta fixed): s10 lacks a given length, and along the arc the squared distance
//! in u and w from the window has a continuous derivative. Where only u lacks, it is
//! stationary nowhere within a quarter turn; where only w does, at theta = 0; where both do,
//! at the direction of a corner of the window. Where an axis may not move, the arc's allowed
//! parts end where it crosses a line of the window. So the least is at one of these angles
//! or at a limit of theta.
//!
//! **A piece of beta** is bounded from below by a relaxed problem, in which r may be any of
//! the piece's reaches whatever sin(beta) is. s10 then lacks at least the distance of two
//! intervals. In the plane of (u, w) the piece is a sector of a ring, and the squared
//! distance from the window a function with a continuous derivative that is stationary only
//! where it is 0. If it is 0 anywhere, it is so at a corner of the window or on the sector's
//! edge; if not, its least is on the edge. The same holds on the strip that an axis that may
//! not move leaves: on the strip's own lines inside the sector, the other axis can still get
//! nearer to the window. The edge is two arcs, as above, and two rays, on which the function
//! is convex and quadratic between the window's lines: its least is at an end, at a line, or
//! at the foot of a corner.
//!
//! Pieces are halved until no bound is shorter than the best arc found by more than the
//! length asked for. An arc is tried at the middle of each piece and at the reach that the
//! relaxed problem takes.

use std::collections::VecDeque;

use super::sets::Window;
use super::{Arm, Interval, SLIDE_TOLERANCE, Turn, other_leg};
use crate::lanes::hypotenuse;

/// How much shorter than the answer a translation might be, m, where nobody asks for another.
pub const CERTIFIED: f64 = 1e-8;
/// Added to a shift so that the target ends inside and not on the edge of rounding, m.
const MARGIN: f64 = 1e-9;

/// The point of a part of the plane of (u, w) that is nearest to a window.
struct Nearest<'a> {
    window: &'a Window,
    may_move: [bool; 2],
    best: Option<Lack>,
}

/// What x and z lack at a point, m.
#[derive(Debug, Clone, Copy)]
struct Lack {
    gap: [f64; 2],
    squared: f64,
    /// Distance of the point from the pitch axis, m.
    r: f64,
}

/// A gap that is no rounding.
#[inline]
fn settled(gap: f64) -> f64 {
    if gap.abs() <= SLIDE_TOLERANCE { 0.0 } else { gap }
}

impl Nearest<'_> {
    #[inline]
    fn consider(&mut self, r: f64, turn: Turn) {
        let (u, w) = (r * turn.sin, r * turn.cos);
        // The slide would be at `limit + gap`: the platform makes up for it.
        let x = settled(u - self.window.u.nearest(u));
        let z = settled(w - self.window.w.nearest(w));
        if (x != 0.0 && !self.may_move[0]) || (z != 0.0 && !self.may_move[1]) {
            return;
        }
        let squared = x * x + z * z;
        if self.best.is_none_or(|best| squared < best.squared) {
            self.best = Some(Lack { gap: [x, z], squared, r });
        }
    }
}

impl Arm {
    /// The smallest translation of the platform (m, base frame) that brings a target in
    /// reach, along the axes that may move: none is shorter by more than `within` (m), see the
    /// proof in the source. Zero for a target in reach, `None` where no such translation
    /// exists or the target is not finite.
    pub fn suggest_base_shift(
        &self,
        target: [f64; 3],
        may_move: [bool; 3],
        within: f64,
    ) -> Option<[f64; 3]> {
        if !target.iter().all(|x| x.is_finite()) {
            return None;
        }
        if self.exact(target).is_ok() {
            return Some([0.0; 3]);
        }
        let p = &self.parameters;
        let window = self.window(target);
        let in_plane = [may_move[0], may_move[2]];
        let straight = target[1] - p.l1 + p.d[1];
        let slide = Interval::new(p.lower[0], p.upper[0]);
        let mut betas = Interval::new(p.lower[4], p.upper[4]);
        if !may_move[1] {
            let set = self.s10_set(target).ok()?;
            betas = Interval::new(
                self.beta_at(target, set.high).rad,
                self.beta_at(target, set.low).rad,
            );
        }
        let mut shortest = f64::INFINITY;
        let mut shift = None;
        let mut consider = |beta: f64| {
            let s10 = straight - p.l3 * beta.sin();
            // Beta keeps an s10 that may not move within its limits, but for rounding.
            let y = if may_move[1] { settled(s10 - slide.nearest(s10)) } else { 0.0 };
            let r = self.reach(beta);
            if let Some(lack) = self.sector(&window, Interval::new(r, r), in_plane) {
                let length = (lack.squared + y * y).sqrt();
                if length < shortest {
                    shortest = length;
                    shift = Some([lack.gap[0], y, lack.gap[1]]);
                }
            }
            shortest
        };
        consider(betas.low);
        consider(betas.high);
        let mut pieces = VecDeque::from([betas]);
        if betas.low < 0.0 && 0.0 < betas.high {
            // The reach grows on one side of 0 and shrinks on the other.
            consider(0.0);
            pieces = [Interval::new(betas.low, 0.0), Interval::new(0.0, betas.high)].into();
        }
        while let Some(piece) = pieces.pop_front() {
            let (a, b) = (self.reach(piece.low), self.reach(piece.high));
            let reaches = Interval::new(a.min(b), a.max(b));
            let Some(lack) = self.sector(&window, reaches, in_plane) else { continue };
            let s10 = [piece.high, piece.low].map(|beta| straight - p.l3 * beta.sin());
            let y = (s10[0] - slide.high).max(slide.low - s10[1]).max(0.0);
            let y = if may_move[1] { y } else { 0.0 };
            let bound = (lack.squared + y * y).sqrt();
            let middle = piece.middle();
            let at_reach = ((lack.r - p.l2) / p.l3).clamp(-1.0, 1.0).acos();
            consider(piece.nearest(if piece.low < 0.0 { -at_reach } else { at_reach }));
            if bound < consider(middle) - within && piece.low < middle && middle < piece.high {
                let halves = [Interval::new(piece.low, middle), Interval::new(middle, piece.high)];
                pieces.extend(halves);
            }
        }
        let length = shortest;
        shift.map(|shift: [f64; 3]| shift.map(|v| v * (1.0 + MARGIN / length.max(MARGIN))))
    }

    /// Distance in x and z of the slides' window from the points that the arm reaches with
    /// a reach in an interval, m.
    pub(super) fn window_distance(&self, window: &Window, r: Interval) -> f64 {
        self.sector(window, r, [true; 2]).map_or(f64::INFINITY, |lack| lack.squared.sqrt())
    }

    /// What x and z lack least with a reach in an interval; `None` where that needs an axis
    /// that may not move.
    fn sector(&self, window: &Window, r: Interval, may_move: [bool; 2]) -> Option<Lack> {
        let mut nearest = Nearest { window, may_move, best: None };
        self.arc(&mut nearest, r.low);
        if r.low < r.high {
            self.arc(&mut nearest, r.high);
            let corners = corners(window);
            for [a, b] in corners {
                let length = hypotenuse(a, b);
                if b > 0.0 && r.holds(length) {
                    nearest.consider(length, self.pitch_nearest(a / length));
                }
            }
            for turn in self.pitch_ends.map(|end| end.turn) {
                let Turn { sin, cos } = turn;
                let across = [window.u.low, window.u.high].map(|a| a / sin);
                let down = [window.w.low, window.w.high].map(|b| b / cos);
                let feet = corners.map(|[a, b]| a * sin + b * cos);
                for at in across.into_iter().chain(down).chain(feet).filter(|at| r.holds(*at)) {
                    nearest.consider(at, turn);
                }
            }
        }
        nearest.best
    }

    /// The points of an arc that may be the nearest.
    fn arc(&self, nearest: &mut Nearest<'_>, r: f64) {
        let (u, w) = (nearest.window.u, nearest.window.w);
        nearest.consider(r, self.pitch_nearest(-1.0));
        nearest.consider(r, self.pitch_nearest(0.0));
        nearest.consider(r, self.pitch_nearest(1.0));
        for a in [u.low, u.high] {
            nearest.consider(r, self.pitch_nearest(a / r));
        }
        for [a, b] in corners(nearest.window) {
            if b > 0.0 {
                nearest.consider(r, self.pitch_nearest(a / hypotenuse(a, b)));
            }
        }
        for cos in [w.low, w.high].map(|b| b / r).into_iter().filter(|x| (0.0..=1.0).contains(x)) {
            let sin = other_leg(cos);
            for sin in [-sin, sin] {
                let turn = self.pitch_nearest(sin);
                // The cosine as it was given, where the limits allow it.
                nearest.consider(r, if turn.sin == sin { Turn { sin, cos } } else { turn });
            }
        }
    }

    /// The theta within its limits whose sine is nearest to a number.
    #[inline]
    fn pitch_nearest(&self, sin: f64) -> Turn {
        let [low, high] = self.pitch_ends.map(|end| end.turn);
        if sin <= low.sin {
            low
        } else if sin >= high.sin {
            high
        } else {
            Turn::of_sine(sin)
        }
    }
}

fn corners(window: &Window) -> [[f64; 2]; 4] {
    let (u, w) = (window.u, window.w);
    [[u.low, w.low], [u.low, w.high], [u.high, w.low], [u.high, w.high]]
}
