//! What records of answers can do besides holding arrays (rows, tables, pickles): written in
//! Python, in `agrik_fast._records`, and handed on to there.

use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// Calls a function of `agrik_fast._records` with a record and more arguments.
pub fn hand_on<'py, T>(
    record: &Bound<'py, T>,
    function: &str,
    more: &[Bound<'py, PyAny>],
) -> PyResult<Bound<'py, PyAny>> {
    let py = record.py();
    let mut all = vec![record.as_any().clone()];
    all.extend_from_slice(more);
    let arguments = PyTuple::new(py, all)?;
    py.import("agrik_fast._records")?.call_method1(function, arguments)
}
