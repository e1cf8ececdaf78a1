//! Arguments from Python: arrays of any kind of number, transforms, numbers; and arrays
//! back to Python.

use agrik::threads::share;
use nalgebra::{IsometryMatrix3, Matrix3, Rotation3, Translation3};
use numpy::ndarray::{ArrayView, Dimension, IntoDimension, IxDyn};
use numpy::{
    Element, PyArray, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn,
    PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyBool, PyFloat, PyInt, PyString};

use crate::errors;

/// How far a transform may be from a rigid one, in the entries of `R^T R` (no unit).
const RIGID: f64 = 1e-6;
/// Below this a rotation is as good as doubles can say it, and is left as it came.
const ROUNDING: f64 = 1e-14;
/// Arrays of at most this many numbers are handed to Python as copies, which is quicker
/// than handing over the memory.
pub const SMALL: usize = 512;
/// Most dimensions of an array: newer NumPys have more, their interface for Rust has not.
const MOST_DIMENSIONS: usize = 32;
/// Numbers that a thread copies at a time.
const PIECE: usize = 1 << 14;

/// Numbers of an argument as doubles in C order, in memory that nobody else holds: no other
/// thread can write to it, so it stays valid while the interpreter is released.
pub struct Floats<'py> {
    shape: Vec<usize>,
    numbers: Private<'py>,
}

/// Memory of our own, or that of an array that was made for us.
enum Private<'py> {
    Copied(Vec<f64>),
    Converted(PyReadonlyArrayDyn<'py, f64>),
}

impl<'py> Floats<'py> {
    /// A private copy of the numbers in `value`.
    pub fn new(argument: &str, value: &Bound<'py, PyAny>) -> PyResult<Self> {
        Self::many(argument, value, 1)
    }

    /// [`Floats::new`] with up to so many threads (0: the number in force), which share the
    /// copying of a long array; the interpreter is held meanwhile.
    pub fn many(argument: &str, value: &Bound<'py, PyAny>, threads: usize) -> PyResult<Self> {
        let array = numbers(argument, value)?;
        let shape = array.shape().to_vec();
        // `as_slice` takes Fortran order as well.
        if let Ok(doubles) = array.cast::<PyArrayDyn<f64>>()
            && doubles.is_c_contiguous()
            && let Ok(view) = doubles.try_readonly()
            && let Ok(values) = view.as_slice()
        {
            return Ok(Self { shape, numbers: Private::Copied(copy(values, threads)) });
        }
        let double = numpy::dtype::<f64>(value.py());
        let made = array.call_method1("astype", (double, "C", "same_kind", false, true))?;
        let made = made.cast_into::<PyArrayDyn<f64>>()?;
        Ok(Self { shape, numbers: Private::Converted(made.try_readonly().map_err(internal)?) })
    }

    /// A private copy of numbers whose shape must match.
    pub fn of_shape(argument: &str, value: &Bound<'py, PyAny>, shape: &[usize]) -> PyResult<Self> {
        let floats = Self::new(argument, value)?;
        if floats.shape() == shape {
            return Ok(floats);
        }
        Err(wrong_shape(value.py(), argument, floats.shape(), &shape_text(shape)))
    }

    /// The lengths of the dimensions.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// All numbers, last dimension fastest.
    pub fn values(&self) -> PyResult<&[f64]> {
        match &self.numbers {
            Private::Copied(values) => Ok(values),
            Private::Converted(array) => array.as_slice().map_err(internal),
        }
    }
}

/// A copy made by several threads: most of its time goes into memory that is touched for
/// the first time.
fn copy(values: &[f64], threads: usize) -> Vec<f64> {
    if values.len() <= PIECE {
        return values.to_vec();
    }
    let mut copied = vec![0.0; values.len()];
    let pieces = values.chunks(PIECE).zip(copied.chunks_mut(PIECE)).collect();
    share(pieces, threads, &|(from, to)| to.copy_from_slice(from), &mut || true);
    copied
}

