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
pub use shift::CERTIFIED;

use super::{distance, goes_on};
use crate::call::{Answers, Status};
use crate::error::{Error, Result};
use crate::lanes::{Real, angle_over_sine};
use analytic::PreparedRules;

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

/// Sine and cosine of an angle.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Turn {
    sin: f64,
    cos: f64,
}

impl Turn {
    /// The angle within a quarter turn that has this sine.
    #[inline]
    fn of_sine(sin: f64) -> Self {
        Self { sin, cos: other_leg(sin) }
    }

    /// The angle, which is within a quarter turn.
    #[inline]
    fn angle(self) -> Angle {
        Angle { rad: self.sin * angle_over_sine(self.cos), turn: self }
    }
}

/// The cosine that belongs to a sine within a quarter turn, or the sine to a cosine.
#[inline]
fn other_leg(x: f64) -> f64 {
    ((1.0 - x) * (1.0 + x)).max(0.0).sqrt()
}

/// An angle with its sine and cosine.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Angle {
    rad: f64,
    turn: Turn,
}

impl Angle {
    #[inline]
    fn new(rad: f64) -> Self {
        let (sin, cos) = Real::sin_cos(rad);
        Self { rad, turn: Turn { sin, cos } }
    }
}

/// Joint values that reach a target, with the sines and cosines they were made from.
#[derive(Debug, Clone, Copy)]
struct Pose {
    q: Joints,
    theta: Turn,
    beta: Turn,
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

/// A method with what its targets share worked out.
enum Prepared {
    Analytic(PreparedRules),
    Suboptimal(PreparedRules),
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
    /// By how much it does, m; 0 where reached.
    pub gap: Vec<f64>,
}

/// The arm: parameters and what follows from them alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arm {
    parameters: Parameters,
    energy: energy::Terms,
    /// Beta at its limits, and `l3 sin(beta)` there.
    ends: [Angle; 2],
    rise: [f64; 2],
    /// Theta at its limits.
    pitch_ends: [Angle; 2],
    /// Outside this box no target can be reached.
    target_box: [[f64; 3]; 2],
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
        let ends = [Angle::new(p.lower[4]), Angle::new(p.upper[4])];
        let rise = [p.l3 * ends[0].turn.sin, p.l3 * ends[1].turn.sin];
        let pitch_ends = [Angle::new(p.lower[3]), Angle::new(p.upper[3])];
        let target_box = [[0.0; 3]; 2];
        let mut arm = Self { parameters, energy, ends, rise, pitch_ends, target_box, free: None };
        arm.target_box = arm.find_target_box();
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

    #[inline]
    fn reach_of(&self, beta: Turn) -> f64 {
        self.parameters.l2 + self.parameters.l3 * beta.cos
    }

    /// The tool point, m.
    #[inline]
    pub fn fk(&self, q: &Joints) -> [f64; 3] {
        self.fk_of(q, Angle::new(q[3]).turn, Angle::new(q[4]).turn)
    }

    #[inline]
    fn fk_of(&self, q: &Joints, theta: Turn, beta: Turn) -> [f64; 3] {
        let p = &self.parameters;
        let r = self.reach_of(beta);
        [
            q[1] + p.d[0] - r * theta.sin,
            q[0] + p.l1 - p.d[1] + p.l3 * beta.sin,
            -q[2] + p.d[2] - r * theta.cos,
        ]
    }

    /// The joint values that reach a target with given theta and beta, limits aside.
    pub fn slides(&self, target: [f64; 3], theta: f64, beta: f64) -> Joints {
        self.pose(target, Angle::new(theta), Angle::new(beta)).q
    }

    #[inline]
    fn pose(&self, target: [f64; 3], theta: Angle, beta: Angle) -> Pose {
        let p = &self.parameters;
        let r = self.reach_of(beta.turn);
        let q = [
            target[1] - p.l1 + p.d[1] - p.l3 * beta.turn.sin,
            target[0] - p.d[0] + r * theta.turn.sin,
            -target[2] + p.d[2] - r * theta.turn.cos,
            theta.rad,
            beta.rad,
        ];
        Pose { q, theta: theta.turn, beta: beta.turn }
    }

    /// Puts joint values that are past a limit by rounding back on it; `None` where one
    /// is farther off.
    #[inline]
    fn held(&self, mut pose: Pose) -> Option<Pose> {
        let p = &self.parameters;
        let mut inside = true;
        for (i, x) in pose.q.iter_mut().enumerate() {
            inside &= *x >= p.lower[i] - SLIDE_TOLERANCE && *x <= p.upper[i] + SLIDE_TOLERANCE;
            *x = x.max(p.lower[i]).min(p.upper[i]);
        }
        inside.then_some(pose)
    }

    fn within(&self, q: &Joints) -> bool {
        let p = &self.parameters;
        (0..5).all(|i| p.lower[i] <= q[i] && q[i] <= p.upper[i])
    }

    /// Joint values for one target, or what lies in the way.
    pub fn solve(&self, target: [f64; 3], method: &Method) -> std::result::Result<Joints, Gap> {
        self.solve_prepared(target, &self.prepare(method)).map(|pose| pose.q)
    }

    fn prepare(&self, method: &Method) -> Prepared {
        match method {
            Method::Analytic(rules) => Prepared::Analytic(self.prepare_rules(rules)),
            Method::Suboptimal(rules) => Prepared::Suboptimal(self.prepare_rules(rules)),
            Method::Exact => Prepared::Exact,
        }
    }

    #[inline(always)]
    fn solve_prepared(
        &self,
        target: [f64; 3],
        method: &Prepared,
    ) -> std::result::Result<Pose, Gap> {
        if !target.iter().all(|x| x.is_finite()) {
            return Err(Gap::bad_input());
        }
        match method {
            Prepared::Analytic(rules) => self.analytic(target, rules),
            Prepared::Suboptimal(rules) => self.suboptimal(target, rules),
            Prepared::Exact => self.exact(target),
        }
    }

    /// Solves a batch of targets (m). `poll` is asked now and then whether to go on.
    pub fn solve_all(
        &self,
        targets: &[[f64; 3]],
        method: &Method,
        poll: &mut dyn FnMut() -> bool,
    ) -> Result<Solutions> {
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
        let method = self.prepare(method);
        let reset = self.reset_pose();
        let at_reset = self.fk(&reset);
        let (joints, _) = out.answers.q.as_chunks_mut::<5>();
        for (i, (target, q)) in targets.iter().zip(joints).enumerate() {
            goes_on(i, poll)?;
            match self.solve_prepared(*target, &method) {
                Ok(found) => {
                    *q = found.q;
                    out.energy[i] = self.energy_of(&found);
                    // The check that `success` promises: against the target itself.
                    let at = self.fk_of(&found.q, found.theta, found.beta);
                    out.answers.position_error[i] = distance(&at, target);
                    out.answers.orientation_error[i] = 0.0;
                    out.answers.status[i] = Status::Converged as u8;
                }
                Err(gap) => {
                    *q = reset;
                    if gap.status != Status::BadInput {
                        out.answers.position_error[i] = distance(&at_reset, target);
                        out.answers.orientation_error[i] = 0.0;
                    }
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
