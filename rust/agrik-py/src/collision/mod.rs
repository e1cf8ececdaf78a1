//! Arms with bodies in scenes, and what hits what: the classes `Scene`, `Bodies`, `Collider`.

pub mod bodies;
pub mod collider;
pub mod distances;
pub mod guard;
pub mod near;
mod rows;
pub mod scene;
