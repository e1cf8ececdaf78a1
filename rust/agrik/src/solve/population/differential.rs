//! Differential evolution (Storn and Price 1997): differences of individuals as steps.

use super::boundary::Boundary;
use super::evaluator::{Evaluator, Fitness, Gene, Population};
use super::progress::{End, Progress};
use super::random::Stream;
use crate::error::{Error, Result};
use crate::lanes::Real;

/// What a mutant starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mutation {
    /// `best + F (a - b)`.
    #[default]
    Best1,
    /// `c + F (a - b)`.
    Rand1,
    /// `x + F (best - x) + F (a - b)`.
    CurrentToBest1,
}

/// Where the weight and the crossover rate come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Adaptation {
    /// From the settings.
    #[default]
    None,
    /// Each individual carries its own, redrawn now and then and kept if they bring
    /// success (jDE, Brest et al. 2006).
    Jde,
    /// Drawn about a memory of successful ones; the population shrinks, and mutants are
    /// made by current-to-pbest/1 with an archive (L-SHADE, Tanabe and Fukunaga 2014).
    LShade,
}

/// How often the crossover rate is drawn anew.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Redraw {
    /// For every gene.
    Gene,
    /// For every individual.
    #[default]
    Individual,
    /// For every generation.
    Generation,
}

/// Differential evolution with binomial crossover.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Differential {
    /// What a mutant starts from; L-SHADE has its own rule.
    pub mutation: Mutation,
    /// Where weight and crossover rate come from.
    pub adaptation: Adaptation,
    /// Weight F of the differences.
    pub weight: f64,
    /// Range that the crossover rate is drawn from, evenly; a rate above 1 counts as 1.
    pub crossover: (f64, f64),
    /// How often the crossover rate is drawn anew.
    pub redraw: Redraw,
    /// What becomes of genes out of range.
    pub boundary: Boundary,
}

/// jDE: chance of a new weight or rate, and the range of new weights.
const JDE_CHANCE: f64 = 0.1;
const JDE_WEIGHT: (f64, f64) = (0.1, 0.9);

/// Buffers of the making of trials.
struct Scratch<R> {
    best: Vec<f64>,
    difference: Vec<R>,
    base: Vec<R>,
    /// Weight and crossover rate of each individual, and of the trials (jDE).
    own: Vec<(R, R)>,
    tried: Vec<(R, R)>,
}

impl Differential {
    /// Refuses numbers outside their ranges.
    pub fn check(&self) -> Result<()> {
        if !(self.weight > 0.0 && self.weight <= 2.0) {
            return Err(Error::argument("weight", "a number above 0, at most 2", self.weight));
        }
        let (low, high) = self.crossover;
        if !(low >= 0.0 && low <= high && high <= 2.0) {
            let got = format!("({low}, {high})");
            return Err(Error::argument("crossover", "0 <= lowest <= highest <= 2", got));
        }
        Ok(())
    }

