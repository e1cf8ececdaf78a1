//! `agrik`: fast, verified inverse kinematics for serial robot arms.
//!
//! Targets go through a [`chain::Chain`] (geometry, limits, tool), a [`task::Task`] (what
//! counts as reached) and a solver of [`solve`] (how to get there) to one record per
//! target, [`call::Answers`]. [`call`] is what all solvers are given and give back. Nothing here knows
//! of Python. Lengths are in metres, angles in radians.

pub mod arms;
pub mod auto;
pub mod call;
pub mod chain;
pub mod closed_form;
pub mod kinematics;
pub mod nearest;
pub mod solve;
pub mod solvers;
pub mod task;
pub mod tune;

pub use agrik_compute::allowed::LARGEST;
pub use agrik_compute::{
    Allowed, Error, Field, Number, Result, allowed, error, lanes, random, threads,
};
