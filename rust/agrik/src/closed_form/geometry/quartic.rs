//! Roots of a quadratic form in `(1, cos t, sin t)`: the fourth-degree equation of
//! Pieper's general case, with its angle kept an angle so that none is at infinity.

use std::f64::consts::TAU;

use nalgebra::{Complex, Matrix4, Schur};

use crate::lanes::hypotenuse;

/// A real root, or a slot without one.
#[derive(Debug, Clone, Copy)]
pub struct Root {
    /// Sine and cosine of the angle.
    pub turn: (f64, f64),
    /// No root, or one that an earlier slot holds.
    pub merged: bool,
    /// Two roots are about to meet here.
    pub singular: bool,
}

/// Roots within this of the unit circle, or of one another, may be two real ones that
/// rounding has moved.
const NEAR: f64 = 1e-2;
/// Most of Newton's steps: three do, unless three roots are about to meet.
const STEPS: usize = 30;
/// Most iterations of the eigenvalues: some ten are usual.
const ITERATIONS: usize = 200;
/// Newton's steps start from so many places all round where there are no eigenvalues.
const SPREAD: usize = 48;
/// Angles this near to one another are one root.
const SAME: f64 = 1e-9;
/// Slope, as a share of the equation's size, below which a root is singular.
const FLAT: f64 = 1e-6;

/// All angles with `sum form[i][j] b[i] b[j] = 0`, `b = (1, cos t, sin t)`.
pub fn roots(form: &[[f64; 3]; 3]) -> [Root; 4] {
    // As c0 + c1 cos t + s1 sin t + c2 cos 2t + s2 sin 2t.
    let c0 = form[0][0] + 0.5 * (form[1][1] + form[2][2]);
    let (c1, s1) = (form[0][1] + form[1][0], form[0][2] + form[2][0]);
    let c2 = 0.5 * (form[1][1] - form[2][2]);
    let s2 = 0.5 * (form[1][2] + form[2][1]);
    let size = c0.abs() + c1.abs() + s1.abs() + c2.abs() + s2.abs();
    let mut out = [Root { turn: (0.0, 1.0), merged: true, singular: false }; 4];
    if size == 0.0 || !size.is_finite() {
        return out;
    }
    let value = |t: f64| {
        let ((s, c), (ss, cc)) = (t.sin_cos(), (2.0 * t).sin_cos());
        let f = c0 + c1 * c + s1 * s + c2 * cc + s2 * ss;
        let slope = -c1 * s + s1 * c + 2.0 * (s2 * cc - c2 * ss);
        let bend = -c1 * c - s1 * s - 4.0 * (c2 * cc + s2 * ss);
        (f, slope, bend)
    };
    let mut found = 0;
    for z in polynomial_roots(c0, c1, s1, c2, s2) {
        if (z.norm() - 1.0).abs() > NEAR {
            continue;
        }
        let mut t = z.im.atan2(z.re);
        let (f, slope, bend) = value(t);
        // Where two roots meet Newton's steps are slow; their common place is where the
        // slope vanishes.
        let touches =
            slope.abs() < 1e-3 * size && f.abs() < 1e-6 * size && bend.abs() > 1e-3 * size;
        if touches {
            let mut turn = t;
            for _ in 0..4 {
                let (_, slope, bend) = value(turn);
                turn -= slope / bend;
            }
            let (top, _, bend) = value(turn);
            // Up to second order the roots stand at +-sqrt(-2 f / f'') from there.
            let square = -2.0 * top / bend;
            let half = square.max(0.0).sqrt();
            // As far as the third order does not count: else a third root is near.
            let room = 0.1 * bend.abs() / size;
            if half < room && (t - turn).abs() < room {
                if square < -1e-12 {
                    continue;
                }
                t = if t < turn { turn - half } else { turn + half };
            }
        }
        for _ in 0..STEPS {
            let (f, slope, _) = value(t);
            let step = if slope.abs() > 1e-9 * size { f / slope } else { 0.0 };
            t -= step.clamp(-0.1, 0.1);
            if step.abs() < 1e-15 {
                break;
            }
        }
        let (f, slope, _) = value(t);
        if f.abs() > 1e-10 * size {
            continue;
        }
        let turn = t.sin_cos();
        let seen = out[..found].iter().any(|other| {
            let (dy, dx) = (other.turn.0 - turn.0, other.turn.1 - turn.1);
            hypotenuse(dy, dx) < SAME
        });
        if !seen && found < out.len() {
            out[found] = Root { turn, merged: false, singular: slope.abs() < FLAT * size };
            found += 1;
        }
    }
    out
}

/// Roots of the polynomial in `z = exp(i t)`: eigenvalues of a matrix of its coefficients.
fn polynomial_roots(c0: f64, c1: f64, s1: f64, c2: f64, s2: f64) -> Vec<Complex<f64>> {
    // z^2 times the equation: (c2 - i s2)/2 z^4 + (c1 - i s1)/2 z^3 + c0 z^2 + ... With the
    // substitution z = (1 + i u) / (1 - i u) it has real coefficients in u = tan(t / 2).
    // A shift of t by a fixed angle keeps roots away from u = infinity; try a few.
    let mut best: Option<(f64, [f64; 5], f64)> = None;
    for shift in [0.0_f64, 0.7, 1.4, 2.1, 2.8, 3.5, 4.2, 4.9, 5.6] {
        let ((s, c), (ss, cc)) = (shift.sin_cos(), (2.0 * shift).sin_cos());
        let (k1, r1) = (c1 * c + s1 * s, s1 * c - c1 * s);
        let (k2, r2) = (c2 * cc + s2 * ss, s2 * cc - c2 * ss);
        // cos = (1 - u^2)/(1 + u^2), sin = 2 u/(1 + u^2), times (1 + u^2)^2.
        let coefficients = [
            c0 + k1 + k2,
            2.0 * r1 + 4.0 * r2,
            2.0 * c0 - 6.0 * k2,
            2.0 * r1 - 4.0 * r2,
            c0 - k1 + k2,
        ];
        let lead = coefficients[4].abs();
        if best.as_ref().is_none_or(|(known, ..)| lead > *known) {
            best = Some((lead, coefficients, shift));
        }
    }
    let Some((_, k, shift)) = best.filter(|(lead, ..)| *lead > 0.0) else {
        return Vec::new();
    };
    let [a, b, c, d] = [k[0], k[1], k[2], k[3]].map(|x| -x / k[4]);
    #[rustfmt::skip]
    let companion = Matrix4::new(
        0.0, 0.0, 0.0, a,
        1.0, 0.0, 0.0, b,
        0.0, 1.0, 0.0, c,
        0.0, 0.0, 1.0, d,
    );
    let i = Complex::new(0.0, 1.0);
    let turn = Complex::new(shift.cos(), shift.sin());
    // Where several roots are about to meet, the iteration may never come to rest at the finest
    // tolerance; what it loses at a coarser one, Newton's steps bring back.
    let Some(schur) = [f64::EPSILON, 1e-13, 1e-11, 1e-9]
        .into_iter()
        .find_map(|tolerance| Schur::try_new(companion, tolerance, ITERATIONS))
    else {
        let spread = (0..SPREAD).map(|k| k as f64 * (TAU / SPREAD as f64));
        return spread.map(|t| Complex::new(t.cos(), t.sin())).collect();
    };
    schur
        .complex_eigenvalues()
        .iter()
        .map(|u| (Complex::new(1.0, 0.0) + i * u) / (Complex::new(1.0, 0.0) - i * u) * turn)
        .collect()
}
