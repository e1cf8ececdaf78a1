//! Solvers: from a name or an object of `agrik_fast.solvers` to the core's settings.

use std::sync::Arc;

use agrik::closed_form::Choice;
use agrik::solve::{Pid, PidOrder, Settings, StartRule, StateSpace, Step, population as search};
use agrik::solvers::Solver;
use agrik::{Field, Number};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyType};

use super::{gains, population};
use crate::convert::{real, whole};
use crate::errors;

const STARTS: [(&str, StartRule); 3] =
    [("sampled", StartRule::Sampled), ("zero", StartRule::Zero), ("middle", StartRule::Middle)];
const ORDERS: [(&str, PidOrder); 2] =
    [("tip-first", PidOrder::TipFirst), ("base-first", PidOrder::BaseFirst)];

const CHOICES: [(&str, Choice); 3] =
    [("nearest", Choice::Nearest), ("margin", Choice::Margin), ("middle", Choice::Middle)];

fn named(py: Python<'_>, name: &str) -> PyResult<Solver> {
    Solver::named(name).ok_or_else(|| {
        let names: Vec<&str> = Solver::names().collect();
        errors::unknown_name(py, "solver", name, &names)
    })
}

/// The solver meant by nothing (the default), a name or an object of `agrik_fast.solvers`;
/// gains must have been made for the robot of that name, if they say for which.
pub fn chosen(solver: Option<&Bound<'_, PyAny>>, robot: &str) -> PyResult<Solver> {
    let Some(solver) = solver else { return Ok(Solver::default()) };
    let py = solver.py();
    if let Ok(name) = solver.cast::<PyString>() {
        return named(py, &name.to_string_lossy());
    }
    let expected = "a solver of agrik_fast.solvers, with all its fields";
    errors::whole_object("solver", solver, expected, of_object(solver, robot))
}

/// The solver with the fields of an object.
fn of_object(solver: &Bound<'_, PyAny>, robot: &str) -> PyResult<Solver> {
    let py = solver.py();
    if let Ok(class) = solver.cast::<PyType>() {
        let expected = format!("a solver, such as {}()", class.name()?);
        let received = format!("the class {}", class.name()?);
        return Err(errors::argument(py, "solver", &received, &expected));
    }
    let name = solver.getattr("name").and_then(|name| name.extract::<String>()).map_err(|_| {
        let names = Solver::names().collect::<Vec<_>>().join(", ");
        let expected = format!("a solver of agrik_fast.solvers or one of {names}");
        errors::value("solver", solver, &expected)
    })?;
    if name == "plain" {
        return plain(solver, robot);
    }
    match named(py, &name)? {
        Solver::Step(defaults) => Ok(Solver::Step(step(solver, defaults, robot)?)),
        Solver::Population(defaults) => {
            Ok(Solver::Population(population::settings(solver, defaults)?))
        }
        Solver::ClosedForm { .. } => closed_form(solver),
        Solver::Auto => {
            let expected = format!("the name '{}' itself", Solver::AUTO);
            Err(errors::value("solver", solver, &expected))
        }
    }
}

/// The settings of a solver that must be a step solver.
pub fn step_settings(solver: Option<&Bound<'_, PyAny>>, robot: &str) -> PyResult<Settings> {
    match (chosen(solver, robot)?, solver) {
        (Solver::Step(settings), _) => Ok(settings),
        (_, Some(solver)) => Err(errors::value("solver", solver, "a step solver")),
        (_, None) => Ok(Settings::default()),
    }
}

/// The closed form with the fields of a solver object.
fn closed_form(solver: &Bound<'_, PyAny>) -> PyResult<Solver> {
    let choice = word("choose", &solver.getattr("choose")?, &CHOICES)?;
    let angle = solver.getattr("arm_angle")?;
    let arm_angle = if angle.is_none() { None } else { Some(real("arm_angle", &angle)?) };
    let proof = solver.getattr("certify")?.is_truthy()?;
    Ok(Solver::ClosedForm { choice, arm_angle, proof })
}

