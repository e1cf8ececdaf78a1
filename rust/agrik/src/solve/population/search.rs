//! The search for one target after the other: seeds, restarts, polish, record of answers.

use super::evaluator::{Evaluator, Gene, Population};
use super::fitness::{EulerGoal, TaskFitness};
use super::progress::{End, Progress};
use super::settings::Settings;
use crate::allowed::LARGEST;
use crate::call::{Answers, AnswersMut, Outcome, Prefer, Request, Solve, Status, Verdict};
use crate::error::{Error, Result};
use crate::kinematics::{Workspace, forward};
use crate::lanes::{Kernel, Level, Real, dispatch};
use crate::random::Stream;
use crate::solve::limit::{bring_near, limits};
use crate::solve::plan::Plan;
use crate::solve::step;
use crate::task::Goal;

/// Best individuals that are polished side by side.
const POLISHED: usize = 8;
/// The step solver that polishes: one attempt from each individual, with some patience.
const POLISH: step::Settings =
    step::Settings { max_iterations: 20, max_restarts: 0, ..step::Settings::LEVENBERG_MARQUARDT };

/// Share of the way to the start values that a polishing step tries to go, where the
/// search is to keep near them.
const PULL: f64 = 0.5;
/// A run that has not improved for so many generations is at a local minimum.
const STUCK: u32 = 30;

/// A population search for the targets of a request.
#[derive(Debug, Clone)]
pub struct Evolution<'a> {
    /// The request, and how what is found is polished.
    plan: Plan<'a>,
    settings: Settings,
    orientation_weight: f64,
}

impl<'a> Evolution<'a> {
    /// A checked search.
    pub fn new(request: Request<'a>, settings: Settings) -> Result<Self> {
        settings.check_for(request.aim())?;
        let plan = Plan::new(request, POLISH)?;
        let setup = plan.setup();
        let orientation_weight =
            settings.orientation_weight.unwrap_or(settings.position_weight * setup.rotation_scale);
        Ok(Self { plan, settings, orientation_weight })
    }

    /// The best cost of the first population of target `row` and after each generation of
    /// its first run; the curve that papers print. `poll` is asked now and then whether to go
    /// on.
    pub fn trace(
        &self,
        level: Level,
        row: usize,
        poll: &mut dyn FnMut() -> bool,
    ) -> Result<Vec<f64>> {
        if self.plan.request.goal(row).is_none() {
            let expected = format!("finite numbers of size {LARGEST:e} at most, as of `q0`");
            return Err(Error::argument("targets", expected, "others"));
        }
        let settings = Settings { polish: false, max_restarts: 0, ..self.settings };
        let evolution = &Self { settings, ..self.clone() };
        let mut answers = Answers::new(1, self.dof());
        let mut rows = answers.as_mut();
        rows.first = row;
        let mut rows = Some(rows);
        let next = &mut || rows.take();
        let mut trace = Vec::new();
        let wanted = Some(&mut trace);
        let searches = Searches { evolution, level, next, keep_going: poll, trace: wanted };
        if dispatch(level, searches) { Ok(trace) } else { Err(Error::Interrupted) }
    }

    #[inline(always)]
    fn fitness<R: Real>(&self, row: usize, goal: &Goal<f64>) -> TaskFitness<'_, R> {
        let plan = &self.plan;
        let mut lanes = Goal::zero();
        for lane in 0..R::WIDTH {
            lanes.set_lane(lane, goal);
        }
        let start = plan.request.start(row);
        let weight = self.settings.start_weight;
        let setup = plan.setup();
        TaskFitness {
            measure: setup.aim.measure(1.0),
            orientation: self.settings.orientation,
            position_weight: self.settings.position_weight,
            orientation_weight: self.orientation_weight,
            tail: *setup.aim.tail(),
            plain_tail: setup.aim.tail().rotation
                == [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            goal: lanes,
            target: EulerGoal::of(tool_axes(goal, &setup.aim.tail().rotation)),
            start: start.filter(|_| weight > 0.0).map(|q| (weight, q)),
        }
    }
}

/// Axes of the tool at a pose goal, which is given as axes of the last joint.
fn tool_axes(goal: &Goal<f64>, tail: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    tail.map(|column| [0, 1, 2].map(|k| (0..3).map(|j| goal.axes[j][k] * column[j]).sum::<f64>()))
}

impl Solve for Evolution<'_> {
    fn rows(&self) -> usize {
        self.plan.rows()
    }
    fn dof(&self) -> usize {
        self.plan.dof()
    }
    /// A target takes about as long as hundreds do with a step solver.
    fn run_length(&self) -> usize {
        4
    }
    fn run<'a>(
        &self,
        level: Level,
        next: &mut dyn FnMut() -> Option<AnswersMut<'a>>,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> bool {
        dispatch(level, Searches { evolution: self, level, next, keep_going, trace: None })
    }
}

