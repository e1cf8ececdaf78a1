//! Chains whose joints stand still: the same arm with fewer joint values.

use super::{Chain, Joint, JointKind, Mimic, compiled};
use crate::error::{Error, Result};

impl Chain {
    /// The same chain with some entries of `q` fixed at values within their limits, each given
    /// as (entry, value in rad or m); the others keep their order. What follows a locked joint
    /// stands still with it.
    pub fn locked(&self, locks: &[(usize, f64)]) -> Result<Self> {
        for (variable, value) in locks {
            self.check_lock(*variable, *value)?;
        }
        let named = |name: &str| {
            let at = self.variables.iter().position(|v| v.name == name);
            at.and_then(|i| locks.iter().find(|(variable, _)| *variable == i))
        };
        let fixed = |joint: &Joint| {
            let (source, factor, offset) = match &joint.mimic {
                None => (joint.name.as_str(), 1.0, 0.0),
                Some(Mimic { source, multiplier, offset, .. }) => {
                    (source.as_str(), *multiplier, *offset)
                }
            };
            match named(source) {
                Some((_, value)) if joint.kind != JointKind::Fixed => Joint {
                    kind: JointKind::Fixed,
                    origin: joint.origin * compiled::motion(joint, factor * value + offset),
                    mimic: None,
                    ..joint.clone()
                },
                _ => joint.clone(),
            }
        };
        let joints = self.joints.iter().map(fixed).collect();
        let free = self.variables.iter().enumerate();
        let free = free.filter(|(i, _)| !locks.iter().any(|(variable, _)| variable == i));
        let order: Vec<String> = free.map(|(_, v)| v.name.clone()).collect();
        Self::new(self.name.clone(), joints, self.base, self.tool, Some(&order))
    }

    /// The same chain with other limits of some entries of `q`, each given by its name, rad or m.
    /// Joints that follow one keep theirs.
    pub fn with_limits<'a>(
        &self,
        limits: impl IntoIterator<Item = (&'a str, f64, f64)>,
    ) -> Result<Self> {
        let mut joints = self.joints.clone();
        for (name, lower, upper) in limits {
            let Some(joint) = joints.iter_mut().find(|joint| joint.name == name) else {
                return Err(Error::argument("limits", "names of joints of the chain", name));
            };
            let bounded = lower.is_finite() || upper.is_finite();
            match joint.kind {
                JointKind::Continuous if bounded => joint.kind = JointKind::Revolute,
                JointKind::Revolute if !bounded => joint.kind = JointKind::Continuous,
                _ => {}
            }
            (joint.lower, joint.upper) = (lower, upper);
        }
        let order: Vec<String> = self.variables.iter().map(|v| v.name.clone()).collect();
        Self::new(self.name.clone(), joints, self.base, self.tool, Some(&order))
    }

    /// Refuses to lock an entry of `q` at a value that it cannot take.
    pub fn check_lock(&self, variable: usize, value: f64) -> Result<()> {
        let Some(of) = self.variables.get(variable) else {
            let expected = format!("an entry of q, 0 to {}", self.dof() - 1);
            return Err(Error::argument("locked", expected, variable));
        };
        if of.lower <= value && value <= of.upper {
            return Ok(());
        }
        let expected =
            format!("a value of '{}' within its limits, {} to {}", of.name, of.lower, of.upper);
        Err(Error::argument("locked", expected, value))
    }
}
