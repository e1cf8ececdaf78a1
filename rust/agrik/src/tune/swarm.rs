//! Particle swarm with constriction (Clerc and Kennedy 2002), updated one by one.

use super::sequence;
use super::{Judge, Reader};
use crate::error::Result;

/// Constriction, and its share for the pull of either best.
const INERTIA: f64 = 0.7298;
const PULL: f64 = 1.49618;
/// Longest step of a parameter, and farthest it goes from zero.
const FASTEST: f64 = 0.5;
const FARTHEST: f64 = 12.0;

/// A swarm; its first particle starts at the vector given.
#[derive(Debug, Clone)]
pub struct Swarm {
    dimension: usize,
    seed: u64,
    generation: u64,
    evaluations: u64,
    x: Vec<f64>,
    v: Vec<f64>,
    best_x: Vec<f64>,
    best_cost: Vec<f64>,
}

impl Swarm {
    /// `particles` around `start` with deviation `sigma`.
    pub fn new(start: &[f64], particles: usize, sigma: f64, seed: u64) -> Self {
        let mut x = Vec::new();
        let mut v = Vec::new();
        for member in 0..particles {
            let mut stream = sequence(seed, 0, member as u64);
            let spread = if member == 0 { 0.0 } else { sigma };
            for value in start {
                x.push(value + spread * stream.normal());
                v.push(0.1 * sigma * stream.normal());
            }
        }
        Self {
            dimension: start.len(),
            seed,
            generation: 0,
            evaluations: 0,
            best_x: x.clone(),
            x,
            v,
            best_cost: vec![f64::INFINITY; particles],
        }
    }

    fn leader(&self) -> usize {
        let mut leader = 0;
        for (i, cost) in self.best_cost.iter().enumerate() {
            if *cost < self.best_cost[leader] {
                leader = i;
            }
        }
        leader
    }

    /// Judges the start positions the first time, then moves and judges every particle.
    pub fn advance(&mut self, judge: &mut Judge<'_>) -> Result<()> {
        let d = self.dimension;
        // An error in the middle leaves the generation as it was.
        let mut next = self.clone();
        for member in 0..next.best_cost.len() {
            let own = member * d..(member + 1) * d;
            if next.generation > 0 {
                let leader = next.leader() * d;
                let mut stream = sequence(next.seed, next.generation, member as u64);
                for k in own.clone() {
                    let (r1, r2) = (stream.uniform(), stream.uniform());
                    let x = next.x[k];
                    let best = next.best_x[leader + k - own.start];
                    let v = INERTIA * next.v[k]
                        + PULL * r1 * (next.best_x[k] - x)
                        + PULL * r2 * (best - x);
                    next.v[k] = v.clamp(-FASTEST, FASTEST);
                    next.x[k] = (x + next.v[k]).clamp(-FARTHEST, FARTHEST);
                }
            }
            let cost = judge(&next.x[own.clone()], next.best_cost[member])?;
            next.evaluations += 1;
            if cost < next.best_cost[member] {
                next.best_cost[member] = cost;
                let (best, now) = (&mut next.best_x[own.clone()], &next.x[own]);
                best.copy_from_slice(now);
            }
        }
        next.generation += 1;
        *self = next;
        Ok(())
    }

    pub(super) fn best(&self) -> Option<(&[f64], f64)> {
        let (d, i) = (self.dimension, self.leader());
        let cost = self.best_cost.get(i)?;
        cost.is_finite().then(|| (&self.best_x[i * d..(i + 1) * d], *cost))
    }

    pub(super) fn evaluations(&self) -> u64 {
        self.evaluations
    }

    pub(super) fn state(&self) -> Vec<f64> {
        let mut state = vec![self.generation as f64, self.evaluations as f64];
        for part in [&self.x, &self.v, &self.best_x, &self.best_cost] {
            state.extend_from_slice(part);
        }
        state
    }

    pub(super) fn restore(&mut self, state: &[f64]) {
        let mut from = Reader(state);
        self.generation = from.one() as u64;
        self.evaluations = from.one() as u64;
        for part in [&mut self.x, &mut self.v, &mut self.best_x, &mut self.best_cost] {
            from.fill(part);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn valley(x: &[f64]) -> f64 {
        x.iter().enumerate().map(|(k, x)| (1.0 + k as f64) * (x - 0.5) * (x - 0.5)).sum()
    }

    #[test]
    fn the_bottom_of_a_valley_is_found() {
        let mut swarm = Swarm::new(&[0.0; 6], 20, 0.3, 1);
        for _ in 0..150 {
            swarm.advance(&mut |x, _| Ok(valley(x))).expect("no error");
        }
        let (_, cost) = swarm.best().expect("a best");
        assert!(cost < 1e-8, "{cost}");
    }

    #[test]
    fn what_is_not_judged_to_its_end_changes_nothing() {
        let mut swarms = [Swarm::new(&[1.0; 4], 8, 0.3, 7), Swarm::new(&[1.0; 4], 8, 0.3, 7)];
        let mut cut = 0;
        for _ in 0..30 {
            swarms[0].advance(&mut |x, _| Ok(valley(x))).expect("no error");
            let mut hasty = |x: &[f64], bound: f64| {
                cut += u32::from(valley(x) > bound);
                Ok(if valley(x) < bound { valley(x) } else { bound })
            };
            swarms[1].advance(&mut hasty).expect("no error");
        }
        assert_eq!(swarms[0].state(), swarms[1].state());
        assert!(cut > 50, "{cut}");
    }

    #[test]
    fn a_stored_swarm_goes_on_as_if_never_stopped() {
        let mut whole = Swarm::new(&[1.0; 4], 8, 0.3, 7);
        for _ in 0..5 {
            whole.advance(&mut |x, _| Ok(valley(x))).expect("no error");
        }
        let mut resumed = Swarm::new(&[1.0; 4], 8, 0.3, 7);
        resumed.restore(&whole.state());
        for swarm in [&mut whole, &mut resumed] {
            swarm.advance(&mut |x, _| Ok(valley(x))).expect("no error");
        }
        assert_eq!(whole.state(), resumed.state());
    }
}
