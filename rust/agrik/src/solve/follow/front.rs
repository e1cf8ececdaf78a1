//! Ways round a dead end of a path.
//!
//! An arm with a joint to spare carries one of many postures from target to target, and which one
//! decides whether the path goes on. Where it does not, a front of postures, a few spread over all
//! that steps can lead to, goes the same way from some targets before. Which way the front took to
//! where it got is the new way of the arm.

use super::{CONTINUE, MOST_POSTURES, ONE, Row, STARTS, Walker};
use crate::call::{Outcome, Status};
use crate::random::Stream;
use crate::solve::tracker::{bounds_around, ticks};

/// Targets that the front begins before the dead end, and goes on behind it.
const REACH: [usize; 4] = [16, 64, 256, 4096];
/// Starts around each posture of the front: the posture, corners of the step around it, and
/// points in it.
const CORNERS: usize = 8;
const AROUND: usize = 16;
/// Postures nearer to each other than this share of a step are one.
const APART: f64 = 0.1;
/// Rounds in which a way is straightened, and the share of the way to the middle between its
/// neighbours that a step of them tries to go.
const ROUNDS: usize = 12;
const EASE: f64 = 0.7;

/// A posture of the front, which one of the target before led to it, and the sum of squared steps
/// up to it.
struct Stand {
    q: Vec<f64>,
    from: usize,
    cost: f64,
}