    #[inline(always)]
    pub(super) fn run<R: Real, F: Fitness<R>>(
        &self,
        genes: &[Gene],
        evaluator: &mut Evaluator<'_, R, F>,
        population: &mut Population<R>,
        stream: &mut Stream,
        progress: &mut Progress,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> End {
        let dof = population.dof;
        let mut trial = Population::<R>::new(population.size, dof);
        let rate = R::splat(0.5 * (self.crossover.0 + self.crossover.1));
        let mut scratch = Scratch {
            best: vec![0.0; dof],
            difference: vec![R::zero(); dof],
            base: vec![R::zero(); dof],
            own: vec![(R::splat(self.weight), rate); population.blocks()],
            tried: vec![(R::splat(self.weight), rate); population.blocks()],
        };
        loop {
            let best = population.best();
            if let Some(end) = progress.note(population.cost_of(best)) {
                return end;
            }
            if !keep_going() {
                return End::Interrupted;
            }
            population.read(best, &mut scratch.best);
            let shared = R::splat(self.draw_rate(stream));
            for block in 0..population.blocks() {
                self.pick(block, population, stream, &mut scratch);
                let (weight, rate) = match self.adaptation {
                    Adaptation::Jde => {
                        let (weight, rate) = jde(scratch.own[block], stream);
                        scratch.tried[block] = (weight, rate);
                        (weight, rate)
                    }
                    _ if self.redraw == Redraw::Individual => {
                        (R::splat(self.weight), self.draw_rates(stream))
                    }
                    _ => (R::splat(self.weight), shared),
                };
                let parents = population.block(block);
                let made = trial.block_mut(block);
                self.cross(weight, rate, parents, &scratch, genes, stream, made);
            }
            evaluator.evaluate(&mut trial);
            self.select(population, &trial, &mut scratch);
            progress.generations += 1;
        }
    }

    fn draw_rate(&self, stream: &mut Stream) -> f64 {
        self.crossover.0 + (self.crossover.1 - self.crossover.0) * stream.uniform()
    }

    #[inline(always)]
    fn draw_rates<R: Real>(&self, stream: &mut Stream) -> R {
        let (low, high) = self.crossover;
        let u: R = stream.uniforms();
        u.mul_add(R::splat(high - low), R::splat(low))
    }

    /// Draws the other individuals of a block's mutants: their difference, and the base.
    #[inline(always)]
    fn pick<R: Real>(
        &self,
        block: usize,
        population: &Population<R>,
        stream: &mut Stream,
        scratch: &mut Scratch<R>,
    ) {
        let (size, dof) = (population.size, population.dof);
        for lane in 0..R::WIDTH {
            let i = block * R::WIDTH + lane;
            let a = skip(stream.below(size - 1), i);
            let (low, high) = if a < i { (a, i) } else { (i, a) };
            let b = skip(skip(stream.below(size - 2), low), high);
            let (from_a, lane_a) = population.place(a);
            let (from_b, lane_b) = population.place(b);
            let a = &population.genes[from_a..from_a + dof];
            let b = &population.genes[from_b..from_b + dof];
            for ((d, a), b) in scratch.difference.iter_mut().zip(a).zip(b) {
                d.set_lane(lane, a.lane(lane_a) - b.lane(lane_b));
            }
            if self.mutation == Mutation::Rand1 {
                // Drawn until it is another one: three are taken at most.
                let (a, b) = (from_a / dof * R::WIDTH + lane_a, from_b / dof * R::WIDTH + lane_b);
                let mut c = stream.below(size);
                while c == a || c == b || c == i {
                    c = stream.below(size);
                }
                let (from_c, lane_c) = population.place(c);
                for (x, c) in scratch.base.iter_mut().zip(&population.genes[from_c..from_c + dof]) {
                    x.set_lane(lane, c.lane(lane_c));
                }
            }
        }
    }

    /// Mutants of a block, crossed with their parents and brought back into range.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    fn cross<R: Real>(
        &self,
        weight: R,
        rate: R,
        parents: &[R],
        scratch: &Scratch<R>,
        genes: &[Gene],
        stream: &mut Stream,
        made: &mut [R],
    ) {
        let by_gene = self.redraw == Redraw::Gene && self.adaptation == Adaptation::None;
        // One gene of each individual comes from the mutant in any case.
        let u: R = stream.uniforms();
        let dof = parents.len() as f64;
        let forced = u.mul_add(R::splat(dof), R::splat(-0.5)).round().min(R::splat(dof - 1.0));
        for (g, gene) in genes.iter().enumerate() {
            let (x, d) = (parents[g], scratch.difference[g]);
            let mutant = match self.mutation {
                Mutation::Best1 => weight.mul_add(d, R::splat(scratch.best[g])),
                Mutation::Rand1 => weight.mul_add(d, scratch.base[g]),
                Mutation::CurrentToBest1 => weight.mul_add(R::splat(scratch.best[g]) - x + d, x),
            };
            let rate = if by_gene { self.draw_rates(stream) } else { rate };
            let u: R = stream.uniforms();
            let is_forced = (forced - R::splat(g as f64)).abs().lt(R::splat(0.5));
            let taken = R::or(u.lt(rate), is_forced);
            let x = R::select(taken, mutant, x);
            made[g] = self.boundary.apply(x, gene, stream);
        }
    }

