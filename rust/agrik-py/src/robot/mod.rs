//! Chains: built from Python's descriptions, asked for frames and Jacobians.

mod build;
pub mod chain;
pub mod kinematics;
