//! Population solvers: many postures at once, better ones made out of good ones.
//!
//! All share one evaluator ([`Evaluator`]: forward kinematics and fitness, one individual
//! per lane) and one search around it (seeds, restarts, polish, record of answers). They
//! differ in how the next generation is made: [`Differential`] evolution with its
//! variants, L-SHADE, and a real-coded [`Genetic`] algorithm. The fitness is a trait, so
//! that other searches over postures use the same machinery ([`minimise`]).

mod boundary;
mod differential;
mod evaluator;
mod fitness;
mod genetic;
mod lshade;
mod progress;
mod rows;
mod run;
mod search;
mod settings;

pub use boundary::Boundary;
pub use differential::{Adaptation, Differential, Mutation, Redraw};
pub use evaluator::{Evaluator, Fitness, Gene, Population, Range};
pub use fitness::Orientation;
pub use genetic::Genetic;
pub use progress::{End, Progress};
pub use search::Evolution;
pub use settings::{Algorithm, Settings};

use crate::chain::Compiled;
use crate::lanes::Real;
use crate::random::Stream;

/// The best posture that an algorithm finds for a fitness, in `best`; returns its cost.
///
/// `start` is one individual of the first population, if given. A cost of infinity means
/// that no individual had a finite one.
#[inline(always)]
pub fn minimise<R: Real, F: Fitness<R>>(
    chain: &Compiled,
    genes: &[Gene],
    fitness: F,
    settings: &Settings,
    start: Option<&[f64]>,
    stream: &mut Stream,
    best: &mut [f64],
) -> f64 {
    let mut evaluator = Evaluator::new(chain, fitness);
    let mut population = Population::<R>::new(settings.population as usize, genes.len());
    let mut progress = settings.progress();
    settings.evolve(
        genes,
        &mut evaluator,
        start,
        &mut population,
        stream,
        &mut progress,
        &mut || true,
    );
    let chosen = population.best();
    population.read(chosen, best);
    population.cost_of(chosen)
}
