//! The resultant of the six equations as a trigonometric polynomial of degree 8 in the hidden
//! angle, from samples of it.
//!
//! Of degree 24 in the tangent of half the angle, it has the factor `(1 + t^2)^4`: sixteen
//! roots are left. As samples all round it has no leading coefficient and no root at infinity;
//! harmonics above the eighth vanish, and what is there in their place is rounding.

use std::sync::LazyLock;

use super::cut::{Equations, ROWS};
use crate::closed_form::geometry::mirrors::{mirror, reflect, unrolled};
use crate::lanes::Real;

/// Degree.
pub const DEGREE: usize = 8;
/// Samples: those of degree 10, to see the rounding.
pub const SAMPLES: usize = 20;
/// Numbers of a polynomial: constant, then cosine and sine part of each harmonic.
pub const HARMONICS: usize = 1 + 2 * DEGREE;

/// A trigonometric polynomial.
pub type Harmonics<R> = [R; HARMONICS];

/// Cosine and sine of the angles at which samples are taken.
pub static ANGLES: LazyLock<[(f64, f64); SAMPLES]> = LazyLock::new(|| {
    std::array::from_fn(|k| {
        let (s, c) = (k as f64 * (std::f64::consts::TAU / SAMPLES as f64)).sin_cos();
        (c, s)
    })
});

/// The columns of the equations at a value of the hidden angle, `[powers of x and y][equation]`.
pub type Columns<R> = [[R; ROWS]; 9];

#[inline(always)]
fn columns<R: Real>(equations: &Equations<R>, (c, s): (R, R)) -> Columns<R> {
    let mut out = [[R::zero(); ROWS]; 9];
    let [constant, cosine, sine] = equations;
    for (j, column) in out.iter_mut().enumerate() {
        for i in 0..ROWS {
            column[i] = sine[j][i].mul_add(s, cosine[j][i].mul_add(c, constant[j][i]));
        }
    }
    out
}

/// Mirrors the first three columns into a triangle; their diagonal's product.
#[inline(always)]
fn reduce<R: Real>(columns: &mut Columns<R>) -> R {
    let mut product = R::splat(1.0);
    unrolled!(K in [0 1 2] {
        let v = mirror::<R, ROWS, K>(&mut columns[K]);
        product *= columns[K][K];
        for j in K + 1..9 {
            reflect::<R, ROWS, K>(&v, &mut columns[j]);
        }
    });
    product
}

/// The resultant at a value of the hidden angle.
///
/// The determinant of `[A0 A1 A2 0; 0 A0 A1 A2]` with six rows of three columns in each block.
/// A triangle out of `A0` above and one out of `A2` below leave six rows of six columns.
#[inline(always)]
pub fn sample<R: Real>(equations: &Equations<R>, at: (R, R)) -> R {
    let mut above = columns(equations, at);
    let mut below =
        [above[6], above[7], above[8], above[0], above[1], above[2], above[3], above[4], above[5]];
    let mut product = reduce(&mut above) * reduce(&mut below);
    let mut left = [[R::zero(); ROWS]; ROWS];
    for (j, column) in left.iter_mut().enumerate() {
        column[..3].copy_from_slice(&above[3 + j][3..]);
        column[3..].copy_from_slice(&below[3 + j][3..]);
    }
    unrolled!(K in [0 1 2 3 4] {
        let v = mirror::<R, ROWS, K>(&mut left[K]);
        product *= left[K][K];
        for j in K + 1..ROWS {
            reflect::<R, ROWS, K>(&v, &mut left[j]);
        }
    });
    product * left[ROWS - 1][ROWS - 1]
}

const HALF: usize = SAMPLES / 2;

/// Cosine and sine part of a harmonic.
#[inline(always)]
fn harmonic<R: Real>(from: &[R; HALF], h: usize) -> (R, R) {
    let angles = &*ANGLES;
    let (mut c, mut s) = (R::zero(), R::zero());
    for (k, x) in from.iter().enumerate() {
        let (cosine, sine) = angles[h * k % SAMPLES];
        c = x.mul_add(R::splat(cosine), c);
        s = x.mul_add(R::splat(sine), s);
    }
    (c * R::splat(2.0 / SAMPLES as f64), s * R::splat(2.0 / SAMPLES as f64))
}

/// The polynomial through samples all round, and what its vanishing harmonics hold as a share
/// of the largest.
#[inline(always)]
pub fn harmonics<R: Real>(samples: &[R; SAMPLES]) -> (Harmonics<R>, R) {
    // Samples half a turn apart: their sum has the even harmonics, their difference the odd.
    let (mut even, mut odd) = ([R::zero(); HALF], [R::zero(); HALF]);
    for k in 0..HALF {
        even[k] = samples[k] + samples[k + HALF];
        odd[k] = samples[k] - samples[k + HALF];
    }
    let mut out = [R::zero(); HARMONICS];
    out[0] = harmonic(&even, 0).0 * R::splat(0.5);
    let mut largest = out[0].abs();
    for h in 1..=DEGREE {
        let (c, s) = harmonic(if h.is_multiple_of(2) { &even } else { &odd }, h);
        largest = largest.max(c.abs()).max(s.abs());
        (out[2 * h - 1], out[2 * h]) = (c, s);
    }
    let (nine, ten) = (harmonic(&odd, 9), harmonic(&even, 10));
    let rest = nine.0.abs().max(nine.1.abs()).max(ten.0.abs());
    (out, rest / largest.max(R::splat(f64::MIN_POSITIVE)))
}

/// Value and slope of a polynomial at an angle given as `(sine, cosine)`.
#[inline(always)]
pub fn value<R: Real>(h: &Harmonics<R>, (s, c): (R, R)) -> (R, R) {
    let (mut sk, mut ck) = (s, c);
    let (mut value, mut slope) = (h[0], R::zero());
    for k in 1..=DEGREE {
        let (a, b) = (h[2 * k - 1], h[2 * k]);
        value = a.mul_add(ck, b.mul_add(sk, value));
        slope = R::splat(k as f64).mul_add(b * ck - a * sk, slope);
        (sk, ck) = (sk.mul_add(c, ck * s), ck.mul_add(c, -(sk * s)));
    }
    (value, slope)
}
