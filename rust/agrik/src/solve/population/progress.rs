//! When a run ends, and its record.

/// Why a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The last generation was reached.
    Generations,
    /// The best cost is at or below the one aimed at.
    Cost,
    /// The best cost has stood still.
    Stagnation,
    /// The caller asked to stop.
    Interrupted,
}

/// A best cost that falls by less than this share of itself stands still.
const STANDSTILL: f64 = 1e-3;

/// Follows the best cost over the generations of a run.
#[derive(Debug, Clone)]
pub struct Progress {
    /// Generations made.
    pub generations: u32,
    last: u32,
    target: f64,
    patience: u32,
    mark: f64,
    since: u32,
    /// Best cost of the first population and after each generation, if wanted.
    pub trace: Option<Vec<f64>>,
}

impl Progress {
    /// The progress of a run that ends after `last` generations, at a cost of at most
    /// `target`, or after `patience` generations (0: any number) at a standstill.
    pub fn new(last: u32, target: f64, patience: u32) -> Self {
        Self { generations: 0, last, target, patience, mark: f64::INFINITY, since: 0, trace: None }
    }

    /// Notes the best cost, and says whether that ends the run.
    #[inline(always)]
    pub fn note(&mut self, best: f64) -> Option<End> {
        if let Some(trace) = &mut self.trace {
            trace.push(best);
        }
        if best < self.mark * (1.0 - STANDSTILL) {
            self.mark = best;
            self.since = 0;
        } else {
            self.since += 1;
        }
        if best <= self.target {
            return Some(End::Cost);
        }
        if self.patience != 0 && self.since > self.patience {
            return Some(End::Stagnation);
        }
        (self.generations >= self.last).then_some(End::Generations)
    }

    /// Generations made, as a share of all.
    pub fn share(&self) -> f64 {
        f64::from(self.generations) / f64::from(self.last.max(1))
    }

    /// Generations since the best cost last fell by more than a trifle.
    pub fn standing_still(&self) -> u32 {
        self.since
    }
}
