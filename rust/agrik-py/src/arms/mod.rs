//! The papers' own arms.

pub mod strawberry;
pub mod tomato;
