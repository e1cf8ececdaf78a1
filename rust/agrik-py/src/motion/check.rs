//! Whether ways are free.

use agrik_motion::edges::{Outcome, Verdict, check_corners, check_path, check_segments};
use agrik_motion::{Contact, Other};
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::settings;
use crate::collision::collider::Collider;
use crate::convert::array;
use crate::errors;
use crate::harvest::station::put;
use crate::ik::signals::Signals;
use crate::robot::kinematics::JointValues;
use crate::threads;

/// What is known of the straight ways between the rows of a path, or of `path` to those of `to`.
#[pyfunction]
#[pyo3(signature = (collider, path, to=None, settings=None, threads=None))]
pub fn motion_check<'py>(
    collider: &Bound<'py, Collider>,
    path: &Bound<'py, PyAny>,
    to: Option<&Bound<'py, PyAny>>,
    settings: Option<&Bound<'py, PyDict>>,
    threads: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let py = collider.py();
    let core = collider.get().core();
    let dof = core.bodies().chain().dof();
    let path = JointValues::new(path, dof)?;
    let to = to.map(|to| JointValues::new(to, dof)).transpose()?;
    let settings = match settings {
        Some(given) => settings::read(given)?,
        None => settings::read(&PyDict::new(py))?,
    };
    let threads = threads::number(threads, "threads")?;
    let values = path.values()?;
    let others = to.as_ref().map(JointValues::values).transpose()?;
    let mut signals = Signals::new();
    let found = py.detach(|| {
        let mut go = || signals.go_on_detached();
        match others {
            None => check_path(&core, settings.keep, values, threads, &mut go),
            Some(to) => check_segments(&core, settings.keep, values, to, threads, &mut go),
        }
    });
    let found = found.map_err(|error| signals.exception(py, error))?;
    verdicts(py, &found)
}

/// Whether the triangles of postures are free whose vertices are rows of three arrays.
#[pyfunction]
#[pyo3(signature = (collider, start, corner, end, settings, threads=None))]
pub fn motion_corners<'py>(
    collider: &Bound<'py, Collider>,
    start: &Bound<'py, PyAny>,
    corner: &Bound<'py, PyAny>,
    end: &Bound<'py, PyAny>,
    settings: &Bound<'py, PyDict>,
    threads: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
    let py = collider.py();
    let core = collider.get().core();
    let dof = core.bodies().chain().dof();
    let [start, corner, end] = [start, corner, end].map(|q| JointValues::new(q, dof));
    let (start, corner, end) = (start?, corner?, end?);
    let keep = settings::read(settings)?.keep;
    let threads = threads::number(threads, "threads")?;
    let values = [start.values()?, corner.values()?, end.values()?];
    let mut signals = Signals::new();
    let found =
        py.detach(|| check_corners(&core, keep, values, threads, &mut || signals.go_on_detached()));
    let found = found.map_err(|error| signals.exception(py, error))?;
    array(py, &[found.len()], found)
}

/// Verdicts as columns.
fn verdicts<'py>(py: Python<'py>, all: &[Verdict]) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    put(py, &out, "outcome", all, |one| one.outcome as u8)?;
    put(py, &out, "clearance", all, |one| one.clearance)?;
    put(py, &out, "at", all, |one| one.at)?;
    put(py, &out, "checks", all, |one| i64::from(one.checks))?;
    let contacts: Vec<Option<Contact>> = all.iter().map(|one| one.contact).collect();
    out.set_item("contact", self::contacts(py, &contacts)?)?;
    Ok(out)
}

/// Contacts as columns: the body, what it is near (an object, or another body), the distance and
/// the two points; -1 and 0 for none.
pub fn contacts<'py>(py: Python<'py>, all: &[Option<Contact>]) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    let index = |wanted: Option<usize>| wanted.map_or(-1, |index| index as i64);
    put(py, &out, "body", all, |one| index(one.map(|c| c.body)))?;
    put(py, &out, "object", all, |one| {
        index(one.and_then(|c| match c.other {
            Other::Object(object) => Some(object),
            Other::Body(_) => None,
        }))
    })?;
    put(py, &out, "other_body", all, |one| {
        index(one.and_then(|c| match c.other {
            Other::Body(body) => Some(body),
            Other::Object(_) => None,
        }))
    })?;
    put(py, &out, "distance", all, |one| one.map_or(0.0, |c| c.distance))?;
    let points = all.iter().flat_map(|one| one.map_or([[0.0; 3]; 2], |c| [c.on_body, c.on_other]));
    let points: Vec<f64> = points.flatten().collect();
    out.set_item("points", array(py, &[all.len(), 2, 3], points)?)?;
    Ok(out)
}

/// Names of outcomes, statuses of plans and ways to find a path, at their codes.
#[pyfunction]
pub fn motion_words() -> (Vec<&'static str>, Vec<&'static str>, Vec<&'static str>) {
    use agrik_motion::planners::{How, PathStatus};
    (
        Outcome::ALL.map(Outcome::name).to_vec(),
        PathStatus::ALL.map(PathStatus::name).to_vec(),
        How::ALL.map(How::name).to_vec(),
    )
}

/// Joint values of one posture.
pub fn posture(name: &str, value: &Bound<'_, PyAny>, dof: usize) -> PyResult<Vec<f64>> {
    let floats = crate::convert::Floats::new(name, value)?;
    if floats.shape() != [dof] {
        let expected = format!("({dof},)");
        return Err(crate::convert::wrong_shape(value.py(), name, floats.shape(), &expected));
    }
    let q = floats.values()?;
    match q.iter().position(|x| !x.is_finite()) {
        None => Ok(q.to_vec()),
        Some(at) => Err(errors::argument(
            value.py(),
            name,
            &format!("{} in place {at}", q[at]),
            "finite joint values",
        )),
    }
}
