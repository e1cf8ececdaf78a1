//! Three joints whose axes meet at right angles, as functions of the arm angle: turns, rates
//! and ranges of both; see [`super::certify`] for the formulas.

use std::f64::consts::PI;

use crate::closed_form::geometry::pieces::{Parts, wrap};
use crate::closed_form::geometry::range::Range;
use crate::lanes::{atan2_each, hypotenuse};

/// Below this `1 - c^2` nothing is known of rates: the angles are noise.
const IN_LINE: f64 = 1e-14;
/// What rounding may do to the entries of a rotation.
const ROUNDING: f64 = 1e-15;

/// Three joints whose axes meet at right angles, as functions of the arm angle.
pub struct Wheel {
    parts: Parts,
    a: f64,
    p: f64,
    /// Amplitude of `c`.
    size: f64,
}

/// A triple at one arm angle.
#[derive(Debug, Clone, Copy)]
pub struct Spoke {
    pub c: f64,
    /// Derivative of `c`.
    slope: f64,
    /// `1 - c^2`, which the difference would not give exactly where it is small.
    d: f64,
    /// Rates of `t1` and `t3` times `d`; linear in `c`.
    n: [f64; 2],
    /// Turns for the first side of `t2`.
    pub turns: [f64; 3],
}

impl Spoke {
    /// Rates of the three turns on the first side.
    pub fn rates(&self) -> [f64; 3] {
        let d = self.d.max(f64::MIN_POSITIVE);
        [self.n[0] / d, self.slope / d.sqrt(), self.n[1] / d]
    }

    /// Which way `t1`, `t2` and `t3` turn from here on to another spoke, if none turns back
    /// on the way.
    pub fn ways(&self, to: &Self) -> [f64; 3] {
        [self.n[0] + to.n[0], self.slope + to.slope, self.n[1] + to.n[1]]
    }
}

impl Wheel {
    pub fn new(parts: Parts) -> Self {
        // M' = [w] M at psi = 0.
        let row = |p: usize, i: usize| [0, 1, 2].map(|k| parts[p][k][i]);
        let at = |i: usize| [0, 1, 2].map(|k| parts[0][k][i] + parts[1][k][i]);
        let dot = |x: [f64; 3], y: [f64; 3]| x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
        let w = [dot(row(2, 2), at(1)), dot(row(2, 0), at(2)), dot(row(2, 1), at(0))];
        let (a, p) = (w[2], dot(w, parts[0][2]));
        Self { parts, a, p, size: hypotenuse(parts[1][2][2], parts[2][2][2]) }
    }

    /// The arm angle at which `c` is greatest; half a turn on it is least.
    fn top(&self) -> f64 {
        self.parts[2][2][2].atan2(self.parts[1][2][2])
    }

    /// First and last axis are in line at every arm angle.
    pub fn is_in_line(&self) -> bool {
        [(0.0, 1.0), (0.0, -1.0), (1.0, 0.0)].into_iter().all(|(s, c)| self.at(s, c).d < IN_LINE)
    }

    pub fn at(&self, s: f64, c: f64) -> Spoke {
        let [constant, cosine, sine] = &self.parts;
        let m = |k: usize, i: usize| constant[k][i] + c * cosine[k][i] + s * sine[k][i];
        let rate = |k: usize, i: usize| c * sine[k][i] - s * cosine[k][i];
        let (x, y, u, v) = (m(2, 0), m(2, 1), m(0, 2), m(1, 2));
        let z = m(2, 2);
        let d = x * x + y * y;
        let [first, second, third] = atan2_each([y, d.sqrt(), v], [x, -z, u]);
        Spoke {
            c: z,
            slope: rate(2, 2),
            d,
            n: [x * rate(2, 1) - y * rate(2, 0), v * rate(0, 2) - u * rate(1, 2)],
            turns: [first, second, -third],
        }
    }

    /// Where `c` turns back, and where `t1` or `t3` does.
    pub fn cuts(&self, out: &mut Vec<f64>) {
        out.extend([wrap(self.top()), wrap(self.top() + PI)]);
        // A rate's numerator is a constant, a cosine and a sine part as well.
        let [east, north, west, south] =
            [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)].map(|(s, c)| self.at(s, c).n);
        for i in 0..2 {
            let (x, y) = (east[i] - west[i], north[i] - south[i]);
            let share = -(east[i] + west[i]) / hypotenuse(x, y);
            if share.abs() < 1.0 {
                let (top, half) = (y.atan2(x), share.acos());
                out.extend([wrap(top + half), wrap(top - half)]);
            }
        }
    }

    /// Ranges of the rates and of their derivatives between two spokes between which none
    /// turns back.
    pub fn rate_ranges(&self, from: &Spoke, to: &Spoke) -> Option<([Range; 3], [Range; 3])> {
        let c = Range::of(from.c, to.c);
        let mut d = Range::of(from.d, to.d);
        if d.low < IN_LINE {
            return None;
        }
        if c.low < 0.0 && c.high > 0.0 {
            d.high = 1.0;
        }
        let over = d.inverse();
        let root = Range { low: over.low.sqrt(), high: over.high.sqrt() };
        let off = [from, to].map(|spoke| self.parts[0][2][2] - spoke.c);
        // The derivative of c is steepest where c is in the middle of its range.
        let mut steep = Range::of(from.slope.abs(), to.slope.abs());
        if off[0] * off[1] < 0.0 {
            steep.high = self.size;
        }
        let steep = steep.by(if from.ways(to)[1] >= 0.0 { 1.0 } else { -1.0 });
        let noise = ROUNDING * root.high;
        let [first, third] = [0, 1].map(|i| Range::of(from.n[i], to.n[i]).times(over).wider(noise));
        let second = steep.times(root).wider(noise);
        // d/dpsi of n / d, where d/dpsi of n1 is -p c' and of d is -2 c c'.
        let bend = |rate: Range, axis: f64| {
            let n = c.times(rate).by(2.0).plus(Range { low: -axis, high: -axis });
            n.times(steep).times(over).wider(ROUNDING * over.high)
        };
        let back = Range::of(off[0], off[1]).plus(c.times(second.square())).times(root);
        let bends = [bend(first, self.p), back.wider(ROUNDING * over.high), bend(third, self.a)];
        Some(([first, second, third], bends))
    }
}

/// The whole number next below a small number, without a library call.
pub fn floor(x: f64) -> f64 {
    let cut = f64::from(x as i32);
    if cut > x { cut - 1.0 } else { cut }
}
