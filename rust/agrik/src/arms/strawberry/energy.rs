//! The energy index, its terms and its derivatives along s10.

use super::{Angle, Arm, Joints, Parameters, Pose, Turn};

/// Constants of the index. With `r = l2 + l3 cos(beta)` and the target fixed,
///
/// ```text
/// J = const(target) - A l3 sin(beta) + P sin(theta) - Q cos(theta)
/// P = p0 + p1 cos(beta) = A r          Q = q0 + q1 cos(beta) = k0 + k1 r
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Terms {
    /// Friction force, N.
    pub a: f64,
    /// Weight of both links, N.
    pub m: f64,
    /// Factors of `1 - cos(theta)` and `1 - cos(beta) cos(theta)`, J.
    pub t2: f64,
    pub t3: f64,
    pub p: [f64; 2],
    pub q: [f64; 2],
    pub k: [f64; 2],
}

impl Terms {
    pub fn new(p: &Parameters) -> Self {
        let (a, g) = (p.friction, p.gravity);
        let m = (p.mass2 + p.mass3) * g;
        let t2 = (p.mass2 / 2.0 + p.mass3) * g * p.l2;
        let t3 = p.mass3 * g * p.l3 / 2.0;
        let b = a + m;
        let q = [b * p.l2 - t2, b * p.l3 - t3];
        let k1 = q[1] / p.l3;
        Self { a, m, t2, t3, p: [a * p.l2, a * p.l3], q, k: [q[0] - k1 * p.l2, k1] }
    }
}

/// Which slide limit theta follows while beta changes, for the derivative of theta.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SlopeCase {
    /// Theta stays as it is: what holds when no slide is at a limit.
    Fixed,
    /// Theta keeps s21 at its limit: case 1, (27).
    OnS21,
    /// Theta keeps s32 at its limit: case 2, (28).
    OnS32,
}

impl Arm {
    /// Energy index of joint values, J: friction of the slides from home, (22), less the
    /// potential energy that the arm loses on its way, (21) with its sign as in table 3.
    pub fn energy_index(&self, q: &Joints) -> f64 {
        self.energy_of(&Pose { q: *q, theta: Angle::new(q[3]).turn, beta: Angle::new(q[4]).turn })
    }

    #[inline]
    pub(super) fn energy_of(&self, pose: &Pose) -> f64 {
        let home = &self.parameters.lower;
        let (e, q) = (&self.energy, &pose.q);
        let (cos_t, cos_b) = (pose.theta.cos, pose.beta.cos);
        let travel = (q[0] - home[0]) + (q[1] - home[1]) + (q[2] - home[2]);
        e.a * travel + e.m * (q[2] - home[2]) - e.t2 * (1.0 - cos_t) - e.t3 * (1.0 - cos_b * cos_t)
    }

    /// The part of the index that the choice of theta and beta decides, J.
    #[inline]
    pub(super) fn choice(&self, theta: Turn, beta: Turn) -> f64 {
        let e = &self.energy;
        (e.p[0] + e.p[1] * beta.cos) * theta.sin
            - (e.q[0] + e.q[1] * beta.cos) * theta.cos
            - e.p[1] * beta.sin
    }

    /// Derivative of beta by s10, (26) with l1 in place of the printed l2, rad/m.
    pub fn beta_slope(&self, beta: f64) -> f64 {
        -1.0 / (self.parameters.l3 * beta.cos())
    }

    /// Derivative of theta by beta, (27) and (28), no unit.
    pub fn theta_slope(&self, theta: f64, beta: f64, case: SlopeCase) -> f64 {
        let share = self.parameters.l3 * beta.sin() / self.reach(beta);
        match case {
            SlopeCase::Fixed => 0.0,
            SlopeCase::OnS21 => theta.tan() * share,
            SlopeCase::OnS32 => -share / theta.tan(),
        }
    }

    /// Derivatives of the friction and the potential part of the index by s10, J/m:
    /// (25), and (24) negated as (21) is.
    pub fn energy_slopes(&self, theta: f64, beta: f64, case: SlopeCase) -> [f64; 2] {
        let p = &self.parameters;
        let (sin_t, cos_t) = theta.sin_cos();
        let (sin_b, cos_b) = beta.sin_cos();
        let by_s10 = self.beta_slope(beta);
        let theta_by_s10 = self.theta_slope(theta, beta, case) * by_s10;
        let r = self.reach(beta);
        let friction = p.friction
            * (r * (cos_t + sin_t) * theta_by_s10 + p.l3 * sin_b * (cos_t - sin_t) * by_s10 + 1.0);
        let g = p.gravity;
        let half = p.l2 / 2.0 + p.l3 * cos_b;
        let printed = -p.mass2 * half * g * sin_t * theta_by_s10
            - p.mass3 * p.l3 * g * cos_b * sin_t / 2.0 * theta_by_s10
            + (-p.mass2 - p.mass3 / 2.0) * p.l3 * g * sin_b * cos_t * by_s10;
        [friction, -printed]
    }
}
