//! AS and SSAS: beta and theta by the paper's rules.

use super::sets::Window;
use super::{Angle, Arm, Gap, Interval, Pose, Turn, other_leg};
use crate::error::{Error, Result};

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
    beta: Turn,
}

/// Theta and beta.
#[derive(Debug, Clone, Copy)]
struct Pair {
    theta: Turn,
    beta: Turn,
}

/// What sines and cosines alone say about the set of theta.
enum Found {
    Nearest(Turn),
    Empty,
    /// Rounding decides.
    Unsure,
}

const ZERO: Turn = Turn { sin: 0.0, cos: 1.0 };
/// A sine or cosine this far past a limit is no rounding.
const CLEAR: f64 = 1e-9;

impl Arm {
    pub(super) fn prepare_rules(&self, rules: &Rules) -> PreparedRules {
        let step = match rules.theta {
            ThetaRule::LeastMagnitude { step } => Some(Angle::new(step)),
            ThetaRule::Middle => None,
        };
        let beta = self.best_beta(step.map_or(ZERO, |step| step.turn));
        PreparedRules { s10_share: rules.s10_share, step, beta }
    }

    #[inline]
    pub(super) fn analytic(
        &self,
        target: [f64; 3],
        rules: &PreparedRules,
    ) -> std::result::Result<Pose, Gap> {
        let set = self.s10_set(target)?;
        let window = self.window(target);
        let s10 = set.low + rules.s10_share * (set.high - set.low);
        let beta = self.beta_of_sine(self.beta_sine(target, s10));
        let pair = self.with_beta(&window, beta, rules);
        self.finished(target, pair, rules).ok_or_else(|| self.theta_gap_at(target, &window, beta))
    }

    /// The pose of theta and beta.
    #[inline]
    fn finished(
        &self,
        target: [f64; 3],
        pair: Option<Pair>,
        rules: &PreparedRules,
    ) -> Option<Pose> {
        let Pair { theta, beta } = pair?;
        let theta = match rules.step {
            Some(step) if theta == step.turn => step,
            _ => theta.angle(),
        };
        self.held(self.pose(target, theta, self.beta_angle(beta)))
    }

    /// Theta by rule at a beta; `None` where no theta is left.
    #[inline]
    fn with_beta(&self, window: &Window, beta: Turn, rules: &PreparedRules) -> Option<Pair> {
        let theta = self.theta_by_rule(window, self.reach_of(beta), rules)?;
        Some(Pair { theta, beta })
    }

    #[inline]
    fn theta_by_rule(&self, window: &Window, r: f64, rules: &PreparedRules) -> Option<Turn> {
        let [low, high] = self.pitch_ends;
        let fits = |theta: Turn| {
            window.u.holds(r * theta.sin)
                && window.w.holds(r * theta.cos)
                && low.turn.sin <= theta.sin
                && theta.sin <= high.turn.sin
        };
        let Some(step) = &rules.step else { return self.middle_theta(window, r) };
        // Most often 0 and the step are both in the set, which is then not needed.
        if fits(ZERO) {
            return Some(if fits(step.turn) { step.turn } else { ZERO });
        }
        match self.least_by_sines(window, r) {
            Found::Nearest(theta) => Some(theta),
            Found::Empty => None,
            Found::Unsure => self.least_theta(window, r),
        }
    }

    /// The element of least magnitude where 0 is none, by sines and cosines alone: on the
    /// side of 0 where the greatest of the lower bounds of `|sin(theta)|` is below the
    /// least of the upper ones.
    #[inline]
    fn least_by_sines(&self, window: &Window, r: f64) -> Found {
        let inverse = 1.0 / r;
        let (near, far) = (window.w.high * inverse, window.w.low * inverse);
        if near < -CLEAR || far > 1.0 + CLEAR {
            return Found::Empty;
        }
        if near < 0.0 || far > 1.0 {
            return Found::Unsure;
        }
        // The least that slide s32 leaves, the same on both sides.
        let cos = near.min(1.0);
        let raised = Turn { sin: other_leg(cos), cos };
        let side = |u_low: f64, u_high: f64, joint_low: f64, joint_high: f64| {
            let sin = (u_low * inverse).max(joint_low);
            let turn = if sin > raised.sin { Turn::of_sine(sin) } else { raised };
            let past = (turn.sin - (u_high * inverse).min(joint_high)).max(far - turn.cos);
            if past <= 0.0 && turn.cos > 0.0 {
                Found::Nearest(turn)
            } else if past > CLEAR {
                Found::Empty
            } else {
                Found::Unsure
            }
        };
        let ([low, high], u) = (self.pitch_ends.map(|end| end.turn.sin), window.u);
        let mirrored = |turn: Turn| Found::Nearest(Turn { sin: -turn.sin, ..turn });
        // Of two as near to 0 the negative one, as the sets are in ascending order.
        match (side(-u.high, -u.low, -high, -low), side(u.low, u.high, low, high)) {
            (Found::Nearest(below), Found::Nearest(above)) if above.sin < below.sin => {
                Found::Nearest(above)
            }
            (Found::Nearest(below), Found::Nearest(_) | Found::Empty) => mirrored(below),
            (Found::Empty, above) => above,
            _ => Found::Unsure,
        }
    }

