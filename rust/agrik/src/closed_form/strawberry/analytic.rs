//! AS and SSAS: beta and theta by the paper's rules.

use super::sets::Window;
use super::{Angle, Arm, Gap, Interval, Pose};
use crate::error::{Error, Result};
use crate::lanes::angle_over_sine;

/// Rounds of SSAS between beta and theta where a slide's limit decides theta; on all of
/// table 3 there are none.
const ROUNDS: usize = 4;

/// How theta is chosen from its set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ThetaRule {
    /// The element of least magnitude (remark 2); this step, rad, where 0 is in the set.
    /// Table 3 was computed with 0.01, the remark's text says 0.
    LeastMagnitude {
        /// Angle in place of 0, rad.
        step: f64,
    },
    /// The middle of the widest interval: farthest from the slides' limits.
    Middle,
}

/// The selection rules of remarks 1 and 2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// Where in its set s10 is chosen: 0 the lower end, 1 the upper, remark 1's 0.5 the
    /// middle. Not used by SSAS, which searches s10.
    pub s10_share: f64,
    /// How theta is chosen.
    pub theta: ThetaRule,
}

impl Default for Rules {
    fn default() -> Self {
        Self { s10_share: 0.5, theta: ThetaRule::LeastMagnitude { step: 0.01 } }
    }
}

impl Rules {
    pub(super) fn check(&self) -> Result<()> {
        if !(0.0..=1.0).contains(&self.s10_share) {
            return Err(Error::argument("s10_share", "a number, 0 to 1", self.s10_share));
        }
        if let ThetaRule::LeastMagnitude { step } = self.theta
            && !step.is_finite()
        {
            return Err(Error::argument("theta_step", "a finite number", step));
        }
        Ok(())
    }
}

/// Rules with the sines and cosines that all targets share.
#[derive(Debug, Clone, Copy)]
pub(super) struct PreparedRules {
    s10_share: f64,
    /// The step of [`ThetaRule::LeastMagnitude`]; `None` for the middle.
    step: Option<Angle>,
    /// Beta of least energy at the step.
    beta: Angle,
}

impl Arm {
    pub(super) fn prepare_rules(&self, rules: &Rules) -> PreparedRules {
        let step = match rules.theta {
            ThetaRule::LeastMagnitude { step } => Some(Angle::new(step)),
            ThetaRule::Middle => None,
        };
        let beta = self.best_beta(&step.unwrap_or(Angle::new(0.0)));
        PreparedRules { s10_share: rules.s10_share, step, beta }
    }

    #[inline]
    pub(super) fn analytic(
        &self,
        target: [f64; 3],
        rules: &PreparedRules,
    ) -> std::result::Result<Pose, Gap> {
        let set = self.s10_set(target)?;
        let s10 = set.low + rules.s10_share * (set.high - set.low);
        let beta = self.beta_at(target, s10);
        self.with_beta(target, &self.window(target), beta, rules)
    }

    /// Theta by rule at a beta, and the slides.
    #[inline]
    fn with_beta(
        &self,
        target: [f64; 3],
        window: &Window,
        beta: Angle,
        rules: &PreparedRules,
    ) -> std::result::Result<Pose, Gap> {
        let r = self.parameters.l2 + self.parameters.l3 * beta.cos;
        let gap = || self.theta_gap_at(target, window, r);
        let theta = self.theta_by_rule(window, r, rules).ok_or_else(gap)?;
        self.held(self.pose(target, theta, beta)).ok_or_else(gap)
    }

    #[inline]
    fn theta_by_rule(&self, window: &Window, r: f64, rules: &PreparedRules) -> Option<Angle> {
        let p = &self.parameters;
        let joint = Interval::new(p.lower[3], p.upper[3]);
        let fits = |theta: &Angle| {
            window.u.holds(r * theta.sin) && window.w.holds(r * theta.cos) && joint.holds(theta.rad)
        };
        let Some(step) = &rules.step else { return self.middle_theta(window, r) };
        let zero = Angle { rad: 0.0, sin: 0.0, cos: 1.0 };
        // Most often 0 and the step are both in the set, which is then not needed.
        if fits(&zero) {
            return Some(if fits(step) { *step } else { zero });
        }
        self.least_by_sines(window, r).or_else(|| self.least_theta(window, r))
    }

