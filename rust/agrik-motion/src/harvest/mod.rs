//! Harvest postures: whether an arm on a slide can pick a fruit among leaves, and how.
//!
//! A [`Station`] is the arm with its bodies in a crop. [`decide`] answers for one [`Target`] by
//! the two-step method of Van Henten, Schenk, Van Willigenburg, Meuleman and Barreiro,
//! "Collision-free inverse kinematics of the redundant seven-link manipulator used in a
//! cucumber picking robot", Biosystems Engineering (2010): a scan of approach angles with the
//! last links alone, then a scan of the slide with the closed form, a table, and the best of
//! its rows by stated criteria; with the recovery that the paper left open. [`plan`] does so
//! for many targets, [`blockers`] names what stands in the way; [`plan_paths`] finds the way
//! into the posture as well. [`Programme`] is the paper's
//! other way, a search over all joints of any arm.
//!
//! Lengths are in metres, angles in radians. The approach angle psi is about the vertical, 0
//! along x of the world; the tool comes along its z axis, with its x axis down.

mod aim;
mod approach;
mod batch;
mod blockers;
mod decide;
mod openings;
mod paths;
mod programme;
mod recovery;
mod refine;
mod scan;
mod settings;
mod station;
mod surroundings;
mod table;

pub use aim::Target;
pub use batch::{plan, plan_blockers};
pub use blockers::{Blockers, blockers};
pub use decide::{Attempt, Decision, Stage, Status, decide, full};
pub use paths::{Picked, Picking, plan_paths};
pub use programme::{DIFFERENTIAL, GENETIC, Programme, Run, Terms, Weights};
pub use scan::{Scanned, approaches, table};
pub use settings::Settings;
pub use station::Station;
pub use surroundings::{Mode, Roles, Surroundings};
pub use table::{DOF, Row, Table};
