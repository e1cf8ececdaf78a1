//! A plan: a request, and the setup of the step solver that is to fulfil it.

use std::borrow::Cow;

use super::Settings;
use super::setup::Setup;
use super::start::Sampler;
use crate::call::{Copies, Goals, Request, Starts};
use crate::chain::Chain;
use crate::error::{Error, Result};
use crate::task::Goal;

/// A request and how to fulfil it.
#[derive(Debug, Clone)]
pub struct Plan<'a> {
    pub(super) request: Request<'a>,
    setup: Cow<'a, Setup>,
    pub(super) sampler: Sampler<'a>,
    /// Limits inside those of the chain that hold for this call, rad or m.
    pub(super) bounds: Option<Vec<(f64, f64)>>,
    /// A second aim: share of the way to a posture that each step tries to go.
    pub(super) pull: Option<(f64, Vec<f64>)>,
}

impl<'a> Plan<'a> {
    /// A plan with a setup of its own.
    pub fn new(request: Request<'a>, settings: Settings) -> Result<Self> {
        let setup = Setup::new(request.chain(), *request.aim(), settings)?;
        Ok(Self::of(request, Cow::Owned(setup)))
    }

    /// A plan with a setup that was made before, for the same chain and aim.
    pub(super) fn with_setup(request: Request<'a>, setup: &'a Setup) -> Self {
        Self::of(request, Cow::Borrowed(setup))
    }

    fn of(request: Request<'a>, setup: Cow<'a, Setup>) -> Self {
        let sampler = Sampler::new(&request, setup.ranking);
        Self { request, setup, sampler, bounds: None, pull: None }
    }

    /// What is to be reached.
    pub fn request(&self) -> &Request<'a> {
        &self.request
    }
    /// What the targets share.
    pub(super) fn setup(&self) -> &Setup {
        &self.setup
    }

    /// The same call with other targets, starts and step settings: a solver's own subtask.
    pub(super) fn with<'b>(
        &'b self,
        copies: &'b Copies,
        starts: &'b [f64],
        settings: Settings,
    ) -> Plan<'b> {
        let setup = Setup { settings, ..self.setup().clone() };
        let request = self.request.with(copies, starts);
        Plan { request, setup: Cow::Owned(setup), ..self.clone() }
    }

    /// Where the first attempt at target `row` starts, unless that is left to chance.
    #[inline(always)]
    pub(super) fn start(&self, row: usize) -> Option<&[f64]> {
        self.request.start(row).or(self.setup.usual_start.as_deref())
    }

    /// True where a bound of the reach proves that the goal cannot be met.
    #[inline(always)]
    pub(super) fn proven_unreachable(&self, goal: &Goal<f64>) -> bool {
        let request = &self.request;
        let (task, tolerance) = (request.task(), request.tolerance());
        if !request.aim().fixes_position() {
            return false;
        }
        if self.setup.tool_reach.excess(goal.position) > tolerance.position {
            return true;
        }
        let pose = task.fixes_pose();
        let Some(wrist) = request.chain().last_joint_reach().filter(|_| pose) else {
            return false;
        };
        // The tool's place and axes give the last joint's origin; an orientation error
        // within tolerance moves it by that angle times the tool's length.
        let t = request.tail().translation;
        let mut p = goal.position;
        for (axis, along) in goal.axes.iter().zip(t) {
            for (x, a) in p.iter_mut().zip(axis) {
                *x -= a * along;
            }
        }
        let arm = t.iter().map(|x| x * x).sum::<f64>().sqrt();
        wrist.excess(p) > tolerance.position + arm * tolerance.orientation
    }
}

impl Setup {
    /// A call for targets of the chain that the setup was made for; allocates nothing.
    pub fn plan<'a>(
        &'a self,
        chain: &'a Chain,
        goals: Goals<'a>,
        starts: Starts<'a>,
        seed: u64,
        first_index: u64,
    ) -> Result<Plan<'a>> {
        if self.dof != chain.dof() {
            let expected = format!("one of {} joint values", chain.dof());
            return Err(Error::argument("setup", expected, self.dof));
        }
        let request = Request::new(chain, self.aim, goals, starts)?.with_seed(seed, first_index);
        Ok(Plan::with_setup(request, self))
    }
}
