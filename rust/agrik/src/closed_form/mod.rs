//! Closed forms: arms whose geometry gives every branch of the inverse kinematics without
//! iteration.
//!
//! [`ClosedForm::of`] recognises the family of a chain once; a [`Query`] is a call: for all
//! branches of each target ([`all`]), or for the best branch by a stated criterion
//! ([`crate::batch::solve`]). [`alone`] takes a single pose without much ado. A family solves
//! whole lane groups through [`ClosedForm::solve`]; limits, the check by forward
//! kinematics and the choice are common to all (see [`settle`]). The papers' own arms,
//! [`strawberry`] and [`tomato`], have closed forms of their own.

mod all;
mod alone;
pub mod arm_angle;
mod best;
mod best_angle;
mod branches;
mod candidates;
mod certify;
mod check;
mod choose;
mod costs;
mod enclosure;
mod geometry;
mod last_resort;
mod open_angles;
mod polish;
mod quartic;
mod query;
mod settle;
mod shoulder;
mod shoulder_arcs;
mod spherical_wrist;
mod srs;
pub mod strawberry;
mod sweep;
pub mod tomato;
mod turn;
mod unreachable;
mod wheel;

pub use all::{all, all_into};
pub use alone::{Alone, Single, alone};
pub use best::best_alone;
pub use branches::{Branches, BranchesMut};
pub use candidates::{BRANCHES, Candidate, ELBOW, JOINTS, SHOULDER, WRIST};
pub use choose::Choice;
pub use geometry::{Geometry, Link, TOLERANCE};
pub use query::{ArmAngle, Query};
pub use shoulder::Kind;
pub use spherical_wrist::SphericalWrist;
pub use srs::Srs;
pub use turn::Turn;

use crate::chain::Chain;
use crate::lanes::Real;
use crate::task::Goal;

/// A chain's family with its numbers.
#[derive(Debug, Clone, PartialEq)]
pub enum ClosedForm {
    /// Six revolute joints, the last three axes meet.
    SphericalWrist(SphericalWrist),
    /// Seven revolute joints, the first three and the last three axes meet.
    Srs(Srs),
}

impl ClosedForm {
    /// The family of a chain, or why it has none; found once for each chain.
    pub fn of(chain: &Chain) -> Result<&Self, &str> {
        chain.closed_form(Self::recognise).as_ref().map_err(String::as_str)
    }

    /// Some branches come from the roots of an equation that loses digits.
    #[inline(always)]
    fn loses_digits(&self) -> bool {
        matches!(self, Self::SphericalWrist(arm) if arm.kind() == Kind::General)
    }

    fn recognise(chain: &Chain) -> Result<Self, String> {
        let reason = |why: String| format!("'{}' has no closed form: {why}", chain.name());
        match chain.dof() {
            6 => {
                let geometry = Geometry::new(chain).map_err(reason)?;
                SphericalWrist::new(geometry).map(Self::SphericalWrist).map_err(reason)
            }
            7 => {
                let geometry = Geometry::new(chain).map_err(reason)?;
                Srs::new(geometry).map(Self::Srs).map_err(reason)
            }
            n => Err(reason(format!("{n} joint variables, and the families known have 6 or 7"))),
        }
    }

    /// Short name of the family.
    pub fn name(&self) -> &'static str {
        match self {
            Self::SphericalWrist(_) => "spherical wrist",
            Self::Srs(_) => "S-R-S",
        }
    }

    /// The axes.
    pub fn geometry(&self) -> &Geometry {
        match self {
            Self::SphericalWrist(arm) => arm.geometry(),
            Self::Srs(arm) => arm.geometry(),
        }
    }

    /// All branches of a lane group; see the families.
    #[inline(always)]
    pub fn solve<R: Real>(
        &self,
        goal: &Goal<R>,
        tool: [f64; 3],
        angle: Turn<R>,
        preferred: &[Turn<R>],
        out: &mut [Candidate<R>; BRANCHES],
    ) {
        match self {
            Self::SphericalWrist(arm) => arm.solve(goal, tool, preferred, out),
            Self::Srs(arm) => arm.solve(goal, tool, angle, preferred, out),
        }
    }

    /// The branches `2 (first + i)` and the one after it in lane `i`, for one goal and arm
    /// angle that are in every lane; over again from the fifth pair.
    #[inline(always)]
    pub fn side_by_side<R: Real>(
        &self,
        goal: &Goal<R>,
        tool: [f64; 3],
        angle: Turn<R>,
        preferred: &[Turn<R>],
        first: usize,
    ) -> [Candidate<R>; 2] {
        match self {
            Self::SphericalWrist(arm) => arm.side_by_side(goal, tool, preferred, first),
            Self::Srs(arm) => arm.side_by_side(goal, tool, angle, preferred, first),
        }
    }
}

/// How far two points are apart.
fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}
