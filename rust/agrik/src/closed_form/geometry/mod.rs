//! Axes, angles and limits: what families and branches are made of.

pub mod axes;
pub mod candidate;
pub mod limit;
pub mod quartic;
pub mod turn;
