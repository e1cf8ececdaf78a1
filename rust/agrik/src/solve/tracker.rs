//! A control loop: a target a tick, and a posture that changes by no more than a bound.
//!
//! A tick continues the posture before by the step solver. Where that does not arrive within the
//! bound, the tick looks for the posture to go to: of those that reach the target, from a few
//! starts each tick, the one that is met soonest where the target goes on as it did, or, where
//! none does, the one that comes nearest to it. Each joint goes
//! there as fast as it may, so that the arm neither jumps nor stays in a dead end.

use super::Settings;
use super::engine::{End, Search};
use super::limit::{limits, wound};
use super::plan::Plan;
use super::setup::Setup;
use crate::allowed::is_measure;
use crate::call::{
    Aim, Answers, Copies, Goals, INSIDE, Outcome, Second, Solve, Starts, Status, solve_into,
};
use crate::chain::Chain;
use crate::error::{Error, Result};
use crate::kinematics::{PerJoint, Workspace, forward};
use crate::lanes::Level;
use crate::task::Goal;

/// One attempt from a start, and one inside the bound.
const ONE: Settings = Settings { max_restarts: 0, ..Settings::LEVENBERG_MARQUARDT };
const CONTINUE: Settings = Settings { max_iterations: 30, ..ONE };
/// Starts of a tick that did not arrive: around the posture, and anywhere.
const AROUND: u32 = 3;
const ANYWHERE: u32 = 4;
/// Another posture to go to takes less than this share of the ticks of the present one, or
/// brings the tool nearer by this share of the robot's size, or angle (rad).
const SOONER: f64 = 0.8;
const NEARER: f64 = 0.02;
const LESS_TURNED: f64 = 0.1;
/// A posture that runs away from the arm, or out of its limits, counts as so many times farther at
/// most: rates tell little of what comes later. Ticks for which it is taken to go on as it does,
/// and how far out of its limits that may lead, rad or m.
const LONGER: f64 = 4.0;
const AHEAD: f64 = 40.0;
const SLACK: f64 = 0.02;
/// Ticks out of reach in a row with a look elsewhere in each; later in every so many.
const LOOKS: u32 = 16;
const SELDOM: u32 = 8;

/// The state of a control loop of one arm.
#[derive(Debug, Clone)]
pub struct Tracker {
    /// The caller's step, without starts of its own.
    warm: Setup,
    /// The default step, for the searches.
    other: Setup,
    /// There is a second aim.
    refines: bool,
    most: Vec<f64>,
    /// Where the arm stands; `None` before the first tick.
    at: Option<PerJoint<f64>>,
    /// The posture that it goes to.
    toward: Option<PerJoint<f64>>,
    /// The target of the tick before, if that did not arrive.
    before: Option<Copies>,
    /// Ticks in a row that did not arrive.
    away: u32,
}

impl Tracker {
    /// A loop whose joints change by at most `most` a tick (rad or m, one number a joint).
    /// With a second aim each tick goes on to where that is best, as far as the bound lets it.
    pub fn new(
        chain: &Chain,
        aim: Aim,
        settings: Settings,
        most: Vec<f64>,
        second: Option<Second>,
    ) -> Result<Self> {
        check_steps("max_change", &most, chain.dof())?;
        let refines = second.is_some();
        let mut warm = Setup::new(chain, aim, Settings { max_restarts: 0, ..settings })?;
        if let Some(second) = second {
            warm = warm.with_second(second);
        }
        Ok(Self {
            warm,
            refines,
            other: Setup::new(chain, aim, ONE)?,
            most,
            at: None,
            toward: None,
            before: None,
            away: 0,
        })
    }

    /// True once the arm stands somewhere.
    pub fn has_started(&self) -> bool {
        self.at.is_some()
    }

    /// Puts the arm to a posture, from which the next tick goes on.
    pub fn stand(&mut self, q: &[f64]) {
        match &mut self.at {
            Some(at) => at.copy_from_slice(q),
            None => self.at = Some(q.into()),
        }
    }

