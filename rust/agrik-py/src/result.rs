//! The record of a call's answers; its arrays are made when they are asked for.

use std::sync::{Arc, Mutex, PoisonError};

use agrik::call::{Aim, Answers, Status};
use agrik::chain::{Chain, DhConvention};
use agrik::solve::{DH, Sensitivity, TWIST};
use agrik::task::Task;
use agrik::threads::share;
use agrik_motion::{Collider, Contact};
use numpy::{Element, PyArray, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyString};

use crate::convert::{SMALL, array, copied, internal, shape_text};
use crate::errors;
use crate::ik::signals::Signals;
use crate::records::hand_on;

/// Numbers that become an array, once: few of them as a copy, many by handing over their memory.
pub(crate) struct Column<T> {
    numbers: Numbers<T>,
    array: PyOnceLock<Py<PyArrayDyn<T>>>,
}

enum Numbers<T> {
    /// Read without a lock, since making an array may run code of others that comes back here.
    Few(Vec<T>),
    Many(Mutex<Vec<T>>),
}

impl<T: Element + Copy> Column<T> {
    pub(crate) fn new(values: Vec<T>) -> Self {
        let few = values.len() <= SMALL;
        let numbers = if few { Numbers::Few(values) } else { Numbers::Many(Mutex::new(values)) };
        Self { numbers, array: PyOnceLock::new() }
    }

    /// An array that is filled already.
    pub(crate) fn made(array: Py<PyArrayDyn<T>>) -> Self {
        let once = PyOnceLock::new();
        // A new cell is empty: this cannot fail.
        let _ = Python::attach(|py| once.set(py, array));
        Self { numbers: Numbers::Few(Vec::new()), array: once }
    }

    pub(crate) fn get<'py>(
        &self,
        py: Python<'py>,
        shape: &[usize],
    ) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
        let values = match &self.numbers {
            Numbers::Few(values) => return self.get_or(py, || copied(py, shape, values)),
            Numbers::Many(values) => values,
        };
        let made = self.array.get_or_try_init(py, || {
            // The lock is let go before Python runs.
            let mut locked = values.lock().unwrap_or_else(PoisonError::into_inner);
            let values = std::mem::take(&mut *locked);
            drop(locked);
            array(py, shape, values).map(Bound::unbind)
        });
        Ok(made?.bind(py).clone())
    }

    /// The array, made by `make` where it has not been yet. Two threads may both make it, and
    /// one is kept: to wait for the other, the interpreter would have to be let go each time.
    pub(crate) fn get_or<'py>(
        &self,
        py: Python<'py>,
        make: impl FnOnce() -> PyResult<Bound<'py, PyArrayDyn<T>>>,
    ) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
        if let Some(made) = self.array.get(py) {
            return Ok(made.bind(py).clone());
        }
        let made = make()?;
        let _ = self.array.set(py, made.clone().unbind());
        Ok(self.array.get(py).map_or(made, |kept| kept.bind(py).clone()))
    }
}

/// Rows whose derivatives a thread works out at a time.
const PIECE: usize = 1024;

/// Which question answers belong to.
#[derive(Debug, Clone)]
pub struct Origin {
    pub chain: Arc<Chain>,
    /// Of a chain that was made from such rows.
    pub convention: Option<DhConvention>,
    pub aim: Aim,
    /// The targets are poses, not points.
    pub are_poses: bool,
    /// The targets have no direction in common.
    pub turns: bool,
}

/// Answers of one `Robot.ik` call; arrays have the targets' leading shape.
#[pyclass(frozen, module = "agrik_fast._native")]
pub struct IkResult {
    shape: Vec<usize>,
    dof: usize,
    /// Rows by status.
    counts: [usize; Status::ALL.len()],
    q: Column<f64>,
    status: Column<u8>,
    success: Column<bool>,
    position_error: Column<f64>,
    orientation_error: Column<f64>,
    iterations: Column<u32>,
    restarts: Column<u32>,
    /// Codes of `agrik_fast.Warnings`; none where no row has any.
    warnings: Vec<u8>,
    /// What the answers were to keep clear of.
    collider: Option<Arc<Collider>>,
    /// What that gave, of a record that came from elsewhere: clearances and nearest pairs.
    near: Option<(Py<PyAny>, Py<PyAny>)>,
    /// What was asked, of a record that is a call's own or a part of it.
    origin: Option<Box<Origin>>,
}

