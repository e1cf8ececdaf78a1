//! Inverse kinematics calls: arguments in, interpreter released, record of answers out.
//!
//! A call has two halves: [`Options`], everything that stays the same from call to call
//! of a control loop, and the targets with their starts. The solver object of `control`
//! keeps the first half and only takes the second.

use std::time::{Duration, Instant};

use agrik::batch;
use agrik::chain::{Chain, Tail};
use agrik::closed_form::{self, ArmAngle, BRANCHES, Choice, ClosedForm, Query};
use agrik::lanes::Level;
use agrik::solve::population::Evolution;
use agrik::solve::{Answers, Plan, Settings, Solve, Starts, Tolerance};
use numpy::{PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

use crate::branches::Branches;
use crate::convert::{self, Floats, numbers, shape_text};
use crate::result::IkResult;
use crate::solver::{self, Chosen};
use crate::targets::{Targets, first_not_rigid, goals, not_rigid_error};
use crate::{errors, single, task, threads};

/// Time between two looks at pending signals of a call that has released the interpreter
/// and has to wait for it each time. Results do not depend on it.
const DETACHED_PERIOD: Duration = Duration::from_millis(50);
/// The same for a call that holds the interpreter, which others may be waiting for. Several
/// times the 5 ms after which a waiting thread asks for its turn: let go before it has
/// asked, the interpreter would be taken back at once.
const ATTACHED_PERIOD: Duration = Duration::from_millis(20);

/// Targets from which on all branches are written to an array of NumPy's.
const MANY: usize = 1024;

/// Arguments of a call as Python gave them.
pub struct Arguments<'a, 'py> {
    pub targets: &'a Bound<'py, PyAny>,
    pub task: Option<&'a Bound<'py, PyAny>>,
    pub solver: Option<&'a Bound<'py, PyAny>>,
    pub q0: Option<&'a Bound<'py, PyAny>>,
    pub seed: Option<&'a Bound<'py, PyAny>>,
    pub tool: Option<&'a Bound<'py, PyAny>>,
    pub threads: Option<&'a Bound<'py, PyAny>>,
    pub position_tolerance: Option<&'a Bound<'py, PyAny>>,
    pub orientation_tolerance: Option<&'a Bound<'py, PyAny>>,
    pub first_index: Option<&'a Bound<'py, PyAny>>,
}

/// What the targets of a call share.
pub struct Options {
    pub wanted: task::Wanted,
    pub solver: Chosen,
    pub tolerance: Tolerance,
    pub tail: Option<Tail>,
    pub seed: u64,
    pub first_index: u64,
    threads: usize,
}

impl Options {
    pub fn new(chain: &Chain, given: &Arguments<'_, '_>, are_poses: bool) -> PyResult<Self> {
        Ok(Self {
            wanted: task::wanted(given.task, are_poses)?,
            solver: solver::chosen(given.solver, chain.name())?,
            tolerance: single::tolerance(given)?,
            tail: single::tail(chain, given)?,
            seed: convert::index("seed", given.seed)?,
            first_index: convert::index("first_index", given.first_index)?,
            threads: threads::number(given.threads, "threads")?,
        })
    }
}

/// Start values as they came, in memory of our own.
enum Given<'py> {
    Nothing,
    One(Floats<'py>),
    Each(Floats<'py>),
}

impl<'py> Given<'py> {
    fn new(
        q0: Option<&Bound<'py, PyAny>>,
        leading: &[usize],
        dof: usize,
        threads: usize,
    ) -> PyResult<Self> {
        static BROADCAST_TO: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
        let Some(q0) = q0 else {
            return Ok(Self::Nothing);
        };
        let py = q0.py();
        let array = numbers("q0", q0)?;
        if array.shape() == [dof] {
            return Ok(Self::One(Floats::new("q0", array.as_any())?));
        }
        let mut shape = leading.to_vec();
        shape.push(dof);
        let refuse = || {
            let expected = format!("({dof},), or one that broadcasts to {}", shape_text(&shape));
            convert::wrong_shape(py, "q0", array.shape(), &expected)
        };
        // Broadcasting would also stretch a last dimension of 1.
        if array.shape().last() != Some(&dof) {
            return Err(refuse());
        }
        let broadcast_to = BROADCAST_TO.import(py, "numpy", "broadcast_to")?;
        let full = broadcast_to.call1((&array, &shape)).map_err(|_| refuse())?;
        Ok(Self::Each(Floats::many("q0", &full, threads)?))
    }

    fn starts(&self) -> PyResult<Starts<'_>> {
        Ok(match self {
            Self::Nothing => Starts::Free,
            Self::One(q) => Starts::One(q.values()?),
            Self::Each(q) => Starts::Each(q.values()?),
        })
    }
}

/// A call's arguments in memory of their own, checked, from which its plan is made.
pub struct Call<'py> {
    pub targets: Targets<'py>,
    options: Options,
    q0: Given<'py>,
}

