//! Differential evolution (Storn and Price 1997): differences of individuals as steps.

use super::boundary::Boundary;
use super::evaluator::{Fitness, Gene, Population};
use super::progress::End;
use super::random::Stream;
use super::run::Run;
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
    /// The number of each lane.
    first: R,
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
    pub(super) fn run<R: Real, F: Fitness<R>>(&self, mut run: Run<'_, '_, R, F>) -> End {
        let dof = run.population.dof;
        let mut trial = Population::<R>::new(run.population.size, dof);
        let rate = R::splat(0.5 * (self.crossover.0 + self.crossover.1));
        let mut scratch = Scratch {
            best: vec![0.0; dof],
            difference: vec![R::zero(); dof],
            base: vec![R::zero(); dof],
            first: numbers(),
            own: vec![(R::splat(self.weight), rate); trial.blocks()],
            tried: vec![(R::splat(self.weight), rate); trial.blocks()],
        };
        loop {
            let best = match run.best() {
                Ok(best) => best,
                Err(end) => return end,
            };
            let Run { genes, evaluator, population, stream, progress, .. } = &mut run;
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
                    _ => match self.redraw {
                        Redraw::Gene => (R::splat(self.weight), R::splat(self.mean_rate())),
                        Redraw::Individual => (R::splat(self.weight), self.draw_rates(stream)),
                        Redraw::Generation => (R::splat(self.weight), shared),
                    },
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

    /// The chance that a gene is taken if the rate is drawn for each: drawn one by one,
    /// genes are independent of each other, so that it acts like a constant rate.
    fn mean_rate(&self) -> f64 {
        let (low, high) = self.crossover;
        if high <= 1.0 || low >= 1.0 {
            return (0.5 * (low + high)).min(1.0);
        }
        (0.5 * (1.0 - low * low) + (high - 1.0)) / (high - low)
    }

    fn draw_rate(&self, stream: &mut Stream) -> f64 {
        self.crossover.0 + (self.crossover.1 - self.crossover.0) * stream.uniform()
    }

    #[inline(always)]
    fn draw_rates<R: Real>(&self, stream: &mut Stream) -> R {
        let (low, high) = self.crossover;
        let u: R = stream.choices();
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
        let size = population.size;
        // Whole numbers, held as floating-point ones so that all lanes are worked out at
        // once: two others, different from each other and from the individual.
        let i = scratch.first + R::splat((block * R::WIDTH) as f64);
        let a = skip(below(size - 1, stream), i);
        let b = skip(skip(below(size - 2, stream), a.min(i)), a.max(i));
        let (from_a, from_b) = (places(population, a), places(population, b));
        // Loops of a length known beforehand, for the commonest arms.
        match population.dof {
            6 => differences::<R, 6>(population, from_a, from_b, &mut scratch.difference),
            7 => differences::<R, 7>(population, from_a, from_b, &mut scratch.difference),
            _ => {
                for lane in 0..R::WIDTH {
                    let (a, lane_a) = individual(population, from_a, lane);
                    let (b, lane_b) = individual(population, from_b, lane);
                    for ((d, x), y) in scratch.difference.iter_mut().zip(a).zip(b) {
                        d.set_lane(lane, x.lane(lane_a) - y.lane(lane_b));
                    }
                }
            }
        }
        if self.mutation == Mutation::Rand1 {
            // The number left out last is the largest of three: sort them.
            let (low, high) = (a.min(i), a.max(i));
            let (low, middle) = (low.min(b), low.max(b));
            let (middle, high) = (middle.min(high), middle.max(high));
            let c = skip(skip(skip(below(size - 3, stream), low), middle), high);
            let from_c = places(population, c);
            for lane in 0..R::WIDTH {
                let (c, lane_c) = individual(population, from_c, lane);
                for (base, x) in scratch.base.iter_mut().zip(c) {
                    base.set_lane(lane, x.lane(lane_c));
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
        // One gene of each individual comes from the mutant in any case: how many genes are
        // left until it, which is 0 there and at least 1 in magnitude elsewhere.
        let mut until_forced: R = below(parents.len(), stream);
        let genes = genes.iter().zip(parents).zip(&scratch.difference).zip(made).enumerate();
        for (g, (((gene, &x), &d), made)) in genes {
            let mutant = match self.mutation {
                Mutation::Best1 => weight.mul_add(d, R::splat(scratch.best[g])),
                Mutation::Rand1 => weight.mul_add(d, scratch.base[g]),
                Mutation::CurrentToBest1 => weight.mul_add(R::splat(scratch.best[g]) - x + d, x),
            };
            let u: R = stream.choices();
            let taken = u.min(until_forced.abs()).le(rate);
            until_forced -= R::splat(1.0);
            *made = self.boundary.apply(R::select(taken, mutant, x), gene, stream);
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

/// 0, 1, 2, ... in the lanes.
#[inline(always)]
fn numbers<R: Real>() -> R {
    let mut numbers = R::zero();
    for lane in 0..R::WIDTH {
        numbers.set_lane(lane, lane as f64);
    }
    numbers
}

/// The largest whole number that is not above a number of magnitude below 2^51.
#[inline(always)]
fn floor<R: Real>(x: R) -> R {
    let near = x.round();
    near - R::select(x.lt(near), R::splat(1.0), R::zero())
}

/// A random whole number below `n` in each lane.
#[inline(always)]
fn below<R: Real>(n: usize, stream: &mut Stream) -> R {
    let u: R = stream.choices();
    // Half a number lower, the nearest whole number is the largest that is not above. Where
    // the product is whole, which is rare, it may be off by one; it stays in the range.
    u.mul_add(R::splat(n as f64), R::splat(-0.5)).round().abs().min(R::splat(n as f64 - 1.0))
}

/// Numbers that leave `taken` out.
#[inline(always)]
fn skip<R: Real>(x: R, taken: R) -> R {
    x + R::select(taken.le(x), R::splat(1.0), R::zero())
}

/// Where the individuals whose numbers stand in the lanes have their first genes: lane
/// within a vector, plus the vectors before it times the lanes of one.
#[inline(always)]
fn places<R: Real>(population: &Population<R>, individuals: R) -> R {
    let width = R::splat(R::WIDTH as f64);
    let block = floor(individuals * R::splat(1.0 / R::WIDTH as f64));
    let lane = individuals - block * width;
    // Above 2^52 the bits of a whole number stand in the fraction.
    block.mul_add(R::splat((population.dof * R::WIDTH) as f64), lane)
        + R::splat((1u64 << 52) as f64)
}

/// Differences of the individuals at two places, gene by gene, for arms of `N` joints.
#[inline(always)]
fn differences<R: Real, const N: usize>(
    population: &Population<R>,
    from_a: R,
    from_b: R,
    difference: &mut [R],
) {
    let Some(difference) = difference.first_chunk_mut::<N>() else { return };
    for lane in 0..R::WIDTH {
        let (a, lane_a) = individual(population, from_a, lane);
        let (b, lane_b) = individual(population, from_b, lane);
        if let (Some(a), Some(b)) = (a.first_chunk::<N>(), b.first_chunk::<N>()) {
            for g in 0..N {
                difference[g].set_lane(lane, a[g].lane(lane_a) - b[g].lane(lane_b));
            }
        }
    }
}

/// Genes and lane of the individual whose place stands in a lane.
#[inline(always)]
fn individual<R: Real>(population: &Population<R>, places: R, lane: usize) -> (&[R], usize) {
    let place = places.lane(lane).to_bits() as u32 as usize;
    let first = place / R::WIDTH;
    (&population.genes[first..first + population.dof], place % R::WIDTH)
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
        // Rates above 1 count as 1: the mean that acts is 5/6 * 0.6875 + 1/6.
        let acting = rates.iter().map(|r| r.min(1.0)).sum::<f64>() / 20_000.0;
        assert!((acting - 0.739_583).abs() < 0.005, "{acting}");
        assert!((it.mean_rate() - 0.739_583).abs() < 1e-6);
        let constant = Differential { crossover: (0.75, 0.75), ..it };
        assert_eq!(constant.mean_rate(), 0.75);
        assert_eq!(Differential { crossover: (1.0, 1.2), ..it }.mean_rate(), 1.0);
    }

    #[test]
    fn partners_are_distinct_and_even() {
        let (size, i) = (6, 2usize);
        let mut stream = Stream::new(0);
        let mut counts = [[0u32; 6]; 6];
        for _ in 0..20_000 {
            let a: f64 = skip(below(size - 1, &mut stream), i as f64);
            let (low, high) = (a.min(i as f64), a.max(i as f64));
            let b = skip(skip(below(size - 2, &mut stream), low), high);
            counts[a as usize][b as usize] += 1;
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
