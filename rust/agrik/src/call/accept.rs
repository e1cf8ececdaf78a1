//! Which postures that reach a target may be its answer: those free of collisions, say.
//!
//! Solvers know nothing of what keeps a posture from being an answer. They ask about postures
//! that have reached their target already, so that a call without such a question has no work
//! with it.

use std::fmt;

use crate::lanes::Lanes;

/// Postures that are asked about at a time, at most.
pub const TOGETHER: usize = Lanes::BITS as usize;

/// What decides whether a posture may be an answer.
///
/// Postures are rows of joint values within the limits (rad and m). Answers depend on them
/// alone, so that those of a call do not depend on threads.
pub trait Accept: fmt::Debug + Send + Sync {
    /// Which of up to [`TOGETHER`] postures may be answers: bit `i` for row `i`.
    fn accepts(&self, q: &[f64]) -> Lanes;

    /// How far one posture is from being refused, m, or `cap` where that is less: 0 or less
    /// exactly where it is refused, the less the worse.
    fn margin(&self, q: &[f64], cap: f64) -> f64;

    /// The margin of one posture, and in `rates` how it changes with each joint value, m/rad
    /// or no unit; zeros where that is not known.
    fn slope(&self, q: &[f64], rates: &mut [f64]) -> f64;

    /// True where every posture of the straight way `change` from `q` is proven to be accepted.
    fn is_way_sure(&self, q: &[f64], change: &[f64]) -> bool;
}

/// Which of several postures that may be answers is the answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Prefer {
    /// The first that is found; of a closed form the best by its own choice.
    #[default]
    First,
    /// Of several the nearest to the start values, or without any to the middle of the limits.
    Near,
    /// Of several the one with the largest margin, which a redundant arm then enlarges.
    Clearance,
}

impl Prefer {
    /// Every preference with the name that users know it by.
    pub const ALL: [(&'static str, Self); 3] =
        [("first", Self::First), ("near", Self::Near), ("clearance", Self::Clearance)];
}

/// What a call asks of its answers besides reaching the target.
#[derive(Debug, Clone, Copy)]
pub struct Guard<'a> {
    /// What decides.
    pub accept: &'a dyn Accept,
    /// Which of several.
    pub prefer: Prefer,
}

/// A posture that reaches its target, as good as its guard finds it; the larger the better.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub(crate) struct Verdict {
    /// It may be an answer.
    pub accepted: bool,
    /// What it is preferred by; of a refused one the margin, m.
    score: f64,
}

impl Guard<'_> {
    /// What an accepted posture is preferred by, the larger the better. `cost` is what it is the
    /// answer by without a guard, and `about` what near ones are near to.
    pub(crate) fn score(&self, q: &[f64], cost: f64, about: impl Fn(usize) -> f64) -> f64 {
        let away = |(i, x): (usize, &f64)| (x - about(i)).powi(2);
        match self.prefer {
            Prefer::First => -cost,
            Prefer::Near => -q.iter().enumerate().map(away).sum::<f64>(),
            Prefer::Clearance => self.accept.margin(q, f64::INFINITY),
        }
    }

    /// Asks about a posture; refused ones are told by their margins.
    pub(crate) fn verdict(&self, q: &[f64], cost: f64, about: impl Fn(usize) -> f64) -> Verdict {
        let accepted = self.accept.accepts(q) & 1 != 0;
        let score = if accepted {
            self.score(q, cost, about)
        } else {
            self.accept.margin(q, f64::INFINITY)
        };
        Verdict { accepted, score }
    }

    /// Which of some postures has the largest margin; the first of several.
    pub(crate) fn best_margin<'q>(&self, postures: impl Iterator<Item = &'q [f64]>) -> usize {
        let mut best = (f64::NEG_INFINITY, 0);
        for (i, q) in postures.enumerate() {
            let margin = self.accept.margin(q, f64::INFINITY);
            if margin > best.0 {
                best = (margin, i);
            }
        }
        best.1
    }
}
