//! A plan: a request, and the setup of the step solver that is to fulfil it.

use std::ops::Deref;

use super::Settings;
use super::limit::wound;
use super::setup::Setup;
use super::start::Sampler;
use crate::call::{Aim, Answers, Copies, Goals, Merit, Request, Second, Solve, Starts, Tolerance};
use crate::chain::{Chain, Variable};
use crate::error::{Error, Result};
use crate::lanes::Level;
use crate::task::{Goal, Task};

/// A request and how to fulfil it.
#[derive(Debug, Clone)]
pub struct Plan<'a> {
    pub(super) request: Request<'a>,
    setup: Held<'a>,
    pub(super) sampler: Sampler<'a>,
    /// Limits inside those of the chain that hold for this call, rad or m.
    pub(super) bounds: Option<Vec<(f64, f64)>>,
    /// These bounds are limits in place of the chain's, perhaps outside of them, and the rows of
    /// the plan come one at a time.
    pub(super) limited: bool,
    /// A second aim: share of the way to a posture that each step tries to go.
    pub(super) pull: Option<(f64, Vec<f64>)>,
}

/// A plan's own setup, in a box since plans are moved about and it is long, or one made before.
#[derive(Debug, Clone)]
enum Held<'a> {
    Own(Box<Setup>),
    Lent(&'a Setup),
}

impl Deref for Held<'_> {
    type Target = Setup;
    #[inline(always)]
    fn deref(&self) -> &Setup {
        match self {
            Self::Own(setup) => setup,
            Self::Lent(setup) => setup,
        }
    }
}

/// The setups of the default solver for poses and positions with the tolerances that are usual.
struct Usual(Option<[Setup; 2]>);

impl Usual {
    fn new(chain: &Chain) -> Self {
        let setup = |task| {
            let aim = Aim::new(chain, task, Tolerance::default(), None)?;
            Setup::new(chain, aim, Settings::default())
        };
        Self(setup(Task::Pose).and_then(|pose| Ok([pose, setup(Task::Position)?])).ok())
    }

    /// The setup of an aim and settings, if it is one of these.
    #[inline(always)]
    fn of(&self, aim: &Aim, settings: &Settings) -> Option<&Setup> {
        let all = self.0.as_ref().filter(|all| all[0].settings == *settings)?;
        all.iter().find(|setup| setup.aim == *aim)
    }
}

impl<'a> Plan<'a> {
    /// A plan with a setup of its own, or with one of those that are usual.
    pub fn new(request: Request<'a>, settings: Settings) -> Result<Self> {
        let (chain, aim) = (request.chain(), request.aim());
        // What most calls ask for is kept with the chain.
        if let Some(usual) = chain.memo(Usual::new).of(aim, &settings) {
            return Ok(Self::of(request, Held::Lent(usual)));
        }
        Ok(Self::of(request, Held::Own(Box::new(Setup::new(chain, *aim, settings)?))))
    }

    /// A plan with a setup that was made before, for the same chain and aim.
    pub(super) fn with_setup(request: Request<'a>, setup: &'a Setup) -> Self {
        Self::of(request, Held::Lent(setup))
    }

    #[inline(always)]
    fn of(request: Request<'a>, setup: Held<'a>) -> Self {
        let sampler = Sampler::new(&request, setup.ranking);
        Self { request, setup, sampler, bounds: None, limited: false, pull: None }
    }

    /// What answers are moved to be best at, where the target leaves a freedom for it: what the
    /// request asks for, or the setup.
    pub(super) fn second_aim(&self) -> Option<&Second> {
        let second = self.request.second().or(self.setup().second.as_deref());
        second.filter(|_| self.leaves_freedom(usize::from(self.turns_freely())))
    }

    /// Answers with a joint at a limit are replaced: the target leaves a freedom for it, and nobody
    /// gave a start that they belong to.
    pub(super) fn keeps_off_limits(&self) -> bool {
        let settings = &self.setup().settings;
        let steps = !settings.plain && !settings.step.is_feedback();
        // A free turn about an axis does not count: six joints keep the answers that they had.
        steps && matches!(self.request.starts(), Starts::Free) && self.leaves_freedom(0)
    }

