//! The first three joints of an arm with a spherical wrist, where the wrist's centre is known
//! to within a distance: arcs that hold the turns of every arm that puts it there.

use std::f64::consts::PI;

use super::shoulder::{Kind, Shoulder};
use crate::closed_form::geometry::enclosure::{Arc, arc_cosines, linear_arcs};
use crate::closed_form::geometry::range::Range;
use crate::lanes::{V3, hypotenuse};

/// Pieces of the turn that the equation of the fourth degree is first looked at on.
const PIECES: usize = 64;
/// Half the length of pieces that are not divided any more, rad.
const SHORTEST: f64 = 1e-6;
/// Most arcs of that equation; where more are left, or more pieces were looked at, it says
/// nothing.
const MOST_ARCS: usize = 16;
const MOST_PIECES: usize = 4096;

/// The squares of a range of numbers from 0 up.
fn squares(range: Range) -> Range {
    Range { low: range.low * range.low, high: range.high * range.high }
}

/// Numbers within `by` of `x` that are not below 0.
fn lengths(x: f64, by: f64) -> Range {
    Range { low: (x - by).max(0.0), high: x + by }
}

impl Shoulder {
    /// Arcs of the three turns of every arm that puts the wrist's centre within `off` of `p`,
    /// seen from the first joint.
    pub fn arcs(&self, p: V3<f64>, off: f64) -> Vec<[Arc; 3]> {
        let mut out = match self.kind() {
            Kind::ParallelElbow => self.parallel_elbow_arcs(p, off),
            Kind::ParallelBase | Kind::MeetingBase => self.separate_arcs(p, off),
            Kind::General => self.general_arcs(p, off),
        };
        for arm in &mut out {
            arm[2] = arm[2].turned(-self.phase_angle());
        }
        out
    }

    fn parallel_elbow_arcs(&self, p: V3<f64>, off: f64) -> Vec<[Arc; 3]> {
        let one = self.one;
        let along = self.two.d + self.two.cosine * self.height;
        let across = (p[2] - (one.d + one.cosine * along)) / one.sine;
        let across_off = off / one.sine.abs();
        let y1 = across * one.cosine - one.sine * along;
        let y1_off = across_off * one.cosine.abs();
        let ring = squares(lengths(hypotenuse(p[0], p[1]), off));
        let y2 = squares(lengths(y1.abs(), y1_off));
        let (low, high) = (ring.low - y2.high, ring.high - y2.low);
        if high < 0.0 {
            return Vec::new();
        }
        let (low, high) = (low.max(0.0).sqrt(), high.sqrt());
        let (middle, x1_off) = (0.5 * (low + high), 0.5 * (high - low));
        let toward = Arc::toward(p[0], p[1], off);
        let (upper, fore) = (self.two.a, self.radius);
        let mut out = Vec::with_capacity(4);
        for front in [1.0, -1.0] {
            let x1 = front * middle;
            let first = toward.minus(Arc::toward(x1, y1, hypotenuse(x1_off, y1_off)));
            let x = x1 - one.a;
            let x2 = squares(lengths(x.abs(), x1_off));
            let span = x2.plus(squares(lengths(across.abs(), across_off)));
            let fixed = upper * upper + fore * fore;
            let cosine = Range { low: span.low - fixed, high: span.high - fixed };
            let Some(bend) = arc_cosines(cosine.by(0.5 / (upper * fore))) else { continue };
            let out_there = Arc::toward(x, across, hypotenuse(x1_off, across_off));
            for sign in [1.0, -1.0] {
                let third = Arc { middle: sign * bend.middle, ..bend };
                let (s, c) = third.middle.sin_cos();
                let (vx, vy) = (upper + fore * c, fore * s * self.two.cosine);
                let second = out_there.minus(Arc::toward(vx, vy, fore * third.chord()));
                out.push([first, second, third]);
            }
        }
        out
    }

    fn separate_arcs(&self, p: V3<f64>, off: f64) -> Vec<[Arc; 3]> {
        let (one, two, r) = (self.one, self.two, self.radius);
        let up = p[2] - one.d;
        let ring = hypotenuse(p[0], p[1]);
        let third = if self.kind() == Kind::ParallelBase {
            let c = up * one.cosine - (two.d + two.cosine * self.height);
            linear_arcs(0.0, two.sine * r, 0.0, Range::about(c, off))
        } else {
            let fixed = two.a * two.a
                + two.d * two.d
                + r * r
                + self.height * self.height
                + 2.0 * two.d * two.cosine * self.height;
            let square = squares(lengths(hypotenuse(ring, up), off));
            let c = Range { low: square.low - fixed, high: square.high - fixed };
            linear_arcs(2.0 * two.a * r, 2.0 * two.d * two.sine * r, 0.0, c)
        };
        let mut out = Vec::with_capacity(4);
        for third in third.into_iter().flatten() {
            let v = self.seen_from_second(third.middle.sin_cos());
            let v_off = r * third.chord();
            let lean = if self.kind() == Kind::ParallelBase {
                let flat = squares(lengths(hypotenuse(v[0], v[1]), v_off));
                let ring = squares(lengths(ring, off));
                let low = ring.low - one.a * one.a - flat.high;
                let high = ring.high - one.a * one.a - flat.low;
                linear_arcs(v[0], -v[1], v_off, Range { low, high }.by(0.5 / one.a))
            } else {
                let c = (up - v[2] * one.cosine) / one.sine;
                let c_off = (off + one.cosine.abs() * v_off) / one.sine.abs();
                linear_arcs(v[1], v[0], v_off, Range::about(c, c_off))
            };
            for second in lean.into_iter().flatten() {
                let first = self.first_arc(p, off, v, v_off, second);
                out.push([first, second, third]);
            }
        }
        out
    }

