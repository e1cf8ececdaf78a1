//! The best arm angle of an S-R-S arm, with a proof that no other is better.
//!
//! # Claim
//!
//! For axes that meet at right angles, the cost of the arm angle found is within
//! [`TOLERANCE`] of the least cost of all arm angles and branches inside the limits; and
//! where none is found, no arm angle has a branch inside them.
//!
//! # Proof
//!
//! Where the third link turns by `psi` about the line from shoulder to wrist, each of the
//! two triples of joints is `Rz(t1) Rx(90) Rz(t2) Rx(90) Rz(t3) = Rot(w, psi) M`. Let `c` be
//! the cosine between its outer axes, `a` that between `w` and the first and `p` that
//! between `w` and the last. `a` and `p` are constant, `c = a p + S cos(psi - psi0)`, and
//!
//! ```text
//! t1' = (a - p c) / (1 - c^2)          t3' = (p - a c) / (1 - c^2)
//! t2' = c' / sqrt(1 - c^2)             c'^2 = S^2 - (c - a p)^2,  c'' = a p - c
//! ```
//!
//! so that a triple's angles, rates and second derivatives are known functions of `c`
//! (of the sign of `c'`, and of the side of `t2`). The circle of arm angles is cut
//!
//! * where a joint is at a limit (see [`super::arm_angle`]): between cuts a branch is inside
//!   its limits throughout or nowhere, and only the former pieces stay;
//! * where `c' = 0`, `c = a / p` or `c = p / a`: between cuts `c` and all angles are
//!   monotone, so their ranges are those of the ends, exactly.
//!
//! A piece is put aside where the least cost that its ranges allow is no better than the
//! best known; where the cost's derivative, bounded from the ranges of `c` and the angles,
//! has one sign (the best of the piece is then an end, and ends have been looked at); or
//! where the second derivative is positive, after its one stationary point has been looked
//! at. Else it is halved. Ranges shrink to points as pieces do, so this ends; a piece
//! shorter than [`SHORTEST`] is put aside as well, which can only happen where first and
//! last axis of a triple come into line (`c^2 = 1`) and its angles jump. An arm stretched
//! along an axis of a triple may have them in line at every arm angle: of such a triple only
//! a sum of angles is known, and nothing is proven.
//!
//! How many pieces that takes has no bound worth its name; a target takes some hundreds.
//! So that no call lasts for ever, the tolerance doubles with every [`PATIENCE`] pieces,
//! and the one that holds at the end is returned.

use std::f64::consts::TAU;

use super::intervals::Bent;
use super::proof_costs::{Costs, Weight, turn};
use super::proof_ranges::{Spoke, Wheel};
use crate::closed_form::branch::choice::Choice;
use crate::closed_form::families::srs::Srs;
use crate::closed_form::geometry::candidate::JOINTS;
use crate::closed_form::geometry::limit::Limit;
use crate::closed_form::geometry::pieces::limit_cuts;
use crate::closed_form::geometry::range::Range;
use crate::closed_form::geometry::turn::Meeting;
use crate::lanes::Real;

/// How far the cost may be above the least one: rad^2, or shares (their squares).
pub const TOLERANCE: f64 = 1e-9;
/// Pieces after which the tolerance doubles, and again after as many more.
const PATIENCE: u32 = 20_000;
/// Pieces below this length are not halved, rad.
const SHORTEST: f64 = 1e-11;
/// Steps of a bracketed root.
const STEPS: usize = 60;

/// The arm angle of least cost so far.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Best {
    pub cost: f64,
    pub psi: f64,
}

/// A search under way.
struct Hunt<'b> {
    best: &'b mut Best,
    tolerance: f64,
    pieces: u32,
}

