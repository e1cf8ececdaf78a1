//! AS and SSAS: beta and theta by the paper's rules.

use super::sets::Window;
use super::{Arm, Gap, Interval, Joints};
use crate::error::{Error, Result};

/// Rounds of SSAS between beta and theta; on all of table 3 the first one is the last.
const ROUNDS: usize = 16;

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

impl Arm {
    #[inline]
    pub(super) fn analytic(
        &self,
        target: [f64; 3],
        rules: &Rules,
    ) -> std::result::Result<Joints, Gap> {
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
        beta: f64,
        rules: &Rules,
    ) -> std::result::Result<Joints, Gap> {
        let r = self.reach(beta);
        let gap = || self.theta_gap_at(target, window, r);
        let theta = self.theta_by_rule(window, r, rules.theta).ok_or_else(gap)?;
        self.held(self.slides(target, theta, beta)).ok_or_else(gap)
    }

    #[inline]
    fn theta_by_rule(&self, window: &Window, r: f64, rule: ThetaRule) -> Option<f64> {
        let p = &self.parameters;
        match rule {
            ThetaRule::LeastMagnitude { step } => {
                let straight = window.u.holds(0.0)
                    && window.w.holds(r)
                    && p.lower[3] <= 0.0
                    && p.upper[3] >= 0.0;
                if straight {
                    let (sin, cos) = step.sin_cos();
                    // Most often both ends of the step are free and no set is needed.
                    if window.u.holds(r * sin)
                        && window.w.holds(r * cos)
                        && p.lower[3] <= step
                        && step <= p.upper[3]
                    {
                        return Some(step);
                    }
                    return Some(0.0);
                }
                self.theta_sets_of(window, r)
                    .all
                    .iter()
                    .flatten()
                    .map(|set| set.nearest(0.0))
                    .min_by(|a, b| a.abs().total_cmp(&b.abs()))
            }
            ThetaRule::Middle => {
                let width = |set: &&Interval| set.high - set.low;
                let sets = self.theta_sets_of(window, r).all;
                let widest = sets.iter().flatten().max_by(|a, b| width(a).total_cmp(&width(b)));
                widest.map(|set| set.middle())
            }
        }
    }

    /// Beta of least energy at a fixed theta, rad.
    #[inline]
    fn best_beta(&self, theta: f64) -> f64 {
        let e = &self.energy;
        let (sin_t, cos_t) = theta.sin_cos();
        e.p[1].atan2(e.q[1] * cos_t - e.p[1] * sin_t)
    }

    #[inline]
    pub(super) fn suboptimal(
        &self,
        target: [f64; 3],
        rules: &Rules,
    ) -> std::result::Result<Joints, Gap> {
        let set = self.s10_set(target)?;
        // Beta falls as s10 grows.
        let betas = Interval::new(self.beta_at(target, set.high), self.beta_at(target, set.low));
        let window = self.window(target);
        let mut theta = match rules.theta {
            ThetaRule::LeastMagnitude { step } => step,
            ThetaRule::Middle => 0.0,
        };
        let mut beta = betas.nearest(self.best_beta(theta));
        let mut best: Option<Joints> = None;
        let mut settled = false;
        for round in 0..ROUNDS {
            let Ok(q) = self.with_beta(target, &window, beta, rules) else { break };
            let better = best.is_none_or(|old| self.energy_index(&q) < self.energy_index(&old));
            if better {
                best = Some(q);
            }
            // Theta, and with it the best beta, settle where the rule holds theta fixed.
            if q[3] == theta {
                // The rule holds theta fixed over beta, so that this is the least of all.
                settled = round == 0;
                break;
            }
            theta = q[3];
            let next = betas.nearest(self.best_beta(theta));
            if next == beta {
                break;
            }
            beta = next;
        }
        if settled {
            return best.ok_or_else(Gap::bad_input);
        }
        // Where theta follows a slide's limit the rounds need not end at the best beta,
        // or may leave no theta: the analytical solution is then a candidate too.
        match (best, self.analytic(target, &Rules { s10_share: 0.5, ..*rules })) {
            (Some(a), Ok(b)) if self.energy_index(&a) <= self.energy_index(&b) => Ok(a),
            (Some(a), Err(_)) => Ok(a),
            (_, analytic) => analytic,
        }
    }
}