    /// Trials that are better take their parents' places.
    #[inline(always)]
    fn select<R: Real>(
        &self,
        population: &mut Population<R>,
        trial: &Population<R>,
        scratch: &mut Scratch<R>,
    ) {
        let dof = population.dof;
        for block in 0..population.blocks() {
            let better = trial.cost[block].lt(population.cost[block]);
            if R::bits(better) == 0 {
                continue;
            }
            population.cost[block] = R::select(better, trial.cost[block], population.cost[block]);
            let from = &trial.genes[block * dof..(block + 1) * dof];
            for (x, t) in population.block_mut(block).iter_mut().zip(from) {
                *x = R::select(better, *t, *x);
            }
            if self.adaptation == Adaptation::Jde {
                let (own, tried) = (&mut scratch.own[block], scratch.tried[block]);
                own.0 = R::select(better, tried.0, own.0);
                own.1 = R::select(better, tried.1, own.1);
            }
        }
    }
}

/// Weights and rates of a block's trials by jDE.
#[inline(always)]
fn jde<R: Real>(own: (R, R), stream: &mut Stream) -> (R, R) {
    let chance = R::splat(JDE_CHANCE);
    let [renew_weight, weight, renew_rate, rate]: [R; 4] =
        [stream.uniforms(), stream.uniforms(), stream.uniforms(), stream.uniforms()];
    let weight = weight.mul_add(R::splat(JDE_WEIGHT.1), R::splat(JDE_WEIGHT.0));
    (
        R::select(renew_weight.lt(chance), weight, own.0),
        R::select(renew_rate.lt(chance), rate, own.1),
    )
}

/// A number that leaves `taken` out.
#[inline(always)]
pub(super) fn skip(x: usize, taken: usize) -> usize {
    x + usize::from(x >= taken)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_of_the_published_recipe_lie_in_their_range() {
        let settings = super::super::Settings::PUBLISHED;
        let super::super::Algorithm::Differential(it) = settings.algorithm else {
            panic!("differential evolution")
        };
        let mut stream = Stream::new(5);
        let rates: Vec<f64> = (0..20_000).map(|_| it.draw_rate(&mut stream)).collect();
        assert!(rates.iter().all(|r| (0.375..1.125).contains(r)));
        let least = rates.iter().copied().fold(f64::INFINITY, f64::min);
        let most = rates.iter().copied().fold(0.0, f64::max);
        assert!(least < 0.376 && most > 1.124);
        // Rates above 1 count as 1: the mean that acts is 0.736.
        let acting = rates.iter().map(|r| r.min(1.0)).sum::<f64>() / 20_000.0;
        assert!((acting - 0.736).abs() < 0.005, "{acting}");
    }

    #[test]
    fn partners_are_distinct_and_even() {
        let (size, i) = (6, 2);
        let mut stream = Stream::new(0);
        let mut counts = [[0u32; 6]; 6];
        for _ in 0..20_000 {
            let a = skip(stream.below(size - 1), i);
            let (low, high) = if a < i { (a, i) } else { (i, a) };
            let b = skip(skip(stream.below(size - 2), low), high);
            counts[a][b] += 1;
        }
        for (a, row) in counts.iter().enumerate() {
            for (b, &count) in row.iter().enumerate() {
                if a == b || a == i || b == i {
                    assert_eq!(count, 0);
                } else {
                    assert!((800..1200).contains(&count), "{a} {b} {count}");
                }
            }
        }
    }
}
