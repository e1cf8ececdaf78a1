//! How fast the joints of a chain may move.

use super::{Chain, Joint, MotionLimits, Variable, check_joints};
use crate::error::{Error, Result};

impl Chain {
    /// The same chain with other limits of motion of some joints, each given by its name.
    pub fn with_motion_limits<'a>(
        &self,
        limits: impl IntoIterator<Item = (&'a str, MotionLimits)>,
    ) -> Result<Self> {
        let mut made = self.clone();
        for (name, limits) in limits {
            let Some(joint) = made.joints.iter_mut().find(|joint| joint.name == name) else {
                return Err(Error::argument("motion", "names of joints of the chain", name));
            };
            joint.motion = limits;
        }
        check_joints(&made.joints)?;
        spread(&mut made.variables, &made.joints);
        Ok(made)
    }
}

/// Gives each variable the limits of its joint and of those that follow it.
pub(super) fn spread(variables: &mut [Variable], joints: &[Joint]) {
    for variable in variables {
        variable.motion = MotionLimits::UNKNOWN;
        for joint in joints {
            let (source, factor) =
                joint.mimic.as_ref().map_or((&joint.name, 1.0), |m| (&m.source, m.multiplier));
            if *source == variable.name {
                variable.motion = variable.motion.narrowed(joint.motion, factor);
            }
        }
    }
}
