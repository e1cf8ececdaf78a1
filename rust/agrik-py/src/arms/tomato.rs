//! The class `TomatoArm`, and the shared loop with a chosen pace for its comparison.

use std::f64::consts::PI;

use agrik::arms::tomato::{Arm, Joints};
use agrik::call::{Aim, Goals, Request, Starts, Tolerance, solve};
use agrik::solve::{Pace, Plan, Settings, StartRule, Step};
use agrik::task::Task;
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use super::strawberry::{row, rows};
use crate::convert::{array, check_dimensions};
use crate::errors;
use crate::ik::signals::Signals;
use crate::result::IkResult;
use crate::robot::chain::Chain;

/// Closed form of the tomato pointing arm.
#[pyclass(frozen, module = "agrik_fast._native")]
pub struct TomatoArm(Arm);

type Answer<'py> = (IkResult, Bound<'py, PyArrayDyn<u8>>, Bound<'py, PyArrayDyn<i8>>);
type Branches<'py> =
    (Bound<'py, PyArrayDyn<f64>>, Bound<'py, PyArrayDyn<bool>>, Bound<'py, PyArrayDyn<u8>>);

#[pymethods]
impl TomatoArm {
    /// Make an arm from link lengths (m) and servo limits (rad).
    #[new]
    #[pyo3(signature = (l1, l2, lower=None, upper=None))]
    fn new(
        py: Python<'_>,
        l1: f64,
        l2: f64,
        lower: Option<&Bound<'_, PyAny>>,
        upper: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let lower = lower.map_or(Ok([-PI; 3]), |value| row("lower", value))?;
        let upper = upper.map_or(Ok([PI; 3]), |value| row("upper", value))?;
        Arm::new([l1, l2], lower, upper).map(Self).map_err(|error| errors::from_core(py, error))
    }

    /// Solve targets, shape (..., 3), m.
    #[pyo3(signature = (targets, current, branch, follow))]
    fn solve<'py>(
        &self,
        py: Python<'py>,
        targets: &Bound<'py, PyAny>,
        current: &Bound<'py, PyAny>,
        branch: Option<usize>,
        follow: bool,
    ) -> PyResult<Answer<'py>> {
        let (floats, leading) = rows::<3>("targets", targets)?;
        let current: Joints = row("current", current)?;
        let points: &[[f64; 3]] = floats.values()?.as_chunks().0;
        let mut signals = Signals::new();
        let mut go_on = || signals.go_on_detached();
        let made = py.detach(|| self.0.solve_all(points, &current, branch, follow, &mut go_on));
        let made = made.map_err(|error| signals.exception(py, error))?;
        Ok((
            IkResult::new(leading.clone(), 3, made.answers),
            array(py, &leading, made.outcome)?,
            array(py, &leading, made.branch)?,
        ))
    }

    /// All branches, shape (..., 4, 3), which are within the limits, (..., 4), and what
    /// became of the targets.
    fn branches<'py>(
        &self,
        py: Python<'py>,
        targets: &Bound<'py, PyAny>,
        pan: f64,
    ) -> PyResult<Branches<'py>> {
        let (floats, leading) = rows::<3>("targets", targets)?;
        check_dimensions(py, "targets", leading.len() + 2)?;
        let points: &[[f64; 3]] = floats.values()?.as_chunks().0;
        let mut q = Vec::with_capacity(points.len() * 12);
        let mut valid = Vec::with_capacity(points.len() * 4);
        let mut outcome = Vec::with_capacity(points.len());
        let mut signals = Signals::new();
        for target in points {
            signals.check_attached(py)?;
            use agrik::arms::tomato::Outcome;
            match self.0.branches(*target, pan) {
                Ok(all) => {
                    q.extend(all.q.concat());
                    valid.extend(all.valid);
                    outcome.push(match (all.valid.contains(&true), all.on_axis) {
                        (false, _) => Outcome::ServoLimit,
                        (true, true) => Outcome::OnAxis,
                        (true, false) => Outcome::Ok,
                    } as u8);
                }
                Err(why) => {
                    q.extend([f64::NAN; 12]);
                    valid.extend([false; 4]);
                    outcome.push(why as u8);
                }
            }
        }
        let with = |more: &[usize]| [&leading, more].concat();
        Ok((
            array(py, &with(&[4, 3]), q)?,
            array(py, &with(&[4]), valid)?,
            array(py, &leading, outcome)?,
        ))
    }

    /// Fixed transpose step above which the iteration diverges, 1/m^2, shape (...).
    fn transpose_bound<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (floats, leading) = rows::<3>("q", q)?;
        let values: &[Joints] = floats.values()?.as_chunks().0;
        array(py, &leading, values.iter().map(|q| self.0.transpose_bound(q)).collect())
    }
}

/// Solve a position task without restarts and with a chosen pace: a share of the error
/// a step (`gain`), or a length of it (`step_length`, m).
///
/// `step` is "transpose" (`parameter` is alpha, 1/m^2; 0 for the automatic length), "pinv"
/// (relative cutoff) or "dls" (damping, m).
#[pyfunction]
#[pyo3(signature = (
    chain, targets, step, parameter, gain, step_length, q0, position_tolerance, max_iterations
))]
#[allow(clippy::too_many_arguments)]
pub fn ik_paced(
    py: Python<'_>,
    chain: &Chain,
    targets: &Bound<'_, PyAny>,
    step: &str,
    parameter: f64,
    gain: f64,
    step_length: Option<f64>,
    q0: &Bound<'_, PyAny>,
    position_tolerance: f64,
    max_iterations: u32,
) -> PyResult<IkResult> {
    let step = match step {
        "transpose" if parameter == 0.0 => Step::Transpose,
        "transpose" => Step::FixedTranspose { alpha: parameter },
        "pinv" => Step::PseudoInverse { cutoff: parameter },
        "dls" => Step::Damped { damping: parameter },
        _ => return Err(errors::unknown_name(py, "step", step, &["transpose", "pinv", "dls"])),
    };
    let settings = Settings {
        step,
        max_iterations,
        max_restarts: 0,
        // The paper's loop does not shorten steps, and counts them as they are.
        max_step: f64::MAX,
        plain: true,
        start: StartRule::Zero,
        pace: step_length.map_or(Pace::Share(gain), Pace::Length),
    };
    let (floats, leading) = rows::<3>("targets", targets)?;
    let (q0, _) = rows::<3>("q0", q0)?;
    let core = chain.core();
    let chain = core.as_ref();
    let starts = q0.values()?;
    let tolerance = Tolerance { position: position_tolerance, ..Tolerance::default() };
    let goals = Goals::Positions { points: floats.values()?.as_chunks().0, direction: None };
    let starts =
        if starts.len() == chain.dof() { Starts::One(starts) } else { Starts::Each(starts) };
    let plan = Aim::new(chain, Task::Position, tolerance, None)
        .and_then(|aim| Request::new(chain, aim, goals, starts))
        .and_then(|request| Plan::new(request, settings))
        .map_err(|error| errors::from_core(py, error))?;
    let mut signals = Signals::new();
    let answers = py.detach(|| solve(&plan, 1, &mut || signals.go_on_detached()));
    let answers = answers.map_err(|error| signals.exception(py, error))?;
    Ok(IkResult::new(leading, chain.dof(), answers))
}
