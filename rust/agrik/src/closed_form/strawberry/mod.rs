//! The strawberry handling arm (Defterli and Xu 2017): three slides, then pitch and roll.
//!
//! ```text
//! x =  s21 + dx - r sin(theta)            r = l2 + l3 cos(beta)
//! y =  s10 + l1 - dy + l3 sin(beta)
//! z = -s32 + dz - r cos(theta)
//! ```
//!
//! A target fixes three of the five joint values, so that (theta, beta) are free inside
//! the set that the slides' limits leave. [`analytic`] picks a point of that set by rule
//! (the paper's AS and SSAS), [`exact`] the one of least energy, with a proof.

mod analytic;
mod command;
mod energy;
mod exact;
mod sets;
mod shift;

pub use analytic::{Rules, ThetaRule};
pub use command::{Axis, Command};
pub use energy::SlopeCase;
pub use exact::FreePose;
pub use sets::{Gap, Interval, Place, ThetaSets};

use crate::error::{Error, Result};
use crate::solve::{Answers, Status};

/// How far a slide may be past its limit before that counts, m: the rounding of the
/// formulas. Answers are put back on the limit.
pub const SLIDE_TOLERANCE: f64 = 1e-14;

/// Joint values in the order s10, s21, s32 (m), theta, beta (rad).
pub type Joints = [f64; 5];

/// Lengths, limits and energy constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// Offset of the arm from the s10 slide, m.
    pub l1: f64,
    /// Link from the pitch to the roll axis, m.
    pub l2: f64,
    /// Link from the roll axis to the tool point, m.
    pub l3: f64,
    /// Offsets of the base frame, m.
    pub d: [f64; 3],
    /// Smallest joint values, m and rad.
    pub lower: Joints,
    /// Largest joint values, m and rad.
    pub upper: Joints,
    /// Friction force of a slide that moves (mu W), N.
    pub friction: f64,
    /// Mass of the first arm link, kg.
    pub mass2: f64,
    /// Mass of the second arm link, kg.
    pub mass3: f64,
    /// Gravity, m/s^2.
    pub gravity: f64,
}

impl Default for Parameters {
    /// The paper's lengths and limits; what it leaves out is fitted to its table 3.
    fn default() -> Self {
        Self {
            l1: 0.090,
            l2: 0.102,
            l3: 0.060,
            d: [0.0, -0.0685, -0.027_303_6],
            lower: [0.075, 0.080, 0.061, (-58.0f64).to_radians(), 0.0],
            upper: [0.660, 0.920, 0.251, 52.0f64.to_radians(), 73.0f64.to_radians()],
            friction: 9.81,
            mass2: 1.0,
            mass3: 0.5,
            gravity: 9.81,
        }
    }
}

/// Which of the three ways to choose theta and beta.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Method {
    /// Analytical solution: by the rules of the paper's remarks 1 and 2.
    Analytic(Rules),
    /// Suboptimal semi-analytical solution: least energy over s10, theta by rule.
    Suboptimal(Rules),
    /// Least energy of all.
    Exact,
}

/// Answers of a batch: the common record, and what this arm adds to it.
#[derive(Debug, Clone, Default)]
pub struct Solutions {
    /// The record that all solvers share.
    pub answers: Answers,
    /// Energy index of each answer, J; NaN where there is none.
    pub energy: Vec<f64>,
    /// Codes of [`Place`]: what lies in the way.
    pub place: Vec<u8>,
    /// By how much it does, m for slides and rad for theta; 0 where reached.
    pub gap: Vec<f64>,
}

/// The arm: parameters and what follows from them alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arm {
    parameters: Parameters,
    energy: energy::Terms,
    /// `l3 sin(beta)` at the limits.
    rise: [f64; 2],
    free: Option<FreePose>,
}

impl Arm {
    /// Checked parameters.
    pub fn new(parameters: Parameters) -> Result<Self> {
        let p = &parameters;
        let positive = [("l2", p.l2), ("l3", p.l3)];
        let not_negative = [
            ("friction", p.friction),
            ("mass2", p.mass2),
            ("mass3", p.mass3),
            ("gravity", p.gravity),
        ];
        for (name, value) in positive {
            if !(value.is_finite() && value > 0.0) {
                return Err(Error::argument(name, "a finite number above 0", value));
            }
        }
        for (name, value) in not_negative {
            if !(value.is_finite() && value >= 0.0) {
                return Err(Error::argument(name, "a finite number, 0 or more", value));
            }
        }
        for (name, value) in [("l1", p.l1), ("dx", p.d[0]), ("dy", p.d[1]), ("dz", p.d[2])] {
            if !value.is_finite() {
                return Err(Error::argument(name, "a finite number", value));
            }
        }
        let quarter = std::f64::consts::FRAC_PI_2;
        for (i, name) in ["s10", "s21", "s32", "theta", "beta"].into_iter().enumerate() {
            let (low, high) = (p.lower[i], p.upper[i]);
            if !(low.is_finite() && high.is_finite() && low <= high) {
                let received = format!("{low}, {high}");
                return Err(Error::argument(name, "finite limits, lower <= upper", received));
            }
            // Beyond a quarter turn one slide position belongs to two angles.
            if i >= 3 && !(low > -quarter && high < quarter) {
                let received = format!("{low}, {high}");
                return Err(Error::argument(name, "limits within a quarter turn", received));
            }
        }
        let energy = energy::Terms::new(p);
        let rise = [p.l3 * p.lower[4].sin(), p.l3 * p.upper[4].sin()];
        let mut arm = Self { parameters, energy, rise, free: None };
        arm.free = arm.free_pose();
        Ok(arm)
    }

