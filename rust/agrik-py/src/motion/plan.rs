//! Plans of paths.

use std::collections::BTreeSet;

use agrik_motion::planners::{
    Cut, Ends, Fewest, PathBlockers, PathStatus, Planned, blockers, plan,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::check::{contacts, posture};
use super::settings;
use crate::collision::collider::Collider;
use crate::convert::{Floats, array, wrong_shape};
use crate::errors;

/// Goals, shape (m, dof).
fn goals_of<'py>(goals: &Bound<'py, PyAny>, dof: usize) -> PyResult<Floats<'py>> {
    let read = Floats::new("goals", goals)?;
    match *read.shape() {
        [_, width] if width == dof => Ok(read),
        _ => Err(wrong_shape(goals.py(), "goals", read.shape(), &format!("(m, {dof})"))),
    }
}

/// Plan from a posture to one of some goals, the best first, shape (m, dof).
#[pyfunction]
pub fn motion_plan<'py>(
    collider: &Bound<'py, Collider>,
    start: &Bound<'py, PyAny>,
    goals: &Bound<'py, PyAny>,
    settings: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyDict>> {
    let py = collider.py();
    let core = collider.get().core();
    let dof = core.bodies().chain().dof();
    let (start, goals) = (posture("start", start, dof)?, goals_of(goals, dof)?);
    let settings = settings::read(settings)?;
    let values = goals.values()?;
    let found = py.detach(|| plan(&core, &start, values, &settings));
    planned(py, &found.map_err(|error| errors::from_core(py, error))?, dof)
}

/// The fewest removable objects without which a path is found, with what is known of their
/// number and with the path; `None` where none is found without all of them.
#[pyfunction]
pub fn motion_blockers<'py>(
    collider: &Bound<'py, Collider>,
    start: &Bound<'py, PyAny>,
    goals: &Bound<'py, PyAny>,
    settings: &Bound<'py, PyDict>,
) -> PyResult<Option<Bound<'py, PyDict>>> {
    let py = collider.py();
    let core = collider.get().core();
    let dof = core.bodies().chain().dof();
    let (start, goals) = (posture("start", start, dof)?, goals_of(goals, dof)?);
    let settings = settings::read(settings)?;
    let values = goals.values()?;
    let objects = core.scene().objects();
    let removable: Vec<usize> = (0..objects.len()).filter(|k| objects[*k].removable).collect();
    let found = py.detach(|| {
        let path = plan(&core, &start, values, &settings)?;
        if path.status == PathStatus::Ok {
            let (fewest, checks) = (Fewest::Proven, path.checks);
            let objects = Vec::new();
            return Ok(Some(PathBlockers { objects, path, fewest, at_least: 0, plans: 1, checks }));
        }
        let needs = vec![BTreeSet::new(); values.len() / dof];
        let ends = Ends { goals: values, needs: &needs };
        let without = |gone: &[usize]| core.without(gone);
        blockers(without, &start, ends, &removable, path.status, &settings)
    });
    let found = found.map_err(|error| errors::from_core(py, error))?;
    let told = |found: PathBlockers| {
        let out = PyDict::new(py);
        out.set_item("objects", found.objects)?;
        out.set_item("fewest", found.fewest as u8)?;
        out.set_item("at_least", found.at_least)?;
        out.set_item("plans", found.plans)?;
        out.set_item("checks", found.checks)?;
        out.set_item("path", planned(py, &found.path, dof)?)?;
        Ok(out)
    };
    found.map(told).transpose()
}

/// A plan's answer as a record.
pub fn planned<'py>(py: Python<'py>, found: &Planned, dof: usize) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("status", found.status as u8)?;
    out.set_item("how", found.how.name())?;
    out.set_item("goal", found.goal)?;
    out.set_item("path", array(py, &[found.path.len() / dof, dof], found.path.clone())?)?;
    out.set_item("clearance", array(py, &[found.clearance.len()], found.clearance.clone())?)?;
    out.set_item("checks", found.checks)?;
    out.set_item("rounds", found.rounds)?;
    out.set_item("nearest", found.nearest)?;
    out.set_item("contact", found.contact.map(|one| contacts(py, &[Some(one)])).transpose()?)?;
    out.set_item("proof", found.proof.as_ref().map(|cut| proof(py, cut)).transpose()?)?;
    Ok(out)
}

fn proof<'py>(py: Python<'py>, cut: &Cut) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("body", cut.body)?;
    out.set_item("radius", cut.radius)?;
    out.set_item("cell", cut.cell)?;
    out.set_item("origin", cut.origin)?;
    out.set_item("cells", cut.cells)?;
    out.set_item("at_goal", cut.at_goal)?;
    out.set_item("start", cut.start)?;
    let goals: Vec<f64> = cut.goals.iter().flatten().copied().collect();
    out.set_item("goals", array(py, &[cut.goals.len(), 3], goals)?)?;
    Ok(out)
}
