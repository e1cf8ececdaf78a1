//! A joint's limits as the loop sees them.

use crate::chain::{JointKind, Variable};
use crate::kinematics::PerJoint;
use crate::solve::plan::Plan;

/// The limits of one joint value, rad or m.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limit {
    pub lower: f64,
    pub upper: f64,
    /// The joint can take every angle, so that its limits hold nothing back.
    pub turns: bool,
}

impl Limit {
    fn of(v: &Variable) -> Self {
        // Half a step of rounding: limits of plus and minus half a turn are a full one.
        let full = v.upper - v.lower >= std::f64::consts::TAU - 1e-15;
        let turns = v.kind != JointKind::Prismatic && full;
        Self { lower: v.lower, upper: v.upper, turns }
    }
}

/// The limits of a plan: those of the joints, unless it has narrower ones.
pub(super) fn limits(plan: &Plan<'_>) -> PerJoint<Limit> {
    match &plan.bounds {
        None => plan.request.chain().variables().iter().map(Limit::of).collect(),
        Some(bounds) => {
            bounds.iter().map(|&(lower, upper)| Limit { lower, upper, turns: false }).collect()
        }
    }
}