impl<'py> Call<'py> {
    pub fn new(py: Python<'py>, chain: &Chain, given: &Arguments<'_, 'py>) -> PyResult<Self> {
        let threads = threads::number(given.threads, "threads")?;
        let targets = Targets::new(given.targets, threads)?;
        let are_poses = targets.are_poses();
        let options = Options::new(chain, given, are_poses)?;
        let leading = targets.leading_shape();
        let q0 = Given::new(given.q0, leading, chain.dof(), threads)?;
        if are_poses {
            let poses: &[[f64; 16]] = targets.values()?.as_chunks().0;
            // Reading a long batch takes a while, during which others may run.
            let found = if poses.len() > 1 {
                py.detach(|| first_not_rigid(poses, threads))
            } else {
                first_not_rigid(poses, 1)
            };
            if let Some(row) = found {
                return Err(not_rigid_error(py, leading, row, &poses[row]));
            }
        }
        Ok(Self { targets, options, q0 })
    }

    pub fn plan<'a>(
        &'a self,
        py: Python<'_>,
        chain: &'a Chain,
        points: &'a mut Vec<[f64; 3]>,
    ) -> PyResult<Plan<'a>> {
        let options = &self.options;
        let settings = match &options.solver {
            Chosen::Step(settings) => settings.clone(),
            _ => Settings::LEVENBERG_MARQUARDT,
        };
        let direction = options.wanted.direction;
        let are_poses = self.targets.are_poses();
        Plan::new(
            chain,
            options.wanted.task,
            settings,
            options.tolerance,
            goals(self.targets.values()?, are_poses, direction, points),
            self.q0.starts()?,
            options.tail,
            options.seed,
            options.first_index,
        )
        .map_err(|error| errors::from_core(py, error))
    }
}

/// Solves the targets of a call.
pub fn solve(py: Python<'_>, chain: &Chain, given: &Arguments<'_, '_>) -> PyResult<IkResult> {
    if let Some(found) = single::best(py, chain, given)? {
        return Ok(found);
    }
    let call = Call::new(py, chain, given)?;
    let mut points = Vec::new();
    let plan = call.plan(py, chain, &mut points)?;
    let leading = call.targets.leading_shape().to_vec();
    let threads = call.options.threads;
    let mut signals = Signals::new();
    let closed = match &call.options.solver {
        Chosen::ClosedForm { choice, arm_angle, proof } => {
            Some((arm_angle.map_or(ArmAngle::Free, ArmAngle::One), *choice, *proof))
        }
        Chosen::Auto if plan.task().fixes_pose() && ClosedForm::of(chain).is_ok() => {
            Some((ArmAngle::Free, Choice::default(), false))
        }
        _ => None,
    };
    let query = match closed {
        None => None,
        Some((angle, choice, proof)) => {
            let query = Query::new(&plan, angle, choice);
            let query = query.map_err(|error| errors::from_core(py, error))?;
            Some(if proof { query.with_proof() } else { query })
        }
    };
    let answers = match (&call.options.solver, &query) {
        (_, Some(query)) if plan.len() <= 1 => {
            batch::solve(query, 1, &mut || signals.go_on_attached(py))
        }
        (_, Some(query)) => detached(py, query, threads, &mut signals),
        (Chosen::Population(settings), _) => {
            let evolution = Evolution::new(plan.clone(), *settings)
                .map_err(|error| errors::from_core(py, error))?;
            detached(py, &evolution, threads, &mut signals)
        }
        _ if plan.len() <= 1 => batch::solve(&plan, 1, &mut || signals.go_on_attached(py)),
        _ => detached(py, &plan, threads, &mut signals),
    };
    match answers {
        Ok(answers) => Ok(IkResult::new(leading, chain.dof(), answers)),
        Err(error) => Err(signals.raised.unwrap_or_else(|| errors::from_core(py, error))),
    }
}

