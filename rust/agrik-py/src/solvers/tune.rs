//! The class `Tuner`: a search over a solver's gains, advanced from Python.

use std::sync::{Arc, Mutex, MutexGuard};

use agrik::call::{Goals, Tolerance};
use agrik::chain;
use agrik::solve::{StartRule, Step};
use agrik::tune::{Cost, Evolution, Family, Problem, Search, Shape, Swarm};
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::solver;
use crate::convert::{Floats, array, real, whole};
use crate::ik::signals::Signals;
use crate::robot::chain::Chain;
use crate::single_use::take_turn;
use crate::{errors, threads};

const SHAPES: [(&str, Shape); 3] =
    [("full", Shape::Full), ("diagonal", Shape::Diagonal), ("input", Shape::Input)];
const METHODS: [&str; 2] = ["pso", "cma"];

/// A search for gains that reach most training goals in the fewest steps.
#[pyclass(frozen, module = "agrik_fast._native")]
pub struct Tuner {
    chain: Arc<chain::Chain>,
    family: Family,
    /// The goals, those that cost the start most first.
    goals: GoalSet,
    start: StartRule,
    max_iterations: u32,
    tolerance: Tolerance,
    threads: usize,
    search: Mutex<Search>,
}

/// Training goals, of one kind.
enum GoalSet {
    /// Tool points, m.
    Points(Vec<[f64; 3]>),
    /// Poses, row by row.
    Poses(Vec<[f64; 16]>),
}

impl GoalSet {
    fn new(py: Python<'_>, floats: &Floats<'_>) -> PyResult<Self> {
        let values = floats.values()?;
        match floats.shape() {
            [count, 3] if *count > 0 => Ok(Self::Points(values.as_chunks().0.to_vec())),
            [count, 4, 4] if *count > 0 => Ok(Self::Poses(values.as_chunks().0.to_vec())),
            other => {
                let expected = "(n, 3) or (n, 4, 4), n > 0";
                Err(crate::convert::wrong_shape(py, "goals", other, expected))
            }
        }
    }

    fn goals(&self) -> Goals<'_> {
        match self {
            Self::Points(points) => Goals::Positions { points, direction: None },
            Self::Poses(poses) => Goals::Poses(poses),
        }
    }

    fn in_order(&self, order: &[usize]) -> Self {
        match self {
            Self::Points(points) => Self::Points(order.iter().map(|i| points[*i]).collect()),
            Self::Poses(poses) => Self::Poses(order.iter().map(|i| poses[*i]).collect()),
        }
    }

    /// Rows of the error.
    fn rows(&self) -> usize {
        match self {
            Self::Points(_) => 3,
            Self::Poses(_) => 6,
        }
    }
}

impl Tuner {
    fn problem(&self) -> Problem<'_> {
        Problem {
            chain: &self.chain,
            family: &self.family,
            goals: self.goals.goals(),
            start: self.start,
            max_iterations: self.max_iterations,
            tolerance: self.tolerance,
            cost: Cost::default(),
        }
    }

    fn search(&self) -> Option<MutexGuard<'_, Search>> {
        // A generation is taken over as a whole, so a panic in one leaves the last.
        take_turn(&self.search)
    }

    /// The search, read or changed by a caller who finds it idle.
    fn idle(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, Search>> {
        self.search().ok_or_else(|| busy(py))
    }
}

fn busy(py: Python<'_>) -> PyErr {
    errors::concurrent_use(py, "this tuner", "wait until its generation is done")
}

/// Joint values that move the tool point somewhere within the limits, or with all six rows
/// of the Jacobian the tool.
fn active(chain: &chain::Chain, rows: usize) -> Vec<bool> {
    let dof = chain.dof();
    let mut jacobian = vec![0.0; 6 * dof];
    let mut moves = vec![false; dof];
    for share in [0.21, 0.5, 0.77] {
        let value = |v: &chain::Variable| {
            let value = v.lower + share * (v.upper - v.lower);
            if value.is_finite() { value } else { 6.0 * share - 3.0 }
        };
        let q: Vec<f64> = chain.variables().iter().map(value).collect();
        agrik::kinematics::tool_jacobians(chain, &q, &mut jacobian);
        for (i, moves) in moves.iter_mut().enumerate() {
            *moves |= (0..rows).any(|k| jacobian[k * dof + i].abs() > 1e-9);
        }
    }
    moves
}

