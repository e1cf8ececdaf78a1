//! What can be asked of a closed form: all branches, or the best one, of many targets or one.

mod accepted_branch;
mod added;
pub mod all_branches;
pub mod any_arm;
pub mod arm_angle;
mod best_branch;
pub mod branches;
pub mod every_branch;
pub mod family;
mod few_joints;
mod last_resort;
pub mod locked;
pub mod one_pose;
pub mod query;
pub mod slide;
pub mod warning;
mod wrap;
