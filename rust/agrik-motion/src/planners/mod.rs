//! Ways from one posture into another that are proven free, or a proof that there is none.
//!
//! [`plan`] tries what costs little first: the straight way, ways on which one slide moves
//! alone, a straight line of the tool backwards out of the goal. Then two trees grow towards
//! each other (RRT-Connect of Kuffner and LaValle, 2000), one from the start, one from all
//! goals and from the ends of the lines out of them. Every piece is a proof of
//! [`crate::edges`]. What is found is made shorter, and where nothing is found [`Cut`] may
//! prove that there is nothing: that a ball inside a body is shut in at the goal or at the start.

mod ask;
mod blockers;
mod cheap;
mod connect;
mod cut;
mod goals;
mod hitting;
mod line;
mod metric;
mod plan;
mod shorten;
mod tree;
mod words;

pub use ask::{Ask, Settings};
pub use blockers::{Ends, Fewest, PathBlockers, blockers};
pub use cut::{Cut, cut};
pub use metric::Metric;
pub use plan::{Planned, plan};
pub use words::{How, PathStatus};
