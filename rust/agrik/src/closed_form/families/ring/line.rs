//! A line with a marked point as fourteen numbers that a turn about any axis changes by first
//! degree in its sine and cosine: `(l, p, p.p, p.l, p x l, (p.p) l - 2 (p.l) p)`.
//!
//! Source: the fourteen equations of M. Raghavan and B. Roth, "Kinematic analysis of the 6R
//! manipulator of general geometry", 1990.

use crate::closed_form::geometry::rigid::Rigid;
use crate::lanes::{Real, V3, axpy, cross, dot, scale};

/// How many numbers.
pub const SIZE: usize = 14;
/// Those that a turn about z leaves alone.
pub const STILL: [usize; 6] = [2, 5, 6, 7, 10, 13];
/// Those that it turns, as x and y.
pub const TURNED: [(usize, usize); 4] = [(0, 1), (3, 4), (8, 9), (11, 12)];

/// The numbers of a line.
pub type Line<R> = [R; SIZE];

/// The numbers of the line along `l` with the point `p`.
#[inline(always)]
pub fn line<R: Real>(l: V3<R>, p: V3<R>) -> Line<R> {
    let (pp, pl, m) = (dot(p, p), dot(p, l), cross(p, l));
    let q = axpy(p, -(pl + pl), scale(l, pp));
    [l[0], l[1], l[2], p[0], p[1], p[2], pp, pl, m[0], m[1], m[2], q[0], q[1], q[2]]
}

/// The numbers after a motion; of a difference of lines with `constant` 0, of a line with 1.
#[inline(always)]
pub fn moved<R: Real>(by: &Rigid<R>, e: &Line<R>, constant: f64) -> Line<R> {
    let one = R::splat(constant);
    let two = R::splat(2.0);
    let t = by.shift;
    let l = by.turn([e[0], e[1], e[2]]);
    let p = by.turn([e[3], e[4], e[5]]);
    let m = by.turn([e[8], e[9], e[10]]);
    let q = by.turn([e[11], e[12], e[13]]);
    let (pp, pl) = (e[6], e[7]);
    let (tt, tl) = (dot(t, t), dot(t, l));
    let square = pp + two * dot(t, p) + tt * one;
    let along = pl + tl;
    let moment = cross(t, l);
    let bent = cross(t, m);
    let back = -(two * (pl + tl));
    let mut out = [R::zero(); SIZE];
    for k in 0..3 {
        out[k] = l[k];
        out[3 + k] = t[k].mul_add(one, p[k]);
        out[8 + k] = m[k] + moment[k];
        out[11 + k] = (-two).mul_add(bent[k], q[k]) + tt.mul_add(l[k], back * t[k]);
    }
    (out[6], out[7]) = (square, along);
    out
}

/// The parts (constant, cosine, sine) of a quantity of first degree in an angle, from its
/// values at 0 and a third of a turn to either side.
pub fn parts(at: [f64; 3]) -> [f64; 3] {
    let [zero, plus, minus] = at;
    let third = 3.0_f64.sqrt();
    [(zero + plus + minus) / 3.0, (2.0 * zero - plus - minus) / 3.0, (plus - minus) / third]
}

/// The angles that [`parts`] wants values at, rad.
pub const THIRDS: [f64; 3] = [0.0, std::f64::consts::TAU / 3.0, -std::f64::consts::TAU / 3.0];
