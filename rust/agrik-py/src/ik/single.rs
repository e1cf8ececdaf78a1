//! Closed forms of a single pose: the common call of a control loop, without the copies,
//! plans and records that a batch needs.

use agrik::chain::{Chain, Tail};
use agrik::closed_form::{Choice, ClosedForm, Single, alone, best_alone};
use agrik::solve::Tolerance;
use numpy::{PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyFloat, PyString};

use crate::branches::Branches;
use crate::convert::{self, is_rigid, transform};
use crate::ik::Arguments;
use crate::result::IkResult;
use crate::solver::{self, AUTO, CLOSED_FORM};
use crate::targets::lone_pose;
use crate::{errors, threads};

/// Most joints of an arm with a closed form.
const JOINTS: usize = agrik::closed_form::JOINTS;

/// All branches of a single pose in an array of doubles; `None` for any other call, and for
/// those that [`crate::ik::solve_all`] has to refuse.
pub fn all(
    py: Python<'_>,
    chain: &Chain,
    given: &Arguments<'_, '_>,
    arm_angle: Option<&Bound<'_, PyAny>>,
) -> PyResult<Option<Branches>> {
    let Some(parts) = Parts::of(chain, given)? else { return Ok(None) };
    let arm_angle = match arm_angle {
        None => None,
        Some(angle) => match angle.cast_exact::<PyFloat>() {
            Err(_) => return Ok(None),
            Ok(angle) => Some(angle.value()),
        },
    };
    threads::number(given.threads, "threads")?;
    let found = alone(&parts.single(chain, arm_angle)).map_err(|e| errors::from_core(py, e))?;
    Ok(Some(Branches::of_one(chain.dof(), found)))
}

/// The best branch of a single pose; `None` for any other call, also where the best of all
/// arm angles is wanted.
pub fn best(
    py: Python<'_>,
    chain: &Chain,
    given: &Arguments<'_, '_>,
) -> PyResult<Option<IkResult>> {
    let Some(solver) = given.solver else { return Ok(None) };
    let (choice, arm_angle) = match solver.cast_exact::<PyString>() {
        Ok(name) if matches!(name.to_str()?, CLOSED_FORM | AUTO) => (Choice::default(), None),
        Ok(_) => return Ok(None),
        Err(_) => match solver::closed_form_of(solver)? {
            Some((choice, arm_angle)) => (choice, arm_angle),
            None => return Ok(None),
        },
    };
    if given.task.is_some() {
        return Ok(None);
    }
    let Some(parts) = Parts::of(chain, given)? else { return Ok(None) };
    for (name, value) in [("seed", given.seed), ("first_index", given.first_index)] {
        convert::index(name, value)?;
    }
    threads::number(given.threads, "threads")?;
    let found = best_alone(&parts.single(chain, arm_angle), choice);
    let found = found.map_err(|e| errors::from_core(py, e))?;
    Ok(found.map(|answers| IkResult::new(Vec::new(), chain.dof(), answers)))
}

/// A call for a single pose of an arm with a closed form, in memory of its own.
struct Parts {
    pose: [f64; 16],
    start: Option<[f64; JOINTS]>,
    tail: Option<Tail>,
    tolerance: Tolerance,
}

impl Parts {
    fn of(chain: &Chain, given: &Arguments<'_, '_>) -> PyResult<Option<Self>> {
        let Some(pose) = lone_pose(given.targets) else { return Ok(None) };
        // A pose that is not finite is bad input, one that is not rigid an error.
        if !is_rigid(&pose) || ClosedForm::of(chain).is_err() {
            return Ok(None);
        }
        let start = match given.q0 {
            None => None,
            Some(q0) => match lone_start(q0, chain.dof()) {
                None => return Ok(None),
                found => found,
            },
        };
        let (tail, tolerance) = (tail(chain, given)?, tolerance(given)?);
        Ok(Some(Self { pose, start, tail, tolerance }))
    }

    fn single<'a>(&'a self, chain: &'a Chain, arm_angle: Option<f64>) -> Single<'a> {
        Single {
            chain,
            pose: &self.pose,
            tail: self.tail,
            tolerance: self.tolerance,
            q0: self.start.as_ref().and_then(|start| start.get(..chain.dof())),
            arm_angle,
        }
    }
}

/// The tool of a call, if it has one of its own.
pub fn tail(chain: &Chain, given: &Arguments<'_, '_>) -> PyResult<Option<Tail>> {
    match given.tool {
        None => Ok(None),
        Some(tool) => Ok(Some(chain.compiled().tail_with(&transform("tool", tool)?))),
    }
}

/// The tolerances of a call.
pub fn tolerance(given: &Arguments<'_, '_>) -> PyResult<Tolerance> {
    let mut tolerance = Tolerance::default();
    if let Some(value) = given.position_tolerance {
        tolerance.position = convert::real("position_tolerance", value)?;
    }
    if let Some(value) = given.orientation_tolerance {
        tolerance.orientation = convert::real("orientation_tolerance", value)?;
    }
    Ok(tolerance)
}

/// Start values in an array of `dof` doubles.
fn lone_start(q0: &Bound<'_, PyAny>, dof: usize) -> Option<[f64; JOINTS]> {
    let array = q0.cast::<PyArray1<f64>>().ok()?;
    if array.len() != dof || !array.is_aligned() {
        return None;
    }
    let mut start = [0.0; JOINTS];
    for (i, x) in start.get_mut(..dof)?.iter_mut().enumerate() {
        *x = array.get_owned(i)?;
    }
    Some(start)
}
