//! Ways that are proven free, and plans of them: functions on a `Collider`.

pub mod check;
pub mod plan;
pub mod settings;
