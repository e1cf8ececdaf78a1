//! Solvers: from a name or an object of `agrik_fast.solvers` to the core's settings.

use std::sync::Arc;

use agrik::closed_form::Choice;
use agrik::solve::{Pid, PidOrder, Settings, StartRule, StateSpace, Step, population as search};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::convert::{real, whole};
use crate::{errors, gains, population};

const KNOWN: [(&str, Settings); 10] = [
    ("lm", Settings::LEVENBERG_MARQUARDT),
    ("dls", Settings::DAMPED),
    ("pinv", Settings::PSEUDO_INVERSE),
    ("pinv-closed", Settings::CLOSED_PSEUDO_INVERSE),
    ("transpose", Settings::TRANSPOSE),
    ("ccd", Settings::DESCENT),
    ("ik-pid", Settings::IK_PID),
    ("state-space", Settings::STATE_SPACE),
    ("static-gain", Settings::STATIC_GAIN),
    ("broyden", Settings::BROYDEN),
];
const STARTS: [(&str, StartRule); 3] =
    [("sampled", StartRule::Sampled), ("zero", StartRule::Zero), ("middle", StartRule::Middle)];
const ORDERS: [(&str, PidOrder); 2] =
    [("tip-first", PidOrder::TipFirst), ("base-first", PidOrder::BaseFirst)];

/// Name of the closed form.
pub const CLOSED_FORM: &str = "closed_form";
/// Name of the choice between a closed form and the default step solver.
pub const AUTO: &str = "auto";
const CHOICES: [(&str, Choice); 3] =
    [("nearest", Choice::Nearest), ("margin", Choice::Margin), ("middle", Choice::Middle)];

/// The solver of a call.
#[derive(Debug, Clone)]
pub enum Chosen {
    Step(Settings),
    Population(search::Settings),
    /// The best of all branches, at an arm angle (`None`: at the best one).
    ClosedForm {
        choice: Choice,
        arm_angle: Option<f64>,
        /// The best arm angle is proven to be the best.
        proof: bool,
    },
    /// A closed form where there is one, else the default step solver.
    Auto,
}

fn names() -> Vec<&'static str> {
    let steps = KNOWN.iter().map(|(name, _)| *name);
    let searches = population::KNOWN.iter().map(|(name, _)| *name);
    steps.chain(searches).chain([CLOSED_FORM, AUTO]).collect()
}

fn named(py: Python<'_>, name: &str) -> PyResult<Settings> {
    KNOWN.into_iter().find(|(known, _)| *known == name).map_or_else(
        || Err(errors::unknown_name(py, "solver", name, &names())),
        |(_, settings)| Ok(settings),
    )
}

/// The solver meant by nothing (the default), a name or an object of `agrik_fast.solvers`
/// for the robot of that name.
pub fn chosen(solver: Option<&Bound<'_, PyAny>>, robot: &str) -> PyResult<Chosen> {
    if let Some(solver) = solver {
        let is_name = solver.is_instance_of::<PyString>();
        let name = if is_name { Ok(solver.clone()) } else { solver.getattr("name") };
        let name = name.and_then(|name| name.extract::<String>()).unwrap_or_default();
        if let Some((_, defaults)) = population::KNOWN.iter().find(|(known, _)| *known == name) {
            let settings =
                if is_name { *defaults } else { population::settings(solver, *defaults)? };
            return Ok(Chosen::Population(settings));
        }
        if name == CLOSED_FORM {
            return closed_form((!is_name).then_some(solver));
        }
        if name == AUTO && is_name {
            return Ok(Chosen::Auto);
        }
    }
    Ok(Chosen::Step(settings(solver, robot)?))
}

/// Choice and arm angle of a closed form given as an object; `None` for other solvers.
pub fn closed_form_of(solver: &Bound<'_, PyAny>) -> PyResult<Option<(Choice, Option<f64>)>> {
    let Ok(name) = solver.getattr("name") else { return Ok(None) };
    let is_closed = name.cast::<PyString>().is_ok_and(|name| name == CLOSED_FORM);
    match if is_closed { closed_form(Some(solver))? } else { Chosen::Auto } {
        Chosen::ClosedForm { choice, arm_angle, .. } => Ok(Some((choice, arm_angle))),
        _ => Ok(None),
    }
}

/// The closed form with the fields of a solver object, or with the defaults.
fn closed_form(solver: Option<&Bound<'_, PyAny>>) -> PyResult<Chosen> {
    let Some(solver) = solver else {
        return Ok(Chosen::ClosedForm { choice: Choice::default(), arm_angle: None, proof: false });
    };
    let choice = word("choose", &solver.getattr("choose")?, &CHOICES)?;
    let angle = solver.getattr("arm_angle")?;
    let arm_angle = if angle.is_none() { None } else { Some(real("arm_angle", &angle)?) };
    let proof = solver.getattr("certify")?.is_truthy()?;
    Ok(Chosen::ClosedForm { choice, arm_angle, proof })
}

/// One of a few words.
fn word<T: Copy>(kind: &str, value: &Bound<'_, PyAny>, known: &[(&str, T)]) -> PyResult<T> {
    let text: String = value.extract().map_err(|_| errors::value(kind, value, "a word"))?;
    known.iter().find(|(name, _)| *name == text).map_or_else(
        || {
            let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
            Err(errors::unknown_name(value.py(), kind, &text, &names))
        },
        |(_, value)| Ok(*value),
    )
}

