//! Rows of a CSV file: numbers as doubles, other fields as texts.
//!
//! The dialect is the usual one: fields between commas, quoted where they hold commas, quotes
//! (doubled) or line ends; lines that begin with `#` and blank ones are no rows. A row is held
//! in memory as a whole, so its length is limited while it is read.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering::Relaxed};

use csv::{ByteRecord, ReaderBuilder};
use numpy::PyArrayDyn;
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;

use crate::convert::array;

/// Bytes that are read ahead.
const BUFFER: usize = 64 << 10;
/// Letters of a field that a message shows.
const SHOWN: usize = 60;
const MARK: &[u8] = b"\xef\xbb\xbf";

/// A file that ends with an error where a row goes on for too long.
struct Limited {
    file: File,
    read: Arc<Progress>,
    limit: usize,
}

/// How far a file has been read.
#[derive(Default)]
struct Progress {
    since_row: AtomicUsize,
    bytes: AtomicU64,
    /// The last byte ended a line.
    line_ended: AtomicBool,
}

impl Read for Limited {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(buffer)?;
        if let Some(&last) = buffer[..count].last() {
            self.read.line_ended.store(last == b'\n', Relaxed);
            self.read.bytes.fetch_add(count as u64, Relaxed);
        }
        let before = self.read.since_row.fetch_add(count, Relaxed);
        // What was read ahead belongs to the rows before.
        if before + count > self.limit + 2 * BUFFER {
            return Err(io::Error::other(Endless));
        }
        Ok(count)
    }
}

/// A row longer than any may be.
#[derive(Debug)]
struct Endless;

impl std::fmt::Display for Endless {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a row without an end")
    }
}

impl std::error::Error for Endless {}

/// Where a row stands and what is in it.
struct Rows {
    reader: csv::Reader<Limited>,
    read: Arc<Progress>,
    limit: usize,
    record: ByteRecord,
    /// Line on which the row begins, from 1.
    line: u64,
}

impl Rows {
    fn open(py: Python<'_>, path: &Path, limit: usize) -> PyResult<Self> {
        let read = Arc::new(Progress::default());
        let file = File::open(path).map_err(|error| of_system(py, &error))?;
        let limited = Limited { file, read: Arc::clone(&read), limit };
        let reader = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .buffer_capacity(BUFFER)
            .from_reader(limited);
        Ok(Self { reader, read, limit, record: ByteRecord::new(), line: 0 })
    }

    /// Goes to the next row that is neither blank nor a comment; false at the end.
    fn advance(&mut self, py: Python<'_>) -> PyResult<bool> {
        loop {
            let before = self.reader.position().line();
            match self.reader.read_byte_record(&mut self.record) {
                Ok(false) => return Ok(false),
                Ok(true) => {}
                Err(error) => return Err(self.fault(py, error, before)),
            }
            self.read.since_row.store(0, Relaxed);
            let first_row = self.line == 0;
            self.line = self.first_line();
            if self.record.as_slice().len() > self.limit {
                return Err(too_long(self.line, self.limit));
            }
            if first_row && self.record.get(0).is_some_and(|field| field.starts_with(MARK)) {
                self.without_mark();
            }
            let first = self.record.get(0).unwrap_or_default().trim_ascii_start();
            let blank = self.record.len() == 1 && first.is_empty();
            if !blank && !first.starts_with(b"#") {
                return Ok(true);
            }
        }
    }

    /// The line on which the present row begins. Its position would be that of the blank lines
    /// before it, so it is counted from its end.
    fn first_line(&self) -> u64 {
        let (position, read) = (self.reader.position(), &self.read);
        let at_end = position.byte() >= read.bytes.load(Relaxed);
        let unended = at_end && !read.line_ended.load(Relaxed);
        let inside: u64 = self.record.iter().map(lines).sum();
        position.line().saturating_sub(inside + u64::from(!unended)).max(1)
    }

    /// Takes off the byte order mark that spreadsheet programs put before the first column's
    /// name.
    fn without_mark(&mut self) {
        let fields: Vec<Vec<u8>> = self
            .record
            .iter()
            .enumerate()
            .map(|(i, field)| field[if i == 0 { MARK.len() } else { 0 }..].to_vec())
            .collect();
        let unquoted = fields.into_iter().map(|field| match &field[..] {
            [b'"', inner @ .., b'"'] => inner.to_vec(),
            _ => field,
        });
        self.record = unquoted.collect();
    }

    fn fault(&self, py: Python<'_>, error: csv::Error, line: u64) -> PyErr {
        match error.into_kind() {
            csv::ErrorKind::Io(error)
                if error.get_ref().is_some_and(|inner| inner.is::<Endless>()) =>
            {
                too_long(line, self.limit)
            }
            csv::ErrorKind::Io(error) => of_system(py, &error),
            other => PyValueError::new_err(format!("line {line}: {other:?}")),
        }
    }

