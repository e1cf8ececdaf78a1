//! EXACT: the joint values of least energy, with a proof that no others need less.
//!
//! # Claim
//!
//! Among all joint values within the limits that reach a target, the answer has the least
//! energy index; and where there is no answer, no joint values reach the target.
//!
//! # Proof
//!
//! Write `r = l2 + l3 cos(beta)`, `u = r sin(theta)`, `w = r cos(theta)`. For a target the
//! slides' limits are `u0 <= u <= u1`, `w0 <= w <= w1` and an interval of beta, and the
//! index is a constant plus
//!
//! ```text
//! f = -A l3 sin(beta) + P sin(theta) - Q cos(theta),   P = A r,  Q = k0 + k1 r
//!   = -A l3 sin(beta) + A u - (k0 / r + k1) w,         k0 = -(m2 + m3) g l2 / 2 <= 0
//! ```
//!
//! The feasible set in the plane of (beta, theta) is compact and f is smooth, so f takes
//! its minimum there: at a stationary point inside, or on one of the curves where a
//! constraint is active. Both kinds are listed completely.
//!
//! **Inside.** `f_theta = 0` gives `theta = -atan2(P, Q)` (the other root is a maximum and
//! out of limits), value `F = -A l3 sin(beta) - N`, `N^2 = P^2 + Q^2`. For beta > 0, as a
//! function of `c = cos(beta)`, `F'' = A l3 (1 - c^2)^(-3/2) - D^2 / N^3` with
//! `D = p0 q1 - p1 q0`, which is positive under condition 1: F is convex, so there is one
//! stationary point, and it is the minimum over all theta and beta >= 0. For beta < 0, F is
//! larger than at -beta, and has no stationary point since N grows with c. The point does
//! not depend on the target: it is found once ([`FreePose`]), and where its slides are
//! within their limits it is the answer, the *free branch*.
//!
//! **On a curve** all other constraints together are an interval of one variable, and f is
//! known well enough along it that its least value needs no search but a bracketed root:
//! * beta fixed: f is one sinusoid in theta; an interval's minimum is at the sinusoid's
//!   minimum or the end nearest to it.
//! * theta fixed: one sinusoid in beta, likewise (both ends are looked at as well).
//! * `u` fixed, in r: for beta >= 0, `-A l3 sin(beta) = -A sqrt(l3^2 - (r - l2)^2)` is convex,
//!   and `-(k0 / r + k1) sqrt(r^2 - u^2)` has second derivative
//!   `u^2 (r^2 - u^2)^(-3/2) (k1 + k0 (3 r^2 - 2 u^2) / r^3)`, not negative under condition
//!   2. So f is convex: its derivative changes sign at most once, and a bracketed root
//!   finder ends at the minimum. For beta < 0 the derivative is negative, so the
//!   minimum is at an end.
//! * `w` fixed, theta <= 0: `A u = -A sqrt(r^2 - w^2)` is convex and so is `-k0 w / r`:
//!   for beta >= 0 as before, for beta < 0 the derivative is negative. Theta >= 0: for
//!   beta >= 0 the derivative is at least `A + k0 / r`, positive under condition 3; for
//!   beta < 0, f is concave under condition 4. Both have their minimum at an end.
//!
//! The ends of these intervals are the points where two constraints meet. A non-empty
//! feasible set without an admissible stationary point therefore shows up as a
//! non-empty interval on one of the curves; if all are empty, so is the set.
//!
//! The conditions, with `r_min` the shortest reach and `N_min` the least of N:
//! 1. `A l3 > D^2 / N_min^3`, and N grows with c
//! 2. `k1 + 3 k0 / r_min >= 0`
//! 3. `A + k0 / r_min >= 0`
//! 4. `A / l3 + 2 k0 / r_min^2 >= 0`
//!
//! Rounding: slides are held to 1e-14 m. At a target that leaves a single beta near 0 (all
//! slides and theta at their limits) beta follows the square root of such a length, so
//! that the energy there is certain to 5e-7 J instead of 1e-14 J.
//!
//! They hold for the paper's arm, also with the hardware's beta limit of -85 degrees, and
//! are checked for any other: EXACT refuses constants for which they fail.

use super::sets::Window;
use super::{Angle, Arm, Gap, Interval, Pose, SLIDE_TOLERANCE};
use crate::error::{Error, Result};
use crate::lanes::hypotenuse;