/// A start rule by its name.
pub fn start_rule(value: &Bound<'_, PyAny>) -> PyResult<StartRule> {
    word("start", value, &STARTS)
}

fn count(solver: &Bound<'_, PyAny>, name: &str) -> PyResult<u32> {
    Ok(whole(name, &solver.getattr(name)?, 0, u32::MAX.into())? as u32)
}

fn number(solver: &Bound<'_, PyAny>, name: &str) -> PyResult<f64> {
    real(name, &solver.getattr(name)?)
}

/// The settings meant by nothing (the default), a name or an object with the fields of
/// that solver; gains must have been made for the robot of that name, if they say for which.
pub fn settings(solver: Option<&Bound<'_, PyAny>>, robot: &str) -> PyResult<Settings> {
    let Some(solver) = solver else {
        return Ok(Settings::LEVENBERG_MARQUARDT);
    };
    let py = solver.py();
    if let Ok(name) = solver.cast::<PyString>() {
        return named(py, name.to_str()?);
    }
    let name = solver.getattr("name").and_then(|name| name.extract::<String>()).map_err(|_| {
        let names = names().join(", ");
        errors::value(
            "solver",
            solver,
            &format!("a solver of agrik_fast.solvers or one of {names}"),
        )
    })?;
    if name == "plain" {
        let inner = settings(Some(&solver.getattr("solver")?), robot)?;
        return Ok(Settings {
            max_iterations: count(solver, "max_iterations")?,
            max_restarts: 0,
            max_step: f64::MAX,
            plain: true,
            start: start_rule(&solver.getattr("start")?)?,
            pace: inner.pace,
            step: inner.step,
        });
    }
    let mut settings = named(py, &name)?;
    settings.max_iterations = count(solver, "max_iterations")?;
    settings.max_restarts = count(solver, "max_restarts")?;
    match &mut settings.step {
        Step::Transpose | Step::FixedTranspose { .. } | Step::ClosedPseudoInverse => {}
        Step::PseudoInverse { cutoff } => *cutoff = number(solver, "cutoff")?,
        Step::Damped { damping } | Step::LevenbergMarquardt { damping } => {
            *damping = number(solver, "damping")?;
        }
        Step::CyclicCoordinateDescent => {
            settings.start = start_rule(&solver.getattr("start")?)?;
            return Ok(settings);
        }
        feedback => {
            gains::check_robot(solver, robot)?;
            *feedback = law(solver, feedback)?;
            settings.start = start_rule(&solver.getattr("start")?)?;
            return Ok(settings);
        }
    }
    settings.max_step = number(solver, "max_step")?;
    Ok(settings)
}

/// The feedback law of the same kind with the gains of a solver object.
fn law(solver: &Bound<'_, PyAny>, kind: &Step) -> PyResult<Step> {
    Ok(match kind {
        Step::IkPid(_) => {
            let unit = number(solver, "angle_unit_rad")? / number(solver, "length_unit_m")?;
            Step::IkPid(Pid {
                proportional: unit * number(solver, "kp")?,
                integral: unit * number(solver, "ki")?,
                derivative: unit * number(solver, "kd")?,
                order: word("order", &solver.getattr("order")?, &ORDERS)?,
                literal: solver.getattr("literal")?.is_truthy()?,
                full_passes: !solver.getattr("incremental")?.is_truthy()?,
            })
        }
        Step::StateSpace(_) if solver.getattr("A")?.is_none() => Step::StateSpace(None),
        Step::StateSpace(_) => Step::StateSpace(Some(Arc::new(StateSpace {
            a: gains::matrix(solver, "A")?,
            b: gains::matrix(solver, "B")?,
            c: gains::matrix(solver, "C")?,
            units: gains::units(solver)?,
        }))),
        Step::StaticGain(_) => Step::StaticGain(gains::static_gain(solver)?),
        _ => Step::Broyden {
            gain: gains::static_gain(solver)?,
            patience: count(solver, "patience")?,
        },
    })
}

/// Return the default settings of each solver, by the solver's name.
#[pyfunction]
pub fn default_settings(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let all = PyDict::new(py);
    for (name, settings) in KNOWN {
        let fields = PyDict::new(py);
        let mut has_max_step = true;
        match &settings.step {
            Step::Transpose | Step::FixedTranspose { .. } | Step::ClosedPseudoInverse => {}
            Step::PseudoInverse { cutoff } => fields.set_item("cutoff", cutoff)?,
            Step::Damped { damping } | Step::LevenbergMarquardt { damping } => {
                fields.set_item("damping", damping)?;
            }
            Step::Broyden { patience, .. } => {
                has_max_step = false;
                fields.set_item("patience", patience)?;
            }
            _ => has_max_step = false,
        }
        fields.set_item("max_iterations", settings.max_iterations)?;
        fields.set_item("max_restarts", settings.max_restarts)?;
        if has_max_step {
            fields.set_item("max_step", settings.max_step)?;
        }
        all.set_item(name, fields)?;
    }
    for (name, settings) in &population::KNOWN {
        all.set_item(name, population::fields(py, settings)?)?;
    }
    Ok(all)
}