impl IkResult {
    /// The record of answers to targets of a leading shape.
    #[inline(always)]
    pub fn new(shape: Vec<usize>, dof: usize, answers: Answers) -> Self {
        let mut counts = [0; Status::ALL.len()];
        for status in &answers.status {
            if let Some(count) = counts.get_mut(usize::from(*status)) {
                *count += 1;
            }
        }
        // Made here, since the status array is the user's to write to once it is out.
        let success = answers.status.iter().map(|s| *s == Status::Converged as u8).collect();
        Self {
            shape,
            dof,
            counts,
            q: Column::new(answers.q),
            status: Column::new(answers.status),
            success: Column::new(success),
            position_error: Column::new(answers.position_error),
            orientation_error: Column::new(answers.orientation_error),
            iterations: Column::new(answers.iterations),
            restarts: Column::new(answers.restarts),
            warnings: Vec::new(),
            collider: None,
            near: None,
            origin: None,
        }
    }

    /// The same record, of answers to a question.
    #[inline(always)]
    pub fn to(self, origin: Origin) -> Self {
        Self { origin: Some(Box::new(origin)), ..self }
    }

    /// The same record with warnings, one a row or none at all.
    #[inline(always)]
    pub fn with_warnings(self, warnings: Vec<u8>) -> Self {
        Self { warnings, ..self }
    }

    /// The same record, of answers that were to keep clear of something.
    #[inline(always)]
    pub fn in_scene(self, collider: Option<Arc<Collider>>) -> Self {
        Self { collider, ..self }
    }

    /// Works out some numbers of each answer; those of targets that were not reached are 0.
    fn derivatives(
        &self,
        py: Python<'_>,
        numbers: usize,
        work: impl Fn(&[f64], &mut [f64]) + Sync,
    ) -> PyResult<Vec<f64>> {
        let (q, success) = (self.q(py)?, self.success(py)?);
        // Another thread may write to the arrays meanwhile.
        let q = q.try_readonly().map_err(internal)?.as_slice().map_err(internal)?.to_vec();
        let success =
            success.try_readonly().map_err(internal)?.as_slice().map_err(internal)?.to_vec();
        let mut out = vec![0.0; success.len() * numbers];
        let mut signals = Signals::new();
        let done = py.detach(|| {
            let rows = q.chunks(PIECE * self.dof).zip(success.chunks(PIECE));
            let pieces = rows.zip(out.chunks_mut(PIECE * numbers)).collect();
            let piece = |((q, success), out): ((&[f64], &[bool]), &mut [f64])| {
                work(q, out);
                for (out, success) in out.chunks_mut(numbers).zip(success) {
                    if !success {
                        out.fill(0.0);
                    }
                }
            };
            share(pieces, 0, &piece, &mut || signals.go_on_detached())
        });
        if done { Ok(out) } else { Err(signals.exception(py, agrik::Error::Interrupted)) }
    }

    /// What is nearest to a collision in each row.
    fn contacts(&self, py: Python<'_>, collider: &Collider) -> PyResult<Vec<Option<Contact>>> {
        let q = self.q(py)?;
        // Another thread may write to the array meanwhile.
        let values = q.try_readonly().map_err(internal)?.as_slice().map_err(internal)?.to_vec();
        let mut signals = Signals::new();
        py.detach(|| collider.nearest_of_each(&values, 0, &mut || signals.go_on_detached()))
            .map_err(|error| signals.exception(py, error))
    }
}