/// Theta and beta of least energy where no slide limits them, and the slides' offsets.
#[derive(Debug, Clone, Copy)]
pub struct FreePose {
    /// Pitch, rad.
    pub theta: f64,
    /// Roll, rad.
    pub beta: f64,
    /// The pose for a target at the origin.
    at_origin: Pose,
}

impl PartialEq for FreePose {
    fn eq(&self, other: &Self) -> bool {
        (self.theta, self.beta) == (other.theta, other.beta)
    }
}

/// The best point so far.
struct Best {
    value: f64,
    theta: f64,
    beta: f64,
}

impl Arm {
    /// Refuses constants for which the proof of this module does not hold.
    pub(super) fn check_certificate(&self) -> Result<()> {
        let (p, e) = (&self.parameters, &self.energy);
        let shortest = self.reach(p.lower[4]).min(self.reach(p.upper[4]));
        let d = e.p[0] * e.q[1] - e.p[1] * e.q[0];
        let grows = e.p[0] * e.p[1] + e.q[0] * e.q[1] >= 0.0 && e.q[0] > 0.0 && e.q[1] >= 0.0;
        let least = hypotenuse(e.p[0], e.q[0]);
        let conditions = [
            grows && e.p[1] > d * d / least.powi(3),
            e.k[1] + 3.0 * e.k[0] / shortest >= 0.0,
            e.a + e.k[0] / shortest >= 0.0,
            e.a / p.l3 + 2.0 * e.k[0] / (shortest * shortest) >= 0.0,
        ];
        match conditions.iter().position(|holds| !holds) {
            None => Ok(()),
            Some(i) => Err(Error::argument(
                "friction",
                "energy constants for which the least energy can be proven (more friction)",
                format!("{} N, which fails condition {}", p.friction, i + 1),
            )),
        }
    }

    /// The stationary point: theta and beta in turn, each the best for the other.
    pub(super) fn free_pose(&self) -> Option<FreePose> {
        let (p, e) = (&self.parameters, &self.energy);
        let (mut theta, mut beta) = (0.0f64, 0.0f64);
        for _ in 0..200 {
            let before = (theta, beta);
            theta = self.best_theta(beta.cos());
            let (sin_t, cos_t) = theta.sin_cos();
            beta = e.p[1].atan2(e.q[1] * cos_t - e.p[1] * sin_t);
            if before == (theta, beta) {
                break;
            }
        }
        let inside = Interval::new(p.lower[3], p.upper[3]).holds(theta)
            && Interval::new(p.lower[4], p.upper[4]).holds(beta);
        let at_origin = self.pose([0.0; 3], Angle::new(theta), Angle::new(beta));
        inside.then_some(FreePose { theta, beta, at_origin })
    }

    /// Theta of least energy at a beta, rad.
    #[inline]
    fn best_theta(&self, cos_b: f64) -> f64 {
        let e = &self.energy;
        -(e.p[0] + e.p[1] * cos_b).atan2(e.q[0] + e.q[1] * cos_b)
    }

    #[inline]
    pub(super) fn exact(&self, target: [f64; 3]) -> std::result::Result<Pose, Gap> {
        if let Some(free) = &self.free {
            let p = &self.parameters;
            let mut pose = free.at_origin;
            pose.q[0] += target[1];
            pose.q[1] += target[0];
            pose.q[2] -= target[2];
            let inside = |i: usize| (p.lower[i] <= pose.q[i]) & (pose.q[i] <= p.upper[i]);
            if inside(0) & inside(1) & inside(2) {
                return Ok(pose);
            }
        }
        self.constrained(target)
    }

    /// The least of all curves, or the proof that there is none.
    #[inline(never)]
    fn constrained(&self, target: [f64; 3]) -> std::result::Result<Pose, Gap> {
        let set = self.s10_set(target)?;
        let window = self.window(target);
        let at = |s10: f64| self.beta_at(target, s10).rad;
        let betas = Interval::new(at(set.high), at(set.low));
        let mut best = Best { value: f64::INFINITY, theta: 0.0, beta: 0.0 };
        self.along_beta(&window, betas, &mut best);
        self.along_theta(&window, betas, &mut best);
        self.along_s21(&window, betas, &mut best);
        self.along_s32(&window, betas, &mut best);
        let found = best.value.is_finite();
        let pose = self.pose(target, Angle::new(best.theta), Angle::new(best.beta));
        found.then_some(pose).and_then(|pose| self.held(pose)).ok_or_else(|| {
            let near = 0.0f64.clamp(betas.low, betas.high);
            let short = self.reach(betas.low).min(self.reach(betas.high));
            let reaches = Interval::new(short, self.reach(near));
            self.theta_gap(&window, reaches)
        })
    }