impl Hunt<'_> {
    /// Only costs below this are of interest.
    fn wanted(&self) -> f64 {
        self.best.cost - self.tolerance
    }

    fn consider(&mut self, point: &Point) {
        if point.cost < self.best.cost {
            *self.best = Best { cost: point.cost, psi: point.psi };
        }
    }

    /// Counts a piece.
    fn spend(&mut self) {
        self.pieces += 1;
        if self.pieces.is_multiple_of(PATIENCE) {
            self.tolerance *= 2.0;
        }
    }
}

/// Both triples at one arm angle.
type Spokes = [Spoke; 2];

/// An arm angle, both triples there, and what the branch at hand costs.
#[derive(Debug, Clone, Copy)]
struct Point {
    psi: f64,
    at: Spokes,
    cost: f64,
    /// Derivative of the cost; not a number where it has none.
    slope: f64,
}

/// What the ranges of a piece say of the derivatives of the cost.
struct Slopes {
    first: Range,
    second: Range,
}

/// One branch of an elbow.
struct Branch<'w> {
    wheels: &'w [Wheel; 2],
    /// 1 or -1: the side of `t2` of each triple.
    sides: [f64; 2],
    costs: &'w Costs,
    /// What the fourth joint costs.
    fourth: f64,
}

impl Branch<'_> {
    /// The rate of a joint on this branch out of those of the first side.
    fn rate(&self, triple: usize, j: usize, rates: &[f64; 3]) -> f64 {
        if j == 1 { self.sides[triple] * rates[1] } else { rates[j] }
    }

    /// The cost at an arm angle, infinite outside the limits, and its derivative.
    fn point(&self, psi: f64, at: Spokes) -> Point {
        let (mut cost, mut slope) = (self.fourth, 0.0);
        for (triple, spoke) in at.iter().enumerate() {
            let rates = spoke.rates();
            for j in 0..3 {
                let x = turn(self.sides[triple], j, spoke);
                let weight = self.costs.weight(triple, j);
                let (least, off) = weight.least(Range { low: x, high: x });
                cost = self.costs.add(cost, least);
                let off = off.map_or(f64::NAN, |off| off.low);
                slope += weight.twice() * off * self.rate(triple, j, &rates);
            }
        }
        Point { psi, at, cost, slope }
    }

    /// Searches a piece on which all angles are monotone.
    fn search(
        &self,
        [from, to]: [&(f64, Spokes); 2],
        hunt: &mut Hunt<'_>,
        open: &mut Vec<[Point; 2]>,
    ) {
        // Inside the limits as a whole or not at all.
        let middle = self.at(0.5 * (from.0 + to.0));
        if middle.cost == f64::INFINITY {
            return;
        }
        hunt.consider(&middle);
        let first = self.point(from.0, from.1);
        let last = self.point(to.0, to.1);
        for (end, inwards) in [(&first, 1.0), (&last, -1.0)] {
            hunt.consider(end);
            // A limit that rounding puts the end past: just before it.
            if end.cost == f64::INFINITY {
                let near = end.psi + inwards * (0.25 * (to.0 - from.0)).min(1e-9);
                hunt.consider(&self.at(near));
            }
        }
        open.clear();
        open.extend([[middle, last], [first, middle]]);
        while let Some([first, last]) = open.pop() {
            hunt.spend();
            let wanted = hunt.wanted();
            let Some(slopes) = self.bounds(&first, &last, wanted) else { continue };
            let width = last.psi - first.psi;
            if width < SHORTEST {
                continue;
            }
            if let Some(slopes) = slopes {
                if slopes.first.low > 0.0
                    || slopes.first.high < 0.0
                    || least_by_slopes(&first, &last, &slopes) >= wanted
                {
                    continue;
                }
                if slopes.second.low > 0.0 {
                    hunt.consider(&self.stationary(first, last));
                    continue;
                }
            }
            let middle = self.at(first.psi + 0.5 * width);
            hunt.consider(&middle);
            open.extend([[middle, last], [first, middle]]);
        }
    }

    fn at(&self, psi: f64) -> Point {
        self.point(psi, spokes(self.wheels, psi))
    }

    /// The one place where the derivative vanishes on a piece where it grows, or the end
    /// next to it.
    fn stationary(&self, mut a: Point, mut b: Point) -> Point {
        if a.slope >= 0.0 {
            return a;
        }
        if b.slope <= 0.0 {
            return b;
        }
        // Regula falsi with the Illinois rule, and a halving now and then.
        let (mut at_a, mut at_b, mut last) = (a.slope, b.slope, 0.0f64);
        for step in 0..STEPS {
            let cut = a.psi + (b.psi - a.psi) * (at_a / (at_a - at_b));
            let halve = step % 4 == 3 || !(cut > a.psi && cut < b.psi);
            let x = self.at(if halve { 0.5 * (a.psi + b.psi) } else { cut });
            // The cost is quadratic here.
            if x.slope.abs() < 1e-6 || b.psi - a.psi < 1e-8 {
                return x;
            }
            if x.slope < 0.0 {
                (a, at_a) = (x, x.slope);
                at_b *= if last < 0.0 { 0.5 } else { 1.0 };
            } else {
                (b, at_b) = (x, x.slope);
                at_a *= if last > 0.0 { 0.5 } else { 1.0 };
            }
            last = x.slope;
        }
        a
    }

    /// `None` where the ranges of a piece allow no cost below `wanted`; else what they say
    /// of the derivatives, where they say anything.
    fn bounds(&self, first: &Point, last: &Point, wanted: f64) -> Option<Option<Slopes>> {
        let mut cost = self.fourth;
        let mut offs = [[None; 3]; 2];
        for (triple, offs) in offs.iter_mut().enumerate() {
            let ends = [&first.at[triple], &last.at[triple]];
            let of = (triple, self.sides[triple]);
            let least;
            (least, *offs) = self.costs.least(of, ends);
            cost = self.costs.together(cost, least);
            if cost >= wanted {
                return None;
            }
        }
        if self.costs.choice == Choice::Margin || last.psi - first.psi > 1.5 {
            return Some(None);
        }
        Some(self.slopes(first, last, &offs))
    }

    fn slopes(
        &self,
        first: &Point,
        last: &Point,
        offs: &[[Option<Range>; 3]; 2],
    ) -> Option<Slopes> {
        let none = Range { low: 0.0, high: 0.0 };
        let (mut slope, mut bend) = (none, none);
        for triple in 0..2 {
            let ends = (&first.at[triple], &last.at[triple]);
            let (rates, bends) = self.wheels[triple].rate_ranges(ends.0, ends.1)?;
            for j in 0..3 {
                let weight = self.costs.weight(triple, j);
                let side = if j == 1 { self.sides[triple] } else { 1.0 };
                let (rate, second) = (rates[j].by(side), bends[j].by(side));
                let off = offs[triple][j]?;
                slope = slope.plus(off.times(rate).by(weight.twice()));
                bend = bend.plus(rate.square().plus(off.times(second)).by(weight.twice()));
            }
        }
        Some(Slopes { first: slope, second: bend })
    }
}