/// `value` as a NumPy array of real numbers, converted only if it is none yet.
pub fn numbers<'py>(
    argument: &str,
    value: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyUntypedArray>> {
    static ASARRAY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let py = value.py();
    let array = match value.cast_exact::<PyUntypedArray>() {
        Ok(array) => array.clone(),
        Err(_) => {
            let made = ASARRAY.import(py, "numpy", "asarray")?.call1((value,));
            let made = made.map_err(|error| {
                if !error.is_instance_of::<PyValueError>(py) {
                    return error;
                }
                errors::argument(py, argument, "rows of unequal length", "an array of numbers")
            })?;
            made.cast_into::<PyUntypedArray>()?
        }
    };
    let dtype = array.dtype();
    if !matches!(dtype.kind(), b'f' | b'i' | b'u') {
        let received = format!("an array of {dtype}");
        return Err(errors::argument(py, argument, &received, "an array of numbers"));
    }
    check_dimensions(py, argument, array.ndim())?;
    Ok(array)
}

/// Refuses an argument that has too many dimensions, or whose answer would have.
pub fn check_dimensions(py: Python<'_>, argument: &str, count: usize) -> PyResult<()> {
    if count <= MOST_DIMENSIONS {
        return Ok(());
    }
    let received = format!("{count} dimensions of it or its answer");
    let expected = format!("at most {MOST_DIMENSIONS} dimensions");
    Err(errors::argument(py, argument, &received, &expected))
}

/// A shape the way Python writes it.
pub fn shape_text(shape: &[usize]) -> String {
    match shape {
        [one] => format!("({one},)"),
        _ => {
            let sizes: Vec<String> = shape.iter().map(ToString::to_string).collect();
            format!("({})", sizes.join(", "))
        }
    }
}

/// The exception for an array of another shape.
pub fn wrong_shape(py: Python<'_>, argument: &str, shape: &[usize], expected: &str) -> PyErr {
    let received = format!("shape {}", shape_text(shape));
    errors::argument(py, argument, &received, &format!("shape {expected}"))
}

/// What a pose or a base or tool transform must be.
pub const RIGID_TRANSFORM: &str = "a rigid transform, [R t; 0 0 0 1] with R^T R = 1 and det R = 1";

/// A 4x4 matrix (row by row) is a rigid transform; NaN is none.
pub fn is_rigid(m: &[f64; 16]) -> bool {
    m[12..] == [0.0, 0.0, 0.0, 1.0] && rotation_defect(m) <= RIGID && determinant(m) > 0.0
}

/// What keeps a matrix from being a rigid transform.
pub fn why_not_rigid(m: &[f64; 16]) -> String {
    if !m.iter().all(|x| x.is_finite()) {
        return "NaN or infinity".to_owned();
    }
    if m[12..] != [0.0, 0.0, 0.0, 1.0] {
        return format!("last row {:?}", &m[12..]);
    }
    let defect = rotation_defect(m);
    if defect <= RIGID {
        "a reflection, det R = -1".to_owned()
    } else {
        format!("|R^T R - 1| = {defect:.1e}")
    }
}

fn determinant(m: &[f64; 16]) -> f64 {
    m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8])
        + m[2] * (m[4] * m[9] - m[5] * m[8])
}

/// The largest entry of `|R^T R - 1|`.
fn rotation_defect(m: &[f64; 16]) -> f64 {
    let mut off: f64 = 0.0;
    for i in 0..3 {
        for j in 0..=i {
            let dot = m[i] * m[j] + m[4 + i] * m[4 + j] + m[8 + i] * m[8 + j];
            let defect = (dot - f64::from(u8::from(i == j))).abs();
            // `max` would drop a NaN.
            off = if defect > off || defect.is_nan() { defect } else { off };
        }
    }
    off
}

