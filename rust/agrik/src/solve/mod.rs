//! Solvers: step solvers, which share one loop, and population solvers, which share one
//! evaluator.

mod climb;
mod engine;
mod follow;
mod limit;
mod limited;
mod linear;
mod pieces;
mod plan;
pub mod population;
mod postures;
mod rates;
mod refined;
mod rows;
mod sensitivity;
mod setup;
mod start;
mod step;
mod tracker;

pub use climb::Climb;
pub use engine::run;
pub use follow::{Follow, Path};
pub(crate) use limit::wound;
pub use limited::Limited;
pub use plan::Plan;
pub use rates::Twists;
pub use refined::Refined;
pub use sensitivity::{DH, Sensitivity, TWIST};
pub use setup::Setup;
pub use step::{
    GainUnits, Lengths, Matrix, Pace, Pid, PidOrder, Settings, StartRule, StateSpace, StaticGain,
    Step, frozen_gain,
};
pub use tracker::Tracker;
