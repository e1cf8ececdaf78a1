//! Everything near an arm, with how distances change: functions on a `Collider`.

use agrik_motion::Other;
use agrik_motion::body::{Near, Nearby};
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::collider::Collider;
use crate::convert::{Floats, array};
use crate::harvest::station::put;
use crate::robot::kinematics::JointValues;
use crate::threads;

/// All objects and pairs of bodies that are near at postures, shape (n, dof), as columns.
#[pyfunction]
#[pyo3(signature = (collider, q, reach, within, own, threads=None))]
pub fn collision_near<'py>(
    collider: &Bound<'py, Collider>,
    q: &Bound<'py, PyAny>,
    reach: &Bound<'py, PyAny>,
    within: &Bound<'py, PyAny>,
    own: &Bound<'py, PyAny>,
    threads: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let py = collider.py();
    let core = collider.get().core();
    let dof = core.bodies().chain().dof();
    let q = JointValues::new(q, dof)?;
    let (reach, within) = (Floats::new("reach", reach)?, Floats::new("within", within)?);
    let own = Floats::new("own", own)?;
    let threads = threads::number(threads, "threads")?;
    let ask = Near {
        q: q.values()?,
        reach: reach.values()?,
        within: within.values()?,
        own: own.values()?,
    };
    let found = Collider::ask(py, |poll| core.near(&ask, threads, poll))?;
    let out = PyDict::new(py);
    put(py, &out, "row", &found, |one| one.row as i64)?;
    put(py, &out, "body", &found, |one| one.contact.body as i64)?;
    // Bodies are told as -1 less their index.
    put(py, &out, "other", &found, |one| match one.contact.other {
        Other::Object(object) => object as i64,
        Other::Body(body) => -1 - body as i64,
    })?;
    put(py, &out, "distance", &found, |one| one.contact.distance)?;
    put(py, &out, "motion", &found, |one| one.motion)?;
    let vectors = |name: &str, of: fn(&Nearby) -> [f64; 3]| -> PyResult<()> {
        let flat = found.iter().flat_map(of).collect();
        out.set_item(name, array(py, &[found.len(), 3], flat)?)
    };
    vectors("on_body", |one| one.contact.on_body)?;
    vectors("normal", |one| one.contact.normal)?;
    let rates = found.iter().flat_map(|one| one.rates.iter().copied()).collect();
    out.set_item("rates", array(py, &[found.len(), dof], rates)?)?;
    Ok(out)
}

/// Distance of the nearest pair of bodies at joint values, shape (n, dof), with the bodies of
/// each shifted by vectors, shape (n, bodies, 3); m.
#[pyfunction]
#[pyo3(signature = (collider, q, shifts, threads=None))]
pub fn collision_shifted_own<'py>(
    collider: &Bound<'py, Collider>,
    q: &Bound<'py, PyAny>,
    shifts: &Bound<'py, PyAny>,
    threads: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let py = collider.py();
    let core = collider.get().core();
    let q = JointValues::new(q, core.bodies().chain().dof())?;
    let shifts = Floats::new("shifts", shifts)?;
    let threads = threads::number(threads, "threads")?;
    let (values, vectors) = (q.values()?, shifts.values()?.as_chunks().0);
    let found =
        Collider::ask(py, |poll| core.shifted_own_clearances(values, vectors, threads, poll))?;
    array(py, &q.shape_with(&[]), found)
}
