//! What a population search can be told.

use super::differential::{Adaptation, Differential};
use super::evaluator::{Evaluator, Fitness, Gene, Population};
use super::fitness::Orientation;
use super::genetic::Genetic;
use super::progress::{End, Progress};
use super::run::Run;
use super::{Boundary, Mutation, Redraw, lshade};
use crate::call::{Aim, Measure};
use crate::error::{Error, Result};
use crate::lanes::Real;
use crate::random::Stream;
use crate::{Allowed, Field};

/// Individuals that a search can hold.
const MOST: u32 = 1 << 20;

/// How the next generation is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Algorithm {
    /// Differential evolution.
    Differential(Differential),
    /// A real-coded genetic algorithm.
    Genetic(Genetic),
}

/// A population search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// How the next generation is made.
    pub algorithm: Algorithm,
    /// Individuals.
    pub population: u32,
    /// Generations of one run.
    pub generations: u32,
    /// Runs after the first before the target is given up.
    pub max_restarts: u32,
    /// How the distance of two orientations is measured.
    pub orientation: Orientation,
    /// Cost of a metre.
    pub position_weight: f64,
    /// Cost of a radian; without it, `position_weight` times 0.3 of the robot's reach.
    pub orientation_weight: Option<f64>,
    /// Cost of a radian (or metre) of way from the start values, where some are given.
    pub start_weight: f64,
    /// A best cost at or below this ends a run.
    pub target_cost: f64,
    /// So many generations without a better cost end a run; 0: none.
    pub stagnation: u32,
    /// Hand the best individuals to the default step solver.
    pub polish: bool,
}

impl Settings {
    /// All population solvers by their names, with their defaults.
    pub const KNOWN: [(&str, Self); 2] = [("de", Self::DIFFERENTIAL), ("ga", Self::GENETIC)];

