//! What a plan is asked for, and the questions that it asks.

use std::time::{Duration, Instant};

use agrik::chain::JointKind;
use agrik_compute::Allowed;
use agrik_compute::random::mix;

use super::metric::Metric;
use crate::edges::{Certifier, Keep};
use crate::{Collider, Error, Result};

/// How a path is looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// What the path keeps; `cap` is how far its distance is told.
    pub keep: Keep,
    /// Goals that are tried, of those given.
    pub goals: usize,
    /// Longest step of a tree, m of the metric.
    pub step: f64,
    /// Rounds of the trees, eight extensions each.
    pub rounds: u32,
    /// Questions for the whole plan; see [`Keep::max_checks`], which is for one way.
    pub max_checks: u64,
    /// Tries to make a path shorter.
    pub shortcuts: u32,
    /// Look for lines of the tool out of the goals.
    pub retreats: bool,
    /// Look for a proof where no path is found.
    pub prove: bool,
    /// Which random numbers are drawn.
    pub seed: u64,
    /// Seconds after which it ends; answers then depend on the machine.
    pub time_limit: Option<f64>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            keep: Keep::clear(0.002).with_cap(0.05),
            goals: 12,
            step: 0.3,
            rounds: 400,
            max_checks: 300_000,
            shortcuts: 60,
            retreats: true,
            prove: true,
            seed: 0,
            time_limit: None,
        }
    }
}

impl Settings {
    /// Refuses numbers out of their ranges.
    ///
    /// # Errors
    ///
    /// Names the first of them.
    pub fn check(&self) -> Result<()> {
        self.keep.check()?;
        Allowed::POSITIVE.of("m").check("step", self.step)?;
        if self.goals == 0 {
            return Err(Error::argument("n_goals", "1 or more", 0));
        }
        if self.max_checks == 0 {
            return Err(Error::argument("max_checks", "1 or more", 0));
        }
        if let Some(limit) = self.time_limit {
            Allowed::POSITIVE.of("s").check("time_limit", limit)?;
        }
        Ok(())
    }
}

/// A plan's questions: counted, so that they end.
#[derive(Debug)]
pub struct Ask<'c> {
    certifier: Certifier<'c>,
    pub(super) settings: Settings,
    pub(super) metric: Metric,
    /// Where postures are drawn from.
    ranges: Vec<(f64, f64)>,
    pub(super) checks: u64,
    deadline: Option<Instant>,
}

impl<'c> Ask<'c> {
    /// Of an arm in a scene.
    ///
    /// # Errors
    ///
    /// A setting is out of its range.
    pub fn new(collider: &'c Collider, settings: Settings) -> Result<Self> {
        settings.check()?;
        let chain = collider.bodies().chain();
        let size = chain.reach().size;
        let range = |v: &agrik::chain::Variable| {
            let most = match v.kind {
                JointKind::Prismatic if size.is_finite() => size,
                _ => std::f64::consts::PI,
            };
            let bounded = v.lower.is_finite() && v.upper.is_finite();
            if bounded { (v.lower, v.upper) } else { (v.lower.max(-most), v.upper.min(most)) }
        };
        let quick = Keep { cap: settings.keep.clear, ..settings.keep };
        let limit = settings.time_limit.map(Duration::from_secs_f64);
        Ok(Self {
            certifier: Certifier::new(collider, quick),
            metric: Metric::new(collider.bodies()),
            ranges: chain.variables().iter().map(range).collect(),
            checks: 0,
            deadline: limit.and_then(|limit| Instant::now().checked_add(limit)),
            settings,
        })
    }

    /// The arm in its scene.
    pub fn collider(&self) -> &'c Collider {
        self.certifier.collider()
    }

    /// The straight way between two postures is proven free.
    pub(super) fn free(&mut self, from: &[f64], to: &[f64]) -> bool {
        let found = self.certifier.segment(from, to);
        self.checks += u64::from(found.checks);
        found.is_safe()
    }

    pub(super) fn certifier(&mut self) -> &mut Certifier<'c> {
        &mut self.certifier
    }

    /// No more questions may be asked.
    pub(super) fn is_spent(&self) -> bool {
        self.checks >= self.settings.max_checks || self.is_late()
    }

    /// The time is over.
    pub(super) fn is_late(&self) -> bool {
        self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// A posture drawn evenly, by a key and a lane of its own.
    pub(super) fn sample(&self, stage: u64, round: u32, lane: u32, to: &mut [f64]) {
        let mut state = self.key(stage, u64::from(round) << 8 | u64::from(lane));
        for (x, (lower, upper)) in to.iter_mut().zip(&self.ranges) {
            *x = lower + (upper - lower) * uniform(&mut state);
        }
    }

    /// Where a stream of numbers starts.
    pub(super) fn key(&self, stage: u64, count: u64) -> u64 {
        mix(mix(self.settings.seed.wrapping_add(stage)).wrapping_add(count))
    }
}

/// The next number of SplitMix64, in [0, 1).
pub(super) fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    (mix(*state) >> 11) as f64 / (1_u64 << 53) as f64
}
