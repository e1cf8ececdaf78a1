//! Solvers: from a name or an object of `agrik_fast.solvers` to the core's settings.

use agrik::closed_form::Choice;
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

const CLOSED_FORM: &str = "closed_form";
const AUTO: &str = "auto";

/// How a call gets to its answers.
#[derive(Debug, Clone, Copy)]
pub enum Solver {
    /// The loop of step solvers.
    Steps(Settings),
    /// All branches, and the best of them at an arm angle (`None`: at the best one).
    ClosedForm { choice: Choice, arm_angle: Option<f64> },
    /// A closed form where there is one, else the default step solver.
    Auto,
}

fn named(py: Python<'_>, name: &str) -> PyResult<Settings> {
    match KNOWN.iter().find(|(known, _)| *known == name) {
        Some((_, settings)) => Ok(*settings),
        None => {
            let mut known: Vec<&str> = KNOWN.iter().map(|(known, _)| *known).collect();
            known.extend([CLOSED_FORM, AUTO]);
            Err(errors::unknown_name(py, "solver", name, &known))
        }
    }
}

/// The solver meant by nothing (the default), a name or an object with the fields of that
/// solver.
pub fn solver(solver: Option<&Bound<'_, PyAny>>) -> PyResult<Solver> {
    let Some(solver) = solver else {
        return Ok(Solver::Steps(Settings::LEVENBERG_MARQUARDT));
    };
    let py = solver.py();
    if let Ok(name) = solver.cast::<PyString>() {
        return match name.to_str()? {
            CLOSED_FORM => Ok(Solver::ClosedForm { choice: Choice::default(), arm_angle: None }),
            AUTO => Ok(Solver::Auto),
            other => named(py, other).map(Solver::Steps),
        };
    }
    let name = solver.getattr("name").and_then(|name| name.extract::<String>()).map_err(|_| {
        let expected =
            "a solver of agrik_fast.solvers or one of lm, dls, pinv, transpose, closed_form, auto";
        errors::value("solver", solver, expected)
    })?;
    let field = |name: &str| solver.getattr(name);
    if name == CLOSED_FORM {
        let choose = field("choose")?;
        let choice = match choose.extract::<String>().as_deref() {
            Ok("nearest") => Choice::Nearest,
            Ok("margin") => Choice::Margin,
            Ok("middle") => Choice::Middle,
            _ => {
                return Err(errors::value("choose", &choose, "'nearest', 'margin' or 'middle'"));
            }
        };
        let angle = field("arm_angle")?;
        let arm_angle = if angle.is_none() { None } else { Some(real("arm_angle", &angle)?) };
        return Ok(Solver::ClosedForm { choice, arm_angle });
    }
    let mut settings = named(py, &name)?;
    let count = |name: &str| Ok::<_, PyErr>(whole(name, &field(name)?, 0, u32::MAX.into())? as u32);
    match &mut settings.step {
        Step::Transpose => {}
        Step::PseudoInverse { cutoff } => *cutoff = real("cutoff", &field("cutoff")?)?,
        Step::Damped { damping } | Step::LevenbergMarquardt { damping } => {
            *damping = real("damping", &field("damping")?)?;
        }
    }
    settings.max_iterations = count("max_iterations")?;
    settings.max_restarts = count("max_restarts")?;
    settings.max_step = real("max_step", &field("max_step")?)?;
    Ok(Solver::Steps(settings))
}

/// Return the default settings of each solver, by the solver's name.
#[pyfunction]
pub fn default_settings(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let all = PyDict::new(py);
    for (name, settings) in KNOWN {
        let fields = PyDict::new(py);
        match settings.step {
            Step::Transpose => {}
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
