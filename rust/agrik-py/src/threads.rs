//! Threads and instruction sets of batch calls.

use pyo3::prelude::*;

use crate::convert::whole;

/// The most threads that can be asked for: more is a slip of the keyboard.
const MOST: u64 = 65_536;

/// Set the number of threads of batch calls in this process; None goes back to the
/// environment's choice.
#[pyfunction]
#[pyo3(signature = (n))]
pub fn set_num_threads(n: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
    agrik::batch::set_num_threads(number(n, "n")?);
    Ok(())
}

/// Return the number of threads that a batch call uses by default.
#[pyfunction]
pub fn get_num_threads() -> usize {
    agrik::batch::num_threads()
}

/// Return the instruction set that the batch loops use on this machine.
#[pyfunction]
pub fn simd_level() -> &'static str {
    agrik::lanes::Level::in_use().name()
}

/// A number of threads as the core takes it: 0 where the caller does not say.
pub fn number(threads: Option<&Bound<'_, PyAny>>, argument: &str) -> PyResult<usize> {
    threads.map_or(Ok(0), |value| Ok(whole(argument, value, 1, MOST)? as usize))
}
