//! All real roots of the resultant, each in an interval of its own: Descartes' rule of signs for
//! the coefficients in Bernstein's basis, on eight arcs of the turn.

use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

use super::resultant::{DEGREE, HARMONICS, Harmonics};
use crate::lanes::Real;

const ARCS: usize = 8;
/// Coefficients on an arc: those of degree 16 in the tangent of half the angle.
const COUNT: usize = 2 * DEGREE + 1;
/// Half an arc, rad.
const HALF: f64 = PI / ARCS as f64;
/// An interval is not parted further once it is narrower, rad (at the arc's centre).
const NARROW: f64 = 1e-3;
/// A coefficient's sign is sure above this share of the largest one, or so many times the
/// noise of the samples.
const SURE: f64 = 4e-15;
const NOISE: f64 = 20.0;
/// Most parts of one arc that wait at a time.
const DEPTH: usize = 16;

/// Where a root is, or may be.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    /// Which goal.
    pub goal: u32,
    /// Centre of the arc, rad.
    pub centre: f64,
    /// The root, rad, once it is known better than by its place.
    pub angle: f64,
    /// Tangents of half the angles from the centre on both sides.
    pub lower: f64,
    pub upper: f64,
    /// The polynomial is below zero at the lower one.
    pub rising: bool,
    /// The interval holds one root for sure; else it only is narrow.
    pub single: bool,
}

/// Bernstein coefficients of `(1 + x^2)^8 cos(k phi)` and `(1 + x^2)^8 sin(k phi)` with
/// `x = tan(phi / 2)` over an arc about 0.
static BASIS: LazyLock<[[f64; COUNT]; HARMONICS]> = LazyLock::new(|| {
    let choose = |n: usize, k: usize| -> f64 {
        (0..k).fold(1.0, |product, i| product * (n - i) as f64 / (i + 1) as f64)
    };
    let mut out = [[0.0; COUNT]; HARMONICS];
    for k in 0..=DEGREE {
        // (1 + i x)^(8 + k) (1 - i x)^(8 - k): its polar form at j times the arc's end and
        // 16 - j times its begin, a mean of unit numbers.
        let (plus, minus) = (DEGREE + k, DEGREE - k);
        for j in 0..COUNT {
            let (mut re, mut im) = (0.0, 0.0);
            for i in j.saturating_sub(minus)..=j.min(plus) {
                let share = choose(plus, i) * choose(minus, j - i) / choose(2 * DEGREE, j);
                let turns = 2.0 * i as f64 - j as f64 - k as f64;
                let (s, c) = (turns * HALF).sin_cos();
                (re, im) = (re + share * c, im + share * s);
            }
            if k == 0 {
                out[0][j] = re;
            } else {
                (out[2 * k - 1][j], out[2 * k][j]) = (re, im);
            }
        }
    }
    out
});

/// Cosine and sine of multiples of the centres of the arcs.
static CENTRES: LazyLock<[(f64, f64); ARCS]> = LazyLock::new(|| {
    std::array::from_fn(|k| {
        let (s, c) = (k as f64 * (TAU / ARCS as f64)).sin_cos();
        (c, s)
    })
});

/// Coefficients on all arcs.
pub type Arcs<R> = [[R; COUNT]; ARCS];

/// The coefficients of a polynomial on all arcs.
#[inline(always)]
pub fn arcs<R: Real>(h: &Harmonics<R>) -> Arcs<R> {
    let (basis, centres) = (&*BASIS, &*CENTRES);
    let mut out = [[R::zero(); COUNT]; ARCS];
    for (arc, coefficients) in out.iter_mut().enumerate() {
        let mut turned = *h;
        for k in 1..=DEGREE {
            let (c, s) = centres[k * arc % ARCS];
            let (c, s) = (R::splat(c), R::splat(s));
            let (a, b) = (h[2 * k - 1], h[2 * k]);
            turned[2 * k - 1] = a.mul_add(c, b * s);
            turned[2 * k] = b.mul_add(c, -(a * s));
        }
        // Cosines are the same on both sides of the centre, sines the opposite.
        for j in 0..=DEGREE {
            let mut even = turned[0] * R::splat(basis[0][j]);
            let mut odd = R::zero();
            for k in 1..=DEGREE {
                even = turned[2 * k - 1].mul_add(R::splat(basis[2 * k - 1][j]), even);
                odd = turned[2 * k].mul_add(R::splat(basis[2 * k][j]), odd);
            }
            coefficients[j] = even + odd;
            coefficients[COUNT - 1 - j] = even - odd;
        }
    }
    out
}

