//! What the joints of an S-R-S arm cost, exactly and over ranges of arm angles; see
//! [`super::certify`].

use std::f64::consts::{PI, TAU};

use super::proof_ranges::{Spoke, floor};
use crate::closed_form::branch::choice::Choice;
use crate::closed_form::geometry::candidate::JOINTS;
use crate::closed_form::geometry::limit::Limit;
use crate::closed_form::geometry::range::Range;

/// Share of the rounding past a limit ([`super::check::SLACK`]) that is made use of here.
const HELD: f64 = 5e-11;

/// How a joint's value counts.
#[derive(Debug, Clone, Copy)]
pub struct Weight {
    limit: Limit,
    offset: f64,
    centre: f64,
    factor: f64,
}

impl Weight {
    pub fn of(choice: Choice, limit: Limit, offset: f64, centre: f64) -> Self {
        let (centre, factor) = match choice {
            Choice::Nearest => (centre, 1.0),
            Choice::Middle | Choice::Margin => (limit.middle, limit.shares()),
        };
        Self { limit, offset, centre, factor }
    }

    pub fn twice(&self) -> f64 {
        2.0 * self.factor * self.factor
    }

    /// The least distance from the centre, weighed, of the values of a range (turns, before
    /// the offset) and all that are whole turns away, inside the limits; infinite without
    /// any. And the range as distances, where just one count of turns is possible.
    pub fn least(&self, turns: Range) -> (f64, Option<Range>) {
        let low = turns.low - self.offset;
        let high = turns.high - self.offset;
        let (from, to) = if self.limit.half == f64::INFINITY {
            let nearest = |x: f64| floor((self.centre - x) * (1.0 / TAU) + 0.5);
            (nearest(high), nearest(low))
        } else {
            let from = -floor((high - self.limit.lower + HELD) * (1.0 / TAU));
            (from, floor((self.limit.upper + HELD - low) * (1.0 / TAU)))
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
            only = (from == to).then_some(Range { low: a - self.centre, high: b - self.centre });
            k += 1.0;
        }
        (least, only)
    }
}

/// How joints count.
pub struct Costs {
    pub weights: [Weight; JOINTS],
    pub choice: Choice,
}

impl Costs {
    pub fn weight(&self, triple: usize, j: usize) -> &Weight {
        &self.weights[4 * triple + j]
    }

    /// The cost of a joint on top of that of others; of its weighed distance.
    pub fn add(&self, sum: f64, least: f64) -> f64 {
        if self.choice == Choice::Margin { sum.max(least) } else { sum + least * least }
    }

    /// The least cost of a triple on a piece, and the ranges of its joints' distances.
    pub fn least(
        &self,
        (triple, side): (usize, f64),
        [from, to]: [&Spoke; 2],
    ) -> (f64, [Option<Range>; 3]) {
        let ways = from.ways(to);
        let (mut cost, mut offs) = (0.0, [None; 3]);
        for j in 0..3 {
            let (x, y) = (turn(side, j, from), turn(side, j, to));
            let range = if j == 1 { Range::of(x, y) } else { swept(x, y, ways[j]) };
            let least;
            (least, offs[j]) = self.weight(triple, j).least(range);
            cost = self.add(cost, least);
        }
        (cost, offs)
    }

    /// The cost of parts together.
    pub fn together(&self, a: f64, b: f64) -> f64 {
        if self.choice == Choice::Margin { a.max(b) } else { a + b }
    }
}

/// The turn of joint `j` of a triple on a side.
pub fn turn(side: f64, j: usize, spoke: &Spoke) -> f64 {
    match j {
        1 => side * spoke.turns[1],
        _ if side > 0.0 => spoke.turns[j],
        _ => spoke.turns[j] + PI,
    }
}

/// The range that an angle sweeps from `x` to `y`, both up to whole turns, in the direction
/// of its rate.
fn swept(x: f64, y: f64, rate: f64) -> Range {
    // Less than a turn; what rounding leaves short of it is none at all.
    let turn = |d: f64| {
        let d = d - TAU * floor(d * (1.0 / TAU));
        if d > TAU - 1e-9 { 0.0 } else { d }
    };
    if rate >= 0.0 {
        Range { low: x, high: x + turn(y - x) }
    } else {
        Range { low: x - turn(x - y), high: x }
    }
}
