//! The record of all branches of a call; its arrays are made when they are asked for.

use std::sync::OnceLock;

use agrik::call::Status;
use agrik::closed_form::{self, Alone};
use numpy::{PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;
use smallvec::SmallVec;

use crate::convert::{array, copied, internal, shape_text};
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
    /// Of a single target made when the first of them is asked for.
    columns: OnceLock<Box<Columns>>,
    /// Codes to be added to the warnings, one a target or none at all.
    more: Vec<u8>,
}

/// The columns of a record.
struct Columns {
    q: Column<f64>,
    valid: Column<bool>,
    reached: Column<bool>,
    singular: Column<u8>,
    status: Column<u8>,
    warnings: Sparse<u8>,
    free: Sparse<i8>,
    values: Sparse<f64>,
    numbers: Sparse<u32>,
    left: Sparse<f64>,
    off: Sparse<f64>,
}

impl Columns {
    fn new(all: closed_form::Branches, q: Option<Py<PyArrayDyn<f64>>>) -> Self {
        Self {
            q: q.map_or_else(|| Column::new(all.q), Column::made),
            valid: Column::new(all.valid),
            reached: Column::new(all.reached),
            singular: Column::new(all.singular),
            status: Column::new(all.status),
            warnings: Sparse::new(all.warnings),
            free: Sparse::new(all.free),
            values: Sparse::new(all.values),
            numbers: Sparse::new(all.numbers),
            left: Sparse::new(all.left),
            off: Sparse::new(all.off),
        }
    }
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
        let solved = all.status.iter().filter(|status| has_branch(**status)).count();
        let targets = all.status.len();
        Self {
            shape,
            dof,
            branches: all.branches,
            targets,
            solved,
            alone: None,
            columns: OnceLock::from(Box::new(Columns::new(all, q))),
            more: Vec::new(),
        }
    }

    /// The record of a single target.
    pub fn of_one(dof: usize, alone: Box<Alone>) -> Self {
        let branches = alone.branches();
        Self {
            shape: Vec::new(),
            dof,
            branches,
            targets: 1,
            solved: usize::from(has_branch(alone.status() as u8)),
            alone: Some(alone),
            columns: OnceLock::new(),
            more: Vec::new(),
        }
    }

    fn columns(&self) -> &Columns {
        self.columns.get_or_init(|| Box::new(Columns::new(closed_form::Branches::default(), None)))
    }

    /// The same record with more warnings, one a target or none at all.
    pub fn with_warnings(self, more: Vec<u8>) -> Self {
        Self { more, ..self }
    }

    fn with(&self, last: &[usize]) -> Vec<usize> {
        [&self.shape, last].concat()
    }
}

/// A target with this status has a valid branch.
fn has_branch(status: u8) -> bool {
    status == Status::Converged as u8 || status == Status::SingularFamily as u8
}

/// A column that most calls have nothing to put into: filled when it is asked for.
struct Sparse<T> {
    column: Column<T>,
    empty: bool,
}

impl<T: numpy::Element + Copy> Sparse<T> {
    fn new(values: Vec<T>) -> Self {
        Self { empty: values.is_empty(), column: Column::new(values) }
    }

