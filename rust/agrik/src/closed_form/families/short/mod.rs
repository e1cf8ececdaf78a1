//! Arms of at most four joints that turn, perhaps behind one that slides, and tasks that ask for
//! as much as they can do or more: every posture that reaches a goal, or those that miss it by
//! least.
//!
//! The error of a posture is the distance to the goal in space and orientation, orientations
//! counted by a length per radian as the step solvers do. It is a distance: no joint changes it
//! by more than it moves the tool. So a look at the middle of a cell of joint values bounds the
//! error in the whole cell, and cells that cannot hold an answer are left out ([`search`]); what
//! is left is small, and steps end it ([`descend`]).

mod descend;
mod look;
mod search;
#[cfg(test)]
mod tests;

use crate::chain::Chain;
use crate::closed_form::geometry::rigid::Rigid;
use crate::closed_form::geometry::screws::{Screw, Screws};
use crate::closed_form::geometry::serial::Serial;
use crate::kinematics::{Workspace, forward};
use crate::lanes::{V3, norm, scale, sub};

pub use descend::Posture;
pub use search::Found;

/// Most joints that turn.
pub const TURNING: usize = 4;

/// No lever is a smaller share of the arm's size.
const LEAST_LEVER: f64 = 1e-9;

/// What of a goal counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wish {
    /// The tool point.
    Point,
    /// The tool point and the third of the tool's axes.
    Axis,
    /// The whole pose.
    Pose,
}

/// An arm of few joints with a tool and what is asked of it.
#[derive(Debug)]
pub struct Short {
    /// The joints that turn, at the places of the last ones; those before stay at 0.
    serial: Serial<TURNING>,
    /// How many turn.
    turning: usize,
    /// Way of the slide before them for each unit of its value, m.
    slide: Option<V3<f64>>,
    wish: Wish,
    /// Length that a radian of orientation counts as, m; 0 for points.
    per_radian: f64,
    /// Most that a radian of each joint moves the tool by, orientation included, m.
    levers: [f64; TURNING],
    /// Size of the arm, m.
    size: f64,
}

/// Values that joints may have: of those that turn, along the chain, and of the slide.
#[derive(Debug, Clone, Copy)]
pub struct Room {
    pub lower: [f64; TURNING],
    pub upper: [f64; TURNING],
    pub slide: (f64, f64),
}

impl Room {
    /// No limits.
    pub const FREE: Self = Self {
        lower: [f64::NEG_INFINITY; TURNING],
        upper: [f64::INFINITY; TURNING],
        slide: (f64::NEG_INFINITY, f64::INFINITY),
    };
}

/// The joints of a chain as lines: the way of its first one where that slides, and the others.
#[derive(Debug)]
pub struct Lines {
    pub slide: Option<V3<f64>>,
    /// The joints that turn; as tool the last joint's frame.
    pub screws: Screws,
    /// Which entry of `q` each joint is, the slide first.
    pub order: Vec<usize>,
}

impl Lines {
    /// The joints of a chain, or why they are none of these; found once for each chain.
    pub fn of(chain: &Chain) -> Result<&Self, &str> {
        chain.memo(Self::recognise).as_ref().map_err(String::as_str)
    }

    fn recognise(chain: &Chain) -> Result<Self, String> {
        let (compiled, variables) = (chain.compiled(), chain.variables());
        let links = &compiled.links;
        if let Some(link) = links.iter().skip(1).find(|link| link.prismatic) {
            let name = &variables[link.variable].name;
            return Err(format!("its joint '{name}' slides"));
        }
        let alone = |link: &&crate::chain::Link| link.prismatic || link.multiplier == 1.0;
        if links.len() != compiled.dof || links.iter().filter(alone).count() != links.len() {
            return Err("a joint follows another".to_owned());
        }
        let mut workspace = Workspace::<f64>::new(compiled);
        forward(compiled, &vec![0.0; compiled.dof], &mut workspace);
        let sliding = usize::from(links.first().is_some_and(|link| link.prismatic));
        let slide = (sliding == 1).then(|| scale(workspace.axes[0].direction, links[0].multiplier));
        let axes = workspace.axes[sliding..].iter();
        let joints = axes.map(|axis| Screw { axis: axis.direction, point: axis.origin }).collect();
        let tool = Rigid { axes: workspace.joint_axes(), shift: workspace.tool_point([0.0; 3]) };
        let order = links.iter().map(|link| link.variable).collect();
        Ok(Self { slide, screws: Screws { joints, tool }, order })
    }
}

impl Short {
    /// The arm of some lines whose tool is `tool` in the last joint's frame; `None` where too
    /// many joints turn.
    pub fn new(
        lines: &Lines,
        tool: &Rigid<f64>,
        (wish, per_radian): (Wish, f64),
        size: f64,
    ) -> Option<Self> {
        let turning = lines.screws.joints.len();
        let still = TURNING.checked_sub(turning)?;
        let tool = lines.screws.tool.after(tool);
        let base = lines.screws.joints.first().map_or(tool.shift, |screw| screw.point);
        let rest = Screw { axis: [0.0, 0.0, 1.0], point: base };
        let moving = lines.screws.joints.iter().copied();
        let joints: Vec<Screw> = std::iter::repeat_n(rest, still).chain(moving).collect();
        let screws = Screws { joints, tool }.gathered();
        let per_radian = if wish == Wish::Point { 0.0 } else { per_radian };
        let mut levers = [0.0; TURNING];
        let (mut far, mut behind) = (0.0, tool.shift);
        for (k, screw) in screws.joints.iter().enumerate().rev() {
            far += norm(sub(behind, screw.point));
            behind = screw.point;
            // A joint that moves nothing is divided by what it moves all the same.
            levers[k] = f64::hypot(far, per_radian).max(LEAST_LEVER * size);
        }
        let serial = Serial::new(&screws)?;
        let slide = lines.slide.filter(|way| norm(*way) > 0.0);
        Some(Self { serial, turning, slide, wish, per_radian, levers, size })
    }

    /// The places of the joints that turn.
    fn moving(&self) -> std::ops::Range<usize> {
        TURNING - self.turning..TURNING
    }
}
