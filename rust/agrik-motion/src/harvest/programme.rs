//! The harvest posture as a non-linear programme: equations (1) to (6) of the paper, for any
//! arm, solved by the population searches that inverse kinematics has as well.
//!
//! The cost has three terms: how far the tool point is from the grip point (4), how far the
//! tool's x axis is from pointing down (5), and how near the arm is to the crop (6), which is
//! 0 where it is far enough and 1 where it touches anything. The approach angle is free. What
//! is asked about is one posture at a time, so these searches run without lanes.

use std::cell::RefCell;

use agrik::kinematics::Workspace;
use agrik::random::Stream;
use agrik::solve::population::{
    Adaptation, Algorithm, Boundary, Differential, Evaluator, Fitness, Gene, Genetic, Mutation,
    Orientation, Population, Redraw, Settings,
};
use agrik_compute::Allowed;
use agrik_compute::lanes::{dot, sub};
use agrik_compute::threads::share;

use super::aim::Target;
use super::surroundings::{Minding, Surroundings};
use crate::body::Placed;
use crate::{Error, Result};

/// What each term of the cost weighs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    /// Per metre of position error. The paper prints no unit; its best costs make it metres.
    pub position: f64,
    /// Of the orientation term.
    pub orientation: f64,
    /// Of the distance term.
    pub distance: f64,
    /// Distance from the crop that is enough, m.
    pub enough: f64,
}

impl Default for Weights {
    fn default() -> Self {
        Self { position: 1.0, orientation: 1.0, distance: 1.0, enough: 0.075 }
    }
}

impl Weights {
    /// Refuses numbers out of their ranges.
    ///
    /// # Errors
    ///
    /// Names the first of them; or all weights are zero.
    pub fn check(&self) -> Result<()> {
        for (name, weight) in [
            ("position_weight", self.position),
            ("orientation_weight", self.orientation),
            ("distance_weight", self.distance),
        ] {
            Allowed::NOT_NEGATIVE.check(name, weight)?;
        }
        Allowed::POSITIVE.of("m").check("enough", self.enough)?;
        if self.position + self.orientation + self.distance == 0.0 {
            return Err(Error::argument("weights", "one of the weights above 0", "all zero"));
        }
        Ok(())
    }
}

/// The terms of the cost at one posture, before they are weighed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Terms {
    /// Weighted sum.
    pub cost: f64,
    /// (4): distance of the tool point from the grip point, m.
    pub position: f64,
    /// (5): about the square root of two times the tilt, rad.
    pub orientation: f64,
    /// (6): 0 to 1.
    pub nearness: f64,
    /// Distance from the crop, m; 0 where bodies touch each other or a static thing.
    pub distance: f64,
}

/// The genetic algorithm's settings; the paper gives none.
pub const GENETIC: Settings = Settings {
    algorithm: Algorithm::Genetic(Genetic {
        tournament: 2,
        crossover_rate: 0.9,
        crossover_index: 10.0,
        mutation_rate: 0.15,
        mutation_width: 0.15,
        mutation_end: 1e-4,
        elites: 2,
        boundary: Boundary::Clamp,
    }),
    population: 100,
    generations: 1500,
    target_cost: 1.5e-4,
    ..SEARCH
};

/// Differential evolution, best/1/bin with a dithered weight.
pub const DIFFERENTIAL: Settings = Settings {
    algorithm: Algorithm::Differential(Differential {
        mutation: Mutation::Best1,
        adaptation: Adaptation::None,
        weight: 0.4,
        dither: 0.5,
        crossover: (0.9, 0.9),
        redraw: Redraw::Generation,
        boundary: Boundary::Redraw,
    }),
    population: 70,
    generations: 1500,
    target_cost: 1e-9,
    ..SEARCH
};

/// What both have in common; the cost is not that of inverse kinematics.
const SEARCH: Settings = Settings {
    max_restarts: 0,
    orientation: Orientation::RotationVector,
    position_weight: 1.0,
    orientation_weight: None,
    start_weight: 0.0,
    stagnation: 0,
    polish: false,
    ..Settings::DIFFERENTIAL
};

/// A target for an arm with bodies in a crop, and what a posture costs.
#[derive(Debug)]
pub struct Programme<'a> {
    around: &'a Surroundings,
    target: &'a Target,
    minding: Minding,
    weights: Weights,
}

/// One run of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The best posture, rad and m.
    pub q: Vec<f64>,
    /// Its cost, term by term.
    pub terms: Terms,
    /// Generations made.
    pub generations: u32,
    /// Postures looked at.
    pub evaluations: u64,
    /// Best cost of the first population and after each generation.
    pub history: Vec<f64>,
}

