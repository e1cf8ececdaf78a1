//! Whether an arm is free on its whole way between postures: proofs, not samples.
//!
//! At a posture a body keeps a distance from all that it minds. On the way to another posture
//! no core point of it moves farther than a bound that the joint values give. So the body is
//! free as far as that bound is less than the distance, and what is left of the way on both
//! sides is asked about in the same manner. A straight way in joint space, a [`Certifier`]
//! either proves free, with a distance that is kept all along it, or shows a posture that is
//! too near to something, or gives up on a place where the arm grazes what it must not touch.

mod certifier;
mod corners;
mod mover;
mod paths;
mod sample;
mod sweep;
mod verdict;

pub use certifier::Certifier;
pub use corners::check_corners;
pub use paths::{check_path, check_segments};
pub use verdict::{Keep, OWN_CLEAR, Outcome, Verdict};