    /// Goes a tick towards the only target of `goals` and says in `answers` where that led:
    /// reached, or held back by the bound or the reach.
    pub fn tick(
        &mut self,
        level: Level,
        chain: &Chain,
        goals: Goals<'_>,
        (seed, index): (u64, u64),
        answers: &mut Answers,
    ) -> Result<()> {
        let Some(at) = &self.at else {
            return Err(Error::argument("q0", "where the arm stands", "none"));
        };
        // Nobody knows where an arm stands whose joint values are no numbers: it stays.
        let known = at.iter().all(|x| is_measure(*x));
        if known {
            let mut plan = self.warm.plan(chain, goals, Starts::One(at), seed, index)?;
            if self.refines {
                plan.bounds = Some(bounds_around(chain, at, &self.most));
            }
            solve_into(level, &plan, 1, answers, &mut || true)?;
        }
        if !known || answers.status[0] == Status::BadInput as u8 {
            let unanswered = Outcome::unanswered(Status::BadInput);
            answers.as_mut().finish(0, unanswered).copy_from_slice(at);
            return Ok(());
        }
        if !answers.success(0) || !is_step(at, &answers.q, &self.most) {
            self.go_on(level, chain, goals, (seed, index), answers)?;
        } else {
            self.away = 0;
            self.toward = None;
            self.before = None;
        }
        if let Some(at) = &mut self.at {
            at.copy_from_slice(&answers.q);
        }
        Ok(())
    }

    /// What a tick does that did not arrive by the step alone.
    #[inline(never)]
    fn go_on(
        &mut self,
        level: Level,
        chain: &Chain,
        goals: Goals<'_>,
        (seed, index): (u64, u64),
        answers: &mut Answers,
    ) -> Result<()> {
        let Some(at) = &self.at else { return Ok(()) };
        let plan = self.other.plan(chain, goals, Starts::One(at), seed, index)?;
        let Some(goal) = plan.request.goal(0) else { return Ok(()) };
        let mut hunt = Hunt {
            plan: &plan,
            level,
            goal,
            at,
            most: &self.most,
            toward: self.toward.as_deref(),
            before: self.before.as_ref(),
            away: self.away,
            iterations: answers.iterations[0],
            restarts: 0,
        };
        let there = hunt.inside_the_bound();
        let toward = match &there {
            Some(_) => None,
            None => {
                let continued = answers.success(0).then_some(answers.q.as_slice());
                hunt.reaching(continued).or_else(|| hunt.nearest())
            }
        };
        let q = match (there, &toward) {
            (Some(q), _) => q,
            (None, Some(toward)) => step_towards(at, toward, &self.most),
            (None, None) => at.clone(),
        };
        let mut workspace = Workspace::new(chain.compiled());
        forward(chain.compiled(), &q, &mut workspace);
        let left = plan.request.left(&workspace, &goal);
        let reached = plan.request.aim().is_met(&left) && chain.within_limits(&q);
        let outcome = Outcome {
            status: if reached { Status::Converged } else { Status::Held },
            position_error: left.position2.sqrt(),
            orientation_error: left.orientation2.sqrt(),
            iterations: hunt.iterations,
            restarts: hunt.restarts,
        };
        answers.as_mut().finish(0, outcome).copy_from_slice(&q);
        self.away = if reached { 0 } else { self.away.saturating_add(1) };
        self.toward = toward.filter(|_| !reached);
        self.before = (!reached).then(|| plan.request.copies(0, 1));
        Ok(())
    }
}

/// The search for a posture to go to.
struct Hunt<'t> {
    plan: &'t Plan<'t>,
    level: Level,
    goal: Goal<f64>,
    at: &'t [f64],
    most: &'t [f64],
    toward: Option<&'t [f64]>,
    before: Option<&'t Copies>,
    away: u32,
    iterations: u32,
    restarts: u32,
}

