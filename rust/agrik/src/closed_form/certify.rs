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
//! last axis of a triple come into line (`c^2 = 1`) and its angles jump.

use std::f64::consts::{PI, TAU};

use super::arm_angle::{Interval, Parts, allows, common, pieces, wrap};
use super::candidates::JOINTS;
use super::check::Limit;
use super::choose::Choice;
use super::srs::Srs;
use super::turn::Meeting;
use crate::lanes::atan2;

/// How far the cost may be above the least one: rad^2, or shares (their squares).
pub const TOLERANCE: f64 = 1e-9;
/// Pieces below this length are not halved, rad.
const SHORTEST: f64 = 1e-11;
/// Share of the rounding past a limit ([`super::check::SLACK`]) that is made use of here.
const HELD: f64 = 5e-11;
/// Steps of a bracketed root.
const STEPS: usize = 60;

/// The arm angle of least cost so far.
#[derive(Debug, Clone, Copy)]
pub(super) struct Best {
    pub cost: f64,
    pub psi: f64,
}

/// A range of numbers.
#[derive(Debug, Clone, Copy)]
struct Range {
    low: f64,
    high: f64,
}

impl Range {
    fn of(a: f64, b: f64) -> Self {
        Self { low: a.min(b), high: a.max(b) }
    }
    fn times(self, o: Self) -> Self {
        let all = [self.low * o.low, self.low * o.high, self.high * o.low, self.high * o.high];
        Self {
            low: all.into_iter().fold(f64::INFINITY, f64::min),
            high: all.into_iter().fold(f64::NEG_INFINITY, f64::max),
        }
    }
    fn plus(self, o: Self) -> Self {
        Self { low: self.low + o.low, high: self.high + o.high }
    }
    fn by(self, factor: f64) -> Self {
        Self::of(self.low * factor, self.high * factor)
    }
    fn square(self) -> Self {
        let (a, b) = (self.low * self.low, self.high * self.high);
        let low = if self.low <= 0.0 && self.high >= 0.0 { 0.0 } else { a.min(b) };
        Self { low, high: a.max(b) }
    }
    /// The inverse of positive numbers.
    fn inverse(self) -> Self {
        Self { low: 1.0 / self.high, high: 1.0 / self.low }
    }
}

/// How a joint's value counts.
#[derive(Debug, Clone, Copy)]
struct Weight {
    limit: Limit,
    offset: f64,
    centre: f64,
    factor: f64,
}

impl Weight {
    fn new(choice: Choice, limit: Limit, offset: f64, centre: f64) -> Self {
        let share = if limit.half == f64::INFINITY { 0.0 } else { 1.0 / limit.half.max(1e-9) };
        let (centre, factor) = match choice {
            Choice::Nearest => (centre, 1.0),
            Choice::Middle | Choice::Margin => (limit.middle, share),
        };
        Self { limit, offset, centre, factor }
    }

    /// The least distance from the centre, weighed, of the values of a range (turns, before
    /// the offset) and all that are whole turns away, inside the limits; infinite without
    /// any. And the range as distances, where just one count of turns is possible.
    fn least(&self, turns: Range) -> (f64, Option<Range>) {
        let low = turns.low - self.offset;
        let high = turns.high - self.offset;
        let (from, to) = if self.limit.half == f64::INFINITY {
            let k = ((self.centre - 0.5 * (low + high)) / TAU).round();
            (k - 1.0, k + 1.0)
        } else {
            let from = ((self.limit.lower - HELD - high) / TAU).ceil();
            (from, ((self.limit.upper + HELD - low) / TAU).floor())
        };
        let mut least = f64::INFINITY;
        let mut only = None;
        let mut k = from;
        while k <= to {
            let (a, b) = (low + k * TAU, high + k * TAU);
            let (a, b) = (a.max(self.limit.lower), b.min(self.limit.upper));
            // Past a limit by rounding only: the value is put on it.
            let (a, b) = (a.min(self.limit.upper), b.max(self.limit.lower));
            let off = (a - self.centre).max(self.centre - b).max(0.0);
            least = least.min(self.factor * off);
            only = (from == to)
                .then_some(Range { low: a - self.centre, high: b - self.centre });
            k += 1.0;
        }
        (least, only)
    }
}

