//! Inverse kinematics calls: arguments in, interpreter released, record of answers out.
//!
//! A call has two halves: [`Options`], everything that stays the same from call to call
//! of a control loop, and the targets with their starts. A reusable solver object for
//! control loops keeps the first half and its buffers, and only takes the second.

use std::time::{Duration, Instant};

use agrik::chain::{Chain, Tail};
use agrik::closed_form::{self, ArmAngle, BRANCHES, Choice, ClosedForm, Query};
use agrik::solve::{Plan, Settings, Starts, Tolerance};
use agrik::{batch, task::Task};
use numpy::{PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

use crate::branches::Branches;
use crate::convert::{self, Floats, numbers, shape_text, transform};
use crate::result::IkResult;
use crate::solver::Solver;
use crate::targets::{Targets, first_not_rigid, goals, not_rigid_error};
use crate::{errors, solver, task, threads};

/// Time between two looks at pending signals of a call that has released the interpreter
/// and has to wait for it each time. Results do not depend on it.
const DETACHED_PERIOD: Duration = Duration::from_millis(50);
/// The same for a call that holds the interpreter, which others may be waiting for: as
/// long as Python itself lets a thread run.
const ATTACHED_PERIOD: Duration = Duration::from_millis(5);

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
struct Options {
    wanted: task::Wanted,
    solver: Solver,
    tolerance: Tolerance,
    tail: Option<Tail>,
    seed: u64,
    first_index: u64,
    threads: usize,
}

impl Options {
    fn new(chain: &Chain, given: &Arguments<'_, '_>, are_poses: bool) -> PyResult<Self> {
        let index = |name: &str, value: Option<&Bound<'_, PyAny>>| {
            value.map_or(Ok(0), |value| convert::whole(name, value, 0, u64::MAX))
        };
        let mut tolerance = Tolerance::default();
        if let Some(value) = given.position_tolerance {
            tolerance.position = convert::real("position_tolerance", value)?;
        }
        if let Some(value) = given.orientation_tolerance {
            tolerance.orientation = convert::real("orientation_tolerance", value)?;
        }
        let tail = match given.tool {
            None => None,
            Some(tool) => Some(chain.compiled().tail_with(&transform("tool", tool)?)),
        };
        Ok(Self {
            wanted: task::wanted(given.task, are_poses)?,
            solver: solver::solver(given.solver)?,
            tolerance,
            tail,
            seed: index("seed", given.seed)?,
            first_index: index("first_index", given.first_index)?,
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
    fn new(q0: Option<&Bound<'py, PyAny>>, leading: &[usize], dof: usize) -> PyResult<Self> {
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
        Ok(Self::Each(Floats::new("q0", &full)?))
    }

    fn starts(&self) -> PyResult<Starts<'_>> {
        Ok(match self {
            Self::Nothing => Starts::Free,
            Self::One(q) => Starts::One(q.values()?),
            Self::Each(q) => Starts::Each(q.values()?),
        })
    }
}

/// Refuses poses that are no rigid transforms.
fn check_rigid(py: Python<'_>, leading: &[usize], poses: &[[f64; 16]]) -> PyResult<()> {
    // Reading a long batch takes a while, during which others may run.
    let found =
        if poses.len() > 1 { py.detach(|| first_not_rigid(poses)) } else { first_not_rigid(poses) };
    match found {
        Some(row) => Err(not_rigid_error(py, leading, row, &poses[row])),
        None => Ok(()),
    }
}

/// Runs a call, without the interpreter where it may take long.
fn run<T: Send>(
    py: Python<'_>,
    rows: usize,
    threads: usize,
    work: impl FnOnce(usize, &mut dyn FnMut() -> bool) -> agrik::Result<T> + Send,
) -> PyResult<T> {
    let mut signals = Signals::new();
    let answers = if rows <= 1 {
        work(1, &mut || signals.go_on_attached(py))
    } else {
        py.detach(|| work(threads, &mut || signals.go_on_detached()))
    };
    answers.map_err(|error| signals.raised.unwrap_or_else(|| errors::from_core(py, error)))
}

/// All branches of the targets of a call.
pub fn solve_all(
    py: Python<'_>,
    chain: &Chain,
    given: &Arguments<'_, '_>,
    arm_angle: Option<&Bound<'_, PyAny>>,
) -> PyResult<Branches> {
    let targets = Targets::new(given.targets)?;
    let leading = targets.leading_shape();
    if !targets.are_poses() {
        let expected = "shape (..., 4, 4): closed forms take poses";
        let mut shape = leading.to_vec();
        shape.push(3);
        let received = format!("shape {}", shape_text(&shape));
        return Err(errors::argument(py, "targets", &received, expected));
    }
    let options = Options::new(chain, given, true)?;
    let q0 = Given::new(given.q0, leading, chain.dof())?;
    let angles = match arm_angle {
        None => None,
        Some(angle) => Some(spread("arm_angle", angle, leading)?),
    };
    let values = targets.values()?;
    let poses: &[[f64; 16]] = values.as_chunks().0;
    check_rigid(py, leading, poses)?;
    let plan = Plan::new(
        chain,
        Task::Pose,
        Settings::LEVENBERG_MARQUARDT,
        options.tolerance,
        agrik::solve::Goals::Poses(poses),
        q0.starts()?,
        options.tail,
        0,
        0,
    )
    .map_err(|error| errors::from_core(py, error))?;
    let angle = match &angles {
        None => ArmAngle::Free,
        Some(angles) => ArmAngle::Each(angles.values()?),
    };
    let query =
        Query::new(&plan, angle, Choice::default()).map_err(|e| errors::from_core(py, e))?;
    if plan.len() < MANY {
        let all = run(py, plan.len(), options.threads, |threads, poll| {
            closed_form::all(&query, threads, poll)
        })?;
        return Ok(Branches::new(leading.to_vec(), chain.dof(), all, None));
    }
    // NumPy asks for large pages, which makes filling fresh memory several times cheaper.
    let shape = [leading, &[BRANCHES, chain.dof()]].concat();
    let array = PyArrayDyn::<f64>::zeros(py, shape, false);
    let mut open = array.try_readwrite().map_err(convert::internal)?;
    let q = open.as_slice_mut().map_err(convert::internal)?;
    let all = run(py, plan.len(), options.threads, |threads, poll| {
        closed_form::all_into(&query, q, threads, poll)
    })?;
    drop(open);
    Ok(Branches::new(leading.to_vec(), chain.dof(), all, Some(array.unbind())))
}

/// Solves the targets of a call.
pub fn solve(py: Python<'_>, chain: &Chain, given: &Arguments<'_, '_>) -> PyResult<IkResult> {
    let targets = Targets::new(given.targets)?;
    let are_poses = targets.are_poses();
    let options = Options::new(chain, given, are_poses)?;
    let leading = targets.leading_shape();
    let q0 = Given::new(given.q0, leading, chain.dof())?;

    let values = targets.values()?;
    if are_poses {
        check_rigid(py, leading, values.as_chunks().0)?;
    }
    let mut points = Vec::new();
    let direction = options.wanted.direction;
    let plan = Plan::new(
        chain,
        options.wanted.task,
        match options.solver {
            Solver::Steps(settings) => settings,
            _ => Settings::LEVENBERG_MARQUARDT,
        },
        options.tolerance,
        goals(values, are_poses, direction, &mut points),
        q0.starts()?,
        options.tail,
        options.seed,
        options.first_index,
    )
    .map_err(|error| errors::from_core(py, error))?;

    let query = match options.solver {
        Solver::Steps(_) => None,
        Solver::ClosedForm { choice, arm_angle } => {
            let angle = arm_angle.map_or(ArmAngle::Free, ArmAngle::One);
            Some(Query::new(&plan, angle, choice).map_err(|error| errors::from_core(py, error))?)
        }
        Solver::Auto if plan.task().fixes_pose() && ClosedForm::of(chain).is_ok() => Some(
            Query::new(&plan, ArmAngle::Free, Choice::default())
                .map_err(|error| errors::from_core(py, error))?,
        ),
        Solver::Auto => None,
    };
    let answers = run(py, plan.len(), options.threads, |threads, poll| match &query {
        Some(query) => closed_form::best(query, threads, poll),
        None => batch::solve(&plan, threads, poll),
    })?;
    Ok(IkResult::new(leading.to_vec(), chain.dof(), answers))
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

/// Asks Python from time to time whether a signal (Ctrl-C) ends the call.
struct Signals {
    last: Instant,
    raised: Option<PyErr>,
}

impl Signals {
    fn new() -> Self {
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
    fn go_on_detached(&mut self) -> bool {
        !self.is_due(DETACHED_PERIOD) || Python::attach(|py| self.check(py))
    }

    /// For a short call that has not: lets the other threads have a turn as well.
    fn go_on_attached(&mut self, py: Python<'_>) -> bool {
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