    /// The element of least magnitude where 0 is none, by sines and cosines alone: on the
    /// side of 0 where the greatest of the lower bounds of `|sin(theta)|` is below the
    /// least of the upper ones. `None` where neither side is clearly so.
    #[inline]
    fn least_by_sines(&self, window: &Window, r: f64) -> Option<Angle> {
        let inverse = 1.0 / r;
        let across = |cos: f64| ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
        let (near, far) = (window.w.high * inverse, window.w.low * inverse);
        if near < 0.0 || far > 1.0 {
            return None;
        }
        // What slide s32 leaves, the same on both sides.
        let cos = near.min(1.0);
        let (raised, deepest) = (across(cos), if far > 0.0 { across(far) } else { 1.0 });
        let side = |u_low: f64, u_high: f64, joint_low: f64, joint_high: f64| {
            let sin = (u_low * inverse).max(joint_low);
            let most = (u_high * inverse).min(deepest).min(joint_high);
            let angle = if sin > raised {
                Angle::of_sine(sin)
            } else {
                Angle { rad: raised * angle_over_sine(cos), sin: raised, cos }
            };
            (angle.sin <= most && angle.cos > 0.0).then_some(angle)
        };
        let ([low, high], u) = (self.pitch_sines, window.u);
        let above = side(u.low, u.high, low, high);
        let below = side(-u.high, -u.low, -high, -low);
        let below = below.map(|a| Angle { rad: -a.rad, sin: -a.sin, cos: a.cos });
        match (above, below) {
            // Of two as near to 0 the negative one, as the sets are in ascending order.
            (Some(a), Some(b)) => Some(if a.rad + b.rad >= 0.0 { b } else { a }),
            (a, b) => a.or(b),
        }
    }

    #[inline(never)]
    fn least_theta(&self, window: &Window, r: f64) -> Option<Angle> {
        let sets = self.theta_sets_of(window, r).all;
        let nearest = sets.iter().flatten().map(|set| set.nearest(0.0));
        nearest.min_by(|a, b| a.abs().total_cmp(&b.abs())).map(Angle::new)
    }

    #[inline(never)]
    fn middle_theta(&self, window: &Window, r: f64) -> Option<Angle> {
        let width = |set: &&Interval| set.high - set.low;
        let sets = self.theta_sets_of(window, r).all;
        let widest = sets.iter().flatten().max_by(|a, b| width(a).total_cmp(&width(b)));
        widest.map(|set| Angle::new(set.middle()))
    }

    /// Beta of least energy at a fixed theta.
    #[inline]
    fn best_beta(&self, theta: &Angle) -> Angle {
        let e = &self.energy;
        let (y, x) = (e.p[1], e.q[1] * theta.cos - e.p[1] * theta.sin);
        let inverse = 1.0 / (y * y + x * x).sqrt();
        // A turn of more than a quarter has no arc sine.
        if x > 0.0 && inverse.is_finite() {
            let (sin, cos) = (y * inverse, x * inverse);
            Angle { rad: sin * angle_over_sine(cos), sin, cos }
        } else {
            Angle::new(y.atan2(x))
        }
    }

    #[inline]
    pub(super) fn suboptimal(
        &self,
        target: [f64; 3],
        rules: &PreparedRules,
    ) -> std::result::Result<Pose, Gap> {
        let set = self.s10_set(target)?;
        let window = self.window(target);
        // Beta falls as s10 grows.
        let [low, high] = [self.s10_beta(target, set.high), self.s10_beta(target, set.low)];
        let clip = |beta: Angle| {
            if beta.sin < low {
                self.beta_at(target, set.high)
            } else if beta.sin > high {
                self.beta_at(target, set.low)
            } else {
                beta
            }
        };
        let analytic = self.analytic(target, &PreparedRules { s10_share: 0.5, ..*rules });
        if let (Some(step), Ok(pose)) =
            (&rules.step, self.with_beta(target, &window, clip(rules.beta), rules))
            && pose.q[3] == step.rad
        {
            // Of all poses with theta at the step this is the least; where the step does
            // not fit, another theta may need less.
            return Ok(match analytic {
                Ok(other) if self.energy_of(&other) < self.energy_of(&pose) => other,
                _ => pose,
            });
        }
        self.in_rounds(target, &window, &clip, rules, analytic)
    }

    /// Sine of beta at s10, not held to any limit.
    #[inline]
    fn s10_beta(&self, target: [f64; 3], s10: f64) -> f64 {
        let p = &self.parameters;
        (target[1] - s10 - p.l1 + p.d[1]) / p.l3
    }

    /// Theta follows a slide's limit: beta and theta in turn, the best pose of all rounds.
    /// The rounds need not end at the best beta, or may leave no theta: `found`, the
    /// analytical solution, is a candidate too.
    #[inline(never)]
    fn in_rounds(
        &self,
        target: [f64; 3],
        window: &Window,
        clip: &impl Fn(Angle) -> Angle,
        rules: &PreparedRules,
        mut found: std::result::Result<Pose, Gap>,
    ) -> std::result::Result<Pose, Gap> {
        let mut least = found.as_ref().map_or(f64::INFINITY, |pose| self.energy_of(pose));
        let mut beta = clip(rules.beta);
        for _ in 0..ROUNDS {
            let Ok(pose) = self.with_beta(target, window, beta, rules) else { break };
            let energy = self.energy_of(&pose);
            if energy < least {
                least = energy;
                found = Ok(pose);
            }
            let next = clip(self.best_beta(&pose.theta));
            if next.rad == beta.rad {
                break;
            }
            beta = next;
        }
        found
    }
}