/// A bound from below of the cost on a piece, from its values and slopes at the ends and
/// the ranges of its derivatives.
fn least_by_slopes(a: &Point, b: &Point, slopes: &Slopes) -> f64 {
    // An end outside the limits by rounding says nothing.
    if !(a.cost + b.cost).is_finite() {
        return f64::NEG_INFINITY;
    }
    let width = b.psi - a.psi;
    let ends = a.cost.min(b.cost);
    // Where the steepest line down from one end meets the steepest up to the other.
    let (down, up) = (slopes.first.low, slopes.first.high);
    let t = ((a.cost - b.cost + up * width) / (up - down)).clamp(0.0, width);
    let lines = ends.min(a.cost + down * t);
    // Up to the middle, and from there on, the least curved parabola from the nearer end.
    if !(a.slope + b.slope).is_finite() {
        return lines;
    }
    let bend = slopes.second.low.min(0.0) * width * width / 8.0;
    let half = 0.5 * width;
    let parabolas = (a.cost + a.slope * half + bend).min(b.cost - b.slope * half + bend);
    lines.max(ends.min(parabolas))
}

fn spokes(wheels: &[Wheel; 2], psi: f64) -> Spokes {
    let (s, c) = Real::sin_cos(psi);
    [wheels[0].at(s, c), wheels[1].at(s, c)]
}