impl Hunt<'_> {
    /// A posture within the bound that reaches the target.
    fn inside_the_bound(&mut self) -> Option<PerJoint<f64>> {
        let bounds = bounds_around(self.plan.request.chain(), self.at, self.most);
        let found = self.attempts(self.at, CONTINUE, Some(bounds));
        found.into_iter().flatten().find(|q| is_step(self.at, q, self.most))
    }

    /// The soonest posture that reaches the target, of the one that the step led to, the one
    /// that the arm is on its way to and those from a few starts.
    fn reaching(&mut self, continued: Option<&[f64]>) -> Option<PerJoint<f64>> {
        if self.plan.proven_unreachable(&self.goal) {
            return None;
        }
        let first = self.away.wrapping_mul(AROUND + ANYWHERE);
        let mut starts = self.toward.unwrap_or(self.at).to_vec();
        let mut start = vec![0.0; self.at.len()];
        for attempt in 1..=AROUND {
            start.copy_from_slice(self.at);
            self.plan.sampler.around(first as usize, attempt, &mut start);
            starts.extend_from_slice(&start);
        }
        for attempt in 0..ANYWHERE {
            let attempt = first.wrapping_add(AROUND + attempt);
            let there = self.plan.setup().at_point(self.goal);
            self.plan.sampler.sample(0, attempt, &there, &mut start);
            starts.extend_from_slice(&start);
        }
        self.restarts += AROUND + ANYWHERE;
        let mut found = self.attempts(&starts, ONE, None).into_iter();
        let present = found.next().flatten().filter(|_| self.toward.is_some());
        let continued = continued.map(PerJoint::from_slice);
        let mut all: Vec<PerJoint<f64>> = present.into_iter().collect();
        let stays = all.len();
        all.extend(found.flatten().chain(continued));
        let times = self.meetings(&all);
        let best = (stays..all.len()).min_by(|a, b| times[*a].total_cmp(&times[*b]));
        let chosen = match best {
            Some(best) if stays == 0 || times[best] < SOONER * times[0] => best,
            _ if stays > 0 => 0,
            _ => return None,
        };
        Some(all.swap_remove(chosen))
    }

    /// Ticks until the arm meets each of some postures if they go on as they did since the tick
    /// before; many where it does not, or where that leads out of the limits before long.
    fn meetings(&mut self, postures: &[PerJoint<f64>]) -> Vec<f64> {
        let still = |q: &PerJoint<f64>| ticks(self.at, q, self.most);
        let Some(before) = self.before else { return postures.iter().map(still).collect() };
        let (chain, at, most) = (self.plan.request.chain(), self.at, self.most);
        let starts: Vec<f64> = postures.iter().flatten().copied().collect();
        let before = before.repeated(postures.len());
        let were = self.attempts_at(&before, &starts, CONTINUE, None);
        let meeting = |(q, was): (&PerJoint<f64>, Option<PerJoint<f64>>)| {
            let still = ticks(at, q, most);
            let Some(was) = was else { return still };
            let variables = chain.variables().iter().enumerate();
            let rates: PerJoint<f64> =
                variables.clone().map(|(j, v)| q[j] - wound(v, was[j], q[j])).collect();
            let time = |(j, rate): (usize, &f64)| {
                let way = q[j] - at[j];
                // Ahead of it or behind: what is left of the joint's own rate closes the way.
                let closing = most[j] - if way > 0.0 { *rate } else { -rate };
                way.abs() / closing.max(most[j] / LONGER)
            };
            let soonest = rates.iter().enumerate().map(time).fold(0.0, f64::max);
            // What bends is not told by its rates for long.
            let ahead = soonest.min(AHEAD);
            let mut ends = variables.map(|(j, v)| (q[j] + ahead * rates[j], v));
            let leaves = ends.any(|(end, v)| end < v.lower - SLACK || end > v.upper + SLACK);
            if leaves { LONGER * soonest.max(still) } else { soonest }
        };
        postures.iter().zip(were).map(meeting).collect()
    }

    /// The posture that comes nearest to a target that none was found to reach.
    fn nearest(&mut self) -> Option<PerJoint<f64>> {
        let (end, q) = self.nearest_from(self.toward.unwrap_or(self.at).into());
        if self.away >= LOOKS && !self.away.is_multiple_of(SELDOM) {
            return Some(q);
        }
        let mut start: PerJoint<f64> = self.at.into();
        let there = self.plan.setup().at_point(self.goal);
        self.plan.sampler.sample(0, self.away, &there, &mut start);
        self.restarts += 1;
        let (other, there) = self.nearest_from(start);
        let size = self.plan.request.chain().reach().size;
        let nearer = other.position_error + NEARER * size < end.position_error;
        let as_near = other.position_error <= end.position_error + NEARER * NEARER * size;
        let turned = other.orientation_error + LESS_TURNED < end.orientation_error;
        Some(if nearer || as_near && turned { there } else { q })
    }

    /// The end of a search for the nearest posture.
    fn nearest_from(&mut self, mut q: PerJoint<f64>) -> (End, PerJoint<f64>) {
        let limits = limits(self.plan);
        for (x, v) in q.iter_mut().zip(&limits) {
            *x = x.max(v.lower).min(v.upper);
        }
        let scale = self.plan.setup().rotation_scale;
        let search = Search { plan: self.plan, limits: &limits, goal: self.goal, scale };
        let end = search.place_first(&mut q);
        self.iterations += end.steps;
        (end, self.turned(q))
    }

    /// Attempts at the target from several starts; what each found, with the angles that are
    /// nearest to where the arm stands.
    fn attempts(
        &mut self,
        starts: &[f64],
        settings: Settings,
        bounds: Option<Vec<(f64, f64)>>,
    ) -> Vec<Option<PerJoint<f64>>> {
        let target = self.plan.request.copies(0, starts.len() / self.at.len());
        self.attempts_at(&target, starts, settings, bounds)
    }

    /// The same at other targets, one for each start.
    fn attempts_at(
        &mut self,
        target: &Copies,
        starts: &[f64],
        settings: Settings,
        bounds: Option<Vec<(f64, f64)>>,
    ) -> Vec<Option<PerJoint<f64>>> {
        let (chain, dof) = (self.plan.request.chain(), self.at.len());
        let count = starts.len() / dof;
        let mut plan = self.plan.with(target, starts, settings);
        plan.bounds = bounds;
        let mut answers = Answers::new(count, dof);
        let mut all = Some(answers.as_mut());
        plan.run(self.level, &mut || all.take(), &mut || true);
        self.iterations += answers.iterations.iter().sum::<u32>();
        let q = answers.q.chunks_exact(dof).enumerate();
        q.map(|(i, q)| {
            let solved = answers.success(i) && chain.within_limits(q);
            solved.then(|| self.turned(q.into()))
        })
        .collect()
    }

    /// The same posture with the angles that are nearest to where the arm stands.
    fn turned(&self, mut q: PerJoint<f64>) -> PerJoint<f64> {
        let variables = self.plan.request.chain().variables().iter();
        for ((x, v), at) in q.iter_mut().zip(variables).zip(self.at) {
            *x = wound(v, *x, *at);
        }
        q
    }
}

