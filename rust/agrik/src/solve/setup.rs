//! What stays the same from call to call of a control loop: the aim and the step.

use super::Settings;
use super::start::Ranking;
use super::step::{Feedback, Lengths, StartRule, middle};
use crate::call::{Aim, Measure, Second, Tolerance};
use crate::chain::{Chain, JointKind, Reach, Tail};
use crate::error::Result;
use crate::task::{Goal, rotation_scale};

/// How far from the goal the rows of one kind aim, since there is near enough: in their units,
/// m, and never at 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Room {
    /// At the goal itself.
    None,
    /// Anywhere on a sphere.
    Ball(f64),
    /// At a side of a box, row by row; 0 where a row aims at the goal.
    Box([f64; 3]),
}

/// How far from the goal a step aims.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Slack {
    pub position: Room,
    pub orientation: Room,
}

/// Tolerances, as a share of the size or in rad, from which on they count in the search.
const WIDE: f64 = 1e-3;
/// Share of a tolerance at which steps aim: inside it, for they come from outside.
const AIM: f64 = 0.9;
/// The same of single axes, where the others may leave no more than one place.
const AIM_OF_AXIS: f64 = 0.999;

impl Room {
    /// Of rows with these weights and a unit, where tolerances above `least` are wide.
    fn of(whole: f64, each: [f64; 3], weights: &[f64], scale: f64, least: f64) -> Self {
        let wide = |most: f64, aim: f64, weight: f64| {
            if most > least && most.is_finite() { aim * most * scale * weight } else { 0.0 }
        };
        if each.iter().any(|x| x.is_finite()) {
            let each = [0, 1, 2].map(|k| wide(each[k], AIM_OF_AXIS, weights[k]));
            return if each == [0.0; 3] { Self::None } else { Self::Box(each) };
        }
        // Rows of one block share a sphere if they share a weight.
        let most = weights.iter().copied().fold(0.0, f64::max);
        let shared = weights.iter().all(|w| *w == 0.0 || *w == most);
        let radius = if shared { wide(whole, AIM, most) } else { 0.0 };
        if radius > 0.0 { Self::Ball(radius) } else { Self::None }
    }
}

impl Slack {
    fn of(aim: &Aim, size: f64, rotation_scale: f64) -> Option<Self> {
        let Tolerance { position, orientation, axes } = aim.tolerance();
        let [x, y, z, a, b, c] = axes.map_or([f64::INFINITY; 6], |axes| axes.most);
        let weights = aim.weights();
        let (place, turn) = weights.split_at(3);
        let position = Room::of(position, [x, y, z], place, 1.0, WIDE * size);
        let orientation = Room::of(orientation, [a, b, c], turn, rotation_scale, WIDE);
        let some = position != Room::None || orientation != Room::None;
        some.then_some(Self { position, orientation })
    }
}

/// An aim and how to get there, checked and worked out for a chain. Making one may cost more
/// than solving a target: gains of feedback laws come from a singular value decomposition.
#[derive(Debug, Clone)]
pub struct Setup {
    pub(super) aim: Aim,
    pub(super) settings: Settings,
    pub(super) rotation_scale: f64,
    pub(super) lengths: Lengths,
    /// The point in the last joint's frame whose position the error's rows compare, m.
    pub(super) point: [f64; 3],
    /// Tolerances that are too wide to aim at the middle of.
    pub(super) slack: Option<Slack>,
    /// The feedback law of the settings, if it is one.
    pub(super) feedback: Option<Feedback>,
    /// Where first attempts start if the caller gives no start and the solver has one.
    pub(super) usual_start: Option<Vec<f64>>,
    pub(super) ranking: Ranking,
    pub(super) tool_reach: Reach,
    /// What answers are moved to be best at, if the request says nothing else.
    pub(super) second: Option<Box<Second>>,
    /// Joint values of the chain that it was made for.
    pub(super) dof: usize,
}

impl Setup {
    /// The rows of the aim.
    #[inline(always)]
    pub(super) fn measure(&self) -> Measure {
        self.aim.measure(self.rotation_scale)
    }

    /// The way from the point whose position the rows compare to the tool point, if any.
    #[inline(always)]
    pub(super) fn onward(&self) -> Option<[f64; 3]> {
        let (from, to) = (self.point, self.aim.tail().translation);
        (from != to).then(|| [0, 1, 2].map(|k| to[k] - from[k]))
    }

    /// A goal of the tool point as one of the point whose position the rows compare.
    #[inline(always)]
    pub(super) fn at_point(&self, mut goal: Goal<f64>) -> Goal<f64> {
        if let Some(onward) = self.onward() {
            for (axis, along) in goal.axes.iter().zip(onward) {
                for (x, a) in goal.position.iter_mut().zip(axis) {
                    *x -= a * along;
                }
            }
        }
        goal
    }

    /// [`Aim::well_known`] of a goal.
    #[inline(always)]
    pub(super) fn well_known(&self, goal: &Goal<f64>) -> f64 {
        self.aim.well_known(self.tool_reach.size, goal.position)
    }

    /// The same setup, with a second aim of its own.
    pub fn with_second(self, second: Second) -> Self {
        Self { second: Some(Box::new(second)), ..self }
    }

