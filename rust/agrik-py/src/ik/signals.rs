//! Ctrl-C: signals that Python has received while a call is at work.

use std::time::{Duration, Instant};

use agrik::Error;
use pyo3::prelude::*;

use crate::errors;

/// Time between two looks at pending signals of a call that has released the interpreter
/// and has to wait for it each time. Results do not depend on it.
const DETACHED_PERIOD: Duration = Duration::from_millis(50);
/// The same for a call that holds the interpreter, which others may be waiting for. Several
/// times the 5 ms after which a waiting thread asks for its turn: let go before it has
/// asked, the interpreter would be taken back at once.
const ATTACHED_PERIOD: Duration = Duration::from_millis(20);

/// Asks Python from time to time whether a signal (Ctrl-C) ends the call.
pub struct Signals {
    last: Instant,
    raised: Option<PyErr>,
}

impl Signals {
    pub fn new() -> Self {
        Self { last: Instant::now(), raised: None }
    }

    /// For a call that has released the interpreter.
    pub fn go_on_detached(&mut self) -> bool {
        !self.is_due(DETACHED_PERIOD) || Python::attach(|py| self.check(py))
    }

    /// For a short call that has not: lets the other threads have a turn as well.
    pub fn go_on_attached(&mut self, py: Python<'_>) -> bool {
        if !self.is_due(ATTACHED_PERIOD) {
            return true;
        }
        py.detach(|| ());
        self.check(py)
    }

    /// [`Signals::go_on_attached`] for a loop of the bindings' own.
    pub fn check_attached(&mut self, py: Python<'_>) -> PyResult<()> {
        if self.go_on_attached(py) {
            return Ok(());
        }
        Err(self.raised.take().unwrap_or_else(|| errors::from_core(py, Error::Interrupted)))
    }

    /// The exception for a call that failed: what the signal raised, if one ended it.
    pub fn exception(self, py: Python<'_>, error: Error) -> PyErr {
        self.raised.unwrap_or_else(|| errors::from_core(py, error))
    }

    fn is_due(&mut self, period: Duration) -> bool {
        let due = self.last.elapsed() >= period;
        if due {
            self.last = Instant::now();
        }
        due
    }

    fn check(&mut self, py: Python<'_>) -> bool {
        match py.check_signals() {
            Ok(()) => true,
            Err(error) => {
                self.raised = Some(error);
                false
            }
        }
    }
}
