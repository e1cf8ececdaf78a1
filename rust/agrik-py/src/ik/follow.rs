//! Paths: targets in order, every posture a continuation of the one before.

use agrik::chain::Chain;
use agrik::lanes::Level;
use agrik::solve::Follow;
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use super::arguments::{Arguments, Call, each_joint};
use super::signals::Signals;
use crate::convert::{Floats, array, real};
use crate::errors;
use crate::result::IkResult;

/// What a path has besides the arguments of an ordinary call.
pub struct Along<'a, 'py> {
    pub q0: Option<&'a Bound<'py, PyAny>>,
    pub max_joint_step: &'a Bound<'py, PyAny>,
    pub pull: &'a Bound<'py, PyAny>,
}

/// Answers, which of them are no continuation, and shares of the steps that joints took.
pub type Followed<'py> = (IkResult, Bound<'py, PyArrayDyn<bool>>, Bound<'py, PyArrayDyn<f64>>);

/// Follows the targets of a call.
pub fn follow<'py>(
    py: Python<'py>,
    chain: &Chain,
    given: &Arguments<'_, 'py>,
    along: &Along<'_, 'py>,
) -> PyResult<Followed<'py>> {
    let dof = chain.dof();
    let call = Call::new(py, chain, given)?;
    let leading = call.targets.leading_shape().to_vec();
    if leading.len() != 1 {
        let received = format!("{} leading dimensions", leading.len());
        let expected = "a sequence of targets, shape (n, 4, 4) or (n, 3)";
        return Err(errors::argument(py, "targets", &received, expected));
    }
    let q0 = along.q0.map(|q0| Floats::of_shape("q0", q0, &[dof])).transpose()?;
    let steps = each_joint("max_joint_step", along.max_joint_step, dof)?;
    let pull = real("pull", along.pull)?;
    let mut points = Vec::new();
    let request = call.request(py, chain, &mut points)?;
    let q0 = q0.as_ref().map(Floats::values).transpose()?;
    let follow =
        Follow::new(request, q0, steps, pull).map_err(|error| errors::from_core(py, error))?;
    let mut signals = Signals::new();
    match py.detach(|| follow.run(Level::in_use(), &mut || signals.go_on_detached())) {
        Ok(path) => {
            let jumps = array(py, &leading, path.jumps)?;
            let speeds = array(py, &leading, path.speeds)?;
            Ok((IkResult::new(leading, dof, path.answers), jumps, speeds))
        }
        Err(error) => Err(signals.exception(py, error)),
    }
}
