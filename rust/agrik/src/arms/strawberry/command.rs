//! Remark 3: the order in which a pose is driven, so that the arm clears the canopy.

use super::{Arm, Joints};
use crate::error::{Error, Result};

/// What a command moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// The gripper; 1 is open, 0 closed.
    Gripper,
    /// Slide s10 (along y), m.
    S10,
    /// Slide s21 (along x), m.
    S21,
    /// Slide s32 (along z, downward), m.
    S32,
    /// Pitch, rad.
    Theta,
    /// Roll, rad.
    Beta,
    /// Gripper about its own axis, rad.
    Psi,
}

impl Axis {
    /// Name as in the robot file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gripper => "gripper",
            Self::S10 => "s10",
            Self::S21 => "s21",
            Self::S32 => "s32",
            Self::Theta => "theta",
            Self::Beta => "beta",
            Self::Psi => "psi",
        }
    }
}

/// One step: an axis and where it goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Command {
    /// What moves.
    pub axis: Axis,
    /// Where to, m or rad (gripper: 1 open, 0 closed).
    pub target: f64,
}

impl Arm {
    /// The steps to a pose. `psi` turns the gripper (rad); `h_extra` (m) is how far above
    /// its end the arm waits while everything else moves.
    ///
    /// The remark prints `s32 + h_extra` for the waiting height. s32 grows downward, so
    /// that would be below the end, inside the plant: it is `s32 - h_extra`, not above
    /// the slide's upper end.
    pub fn commands(&self, q: &Joints, psi: f64, h_extra: f64) -> Result<[Command; 9]> {
        if !(h_extra.is_finite() && h_extra >= 0.0) {
            return Err(Error::argument("h_extra", "a finite number, 0 or more", h_extra));
        }
        let quarter = std::f64::consts::FRAC_PI_2;
        if !(-quarter..=quarter).contains(&psi) {
            return Err(Error::argument("psi", "an angle within a quarter turn", psi));
        }
        if !q.iter().all(|x| x.is_finite()) || !self.within(q) {
            return Err(Error::argument("q", "joint values within the limits", format!("{q:?}")));
        }
        let waiting = (q[2] - h_extra).max(self.parameters.lower[2].min(q[2]));
        let step = |axis, target| Command { axis, target };
        Ok([
            step(Axis::Gripper, 1.0),
            step(Axis::S32, waiting),
            step(Axis::S10, q[0]),
            step(Axis::S21, q[1]),
            step(Axis::Theta, q[3]),
            step(Axis::Beta, q[4]),
            step(Axis::Psi, psi),
            step(Axis::S32, q[2]),
            step(Axis::Gripper, 0.0),
        ])
    }
}
