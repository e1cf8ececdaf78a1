//! Inverse kinematics: arguments in, interpreter released, record of answers out.

pub mod arguments;
pub mod batch;
pub mod branches;
pub mod control;
pub mod follow;
mod locked;
pub mod rates;
mod second;
pub mod signals;
pub mod straighten;
mod targets;
mod task;
