//! How numbers are worked through: SIMD lanes, threads, random streams, errors.
//!
//! Knows no geometry and no robot. The only crate with `unsafe` code, all of it in [`lanes`].

pub mod allowed;
pub mod error;
pub mod lanes;
mod pool;
pub mod random;

pub mod threads;

pub use allowed::{Allowed, Field, Number};
pub use error::{Error, Result};