struct Searches<'k, 'a> {
    evolution: &'k Evolution<'k>,
    level: Level,
    next: &'k mut dyn FnMut() -> Option<AnswersMut<'a>>,
    keep_going: &'k mut dyn FnMut() -> bool,
    trace: Option<&'k mut Vec<f64>>,
}

impl Kernel for Searches<'_, '_> {
    type Output = bool;
    #[inline(always)]
    fn run<R: Real>(self) -> bool {
        let mut search = Search::<R>::new(self.evolution, self.level);
        search.trace = self.trace.is_some().then(Vec::new);
        while let Some(mut rows) = (self.next)() {
            for i in 0..rows.len() {
                let Some(outcome) = search.solve(rows.first + i, self.keep_going) else {
                    return false;
                };
                rows.finish(i, outcome).copy_from_slice(&search.found.q);
            }
        }
        if let (Some(trace), Some(costs)) = (self.trace, search.trace) {
            *trace = costs;
        }
        true
    }
}

/// The best posture of a target so far.
struct Found {
    q: Vec<f64>,
    /// What postures are compared by: reached ones first, then by this, m^2.
    squared: f64,
    reached: bool,
    /// What the call's guard, if there is one, finds it.
    verdict: Option<Verdict>,
    position_error: f64,
    orientation_error: f64,
}

impl Found {
    /// It reaches the target, and nothing speaks against it.
    fn is_answer(&self) -> bool {
        self.reached && self.verdict.is_none_or(|verdict| verdict.accepted)
    }
}

/// Buffers of one thread.
struct Search<'e, R: Real> {
    evolution: &'e Evolution<'e>,
    level: Level,
    genes: Vec<Gene>,
    population: Population<R>,
    workspace: Workspace<f64>,
    order: Vec<usize>,
    q: Vec<f64>,
    found: Found,
    /// Best costs, where they are wanted.
    trace: Option<Vec<f64>>,
}

impl<'e, R: Real> Search<'e, R> {
    fn new(evolution: &'e Evolution<'e>, level: Level) -> Self {
        let chain = evolution.plan.request.chain();
        let dof = chain.dof();
        Self {
            evolution,
            level,
            genes: Gene::of(chain, None),
            population: Population::new(evolution.settings.population as usize, dof),
            workspace: Workspace::new(chain.compiled()),
            order: Vec::new(),
            q: vec![0.0; dof],
            found: Found {
                q: vec![0.0; dof],
                squared: f64::INFINITY,
                reached: false,
                verdict: None,
                position_error: f64::INFINITY,
                orientation_error: f64::INFINITY,
            },
            trace: None,
        }
    }

    /// Solves a target; `None` where the caller wants to stop.
    #[inline(always)]
    fn solve(&mut self, row: usize, keep_going: &mut dyn FnMut() -> bool) -> Option<Outcome> {
        let (plan, settings) = (&self.evolution.plan, &self.evolution.settings);
        self.forget();
        let mut outcome = Outcome::unanswered(Status::BadInput);
        let Some(goal) = plan.request.goal(row) else { return Some(outcome) };
        let start = plan.request.start(row);
        if start.is_some() {
            self.genes = Gene::of(plan.request.chain(), start);
        }
        let unreachable = plan.proven_unreachable(&goal);
        outcome.status = if unreachable { Status::OutOfReach } else { Status::NotFound };
        let first = plan.setup().aim.puts_position_first();
        if settings.polish && start.is_some() && !first {
            // What is near the start values needs no search.
            self.take_start(start);
            self.polish(row, &goal, 1);
        }
        while !self.found.is_answer() {
            let mut progress = settings.progress();
            progress.trace = self.trace.take();
            let end = self.evolve(row, outcome.restarts, &goal, &mut progress, keep_going);
            self.trace = progress.trace.take();
            if end == End::Interrupted {
                return None;
            }
            if !unreachable {
                let stuck = end == End::Stagnation || progress.standing_still() > STUCK;
                outcome.status = if stuck { Status::Stalled } else { Status::NotFound };
            }
            outcome.iterations += progress.generations;
            self.population.ranked(POLISHED, &mut self.order);
            let best = self.order[0];
            self.population.read(best, &mut self.q);
            self.consider(&goal, start);
            if settings.polish && (first || !self.found.is_answer()) {
                self.polish(row, &goal, POLISHED);
            }
            if self.found.is_answer() || unreachable || outcome.restarts == settings.max_restarts {
                break;
            }
            outcome.restarts += 1;
        }
        if self.found.reached {
            let accepted = self.found.is_answer();
            outcome.status = if accepted { Status::Converged } else { Status::InCollision };
        }
        outcome.position_error = self.found.position_error;
        outcome.orientation_error = self.found.orientation_error;
        Some(outcome)
    }