    /// The name by which users choose the algorithm.
    pub fn name(&self) -> &'static str {
        match self.algorithm {
            Algorithm::Differential(_) => "de",
            Algorithm::Genetic(_) => "ga",
        }
    }

    /// Memetic differential evolution, the default: a short run, then the default step
    /// solver from its best individuals, again and again.
    pub const DIFFERENTIAL: Self = Self {
        algorithm: Algorithm::Differential(Differential {
            mutation: Mutation::Best1,
            adaptation: Adaptation::None,
            weight: 0.5,
            dither: 0.0,
            crossover: (0.375, 1.125),
            redraw: Redraw::Individual,
            boundary: Boundary::Redraw,
        }),
        population: 48,
        generations: 20,
        max_restarts: 20,
        orientation: Orientation::RotationVector,
        position_weight: 1.0,
        orientation_weight: None,
        start_weight: 0.0,
        target_cost: 0.0,
        stagnation: 0,
        polish: true,
    };

    /// The published recipe for the redundant arm (Li et al.), in the adopted reading:
    /// 100 individuals, 200 generations, best/1/bin, a crossover rate drawn anew for every
    /// gene, genes out of range put to the middle, a cost of 1 per mm and 100 per radian
    /// of ZYZ angles, no polish.
    pub const PUBLISHED: Self = Self {
        algorithm: Algorithm::Differential(Differential {
            mutation: Mutation::Best1,
            adaptation: Adaptation::None,
            weight: 0.5,
            dither: 0.0,
            crossover: (0.375, 1.125),
            redraw: Redraw::Gene,
            boundary: Boundary::Median,
        }),
        population: 100,
        generations: 200,
        max_restarts: 0,
        orientation: Orientation::EulerZyz,
        position_weight: 1000.0,
        orientation_weight: Some(100.0),
        start_weight: 0.0,
        target_cost: 0.0,
        stagnation: 0,
        polish: false,
    };

    /// A genetic algorithm whose best individuals are polished.
    pub const GENETIC: Self = Self {
        algorithm: Algorithm::Genetic(Genetic {
            tournament: 3,
            crossover_rate: 0.9,
            crossover_index: 5.0,
            mutation_rate: 0.2,
            mutation_width: 0.1,
            mutation_end: 1.0,
            elites: 2,
            boundary: Boundary::Clamp,
        }),
        ..Self::DIFFERENTIAL
    };

    /// The numbers that users choose; that of one of them may hang on another.
    pub fn fields(&mut self) -> Vec<Field<'_>> {
        let mut fields = match &mut self.algorithm {
            Algorithm::Differential(it) => it.fields(),
            Algorithm::Genetic(it) => it.fields(self.population),
        };
        let weight = Allowed::NOT_NEGATIVE;
        fields.extend([
            Field::count("population", &mut self.population, Allowed::whole(4, MOST)),
            Field::count("generations", &mut self.generations, Allowed::whole(1, u32::MAX)),
            Field::count("max_restarts", &mut self.max_restarts, Allowed::COUNT),
            Field::real("position_weight", &mut self.position_weight, weight.of("per m")),
            Field::real("start_weight", &mut self.start_weight, weight),
            Field::real("target_cost", &mut self.target_cost, weight),
            Field::count("stagnation", &mut self.stagnation, Allowed::COUNT),
        ]);
        if let Some(orientation) = &mut self.orientation_weight {
            fields.push(Field::real("orientation_weight", orientation, weight.of("per rad")));
        }
        fields
    }

    /// Refuses numbers that are not allowed.
    pub fn check(&self) -> Result<()> {
        // On a copy: numbers are small.
        let mut copy = *self;
        copy.fields().iter().try_for_each(Field::check)?;
        if self.position_weight == 0.0 && self.orientation_weight.unwrap_or(0.0) == 0.0 {
            return Err(Error::argument("position_weight", "one of the weights above 0", 0));
        }
        match &self.algorithm {
            Algorithm::Differential(it) => it.check(),
            Algorithm::Genetic(_) => Ok(()),
        }
    }

    /// [`Settings::check`], and that the task has what the fitness measures.
    pub fn check_for(&self, aim: &Aim) -> Result<()> {
        self.check()?;
        let has_angles = matches!(aim.measure(1.0), Measure::Pose(_) | Measure::Position(_));
        if self.orientation == Orientation::EulerZyz && !has_angles {
            return Err(Error::argument(
                "orientation",
                "the rotation vector, since the task fixes no full orientation",
                "euler-zyz",
            ));
        }
        Ok(())
    }

    /// One run; the last population stays in `population`.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    pub fn evolve<R: Real, F: Fitness<R>>(
        &self,
        genes: &[Gene],
        evaluator: &mut Evaluator<'_, R, F>,
        start: Option<&[f64]>,
        population: &mut Population<R>,
        stream: &mut Stream,
        progress: &mut Progress,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> End {
        population.resize(self.population as usize);
        population.scatter(genes, stream);
        if let Some(q) = start {
            population.write(0, q);
        }
        evaluator.evaluate(population);
        let run = Run { genes, evaluator, population, stream, progress, keep_going };
        match (&self.algorithm, self.budget()) {
            (Algorithm::Differential(it), Some(budget)) => lshade::run(it, budget, run),
            (Algorithm::Differential(it), None) => it.run(run),
            (Algorithm::Genetic(it), _) => it.run(run),
        }
    }

    /// The progress of a run, before its first generation.
    pub fn progress(&self) -> Progress {
        // A run with a budget of evaluations ends by that.
        let last = if self.budget().is_some() { u32::MAX } else { self.generations };
        Progress::new(last, self.target_cost, self.stagnation)
    }

    /// Evaluations of a run that counts them, not generations: L-SHADE's.
    pub(super) fn budget(&self) -> Option<u64> {
        match &self.algorithm {
            Algorithm::Differential(it) if it.adaptation == Adaptation::LShade => {
                Some(u64::from(self.population) * (u64::from(self.generations) + 1))
            }
            _ => None,
        }
    }
}
