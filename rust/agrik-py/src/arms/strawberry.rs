//! The class `StrawberryArm`: the strawberry arm's closed forms over arrays.

use agrik::arms::strawberry::{
    Arm, CERTIFIED, Interval, Joints, Method, Parameters, Rules, SlopeCase, ThetaRule,
};
use agrik::call::Answers;
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::{Floats, array, shape_text, wrong_shape};
use crate::errors;
use crate::ik::signals::Signals;
use crate::result::IkResult;

/// Targets from which on the interpreter is released.
const MANY: usize = 64;

/// Closed forms of the strawberry handling arm.
#[pyclass(frozen, module = "agrik_fast._native")]
pub struct StrawberryArm(Arm);

type Answer<'py> = (
    IkResult,
    Bound<'py, PyArrayDyn<f64>>,
    Bound<'py, PyArrayDyn<u8>>,
    Bound<'py, PyArrayDyn<f64>>,
);

/// Rows of `N` numbers and the leading shape.
pub fn rows<'py, const N: usize>(
    argument: &str,
    value: &Bound<'py, PyAny>,
) -> PyResult<(Floats<'py>, Vec<usize>)> {
    let floats = Floats::new(argument, value)?;
    match floats.shape().split_last() {
        Some((last, leading)) if *last == N => {
            let leading = leading.to_vec();
            Ok((floats, leading))
        }
        _ => {
            let expected = format!("(..., {N})");
            Err(wrong_shape(value.py(), argument, floats.shape(), &expected))
        }
    }
}

