//! Threads and instruction sets of batch calls.

use std::ffi::CString;

use agrik::lanes::{Level, VARIABLE};
use pyo3::exceptions::PyRuntimeWarning;
use pyo3::prelude::*;

use crate::convert::whole;

/// The most threads that can be asked for: more is a slip of the keyboard.
const MOST: u64 = 65_536;

/// Set the number of threads of batch calls in this process; None goes back to the
/// environment's choice.
#[pyfunction]
#[pyo3(signature = (n))]
pub fn set_num_threads(n: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
    agrik::threads::set_num_threads(number(n, "n")?);
    Ok(())
}

/// Return the number of threads that a batch call uses by default.
#[pyfunction]
pub fn get_num_threads() -> usize {
    agrik::threads::num_threads()
}

/// Return the instruction set that the batch loops use on this machine.
#[pyfunction]
pub fn simd_level() -> &'static str {
    Level::in_use().name()
}

/// Warns who asks the environment for an instruction set that this machine lacks or that
/// nobody has heard of: the call would silently be another one than was meant.
pub fn warn_of_unmet_wish(py: Python<'_>) -> PyResult<()> {
    let Some(wish) = Level::unmet_wish() else { return Ok(()) };
    let available = Level::ALL.iter().filter(|level| level.is_available());
    let names: Vec<_> = available.map(|level| level.name()).collect();
    let message = format!(
        "environment variable {VARIABLE}: expected one of {} on this machine, got {wish:?}; \
         using {}",
        names.join(", "),
        Level::in_use().name(),
    );
    let category = py.get_type::<PyRuntimeWarning>();
    // Debug formatting has no zero bytes.
    let message = CString::new(message).unwrap_or_default();
    PyErr::warn(py, &category, &message, 1)
}

/// A number of threads as the core takes it: 0 where the caller does not say.
pub fn number(threads: Option<&Bound<'_, PyAny>>, argument: &str) -> PyResult<usize> {
    threads.map_or(Ok(0), |value| Ok(whole(argument, value, 1, MOST)? as usize))
}
