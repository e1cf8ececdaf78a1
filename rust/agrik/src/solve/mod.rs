//! Step solvers: one loop with an exchangeable step, one record of answers.

mod engine;
mod linear;
mod plan;
mod start;
mod step;

pub use engine::run;
pub use plan::{Answers, AnswersMut, Goals, Plan, Starts, Status, Tolerance};
pub use step::{Pace, Settings, Step};
