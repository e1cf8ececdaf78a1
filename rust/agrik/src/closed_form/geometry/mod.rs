//! Axes, angles and limits: what families and branches are made of.

pub mod axes;
pub mod candidate;
pub mod enclosure;
pub mod limit;
pub mod mirrors;
pub mod pieces;
pub mod quartic;
pub mod range;
pub mod rigid;
pub mod screws;
pub mod serial;
pub mod turn;