    /// A checked setup.
    pub fn new(chain: &Chain, aim: Aim, settings: Settings) -> Result<Self> {
        settings.check()?;
        let tail = *aim.tail();
        let compiled = chain.compiled();
        let tool_reach = if tail == compiled.tail {
            *chain.reach()
        } else {
            Reach::with_tail(compiled, chain.variables(), &tail)
        };
        let tolerance = aim.tolerance();
        let own = compiled.tail.translation;
        let near = compiled.pose_point(own);
        // Where the orientation is met exactly, and only there, any point of the tool will do.
        let by_pose_point = aim.fixes_pose()
            && chain.dof() >= 6
            && tolerance.orientation <= WIDE
            && !settings.step.is_feedback();
        let size = if by_pose_point && near != own {
            let tail = Tail { translation: near, ..compiled.tail };
            Reach::with_tail(compiled, chain.variables(), &tail).size
        } else if !by_pose_point && compiled.pose_point(tail.translation) != tail.translation {
            tool_reach.size
        } else {
            chain.reach().size
        };
        let point =
            if by_pose_point { compiled.pose_point(tail.translation) } else { tail.translation };
        let rotation_scale = rotation_scale(size);
        let slides = chain.variables().iter().any(|v| v.kind == JointKind::Prismatic);
        let lengths = Lengths::new(size, slides);
        let slack = Slack::of(&aim, size, rotation_scale)
            .filter(|_| !settings.plain && !settings.step.is_feedback())
            // About another point than the tool's the sphere would be no sphere.
            .filter(|_| point == tail.translation);
        let feedback = Feedback::new(&settings, chain, &aim, rotation_scale)?;
        let usual_start = match settings.start {
            StartRule::Sampled => None,
            StartRule::Zero => Some(chain.near_zero()),
            StartRule::Middle => Some(middle(chain)),
        };
        let ranking = ranking(&aim, near, point, rotation_scale);
        Ok(Self {
            aim,
            settings,
            rotation_scale,
            lengths,
            point,
            slack,
            feedback,
            usual_start,
            ranking,
            tool_reach,
            second: None,
            dof: chain.dof(),
        })
    }
}

/// By what starts are compared with a goal of the task. `sampled` is the point whose places
/// the table holds, `point` the one whose place the goal gives.
fn ranking(aim: &Aim, sampled: [f64; 3], point: [f64; 3], rotation_scale: f64) -> Ranking {
    let squared = rotation_scale * rotation_scale;
    let (axes, direction) = match aim.measure(rotation_scale) {
        Measure::Pose(_) => (squared, ([0.0; 3], 0.0)),
        Measure::Axis(rows) => (0.0, (rows.axis, squared)),
        // Rows that are free make the axes a poor guide; the tool point is one if it counts.
        Measure::Position(_) | Measure::Framed(_) => (0.0, ([0.0; 3], 0.0)),
    };
    let shift = [0, 1, 2].map(|k| point[k] - sampled[k]);
    Ranking { placed: aim.fixes_position(), shift, axes, direction }
}

#[cfg(test)]
mod tests {
    use nalgebra::IsometryMatrix3;

    use super::*;
    use crate::call::{Goals, Request, Starts, solve};
    use crate::chain::{DhConvention, DhRow};
    use crate::solve::Plan;
    use crate::task::Task;

    fn arm(joints: usize) -> Chain {
        let joints = (0..joints).map(|i| {
            let row = DhRow { a: 0.3, alpha: 1.2, d: 0.1, theta: 0.0 };
            let (kind, end) = (JointKind::Revolute, 2.0);
            row.joint(DhConvention::Standard, format!("joint_{i}"), kind, -end, end)
        });
        let none = IsometryMatrix3::identity();
        Chain::new("arm", joints.collect(), none, none, None).expect("a chain")
    }

    #[test]
    fn a_setup_serves_many_calls_of_its_chain() {
        let chain = arm(4);
        let points = [[0.4, 0.3, 0.5], [0.1, -0.5, 0.6]];
        let goals = Goals::Positions { points: &points, direction: None };
        // The state space need not get there, but has to do the same each time.
        for (settings, solves) in
            [(Settings::LEVENBERG_MARQUARDT, true), (Settings::STATE_SPACE, false)]
        {
            let aim = Aim::new(&chain, Task::Position, Tolerance::default(), None).expect("valid");
            let setup = Setup::new(&chain, aim, settings.clone()).expect("valid");
            let request = Request::new(&chain, aim, goals, Starts::Free).expect("valid");
            let whole = Plan::new(request.with_seed(3, 1), settings).expect("valid");
            let wanted = solve(&whole, 1, &mut || true).expect("not interrupted");
            assert!(!solves || wanted.success(0) && wanted.success(1), "{:?}", wanted.status);
            for _ in 0..2 {
                let call = setup.plan(&chain, goals, Starts::Free, 3, 1).expect("valid");
                assert_eq!(solve(&call, 1, &mut || true).expect("not interrupted"), wanted);
            }
            let other = arm(5);
            let other = setup.plan(&other, goals, Starts::Free, 3, 1).map(|_| ());
            let said = other.expect_err("made for another chain").to_string();
            assert!(said.contains("setup") && said.contains('4') && said.contains('5'), "{said}");
        }
    }
}
