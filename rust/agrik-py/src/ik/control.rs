//! A solver for one target at a time, made once and called from a control loop: what stays
//! the same from call to call is read once, and a call allocates nothing.
//!
//! One caller at a time: a call that meets another one at work is refused, for it may be
//! that other call itself that waits for it (in a signal handler, or for the interpreter).

use std::sync::atomic::{AtomicU8, AtomicU32, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex};

use agrik::call::{Answers, Goals, Starts, Status, solve_into};
use agrik::chain::Chain;
use agrik::lanes::Level;
use agrik::solve::{Setup, Tracker};
use numpy::{PyArray1, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyString;
use smallvec::{SmallVec, smallvec};

use super::arguments::{Options, each_joint, read_doubles};
use super::signals::Signals;
use super::straighten::{Invalid, Mended};
use super::targets::{Targets, first_not_rigid};
use crate::convert::{Floats, numbers, wrong_shape};
use crate::errors;
use crate::records::hand_on;
use crate::single_use::take_turn;
use crate::solvers::solver::step_settings;

/// Start values, without memory from the heap where there are few.
type Start = SmallVec<[f64; 16]>;

/// The last answer. Read without a lock: who reads may be a signal
/// handler, or another thread that holds the interpreter, while a call is at work.
struct Last {
    status: AtomicU8,
    /// Bits of the joint values.
    q: Box<[AtomicU64]>,
    /// Bits of the errors, m and rad.
    position_error: AtomicU64,
    orientation_error: AtomicU64,
    iterations: AtomicU32,
    restarts: AtomicU32,
}

impl Last {
    fn new(answers: &Answers) -> Self {
        let last = Self {
            status: AtomicU8::default(),
            q: answers.q.iter().map(|_| AtomicU64::default()).collect(),
            position_error: AtomicU64::default(),
            orientation_error: AtomicU64::default(),
            iterations: AtomicU32::default(),
            restarts: AtomicU32::default(),
        };
        last.set(answers);
        last
    }

    fn set(&self, answers: &Answers) {
        self.status.store(answers.status[0], Relaxed);
        for (to, from) in self.q.iter().zip(&answers.q) {
            to.store(from.to_bits(), Relaxed);
        }
        self.position_error.store(answers.position_error[0].to_bits(), Relaxed);
        self.orientation_error.store(answers.orientation_error[0].to_bits(), Relaxed);
        self.iterations.store(answers.iterations[0], Relaxed);
        self.restarts.store(answers.restarts[0], Relaxed);
    }
}

/// How a target is solved.
enum Work {
    /// By itself.
    Alone(Setup),
    /// As a tick of a loop whose joints change by no more than a bound; with it the answer to
    /// the first tick, where nobody says where the arm stands.
    Loop(Setup, Box<Mutex<Tracker>>),
}

/// A solver for one target at a time; see `agrik_fast.Robot.solver`.
#[pyclass(frozen, module = "agrik_fast._native")]
pub struct TargetSolver {
    chain: Arc<Chain>,
    work: Work,
    /// Direction of the tool axis where targets are points, unit length.
    direction: Option<[f64; 3]>,
    seed: u64,
    first_index: u64,
    answers: Mutex<Answers>,
    last: Last,
    /// How to make the same solver again: a function and its arguments.
    recipe: Option<Py<PyAny>>,
}

impl TargetSolver {
    /// A solver of a chain with the options of a call.
    pub fn new(
        py: Python<'_>,
        chain: Arc<Chain>,
        solver: Option<&Bound<'_, PyAny>>,
        options: Options,
        max_change: Option<&Bound<'_, PyAny>>,
        recipe: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let Options { direction, aim, seed, first_index, second, .. } = options;
        let settings = step_settings(solver, chain.name())?;
        let from_core = |error| errors::from_core(py, error);
        let mut setup = Setup::new(&chain, aim, settings.clone()).map_err(from_core)?;
        if let Some(second) = &second {
            setup = setup.with_second(second.clone());
        }
        let work = match max_change {
            None => Work::Alone(setup),
            Some(most) => {
                let most = each_joint("max_change", most, chain.dof())?;
                let tracker =
                    Tracker::new(&chain, aim, settings, most, second).map_err(from_core)?;
                Work::Loop(setup, Box::new(Mutex::new(tracker)))
            }
        };
        let answers = Answers::new(1, chain.dof());
        Ok(Self {
            work,
            last: Last::new(&answers),
            recipe,
            answers: Mutex::new(answers),
            chain,
            direction,
            seed,
            first_index,
        })
    }

    /// A copy of a start of the right length.
    fn start(&self, q0: &Bound<'_, PyAny>) -> PyResult<Start> {
        let mut start: Start = smallvec![0.0; self.chain.dof()];
        if read_doubles(q0, &mut start) {
            return Ok(start);
        }
        let array = numbers("q0", q0)?;
        if array.shape() != [start.len()] {
            let expected = format!("({},)", start.len());
            return Err(wrong_shape(q0.py(), "q0", array.shape(), &expected));
        }
        start.copy_from_slice(Floats::new("q0", array.as_any())?.values()?);
        Ok(start)
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
        // Arguments first: to read them may run code of the caller, which may come back here.
        let start = q0.map(|q0| self.start(q0)).transpose()?;
        let starts = start.as_ref().map_or(Starts::Free, |start| Starts::One(start));
        let (point, mended);
        let goals = if target.are_poses() {
            let poses: &[[f64; 16]] = values.as_chunks().0;
            let mut poses = poses;
            if first_not_rigid(poses, 1).is_some() {
                mended = Mended::new(poses, Invalid::Mark);
                poses = mended.poses.as_chunks().0;
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
        let busy = || {
            let instead = "make one for each thread with Robot.solver";
            errors::concurrent_use(py, "this solver", instead)
        };
        let mut answers = take_turn(&self.answers).ok_or_else(busy)?;
        let mut signals = Signals::new();
        let (level, at) = (Level::in_use(), (seed, first_index));
        let setup = match &self.work {
            Work::Alone(setup) => setup,
            Work::Loop(setup, tracker) => {
                let mut tracker = take_turn(tracker).ok_or_else(busy)?;
                if let Some(start) = &start {
                    tracker.stand(start);
                }
                if tracker.has_started() {
                    tracker
                        .tick(level, &self.chain, goals, at, &mut answers)
                        .map_err(|error| errors::from_core(py, error))?;
                    self.last.set(&answers);
                    return Ok(answers.success(0));
                }
                setup
            }
        };
        let plan = setup
            .plan(&self.chain, goals, starts, seed, first_index)
            .map_err(|error| errors::from_core(py, error))?;
        solve_into(level, &plan, 1, &mut answers, &mut || signals.go_on_attached(py))
            .map_err(|error| signals.exception(py, error))?;
        if let Work::Loop(_, tracker) = &self.work
            && answers.status[0] != Status::BadInput as u8
        {
            take_turn(tracker).ok_or_else(busy)?.stand(&answers.q);
        }
        self.last.set(&answers);
        Ok(answers.success(0))
    }

    /// Joint values of the last answer, shape (dof,), rad or m; a copy.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let q: Start = self.last.q.iter().map(|bits| f64::from_bits(bits.load(Relaxed))).collect();
        PyArray1::from_slice(py, &q)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        match &slf.get().recipe {
            Some(recipe) => Ok(recipe.bind(slf.py()).clone()),
            None => Err(PyTypeError::new_err("a solver is pickled with the robot that made it")),
        }
    }

    /// Whether the last target was reached, by a final FK check.
    #[getter]
    fn success(&self) -> bool {
        self.last.status.load(Relaxed) == Status::Converged as u8
    }

    /// Code of `agrik_fast.Status` of the last answer.
    #[getter]
    fn status(&self) -> u8 {
        self.last.status.load(Relaxed)
    }

    /// Distance of the tool point from the last target, m.
    #[getter]
    fn position_error(&self) -> f64 {
        f64::from_bits(self.last.position_error.load(Relaxed))
    }

    /// Angle left to the last target's orientation, rad.
    #[getter]
    fn orientation_error(&self) -> f64 {
        f64::from_bits(self.last.orientation_error.load(Relaxed))
    }

    /// Steps taken for the last answer, over all attempts.
    #[getter]
    fn iterations(&self) -> u32 {
        self.last.iterations.load(Relaxed)
    }

    /// Attempts after the first for the last answer.
    #[getter]
    fn restarts(&self) -> u32 {
        self.last.restarts.load(Relaxed)
    }

    /// The last answer as a record of its own.
    #[getter]
    fn result<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        hand_on(slf, "last_answer", &[])
    }

    /// Return the last answer's arrays by their names.
    fn to_dict<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        hand_on(&Self::result(slf)?, "to_dict", &[])
    }

    /// Return the last answer as a `pyarrow.Table` of one row.
    fn to_arrow<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        hand_on(&Self::result(slf)?, "to_arrow", &[])
    }

    /// Return the last answer as a `pandas.DataFrame` of one row.
    fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        hand_on(&Self::result(slf)?, "to_pandas", &[])
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        hand_on(&Self::result(slf)?, "html_table", &[])
    }

    fn __repr__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let kind = match slf.get().work {
            Work::Alone(_) => "",
            Work::Loop(..) => "a loop, ",
        };
        let head = format!("{}, {kind}", slf.get().chain.name());
        hand_on(slf, "text_of_solver", &[PyString::new(slf.py(), &head).into_any()])
    }
}
