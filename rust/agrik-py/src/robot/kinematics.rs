//! Forward kinematics and Jacobians of arrays of joint values.

use agrik::call::{Aim, Goals, Request, Starts, Tolerance};
use agrik::chain::Chain;
use agrik::closed_form::{ClosedForm, arm_angle};
use agrik::kinematics::{tool_jacobians, tool_poses};
use agrik::task::Task;
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::convert::{Floats, array, check_dimensions, numbers, transform, wrong_shape};
use crate::errors;
use crate::ik::arguments::tail;

/// Rows from which on the interpreter is released.
const MANY: usize = 256;
/// Rows between two looks at pending signals (Ctrl-C), a few hundredths of a second.
const BETWEEN_SIGNAL_CHECKS: usize = 32_768;

/// Joint values of an argument, in memory of our own.
pub enum JointValues<'py> {
    Lone(Vec<f64>),
    Many(Floats<'py>),
}

impl<'py> JointValues<'py> {
    pub fn new(q: &Bound<'py, PyAny>, dof: usize) -> PyResult<Self> {
        if let Ok(one) = q.cast::<PyArray1<f64>>()
            && one.len() == dof
            && one.is_aligned()
        {
            return Ok(Self::Lone((0..dof).filter_map(|i| one.get_owned(i)).collect()));
        }
        let given = numbers("q", q)?;
        if given.shape().last() != Some(&dof) {
            let expected = format!("(..., {dof})");
            return Err(wrong_shape(q.py(), "q", given.shape(), &expected));
        }
        Ok(Self::Many(Floats::new("q", given.as_any())?))
    }

    pub fn values(&self) -> PyResult<&[f64]> {
        match self {
            Self::Lone(values) => Ok(values),
            Self::Many(floats) => floats.values(),
        }
    }

    /// The leading shape, with the dimensions of one answer behind it.
    pub fn shape_with(&self, answer: &[usize]) -> Vec<usize> {
        let leading = match self {
            Self::Lone(_) => &[],
            Self::Many(floats) => floats.shape().split_last().map_or(&[][..], |(_, rest)| rest),
        };
        [leading, answer].concat()
    }
}

/// One answer for each row of `q`; `compute` gets many rows and room for their answers.
fn for_each_row<'py>(
    q: &Bound<'py, PyAny>,
    chain: &Chain,
    answer: &[usize],
    compute: impl Fn(&[f64], &mut [f64]) + Sync,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let py = q.py();
    let q = JointValues::new(q, chain.dof())?;
    let shape = q.shape_with(answer);
    check_dimensions(py, "q", shape.len())?;
    let values = q.values()?;
    let size: usize = answer.iter().product();
    let rows = values.len() / chain.dof();
    let mut out = vec![0.0; rows * size];
    if rows < MANY {
        compute(values, &mut out);
    } else {
        let parts = out.chunks_mut(BETWEEN_SIGNAL_CHECKS * size);
        for (values, out) in values.chunks(BETWEEN_SIGNAL_CHECKS * chain.dof()).zip(parts) {
            py.detach(|| compute(values, out));
            py.check_signals()?;
        }
    }
    array(py, &shape, out)
}

/// Tool poses, shape (..., 4, 4).
pub fn fk<'py>(chain: &Chain, q: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    for_each_row(q, chain, &[4, 4], |q, out| tool_poses(chain, q, out))
}

/// Poses of all links and the tool, shape (..., links, 4, 4).
pub fn fk_links<'py>(
    chain: &Chain,
    q: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let links = chain.joints().len() + 1;
    for_each_row(q, chain, &[links, 4, 4], |q, out| {
        let rows = q.chunks_exact(chain.dof()).zip(out.chunks_exact_mut(16 * links));
        for (q, out) in rows {
            for (pose, out) in chain.link_poses(q).iter().zip(out.chunks_exact_mut(16)) {
                // The core stores columns.
                out.copy_from_slice(pose.transpose().as_slice());
            }
        }
    })
}

/// Geometric Jacobians, shape (..., 6, dof).
pub fn jacobian<'py>(
    chain: &Chain,
    q: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    for_each_row(q, chain, &[6, chain.dof()], |q, out| tool_jacobians(chain, q, out))
}

/// Arm angles of joint values of an S-R-S arm, rad.
pub fn arm_angle<'py>(
    chain: &Chain,
    q: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let refuse = |why: &str| errors::argument(q.py(), "robot", why, "an S-R-S arm");
    match ClosedForm::of(chain) {
        Ok(ClosedForm::Srs(arm)) => for_each_row(q, chain, &[], |q, out| {
            for (q, out) in q.chunks_exact(chain.dof()).zip(out) {
                *out = arm.arm_angle(q);
            }
        }),
        Ok(_) => Err(refuse("an arm that is not redundant")),
        Err(why) => Err(refuse(why)),
    }
}

/// Arm angles that the limits allow for one pose, for each branch, rad.
pub fn arm_angle_intervals(
    chain: &Chain,
    target: &Bound<'_, PyAny>,
    tool: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<Vec<(f64, f64)>>> {
    let py = target.py();
    let pose = transform("target", target)?.to_homogeneous();
    let mut rows = [0.0; 16];
    for (i, x) in rows.iter_mut().enumerate() {
        *x = pose[(i / 4, i % 4)];
    }
    let tail = tail(chain, tool)?;
    let goals = Goals::Poses(std::slice::from_ref(&rows));
    let all = Aim::new(chain, Task::Pose, Tolerance::default(), tail)
        .and_then(|aim| Request::new(chain, aim, goals, Starts::Free))
        .and_then(|request| arm_angle::intervals(&request))
        .map_err(|error| errors::from_core(py, error))?;
    Ok(all.into_iter().map(|one| one.iter().map(|i| (i.lower, i.upper)).collect()).collect())
}
