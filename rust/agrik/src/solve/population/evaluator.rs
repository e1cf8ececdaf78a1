//! The shared evaluator of all population solvers: one individual per lane.

use crate::chain::{Chain, Compiled, JointKind};
use crate::kinematics::{Workspace, forward_frame};
use crate::lanes::Real;
use crate::random::Stream;
use crate::solve::start::range;

/// What makes one individual better than another: the lower the cost, the better.
///
/// A cost that is not a number counts as infinitely bad.
pub trait Fitness<R: Real> {
    /// Cost of the postures `q` (one entry per joint value, one individual per lane), whose
    /// last frame stands in `at` (the joints' axes do not).
    fn cost(&self, q: &[R], at: &Workspace<R>) -> R;
}

/// What a gene may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gene {
    /// Smallest value, rad or m.
    pub lower: f64,
    /// Largest value, rad or m.
    pub upper: f64,
    /// A joint without limits: values outside mean the same posture as one inside.
    pub turns: bool,
}

impl Gene {
    /// The genes of a chain: its limits, and one turn about `center` (0 if there is none)
    /// for joints that have none.
    pub fn of(chain: &Chain, center: Option<&[f64]>) -> Vec<Self> {
        let about = |i: usize| center.map_or(0.0, |q| q[i]);
        let variables = chain.variables().iter().enumerate();
        variables
            .map(|(i, v)| match v.kind {
                JointKind::Continuous => Self {
                    lower: about(i) - std::f64::consts::PI,
                    upper: about(i) + std::f64::consts::PI,
                    turns: true,
                },
                // Slides without limits.
                _ if (v.upper - v.lower).is_infinite() => {
                    let (lower, width) = range(chain, v);
                    Self { lower, upper: lower + width, turns: false }
                }
                _ => Self { lower: v.lower, upper: v.upper, turns: false },
            })
            .collect()
    }

    /// The same for a gene of several individuals.
    #[inline(always)]
    pub fn range<R: Real>(&self) -> Range<R> {
        Range {
            lower: R::splat(self.lower),
            upper: R::splat(self.upper),
            middle: R::splat(0.5 * (self.lower + self.upper)),
            turns: self.turns,
        }
    }
}

/// A [`Gene`] in lanes.
#[derive(Debug, Clone, Copy)]
pub struct Range<R> {
    /// Smallest value, rad or m.
    pub lower: R,
    /// Largest value, rad or m.
    pub upper: R,
    /// Between these.
    pub middle: R,
    /// A joint without limits.
    pub turns: bool,
}

/// Individuals with their costs: blocks of one vector per gene.
#[derive(Debug, Clone)]
pub struct Population<R> {
    /// How many individuals; the rest of the last block is filled up with others' likes,
    /// whose cost is infinite.
    pub size: usize,
    /// Genes of an individual.
    pub dof: usize,
    /// Genes, block by block.
    pub genes: Vec<R>,
    /// Costs, one vector a block.
    pub cost: Vec<R>,
}

impl<R: Real> Population<R> {
    /// Room for `size` individuals.
    #[inline(always)]
    pub fn new(size: usize, dof: usize) -> Self {
        let blocks = size.div_ceil(R::WIDTH);
        Self {
            size,
            dof,
            genes: vec![R::zero(); blocks * dof],
            cost: vec![R::splat(f64::INFINITY); blocks],
        }
    }

    /// Makes room for another number of individuals; those that stay keep their genes.
    #[inline(always)]
    pub fn resize(&mut self, size: usize) {
        let blocks = size.div_ceil(R::WIDTH);
        self.size = size;
        self.genes.resize(blocks * self.dof, R::zero());
        self.cost.resize(blocks, R::splat(f64::INFINITY));
        for i in size..blocks * R::WIDTH {
            self.set_cost(i, f64::INFINITY);
        }
    }

    /// Sets the cost of an individual.
    #[inline(always)]
    pub fn set_cost(&mut self, i: usize, cost: f64) {
        self.cost[i / R::WIDTH].set_lane(i % R::WIDTH, cost);
    }

    /// Uniform random individuals.
    #[inline(always)]
    pub fn scatter(&mut self, genes: &[Gene], stream: &mut Stream) {
        for block in self.genes.chunks_exact_mut(self.dof) {
            for (x, gene) in block.iter_mut().zip(genes) {
                let u: R = stream.uniforms();
                *x = u.mul_add(R::splat(gene.upper - gene.lower), R::splat(gene.lower));
            }
        }
    }

