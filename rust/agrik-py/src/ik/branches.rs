//! The record of all branches of a call; its arrays are made when they are asked for.

use agrik::call::Status;
use agrik::closed_form::{self, Alone};
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use smallvec::SmallVec;

use crate::convert::{copied, shape_text};
use crate::errors;
use crate::records::hand_on;
use crate::result::{Column, column};

/// Every branch of the targets of one `Robot.ik_all` call.
#[pyclass(frozen, module = "agrik_fast._native")]
pub struct Branches {
    shape: Vec<usize>,
    dof: usize,
    branches: usize,
    targets: usize,
    solved: usize,
    /// The branches of a single target, in place of the columns' own numbers.
    alone: Option<Box<Alone>>,
    q: Column<f64>,
    valid: Column<bool>,
    reached: Column<bool>,
    singular: Column<u8>,
    status: Column<u8>,
}

impl Branches {
    /// The record of branches for targets of a leading shape; `q` where the joint values
    /// stand in an array already.
    pub fn new(
        shape: Vec<usize>,
        dof: usize,
        all: closed_form::Branches,
        q: Option<Py<PyArrayDyn<f64>>>,
    ) -> Self {
        let solved = all.status.iter().filter(|s| **s == Status::Converged as u8).count();
        Self {
            shape,
            dof,
            branches: all.branches,
            targets: all.status.len(),
            solved,
            alone: None,
            q: q.map_or_else(|| Column::new(all.q), Column::made),
            valid: Column::new(all.valid),
            reached: Column::new(all.reached),
            singular: Column::new(all.singular),
            status: Column::new(all.status),
        }
    }

    /// The record of a single target.
    pub fn of_one(dof: usize, alone: Box<Alone>) -> Self {
        Self {
            shape: Vec::new(),
            dof,
            branches: alone.branches(),
            targets: 1,
            solved: usize::from(alone.status() == Status::Converged),
            alone: Some(alone),
            q: Column::new(Vec::new()),
            valid: Column::new(Vec::new()),
            reached: Column::new(Vec::new()),
            singular: Column::new(Vec::new()),
            status: Column::new(Vec::new()),
        }
    }

    fn with(&self, last: &[usize]) -> Vec<usize> {
        [&self.shape, last].concat()
    }
}

/// One number for each branch of a single target.
fn each<'py, T: numpy::Element + Copy>(
    py: Python<'py>,
    one: &Alone,
    number: impl Fn(&Alone, usize) -> T,
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let numbers: SmallVec<[T; 16]> = (0..one.branches()).map(|b| number(one, b)).collect();
    copied(py, &[one.branches()], &numbers)
}

#[pymethods]
impl Branches {
    /// Joint values, shape (..., branches, dof), rad; the nearest where not reached.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let Some(one) = &self.alone else {
            return self.q.get(py, &self.with(&[self.branches, self.dof]));
        };
        self.q.get_or(py, || copied(py, &[self.branches, self.dof], one.q()))
    }

    /// Reached by forward kinematics, inside the limits, no branch twice.
    #[getter]
    fn valid<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
        match &self.alone {
            None => self.valid.get(py, &self.with(&[self.branches])),
            Some(one) => self.valid.get_or(py, || each(py, one, Alone::valid)),
        }
    }

    /// `valid` without regard to the limits.
    #[getter]
    fn reached<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
        match &self.alone {
            None => self.reached.get(py, &self.with(&[self.branches])),
            Some(one) => self.reached.get_or(py, || each(py, one, Alone::reached)),
        }
    }

    /// Singularities of each branch, a sum of codes of `agrik_fast.Singularity`.
    #[getter]
    fn singular<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<u8>>> {
        match &self.alone {
            None => self.singular.get(py, &self.with(&[self.branches])),
            Some(one) => self.singular.get_or(py, || each(py, one, Alone::singular)),
        }
    }

    /// Codes of `agrik_fast.Status`.
    #[getter]
    fn status<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<u8>>> {
        match &self.alone {
            None => self.status.get(py, &self.shape),
            Some(one) => self.status.get_or(py, || copied(py, &[], &[one.status() as u8])),
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

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        hand_on(slf, "html_table", &[])
    }

    fn __repr__(&self) -> String {
        let plural = if self.targets == 1 { "" } else { "s" };
        format!("Branches({} target{plural}, {} with a valid branch)", self.targets, self.solved)
    }
}

/// The record of arrays that belong together, such as those of another record.
#[pyfunction]
pub fn branches(
    q: &Bound<'_, PyAny>,
    valid: &Bound<'_, PyAny>,
    reached: &Bound<'_, PyAny>,
    singular: &Bound<'_, PyAny>,
    status: &Bound<'_, PyAny>,
) -> PyResult<Branches> {
    let (mut wide, q_values) = column("q", q)?;
    let dof = wide.pop().unwrap_or_default();
    let (shape, status) = column("status", status)?;
    let all = closed_form::Branches {
        branches: wide.last().copied().unwrap_or_default(),
        q: q_values,
        valid: column("valid", valid)?.1,
        reached: column("reached", reached)?.1,
        singular: column("singular", singular)?.1,
        status,
    };
    let rows: usize = wide.iter().product();
    let lengths = [all.valid.len(), all.reached.len(), all.singular.len()];
    if wide.split_last().map(|(_, rest)| rest) != Some(&shape[..]) || lengths != [rows; 3] {
        let received = format!("shape {}", shape_text(&wide));
        let expected = format!("branches of targets of shape {}", shape_text(&shape));
        return Err(errors::argument(q.py(), "q", &received, &expected));
    }
    Ok(Branches::new(shape, dof, all, None))
}