    #[inline]
    fn consider(&self, best: &mut Best, theta: f64, beta: f64) {
        let value = self.choice(Angle::new(theta).turn, Angle::new(beta).turn);
        if value < best.value {
            *best = Best { value, theta, beta };
        }
    }

    /// Beta at either end of its interval.
    fn along_beta(&self, window: &Window, betas: Interval, best: &mut Best) {
        for beta in [betas.low, betas.high] {
            let cos_b = beta.cos();
            let wanted = self.best_theta(cos_b);
            let r = self.reach(beta);
            for set in self.theta_sets_of(window, r).all.iter().flatten() {
                self.consider(best, set.nearest(wanted), beta);
            }
        }
    }

    /// Theta at either limit.
    fn along_theta(&self, window: &Window, betas: Interval, best: &mut Best) {
        let (p, e) = (&self.parameters, &self.energy);
        for theta in [p.lower[3], p.upper[3]] {
            let (sin, cos) = theta.sin_cos();
            let Some(reaches) = ratio(window.w, cos)
                .zip(ratio(window.u, sin))
                .and_then(|(a, b)| a.common(b, SLIDE_TOLERANCE))
            else {
                continue;
            };
            let wanted = e.p[1].atan2(e.q[1] * cos - e.p[1] * sin);
            for part in self.beta_parts(betas, reaches).iter().flatten() {
                for beta in [part.nearest(wanted), part.low, part.high] {
                    self.consider(best, theta, beta);
                }
            }
        }
    }

    /// Slide s21 at either limit.
    fn along_s21(&self, window: &Window, betas: Interval, best: &mut Best) {
        let (p, e) = (&self.parameters, &self.energy);
        let sines = Interval::new(p.lower[3].sin(), p.upper[3].sin());
        for u in [window.u.low, window.u.high] {
            let u2 = u * u;
            // u / r within the sines of the joint's limits, and w within its own.
            let Some(reaches) = inverse_ratio(u, sines).and_then(|a| {
                let w = square(window.w)?;
                let b = Interval::new((u2 + w.low).sqrt(), (u2 + w.high).sqrt());
                a.common(b, SLIDE_TOLERANCE)
            }) else {
                continue;
            };
            let theta_at = |beta: f64| {
                let r = self.reach(beta);
                u.atan2((r * r - u2).max(0.0).sqrt())
            };
            let [below, above] = self.beta_parts(betas, reaches);
            if let Some(part) = above {
                let beta = falling_root(part, |beta| {
                    let (sin, cos) = beta.sin_cos();
                    let r = p.l2 + p.l3 * cos;
                    let slope = (e.k[1] + e.k[0] * u2 / (r * r * r)) * r;
                    e.a * cos * (r * r - u2).max(0.0).sqrt() - sin * slope
                });
                self.consider(best, theta_at(beta), beta);
            }
            if let Some(part) = below {
                self.consider(best, theta_at(part.low), part.low);
                self.consider(best, theta_at(part.high), part.high);
            }
        }
    }

    /// Slide s32 at either limit.
    fn along_s32(&self, window: &Window, betas: Interval, best: &mut Best) {
        let (p, e) = (&self.parameters, &self.energy);
        for w in [window.w.low, window.w.high] {
            if w <= 0.0 {
                continue;
            }
            let w2 = w * w;
            for sign in [-1.0, 1.0] {
                // Magnitudes of theta and u on this side of zero.
                let (angles, across) = if sign < 0.0 {
                    (
                        Interval::new(-p.upper[3], -p.lower[3]),
                        Interval::new(-window.u.high, -window.u.low),
                    )
                } else {
                    (Interval::new(p.lower[3], p.upper[3]), window.u)
                };
                if angles.high < 0.0 {
                    continue;
                }
                let Some(u) = square(across) else { continue };
                let by_angle = Interval::new(w / angles.low.max(0.0).cos(), w / angles.high.cos());
                let by_slide = Interval::new((w2 + u.low).sqrt(), (w2 + u.high).sqrt());
                let Some(reaches) = by_angle.common(by_slide, SLIDE_TOLERANCE) else { continue };
                let theta_at = |beta: f64| {
                    let r = self.reach(beta);
                    sign * (r * r - w2).max(0.0).sqrt().atan2(w)
                };
                let [below, above] = self.beta_parts(betas, reaches);
                if let (Some(part), true) = (above, sign < 0.0) {
                    let beta = falling_root(part, |beta| {
                        let (sin, cos) = beta.sin_cos();
                        let r = p.l2 + p.l3 * cos;
                        let root = (r * r - w2).max(0.0).sqrt();
                        e.a * cos * root - sin * (e.a * r - e.k[0] * w * root / (r * r))
                    });
                    self.consider(best, theta_at(beta), beta);
                } else if let Some(part) = above {
                    self.consider(best, theta_at(part.low), part.low);
                    self.consider(best, theta_at(part.high), part.high);
                }
                if let Some(part) = below {
                    self.consider(best, theta_at(part.low), part.low);
                    self.consider(best, theta_at(part.high), part.high);
                }
            }
        }
    }

