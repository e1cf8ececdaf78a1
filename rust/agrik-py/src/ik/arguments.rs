//! The arguments of a call, each read once.
//!
//! A call has two halves: [`Options`], everything that stays the same from call to call
//! of a control loop, and the targets with their starts. The solver object of `control`
//! keeps the first half and only takes the second. Who has a choice of solvers reads that
//! argument (`solvers::solver::chosen`).

use agrik::call::{Aim, Near, Request, Second, Starts, Tolerance};
use agrik::chain::{Chain, Tail};
use agrik::closed_form::ArmAngle;
use agrik::task::{MaskFrame, Task};
use numpy::{PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyFloat, PyString};

use super::straighten::{Invalid, Mended};
use super::targets::{Targets, first_not_rigid, goals, not_rigid_error};
use super::{second, task};
use crate::convert::{self, Floats, numbers, shape_text, transform};
use crate::{errors, threads};

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
    pub tolerance_frame: Option<&'a Bound<'py, PyAny>>,
    pub first_index: Option<&'a Bound<'py, PyAny>>,
    /// What becomes of poses that are no rigid transforms.
    pub invalid: Option<&'a Bound<'py, PyAny>>,
    /// What the freedom of answers is used for.
    pub second_aim: Option<&'a Bound<'py, PyAny>>,
}

/// What the targets of a call share.
pub struct Options {
    /// Direction of the tool axis that all targets of an axis task share, if they do.
    pub direction: Option<[f64; 3]>,
    pub aim: Aim,
    pub seed: u64,
    pub first_index: u64,
    /// 0: the number in force.
    pub threads: usize,
    pub second: Option<Second>,
}

impl Options {
    #[inline(always)]
    pub fn new(chain: &Chain, given: &Arguments<'_, '_>, are_poses: bool) -> PyResult<Self> {
        let py = given.targets.py();
        let wanted = task::wanted(given.task, are_poses)?;
        let tolerance = tolerance(given, &wanted.task)?;
        let tail = tail(chain, given.tool)?;
        let aim = Aim::new(chain, wanted.task, tolerance, tail);
        Ok(Self {
            direction: wanted.direction,
            aim: aim.map_err(|error| errors::from_core(py, error))?,
            seed: convert::index("seed", given.seed)?,
            first_index: convert::index("first_index", given.first_index)?,
            threads: threads::number(given.threads, "threads")?,
            second: second::second(chain, given.second_aim)?,
        })
    }
}

/// Joint values that need no memory from the heap.
const FEW: usize = 16;

/// Start values as they came, in memory of our own.
enum Given<'py> {
    Nothing,
    Few([f64; FEW], usize),
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
        let mut few = [0.0; FEW];
        if few.get_mut(..dof).is_some_and(|few| read_doubles(q0, few)) {
            return Ok(Self::Few(few, dof));
        }
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
            Self::Few(q, dof) => Starts::One(&q[..*dof]),
            Self::One(q) => Starts::One(q.values()?),
            Self::Each(q) => Starts::Each(q.values()?),
        })
    }
}

/// Numbers of an argument that has one for all joints, or one for each.
pub fn each_joint(argument: &str, value: &Bound<'_, PyAny>, dof: usize) -> PyResult<Vec<f64>> {
    match convert::real(argument, value) {
        Ok(one) => Ok(vec![one; dof]),
        Err(_) => Ok(Floats::of_shape(argument, value, &[dof])?.values()?.to_vec()),
    }
}

/// Reads an array of just as many doubles without a detour over NumPy's functions; false for
/// anything else.
pub fn read_doubles(q0: &Bound<'_, PyAny>, to: &mut [f64]) -> bool {
    let Ok(array) = q0.cast::<PyArray1<f64>>() else { return false };
    if array.len() != to.len() || !array.is_aligned() {
        return false;
    }
    for (i, x) in to.iter_mut().enumerate() {
        *x = array.get_owned(i).unwrap_or(f64::NAN);
    }
    true
}

/// A call's arguments in memory of their own, checked, from which its request is made.
pub struct Call<'py> {
    pub targets: Targets<'py>,
    pub options: Options,
    q0: Given<'py>,
    /// The poses in place of those that came, where some are no rigid transforms.
    mended: Option<Box<Mended>>,
}

