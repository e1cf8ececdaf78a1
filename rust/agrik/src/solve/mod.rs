//! Solvers: step solvers, which share one loop, and population solvers, which share one
//! evaluator; one record of answers.

mod engine;
mod follow;
mod linear;
mod plan;
pub mod population;
mod rows;
mod start;
mod step;

pub use engine::run;
pub use follow::{Follow, Path};
pub(crate) use plan::Outcome;
pub use plan::{Answers, AnswersMut, Goals, Plan, Starts, Status, Tolerance};
pub use rows::Solve;
pub use step::{
    GainUnits, Matrix, Pace, Pid, PidOrder, Settings, StartRule, StateSpace, StaticGain, Step,
    frozen_gain,
};