/// One row of `N` numbers.
pub fn row<const N: usize>(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<[f64; N]> {
    let floats = Floats::of_shape(argument, value, &[N])?;
    let mut row = [0.0; N];
    row.copy_from_slice(floats.values()?);
    Ok(row)
}

fn pair(interval: Interval) -> (f64, f64) {
    (interval.low, interval.high)
}

fn method(
    py: Python<'_>,
    name: &str,
    s10_share: f64,
    theta_rule: &str,
    theta_step: f64,
) -> PyResult<Method> {
    let theta = match theta_rule {
        "least_magnitude" => ThetaRule::LeastMagnitude { step: theta_step },
        "middle" => ThetaRule::Middle,
        _ => {
            let known = ["least_magnitude", "middle"];
            return Err(errors::unknown_name(py, "theta rule", theta_rule, &known));
        }
    };
    let rules = Rules { s10_share, theta };
    match name {
        "as" => Ok(Method::Analytic(rules)),
        "ssas" => Ok(Method::Suboptimal(rules)),
        "exact" => Ok(Method::Exact),
        _ => Err(errors::unknown_name(py, "method", name, &["as", "ssas", "exact"])),
    }
}

#[pymethods]
impl StrawberryArm {
    /// Make an arm; what is not given is as in the paper.
    #[new]
    #[pyo3(signature = (
        *, l1=None, l2=None, l3=None, d=None, lower=None, upper=None, friction=None, mass2=None,
        mass3=None, gravity=None
    ))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        l1: Option<f64>,
        l2: Option<f64>,
        l3: Option<f64>,
        d: Option<&Bound<'_, PyAny>>,
        lower: Option<&Bound<'_, PyAny>>,
        upper: Option<&Bound<'_, PyAny>>,
        friction: Option<f64>,
        mass2: Option<f64>,
        mass3: Option<f64>,
        gravity: Option<f64>,
    ) -> PyResult<Self> {
        let mut p = Parameters::default();
        for (to, given) in [
            (&mut p.l1, l1),
            (&mut p.l2, l2),
            (&mut p.l3, l3),
            (&mut p.friction, friction),
            (&mut p.mass2, mass2),
            (&mut p.mass3, mass3),
            (&mut p.gravity, gravity),
        ] {
            *to = given.unwrap_or(*to);
        }
        if let Some(d) = d {
            p.d = row("d", d)?;
        }
        if let Some(lower) = lower {
            p.lower = row("lower", lower)?;
        }
        if let Some(upper) = upper {
            p.upper = row("upper", upper)?;
        }
        Arm::new(p).map(Self).map_err(|error| errors::from_core(py, error))
    }

    /// The parameters by name, m, rad, N, kg.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let p = self.0.parameters();
        let all = PyDict::new(py);
        for (name, value) in [
            ("l1", p.l1),
            ("l2", p.l2),
            ("l3", p.l3),
            ("friction", p.friction),
            ("mass2", p.mass2),
            ("mass3", p.mass3),
            ("gravity", p.gravity),
        ] {
            all.set_item(name, value)?;
        }
        all.set_item("d", p.d.to_vec())?;
        all.set_item("lower", p.lower.to_vec())?;
        all.set_item("upper", p.upper.to_vec())?;
        Ok(all)
    }

    /// Theta and beta of the free branch, rad, or None.
    #[getter]
    fn free_pose(&self) -> Option<(f64, f64)> {
        self.0.free().map(|free| (free.theta, free.beta))
    }

    /// Home and reset pose, shape (5,), m and rad.
    #[getter]
    fn reset_pose<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        array(py, &[5], self.0.reset_pose().to_vec())
    }

    /// Bounds of the targets, shape (2, 3), m.
    #[getter]
    fn target_box<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        array(py, &[2, 3], self.0.target_box().concat())
    }

    /// Solve targets, shape (..., 3), m.
    #[pyo3(signature = (targets, method, s10_share, theta_rule, theta_step))]
    fn solve<'py>(
        &self,
        py: Python<'py>,
        targets: &Bound<'py, PyAny>,
        method: &str,
        s10_share: f64,
        theta_rule: &str,
        theta_step: f64,
    ) -> PyResult<Answer<'py>> {
        let method = self::method(py, method, s10_share, theta_rule, theta_step)?;
        let (floats, leading) = rows::<3>("targets", targets)?;
        let points: &[[f64; 3]] = floats.values()?.as_chunks().0;
        let mut signals = Signals::new();
        let made = if points.len() < MANY {
            self.0.solve_all(points, &method, &mut || signals.go_on_attached(py))
        } else {
            py.detach(|| self.0.solve_all(points, &method, &mut || signals.go_on_detached()))
        };
        let made = made.map_err(|error| signals.exception(py, error))?;
        Ok((
            IkResult::new(leading.clone(), 5, made.answers),
            array(py, &leading, made.energy)?,
            array(py, &leading, made.place)?,
            array(py, &leading, made.gap)?,
        ))
    }

    /// Tool points, shape (..., 3), m, of joint values, shape (..., 5).
    fn fk<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (floats, mut shape) = rows::<5>("q", q)?;
        let values: &[Joints] = floats.values()?.as_chunks().0;
        shape.push(3);
        array(py, &shape, values.iter().flat_map(|q| self.0.fk(q)).collect())
    }

    /// Energy index, J, of joint values, shape (..., 5).
    fn energy<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (floats, shape) = rows::<5>("q", q)?;
        let values: &[Joints] = floats.values()?.as_chunks().0;
        array(py, &shape, values.iter().map(|q| self.0.energy_index(q)).collect())
    }

    /// The set of s10 of one target, m, or None; and by how much it is empty.
    fn s10_set(&self, target: &Bound<'_, PyAny>) -> PyResult<(Option<(f64, f64)>, f64)> {
        Ok(match self.0.s10_set(row("target", target)?) {
            Ok(set) => (Some(pair(set)), 0.0),
            Err(gap) => (None, gap.amount),
        })
    }

    /// The sets of theta of one target at a beta, rad, by name.
    fn theta_sets<'py>(
        &self,
        py: Python<'py>,
        target: &Bound<'py, PyAny>,
        beta: f64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let sets = self.0.theta_sets(row("target", target)?, beta);
        let list = |sets: &[Option<Interval>]| -> Vec<(f64, f64)> {
            sets.iter().flatten().map(|set| pair(*set)).collect()
        };
        let all = PyDict::new(py);
        all.set_item("s21", list(&[sets.s21]))?;
        all.set_item("s32", list(&sets.s32))?;
        all.set_item("all", list(&sets.all))?;
        Ok(all)
    }

    /// Derivatives along s10 at a theta and beta, by name.
    fn slopes<'py>(
        &self,
        py: Python<'py>,
        theta: f64,
        beta: f64,
        case: &str,
    ) -> PyResult<Bound<'py, PyDict>> {
        let case = match case {
            "fixed" => SlopeCase::Fixed,
            "s21" => SlopeCase::OnS21,
            "s32" => SlopeCase::OnS32,
            _ => return Err(errors::unknown_name(py, "case", case, &["fixed", "s21", "s32"])),
        };
        let [friction, potential] = self.0.energy_slopes(theta, beta, case);
        let all = PyDict::new(py);
        all.set_item("beta_by_s10", self.0.beta_slope(beta))?;
        all.set_item("theta_by_beta", self.0.theta_slope(theta, beta, case))?;
        all.set_item("friction_by_s10", friction)?;
        all.set_item("potential_by_s10", potential)?;
        Ok(all)
    }

    /// The steps of remark 3 to a pose: (axis, target) pairs.
    fn commands(
        &self,
        py: Python<'_>,
        q: &Bound<'_, PyAny>,
        psi: f64,
        h_extra: f64,
    ) -> PyResult<Vec<(&'static str, f64)>> {
        let steps = self.0.commands(&row("q", q)?, psi, h_extra);
        let steps = steps.map_err(|error| errors::from_core(py, error))?;
        Ok(steps.iter().map(|step| (step.axis.name(), step.target)).collect())
    }

    /// Smallest translations of the platform but for `within`, shape (..., 3), m; NaN where
    /// none helps.
    #[pyo3(signature = (targets, may_move, within=CERTIFIED))]
    fn suggest_base_shift<'py>(
        &self,
        py: Python<'py>,
        targets: &Bound<'py, PyAny>,
        may_move: [bool; 3],
        within: f64,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (floats, mut shape) = rows::<3>("targets", targets)?;
        let points: &[[f64; 3]] = floats.values()?.as_chunks().0;
        let shift =
            |t: &[f64; 3]| self.0.suggest_base_shift(*t, may_move, within).unwrap_or([f64::NAN; 3]);
        let mut shifts = Vec::with_capacity(3 * points.len());
        for some in points.chunks(MANY) {
            py.detach(|| shifts.extend(some.iter().flat_map(shift)));
            py.check_signals()?;
        }
        shape.push(3);
        array(py, &shape, shifts)
    }
}

