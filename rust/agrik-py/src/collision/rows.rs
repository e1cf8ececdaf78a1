//! Rows of numbers with labels, as solids come.

use agrik::Error;
use pyo3::prelude::*;

use crate::convert::{Floats, shape_text, wrong_shape};
use crate::errors;

/// Rows of `N` numbers each; none where the argument is left out.
pub struct Rows<'py, const N: usize> {
    name: &'static str,
    floats: Option<Floats<'py>>,
}

impl<'py, const N: usize> Rows<'py, N> {
    pub fn new(name: &'static str, value: Option<&Bound<'py, PyAny>>) -> PyResult<Self> {
        let Some(value) = value else { return Ok(Self { name, floats: None }) };
        let floats = Floats::new(name, value)?;
        let empty = floats.shape().contains(&0);
        if !empty && (floats.shape().len() != 2 || floats.shape()[1] != N) {
            return Err(wrong_shape(value.py(), name, floats.shape(), &format!("(n, {N})")));
        }
        Ok(Self { name, floats: Some(floats).filter(|_| !empty) })
    }

    pub fn rows(&self) -> PyResult<&[[f64; N]]> {
        Ok(match &self.floats {
            Some(floats) => floats.values()?.as_chunks().0,
            None => &[],
        })
    }

    /// The error of a row, with the row in its words.
    pub fn error(&self, py: Python<'_>, row: usize, error: Error) -> PyErr {
        of_row(py, self.name, row, error)
    }
}

/// An error of the core about one row of an argument, with the row in its words.
pub fn of_row(py: Python<'_>, name: &str, row: usize, error: Error) -> PyErr {
    match error {
        Error::Argument { argument, received, expected } => {
            errors::argument(py, &format!("{name}[{row}], {argument}"), &received, &expected)
        }
        other => errors::from_core(py, other),
    }
}

/// Which of `count` names each of `rows` solids belongs to.
pub fn labels(
    py: Python<'_>,
    name: &str,
    value: Option<&Bound<'_, PyAny>>,
    rows: usize,
    count: usize,
) -> PyResult<Vec<usize>> {
    let given = value.map(|value| Floats::new(name, value)).transpose()?;
    let (shape, values) = match &given {
        Some(floats) => (floats.shape(), floats.values()?),
        None => (&[0][..], &[][..]),
    };
    if values.len() != rows || shape.len() > 1 {
        let expected = format!("({rows},), one label a row");
        let received = format!("shape {}", shape_text(shape));
        return Err(errors::argument(py, name, &received, &format!("shape {expected}")));
    }
    let label = |(row, x): (usize, &f64)| {
        if *x >= 0.0 && *x < count as f64 && x.fract() == 0.0 {
            return Ok(*x as usize);
        }
        let expected = format!("an index of the {count} names, from 0");
        Err(errors::argument(py, &format!("{name}[{row}]"), &x.to_string(), &expected))
    };
    values.iter().enumerate().map(label).collect()
}