/// All branches of the targets of a call.
pub fn solve_all<'py>(
    py: Python<'py>,
    chain: &Chain,
    given: &Arguments<'_, 'py>,
    arm_angle: Option<&Bound<'py, PyAny>>,
) -> PyResult<Branches> {
    if let Some(found) = single::all(py, chain, given, arm_angle)? {
        return Ok(found);
    }
    let call = Call::new(py, chain, given)?;
    let leading = call.targets.leading_shape();
    if !call.targets.are_poses() {
        let expected = "shape (..., 4, 4): closed forms take poses";
        let received = format!("shape {}", shape_text(&[leading, &[3]].concat()));
        return Err(errors::argument(py, "targets", &received, expected));
    }
    let angles = match arm_angle {
        None => None,
        Some(angle) => Some(spread("arm_angle", angle, leading)?),
    };
    let angle = match &angles {
        None => ArmAngle::Free,
        Some(angles) => ArmAngle::Each(angles.values()?),
    };
    let mut points = Vec::new();
    let plan = call.plan(py, chain, &mut points)?;
    let query =
        Query::new(&plan, angle, Choice::default()).map_err(|e| errors::from_core(py, e))?;
    let threads = call.options.threads;
    let mut signals = Signals::new();
    let all = if plan.len() <= 1 {
        closed_form::all(&query, 1, &mut || signals.go_on_attached(py)).map(|all| (all, None))
    } else if plan.len() < MANY {
        py.detach(|| closed_form::all(&query, threads, &mut || signals.go_on_detached()))
            .map(|all| (all, None))
    } else {
        // NumPy asks for large pages, which makes filling fresh memory several times cheaper.
        let shape = [leading, &[BRANCHES, chain.dof()]].concat();
        let array = PyArrayDyn::<f64>::zeros(py, shape, false);
        let mut open = array.try_readwrite().map_err(convert::internal)?;
        let q = open.as_slice_mut().map_err(convert::internal)?;
        let all = py
            .detach(|| closed_form::all_into(&query, q, threads, &mut || signals.go_on_detached()));
        drop(open);
        all.map(|all| (all, Some(array.unbind())))
    };
    match all {
        Ok((all, q)) => Ok(Branches::new(leading.to_vec(), chain.dof(), all, q)),
        Err(error) => Err(signals.raised.unwrap_or_else(|| errors::from_core(py, error))),
    }
}

/// Numbers of an argument that broadcasts to the targets' leading shape.
fn spread<'py>(
    argument: &str,
    value: &Bound<'py, PyAny>,
    leading: &[usize],
) -> PyResult<Floats<'py>> {
    static BROADCAST_TO: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let py = value.py();
    let array = numbers(argument, value)?;
    let broadcast_to = BROADCAST_TO.import(py, "numpy", "broadcast_to")?;
    let full = broadcast_to.call1((&array, leading.to_vec())).map_err(|_| {
        let expected = format!("{}, or one that broadcasts to it", shape_text(leading));
        convert::wrong_shape(py, argument, array.shape(), &expected)
    })?;
    Floats::new(argument, &full)
}

fn detached(
    py: Python<'_>,
    call: &impl Solve,
    threads: usize,
    signals: &mut Signals,
) -> agrik::Result<Answers> {
    py.detach(|| batch::solve(call, threads, &mut || signals.go_on_detached()))
}

/// The best cost of the first run of a population solver, generation by generation, for
/// the first target of a call.
pub fn cost_history(
    py: Python<'_>,
    chain: &Chain,
    given: &Arguments<'_, '_>,
) -> PyResult<Vec<f64>> {
    let call = Call::new(py, chain, given)?;
    let mut points = Vec::new();
    let plan = call.plan(py, chain, &mut points)?;
    let Chosen::Population(settings) = call.options.solver else {
        return Err(errors::argument(py, "solver", "a step solver", "a population solver"));
    };
    if plan.len() != 1 {
        let received = format!("{} targets", plan.len());
        return Err(errors::argument(py, "targets", &received, "one target"));
    }
    Evolution::new(plan, settings)
        .and_then(|evolution| py.detach(|| evolution.trace(Level::in_use(), 0)))
        .map_err(|error| errors::from_core(py, error))
}

/// Asks Python from time to time whether a signal (Ctrl-C) ends the call.
pub struct Signals {
    last: Instant,
    pub raised: Option<PyErr>,
}

impl Signals {
    pub fn new() -> Self {
        Self { last: Instant::now(), raised: None }
    }

    fn is_due(&mut self, period: Duration) -> bool {
        let due = self.last.elapsed() >= period;
        if due {
            self.last = Instant::now();
        }
        due
    }

    /// For a call that has released the interpreter.
    pub fn go_on_detached(&mut self) -> bool {
        !self.is_due(DETACHED_PERIOD) || Python::attach(|py| self.check(py))
    }

    /// For a short call that has not: lets the other threads have a turn as well.
    pub fn go_on_attached(&mut self, py: Python<'_>) -> bool {
        if !self.is_due(ATTACHED_PERIOD) {
            return true;
        }
        py.detach(|| ());
        self.check(py)
    }

    fn check(&mut self, py: Python<'_>) -> bool {
        match py.check_signals() {
            Ok(()) => true,
            Err(error) => {
                self.raised = Some(error);
                false
            }
        }
    }
}