/// Three joints whose axes meet at right angles, as functions of the arm angle.
struct Wheel {
    parts: Parts,
    a: f64,
    p: f64,
    /// Amplitude of `c`, squared.
    s2: f64,
}

/// A triple at one arm angle: `c`, then the turns for the first side of `t2`.
#[derive(Debug, Clone, Copy)]
struct Spoke {
    c: f64,
    turns: [f64; 3],
}

impl Wheel {
    fn new(parts: Parts) -> Self {
        // M' = [w] M at psi = 0.
        let row = |p: usize, i: usize| [0, 1, 2].map(|k| parts[p][k][i]);
        let at = |i: usize| [0, 1, 2].map(|k| parts[0][k][i] + parts[1][k][i]);
        let dot = |x: [f64; 3], y: [f64; 3]| x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
        let w = [dot(row(2, 2), at(1)), dot(row(2, 0), at(2)), dot(row(2, 1), at(0))];
        let (a, p) = (w[2], dot(w, parts[0][2]));
        let s2 = ((1.0 - a * a) * (1.0 - p * p)).max(0.0);
        Self { parts, a, p, s2 }
    }

    fn at(&self, psi: f64) -> Spoke {
        let (s, c) = psi.sin_cos();
        let m = |k: usize, i: usize| {
            self.parts[0][k][i] + c * self.parts[1][k][i] + s * self.parts[2][k][i]
        };
        let (x, y, z) = (m(2, 0), m(2, 1), m(2, 2));
        let turns = [atan2(y, x), atan2((x * x + y * y).sqrt(), -z), -atan2(m(1, 2), m(0, 2))];
        Spoke { c: z, turns }
    }

    /// Where `c` turns back, and where `t1` or `t3` does.
    fn cuts(&self, out: &mut Vec<f64>) {
        let [k0, k1, k2] = [0, 1, 2].map(|p| self.parts[p][2][2]);
        let (top, size) = (k2.atan2(k1), k1.hypot(k2));
        out.extend([wrap(top), wrap(top + PI)]);
        for (n, d) in [(self.a, self.p), (self.p, self.a)] {
            let share = (n / d - k0) / size;
            if share.abs() < 1.0 {
                let half = share.acos();
                out.extend([wrap(top + half), wrap(top - half)]);
            }
        }
    }

    /// Rates of the three turns, for `c` and the sign of `c'`, on the first side.
    fn rates(&self, c: f64, sign: f64) -> [f64; 3] {
        let d = ((1.0 - c) * (1.0 + c)).max(f64::MIN_POSITIVE);
        let off = c - self.a * self.p;
        let slope = sign * (self.s2 - off * off).max(0.0).sqrt();
        [(self.a - self.p * c) / d, slope / d.sqrt(), (self.p - self.a * c) / d]
    }

    /// Ranges of the rates and of their derivatives over a range of `c`.
    fn rate_ranges(&self, c: Range, sign: f64) -> Option<([Range; 3], [Range; 3])> {
        let (a, p) = (self.a, self.p);
        let d = Range { low: 1.0 - c.square().high, high: 1.0 - c.square().low };
        if d.low < 1e-9 {
            return None;
        }
        let over = d.inverse();
        let linear = |x: f64, y: f64| Range::of(x - y * c.low, x - y * c.high);
        let off = Range { low: c.low - a * p, high: c.high - a * p }.square();
        let steep = Range {
            low: (self.s2 - off.high).max(0.0).sqrt(),
            high: (self.s2 - off.low).max(0.0).sqrt(),
        }
        .by(sign);
        let root = Range { low: d.low.sqrt(), high: d.high.sqrt() }.inverse();
        let rates = [linear(a, p).times(over), steep.times(root), linear(p, a).times(over)];
        // d/dc of (a - p c) / (1 - c^2) is (2 a c - p (1 + c^2)) / (1 - c^2)^2.
        let over2 = over.square();
        let bend = |a: f64, p: f64| {
            let one = Range { low: 1.0 + c.square().low, high: 1.0 + c.square().high };
            let n = Range::of(2.0 * a * c.low, 2.0 * a * c.high).plus(one.by(-p));
            n.times(over2).times(steep)
        };
        let back = Range { low: a * p - c.high, high: a * p - c.low };
        let second = back.times(root).plus(c.times(steep.square()).times(root).times(over));
        Some((rates, [bend(a, p), second, bend(p, a)]))
    }
}

