//! Arms with bodies, among the things of a scene.
//!
//! [`body`] puts solids on the frames of a chain and says, for many postures at once, what
//! they hit and how far from it they are; [`harvest`] decides whether and how a fruit can be
//! picked; [`edges`] proves ways between postures free, [`planners`] looks for them;
//! [`time_law`] says when an arm is where on its way. Lengths are in metres, angles in radians,
//! all in the frame in which the base of the chain stands.

pub mod body;
pub mod edges;
pub mod harvest;
pub mod planners;
pub mod time_law;

pub use agrik_compute::{Error, Result};
pub use body::{Bodies, Body, Collider, Contact, Free, Other, Placed, Shape, Touch};