/// A step solver as textbooks have it.
fn plain(solver: &Bound<'_, PyAny>, robot: &str) -> PyResult<Solver> {
    let iterations = solver.getattr("max_iterations")?;
    let inner = step_settings(Some(&solver.getattr("solver")?), robot)?;
    Ok(Solver::Step(Settings {
        max_iterations: whole("max_iterations", &iterations, 1, u32::MAX.into())? as u32,
        max_restarts: 0,
        max_step: f64::MAX,
        plain: true,
        start: start_rule(&solver.getattr("start")?)?,
        pace: inner.pace,
        step: inner.step,
    }))
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

/// Reads numbers from the attributes of an object.
pub fn read<'f>(
    solver: &Bound<'_, PyAny>,
    fields: impl IntoIterator<Item = Field<'f>>,
) -> PyResult<()> {
    for Field { name, value, allowed } in fields {
        let given = solver.getattr(name)?;
        let refuse = || errors::value(name, &given, &allowed.to_string());
        match value {
            Number::Real(x) => *x = real(name, &given).map_err(|_| refuse())?,
            Number::Count(n) => {
                *n = whole(name, &given, 0, u32::MAX.into()).map_err(|_| refuse())? as u32;
            }
        }
    }
    Ok(())
}

/// Writes numbers into a dictionary by their names.
pub fn write<'f>(
    to: &Bound<'_, PyDict>,
    fields: impl IntoIterator<Item = Field<'f>>,
) -> PyResult<()> {
    for Field { name, value, .. } in fields {
        match value {
            Number::Real(x) => to.set_item(name, *x)?,
            Number::Count(n) => to.set_item(name, *n)?,
        }
    }
    Ok(())
}

fn number(solver: &Bound<'_, PyAny>, name: &str) -> PyResult<f64> {
    real(name, &solver.getattr(name)?)
}

/// The settings of a step solver with the fields of an object.
fn step(solver: &Bound<'_, PyAny>, defaults: Settings, robot: &str) -> PyResult<Settings> {
    let mut settings = defaults;
    match &mut settings.step {
        Step::CyclicCoordinateDescent => settings.start = start_rule(&solver.getattr("start")?)?,
        feedback @ (Step::IkPid(_)
        | Step::StateSpace(_)
        | Step::StaticGain(_)
        | Step::Broyden { .. }) => {
            gains::check_robot(solver, robot)?;
            *feedback = law(solver, feedback)?;
            settings.start = start_rule(&solver.getattr("start")?)?;
        }
        Step::Transpose
        | Step::FixedTranspose { .. }
        | Step::ClosedPseudoInverse
        | Step::PseudoInverse { .. }
        | Step::Damped { .. }
        | Step::LevenbergMarquardt { .. } => {}
    }
    read(solver, settings.fields())?;
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
        // Its patience is among the numbers that are read with those of the loop.
        _ => Step::Broyden { gain: gains::static_gain(solver)?, patience: 1 },
    })
}

/// Return the default settings of each solver, by the solver's name.
#[pyfunction]
pub fn default_settings(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let all = PyDict::new(py);
    for (name, mut settings) in Settings::KNOWN {
        let fields = PyDict::new(py);
        write(&fields, settings.fields())?;
        all.set_item(name, fields)?;
    }
    for (name, settings) in &search::Settings::KNOWN {
        all.set_item(name, population::fields(py, settings)?)?;
    }
    Ok(all)
}

/// Refuse a solver with settings that are not allowed.
#[pyfunction]
pub fn check_solver(solver: &Bound<'_, PyAny>) -> PyResult<()> {
    let py = solver.py();
    // Gains say for which robot they were made; here they are looked at for themselves.
    let inner = solver.getattr("solver");
    let gains = inner.as_ref().unwrap_or(solver);
    let robot = gains.getattr("robot").and_then(|robot| robot.extract::<Option<String>>());
    let robot = robot.ok().flatten().unwrap_or_default();
    chosen(Some(solver), &robot)?.check().map_err(|error| errors::from_core(py, error))
}

/// Return the names of all solvers, step solvers first.
#[pyfunction]
pub fn solver_names() -> Vec<&'static str> {
    Solver::names().collect()
}

/// Return the names of the solvers that take limits of each row.
#[pyfunction]
pub fn limited_solver_names() -> Vec<&'static str> {
    let takes = |name: &&str| Solver::named(name).is_some_and(|solver| solver.takes_limits());
    Solver::names().filter(takes).collect()
}