/// Shoulder and wrist as functions of the arm angle.
pub(crate) fn wheels(bent: &Bent) -> [Wheel; 2] {
    [Wheel::new(bent.shoulder), Wheel::new(bent.wrist)]
}

/// Whether the proof holds for an arm.
pub(crate) fn applies(arm: &Srs) -> bool {
    let (shoulder, wrist) = arm.meetings();
    let right = |m: &Meeting| m.one.cosine == 0.0 && m.two.cosine == 0.0;
    right(shoulder) && right(wrist)
}

/// Lowers `best` to the least cost of all arm angles and branches of one target; returns how
/// far it may be above that: [`TOLERANCE`], more where [`PATIENCE`] ran out, or infinity.
pub(crate) fn certify(
    arm: &Srs,
    elbows: &[Bent],
    limits: &[Limit],
    centre: &[f64; JOINTS],
    choice: Choice,
    best: &mut Best,
) -> f64 {
    let hunt = &mut Hunt { best, tolerance: TOLERANCE, pieces: 0 };
    let weight = |j: usize| Weight::of(choice, limits[j], arm.offset(j), centre[j]);
    let costs = Costs { weights: std::array::from_fn(weight), choice };
    let joints = |first: usize| [0, 1, 2].map(|j| (limits[first + j], arm.offset(first + j)));
    let (one, two) = arm.meetings();
    let mut cuts = Vec::with_capacity(32);
    let mut points = Vec::with_capacity(32);
    let mut open = Vec::with_capacity(32);
    for bent in elbows {
        let q = bent.fourth + arm.offset(3);
        let off = costs.weights[3].least(Range { low: q, high: q }).0;
        let fourth = costs.add(0.0, off);
        if fourth >= hunt.wanted() {
            continue;
        }
        let wheels = wheels(bent);
        if wheels.iter().any(Wheel::is_in_line) {
            hunt.tolerance = f64::INFINITY;
            break;
        }
        cuts.clear();
        wheels[0].cuts(&mut cuts);
        wheels[1].cuts(&mut cuts);
        limit_cuts(one, &bent.shoulder, &joints(0), &mut cuts);
        limit_cuts(two, &bent.wrist, &joints(4), &mut cuts);
        cuts.retain(|x| x.is_finite());
        cuts.sort_by(f64::total_cmp);
        cuts.dedup_by(|a, b| (*a - *b).abs() < SHORTEST);
        points.clear();
        points.extend(cuts.iter().map(|&psi| (psi, spokes(&wheels, psi))));
        let Some(&(start, at)) = points.first() else { continue };
        points.push((start + TAU, at));
        for piece in points.windows(2) {
            let ends = [&piece[0], &piece[1]];
            let least = |triple: usize, side: f64| {
                let ends = ends.map(|end| &end.1[triple]);
                costs.least((triple, side), ends).0
            };
            let lasts = [1.0, -1.0].map(|side| (side, least(1, side)));
            for side in [1.0, -1.0] {
                let first = costs.together(fourth, least(0, side));
                for (other, last) in lasts {
                    if costs.together(first, last) < hunt.wanted() {
                        let sides = [side, other];
                        let branch = Branch { wheels: &wheels, sides, costs: &costs, fourth };
                        branch.search(ends, hunt, &mut open);
                    }
                }
            }
        }
    }
    hunt.tolerance
}