    /// How many blocks.
    #[inline(always)]
    pub fn blocks(&self) -> usize {
        self.cost.len()
    }

    /// The genes of a block.
    #[inline(always)]
    pub fn block(&self, block: usize) -> &[R] {
        &self.genes[block * self.dof..(block + 1) * self.dof]
    }

    /// The genes of a block, writable.
    #[inline(always)]
    pub fn block_mut(&mut self, block: usize) -> &mut [R] {
        &mut self.genes[block * self.dof..(block + 1) * self.dof]
    }

    /// Place of an individual's genes, and its lane.
    #[inline(always)]
    pub fn place(&self, i: usize) -> (usize, usize) {
        (i / R::WIDTH * self.dof, i % R::WIDTH)
    }

    /// Cost of an individual.
    #[inline(always)]
    pub fn cost_of(&self, i: usize) -> f64 {
        self.cost[i / R::WIDTH].lane(i % R::WIDTH)
    }

    /// Copies an individual's genes out.
    #[inline(always)]
    pub fn read(&self, i: usize, q: &mut [f64]) {
        let (start, lane) = self.place(i);
        for (x, gene) in q.iter_mut().zip(&self.genes[start..start + self.dof]) {
            *x = gene.lane(lane);
        }
    }

    /// Copies an individual's genes out, each into all lanes.
    #[inline(always)]
    pub fn spread(&self, i: usize, genes: &mut [R]) {
        let (start, lane) = self.place(i);
        for (x, gene) in genes.iter_mut().zip(&self.genes[start..start + self.dof]) {
            *x = R::splat(gene.lane(lane));
        }
    }

    /// Puts an individual in place of another.
    #[inline(always)]
    pub fn write(&mut self, i: usize, q: &[f64]) {
        let (start, lane) = self.place(i);
        for (x, gene) in q.iter().zip(&mut self.genes[start..start + self.dof]) {
            gene.set_lane(lane, *x);
        }
    }

    /// The best individual; the first one if none has a finite cost.
    #[inline(always)]
    pub fn best(&self) -> usize {
        let mut least = R::splat(f64::INFINITY);
        for cost in &self.cost {
            least = cost.min(least);
        }
        let mut value = least.lane(0);
        for lane in 1..R::WIDTH {
            value = value.min(least.lane(lane));
        }
        let value = R::splat(value);
        for (block, cost) in self.cost.iter().enumerate() {
            let bits = R::bits(cost.le(value));
            if bits != 0 && value.lane(0) < f64::INFINITY {
                return block * R::WIDTH + bits.trailing_zeros() as usize;
            }
        }
        0
    }

    /// The best individuals, as many as asked for, from best to worst; equals in their order.
    pub fn ranked(&self, count: usize, order: &mut Vec<usize>) {
        order.clear();
        order.extend(0..self.size);
        let rank =
            |a: &usize, b: &usize| self.cost_of(*a).total_cmp(&self.cost_of(*b)).then(a.cmp(b));
        if count < self.size {
            order.select_nth_unstable_by(count, rank);
            order.truncate(count);
        }
        order.sort_unstable_by(rank);
    }
}

/// Forward kinematics and fitness of whole blocks.
#[derive(Debug)]
pub struct Evaluator<'a, R, F> {
    chain: &'a Compiled,
    fitness: F,
    workspace: Workspace<R>,
}

impl<'a, R: Real, F: Fitness<R>> Evaluator<'a, R, F> {
    /// An evaluator over a chain.
    #[inline(always)]
    pub fn new(chain: &'a Compiled, fitness: F) -> Self {
        Self { chain, fitness, workspace: Workspace::new(chain) }
    }

    /// Costs of all individuals.
    #[inline(always)]
    pub fn evaluate(&mut self, population: &mut Population<R>) {
        let dof = population.dof;
        let infinite = R::splat(f64::INFINITY);
        let blocks = population.genes.chunks_exact(dof).zip(&mut population.cost);
        for (block, cost) in blocks {
            forward_frame(self.chain, block, &mut self.workspace);
            let found = self.fitness.cost(block, &self.workspace);
            *cost = R::select(found.lt(infinite), found, infinite);
        }
        let spare = population.size % R::WIDTH;
        if spare != 0
            && let Some(last) = population.cost.last_mut()
        {
            *last = R::select(R::mask_from_bits((1 << spare) - 1), *last, infinite);
        }
    }
}
