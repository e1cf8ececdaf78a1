//! What every solver is given, and what it gives back: a [`Request`] (chain, aim, targets,
//! starts) in, one record of [`Answers`] out. A solver is whatever implements [`Solve`];
//! [`solve`] spreads its targets over threads.

mod accept;
mod aim;
mod answers;
mod batch;
mod request;
mod second;
mod targets;

pub(crate) use accept::Verdict;
pub use accept::{Accept, Guard, Prefer, TOGETHER};
pub use aim::{Aim, AxisBounds, Near, Tolerance};
pub(crate) use aim::{INSIDE, Left, Measure};
pub(crate) use answers::Outcome;
pub use answers::{Answers, AnswersMut, Status};
pub use batch::{Solve, solve, solve_at, solve_into};
pub use request::Request;
pub use second::{Merit, Second, check_weights};
pub(crate) use targets::Copies;
pub use targets::{Goals, Starts};
