//! Three joints whose axes meet at right angles, as functions of the arm angle: turns, rates
//! and ranges of both; see [`super::certify`] for the formulas.

use std::f64::consts::PI;

use super::arm_angle::{Parts, wrap};
use crate::lanes::{atan2_each, hypotenuse};

/// A range of numbers.
#[derive(Debug, Clone, Copy)]
pub struct Range {
    pub low: f64,
    pub high: f64,
}

impl Range {
    pub fn of(a: f64, b: f64) -> Self {
        Self { low: a.min(b), high: a.max(b) }
    }
    pub fn times(self, o: Self) -> Self {
        let all = [self.low * o.low, self.low * o.high, self.high * o.low, self.high * o.high];
        Self {
            low: all.into_iter().fold(f64::INFINITY, f64::min),
            high: all.into_iter().fold(f64::NEG_INFINITY, f64::max),
        }
    }
    pub fn plus(self, o: Self) -> Self {
        Self { low: self.low + o.low, high: self.high + o.high }
    }
    pub fn by(self, factor: f64) -> Self {
        Self::of(self.low * factor, self.high * factor)
    }
    pub fn square(self) -> Self {
        let (a, b) = (self.low * self.low, self.high * self.high);
        let low = if self.low <= 0.0 && self.high >= 0.0 { 0.0 } else { a.min(b) };
        Self { low, high: a.max(b) }
    }
    /// The inverse of positive numbers.
    pub fn inverse(self) -> Self {
        Self { low: 1.0 / self.high, high: 1.0 / self.low }
    }
}

/// Three joints whose axes meet at right angles, as functions of the arm angle.
pub struct Wheel {
    parts: Parts,
    a: f64,
    p: f64,
    /// Amplitude of `c`, squared.
    s2: f64,
}

/// A triple at one arm angle: `c`, and the turns for the first side of `t2`.
#[derive(Debug, Clone, Copy)]
pub struct Spoke {
    pub c: f64,
    pub turns: [f64; 3],
}

impl Wheel {
    pub fn new(parts: Parts) -> Self {
        // M' = [w] M at psi = 0.
        let row = |p: usize, i: usize| [0, 1, 2].map(|k| parts[p][k][i]);
        let at = |i: usize| [0, 1, 2].map(|k| parts[0][k][i] + parts[1][k][i]);
        let dot = |x: [f64; 3], y: [f64; 3]| x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
        let w = [dot(row(2, 2), at(1)), dot(row(2, 0), at(2)), dot(row(2, 1), at(0))];
        let (a, p) = (w[2], dot(w, parts[0][2]));
        let s2 = ((1.0 - a * a) * (1.0 - p * p)).max(0.0);
        Self { parts, a, p, s2 }
    }

    pub fn at(&self, s: f64, c: f64) -> Spoke {
        let m = |k: usize, i: usize| {
            self.parts[0][k][i] + c * self.parts[1][k][i] + s * self.parts[2][k][i]
        };
        let (x, y, z) = (m(2, 0), m(2, 1), m(2, 2));
        let across = (x * x + y * y).sqrt();
        let [first, second, third] = atan2_each([y, across, m(1, 2)], [x, -z, m(0, 2)]);
        Spoke { c: z, turns: [first, second, -third] }
    }

    /// Where `c` turns back, and where `t1` or `t3` does.
    pub fn cuts(&self, out: &mut Vec<f64>) {
        let [k0, k1, k2] = [0, 1, 2].map(|p| self.parts[p][2][2]);
        let (top, size) = (k2.atan2(k1), hypotenuse(k1, k2));
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
    pub fn rates(&self, c: f64, sign: f64) -> [f64; 3] {
        let d = ((1.0 - c) * (1.0 + c)).max(f64::MIN_POSITIVE);
        let off = c - self.a * self.p;
        let slope = sign * (self.s2 - off * off).max(0.0).sqrt();
        [(self.a - self.p * c) / d, slope / d.sqrt(), (self.p - self.a * c) / d]
    }

    /// Ranges of the rates and of their derivatives over a range of `c`.
    pub fn rate_ranges(&self, c: Range, sign: f64) -> Option<([Range; 3], [Range; 3])> {
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

/// The whole number next below a small number, without a library call.
pub fn floor(x: f64) -> f64 {
    let cut = f64::from(x as i32);
    if cut > x { cut - 1.0 } else { cut }
}
