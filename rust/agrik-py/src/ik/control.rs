//! A solver for one target at a time, made once and called from a control loop: what stays
//! the same from call to call is read once, and a call allocates nothing.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use agrik::call::{Answers, Goals, Starts, Status, solve_into};
use agrik::chain::Chain;
use agrik::lanes::Level;
use agrik::solve::Setup;
use numpy::{PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;

use super::arguments::Options;
use super::signals::Signals;
use super::targets::{Targets, first_not_rigid, not_rigid_error};
use crate::convert::{Floats, internal, numbers, wrong_shape};
use crate::errors;
use crate::solvers::solver::step_settings;

/// What a call writes: the last answer and the start that it was given.
struct Buffers {
    answers: Answers,
    start: Vec<f64>,
}

/// A solver for one target at a time; see `agrik_fast.Robot.solver`.
#[pyclass(frozen, module = "agrik_fast._native")]
pub struct TargetSolver {
    chain: Arc<Chain>,
    setup: Setup,
    /// Direction of the tool axis where targets are points, unit length.
    direction: Option<[f64; 3]>,
    seed: u64,
    first_index: u64,
    q: Py<PyArray1<f64>>,
    buffers: Mutex<Buffers>,
}

impl TargetSolver {
    /// A solver of a chain with the options of a call.
    pub fn new(
        py: Python<'_>,
        chain: Arc<Chain>,
        solver: Option<&Bound<'_, PyAny>>,
        options: Options,
    ) -> PyResult<Self> {
        let Options { direction, aim, seed, first_index, .. } = options;
        let settings = step_settings(solver, chain.name())?;
        let dof = chain.dof();
        let setup = Setup::new(&chain, aim, settings);
        Ok(Self {
            setup: setup.map_err(|error| errors::from_core(py, error))?,
            q: PyArray1::zeros(py, dof, false).unbind(),
            buffers: Mutex::new(Buffers { answers: Answers::new(1, dof), start: vec![0.0; dof] }),
            chain,
            direction,
            seed,
            first_index,
        })
    }

    fn lock(&self) -> MutexGuard<'_, Buffers> {
        // A panic while the lock was held left numbers behind, at worst old ones.
        self.buffers.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Copies a start of the right length.
    fn read_start(&self, q0: &Bound<'_, PyAny>, start: &mut [f64]) -> PyResult<()> {
        if let Ok(array) = q0.cast::<PyArray1<f64>>()
            && array.len() == start.len()
            && array.is_aligned()
        {
            for (i, x) in start.iter_mut().enumerate() {
                *x = array.get_owned(i).unwrap_or(f64::NAN);
            }
            return Ok(());
        }
        let array = numbers("q0", q0)?;
        if array.shape() != [start.len()] {
            let expected = format!("({},)", start.len());
            return Err(wrong_shape(q0.py(), "q0", array.shape(), &expected));
        }
        start.copy_from_slice(Floats::new("q0", array.as_any())?.values()?);
        Ok(())
    }
}

#[pymethods]
impl TargetSolver {
    /// Solve one target: a pose (4, 4) or a point (3,). Return whether it was reached.
    #[pyo3(signature = (target, q0=None))]
    fn solve(
        &self,
        py: Python<'_>,
        target: &Bound<'_, PyAny>,
        q0: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<bool> {
        let target = Targets::new(target, 1)?;
        if !target.leading_shape().is_empty() {
            let shape = target.leading_shape();
            return Err(wrong_shape(py, "target", shape, "(4, 4) or (3,), a single target"));
        }
        let values = target.values()?;
        let direction = self.direction;
        let mut buffers = self.lock();
        let Buffers { answers, start } = &mut *buffers;
        let starts = match q0 {
            None => Starts::Free,
            Some(q0) => {
                self.read_start(q0, start)?;
                Starts::One(start)
            }
        };
        let point;
        let goals = if target.are_poses() {
            let poses: &[[f64; 16]] = values.as_chunks().0;
            if let Some(row) = first_not_rigid(poses, 1) {
                return Err(not_rigid_error(py, &[], row, &poses[row]));
            }
            match direction {
                None => Goals::Poses(poses),
                direction => {
                    point = [[poses[0][3], poses[0][7], poses[0][11]]];
                    Goals::Positions { points: &point, direction }
                }
            }
        } else {
            Goals::Positions { points: values.as_chunks().0, direction }
        };
        let (seed, first_index) = (self.seed, self.first_index);
        let plan = self
            .setup
            .plan(&self.chain, goals, starts, seed, first_index)
            .map_err(|error| errors::from_core(py, error))?;
        let mut signals = Signals::new();
        solve_into(Level::in_use(), &plan, 1, answers, &mut || signals.go_on_attached(py))
            .map_err(|error| signals.exception(py, error))?;
        let mut q = self.q.bind(py).try_readwrite().map_err(internal)?;
        q.as_slice_mut().map_err(internal)?.copy_from_slice(&answers.q);
        Ok(answers.success(0))
    }

    /// Joint values of the last answer, shape (dof,), rad or m; overwritten by each call.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.q.bind(py).clone()
    }

    /// Whether the last target was reached, by a final FK check.
    #[getter]
    fn success(&self) -> bool {
        self.lock().answers.status[0] == Status::Converged as u8
    }

    /// Code of `agrik_fast.Status` of the last answer.
    #[getter]
    fn status(&self) -> u8 {
        self.lock().answers.status[0]
    }

    /// Distance of the tool point from the last target, m.
    #[getter]
    fn position_error(&self) -> f64 {
        self.lock().answers.position_error[0]
    }

    /// Angle left to the last target's orientation, rad.
    #[getter]
    fn orientation_error(&self) -> f64 {
        self.lock().answers.orientation_error[0]
    }

    /// Steps taken for the last answer, over all attempts.
    #[getter]
    fn iterations(&self) -> u32 {
        self.lock().answers.iterations[0]
    }

    /// Attempts after the first for the last answer.
    #[getter]
    fn restarts(&self) -> u32 {
        self.lock().answers.restarts[0]
    }
}
