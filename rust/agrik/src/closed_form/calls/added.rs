//! Arms of fewer joints than a pose needs: turns are added that the task does not ask for.

use super::any_arm::representative;
use crate::call::Request;
use crate::closed_form::families::every::Every;
use crate::closed_form::families::postures::Set;
use crate::closed_form::families::six::Six;
use crate::closed_form::geometry::rigid::Rigid;
use crate::closed_form::geometry::screws::{EXACT, Screw, Screws};
use crate::lanes::{V3, cross, dot, norm, sub};
use crate::task::{Task, axis_goal, rotation_between};

/// An arm of fewer than six joints, with turns about the tool point added that the task does not
/// ask for: their values are dropped.
pub struct Added {
    /// The arm with them.
    pub(super) six: Six,
    /// The tool in the last joint's frame.
    tool: Rigid<f64>,
    /// Joints that there are.
    pub(super) joints: usize,
    /// Where the first of the added ones is among the six.
    at: usize,
    /// What the added joints do counts as an error.
    pub(super) counts: bool,
    /// That of an axis alone: how the tool is turned about it does not count, and the last joint,
    /// which turns about it, is free.
    rolls: bool,
}

/// A posture at a goal's point, and what it misses the goal by, rad and m.
#[derive(Clone, Copy)]
pub struct Miss {
    pub angle: f64,
    pub distance: f64,
    pub q: [f64; 6],
}

/// The postures that miss a goal's orientation by least.
pub struct Least {
    /// Of all; infinite where there is none.
    pub all: Miss,
    /// Of those within the limits.
    pub within: Option<Miss>,
}

impl Added {
    /// The arm of a request: of five joints for a point and an axis, of three for a point.
    pub fn new(request: &Request<'_>, every: &Every) -> Result<Self, String> {
        let about = |axis| Self::about(request, every, axis);
        match about([0.0, 0.0, 1.0]) {
            // Where the last joint turns about the tool axis, a turn about another one will do for
            // a pose: whoever reaches it does not use it.
            Err(_) if request.task() == Task::Pose && every.joints() == 5 => about([1.0, 0.0, 0.0]),
            made => made,
        }
    }

    /// The same; of a pose for five joints with a turn about an axis of the tool.
    fn about(request: &Request<'_>, every: &Every, axis: V3<f64>) -> Result<Self, String> {
        let tail = request.tail();
        let (point, joints) = (tail.translation, every.joints());
        let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let (axes, turns): (_, Vec<V3<f64>>) = match (request.task(), joints) {
            (Task::Axis { tool_axis }, 5) => {
                let axes = axis_goal(point, tail.direction(tool_axis)).axes;
                (axes, vec![axes[2]])
            }
            (Task::Pose, 5) => (unit, vec![tail.direction(axis)]),
            (Task::Position | Task::Pose, 3) => (unit, unit.to_vec()),
            _ => return Err(format!("{joints} joints, which do not fit the task")),
        };
        let tool = Rigid { axes, shift: point };
        let at = every.screws.tool;
        let added = turns.iter().map(|w| Screw { axis: at.turn(*w), point: at.apply(point) });
        let all = every.screws.joints.iter().copied().chain(added).collect();
        let screws = Screws { joints: all, tool: at.after(&tool) };
        let counts = request.task().fixes_pose();
        if joints == 5 {
            let (last, new) = (screws.joints[4], screws.joints[5]);
            let off = norm(cross(sub(new.point, last.point), last.axis));
            // A roll about a line through the tool point: what it cannot do is a turn out of the
            // plane of the pitches, whichever way the tool points.
            let along = screws.tilt(4, 5) < EXACT;
            if off < EXACT * screws.length() && (along || counts) {
                match with_a_second_yaw(&screws) {
                    Ok(six) => {
                        return Ok(Self { six, tool, joints, at: 4, counts: true, rolls: !counts });
                    }
                    Err(why) if along => return Err(why),
                    Err(_) => {}
                }
            }
        }
        Ok(Self { six: Six::new(&screws, None)?, tool, joints, at: joints, counts, rolls: false })
    }

    /// Values of the joints that there are among those of the six.
    pub fn spread(&self, q: &[f64; 6]) -> [f64; 6] {
        let mut out = [0.0; 6];
        for (k, x) in q[..self.joints].iter().enumerate() {
            out[if k < self.at { k } else { k + 6 - self.joints }] = *x;
        }
        out
    }

    /// The joints that there are of the six, the rest zero.
    fn gathered(&self, q: &[f64; 6]) -> [f64; 6] {
        let of = |k: usize| {
            if k < self.at { q[k] } else { q[k + 6 - self.joints] }
        };
        std::array::from_fn(|k| if k < self.joints { of(k) } else { 0.0 })
    }

    /// Leaves the joints that there are, of those postures that miss the goal's orientation by no
    /// more than `allowed`, rad; an angle that nothing decides is taken from `near`.
    pub fn drop(
        &self,
        every: &Every,
        goal: &Rigid<f64>,
        (near, allowed): (&[f64; 6], f64),
        set: &mut Set,
    ) -> Least {
        let given = *set;
        set.count = 0;
        let behind = given.free >> (6 - self.joints) & !((1 << self.at) - 1);
        set.free = (given.free & ((1 << self.at) - 1) | behind) & ((1 << self.joints) - 1);
        let nothing = Miss { angle: f64::INFINITY, distance: f64::INFINITY, q: *near };
        let mut least = Least { all: nothing, within: None };
        for (q, singular) in given.postures().iter().zip(given.singular) {
            let mut q = self.gathered(q);
            if self.rolls {
                q[self.joints - 1] = near[self.joints - 1];
            }
            let at = every.screws.pose(&q[..self.joints]).after(&self.tool);
            let left = if self.rolls {
                norm(cross(at.axes[2], goal.axes[2])).atan2(dot(at.axes[2], goal.axes[2]))
            } else {
                norm(rotation_between(at.axes, goal.axes))
            };
            let miss = Miss { angle: left, distance: norm(sub(at.shift, goal.shift)), q };
            if left < least.all.angle {
                least.all = miss;
            }
            if least.within.is_none_or(|known| left < known.angle) {
                let mut each = every.limits.iter().zip(&q).zip(near);
                if each.all(|((limit, x), near)| representative(limit, *x, *near).1) {
                    least.within = Some(miss);
                }
            }
            if !self.counts || left <= allowed {
                set.add_with(&q, singular, 0);
            }
        }
        if self.rolls && set.count > 0 {
            set.free |= 1 << (self.joints - 1);
        }
        set.none &= set.count == given.count;
        least
    }
}

/// An arm of yaw, three pitches and roll, with a turn at the tool point put before the last joint,
/// across the tool axis and out of the plane that the pitches move it in: what that turn has to do
/// is the least angle by which the arm misses an orientation at a point. `screws` has a joint too
/// many, which turns as the last one does.
fn with_a_second_yaw(screws: &Screws) -> Result<Six, String> {
    let (pitch, roll) = (screws.joints[1], screws.joints[4]);
    let parallel = screws.tilt(1, 2).max(screws.tilt(1, 3));
    if parallel > EXACT || dot(pitch.axis, roll.axis).abs() > EXACT {
        let why = "its last joint turns about the tool axis itself, and no three pitches before it";
        return Err(why.to_owned());
    }
    let across = cross(pitch.axis, roll.axis);
    let axis = across.map(|x| x / norm(across));
    let point = screws.joints[5].point;
    let mut screws = screws.clone();
    screws.joints.pop();
    screws.joints.insert(4, Screw { axis, point });
    Six::closed(&screws)
}