#[pymethods]
impl Tuner {
    /// Prepare a search.
    #[new]
    #[pyo3(signature = (
        chain, solver, goals, shape, method, population, sigma, seed, start, max_iterations,
        tolerance, orientation_tolerance=1e-6, threads=None
    ))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        chain: &Chain,
        solver: &Bound<'_, PyAny>,
        goals: &Bound<'_, PyAny>,
        shape: &str,
        method: &str,
        population: &Bound<'_, PyAny>,
        sigma: &Bound<'_, PyAny>,
        seed: &Bound<'_, PyAny>,
        start: &Bound<'_, PyAny>,
        max_iterations: &Bound<'_, PyAny>,
        tolerance: &Bound<'_, PyAny>,
        orientation_tolerance: f64,
        threads: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let chain = chain.core();
        let settings = solver::step_settings(Some(solver), chain.name())?;
        let Some((_, shape)) = SHAPES.into_iter().find(|(name, _)| *name == shape) else {
            return Err(errors::unknown_name(py, "shape", shape, &SHAPES.map(|(name, _)| name)));
        };
        let goals = GoalSet::new(py, &Floats::new("goals", goals)?)?;
        let family = Family::new(settings.step, shape, active(&chain, goals.rows()))
            .map_err(|error| errors::from_core(py, error))?;
        let members = whole("population", population, 4, 100_000)? as usize;
        let sigma = real("sigma", sigma)?;
        if !(sigma.is_finite() && sigma > 0.0) {
            return Err(errors::argument(py, "sigma", &sigma.to_string(), "a finite number > 0"));
        }
        let seed = whole("seed", seed, 0, u64::MAX)?;
        let first = family.start();
        let search = match method {
            "pso" => Search::Swarm(Swarm::new(&first, members, sigma, seed)),
            "cma" => Search::Evolution(Evolution::new(&first, members, sigma, seed)),
            other => return Err(errors::unknown_name(py, "method", other, &METHODS)),
        };
        let mut tuner = Self {
            chain,
            family,
            goals,
            start: solver::start_rule(start)?,
            max_iterations: whole("max_iterations", max_iterations, 1, u32::MAX.into())? as u32,
            tolerance: Tolerance {
                position: real("tolerance", tolerance)?,
                orientation: orientation_tolerance,
                axes: None,
            },
            threads: threads::number(threads, "threads")?,
            search: Mutex::new(search),
        };
        let mut signals = Signals::new();
        let mut go_on = || signals.go_on_detached();
        let order = py.detach(|| tuner.problem().hardest_first(&first, tuner.threads, &mut go_on));
        let order = order.map_err(|error| signals.exception(py, error))?;
        tuner.goals = tuner.goals.in_order(&order);
        Ok(tuner)
    }

    /// Go on by one generation.
    fn advance(&self, py: Python<'_>) -> PyResult<()> {
        let mut signals = Signals::new();
        let advanced = py.detach(|| {
            let (problem, threads) = (self.problem(), self.threads);
            let mut search = self.search()?;
            let mut go_on = || signals.go_on_detached();
            Some(search.advance(&mut |x, bound| problem.cost_below(x, bound, threads, &mut go_on)))
        });
        advanced.ok_or_else(|| busy(py))?.map_err(|error| signals.exception(py, error))
    }

    /// Number of parameters.
    #[getter]
    fn dimension(&self) -> usize {
        self.family.start().len()
    }

    /// Vectors judged so far.
    #[getter]
    fn evaluations(&self, py: Python<'_>) -> PyResult<u64> {
        Ok(self.idle(py)?.evaluations())
    }

    /// Cost of the best vector so far; infinite before the first generation.
    #[getter]
    fn cost(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.idle(py)?.best().map_or(f64::INFINITY, |(_, cost)| cost))
    }

    /// The best vector so far; the start before the first generation.
    #[getter]
    fn best<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let best = self.idle(py)?.best().map(|(x, _)| x.to_vec());
        let best = best.unwrap_or_else(|| self.family.start());
        array(py, &[best.len()], best)
    }

    /// Cost, goals reached and mean steps over these of a vector on the training goals.
    fn score(&self, py: Python<'_>, vector: &Bound<'_, PyAny>) -> PyResult<(f64, usize, f64)> {
        let x = Floats::of_shape("vector", vector, &[self.dimension()])?;
        let x = x.values()?;
        let mut signals = Signals::new();
        let score = py
            .detach(|| self.problem().score(x, self.threads, &mut || signals.go_on_detached()))
            .map_err(|error| signals.exception(py, error))?;
        Ok((score.cost, score.solved, score.steps))
    }

    /// The gains of a vector, in the units of the solver that the search started from.
    fn gains<'py>(
        &self,
        py: Python<'py>,
        vector: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let x = Floats::of_shape("vector", vector, &[self.dimension()])?;
        let gains = PyDict::new(py);
        let put = |name: &str, m: &agrik::solve::Matrix| {
            gains.set_item(name, array(py, &[m.rows(), m.columns], m.values.clone())?)
        };
        match self.family.step(x.values()?) {
            Step::IkPid(pid) => {
                gains.set_item("kp", pid.proportional)?;
                gains.set_item("ki", pid.integral)?;
                gains.set_item("kd", pid.derivative)?;
            }
            Step::StateSpace(Some(set)) => {
                put("A", &set.a)?;
                put("B", &set.b)?;
                put("C", &set.c)?;
            }
            Step::StaticGain(Some(set)) => put("K", &set.gain)?,
            _ => {}
        }
        Ok(gains)
    }

    /// Everything that changes while the search runs, as numbers.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let state = self.idle(py)?.state();
        array(py, &[state.len()], state)
    }

    /// Take up the search where `state` left it.
    fn restore(&self, state: &Bound<'_, PyAny>) -> PyResult<()> {
        let floats = Floats::new("state", state)?;
        self.idle(state.py())?
            .restore(floats.values()?)
            .map_err(|error| errors::from_core(state.py(), error))
    }
}
