//! What makes a candidate an answer: limits, the check by forward kinematics, the choice.

pub mod check;
pub mod choice;
pub mod group;
pub mod open_angles;
pub mod polish;
pub mod unreachable;