impl Walker<'_> {
    /// Looks for a way round the dead end before target `row`, from the posture taken at a target
    /// before or from any where the first is free. If there is one, rows up to `row`, and some
    /// after it, stand on it.
    pub(super) fn go_round(&mut self, row: usize, outcome: &mut Outcome) -> bool {
        let near = &self.rows[row - 1].q;
        let starts = self.starts(row, near, STARTS);
        if self.attempts(row, &starts, None, near, ONE, outcome).is_empty() {
            return false;
        }
        for reach in REACH {
            let first = row.saturating_sub(reach).max(self.piece);
            let free = first == 0 && self.follow.q0.is_none();
            let begin = if free { self.postures(0, outcome) } else { Vec::new() };
            let begin = if begin.is_empty() { vec![self.rows[first].q.clone()] } else { begin };
            if let Some(mut way) = self.front(first, row, reach, begin, outcome) {
                self.straighten(first, free, &mut way, outcome);
                self.rows.truncate(first);
                let there = |q| {
                    let outcome = Outcome::unanswered(Status::Converged);
                    Row { q, outcome, jump: false }
                };
                let jump = self.rows.len() == self.piece && self.piece > 0;
                self.rows.extend(way.into_iter().map(there));
                self.rows[first].jump = jump;
                let outcome = Outcome { status: Status::Converged, ..*outcome };
                self.rows[row].outcome = outcome;
                return true;
            }
            if first == self.piece || self.stopped {
                break;
            }
        }
        false
    }

    /// The way of a front from target `first` to `row` at least, and `more` targets after it at
    /// most.
    fn front(
        &mut self,
        first: usize,
        row: usize,
        more: usize,
        begin: Vec<Vec<f64>>,
        outcome: &mut Outcome,
    ) -> Option<Vec<Vec<f64>>> {
        let last = (row + more).min(self.follow.plan.request.len() - 1);
        let begin = begin.into_iter().map(|q| Stand { q, from: 0, cost: 0.0 });
        let mut layers: Vec<Vec<Stand>> = vec![begin.collect()];
        for target in first + 1..=last {
            self.stopped = self.stopped || !(self.poll)();
            if self.stopped {
                return None;
            }
            if self.follow.plan.request.goal(target).is_none() {
                break;
            }
            let before = layers.last()?;
            let mut next = Vec::new();
            for (from, stand) in before.iter().enumerate() {
                for q in self.steps(target, from, &stand.q, outcome) {
                    let step = ticks(&stand.q, &q, &self.follow.max_joint_step);
                    next.push(Stand { q, from, cost: stand.cost + step * step });
                }
            }
            if next.is_empty() {
                break;
            }
            layers.push(self.spread(next));
        }
        if first + layers.len() <= row {
            return None;
        }
        let mut at = {
            let costs = layers.last()?.iter().map(|stand| stand.cost).enumerate();
            costs.min_by(|a, b| a.1.total_cmp(&b.1))?.0
        };
        let mut way = Vec::with_capacity(layers.len());
        for layer in layers.iter_mut().rev() {
            let stand = layer.swap_remove(at);
            at = stand.from;
            way.push(stand.q);
        }
        way.reverse();
        Some(way)
    }

    /// Postures for a target no farther than a step from one.
    fn steps(&self, row: usize, from: usize, at: &[f64], outcome: &mut Outcome) -> Vec<Vec<f64>> {
        let plan = &self.follow.plan;
        let bounds = bounds_around(plan.request.chain(), at, &self.follow.max_joint_step);
        let mut stream = Stream::new(plan.sampler.key(row, 2 + from as u32));
        let mut starts = at.to_vec();
        for k in 1..AROUND {
            for (low, high) in &bounds {
                let share = stream.uniform();
                let share = if k <= CORNERS { share.round() } else { share };
                starts.push(low + (high - low) * share);
            }
        }
        let target = plan.request.copies(row, AROUND);
        self.attempts_at(&target, &starts, Some((&bounds, None)), at, CONTINUE, outcome)
    }

    /// Different postures of a target from anywhere.
    fn postures(&self, row: usize, outcome: &mut Outcome) -> Vec<Vec<f64>> {
        let near = &self.rows[row].q;
        let starts = self.starts(row, near, STARTS);
        let found = self.attempts(row, &starts, None, near, ONE, outcome);
        let stands = found.into_iter().map(|q| Stand { q, from: 0, cost: 0.0 });
        self.spread(stands.collect()).into_iter().map(|stand| stand.q).collect()
    }

    /// The cheapest of some postures, and those that are farthest from all that are kept already.
    fn spread(&self, mut open: Vec<Stand>) -> Vec<Stand> {
        let most = &self.follow.max_joint_step;
        let mut away = vec![f64::INFINITY; open.len()];
        let mut kept: Vec<Stand> = Vec::new();
        let costs = open.iter().map(|stand| stand.cost).enumerate();
        let mut next = costs.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i);
        while let Some(i) = next.filter(|_| kept.len() < MOST_POSTURES) {
            away.swap_remove(i);
            let new = open.swap_remove(i);
            for (far, stand) in away.iter_mut().zip(&open) {
                *far = far.min(ticks(&stand.q, &new.q, most));
            }
            kept.push(new);
            let far = away.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
            next = far.filter(|(_, far)| *far > APART).map(|(i, _)| i);
        }
        kept
    }

    /// Draws each posture of a way to the middle between its neighbours, as far as both stay a
    /// step away; the first one stays unless it is free.
    fn straighten(&self, first: usize, free: bool, way: &mut [Vec<f64>], outcome: &mut Outcome) {
        let chain = self.follow.plan.request.chain();
        let most = &self.follow.max_joint_step;
        for _ in 0..ROUNDS {
            for k in usize::from(!free)..way.len() {
                let before = way[k.saturating_sub(1)].clone();
                let after = way[(k + 1).min(way.len() - 1)].clone();
                let (before, after) = match k {
                    0 => (after.clone(), after),
                    _ if k + 1 == way.len() => (before.clone(), before),
                    _ => (before, after),
                };
                let ranges = bounds_around(chain, &before, most).into_iter();
                let ranges = ranges.zip(bounds_around(chain, &after, most));
                let bounds: Vec<_> = ranges.map(|(a, b)| (a.0.max(b.0), a.1.min(b.1))).collect();
                if bounds.iter().any(|(low, high)| low > high) {
                    continue;
                }
                let middle: Vec<_> =
                    before.iter().zip(&after).map(|(a, b)| 0.5 * (a + b)).collect();
                let inside = Some((&bounds[..], Some((EASE, &middle[..]))));
                let target = self.follow.plan.request.copies(first + k, 1);
                let found = self.attempts_at(&target, &way[k], inside, &middle, CONTINUE, outcome);
                if let Some(q) = found.into_iter().next() {
                    way[k] = q;
                }
            }
        }
    }
}