    /// The first turn after the others.
    fn first_arc(&self, p: V3<f64>, off: f64, v: V3<f64>, v_off: f64, second: Arc) -> Arc {
        let (s, c) = second.middle.sin_cos();
        let (x, y) = (v[0] * c - v[1] * s, v[0] * s + v[1] * c);
        let y = y * self.one.cosine - v[2] * self.one.sine;
        let turned = (hypotenuse(v[0], v[1]) + v_off) * second.chord();
        let out_there = Arc::toward(x + self.one.a, y, v_off + turned);
        Arc::toward(p[0], p[1], off).minus(out_there)
    }

    fn general_arcs(&self, p: V3<f64>, off: f64) -> Vec<[Arc; 3]> {
        let one = self.one;
        let up = p[2] - one.d;
        let ring = p[0] * p[0] + p[1] * p[1];
        let far = hypotenuse(ring.sqrt(), up);
        let square_off = 2.0 * far * off + off * off;
        let x_off = 0.5 * square_off / one.a.abs();
        let y_off = off / one.sine.abs();
        let mut out = Vec::with_capacity(4);
        for third in self.third_arcs(up, ring, x_off, y_off) {
            let v = self.seen_from_second(third.middle.sin_cos());
            let v_off = self.radius * third.chord();
            let v2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
            let v2_off = 2.0 * v2.sqrt() * v_off + v_off * v_off;
            let x = 0.5 * (up * up + ring - v2 - one.a * one.a) / one.a;
            let y = (up - v[2] * one.cosine) / one.sine;
            let x_off = x_off + 0.5 * v2_off / one.a.abs();
            let y_off = y_off + v_off * (one.cosine / one.sine).abs();
            let second =
                Arc::toward(x, y, hypotenuse(x_off, y_off)).minus(Arc::toward(v[0], v[1], v_off));
            out.push([self.first_arc(p, off, v, v_off, second), second, third]);
        }
        out
    }

    /// Arcs of the third turn: all places where the equation of the fourth degree is so near
    /// to zero that it may vanish for an `x` and a `y` within their bounds.
    fn third_arcs(&self, up: f64, ring: f64, x_off: f64, y_off: f64) -> Vec<Arc> {
        let form = self.third_form(up, ring);
        // As c0 + c1 cos t + s1 sin t + c2 cos 2t + s2 sin 2t.
        let c0 = form[0][0] + 0.5 * (form[1][1] + form[2][2]);
        let (c1, s1) = (form[0][1] + form[1][0], form[0][2] + form[2][0]);
        let (c2, s2) = (0.5 * (form[1][1] - form[2][2]), 0.5 * (form[1][2] + form[2][1]));
        let (single, double) = (hypotenuse(c1, s1), hypotenuse(c2, s2));
        let bend = single + 4.0 * double;
        // x^2 + y^2 is as large as the centre's distance from the second axis, squared,
        // wherever the equation holds.
        let reach = self.two.a.abs() + self.radius + (self.two.sine * self.height).abs();
        let size = c0.abs() + single + double;
        let error = 2.0 * reach * (x_off + y_off)
            + x_off * x_off
            + y_off * y_off
            + 1e-13 * (size + form.iter().flatten().map(|x| x.abs()).sum::<f64>());
        let half = PI / PIECES as f64;
        let mut open: Vec<(f64, f64)> =
            (0..PIECES).rev().map(|i| (half * (2 * i + 1) as f64 - PI, half)).collect();
        let mut out: Vec<Arc> = Vec::with_capacity(4);
        let mut looks = 0;
        while let Some((middle, half)) = open.pop() {
            looks += 1;
            let ((s, c), (ss, cc)) = (middle.sin_cos(), (2.0 * middle).sin_cos());
            let f = c0 + c1 * c + s1 * s + c2 * cc + s2 * ss;
            let slope = -c1 * s + s1 * c + 2.0 * (s2 * cc - c2 * ss);
            if f.abs() > error + slope.abs() * half + 0.5 * bend * half * half {
                continue;
            }
            if half > SHORTEST && looks < MOST_PIECES {
                // Not worth dividing where the whole piece may hold roots.
                if f.abs() + slope.abs() * half > 0.5 * error || half > 1e-3 {
                    let quarter = 0.5 * half;
                    open.extend([(middle + quarter, quarter), (middle - quarter, quarter)]);
                    continue;
                }
            }
            match out.last_mut() {
                // Pieces come in order: one that touches the last goes on.
                Some(last) if middle - half <= last.middle + last.off + 1e-9 => {
                    let (low, high) = (last.middle - last.off, middle + half);
                    *last = Arc { middle: 0.5 * (low + high), off: 0.5 * (high - low) };
                }
                _ => out.push(Arc { middle, off: half + 1e-12 }),
            }
        }
        if out.len() > MOST_ARCS || looks >= MOST_PIECES { vec![Arc::all()] } else { out }
    }
}
