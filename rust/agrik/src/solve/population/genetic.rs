//! A real-coded genetic algorithm: tournaments, simulated binary crossover (Deb and
//! Agrawal 1995), Gaussian mutation, elites.

use super::boundary::Boundary;
use super::evaluator::{Fitness, Population};
use super::progress::End;
use super::run::Run;
use crate::lanes::Real;
use crate::random::Stream;
use crate::{Allowed, Field};

/// How a generation is bred.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Genetic {
    /// Individuals that compete to become a parent.
    pub tournament: u32,
    /// Share of pairs that are crossed.
    pub crossover_rate: f64,
    /// Distribution index of the crossover: the larger, the nearer children are to parents.
    pub crossover_index: f64,
    /// Chance of a gene to mutate.
    pub mutation_rate: f64,
    /// Standard deviation of a mutation, relative to the gene's range.
    pub mutation_width: f64,
    /// Share of that width which is left at the last generation; it shrinks by the same factor
    /// from each to the next.
    pub mutation_end: f64,
    /// Best individuals that live on as they are.
    pub elites: u32,
    /// What becomes of genes out of range.
    pub boundary: Boundary,
}

/// Individuals drawn between two questions whether to go on: a generation of large
/// tournaments in a large population takes hours.
const DRAWS_PER_POLL: usize = 1 << 16;

impl Genetic {
    /// The numbers that users choose, for a population of a size.
    pub fn fields(&mut self, population: u32) -> Vec<Field<'_>> {
        let below = Allowed::whole(0, population.saturating_sub(1));
        let not_negative = Allowed::NOT_NEGATIVE;
        vec![
            Field::count("tournament", &mut self.tournament, Allowed::whole(1, population)),
            Field::real("crossover_rate", &mut self.crossover_rate, Allowed::SHARE),
            Field::real("crossover_index", &mut self.crossover_index, not_negative),
            Field::real("mutation_rate", &mut self.mutation_rate, Allowed::SHARE),
            Field::real("mutation_width", &mut self.mutation_width, not_negative),
            Field::count("elites", &mut self.elites, below),
        ]
    }

    #[inline(always)]
    pub(super) fn run<R: Real, F: Fitness<R>>(&self, mut run: Run<'_, '_, R, F>) -> End {
        let mut children = Population::<R>::new(run.population.size, run.population.dof);
        let mut order = Vec::new();
        loop {
            if let Err(end) = run.best() {
                return end;
            }
            let width = self.mutation_width * self.mutation_end.powf(run.progress.share());
            if !self.breed(&mut run, width, &mut children, &mut order) {
                return End::Interrupted;
            }
            run.evaluator.evaluate(&mut children);
            std::mem::swap(run.population, &mut children);
            run.progress.generations += 1;
        }
    }

    /// Makes the next generation; false where the caller wants to stop.
    fn breed<R: Real, F>(
        &self,
        run: &mut Run<'_, '_, R, F>,
        width: f64,
        children: &mut Population<R>,
        order: &mut Vec<usize>,
    ) -> bool {
        let Run { genes, population, stream, keep_going, .. } = run;
        let dof = population.dof;
        let mut drawn = 0;
        let (mut a, mut b) = (vec![0.0; dof], vec![0.0; dof]);
        let mut made = self.elites as usize;
        population.ranked(made, order);
        for (i, &elite) in order.iter().enumerate() {
            population.read(elite, &mut a);
            children.write(i, &a);
        }
        while made < population.size {
            drawn += 2 * self.tournament as usize;
            if drawn >= DRAWS_PER_POLL {
                drawn = 0;
                if !keep_going() {
                    return false;
                }
            }
            population.read(self.parent(population, stream), &mut a);
            population.read(self.parent(population, stream), &mut b);
            if stream.uniform() < self.crossover_rate {
                self.cross(&mut a, &mut b, stream);
            }
            for child in [&mut a, &mut b] {
                if made == population.size {
                    break;
                }
                for (x, gene) in child.iter_mut().zip(*genes) {
                    if stream.uniform() < self.mutation_rate {
                        *x += width * (gene.upper - gene.lower) * stream.normal();
                    }
                    *x = self.boundary.apply(*x, &gene.range(), stream);
                }
                children.write(made, child);
                made += 1;
            }
        }
        true
    }

    /// The best of a few drawn individuals.
    fn parent<R: Real>(&self, population: &Population<R>, stream: &mut Stream) -> usize {
        let mut best = stream.below(population.size);
        for _ in 1..self.tournament {
            let other = stream.below(population.size);
            if population.cost_of(other) < population.cost_of(best) {
                best = other;
            }
        }
        best
    }

    /// Simulated binary crossover: children spread about their parents as the children of
    /// two bit strings would.
    fn cross(&self, a: &mut [f64], b: &mut [f64], stream: &mut Stream) {
        for (x, y) in a.iter_mut().zip(b) {
            let (swap, u) = (stream.uniform(), stream.uniform());
            let power = 1.0 / (self.crossover_index + 1.0);
            let spread =
                if u <= 0.5 { (2.0 * u).powf(power) } else { (0.5 / (1.0 - u)).powf(power) };
            if swap < 0.5 {
                let (middle, half) = (0.5 * (*x + *y), 0.5 * spread * (*y - *x));
                (*x, *y) = (middle - half, middle + half);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crossed_genes_keep_their_mean() {
        let crate::solve::population::Algorithm::Genetic(it) =
            crate::solve::population::Settings::GENETIC.algorithm
        else {
            panic!("the genetic algorithm")
        };
        let mut stream = Stream::new(4);
        let mut changed = 0;
        for _ in 0..1000 {
            let (mut a, mut b) = (vec![1.0], vec![3.0]);
            it.cross(&mut a, &mut b, &mut stream);
            assert!((a[0] + b[0] - 4.0).abs() < 1e-12);
            changed += u32::from(a[0] != 1.0);
        }
        assert!((400..600).contains(&changed));
    }
}