#[pymethods]
impl IkResult {
    /// Joint values, shape (..., dof), rad or m; the best found where unsolved.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let mut shape = self.shape.clone();
        shape.push(self.dof);
        self.q.get(py, &shape)
    }

    /// True only where a final FK check met the tolerances and the limits.
    #[getter]
    fn success<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
        self.success.get(py, &self.shape)
    }

    /// Codes of `agrik_fast.Status`.
    #[getter]
    fn status<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<u8>>> {
        self.status.get(py, &self.shape)
    }

    /// Distance of the tool point from the target, m; infinite for bad input.
    #[getter]
    fn position_error<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.position_error.get(py, &self.shape)
    }

    /// Angle left to the target orientation, rad; 0 for position tasks.
    #[getter]
    fn orientation_error<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.orientation_error.get(py, &self.shape)
    }

    /// Steps taken, over all attempts.
    #[getter]
    fn iterations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<u32>>> {
        self.iterations.get(py, &self.shape)
    }

    /// Attempts after the first.
    #[getter]
    fn restarts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<u32>>> {
        self.restarts.get(py, &self.shape)
    }

    /// Codes of `agrik_fast.Warnings`, 0 for none.
    #[getter]
    fn warnings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<u8>>> {
        let rows = self.shape.iter().product();
        let none = || vec![0; rows];
        let all = if self.warnings.is_empty() { none() } else { self.warnings.clone() };
        array(py, &self.shape, all)
    }

    /// Distance of each answer from the nearest collision, m; None without a scene.
    #[getter]
    fn clearance<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        if let Some((clearance, _)) = &self.near {
            return Ok(Some(clearance.bind(py).clone()));
        }
        let Some(collider) = &self.collider else { return Ok(None) };
        let contacts = self.contacts(py, collider)?;
        let least = |found: &Option<Contact>| found.map_or(f64::INFINITY, |found| found.distance);
        let made = array(py, &self.shape, contacts.iter().map(least).collect())?;
        Ok(Some(made.into_any()))
    }

    /// Names of a body and of the object or other body nearest to it, shape (..., 2).
    #[getter]
    fn nearest_pair<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        if let Some((_, pairs)) = &self.near {
            return Ok(Some(pairs.bind(py).clone()));
        }
        let Some(collider) = &self.collider else { return Ok(None) };
        let names: Vec<Py<PyAny>> = self
            .contacts(py, collider)?
            .iter()
            .flat_map(|found| found.as_ref().map_or(["", ""], |found| collider.names(found)))
            .map(|name| PyString::new(py, name).into_any().unbind())
            .collect();
        let shape = [&self.shape[..], &[2]].concat();
        let flat = PyArray::from_vec(py, names);
        flat.call_method1("reshape", (shape,)).map(Some)
    }

    /// How the joint values follow their targets, or the rows of the arm.
    #[pyo3(signature = (wrt="target"))]
    fn jacobian_of_q<'py>(
        &self,
        py: Python<'py>,
        wrt: &str,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let Some(origin) = &self.origin else {
            let received = "a result without its question, as one that was pickled";
            let expected = "a result of Robot.ik, or some of its rows";
            return Err(errors::argument(py, "jacobian_of_q", received, expected));
        };
        let Origin { chain, convention, aim, are_poses, turns } = &**origin;
        if aim.task() == Task::PositionFirst {
            let expected = "another task: its orientation is no function of the joint values";
            return Err(errors::argument(py, "jacobian_of_q", "task 'position-first'", expected));
        }
        let sensitivity = Sensitivity { chain, aim, turns: *turns };
        let mut shape = self.shape.clone();
        shape.push(self.dof);
        match (wrt, convention) {
            ("target", _) => {
                let size = self.dof * TWIST;
                let all = self.derivatives(py, size, |q, out| sensitivity.by_target(q, out))?;
                if *are_poses {
                    shape.push(TWIST);
                    return array(py, &shape, all);
                }
                // Points do not turn.
                shape.push(TWIST / 2);
                let ways = all.as_chunks::<TWIST>().0.iter();
                array(py, &shape, ways.flat_map(|twist| [twist[0], twist[1], twist[2]]).collect())
            }
            ("dh", Some(convention)) => {
                let rows = chain.joints().len();
                let size = self.dof * rows * DH;
                let all =
                    self.derivatives(py, size, |q, out| sensitivity.by_dh(*convention, q, out))?;
                shape.extend([rows, DH]);
                array(py, &shape, all)
            }
            ("dh", None) => {
                let expected = "\"target\": the robot was not made from DH rows";
                Err(errors::argument(py, "wrt", "\"dh\"", expected))
            }
            (other, _) => Err(errors::unknown_name(py, "wrt", other, &["target", "dh"])),
        }
    }

    fn __len__(slf: &Bound<'_, Self>) -> PyResult<usize> {
        hand_on(slf, "length", &[])?.extract()
    }

    /// The record of some of the targets, chosen as in a NumPy array of them.
    fn __getitem__<'py>(
        slf: &Bound<'py, Self>,
        key: Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        hand_on(slf, "take", &[key])
    }

    fn __iter__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        hand_on(slf, "iterate", &[])
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        hand_on(slf, "reduce", &[])
    }

    /// Return the arrays by their names.
    fn to_dict<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        hand_on(slf, "to_dict", &[])
    }

    /// Return a `pyarrow.Table`.
    fn to_arrow<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        hand_on(slf, "to_arrow", &[])
    }

    /// Return a `pandas.DataFrame`.
    fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        hand_on(slf, "to_pandas", &[])
    }

    /// Draw what became of the targets, or an arm's postures.
    #[pyo3(signature = (arm=None))]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        arm: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let arm = arm.unwrap_or_else(|| slf.py().None().into_bound(slf.py()));
        hand_on(slf, "plot", &[arm])
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        hand_on(slf, "html_table", &[])
    }

    fn __bool__(slf: &Bound<'_, Self>) -> PyResult<bool> {
        hand_on(slf, "truth", &[])?.extract()
    }

    fn __repr__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let head = PyString::new(slf.py(), &slf.get().outcome()).into_any();
        hand_on(slf, "text", &[head])
    }
}