    /// The parameters.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The pose of least energy when no slide is at a limit, the same for all targets;
    /// `None` where it is outside the limits of theta and beta.
    pub fn free(&self) -> Option<FreePose> {
        self.free
    }

    /// Home and reset pose: slides drawn in, arm straight down.
    pub fn reset_pose(&self) -> Joints {
        let p = &self.parameters;
        let inside = |i: usize| 0.0f64.clamp(p.lower[i], p.upper[i]);
        [p.lower[0], p.lower[1], p.lower[2], inside(3), inside(4)]
    }

    /// Distance of the tool point from the pitch axis, m.
    #[inline]
    fn reach(&self, beta: f64) -> f64 {
        self.parameters.l2 + self.parameters.l3 * beta.cos()
    }

    /// The tool point, m.
    #[inline]
    pub fn fk(&self, q: &Joints) -> [f64; 3] {
        let p = &self.parameters;
        let (sin_t, cos_t) = q[3].sin_cos();
        let (sin_b, cos_b) = q[4].sin_cos();
        let r = p.l2 + p.l3 * cos_b;
        [q[1] + p.d[0] - r * sin_t, q[0] + p.l1 - p.d[1] + p.l3 * sin_b, -q[2] + p.d[2] - r * cos_t]
    }

    /// The joint values that reach a target with given theta and beta, limits aside.
    #[inline]
    pub fn slides(&self, target: [f64; 3], theta: f64, beta: f64) -> Joints {
        let (sin_t, cos_t) = theta.sin_cos();
        let (sin_b, cos_b) = beta.sin_cos();
        self.slides_of(target, theta, beta, [sin_t, cos_t, sin_b, cos_b])
    }

    /// [`Arm::slides`] with sines and cosines at hand.
    #[inline]
    fn slides_of(&self, target: [f64; 3], theta: f64, beta: f64, trig: [f64; 4]) -> Joints {
        let p = &self.parameters;
        let r = p.l2 + p.l3 * trig[3];
        [
            target[1] - p.l1 + p.d[1] - p.l3 * trig[2],
            target[0] - p.d[0] + r * trig[0],
            -target[2] + p.d[2] - r * trig[1],
            theta,
            beta,
        ]
    }

    /// Puts joint values that are past a limit by rounding back on it; `None` where one
    /// is farther off.
    #[inline]
    fn held(&self, mut q: Joints) -> Option<Joints> {
        let p = &self.parameters;
        let mut inside = true;
        for (i, x) in q.iter_mut().enumerate() {
            inside &= *x >= p.lower[i] - SLIDE_TOLERANCE && *x <= p.upper[i] + SLIDE_TOLERANCE;
            *x = x.max(p.lower[i]).min(p.upper[i]);
        }
        inside.then_some(q)
    }

    /// Joint values for one target, or what lies in the way.
    #[inline]
    pub fn solve(&self, target: [f64; 3], method: &Method) -> std::result::Result<Joints, Gap> {
        if !target.iter().all(|x| x.is_finite()) {
            return Err(Gap::bad_input());
        }
        match method {
            Method::Analytic(rules) => self.analytic(target, rules),
            Method::Suboptimal(rules) => self.suboptimal(target, rules),
            Method::Exact => self.exact(target),
        }
    }

    /// Solves a batch of targets (m).
    pub fn solve_all(&self, targets: &[[f64; 3]], method: &Method) -> Result<Solutions> {
        match method {
            Method::Analytic(rules) | Method::Suboptimal(rules) => rules.check()?,
            Method::Exact => self.check_certificate()?,
        }
        let rows = targets.len();
        let mut out = Solutions {
            answers: Answers::new(rows, 5),
            energy: vec![f64::NAN; rows],
            place: vec![Place::Reached as u8; rows],
            gap: vec![0.0; rows],
        };
        let (joints, _) = out.answers.q.as_chunks_mut::<5>();
        for (i, (target, q)) in targets.iter().zip(joints).enumerate() {
            match self.solve(*target, method) {
                Ok(found) => {
                    *q = found;
                    out.energy[i] = self.energy_index(&found);
                    // The check that `success` promises: against the target itself.
                    let at = self.fk(&found);
                    let off: f64 = at.iter().zip(target).map(|(a, b)| (a - b) * (a - b)).sum();
                    out.answers.position_error[i] = off.sqrt();
                    out.answers.orientation_error[i] = 0.0;
                    out.answers.status[i] = Status::Converged as u8;
                }
                Err(gap) => {
                    *q = self.reset_pose();
                    out.place[i] = gap.place as u8;
                    out.gap[i] = gap.amount;
                    out.answers.status[i] = gap.status as u8;
                }
            }
        }
        Ok(out)
    }
}

#[cfg(test)]
mod tests;
