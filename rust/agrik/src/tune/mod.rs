//! Tuning: searches over the gains of a feedback law for the set that solves most training
//! goals in the fewest steps.
//!
//! A [`Problem`] gives a vector of parameters a cost, a [`Search`] proposes vectors. A
//! search advances generation by generation, and what it knows between two of them is a
//! list of numbers, so that it can be stored and taken up again.

mod evolution;
mod family;
mod problem;
mod swarm;

pub use evolution::Evolution;
pub use family::{Family, Shape};
pub use problem::{Cost, Problem, Score};
pub use swarm::Swarm;

use crate::error::{Error, Result};
use crate::random::Sequence;

/// Sweeps after which an eigenvalue decomposition is given up: far more than one takes.
const SWEEPS: usize = 100_000;

/// A search, by its method.
#[derive(Debug, Clone)]
pub enum Search {
    /// Particle swarm, global best with constriction.
    Swarm(Swarm),
    /// Evolution strategy with covariance matrix adaptation.
    Evolution(Evolution),
}

/// What becomes of a vector: its cost, or an error that ends the search.
///
/// The second argument is the cost below which the vector has to be to matter. One that is
/// certain to cost as much or more may be given any cost from there on: the search takes
/// the same way, and judging the vector to its end is saved.
pub type Judge<'a> = dyn FnMut(&[f64], f64) -> Result<f64> + 'a;

impl Search {
    /// One generation more.
    pub fn advance(&mut self, judge: &mut Judge<'_>) -> Result<()> {
        match self {
            Self::Swarm(swarm) => swarm.advance(judge),
            Self::Evolution(evolution) => evolution.advance(judge),
        }
    }

    /// The best vector so far and its cost; none before the first generation.
    pub fn best(&self) -> Option<(&[f64], f64)> {
        match self {
            Self::Swarm(swarm) => swarm.best(),
            Self::Evolution(evolution) => evolution.best(),
        }
    }

    /// Vectors judged so far.
    pub fn evaluations(&self) -> u64 {
        match self {
            Self::Swarm(swarm) => swarm.evaluations(),
            Self::Evolution(evolution) => evolution.evaluations(),
        }
    }

    /// Everything that changes while the search runs.
    pub fn state(&self) -> Vec<f64> {
        match self {
            Self::Swarm(swarm) => swarm.state(),
            Self::Evolution(evolution) => evolution.state(),
        }
    }

    /// Takes up a search of the same settings where [`Search::state`] left it.
    pub fn restore(&mut self, state: &[f64]) -> Result<()> {
        let wanted = self.state().len();
        if state.len() != wanted {
            let expected = format!("{wanted} numbers, as a search of these settings has");
            return Err(Error::argument("state", expected, state.len()));
        }
        match self {
            Self::Swarm(swarm) => swarm.restore(state),
            Self::Evolution(evolution) => evolution.restore(state),
        }
        Ok(())
    }
}

/// Hands out the numbers of a stored state in the order they were stored in.
struct Reader<'a>(&'a [f64]);

impl Reader<'_> {
    /// One number; zero past the end, which [`Search::restore`] rules out.
    fn one(&mut self) -> f64 {
        let (first, rest) = self.0.split_first().unwrap_or((&0.0, &[]));
        self.0 = rest;
        *first
    }

    fn fill(&mut self, to: &mut [f64]) {
        for x in to {
            *x = self.one();
        }
    }
}

/// The random numbers of a member in a generation: nothing but the generation's number has
/// to be stored with a search.
fn sequence(seed: u64, generation: u64, member: u64) -> Sequence {
    let key = seed ^ generation.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    Sequence::new(key.rotate_left(23) ^ member.wrapping_mul(0xd1b5_4a32_d192_ed03))
}