/// Refuses what bounds no change of joint values.
pub(super) fn check_steps(argument: &'static str, most: &[f64], dof: usize) -> Result<()> {
    if most.len() != dof {
        return Err(Error::argument(argument, format!("{dof} numbers"), most.len()));
    }
    match most.iter().find(|x| !(x.is_finite() && **x > 0.0)) {
        Some(bad) => Err(Error::argument(argument, "finite numbers above 0", bad)),
        None => Ok(()),
    }
}

/// The joints' ranges one step around a posture, within the limits as far as that is possible.
pub(super) fn bounds_around(chain: &Chain, at: &[f64], most: &[f64]) -> Vec<(f64, f64)> {
    let around = chain.variables().iter().zip(at).zip(most);
    around
        // A little less, so that rounding does not make a step too long.
        .map(|((v, x), step)| (v, x - step * INSIDE, x + step * INSIDE))
        .map(|(v, low, high)| (v.lower.max(low).min(high), v.upper.min(high).max(low)))
        .collect()
}

/// True where no joint changes by more than its step.
#[inline(always)]
pub(super) fn is_step(from: &[f64], to: &[f64], most: &[f64]) -> bool {
    from.iter().zip(to).zip(most).all(|((a, b), step)| (a - b).abs() <= *step)
}

/// Steps that the way from one posture to another takes.
pub(super) fn ticks(from: &[f64], to: &[f64], most: &[f64]) -> f64 {
    let shares = from.iter().zip(to).zip(most).map(|((a, b), step)| (a - b).abs() / step);
    shares.fold(0.0, f64::max)
}

/// The posture one step on the way to another: each joint goes as far as it may, so that those
/// with little to go are there when the slowest arrives.
fn step_towards(from: &[f64], to: &[f64], most: &[f64]) -> PerJoint<f64> {
    let joints = from.iter().zip(to).zip(most);
    joints.map(|((a, b), step)| a + (b - a).max(-step * INSIDE).min(step * INSIDE)).collect()
}
