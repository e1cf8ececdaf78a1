//! A checked call of a closed form, and how its targets get into a lane group.

use crate::closed_form::families::ClosedForm;

use super::arm_angle::{ArmAngle, arm_angles, form_of};
use crate::call::{Request, Starts};
use crate::chain::Chain;
use crate::closed_form::branch::choice::Choice;
use crate::closed_form::branch::group::{Group, Job, Near};
use crate::error::{Error, Result};
use crate::lanes::{Lanes, Real};
use crate::task::Goal;

/// Targets of one run: what a thread takes at a time.
pub(crate) const RUN: usize = 256;
/// Up to this many targets are solved one after the other.
pub(crate) const FEW: usize = 2;

/// One target, and what its answers stay near.
pub(crate) struct Target<R> {
    pub goal: Goal<f64>,
    pub near: Near<R>,
    /// Arm angle, rad.
    pub angle: f64,
}

/// A call of a closed form.
#[derive(Debug, Clone)]
pub struct Query<'a> {
    pub(crate) request: Request<'a>,
    pub(crate) form: &'a ClosedForm,
    pub(crate) angle: ArmAngle<'a>,
    pub(crate) choice: Choice,
    /// The best arm angle is proven to be the best.
    pub(crate) proof: bool,
    /// Targets without a valid branch are looked at once more.
    pub(crate) last_search: bool,
    /// No proof is looked for that targets without a branch have no solution.
    pub(crate) reached: bool,
}

impl<'a> Query<'a> {
    /// A checked call.
    #[inline]
    pub fn new(request: Request<'a>, angle: ArmAngle<'a>, choice: Choice) -> Result<Self> {
        if !request.task().fixes_pose() {
            return Err(Error::argument("task", "the full pose, for closed forms", "another task"));
        }
        let form = form_of(request.chain())?;
        arm_angles(form, angle, request.len())?;
        Ok(Self { request, form, angle, choice, proof: false, last_search: true, reached: false })
    }

    /// The same call, where a free arm angle is proven to be the best and not only the best
    /// of those looked at.
    pub fn with_proof(self) -> Self {
        Self { proof: true, ..self }
    }

    /// The same call for nothing but branches: a target without a valid one is not looked at
    /// again, neither for a posture within the tolerances nor for a proof that there is none.
    pub fn without_last_search(self) -> Self {
        Self { last_search: false, ..self }
    }

    /// The arm reaches targets at arm angles that are free.
    pub(crate) fn is_redundant(&self) -> bool {
        matches!((self.form, self.angle), (ClosedForm::Srs(_), ArmAngle::Free))
    }

    pub(crate) fn chain(&self) -> &'a Chain {
        self.request.chain()
    }

    #[inline(always)]
    pub(crate) fn job(&self) -> Job<'a> {
        Job { steps: matches!(self.angle, ArmAngle::Free), ..Job::new(self.form, &self.request) }
    }

    /// The arm angle of a target; 0 where there is none.
    #[inline(always)]
    pub(crate) fn angle(&self, row: usize) -> f64 {
        match (self.angle, self.form) {
            (ArmAngle::One(x), _) => x,
            (ArmAngle::Each(all), _) => all[row],
            (ArmAngle::Free, ClosedForm::Srs(arm)) => {
                self.request.start(row).map_or(0.0, |q0| arm.arm_angle(q0))
            }
            _ => 0.0,
        }
    }

    /// Loads targets `first..` into the lanes of a group; returns the lanes that hold a
    /// target and those whose target or start is not finite.
    #[inline(always)]
    pub(crate) fn load<R: Real>(
        &self,
        group: &mut Group<'_, R>,
        first: usize,
        end: usize,
    ) -> (Lanes, Lanes) {
        let geometry = group.job.geometry;
        let turns = matches!(self.form, ClosedForm::Srs(_));
        let (mut used, mut bad) = (0, 0);
        for lane in 0..R::WIDTH {
            let row = first + lane;
            if row >= end {
                break;
            }
            used |= 1 << lane;
            let Some(goal) = self.request.goal(row) else {
                bad |= 1 << lane;
                continue;
            };
            group.goal.set_lane(lane, &goal);
            if let Some(q0) = self.request.start(row) {
                group.near.set(geometry, lane, q0, self.request.well_known(row));
            }
            if turns {
                let (s, c) = self.angle(row).sin_cos();
                group.angle.0.set_lane(lane, s);
                group.angle.1.set_lane(lane, c);
            }
        }
        if !matches!(self.request.starts(), Starts::Free) {
            group.near.turn(geometry);
            group.near.judged_by(self.choice, geometry);
        }
        (used, bad)
    }

    /// One target, in every lane; `None` where it or its start is not finite.
    #[inline(always)]
    pub(crate) fn alone<R: Real>(&self, job: &Job<'_>, row: usize) -> Option<Target<R>> {
        let goal = self.request.goal(row)?;
        let near = Near::to(job.geometry, &self.request, row);
        Some(Target { goal, near, angle: self.angle(row) })
    }
}
