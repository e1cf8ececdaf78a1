//! Closed forms: arms whose geometry gives the joint values without iteration.

pub mod strawberry;
pub mod tomato;
