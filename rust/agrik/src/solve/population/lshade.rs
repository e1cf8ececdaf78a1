//! L-SHADE (Tanabe and Fukunaga 2014): weights and rates drawn about a memory of those that
//! brought success, an archive of replaced individuals, a population that shrinks.

use super::differential::Differential;
use super::evaluator::{Fitness, Gene, Population, Range};
use super::progress::End;
use super::run::Run;
use crate::lanes::Real;
use crate::random::Stream;

/// Entries of the memory of successful weights and rates.
const MEMORY: usize = 6;
/// Share of the population among which a mutant's goal is drawn.
const TOP: f64 = 0.11;
/// Archive, relative to the population.
const ARCHIVE: f64 = 2.6;
/// The population never shrinks below this.
const LEAST: usize = 4;

/// Successful weights and rates, as running means.
struct Memory {
    entries: [(f64, f64); MEMORY],
    next: usize,
}

impl Memory {
    fn draw(&self, stream: &mut Stream) -> (f64, f64) {
        let (weight, rate) = self.entries[stream.below(MEMORY)];
        let mut drawn = weight + 0.1 * stream.cauchy();
        while drawn <= 0.0 {
            drawn = weight + 0.1 * stream.cauchy();
        }
        let rate = if rate < 0.0 { 0.0 } else { rate + 0.1 * stream.normal() };
        (drawn.min(1.0), rate.clamp(0.0, 1.0))
    }

    /// Weighted Lehmer means of what brought success, each weighted by its gain.
    fn learn(&mut self, successes: &[(f64, f64, f64)]) {
        let gain: f64 = successes.iter().map(|s| s.2).sum();
        // Infinite costs that became finite say nothing about how much was gained.
        if !(gain > 0.0 && gain.is_finite()) {
            return;
        }
        let mean = |pick: fn(&(f64, f64, f64)) -> f64| {
            let of = |power: i32| -> f64 {
                successes.iter().map(|s| s.2 / gain * pick(s).powi(power)).sum()
            };
            let below = of(1);
            if below > 0.0 { of(2) / below } else { 0.0 }
        };
        let weight = mean(|s| s.0);
        // A rate that has died out stays so.
        let rate = if self.entries[self.next].1 < 0.0 || successes.iter().all(|s| s.1 == 0.0) {
            -1.0
        } else {
            mean(|s| s.1)
        };
        self.entries[self.next] = (weight, rate);
        self.next = (self.next + 1) % MEMORY;
    }
}

/// Trials between two questions whether to go on.
const TRIALS_PER_POLL: usize = 1 << 16;

/// A run of so many evaluations: a population that shrinks has more generations.
#[inline(always)]
pub(super) fn run<R: Real, F: Fitness<R>>(
    settings: &Differential,
    budget: u64,
    mut run: Run<'_, '_, R, F>,
) -> End {
    let (first, dof) = (run.population.size, run.population.dof);
    let rate = 0.5 * (settings.crossover.0 + settings.crossover.1).min(2.0);
    let mut memory =
        Memory { entries: [(settings.weight.min(1.0), rate.min(1.0)); MEMORY], next: 0 };
    let mut archive: Vec<f64> = Vec::new();
    let mut order = Vec::new();
    let mut trial = Population::<R>::new(first, dof);
    let mut tried = Vec::new();
    let mut successes = Vec::new();
    let (mut x, mut goal, mut a, mut b) =
        (vec![0.0; dof], vec![0.0; dof], vec![0.0; dof], vec![0.0; dof]);
    let ranges: Vec<Range<f64>> = run.genes.iter().map(Gene::range).collect();
    let mut evaluations = first as u64;
    loop {
        if let Err(end) = run.best() {
            return end;
        }
        if evaluations >= budget {
            return End::Generations;
        }
        let Run { evaluator, population, stream, progress, keep_going, .. } = &mut run;
        let size = population.size;
        let top = ((TOP * size as f64).round() as usize).max(2);
        population.ranked(top, &mut order);
        trial.resize(size);
        tried.clear();
        for i in 0..size {
            if i % TRIALS_PER_POLL == TRIALS_PER_POLL - 1 && !keep_going() {
                return End::Interrupted;
            }
            let (weight, rate) = memory.draw(stream);
            tried.push((weight, rate));
            population.read(i, &mut x);
            population.read(order[stream.below(top)], &mut goal);
            let r1 = skip(stream.below(size - 1), i);
            population.read(r1, &mut a);
            let (low, high) = if r1 < i { (r1, i) } else { (i, r1) };
            let r2 = stream.below(size - 2 + archive.len() / dof);
            if r2 < size - 2 {
                population.read(skip(skip(r2, low), high), &mut b);
            } else {
                let from = (r2 - (size - 2)) * dof;
                b.copy_from_slice(&archive[from..from + dof]);
            }
            let forced = stream.below(dof);
            let others = goal.iter().zip(&a).zip(&b);
            for (g, ((x, range), ((goal, a), b))) in
                x.iter_mut().zip(&ranges).zip(others).enumerate()
            {
                if g == forced || stream.uniform() < rate {
                    let mutant = *x + weight * (goal - *x) + weight * (a - b);
                    *x = settings.boundary.apply(mutant, range, stream);
                }
            }
            trial.write(i, &x);
        }
        evaluator.evaluate(&mut trial);
        evaluations += size as u64;
        successes.clear();
        for (i, &(weight, rate)) in tried.iter().enumerate() {
            let (old, new) = (population.cost_of(i), trial.cost_of(i));
            if new < old {
                successes.push((weight, rate, old - new));
                population.read(i, &mut x);
                archive.extend_from_slice(&x);
                trial.read(i, &mut x);
                population.write(i, &x);
                population.set_cost(i, new);
            }
        }
        memory.learn(&successes);
        progress.generations += 1;
        let share = (evaluations as f64 / budget as f64).min(1.0);
        let wanted = first as f64 + (LEAST as f64 - first as f64) * share;
        shrink(population, (wanted.round() as usize).max(LEAST), &mut order);
        let room = ((ARCHIVE * population.size as f64) as usize).max(1);
        while archive.len() / dof > room {
            let gone = stream.below(archive.len() / dof);
            let last = archive.len() - dof;
            archive.copy_within(last.., gone * dof);
            archive.truncate(last);
        }
    }
}

/// Drops the worst individuals.
fn shrink<R: Real>(population: &mut Population<R>, size: usize, order: &mut Vec<usize>) {
    if size >= population.size {
        return;
    }
    population.ranked(size, order);
    order.sort_unstable();
    let mut q = vec![0.0; population.dof];
    for (to, &from) in order.iter().enumerate() {
        if to == from {
            continue;
        }
        population.read(from, &mut q);
        let cost = population.cost_of(from);
        population.write(to, &q);
        population.set_cost(to, cost);
    }
    population.resize(size);
}

/// A number that leaves `taken` out.
fn skip(x: usize, taken: usize) -> usize {
    x + usize::from(x >= taken)
}
