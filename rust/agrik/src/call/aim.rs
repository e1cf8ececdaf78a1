//! What counts as reached: the task, how near is near enough, and with which tool.

use crate::Allowed;
use crate::allowed::check_measures;
use crate::chain::{Chain, Tail};
use crate::error::Result;
use crate::task::Task;

/// How near is near enough.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Distance, m.
    pub position: f64,
    /// Angle, rad.
    pub orientation: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { position: 1e-6, orientation: 1e-6 }
    }
}

impl Tolerance {
    /// Refuses what no error can be below.
    fn check(&self) -> Result<()> {
        Allowed::POSITIVE.check("position_tolerance", self.position)?;
        Allowed::POSITIVE.check("orientation_tolerance", self.orientation)
    }
}

/// A task, its tolerances and the tool that has to fulfil it, checked.
#[derive(Debug, Clone, Copy)]
pub struct Aim {
    task: Task,
    tolerance: Tolerance,
    tail: Tail,
}

impl Aim {
    /// A checked aim; `tail` is a tool in place of the chain's own.
    #[inline]
    pub fn new(
        chain: &Chain,
        task: Task,
        tolerance: Tolerance,
        tail: Option<Tail>,
    ) -> Result<Self> {
        let task = task.checked()?;
        tolerance.check()?;
        if let Some(tail) = &tail {
            check_measures("tool", tail.translation)?;
        }
        Ok(Self { task, tolerance, tail: tail.unwrap_or(chain.compiled().tail) })
    }

    /// What counts as reached.
    pub fn task(&self) -> Task {
        self.task
    }
    /// How near is near enough.
    pub fn tolerance(&self) -> Tolerance {
        self.tolerance
    }
    /// The tool in the last joint's frame.
    pub fn tail(&self) -> &Tail {
        &self.tail
    }
}