/// One branch on a piece of the circle.
struct Branch<'w> {
    wheels: [&'w Wheel; 2],
    /// 1 or -1: the side of `t2` of each triple.
    sides: [f64; 2],
    weights: &'w [Weight; JOINTS],
    choice: Choice,
    /// What the fourth joint costs.
    fourth: f64,
}

/// Both triples at one arm angle.
type Spokes = [Spoke; 2];

impl Branch<'_> {
    fn at(&self, psi: f64) -> Spokes {
        [self.wheels[0].at(psi), self.wheels[1].at(psi)]
    }

    /// The turn of joint `j` (of a triple) on this branch.
    fn turn(&self, triple: usize, j: usize, spoke: &Spoke) -> f64 {
        let side = self.sides[triple];
        match j {
            1 => side * spoke.turns[1],
            _ if side > 0.0 => spoke.turns[j],
            _ => spoke.turns[j] + PI,
        }
    }

    fn weight(&self, triple: usize, j: usize) -> &Weight {
        &self.weights[4 * triple + j]
    }

    fn add(&self, sum: f64, least: f64) -> f64 {
        if self.choice == Choice::Margin { sum.max(least) } else { sum + least * least }
    }

    /// The cost at an arm angle, infinite outside the limits.
    fn cost(&self, spokes: &Spokes) -> f64 {
        let mut cost = self.fourth;
        for (triple, spoke) in spokes.iter().enumerate() {
            for j in 0..3 {
                let x = self.turn(triple, j, spoke);
                cost = self.add(cost, self.weight(triple, j).least(Range::of(x, x)).0);
            }
        }
        cost
    }

    /// The derivative of the cost by the arm angle; `signs` are those of `c'`.
    fn slope(&self, spokes: &Spokes, signs: [f64; 2]) -> f64 {
        let mut slope = 0.0;
        for (triple, spoke) in spokes.iter().enumerate() {
            let rates = self.wheels[triple].rates(spoke.c, signs[triple]);
            for (j, rate) in rates.into_iter().enumerate() {
                let x = self.turn(triple, j, spoke);
                let weight = self.weight(triple, j);
                let rate = if j == 1 { self.sides[triple] * rate } else { rate };
                let off = weight.least(Range::of(x, x)).1.map_or(f64::NAN, |off| off.low);
                slope += 2.0 * weight.factor * weight.factor * off * rate;
            }
        }
        slope
    }

    fn consider(&self, psi: f64, spokes: &Spokes, best: &mut Best) {
        let cost = self.cost(spokes);
        if cost < best.cost {
            *best = Best { cost, psi };
        }
    }

    /// Searches a piece on which all angles are monotone.
    fn search(&self, piece: Interval, best: &mut Best) {
        let ends = (self.at(piece.lower), self.at(piece.upper));
        for (end, at, inwards) in [(piece.lower, &ends.0, 1.0), (piece.upper, &ends.1, -1.0)] {
            self.consider(end, at, best);
            // A limit that rounding puts the end past: just before it.
            if self.cost(at) == f64::INFINITY {
                let near = end + inwards * (0.25 * (piece.upper - piece.lower)).min(1e-9);
                self.consider(near, &self.at(near), best);
            }
        }
        let mut open = vec![(piece, ends)];
        while let Some((piece, (first, last))) = open.pop() {
            let Some(bounds) = self.bounds(piece, &first, &last, best.cost - TOLERANCE) else {
                continue;
            };
            let width = piece.upper - piece.lower;
            if width < SHORTEST {
                continue;
            }
            let mut psi = piece.lower + 0.5 * width;
            if let Some((slope, bend, signs)) = bounds {
                if slope.low > 0.0 || slope.high < 0.0 {
                    continue;
                }
                if bend.low > 0.0 {
                    psi = self.stationary(piece, signs);
                    self.consider(psi, &self.at(psi), best);
                    continue;
                }
            }
            let at = self.at(psi);
            self.consider(psi, &at, best);
            if !(psi > piece.lower && psi < piece.upper) {
                psi = piece.lower + 0.5 * width;
            }
            open.push((Interval { lower: piece.lower, upper: psi }, (first, at)));
            open.push((Interval { lower: psi, upper: piece.upper }, (at, last)));
        }
    }

    /// The one zero of the derivative on a piece where it grows, or the end next to it.
    fn stationary(&self, piece: Interval, signs: [f64; 2]) -> f64 {
        let g = |psi: f64| self.slope(&self.at(psi), signs);
        let (mut a, mut b) = (piece.lower, piece.upper);
        let (mut at_a, mut at_b) = (g(a), g(b));
        if at_a >= 0.0 {
            return a;
        }
        if at_b <= 0.0 {
            return b;
        }
        let mut last = 0.0f64;
        for step in 0..STEPS {
            let cut = a + (b - a) * (at_a / (at_a - at_b));
            let x = if step % 4 == 3 || !(cut > a && cut < b) { 0.5 * (a + b) } else { cut };
            let y = g(x);
            // The cost is quadratic here.
            if y.abs() < 1e-6 || b - a < 1e-8 {
                return x;
            }
            if y < 0.0 {
                (a, at_a) = (x, y);
                at_b *= if last < 0.0 { 0.5 } else { 1.0 };
            } else {
                (b, at_b) = (x, y);
                at_a *= if last > 0.0 { 0.5 } else { 1.0 };
            }
            last = y;
        }
        0.5 * (a + b)
    }

    /// `None` where the ranges of a piece allow no cost below `wanted`; else ranges of the
    /// cost's derivatives and the signs of `c'`, where they are known.
    #[allow(clippy::type_complexity)]
    fn bounds(
        &self,
        piece: Interval,
        first: &Spokes,
        last: &Spokes,
        wanted: f64,
    ) -> Option<Option<(Range, Range, [f64; 2])>> {
        let mut cost = self.fourth;
        let mut signs = [0.0; 2];
        let mut offs = [[None; 3]; 2];
        for triple in 0..2 {
            let (from, to) = (&first[triple], &last[triple]);
            signs[triple] = if to.c >= from.c { 1.0 } else { -1.0 };
            let middle = self.wheels[triple].rates(0.5 * (from.c + to.c), signs[triple]);
            for j in 0..3 {
                let (x, y) = (self.turn(triple, j, from), self.turn(triple, j, to));
                let rate = if j == 1 { self.sides[triple] * middle[1] } else { middle[j] };
                let range = if j == 1 { Range::of(x, y) } else { swept(x, y, rate) };
                let (least, off) = self.weight(triple, j).least(range);
                cost = self.add(cost, least);
                offs[triple][j] = off;
            }
        }
        if cost >= wanted {
            return None;
        }
        if self.choice == Choice::Margin || piece.upper - piece.lower > 1.0 {
            return Some(None);
        }
        Some(self.derivatives(first, last, &offs, signs))
    }

    fn derivatives(
        &self,
        first: &Spokes,
        last: &Spokes,
        offs: &[[Option<Range>; 3]; 2],
        signs: [f64; 2],
    ) -> Option<(Range, Range, [f64; 2])> {
        let none = Range { low: 0.0, high: 0.0 };
        let (mut slope, mut bend) = (none, none);
        for triple in 0..2 {
            let c = Range::of(first[triple].c, last[triple].c);
            let (rates, bends) = self.wheels[triple].rate_ranges(c, signs[triple])?;
            for j in 0..3 {
                let weight = self.weight(triple, j);
                let side = if j == 1 { self.sides[triple] } else { 1.0 };
                let (rate, second) = (rates[j].by(side), bends[j].by(side));
                let off = offs[triple][j]?;
                let twice = 2.0 * weight.factor * weight.factor;
                slope = slope.plus(off.times(rate).by(twice));
                bend = bend.plus(rate.square().plus(off.times(second)).by(twice));
            }
        }
        Some((slope, bend, signs))
    }
}

