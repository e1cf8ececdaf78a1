//! Six joints whose last three axes meet, or whose first three do: then the arm is read from its
//! tool, and has a spherical wrist as well.

use super::SphericalWrist;
use super::postures::{Candidates, Set};
use crate::closed_form::geometry::axes::Geometry;
use crate::closed_form::geometry::candidate::{Candidate, JOINTS, MOST_BRANCHES};
use crate::closed_form::geometry::enclosure::Margin;
use crate::closed_form::geometry::rigid::Rigid;
use crate::closed_form::geometry::screws::Screws;
use crate::closed_form::geometry::serial::Serial;
use crate::closed_form::geometry::turn::Turn;
use crate::lanes::{Kernel, Level, Real, cross, dispatch, norm};
use crate::task::Goal;

/// An arm with three axes that meet at one end.
#[derive(Debug, Clone, PartialEq)]
pub struct Meeting {
    arm: SphericalWrist,
    serial: Serial<6>,
    /// The first three axes meet.
    reversed: bool,
    /// The last joint's frame at `q = 0`, of the arm as it is read.
    frame: Rigid<f64>,
    untool: Rigid<f64>,
    length: f64,
}

impl Meeting {
    /// The arm of six axes with its spherical end last, or first where `reversed`; or why it
    /// has none.
    pub fn new(screws: &Screws, reversed: bool) -> Result<Self, String> {
        let screws = screws.gathered();
        let length = screws.length();
        let scaled = screws.scaled(1.0 / length);
        let serial = Serial::<6>::new(&scaled).ok_or("it has no six joints")?;
        let read = if reversed { scaled.reversed().gathered() } else { scaled };
        let last = read.joints[5];
        let guess = if last.axis[0].abs() < 0.8 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let y = cross(last.axis, guess);
        let size = crate::lanes::dot(y, y).sqrt();
        let y = y.map(|x| x / size);
        let frame = Rigid { axes: [cross(y, last.axis), y, last.axis], shift: last.point };
        let lines: Vec<_> = read.joints.iter().map(|one| (one.point, one.axis)).collect();
        // Lines are taken for meeting by the same measure as in the other families here.
        let geometry = Geometry::of_lines(&lines, frame.axes[0], 3.0)?;
        Ok(Self {
            arm: SphericalWrist::new(geometry)?,
            serial,
            reversed,
            frame,
            untool: read.tool.inverse(),
            length,
        })
    }

    /// The first three axes meet.
    pub fn is_reversed(&self) -> bool {
        self.reversed
    }

    /// No posture comes within a margin of a goal (m), whatever the limits: proven.
    pub fn is_out_of_reach(&self, goal: &Rigid<f64>, margin: Margin) -> bool {
        let mut goal = *goal;
        goal.shift = goal.shift.map(|x| x / self.length);
        let geometry = self.arm.geometry();
        let misfit = geometry.misfit.position.max(geometry.misfit.orientation);
        let mut margin = margin.widened(self.length, misfit, 3.0 + norm(goal.shift));
        let read = if self.reversed {
            // An error of the orientation moves the base as the tool sees it.
            margin.position = margin.at(norm(goal.shift));
            goal.inverse()
        } else {
            goal
        };
        let lever = self.untool.after(&self.frame);
        let at = read.after(&lever);
        let wanted = Goal { position: at.shift, axes: at.axes };
        let off = margin.at(norm(lever.shift));
        !margin.is_wide() && self.arm.is_out_of_reach(&wanted, off, margin.turn)
    }

    /// All postures of goals (m); an angle that nothing decides is taken from `near`.
    pub fn solve(&self, level: Level, goals: &[Rigid<f64>], near: &[[f64; 6]], sets: &mut [Set]) {
        dispatch(level, All { arm: self, goals, near, sets });
    }

    /// Candidates of the arm as it is read, those of the arm.
    #[inline(always)]
    fn taken<R: Real>(&self, one: &Candidate<R>) -> Candidates<R> {
        let mut q = [R::zero(); 6];
        for (k, x) in q.iter_mut().enumerate() {
            *x = one.q[if self.reversed { 5 - k } else { k }];
        }
        // The wrist's singularity leaves its first joint free, the shoulder's that of the arm.
        let (wrist, base) = if self.reversed { (1 << 2, 1 << 5) } else { (1 << 3, 1) };
        Candidates {
            q,
            merged: one.merged,
            singular: one.singular,
            open: [(one.singular[2], wrist), (0, base)],
        }
    }

    /// Puts a candidate into the sets of its goals, see [`Candidates::settle`].
    #[inline(always)]
    fn settle<R: Real>(&self, one: &Candidate<R>, goal: &Rigid<R>, lanes: usize, sets: &mut [Set]) {
        let found = self.taken(one);
        let (_, left, _) = self.serial.errors(&found.q, goal);
        found.settle(&self.serial, (goal, left), lanes, sets);
    }
}

struct All<'a> {
    arm: &'a Meeting,
    goals: &'a [Rigid<f64>],
    near: &'a [[f64; 6]],
    sets: &'a mut [Set],
}

impl Kernel for All<'_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        let Self { arm, goals, near, sets } = self;
        // Of a single goal the lanes hold its postures, where there is room for all.
        let alone = goals.len() == 1 && R::WIDTH >= MOST_BRANCHES / 2;
        let scale = 1.0 / arm.length;
        let frame = Rigid::<R>::splat(&arm.frame);
        let mut first = 0;
        while first < goals.len() {
            let count = if alone { 1 } else { R::WIDTH.min(goals.len() - first) };
            let mut goal = Rigid::<R>::identity();
            let mut values = [R::zero(); 6];
            for lane in 0..R::WIDTH {
                let row = first + if lane < count { lane } else { 0 };
                let mut one = goals[row];
                for x in &mut one.shift {
                    *x *= scale;
                }
                goal.set_lane(lane, &one);
                for k in 0..6 {
                    values[k].set_lane(lane, near[row][if arm.reversed { 5 - k } else { k }]);
                }
            }
            let mut preferred: [Turn<R>; JOINTS] = [(R::zero(), R::splat(1.0)); JOINTS];
            for k in 0..6 {
                preferred[k] = (values[k] + R::splat(arm.arm.geometry().offset(k))).sin_cos();
            }
            let read = if arm.reversed { goal.inverse() } else { goal };
            let at = read.after(&Rigid::splat(&arm.untool)).after(&frame);
            let wanted = Goal { position: at.shift, axes: at.axes };
            let own = &mut sets[first..first + count];
            // One way to turn the wrist after the other, so that postures come in the same order
            // whatever the lanes hold.
            if alone {
                let both = arm.arm.side_by_side(&wanted, [0.0; 3], &preferred, 0);
                for one in &both {
                    arm.settle(one, &goal, MOST_BRANCHES / 2, own);
                }
            } else {
                let mut out = [Candidate::none(); MOST_BRANCHES];
                arm.arm.solve(&wanted, [0.0; 3], &preferred, &mut out);
                for one in out.iter().step_by(2).chain(out.iter().skip(1).step_by(2)) {
                    arm.settle(one, &goal, count, own);
                }
            }
            first += count;
        }
    }
}