/// The common record of answers that were found outside the core.
#[pyfunction]
#[pyo3(signature = (q, status, position_error, iterations=None))]
pub fn ik_record(
    q: &Bound<'_, PyAny>,
    status: &Bound<'_, PyAny>,
    position_error: &Bound<'_, PyAny>,
    iterations: Option<&Bound<'_, PyAny>>,
) -> PyResult<IkResult> {
    let py = q.py();
    let q = Floats::new("q", q)?;
    let errors = Floats::new("position_error", position_error)?;
    let Some((dof, leading)) = q.shape().split_last() else {
        return Err(wrong_shape(py, "q", q.shape(), "(..., n)"));
    };
    let status = Floats::of_shape("status", status, leading)?;
    if errors.shape() != leading {
        let expected = shape_text(leading);
        return Err(wrong_shape(py, "position_error", errors.shape(), &expected));
    }
    let status: Vec<u8> = status.values()?.iter().map(|code| *code as u8).collect();
    let errors = errors.values()?;
    let iterations = match iterations {
        Some(counts) => {
            let counts = Floats::of_shape("iterations", counts, leading)?;
            counts.values()?.iter().map(|count| *count as u32).collect()
        }
        None => vec![0; status.len()],
    };
    let answers = Answers {
        q: q.values()?.to_vec(),
        // Infinite where nothing could be tried, as the error of position.
        orientation_error: errors.iter().map(|x| if x.is_finite() { 0.0 } else { *x }).collect(),
        iterations,
        restarts: vec![0; status.len()],
        position_error: errors.to_vec(),
        status,
    };
    Ok(IkResult::new(leading.to_vec(), *dof, answers))
}
