//! The record of all branches of a call; its arrays are made when they are asked for.

use agrik::closed_form::{self, BRANCHES};
use agrik::solve::Status;
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use crate::result::Column;

/// Every branch of the targets of one `Robot.ik_all` call.
#[pyclass(frozen, module = "agrik_fast._native")]
pub struct Branches {
    shape: Vec<usize>,
    dof: usize,
    targets: usize,
    solved: usize,
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
            targets: all.status.len(),
            solved,
            q: q.map_or_else(|| Column::new(all.q), Column::made),
            valid: Column::new(all.valid),
            reached: Column::new(all.reached),
            singular: Column::new(all.singular),
            status: Column::new(all.status),
        }
    }

    fn with(&self, last: &[usize]) -> Vec<usize> {
        [&self.shape, last].concat()
    }
}

#[pymethods]
impl Branches {
    /// Joint values, shape (..., branches, dof), rad; the nearest where not reached.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.q.get(py, &self.with(&[BRANCHES, self.dof]))
    }

    /// Reached by forward kinematics, inside the limits, no branch twice.
    #[getter]
    fn valid<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
        self.valid.get(py, &self.with(&[BRANCHES]))
    }

    /// `valid` without regard to the limits.
    #[getter]
    fn reached<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
        self.reached.get(py, &self.with(&[BRANCHES]))
    }

    /// Singularities of each branch, a sum of codes of `agrik_fast.Singularity`.
    #[getter]
    fn singular<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<u8>>> {
        self.singular.get(py, &self.with(&[BRANCHES]))
    }

    /// Codes of `agrik_fast.Status`.
    #[getter]
    fn status<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<u8>>> {
        self.status.get(py, &self.shape)
    }

    fn __repr__(&self) -> String {
        let plural = if self.targets == 1 { "" } else { "s" };
        format!("Branches({} target{plural}, {} with a valid branch)", self.targets, self.solved)
    }
}