impl<'a> Programme<'a> {
    /// A checked programme.
    ///
    /// # Errors
    ///
    /// A weight is out of its range, all are zero, the grip point is no place, or an object of
    /// the target is none of the scene's.
    pub fn new(around: &'a Surroundings, target: &'a Target, weights: Weights) -> Result<Self> {
        weights.check()?;
        for x in target.point {
            Allowed::FINITE.check("target", x)?;
        }
        let minding = Minding::new(around, &target.objects)?;
        Ok(Self { around, target, minding, weights })
    }

    /// The terms at a posture.
    ///
    /// # Errors
    ///
    /// `q` has another length, or a number that is not finite.
    pub fn terms(&self, q: &[f64]) -> Result<Terms> {
        let mut placed = self.around.bodies.room();
        self.around.bodies.place(q, &mut placed)?;
        Ok(self.judged(&placed, f64::INFINITY))
    }

    /// The terms at a posture whose bodies are in place; distances beyond `cap` are it.
    fn judged(&self, placed: &Placed, cap: f64) -> Terms {
        let chain = self.around.chain().compiled();
        let way = sub(placed.tool(), self.target.point);
        let position = dot(way, way).sqrt();
        let last = placed.frame(chain.links.len());
        let [x, y, z] = chain.tail.rotation.map(|axis| last.direction(axis));
        // The first column and the third row of the tool's rotation.
        let squares = [x[0], x[1], 1.0 + x[2], y[2], z[2]].map(|r| r * r);
        let orientation = squares.iter().sum::<f64>().sqrt();
        let distance = if self.around.hits_itself(placed) {
            0.0
        } else {
            self.around.clearance(placed, &self.minding, cap)
        };
        let nearness = (1.0 - distance / self.weights.enough).clamp(0.0, 1.0);
        let Weights { position: p, orientation: o, distance: d, .. } = self.weights;
        let cost = p * position + o * orientation + d * nearness;
        Terms { cost, position, orientation, nearness, distance }
    }

    /// The best posture that a search finds from one seed.
    ///
    /// # Errors
    ///
    /// A setting is out of its range.
    pub fn search(&self, settings: &Settings, seed: u64) -> Result<Run> {
        settings.check()?;
        let chain = self.around.chain();
        let genes = Gene::of(chain, None);
        let room = RefCell::new(self.around.bodies.room());
        let fitness = Cost { programme: self, room: &room };
        let mut evaluator = Evaluator::<f64, _>::new(chain.compiled(), fitness);
        let mut population = Population::<f64>::new(settings.population as usize, genes.len());
        let mut progress = settings.progress();
        progress.trace = Some(Vec::new());
        let mut stream = Stream::new(seed);
        settings.evolve(
            &genes,
            &mut evaluator,
            None,
            &mut population,
            &mut stream,
            &mut progress,
            &mut || true,
        );
        let mut q = vec![0.0; genes.len()];
        population.read(population.best(), &mut q);
        Ok(Run {
            terms: self.terms(&q)?,
            q,
            generations: progress.generations,
            evaluations: u64::from(settings.population) * (u64::from(progress.generations) + 1),
            history: progress.trace.unwrap_or_default(),
        })
    }

    /// [`Programme::search`] from several seeds, on `threads` threads (0: the number in force);
    /// `poll` is asked now and then whether to go on.
    ///
    /// # Errors
    ///
    /// As [`Programme::search`]; `poll` said no.
    pub fn searches(
        &self,
        settings: &Settings,
        seeds: &[u64],
        threads: usize,
        poll: &mut dyn FnMut() -> bool,
    ) -> Result<Vec<Run>> {
        let mut out: Vec<Option<Result<Run>>> = seeds.iter().map(|_| None).collect();
        let work = |(seed, to): (&u64, &mut Option<Result<Run>>)| {
            *to = Some(self.search(settings, *seed));
        };
        if !share(seeds.iter().zip(&mut out).collect(), threads, &work, poll) {
            return Err(Error::Interrupted);
        }
        out.into_iter().map(|run| run.unwrap_or(Err(Error::Interrupted))).collect()
    }
}

/// The cost as population searches ask for it.
struct Cost<'p> {
    programme: &'p Programme<'p>,
    room: &'p RefCell<Placed>,
}

impl Fitness<f64> for Cost<'_> {
    fn cost(&self, q: &[f64], _: &Workspace<f64>) -> f64 {
        let around = self.programme.around;
        let mut placed = self.room.borrow_mut();
        around.bodies.place_unchecked(q, &mut placed);
        self.programme.judged(&placed, self.programme.weights.enough).cost
    }
}