impl<'py> Call<'py> {
    // In place of its caller: it is long, and would be moved about.
    #[inline(always)]
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
                let invalid = Invalid::new(given.invalid)?;
                if invalid == Invalid::Raise {
                    return Err(not_rigid_error(py, leading, row, &poses[row]));
                }
                let mended = py.detach(|| Box::new(Mended::new(poses, invalid)));
                return Ok(Self { targets, options, q0, mended: Some(mended) });
            }
        }
        if given.invalid.is_some() {
            Invalid::new(given.invalid)?;
        }
        Ok(Self { targets, options, q0, mended: None })
    }

    /// A code a row of what is to be said of targets; empty where there is nothing.
    pub fn warnings(&self) -> Vec<u8> {
        self.mended.as_ref().map_or_else(Vec::new, |mended| mended.warnings.clone())
    }

    /// The request; `points` holds what it needs besides the arguments.
    pub fn request<'a>(
        &'a self,
        py: Python<'_>,
        chain: &'a Chain,
        points: &'a mut Vec<[f64; 3]>,
    ) -> PyResult<Request<'a>> {
        let Options { direction, aim, seed, first_index, second, .. } = &self.options;
        let are_poses = self.targets.are_poses();
        let values = match &self.mended {
            Some(mended) => &mended.poses[..],
            None => self.targets.values()?,
        };
        let goals = goals(values, are_poses, *direction, points);
        let request = Request::new(chain, *aim, goals, self.q0.starts()?)
            .map(|request| request.with_seed(*seed, *first_index))
            .map_err(|error| errors::from_core(py, error))?;
        Ok(match second {
            Some(second) => request.with_second(second),
            None => request,
        })
    }
}

/// The tool of a call, if it has one of its own.
pub fn tail(chain: &Chain, tool: Option<&Bound<'_, PyAny>>) -> PyResult<Option<Tail>> {
    match tool {
        None => Ok(None),
        Some(tool) => Ok(Some(chain.compiled().tail_with(&transform("tool", tool)?))),
    }
}

#[inline(always)]
fn tolerance(given: &Arguments<'_, '_>, task: &Task) -> PyResult<Tolerance> {
    let usual = Tolerance::default();
    let position = near("position_tolerance", given.position_tolerance, usual.position)?;
    let orientation =
        near("orientation_tolerance", given.orientation_tolerance, usual.orientation)?;
    if let (Near::Whole(position), Near::Whole(orientation), None) =
        (position, orientation, given.tolerance_frame)
    {
        return Ok(Tolerance { position, orientation, ..usual });
    }
    let frame = match (given.tolerance_frame, task) {
        (Some(frame), _) => task::frame("tolerance_frame", frame)?,
        (None, Task::Masked { frame, .. }) => *frame,
        (None, _) => MaskFrame::Base,
    };
    Ok(match (position, orientation) {
        (Near::Whole(position), Near::Whole(orientation)) => {
            Tolerance { position, orientation, ..usual }
        }
        _ => Tolerance::by_axis(position, orientation, frame)
            .map_err(|error| errors::from_core(given.targets.py(), error))?,
    })
}

/// A tolerance: a number, or three of them, one for each axis.
#[inline(always)]
fn near(argument: &str, value: Option<&Bound<'_, PyAny>>, usual: f64) -> PyResult<Near> {
    let Some(value) = value else { return Ok(Near::Whole(usual)) };
    match value.cast_exact::<PyFloat>() {
        Ok(number) => Ok(Near::Whole(number.value())),
        Err(_) => near_in_general(argument, value),
    }
}

#[inline(never)]
fn near_in_general(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<Near> {
    // What has a length is no single number; a lone one may be of any type.
    if value.len().is_err() || value.is_instance_of::<PyString>() {
        return convert::real(argument, value).map(Near::Whole);
    }
    let floats = Floats::new(argument, value)?;
    match *floats.values()? {
        [x, y, z] if floats.shape() == [3] => Ok(Near::Each([x, y, z])),
        _ => {
            let received = format!("shape {}", shape_text(floats.shape()));
            let expected = "one number, or three: one for each axis, shape (3,)";
            Err(errors::argument(value.py(), argument, &received, expected))
        }
    }
}

/// Arm angles as they came: none, one for all targets, or one a target.
pub enum ArmAngles<'py> {
    Free,
    One(f64),
    Each(Floats<'py>),
}

impl<'py> ArmAngles<'py> {
    pub fn new(angle: Option<&Bound<'py, PyAny>>, leading: &[usize]) -> PyResult<Self> {
        let Some(angle) = angle else { return Ok(Self::Free) };
        if let Ok(angle) = angle.cast_exact::<PyFloat>() {
            return Ok(Self::One(angle.value()));
        }
        Ok(Self::Each(spread("arm_angle", angle, leading)?))
    }

    pub fn values(&self) -> PyResult<ArmAngle<'_>> {
        Ok(match self {
            Self::Free => ArmAngle::Free,
            Self::One(angle) => ArmAngle::One(*angle),
            Self::Each(angles) => ArmAngle::Each(angles.values()?),
        })
    }
}

/// Numbers of an argument that broadcasts to the targets' leading shape.
pub fn spread<'py>(
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
