//! Solvers: step solvers, which share one loop, and population solvers, which share one
//! evaluator; one record of answers.

mod answers;
mod engine;
mod follow;
mod linear;
mod plan;
pub mod population;
mod rows;
mod setup;
mod start;
mod step;
mod targets;

pub(crate) use answers::Outcome;
pub use answers::{Answers, AnswersMut, Status};
pub use engine::run;
pub use follow::{Follow, Path};
pub use plan::Plan;
pub use rows::Solve;
pub use setup::{Setup, Tolerance};
pub use step::{
    GainUnits, Lengths, Matrix, Pace, Pid, PidOrder, Settings, StartRule, StateSpace, StaticGain,
    Step, frozen_gain,
};
pub use targets::{Goals, Starts};
