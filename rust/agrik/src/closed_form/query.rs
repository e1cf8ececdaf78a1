//! A checked call of a closed form, and how its targets get into a lane group.

use super::ClosedForm;
use super::alone::Target;
use super::candidates::Lanes;
use super::choose::Choice;
use super::settle::{Group, Job, Near};
use crate::chain::Chain;
use crate::error::{Error, Result};
use crate::lanes::Real;
use crate::solve::{Plan, Starts};

/// Targets of one run: what a thread takes at a time.
pub(super) const RUN: usize = 256;
/// Up to this many targets are solved one after the other.
pub(super) const FEW: usize = 2;

/// The arm angles of a call, rad; of no account for arms without one.
#[derive(Debug, Clone, Copy)]
pub enum ArmAngle<'a> {
    /// That of the start values; for the best branch, the best of all arm angles.
    Free,
    /// The same for all targets.
    One(f64),
    /// One a target.
    Each(&'a [f64]),
}

/// A call of a closed form.
#[derive(Debug, Clone)]
pub struct Query<'a> {
    pub(super) plan: &'a Plan<'a>,
    pub(super) form: &'a ClosedForm,
    pub(super) angle: ArmAngle<'a>,
    pub(super) choice: Choice,
    /// The best arm angle is proven to be the best.
    pub(super) proof: bool,
}

impl<'a> Query<'a> {
    /// A checked call for the targets, starts and tolerances of a plan, whose solver
    /// settings are of no account.
    pub fn new(plan: &'a Plan<'a>, angle: ArmAngle<'a>, choice: Choice) -> Result<Self> {
        if !plan.task().fixes_pose() {
            return Err(Error::argument("task", "the full pose, for closed forms", "another task"));
        }
        let form = form_of(plan.chain())?;
        arm_angles(form, angle, plan.len())?;
        Ok(Self { plan, form, angle, choice, proof: false })
    }

    /// The same call, where a free arm angle is proven to be the best and not only the best
    /// of those looked at.
    pub fn with_proof(self) -> Self {
        Self { proof: true, ..self }
    }

    pub(super) fn chain(&self) -> &'a Chain {
        self.plan.chain()
    }

    #[inline(always)]
    pub(super) fn job(&self) -> Job<'a> {
        Job::new(self.chain(), self.form, *self.plan.tail(), self.plan.tolerance())
    }

    /// A target's start values, if it has any.
    #[inline(always)]
    pub(super) fn start(&self, row: usize) -> Option<&'a [f64]> {
        self.plan.starts().row(row, self.chain().dof())
    }

    /// The arm angle of a target; 0 where there is none.
    #[inline(always)]
    pub(super) fn angle(&self, row: usize) -> f64 {
        match (self.angle, self.form) {
            (ArmAngle::One(x), _) => x,
            (ArmAngle::Each(all), _) => all[row],
            (ArmAngle::Free, ClosedForm::Srs(arm)) => {
                self.start(row).map_or(0.0, |q0| arm.arm_angle(q0))
            }
            _ => 0.0,
        }
    }

    /// Loads targets `first..` into the lanes of a group; returns the lanes that hold a
    /// target and those whose target or start is not finite.
    #[inline(always)]
    pub(super) fn load<R: Real>(
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
            let Some(goal) = self.plan.goal(row) else {
                bad |= 1 << lane;
                continue;
            };
            group.goal.set_lane(lane, &goal);
            if let Some(q0) = self.start(row) {
                group.near.set(geometry, lane, q0);
            }
            if turns {
                let (s, c) = self.angle(row).sin_cos();
                group.angle.0.set_lane(lane, s);
                group.angle.1.set_lane(lane, c);
            }
        }
        if !matches!(self.plan.starts(), Starts::Free) {
            group.near.turn(geometry);
            group.near.judged_by(self.choice, geometry);
        }
        (used, bad)
    }

    /// One target, in every lane; `None` where it or its start is not finite.
    #[inline(always)]
    pub(super) fn alone<R: Real>(&self, job: &Job<'_>, row: usize) -> Option<Target<R>> {
        let goal = self.plan.goal(row)?;
        let near = Near::to(job.geometry, self.start(row));
        Some(Target { goal, near, angle: self.angle(row) })
    }
}

/// The family of a chain, or the error of a call for it.
pub(super) fn form_of(chain: &Chain) -> Result<&ClosedForm> {
    ClosedForm::of(chain).map_err(|why| Error::argument("solver", "an arm with a closed form", why))
}

/// Refuses arm angles that an arm has not, or that are no angles.
pub(super) fn arm_angles(form: &ClosedForm, angle: ArmAngle<'_>, targets: usize) -> Result<()> {
    let angles: &[f64] = match &angle {
        ArmAngle::Free => &[],
        ArmAngle::One(x) => std::slice::from_ref(x),
        ArmAngle::Each(all) => all,
    };
    if matches!(angle, ArmAngle::Each(_)) && angles.len() != targets {
        let expected = format!("{targets} numbers, one a target");
        return Err(Error::argument("arm_angle", expected, angles.len()));
    }
    if let Some(bad) = angles.iter().find(|x| !x.is_finite()) {
        return Err(Error::argument("arm_angle", "finite numbers", bad));
    }
    if !angles.is_empty() && !matches!(form, ClosedForm::Srs(_)) {
        let expected = "none, as the arm is not redundant";
        return Err(Error::argument("arm_angle", expected, "arm angles"));
    }
    Ok(())
}
