//! Solids, exact distances between them, and scenes of many: knows no robot.
//!
//! A [`Solid`] is a convex core (point, segment, cuboid, hull, half-space) with a radius
//! round it. [`closest`] gives the distance of two of them and the points where they come
//! nearest, one file a pair of kinds in [`mod@distance`]. A [`Scene`] holds named objects made of
//! many solids, and answers for one more solid, placed anywhere, whether it is free and how
//! far away the nearest object is; below it lies a [`SphereTree`], which weighs up eight
//! spheres at a time with singles and leaves to doubles what is near. Beside it, [`outline`] rules
//! out in singles that balls of many postures are near anything.
//!
//! Lengths are in metres, all coordinates in one frame that the caller chooses. No function
//! of this crate takes any other unit, and none depends on one: nothing but ratios of
//! lengths is ever compared with a constant.

pub mod broad_phase;
pub mod cover;
pub mod distance;
pub mod outline;
pub mod pose;
pub mod probe;
pub mod scene;
pub mod shapes;
pub mod sphere_tree;

pub use agrik_compute::{Error, Result, lanes};
pub use broad_phase::BroadPhase;
pub use cover::{Cover, Spheres, Split};
pub use distance::{Closest, closest, distance, distance_within, overlaps, within};
pub use pose::Pose;
pub use scene::{Exemption, Nearest, Object, Scene};
pub use shapes::{Cloud, Core, Cuboid, HalfSpace, Hull, Point, Segment, Solid};
pub use sphere_tree::SphereTree;
