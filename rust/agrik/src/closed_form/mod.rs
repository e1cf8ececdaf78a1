//! Closed forms: arms whose geometry gives every branch of the inverse kinematics without
//! iteration.
//!
//! [`ClosedForm::of`] recognises the family of a chain once; a [`Query`] is a call: for all
//! branches of each target ([`all`], or [`alone`] for a single one), or for the best branch by
//! a stated criterion ([`crate::call::solve`]).
//!
//! The folders stand one above the other: `geometry` (axes and angles), `families` (which
//! arms), `branch` (what makes a candidate an answer), `arm_angle` (the free angle of S-R-S
//! arms), `calls` (what can be asked).

pub mod arm_angle;
mod branch;
mod calls;
mod families;
mod geometry;

pub use branch::choice::Choice;
pub use calls::all_branches::{all, all_into};
pub use calls::any_arm::AnyArm;
pub use calls::arm_angle::ArmAngle;
pub use calls::branches::{Branches, BranchesMut};
pub use calls::every_branch::{Ask, can_sweep, every, reason};
pub use calls::family::Family as Recognised;
pub use calls::locked::{Lock, Values, all_locked};
pub use calls::one_pose::{Alone, alone, alone_of_six};
pub use calls::query::Query;
pub use calls::slide::Sweep;
pub use calls::warning;
pub use families::every::Every;
pub use families::six::{Six, Way};
pub use families::{ClosedForm, Family, Kind, Lead, SphericalWrist, Srs};
pub use geometry::axes::{Geometry, TOLERANCE};
pub use geometry::candidate::{Candidate, ELBOW, JOINTS, SHOULDER, WRIST};
pub use geometry::turn::{Link, Turn};
