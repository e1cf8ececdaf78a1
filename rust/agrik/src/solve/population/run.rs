//! One run of an algorithm: what all of them are handed, and when they stop.

use super::evaluator::{Evaluator, Fitness, Gene, Population};
use super::progress::{End, Progress};
use crate::lanes::Real;
use crate::random::Stream;

/// A run that has its first, judged population; the last one stays in `population`.
pub(super) struct Run<'r, 'e, R, F> {
    pub genes: &'r [Gene],
    pub evaluator: &'r mut Evaluator<'e, R, F>,
    pub population: &'r mut Population<R>,
    pub stream: &'r mut Stream,
    pub progress: &'r mut Progress,
    pub keep_going: &'r mut dyn FnMut() -> bool,
}

impl<R: Real, F: Fitness<R>> Run<'_, '_, R, F> {
    /// The best individual, from which the next generation is made; or why there is none.
    #[inline(always)]
    pub fn best(&mut self) -> Result<usize, End> {
        let best = self.population.best();
        if let Some(end) = self.progress.note(self.population.cost_of(best)) {
            return Err(end);
        }
        if (self.keep_going)() { Ok(best) } else { Err(End::Interrupted) }
    }
}
