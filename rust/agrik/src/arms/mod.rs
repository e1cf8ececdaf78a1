//! The papers' own arms, which need masses, servos and rules that a chain does not have.

use crate::error::{Error, Result};

pub mod strawberry;
pub mod tomato;

/// Targets between two questions whether to go on.
const ROWS_PER_POLL: usize = 256;

/// Whether a batch goes on with row `i`; asks every few rows.
fn goes_on(i: usize, poll: &mut dyn FnMut() -> bool) -> Result<()> {
    if i % ROWS_PER_POLL != ROWS_PER_POLL - 1 || poll() { Ok(()) } else { Err(Error::Interrupted) }
}

/// How far two points are apart.
fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}