/// The range that an angle sweeps from `x` to `y`, both up to whole turns, in the direction
/// of its rate.
fn swept(x: f64, y: f64, rate: f64) -> Range {
    // Less than a turn; what rounding leaves short of it is none at all.
    let turn = |d: f64| {
        let d = d.rem_euclid(TAU);
        if d > TAU - 1e-9 { 0.0 } else { d }
    };
    if rate >= 0.0 {
        Range { low: x, high: x + turn(y - x) }
    } else {
        Range { low: x - turn(x - y), high: x }
    }
}

/// Whether the proof holds for an arm.
pub(super) fn applies(arm: &Srs) -> bool {
    let (shoulder, wrist) = arm.meetings();
    let right = |m: &Meeting| m.one.cosine == 0.0 && m.two.cosine == 0.0;
    right(shoulder) && right(wrist)
}

/// Lowers `best` to the least cost of all arm angles and branches of one target.
pub(super) fn certify(
    arm: &Srs,
    elbows: &[super::arm_angle::Bent],
    limits: &[Limit],
    centre: &[f64; JOINTS],
    choice: Choice,
    best: &mut Best,
) {
    let weights: [Weight; JOINTS] =
        std::array::from_fn(|j| Weight::new(choice, limits[j], arm.offset(j), centre[j]));
    for bent in elbows {
        let q = bent.fourth + arm.offset(3);
        let off = weights[3].least(Range::of(q, q)).0;
        let fourth = if choice == Choice::Margin { off } else { off * off };
        if fourth >= best.cost - TOLERANCE {
            continue;
        }
        let (one, two) = arm.meetings();
        let joints = |first: usize| [0, 1, 2].map(|j| (limits[first + j], arm.offset(first + j)));
        let wheels = [Wheel::new(bent.shoulder), Wheel::new(bent.wrist)];
        let mut cuts = Vec::with_capacity(16);
        wheels[0].cuts(&mut cuts);
        wheels[1].cuts(&mut cuts);
        cuts.sort_by(f64::total_cmp);
        let lasts = [0, 1].map(|j| pieces(two, &bent.wrist, j, &joints(4)));
        for (i, side) in [1.0, -1.0].into_iter().enumerate() {
            let first = pieces(one, &bent.shoulder, i, &joints(0));
            for (last, other) in lasts.iter().zip([1.0, -1.0]) {
                let branch = Branch {
                    wheels: [&wheels[0], &wheels[1]],
                    sides: [side, other],
                    weights: &weights,
                    choice,
                    fourth,
                };
                for interval in common(&first, last) {
                    for piece in split(interval, &cuts) {
                        branch.search(piece, best);
                    }
                }
            }
        }
    }
}

/// An interval, cut at angles that count up to whole turns.
fn split(interval: Interval, cuts: &[f64]) -> impl Iterator<Item = Interval> {
    let mut at: Vec<f64> = vec![interval.lower];
    for turn in [-TAU, 0.0, TAU, 2.0 * TAU] {
        let inside = |x: &f64| *x > interval.lower && *x < interval.upper;
        at.extend(cuts.iter().map(|x| x + turn).filter(inside));
    }
    at.push(interval.upper);
    (1..at.len()).map(move |i| Interval { lower: at[i - 1], upper: at[i] })
}