    fn text(&self, at: usize) -> PyResult<&str> {
        let field = self.record.get(at).unwrap_or_default();
        std::str::from_utf8(field).map_err(|_| {
            // The field may go over several lines.
            let before = self.record.iter().take(at + 1).map(|f| lines(valid(f)));
            let line = self.line + before.sum::<u64>();
            PyValueError::new_err(format!("line {line}: is not UTF-8 text"))
        })
    }
}

/// The part of a field that is text.
fn valid(field: &[u8]) -> &[u8] {
    match std::str::from_utf8(field) {
        Ok(_) => field,
        Err(error) => &field[..error.valid_up_to()],
    }
}

/// The system's error as Python has it.
fn of_system(py: Python<'_>, error: &io::Error) -> PyErr {
    let number = error.raw_os_error().unwrap_or(0);
    let words = py
        .import("os")
        .and_then(|os| os.call_method1("strerror", (number,)))
        .and_then(|words| words.extract::<String>())
        .unwrap_or_else(|_| error.to_string());
    PyOSError::new_err((number, words))
}

fn lines(text: &[u8]) -> u64 {
    text.iter().filter(|&&b| b == b'\n').count() as u64
}

fn too_long(line: u64, limit: usize) -> PyErr {
    PyValueError::new_err(format!("line {line}: a row of more than {limit} letters"))
}

/// A number as Python's `float` reads it, but for its underscores.
fn number(field: &[u8]) -> Option<f64> {
    std::str::from_utf8(field.trim_ascii()).ok()?.parse().ok()
}

/// Rows of a CSV file, read in blocks.
#[pyclass(module = "agrik_fast._native")]
pub struct CsvRows {
    rows: Rows,
    header: Vec<String>,
    /// Rows after the header so far.
    count: usize,
}

#[pymethods]
impl CsvRows {
    /// Open a file and read its header; rows of more than `limit` bytes are refused.
    #[new]
    fn new(py: Python<'_>, path: PathBuf, limit: usize) -> PyResult<Self> {
        let mut rows = Rows::open(py, &path, limit)?;
        let mut header = Vec::new();
        if rows.advance(py)? {
            for at in 0..rows.record.len() {
                header.push(rows.text(at)?.trim().to_string());
            }
        }
        Ok(Self { rows, header, count: 0 })
    }

    /// Names of the columns; none where the file holds no row.
    #[getter]
    fn header(&self) -> Vec<String> {
        self.header.clone()
    }

    /// Read up to `size` rows, fewer where they take more than `bytes` together: numbers of
    /// the columns `numeric`, shape (n, k), texts of the columns `texts`, one list a column,
    /// and the line of each row.
    #[allow(clippy::type_complexity)]
    fn block<'py>(
        &mut self,
        py: Python<'py>,
        size: usize,
        bytes: usize,
        numeric: Vec<usize>,
        texts: Vec<usize>,
    ) -> PyResult<(Bound<'py, PyArrayDyn<f64>>, Vec<Vec<String>>, Vec<u64>)> {
        let mut numbers = Vec::new();
        let mut fields: Vec<Vec<String>> = vec![Vec::new(); texts.len()];
        let mut lines = Vec::new();
        let (mut letters, mut widest) = (0, 0);
        // Texts become as wide as the widest, four bytes a letter.
        let row_bytes = |widest: usize| 8 * numeric.len() + 4 * widest;
        while lines.len() < size
            && lines.len() * row_bytes(widest) + letters < bytes
            && self.rows.advance(py)?
        {
            self.count += 1;
            let (rows, row) = (&self.rows, self.count);
            let (found, wanted) = (rows.record.len(), self.header.len());
            if found != wanted {
                return Err(PyValueError::new_err(format!(
                    "row {row} (line {}): {found} fields, expected {wanted} as in the header",
                    rows.line
                )));
            }
            for &at in &numeric {
                let field = rows.record.get(at).unwrap_or_default();
                numbers.push(number(field).ok_or_else(|| self.no_number(at))?);
            }
            for (&at, column) in texts.iter().zip(&mut fields) {
                let text = rows.text(at)?.trim();
                letters += text.len();
                widest = widest.max(text.len());
                column.push(text.to_string());
            }
            lines.push(rows.line);
            if lines.len() % 4096 == 0 {
                py.check_signals()?;
            }
        }
        let shape = [lines.len(), numeric.len()];
        Ok((array(py, &shape, numbers)?, fields, lines))
    }
}

impl CsvRows {
    fn no_number(&self, at: usize) -> PyErr {
        let (rows, row) = (&self.rows, self.count);
        let text = match rows.text(at) {
            Ok(text) => text.trim(),
            Err(error) => return error,
        };
        let mut shown: String = format!("'{}'", text.escape_debug()).replace("\\'", "'");
        if shown.chars().count() > SHOWN {
            shown = shown.chars().take(SHOWN).chain("...".chars()).collect();
        }
        let column = &self.header[at];
        PyValueError::new_err(format!(
            "row {row} (line {}), column '{column}': expected a number, got {shown}",
            rows.line
        ))
    }
}
