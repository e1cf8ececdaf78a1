//! Which arms have a closed form: one file a family, and the choice between them.

pub mod every;
mod lead;
mod meeting;
pub mod postures;
pub mod ring;
pub mod short;
mod shoulder;
mod shoulder_arcs;
pub mod six;
pub mod spherical_wrist;
pub mod srs;
mod three_parallel;

pub use lead::Lead;
pub use shoulder::Kind;
pub use spherical_wrist::SphericalWrist;
pub use srs::Srs;

use super::geometry::axes::Geometry;
use super::geometry::candidate::{Candidate, MOST_BRANCHES};
use super::geometry::turn::Turn;
use crate::chain::Chain;
use crate::lanes::Real;
use crate::task::Goal;

/// What is known of a family before any of its arms.
pub trait Family {
    /// Most solutions that a target can have: rows of a target in a record of branches.
    const BRANCHES: usize;
}

/// Misfit (m, rad) of an arm that is not just rounded.
const ROUGH: f64 = 1e-9;

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
        chain.memo(Self::recognise).as_ref().map_err(String::as_str)
    }

    /// Some branches come from the roots of an equation that loses digits.
    #[inline(always)]
    pub fn loses_digits(&self) -> bool {
        matches!(self, Self::SphericalWrist(arm) if arm.kind() == Kind::General)
    }

    /// The axes are so far from what they are taken for that branches near others may not be
    /// those of the arm as given.
    pub fn is_rough(&self) -> bool {
        let misfit = &self.geometry().misfit;
        matches!(self, Self::SphericalWrist(_)) && misfit.position.max(misfit.orientation) > ROUGH
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

    /// Most solutions that a target can have.
    #[inline(always)]
    pub fn branches(&self) -> usize {
        match self {
            Self::SphericalWrist(_) => SphericalWrist::BRANCHES,
            Self::Srs(_) => Srs::BRANCHES,
        }
    }

    /// The axes.
    pub fn geometry(&self) -> &Geometry {
        match self {
            Self::SphericalWrist(arm) => arm.geometry(),
            Self::Srs(arm) => arm.geometry(),
        }
    }

    /// All branches of a lane group, the first ones of `out`; see the families.
    #[inline(always)]
    pub fn solve<R: Real>(
        &self,
        goal: &Goal<R>,
        tool: [f64; 3],
        angle: Turn<R>,
        preferred: &[Turn<R>],
        out: &mut [Candidate<R>; MOST_BRANCHES],
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