impl IkResult {
    /// How many targets ended how, in words.
    fn outcome(&self) -> String {
        let names = [
            "converged",
            "out of reach",
            "not found",
            "bad input",
            "stalled",
            "non-finite",
            "in collision",
        ];
        let parts: Vec<String> = self
            .counts
            .iter()
            .zip(names)
            .filter(|(count, _)| **count > 0)
            .map(|(count, name)| format!("{count} {name}"))
            .collect();
        let total: usize = self.counts.iter().sum();
        let plural = if total == 1 { "" } else { "s" };
        let outcome =
            if parts.is_empty() { String::new() } else { format!(": {}", parts.join(", ")) };
        format!("{total} target{plural}{outcome}")
    }
}

/// An array as numbers of one type, and its shape.
pub(crate) fn column<T: Element + Copy>(
    name: &str,
    value: &Bound<'_, PyAny>,
) -> PyResult<(Vec<usize>, Vec<T>)> {
    let array = value
        .cast::<PyArrayDyn<T>>()
        .map_err(|_| errors::value(name, value, "an array of the record's type"))?;
    let numbers = array.try_readonly().map_err(internal)?;
    Ok((array.shape().to_vec(), numbers.as_array().iter().copied().collect()))
}

/// The record of arrays that belong together, such as those of another record.
#[pyfunction]
#[pyo3(signature = (
    q, status, position_error, orientation_error, iterations, restarts, warnings,
    clearance=None, nearest_pair=None, like=None
))]
#[allow(clippy::too_many_arguments)]
pub fn ik_result(
    q: &Bound<'_, PyAny>,
    status: &Bound<'_, PyAny>,
    position_error: &Bound<'_, PyAny>,
    orientation_error: &Bound<'_, PyAny>,
    iterations: &Bound<'_, PyAny>,
    restarts: &Bound<'_, PyAny>,
    warnings: &Bound<'_, PyAny>,
    clearance: Option<Py<PyAny>>,
    nearest_pair: Option<Py<PyAny>>,
    like: Option<&Bound<'_, IkResult>>,
) -> PyResult<IkResult> {
    let (mut wide, q_values) = column("q", q)?;
    let dof = wide.pop().unwrap_or_default();
    let (shape, status) = column("status", status)?;
    let answers = Answers {
        q: q_values,
        status,
        position_error: column("position_error", position_error)?.1,
        orientation_error: column("orientation_error", orientation_error)?.1,
        iterations: column("iterations", iterations)?.1,
        restarts: column("restarts", restarts)?.1,
    };
    let warnings = column("warnings", warnings)?.1;
    let rows: usize = shape.iter().product();
    let lengths = [
        answers.position_error.len(),
        answers.orientation_error.len(),
        answers.iterations.len(),
        answers.restarts.len(),
        warnings.len(),
    ];
    if wide != shape || lengths.iter().any(|&length| length != rows) {
        let received = format!("shape {}", shape_text(&wide));
        let expected = format!("arrays of the status' shape {}", shape_text(&shape));
        return Err(errors::argument(q.py(), "q", &received, &expected));
    }
    let mut made = IkResult::new(shape, dof, answers).with_warnings(warnings);
    made.near = clearance.zip(nearest_pair);
    made.origin = like.and_then(|record| record.get().origin.clone());
    Ok(made)
}

/// Return the codes of all statuses by their names.
#[pyfunction]
pub fn statuses(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let all = PyDict::new(py);
    for status in Status::ALL {
        all.set_item(status.name(), status as u8)?;
    }
    Ok(all)
}