    /// A posture inside the limits stands in until a better one is found.
    fn forget(&mut self) {
        let variables = self.evolution.plan.request.chain().variables();
        for (x, v) in self.found.q.iter_mut().zip(variables) {
            *x = v.near_zero();
        }
        self.found.squared = f64::INFINITY;
        self.found.reached = false;
        self.found.verdict = None;
        self.found.position_error = f64::INFINITY;
        self.found.orientation_error = f64::INFINITY;
    }

    /// One run of the algorithm.
    #[inline(always)]
    fn evolve(
        &mut self,
        row: usize,
        attempt: u32,
        goal: &Goal<f64>,
        progress: &mut Progress,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> End {
        let evolution = self.evolution;
        let plan = &evolution.plan;
        let fitness = evolution.fitness::<R>(row, goal);
        let mut evaluator = Evaluator::new(plan.request.chain().compiled(), fitness);
        let mut stream = Stream::new(plan.sampler.key(row, attempt));
        let start = plan.request.start(row).filter(|_| attempt == 0);
        let mut inside = [0.0; 32];
        let start = start.filter(|q| q.len() <= inside.len()).map(|q| {
            for ((x, from), gene) in inside.iter_mut().zip(q).zip(&self.genes) {
                *x = from.clamp(gene.lower, gene.upper);
            }
            &inside[..q.len()]
        });
        evolution.settings.evolve(
            &self.genes,
            &mut evaluator,
            start,
            &mut self.population,
            &mut stream,
            progress,
            keep_going,
        )
    }

    /// Makes the start values the only ranked individual.
    fn take_start(&mut self, start: Option<&[f64]>) {
        for (i, gene) in self.genes.iter().enumerate() {
            self.q[i] = start.map_or(0.0, |q| q[i]).clamp(gene.lower, gene.upper);
        }
        self.population.resize(self.evolution.settings.population as usize);
        self.population.write(0, &self.q);
        self.order.clear();
        self.order.push(0);
    }

    /// Hands the best individuals to the step solver, side by side in its lanes.
    fn polish(&mut self, row: usize, goal: &Goal<f64>, most: usize) {
        let plan = &self.evolution.plan;
        let dof = plan.request.chain().dof();
        let count = most.min(self.order.len()).min(self.population.size);
        let mut starts = Vec::with_capacity(count * dof);
        for &individual in &self.order[..count] {
            self.population.read(individual, &mut self.q);
            starts.extend_from_slice(&self.q);
        }
        let target = plan.request.copies(row, count);
        let mut copies = plan.with(&target, &starts, POLISH);
        let start = plan.request.start(row);
        if let Some(start) = start
            && self.evolution.settings.start_weight > 0.0
        {
            copies.pull = Some((PULL, start.to_vec()));
        }
        let mut answers = Answers::new(count, dof);
        let mut all = Some(answers.as_mut());
        copies.run(self.level, &mut || all.take(), &mut || true);
        for q in answers.q.chunks_exact(dof) {
            self.q.copy_from_slice(q);
            self.consider(goal, start);
            // Without start values to stay near, the first that reaches is as good as any.
            let any = plan.request.guard().is_none_or(|guard| guard.prefer == Prefer::First);
            let first = plan.setup().aim.puts_position_first();
            if self.found.is_answer() && start.is_none() && any && !first {
                break;
            }
        }
    }

    /// Keeps the posture in `q` if it is the best so far: of those that reach the goal the
    /// nearest to the start values, of the others the one with the smallest error.
    fn consider(&mut self, goal: &Goal<f64>, start: Option<&[f64]>) {
        let plan = &self.evolution.plan;
        let most = plan.setup().well_known(goal);
        bring_near(&limits(plan), &mut self.q, start, most);
        forward(plan.request.chain().compiled(), &self.q, &mut self.workspace);
        let left = plan.request.left(&self.workspace, goal);
        let setup = plan.setup();
        let reached = setup.aim.is_met(&left);
        let (position2, orientation2) = (left.position2, left.orientation2);
        let squared = match start {
            _ if reached && setup.aim.puts_position_first() => orientation2,
            Some(start) if reached => {
                self.q.iter().zip(start).map(|(x, s)| (x - s) * (x - s)).sum()
            }
            _ => position2 + setup.rotation_scale * setup.rotation_scale * orientation2,
        };
        let guard = plan.request.guard().filter(|_| reached);
        let verdict = guard.map(|guard| {
            let variables = plan.request.chain().variables();
            let about = |i: usize| start.map_or(variables[i].middle(), |start| start[i]);
            guard.verdict(&self.q, squared, about)
        });
        let better = match (reached, self.found.reached) {
            (true, false) => true,
            (false, true) => false,
            (true, true) if verdict.is_some() => verdict > self.found.verdict,
            _ => squared < self.found.squared,
        };
        if better && squared.is_finite() {
            self.found.q.copy_from_slice(&self.q);
            self.found.squared = squared;
            self.found.reached = reached;
            self.found.verdict = verdict;
            self.found.position_error = position2.sqrt();
            self.found.orientation_error = orientation2.sqrt();
        }
    }
}