    /// The betas of an interval, below and above 0, whose reach is in another.
    fn beta_parts(&self, betas: Interval, reaches: Interval) -> [Option<Interval>; 2] {
        let p = &self.parameters;
        let of_magnitude = |low: f64, high: f64| {
            let span = Interval::new(self.reach(high), self.reach(low));
            let r = span.common(reaches, SLIDE_TOLERANCE)?;
            // An end that the reach does not cut is kept as it is: the arc cosine would
            // lose half its digits near 0.
            let angle = |r: f64, whole: f64, at: f64| {
                if r == whole { at } else { ((r - p.l2) / p.l3).clamp(-1.0, 1.0).acos() }
            };
            let (a, b) = (angle(r.high, span.high, low), angle(r.low, span.low, high));
            Some(Interval::new(a.max(low).min(high), b.max(low).min(high)))
        };
        let above = (betas.high >= 0.0).then(|| of_magnitude(betas.low.max(0.0), betas.high));
        let below = (betas.low < 0.0).then(|| {
            let part = of_magnitude((-betas.high).max(0.0), -betas.low)?;
            Some(Interval::new(-part.high, -part.low))
        });
        [below.flatten(), above.flatten()]
    }
}

/// The positive r with `r factor` in an interval.
fn ratio(of: Interval, factor: f64) -> Option<Interval> {
    if factor == 0.0 {
        let free = Interval::new(0.0, f64::INFINITY);
        return (of.low <= SLIDE_TOLERANCE && of.high >= -SLIDE_TOLERANCE).then_some(free);
    }
    let (a, b) = (of.low / factor, of.high / factor);
    let r = Interval::new(a.min(b).max(0.0), a.max(b));
    (r.high > 0.0).then_some(r)
}

/// The positive r with `value / r` in an interval.
fn inverse_ratio(value: f64, of: Interval) -> Option<Interval> {
    if value < 0.0 {
        return inverse_ratio(-value, Interval::new(-of.high, -of.low));
    }
    if value == 0.0 {
        return of.holds(0.0).then_some(Interval::new(0.0, f64::INFINITY));
    }
    let longest = if of.low > 0.0 { value / of.low } else { f64::INFINITY };
    (of.high > 0.0).then(|| Interval::new(value / of.high, longest))
}

/// The squares of the numbers of an interval that are not negative.
fn square(of: Interval) -> Option<Interval> {
    let low = of.low.max(0.0);
    (of.high >= 0.0).then(|| Interval::new(low * low, of.high * of.high))
}

/// Where a function that changes sign at most once, from positive to negative, does so;
/// the end where it would if it does not. Regula falsi with the Illinois rule, and a
/// halving where that is slow.
#[inline]
fn falling_root(part: Interval, g: impl Fn(f64) -> f64) -> f64 {
    let (mut a, mut b) = (part.low, part.high);
    let (mut at_a, mut at_b) = (g(a), g(b));
    if at_a <= 0.0 {
        return a;
    }
    if at_b >= 0.0 {
        return b;
    }
    let mut halve = false;
    let mut last = 0.0f64;
    // Every other round at the latest halves the bracket: 120 rounds are never used up.
    for _ in 0..120 {
        let width = b - a;
        let cut = a + width * (at_a / (at_a - at_b));
        let x = if halve || !(cut > a && cut < b) { a + 0.5 * width } else { cut };
        if !(x > a && x < b) {
            break;
        }
        let y = g(x);
        if y > 0.0 {
            (a, at_a) = (x, y);
            if last > 0.0 {
                at_b *= 0.5;
            }
        } else {
            (b, at_b) = (x, y);
            if last < 0.0 {
                at_a *= 0.5;
            }
        }
        // The energy is quadratic here: half of the digits decide its last one.
        if b - a < 1e-13 || y.abs() < 1e-15 {
            return x;
        }
        halve = !halve && b - a > 0.5 * width;
        last = y;
    }
    0.5 * (a + b)
}