    #[inline(never)]
    fn least_theta(&self, window: &Window, r: f64) -> Option<Turn> {
        let sets = self.theta_sets_of(window, r).all;
        let nearest = sets.iter().flatten().map(|set| set.nearest(0.0));
        nearest.min_by(|a, b| a.abs().total_cmp(&b.abs())).map(|theta| Angle::new(theta).turn)
    }

    #[inline(never)]
    fn middle_theta(&self, window: &Window, r: f64) -> Option<Turn> {
        let width = |set: &&Interval| set.high - set.low;
        let sets = self.theta_sets_of(window, r).all;
        let widest = sets.iter().flatten().max_by(|a, b| width(a).total_cmp(&width(b)));
        widest.map(|set| Angle::new(set.middle()).turn)
    }

    /// Beta of least energy at a fixed theta.
    #[inline]
    fn best_beta(&self, theta: Turn) -> Turn {
        let e = &self.energy;
        let (y, x) = (e.p[1], e.q[1] * theta.cos - e.p[1] * theta.sin);
        let inverse = 1.0 / (y * y + x * x).sqrt();
        if inverse.is_finite() { Turn { sin: y * inverse, cos: x * inverse } } else { ZERO }
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
        let [low, high] = [self.beta_sine(target, set.high), self.beta_sine(target, set.low)];
        let middle = self.beta_of_sine(0.5 * (low + high));
        let analytic = self.with_beta(&window, middle, rules);
        let first = self.with_beta(&window, self.clipped(rules.beta, low, high), rules);
        let pair = match (&rules.step, first) {
            // Of all poses with theta at the step this is the least; where the step does
            // not fit, another theta may need less.
            (Some(step), Some(pair)) if pair.theta == step.turn => self.lesser(analytic, pair),
            (_, Some(pair)) => self.in_rounds(&window, [low, high], rules, analytic, pair),
            (_, None) => analytic,
        };
        self.finished(target, pair, rules).ok_or_else(|| self.theta_gap_at(target, &window, middle))
    }

    /// Beta within what the set of s10 leaves, given by sines.
    #[inline]
    fn clipped(&self, beta: Turn, low: f64, high: f64) -> Turn {
        // Beyond a quarter turn, always upwards, the sine falls again.
        if beta.cos > 0.0 && beta.sin < low {
            self.beta_of_sine(low)
        } else if beta.cos > 0.0 && beta.sin <= high {
            beta
        } else {
            self.beta_of_sine(high)
        }
    }

    /// Theta follows a slide's limit: beta and theta in turn, the best of all rounds. The
    /// rounds need not end at the best beta, or may leave no theta: `analytic`, the
    /// analytical solution, is a candidate too.
    #[inline]
    fn in_rounds(
        &self,
        window: &Window,
        [low, high]: [f64; 2],
        rules: &PreparedRules,
        analytic: Option<Pair>,
        first: Pair,
    ) -> Option<Pair> {
        let (mut best, mut last) = (self.lesser(analytic, first), first);
        for _ in 1..ROUNDS {
            let beta = self.clipped(self.best_beta(last.theta), low, high);
            if beta == last.beta {
                break;
            }
            let Some(pair) = self.with_beta(window, beta, rules) else { break };
            best = self.lesser(best, pair);
            last = pair;
        }
        best
    }

    /// The one of less energy.
    #[inline]
    fn lesser(&self, one: Option<Pair>, other: Pair) -> Option<Pair> {
        let energy = |pair: Pair| self.choice(pair.theta, pair.beta);
        Some(match one {
            Some(one) if energy(one) < energy(other) => one,
            _ => other,
        })
    }
}
