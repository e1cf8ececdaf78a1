//! Solvers: from names and objects of `agrik_fast.solvers` to the core's settings; tuning.

mod gains;
mod population;
pub mod solver;
pub mod tune;