    /// The array; of an empty column with `number` of each place in it.
    fn get<'py>(
        &self,
        py: Python<'py>,
        shape: &[usize],
        number: impl Fn(usize) -> T,
    ) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
        if !self.empty {
            return self.column.get(py, shape);
        }
        let count = shape.iter().product();
        self.column.get_or(py, || array(py, shape, (0..count).map(number).collect()))
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
            return self.columns().q.get(py, &self.with(&[self.branches, self.dof]));
        };
        self.columns().q.get_or(py, || copied(py, &[self.branches, self.dof], one.q()))
    }

    /// Reached by forward kinematics, inside the limits, no branch twice.
    #[getter]
    fn valid<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
        match &self.alone {
            None => self.columns().valid.get(py, &self.with(&[self.branches])),
            Some(one) => self.columns().valid.get_or(py, || each(py, one, Alone::valid)),
        }
    }

    /// `valid` without regard to the limits.
    #[getter]
    fn reached<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
        match &self.alone {
            None => self.columns().reached.get(py, &self.with(&[self.branches])),
            Some(one) => self.columns().reached.get_or(py, || each(py, one, Alone::reached)),
        }
    }

    /// Singularities of each branch, a sum of codes of `agrik_fast.Singularity`.
    #[getter]
    fn singular<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<u8>>> {
        match &self.alone {
            None => self.columns().singular.get(py, &self.with(&[self.branches])),
            Some(one) => self.columns().singular.get_or(py, || each(py, one, Alone::singular)),
        }
    }

    /// Codes of `agrik_fast.Status`.
    #[getter]
    fn status<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<u8>>> {
        match &self.alone {
            None => self.columns().status.get(py, &self.shape),
            Some(one) => {
                self.columns().status.get_or(py, || copied(py, &[], &[one.status() as u8]))
            }
        }
    }

    /// Sums of codes of `agrik_fast.Warnings`.
    #[getter]
    fn warnings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<u8>>> {
        let own = self
            .columns()
            .warnings
            .get(py, &self.shape, |_| self.alone.as_ref().map_or(0, |one| one.warnings()))?;
        if self.more.is_empty() {
            return Ok(own);
        }
        let codes = own.try_readonly().map_err(internal)?;
        let all = codes.as_array().iter().zip(&self.more).map(|(a, b)| a | b).collect();
        array(py, &self.shape, all)
    }

    /// Entry of `q` that a singularity leaves free, -1 for none.
    #[getter]
    fn free_joint<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<i8>>> {
        self.columns()
            .free
            .get(py, &self.shape, |_| self.alone.as_ref().map_or(-1, |one| one.free_joint()))
    }

    /// Value of the swept joint or arm angle of each branch; NaN without a sweep.
    #[getter]
    fn value<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.columns().values.get(py, &self.with(&[self.branches]), |_| f64::NAN)
    }

    /// Number of each branch among those of its value.
    #[getter]
    fn branch<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<u32>>> {
        self.columns()
            .numbers
            .get(py, &self.with(&[self.branches]), |i| (i % self.branches.max(1)) as u32)
    }

    /// Least angle left of targets that ask for more than the arm has joints for, rad.
    #[getter]
    fn orientation_error<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.columns().left.get(py, &self.shape, |_| 0.0)
    }

    /// Distance that goes with it, m; 0 for targets that are reached.
    #[getter]
    fn position_error<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.columns().off.get(py, &self.shape, |_| 0.0)
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
#[pyo3(signature = (
    q, valid, reached, singular, status, warnings, free_joint, value, branch, orientation_error,
    position_error=None
))]
#[allow(clippy::too_many_arguments)]
pub fn branches(
    q: &Bound<'_, PyAny>,
    valid: &Bound<'_, PyAny>,
    reached: &Bound<'_, PyAny>,
    singular: &Bound<'_, PyAny>,
    status: &Bound<'_, PyAny>,
    warnings: &Bound<'_, PyAny>,
    free_joint: &Bound<'_, PyAny>,
    value: &Bound<'_, PyAny>,
    branch: &Bound<'_, PyAny>,
    orientation_error: &Bound<'_, PyAny>,
    position_error: Option<&Bound<'_, PyAny>>,
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
        warnings: column("warnings", warnings)?.1,
        free: column("free_joint", free_joint)?.1,
        values: column("value", value)?.1,
        numbers: column("branch", branch)?.1,
        left: column("orientation_error", orientation_error)?.1,
        // Records of earlier versions have none.
        off: match position_error {
            Some(errors) => column("position_error", errors)?.1,
            None => vec![0.0; shape.iter().product()],
        },
    };
    let (rows, targets): (usize, usize) = (wide.iter().product(), shape.iter().product());
    let of_branches = [
        all.valid.len(),
        all.reached.len(),
        all.singular.len(),
        all.values.len(),
        all.numbers.len(),
    ];
    let of_targets = [all.warnings.len(), all.free.len(), all.left.len(), all.off.len()];
    let fit = of_branches == [rows; 5] && of_targets == [targets; 4];
    if wide.split_last().map(|(_, rest)| rest) != Some(&shape[..]) || !fit {
        let received = format!("shape {}", shape_text(&wide));
        let expected = format!("branches of targets of shape {}", shape_text(&shape));
        return Err(errors::argument(q.py(), "q", &received, &expected));
    }
    Ok(Branches::new(shape, dof, all, None))
}