/// The places of all real roots of one goal's polynomial; `noise` as its samples have it.
#[inline(always)]
pub fn places(goal: u32, arcs: &Arcs<f64>, noise: f64, out: &mut Vec<Place>) {
    let mut largest = 0.0_f64;
    for x in arcs.iter().flatten() {
        largest = largest.max(x.abs());
    }
    if !(largest > 0.0 && largest.is_finite()) {
        return;
    }
    let least = largest * (NOISE * noise).max(SURE);
    let half = (0.5 * HALF).tan();
    let mut waiting = [([0.0; COUNT], 0.0, 0.0); DEPTH];
    for (arc, coefficients) in arcs.iter().enumerate() {
        waiting[0] = (*coefficients, 0.0, 1.0);
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let (b, begin, size) = &waiting[count];
            let (begin, size) = (*begin, *size);
            let seen = signs(b, least);
            if seen.changes == 0 && !seen.unsure {
                continue;
            }
            let place = |lower: f64, upper: f64, single: bool| Place {
                goal,
                centre: arc as f64 * (TAU / ARCS as f64),
                angle: f64::NAN,
                lower: half * (2.0 * lower - 1.0),
                upper: half * (2.0 * upper - 1.0),
                rising: b[0] < 0.0,
                single,
            };
            let at = |part: f64| place(begin + part * size, begin + part * size, false);
            if seen.changes == 1 && !seen.unsure {
                out.push(place(begin, begin + size, true));
            } else if seen.all_unsure || size < NARROW / (4.0 * half) || count + 2 > DEPTH {
                if seen.all_unsure || seen.changes < 2 {
                    out.push(at(0.5));
                } else {
                    out.extend([at(0.25), at(0.75)]);
                }
            } else {
                let (left, right) = halves(b);
                let size = 0.5 * size;
                waiting[count] = (right, begin + size, size);
                waiting[count + 1] = (left, begin, size);
                count += 2;
            }
        }
    }
}

struct Signs {
    changes: u32,
    unsure: bool,
    all_unsure: bool,
}

#[inline(always)]
fn signs(b: &[f64; COUNT], least: f64) -> Signs {
    let (mut sure, mut below) = (0_u32, 0_u32);
    for (i, x) in b.iter().enumerate() {
        sure |= u32::from(x.abs() > least) << i;
        below |= u32::from(*x < 0.0) << i;
    }
    const ALL: u32 = (1 << COUNT) - 1;
    let changes = if sure == ALL {
        ((below ^ (below >> 1)) & (ALL >> 1)).count_ones()
    } else {
        let (mut changes, mut last) = (0, None);
        for i in (0..COUNT).filter(|i| sure >> i & 1 != 0) {
            let sign = below >> i & 1;
            changes += u32::from(last.is_some_and(|last| last != sign));
            last = Some(sign);
        }
        changes
    };
    Signs { changes, unsure: sure != ALL, all_unsure: sure == 0 }
}

/// De Casteljau's halves.
#[inline(always)]
fn halves(b: &[f64; COUNT]) -> ([f64; COUNT], [f64; COUNT]) {
    let (mut left, mut right) = ([0.0; COUNT], *b);
    left[0] = b[0];
    for level in 1..COUNT {
        for i in 0..COUNT - level {
            right[i] = 0.5 * (right[i] + right[i + 1]);
        }
        left[level] = right[0];
    }
    (left, right)
}
