//! An arm with solids on its frames: where they are at a posture, which of them may hit each
//! other, and what they are near.
//!
//! [`Bodies`] are an arm's own; with a scene they make a [`Collider`], which answers. Poses of
//! frames are worked out for many postures in lanes. Whether they hit is first sieved, eight
//! postures at a time, in singles; what that lets through, and every distance, is asked about
//! posture by posture, with lanes over the things around it. Numbers that are none are refused
//! before anything is asked.

mod accept;
mod batch;
mod bodies;
mod collider;
mod eights;
mod levers;
mod near;
mod placed;
mod self_pairs;
mod shape;
mod sieve;
mod together;

pub use accept::Free;
pub use batch::{BodyDistance, Distances, OwnDistance};
pub use bodies::Bodies;
pub(crate) use bodies::{Mount, check_postures};
pub use collider::{Collider, Contact, Other, Touch};
pub(crate) use levers::link_levers;
pub use near::{Near, Nearby};
pub use placed::Placed;
pub use self_pairs::{Excluded, Reason};
pub use shape::{Body, Shape};
pub(crate) use sieve::{Bends, PARTS, Sifted};
