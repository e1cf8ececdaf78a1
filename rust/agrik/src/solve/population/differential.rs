//! Differential evolution (Storn and Price 1997): differences of individuals as steps.

use super::boundary::Boundary;
use super::evaluator::{Fitness, Gene, Population, Range};
use super::progress::End;
use super::rows::{Rows, WHOLE};
use super::run::Run;
use crate::error::Result;
use crate::lanes::{Real, Words};
use crate::random::Stream;
use crate::{Allowed, Field};

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
    /// How much above it the weight may be, drawn evenly for each generation.
    pub dither: f64,
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
    /// Genes of the best individual, each in all lanes.
    best: Vec<R>,
    difference: Vec<R>,
    base: Vec<R>,
    rows: Rows<R>,
    /// The number of each lane.
    first: R,
    /// Weight and crossover rate of each individual, and of the trials (jDE).
    own: Vec<(R, R)>,
    tried: Vec<(R, R)>,
}

/// What a gene of a mutant is made of besides its parent's.
struct Parts<'s, R> {
    weight: R,
    best: &'s [R],
    base: &'s [R],
    difference: &'s [R],
}

impl Differential {
    /// The numbers that users choose, one by one.
    pub fn fields(&mut self) -> Vec<Field<'_>> {
        vec![Field::real("weight", &mut self.weight, Allowed::up_to(2.0))]
    }

    /// Refuses a range of crossover rates that is none.
    pub fn check(&self) -> Result<()> {
        let (low, high) = self.crossover;
        Allowed::between(0.0, 2.0).check("crossover", low)?;
        Allowed::between(low, 2.0).check("crossover", high)
    }

    #[inline(always)]
    pub(super) fn run<R: Real, F: Fitness<R>>(&self, mut run: Run<'_, '_, R, F>) -> End {
        let dof = run.population.dof;
        let mut trial = Population::<R>::new(run.population.size, dof);
        let middle = R::splat(0.5 * (self.crossover.0 + self.crossover.1));
        let weight = R::splat(self.weight);
        let rows = Rows::of(run.population);
        let mut scratch = Scratch {
            best: vec![R::zero(); dof],
            difference: rows.buffer(),
            base: rows.buffer(),
            rows,
            first: numbers(),
            own: vec![(weight, middle); trial.blocks()],
            tried: vec![(weight, middle); trial.blocks()],
        };
        let mean = R::splat(self.mean_rate());
        let ranges: Vec<Range<R>> = run.genes.iter().map(Gene::range).collect();
        loop {
            let best = match run.best() {
                Ok(best) => best,
                Err(end) => return end,
            };
            let Run { evaluator, population, stream, progress, .. } = &mut run;
            population.spread(best, &mut scratch.best);
            let weight = if self.dither > 0.0 {
                R::splat(self.weight + self.dither * stream.uniform())
            } else {
                weight
            };
            let shared = match self.redraw {
                Redraw::Gene | Redraw::Individual => mean,
                Redraw::Generation => R::splat(self.draw_rate(stream)),
            };
            for block in 0..population.blocks() {
                let forced = self.pick(block, population, stream, &mut scratch);
                let (weight, rate) = match self.adaptation {
                    Adaptation::Jde => {
                        let (weight, rate) = jde(scratch.own[block], stream);
                        scratch.tried[block] = (weight, rate);
                        (weight, rate)
                    }
                    _ if self.redraw == Redraw::Individual => (weight, self.draw_rates(stream)),
                    _ => (weight, shared),
                };
                let (best, base, difference) =
                    (&scratch.best[..], &scratch.base[..], &scratch.difference[..]);
                let parts = Parts { weight, best, base, difference };
                let chance = (rate, forced);
                let parents = population.block(block);
                let made = trial.block_mut(block);
                // The published rules are known where the loop over the genes is compiled.
                match (self.mutation, self.boundary) {
                    (Mutation::Best1, Boundary::Median) => {
                        let rules = (Mutation::Best1, Boundary::Median);
                        cross(rules, &parts, chance, parents, &ranges, stream, made);
                    }
                    rules => cross(rules, &parts, chance, parents, &ranges, stream, made),
                }
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
        let u: R = stream.uniforms();
        u.mul_add(R::splat(high - low), R::splat(low))
    }

    /// Draws the other individuals of a block's mutants, whose difference and base are
    /// gathered, and the gene of each that comes from the mutant in any case.
    #[inline(always)]
    fn pick<R: Real>(
        &self,
        block: usize,
        population: &Population<R>,
        stream: &mut Stream,
        scratch: &mut Scratch<R>,
    ) -> R::Words {
        let size = population.size;
        // Whole numbers, held as floating-point ones so that all lanes are compared at
        // once: two others, different from each other and from the individual.
        let i = scratch.first + R::splat((block * R::WIDTH) as f64);
        let word: R::Words = stream.words();
        let (a, rest) = below::<R>(size - 1, word);
        let (b, _) = below::<R>(size - 2, word.down::<32>());
        let forced = rest.product(R::Words::splat(population.dof as u64)).down::<32>();
        let a = skip(a, i);
        let (low, high) = (a.min(i), a.max(i));
        let b = skip(skip(b, low), high);
        scratch.rows.difference(a, b, &mut scratch.difference);
        if self.mutation == Mutation::Rand1 {
            // The number left out last is the largest of three: sort them.
            let (low, middle) = (low.min(b), low.max(b));
            let (middle, high) = (middle.min(high), middle.max(high));
            let (c, _) = below::<R>(size - 3, stream.words());
            let c = skip(skip(skip(c, low), middle), high);
            scratch.rows.gather(c, &mut scratch.base);
        }
        forced
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
            scratch.rows.update(block, population.block(block));
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

/// Mutants of a block, crossed with their parents and brought back into range; `chance` is
/// the rate and the number of the gene that is taken in any case.
#[inline(always)]
fn cross<R: Real>(
    rules: (Mutation, Boundary),
    parts: &Parts<'_, R>,
    chance: (R, R::Words),
    parents: &[R],
    ranges: &[Range<R>],
    stream: &mut Stream,
    made: &mut [R],
) {
    // Loops of a length known beforehand, for the commonest arms.
    match (parents.first_chunk::<7>(), parents.first_chunk::<6>()) {
        (Some(all), _) if parents.len() == 7 => {
            cross_all(rules, parts, chance, all, ranges, stream, made);
        }
        (_, Some(all)) if parents.len() == 6 => {
            cross_all(rules, parts, chance, all, ranges, stream, made);
        }
        _ => cross_all(rules, parts, chance, parents, ranges, stream, made),
    }
}

/// [`cross`] as it is written for any number of genes.
#[inline(always)]
fn cross_all<R: Real>(
    (mutation, boundary): (Mutation, Boundary),
    parts: &Parts<'_, R>,
    (rate, forced): (R, R::Words),
    parents: &[R],
    ranges: &[Range<R>],
    stream: &mut Stream,
    made: &mut [R],
) {
    let dof = parents.len();
    let (made, ranges) = (&mut made[..dof], &ranges[..dof]);
    let (best, difference) = (&parts.best[..dof], &parts.difference[..dof]);
    let threshold = threshold(rate);
    let forced = forced.in_all_fields();
    // A word decides on four genes, by 16 bits each.
    let mut numbers = R::Words::splat(0x0003_0002_0001_0000);
    for first in (0..dof).step_by(4) {
        let drawn: R::Words = stream.words();
        // The greatest number counts as the one before it: a rate of one takes them all.
        let drawn = drawn.smaller_fields(R::Words::splat(0x7ffe_7ffe_7ffe_7ffe));
        let taken = drawn.fields_below(threshold).or(forced.equal_fields(numbers));
        numbers = numbers.plus(R::Words::splat(0x0004_0004_0004_0004));
        let taken = [taken.up::<48>(), taken.up::<32>(), taken.up::<16>(), taken];
        for (g, taken) in (first..dof).zip(taken) {
            let (x, d) = (parents[g], difference[g]);
            let mutant = match mutation {
                Mutation::Best1 => parts.weight.mul_add(d, best[g]),
                Mutation::Rand1 => parts.weight.mul_add(d, parts.base[g]),
                Mutation::CurrentToBest1 => parts.weight.mul_add(best[g] - x + d, x),
            };
            let x = R::select(R::highest_bits(taken), mutant, x);
            made[g] = boundary.apply(x, &ranges[g], stream);
        }
    }
}

/// What 16 random bits, read as a number with a sign, must lie below for a gene to be
/// taken, in each field of a word.
#[inline(always)]
fn threshold<R: Real>(rate: R) -> R::Words {
    let scaled = (rate * R::splat(65_536.0)).min(R::splat(65_535.0));
    let whole = (scaled + R::splat(WHOLE)).to_words();
    whole.in_all_fields().xor(R::Words::splat(0x8000_8000_8000_8000))
}

/// A random whole number below `n` in each lane, made of the low half of a random word, and
/// a word whose low half is random whichever number that is (as long as `n` is small beside
/// 2^32).
#[inline(always)]
fn below<R: Real>(n: usize, word: R::Words) -> (R, R::Words) {
    let product = word.product(R::Words::splat(n as u64));
    let whole = product.down::<32>().or(R::Words::splat(WHOLE.to_bits()));
    (R::from_words(whole) - R::splat(WHOLE), product)
}

/// Numbers that leave `taken` out.
#[inline(always)]
fn skip<R: Real>(x: R, taken: R) -> R {
    x + R::select(taken.le(x), R::splat(1.0), R::zero())
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
        let mut genes = [[0u32; 7]; 6];
        for _ in 0..20_000 {
            let word: u64 = stream.words();
            let (a, rest) = below::<f64>(size - 1, word);
            let a = skip(a, i as f64);
            let (low, high) = (a.min(i as f64), a.max(i as f64));
            let (b, _) = below::<f64>(size - 2, word >> 32);
            let b = skip(skip(b, low), high);
            counts[a as usize][b as usize] += 1;
            // What the choice of the first leaves chooses the gene that is always taken.
            let (forced, _) = below::<f64>(7, rest);
            genes[a as usize][forced as usize] += 1;
        }
        for (a, row) in genes.iter().enumerate() {
            let expected = if a == i { 0..1 } else { 460..690 };
            assert!(row.iter().all(|count| expected.contains(count)), "{a} {row:?}");
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

    #[test]
    fn genes_are_taken_at_their_rate() {
        let rules = (Mutation::Best1, Boundary::Clamp);
        let mut stream = Stream::new(8);
        for dof in [1, 3, 6, 7, 11] {
            let ranges = vec![Gene { lower: -9.0, upper: 9.0, turns: false }.range(); dof];
            let (parents, best, none) = (vec![0.0; dof], vec![1.0; dof], vec![0.0; dof]);
            let parts = Parts { weight: 0.5, best: &best, base: &none, difference: &none };
            for rate in [0.0, 0.25, 0.739_583, 1.0, 1.1] {
                let mut taken = vec![0u32; dof];
                for trial in 0..8000u64 {
                    let forced = trial % dof as u64;
                    let mut made = vec![-1.0; dof];
                    cross(rules, &parts, (rate, forced), &parents, &ranges, &mut stream, &mut made);
                    assert_eq!(made[forced as usize], 1.0);
                    for (taken, made) in taken.iter_mut().zip(&made) {
                        assert!(*made == 0.0 || *made == 1.0);
                        *taken += u32::from(*made == 1.0);
                    }
                }
                // Five deviations; rates of nothing and of all are exact.
                let forced = 1.0 / dof as f64;
                let chance = forced + (1.0 - forced) * rate.min(1.0);
                let spread = 5.0 * (rate * (1.0 - rate)).max(0.0).sqrt() * 8000f64.sqrt();
                for count in taken {
                    let off = (f64::from(count) - 8000.0 * chance).abs();
                    assert!(off <= spread + 1.0, "{dof} genes, rate {rate}: {count}");
                }
            }
        }
    }
}
