//! The free angle of S-R-S arms: what the limits leave of it, and the best one.

pub(crate) mod intervals;
mod proof;
mod proof_costs;
mod proof_ranges;
pub(crate) mod search;
mod sweep;

pub use super::geometry::pieces::Interval;
pub use intervals::intervals;