    /// More than one posture around a solution is one.
    fn leaves_freedom(&self, free: usize) -> bool {
        self.request.chain().dof() + free > self.weighed() || self.setup().slack.is_some()
    }

    /// Of the six numbers of a pose those that count.
    fn weighed(&self) -> usize {
        self.setup().aim.weights().iter().filter(|w| **w != 0.0).count()
    }

    /// The tool may turn about its axis.
    fn turns_freely(&self) -> bool {
        matches!(self.setup().aim.task(), Task::Axis { .. })
    }

    /// All of some rows are asked for, of an arm that has one joint more; manipulability is that of
    /// all six then.
    pub(super) fn spares_one(&self, rows: usize) -> bool {
        let all = if self.turns_freely() { rows == 5 } else { rows == self.weighed() };
        let whole = |second: &Second| second.measure != Merit::Manipulability || rows == 6;
        all && self.request.chain().dof() == rows + 1
            && self.setup().slack.is_none()
            && self.second_aim().is_some_and(whole)
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
        Plan { request, setup: Held::Own(Box::new(setup)), ..self.clone() }
    }

    /// The same plan with other limits.
    pub(super) fn within(&self, limits: &[[f64; 2]]) -> Plan<'_> {
        let bounds = Some(limits.iter().map(|[lower, upper]| (*lower, *upper)).collect());
        let setup = Held::Lent(self.setup());
        Plan {
            request: self.request,
            setup,
            sampler: self.sampler.clone(),
            bounds,
            limited: true,
            pull: None,
        }
    }

    /// Some limits are outside those of the chain, for which its reach holds.
    fn is_wider(&self) -> bool {
        let wider =
            |(v, (lower, upper)): (&Variable, &(f64, f64))| *lower < v.lower || v.upper < *upper;
        let bounds = self.bounds.iter().filter(|_| self.limited).flatten();
        self.request.chain().variables().iter().zip(bounds).any(wider)
    }

    /// The limits of a joint in this plan.
    pub(super) fn ends(&self, i: usize) -> (f64, f64) {
        let v = &self.request.chain().variables()[i];
        let own = (v.lower, v.upper);
        self.bounds.as_ref().filter(|_| self.limited).map_or(own, |bounds| bounds[i])
    }

    /// Starts for target `row`, one after the other: its start values, by turns some around them,
    /// farther each time, and some from anywhere; `count` in all.
    pub(crate) fn starts(&self, row: usize, count: usize) -> Vec<f64> {
        let (Some(goal), Some(q0)) = (self.request.goal(row), self.start(row)) else {
            return Vec::new();
        };
        let there = self.setup().at_point(goal);
        let mut starts = q0.to_vec();
        let mut start = q0.to_vec();
        for attempt in 1..count as u32 {
            start.copy_from_slice(q0);
            if attempt % 2 == 1 {
                self.sampler.around(row, 1 + attempt / 4, &mut start);
            } else {
                self.sampler.sample(row, attempt / 2, &there, &mut start);
            }
            starts.extend_from_slice(&start);
        }
        starts
    }

    /// What one attempt at target `row` from each of some starts leads to, moved to where `second`,
    /// about the start values of the row, is best.
    pub(crate) fn moved(
        &self,
        level: Level,
        row: usize,
        starts: &[f64],
        second: &Second,
    ) -> Answers {
        let dof = self.request.chain().dof();
        let count = starts.len() / dof;
        let mut answers = Answers::new(count, dof);
        let Some(q0) = self.start(row).filter(|_| count > 0) else { return answers };
        let copies = self.request.copies(row, count);
        let one = Settings { max_restarts: 0, ..Settings::LEVENBERG_MARQUARDT };
        let mut plan = self.with(&copies, starts, one);
        let about = second.about(q0);
        plan.request = plan.request.with_second(&about);
        let rows = vec![row; count];
        plan.sampler.chosen = Some(&rows);
        let mut all = Some(answers.as_mut());
        plan.run(level, &mut || all.take(), &mut || true);
        for (x, (v, about)) in answers
            .q
            .chunks_exact_mut(dof)
            .flat_map(|q| q.iter_mut().zip(self.request.chain().variables().iter().zip(q0)))
        {
            *x = wound(v, *x, *about);
        }
        answers
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
        if self.is_wider() || !request.aim().fixes_position() {
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
