//! Exceptions: the classes of `agrik_fast.errors`, raised from here.

use agrik::Error;
use pyo3::call::PyCallArgs;
use pyo3::exceptions::{PyAttributeError, PyKeyboardInterrupt, PyRuntimeError};
use pyo3::panic::PanicException;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

const MODULE: &str = "agrik_fast.errors";

/// A class of `agrik_fast.errors`, imported once.
struct Class {
    name: &'static str,
    class: PyOnceLock<Py<PyType>>,
}

impl Class {
    const fn new(name: &'static str) -> Self {
        Self { name, class: PyOnceLock::new() }
    }

    fn get<'py>(&self, py: Python<'py>) -> PyResult<&Bound<'py, PyType>> {
        self.class.import(py, MODULE, self.name)
    }

    fn with<'py>(&self, py: Python<'py>, args: impl PyCallArgs<'py>) -> PyErr {
        match self.get(py).and_then(|class| class.call1(args)) {
            Ok(exception) => PyErr::from_value(exception),
            // What kept the exception from being made says more than nothing.
            Err(error) => error,
        }
    }
}

static ARGUMENT_ERROR: Class = Class::new("ArgumentError");
static CONCURRENT_USE_ERROR: Class = Class::new("ConcurrentUseError");
static INTERNAL_ERROR: Class = Class::new("InternalError");
static UNKNOWN_NAME_ERROR: Class = Class::new("UnknownNameError");
static URDF_ERROR: Class = Class::new("UrdfError");

/// An `ArgumentError`: which argument, what came, what was expected.
pub fn argument(py: Python<'_>, argument: &str, received: &str, expected: &str) -> PyErr {
    ARGUMENT_ERROR.with(py, (argument, received, expected))
}

/// An `ArgumentError` that shows the value that came.
pub fn value(argument_name: &str, received: &Bound<'_, PyAny>, expected: &str) -> PyErr {
    let text = received.repr().map_or_else(|_| "an object".to_owned(), |text| text.to_string());
    argument(received.py(), argument_name, &text, expected)
}

/// What was read of an object's fields; a field that it lacks is its argument's fault.
pub fn whole_object<T>(
    argument_name: &str,
    object: &Bound<'_, PyAny>,
    expected: &str,
    read: PyResult<T>,
) -> PyResult<T> {
    read.map_err(|error| {
        let lacks = error.is_instance_of::<PyAttributeError>(object.py());
        if lacks { value(argument_name, object, expected) } else { error }
    })
}

/// An `UnknownNameError`, which finds the nearest of the known names itself.
pub fn unknown_name(py: Python<'_>, kind: &str, name: &str, known: &[&str]) -> PyErr {
    UNKNOWN_NAME_ERROR.with(py, (kind, name, known.to_vec()))
}

/// A `ConcurrentUseError`: an object that serves one caller at a time has one already.
pub fn concurrent_use(py: Python<'_>, object: &str, instead: &str) -> PyErr {
    CONCURRENT_USE_ERROR.with(py, (object, instead))
}

/// Makes panics `InternalError`s, which are caught by `except Exception` and ask for a report.
///
/// The one guard of all entry points, those to come included, and at no cost to a call: PyO3
/// catches a panic wherever Python calls in, and raises it as a class that is this module's
/// own. That class is given other parents, a name and with them its words.
pub fn guard_against_panics(py: Python<'_>) -> PyResult<()> {
    let raised = py.get_type::<PanicException>();
    // The built-in class comes first: the layout of instances has to stay as it is.
    let parents = (py.get_type::<PyRuntimeError>(), INTERNAL_ERROR.get(py)?);
    raised.setattr("__bases__", parents)?;
    raised.setattr("__module__", MODULE)?;
    raised.setattr("__name__", INTERNAL_ERROR.name)?;
    raised.setattr("__qualname__", INTERNAL_ERROR.name)
}

/// Panics: for the test of [`guard_against_panics`].
#[pyfunction]
#[allow(clippy::panic)]
pub fn _panic() {
    panic!("asked for by a test");
}

/// The exception that stands for an error of the core.
pub fn from_core(py: Python<'_>, error: Error) -> PyErr {
    match error {
        Error::Argument { argument: name, received, expected } => {
            argument(py, &name, &received, &expected)
        }
        Error::Description { message, .. } => URDF_ERROR.with(py, (message,)),
        Error::Interrupted => PyKeyboardInterrupt::new_err(()),
    }
}

/// Warns who imports a build without optimisation: it is many times slower.
pub fn warn_of_debug_build(py: Python<'_>) -> PyResult<()> {
    if cfg!(debug_assertions) {
        let category = py.get_type::<pyo3::exceptions::PyRuntimeWarning>();
        let message = c"agrik_fast was built without optimisation; build it with --release";
        PyErr::warn(py, &category, message, 1)?;
    }
    Ok(())
}
