//! Columns as the lines of a CSV file.

use std::fmt::Write as _;

use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyList};

use crate::errors;

/// One column of a block of rows.
enum Column<'py> {
    Doubles(numpy::PyReadonlyArray1<'py, f64>),
    Whole(numpy::PyReadonlyArray1<'py, i64>),
    Flags(numpy::PyReadonlyArray1<'py, bool>),
    Texts(Vec<String>),
}

impl<'py> Column<'py> {
    fn new(at: usize, value: &Bound<'py, PyAny>) -> PyResult<Self> {
        if let Ok(array) = value.cast::<PyArray1<f64>>() {
            return Ok(Self::Doubles(array.readonly()));
        }
        if let Ok(array) = value.cast::<PyArray1<i64>>() {
            return Ok(Self::Whole(array.readonly()));
        }
        if let Ok(array) = value.cast::<PyArray1<bool>>() {
            return Ok(Self::Flags(array.readonly()));
        }
        if let Ok(list) = value.cast::<PyList>() {
            return Ok(Self::Texts(list.extract()?));
        }
        let expected = "an array of float64, int64 or bool, or a list of texts";
        Err(errors::value(&format!("columns[{at}]"), value, expected))
    }

    fn len(&self) -> usize {
        match self {
            Self::Doubles(array) => array.as_array().len(),
            Self::Whole(array) => array.as_array().len(),
            Self::Flags(array) => array.as_array().len(),
            Self::Texts(texts) => texts.len(),
        }
    }

    /// Writes a field; numbers by their shortest text that reads back to the same bits.
    fn write(&self, row: usize, to: &mut String) {
        // Writing to a text cannot fail.
        let _ = match self {
            Self::Doubles(array) => {
                let value = array.as_array()[row];
                if value.is_nan() { to.write_str("nan") } else { write!(to, "{value:?}") }
            }
            Self::Whole(array) => write!(to, "{}", array.as_array()[row]),
            Self::Flags(array) => {
                to.write_str(if array.as_array()[row] { "true" } else { "false" })
            }
            Self::Texts(texts) => {
                quote(&texts[row], to);
                Ok(())
            }
        };
    }
}

/// A text as a field, between quotes where it would not be read back as it is.
fn quote(text: &str, to: &mut String) {
    let plain = !text.contains([',', '"', '\n', '\r']);
    if plain {
        to.push_str(text);
        return;
    }
    to.push('"');
    to.push_str(&text.replace('"', "\"\""));
    to.push('"');
}

/// Return the lines of columns of one length as bytes in UTF-8.
#[pyfunction]
pub fn csv_lines<'py>(
    py: Python<'py>,
    columns: Vec<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyBytes>> {
    let columns: Vec<Column<'py>> = columns
        .iter()
        .enumerate()
        .map(|(at, column)| Column::new(at, column))
        .collect::<PyResult<_>>()?;
    let rows = columns.first().map_or(0, Column::len);
    for (at, column) in columns.iter().enumerate() {
        if column.len() != rows {
            let received = format!("{} rows", column.len());
            let expected = format!("{rows}, as in the first column");
            return Err(errors::argument(py, &format!("columns[{at}]"), &received, &expected));
        }
    }
    let mut text = String::with_capacity(rows * columns.len() * 20);
    for row in 0..rows {
        for (at, column) in columns.iter().enumerate() {
            if at > 0 {
                text.push(',');
            }
            column.write(row, &mut text);
        }
        text.push('\n');
    }
    Ok(PyBytes::new(py, text.as_bytes()))
}