/// A rigid transform from a 4x4 array.
pub fn transform(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<IsometryMatrix3<f64>> {
    let floats = Floats::of_shape(argument, value, &[4, 4])?;
    let mut m = [0.0; 16];
    m.copy_from_slice(floats.values()?);
    if !is_rigid(&m) {
        return Err(errors::argument(value.py(), argument, &why_not_rigid(&m), RIGID_TRANSFORM));
    }
    let matrix = Matrix3::new(m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]);
    let mut rotation = Rotation3::from_matrix_unchecked(matrix);
    if rotation_defect(&m) > ROUNDING {
        rotation.renormalize();
    }
    Ok(IsometryMatrix3::from_parts(Translation3::new(m[3], m[7], m[11]), rotation))
}

/// A transform, or the identity where there is none.
pub fn transform_or_identity(
    argument: &str,
    value: Option<&Bound<'_, PyAny>>,
) -> PyResult<IsometryMatrix3<f64>> {
    value.map_or_else(|| Ok(IsometryMatrix3::identity()), |value| transform(argument, value))
}

/// A whole number in `low..=high`.
pub fn whole(argument: &str, value: &Bound<'_, PyAny>, low: u64, high: u64) -> PyResult<u64> {
    // `True` is no count, though Python takes it for a number.
    let number = if value.is_exact_instance_of::<PyInt>() || !value.is_instance_of::<PyBool>() {
        value.extract::<u64>().ok()
    } else {
        None
    };
    match number {
        Some(number) if (low..=high).contains(&number) => Ok(number),
        _ => {
            let expected = format!("a whole number, {low} to {high}");
            Err(errors::value(argument, value, &expected))
        }
    }
}

/// A whole number that may be left out, 0 then.
pub fn index(argument: &str, value: Option<&Bound<'_, PyAny>>) -> PyResult<u64> {
    value.map_or(Ok(0), |value| whole(argument, value, 0, u64::MAX))
}

/// A number; its range is the caller's business.
pub fn real(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    if let Ok(number) = value.cast_exact::<PyFloat>() {
        return Ok(number.value());
    }
    let number = if value.is_instance_of::<PyBool>() { None } else { value.extract().ok() };
    number.ok_or_else(|| errors::value(argument, value, "a number"))
}

/// One of a few words; what it means stands beside each.
#[inline]
pub fn word<T: Copy>(kind: &str, value: &Bound<'_, PyAny>, known: &[(&str, T)]) -> PyResult<T> {
    let names = || known.iter().map(|(name, _)| *name).collect::<Vec<_>>();
    let Ok(text) = value.cast::<PyString>() else {
        return Err(errors::value(kind, value, &format!("one of {}", names().join(", "))));
    };
    let text = text.to_string_lossy();
    let found = known.iter().find(|(name, _)| *name == text);
    found
        .map(|(_, meant)| *meant)
        .ok_or_else(|| errors::unknown_name(value.py(), kind, &text, &names()))
}

/// True or False, and nothing that merely counts as one.
#[inline]
pub fn truth(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<bool> {
    if let Ok(truth) = value.cast_exact::<PyBool>() {
        return Ok(truth.is_true());
    }
    // NumPy's truth values are no bool, and are taken for one.
    value.extract().map_err(|_| errors::value(argument, value, "True or False"))
}

/// An array for Python that holds a copy of numbers in C order.
pub fn copied<'py, T: Element + Copy>(
    py: Python<'py>,
    shape: &[usize],
    values: &[T],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let view = ArrayView::from_shape(shape.into_dimension(), values).map_err(internal)?;
    Ok(PyArray::from_array(py, &view))
}

/// An array for Python out of numbers in C order.
pub fn array<'py, T: Element + Copy>(
    py: Python<'py>,
    shape: &[usize],
    values: Vec<T>,
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let shape: IxDyn = shape.into_dimension();
    if shape.size() <= SMALL {
        return copied(py, shape.slice(), &values);
    }
    let owned = numpy::ndarray::Array::from_shape_vec(shape, values).map_err(internal)?;
    Ok(PyArray::from_owned_array(py, owned))
}

/// An error that no argument can cause; said rather than panicked.
pub fn internal(error: impl std::fmt::Display) -> PyErr {
    PyRuntimeError::new_err(format!("agrik_fast: {error}"))
}
