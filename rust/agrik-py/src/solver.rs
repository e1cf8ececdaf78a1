//! Solvers: from a name or an object of `agrik_fast.solvers` to the core's settings.

use agrik::solve::{Settings, Step};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::convert::{real, whole};
use crate::errors;

const KNOWN: [(&str, Settings); 4] = [
    ("lm", Settings::LEVENBERG_MARQUARDT),
    ("dls", Settings::DAMPED),
    ("pinv", Settings::PSEUDO_INVERSE),
    ("transpose", Settings::TRANSPOSE),
];

fn named(py: Python<'_>, name: &str) -> PyResult<Settings> {
    match KNOWN.iter().find(|(known, _)| *known == name) {
        Some((_, settings)) => Ok(*settings),
        None => Err(errors::unknown_name(py, "solver", name, &KNOWN.map(|(known, _)| known))),
    }
}

/// The settings meant by nothing (the default), a name or an object with the fields of
/// that solver.
pub fn settings(solver: Option<&Bound<'_, PyAny>>) -> PyResult<Settings> {
    let Some(solver) = solver else {
        return Ok(Settings::LEVENBERG_MARQUARDT);
    };
    let py = solver.py();
    if let Ok(name) = solver.cast::<PyString>() {
        return named(py, name.to_str()?);
    }
    let name = solver.getattr("name").and_then(|name| name.extract::<String>()).map_err(|_| {
        let expected = "a solver of agrik_fast.solvers or one of lm, dls, pinv, transpose";
        errors::value("solver", solver, expected)
    })?;
    let mut settings = named(py, &name)?;
    let field = |name: &str| solver.getattr(name);
    let count = |name: &str| Ok::<_, PyErr>(whole(name, &field(name)?, 0, u32::MAX.into())? as u32);
    match &mut settings.step {
        Step::Transpose | Step::FixedTranspose { .. } => {}
        Step::PseudoInverse { cutoff } => *cutoff = real("cutoff", &field("cutoff")?)?,
        Step::Damped { damping } | Step::LevenbergMarquardt { damping } => {
            *damping = real("damping", &field("damping")?)?;
        }
    }
    settings.max_iterations = count("max_iterations")?;
    settings.max_restarts = count("max_restarts")?;
    settings.max_step = real("max_step", &field("max_step")?)?;
    Ok(settings)
}

/// Return the default settings of each solver, by the solver's name.
#[pyfunction]
pub fn default_settings(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let all = PyDict::new(py);
    for (name, settings) in KNOWN {
        let fields = PyDict::new(py);
        match settings.step {
            Step::Transpose | Step::FixedTranspose { .. } => {}
            Step::PseudoInverse { cutoff } => fields.set_item("cutoff", cutoff)?,
            Step::Damped { damping } | Step::LevenbergMarquardt { damping } => {
                fields.set_item("damping", damping)?;
            }
        }
        fields.set_item("max_iterations", settings.max_iterations)?;
        fields.set_item("max_restarts", settings.max_restarts)?;
        fields.set_item("max_step", settings.max_step)?;
        all.set_item(name, fields)?;
    }
    Ok(all)
}
