//! The one loop of all step solvers: evaluate, test, step, hold the limits, start again.
//!
//! Each lane works on a target of its own; a lane whose target is solved or given up is
//! given the next one at once. With a one-lane number type this is an ordinary loop over
//! targets.

mod asked;
mod attempts;
mod feedback;
mod nearest;
mod runs;
mod second_curve;
mod second_step;
mod slack;

use smallvec::{SmallVec, smallvec};

use self::asked::Aside;
use self::attempts::Job;
use self::feedback::{Halt, Memory};
pub(super) use self::nearest::{End, Search};
use self::runs::Runs;
use self::second_step as second;
use self::slack::Relaxed;
use super::limit::{Limit, limits, nearest_turn};
use super::plan::Plan;
use super::setup::Setup;
use super::step::{Step, dot, pulled, squared_norm};
use crate::call::{AnswersMut, INSIDE, Measure, Second, Tolerance};
use crate::chain::{JointKind, Variable};
use crate::kinematics::{PerJoint, Workspace, columns, forward};
use crate::lanes::Real;
use crate::task::{Goal, PoseRows, Rows, TaskError};

/// An attempt whose error is below this share of the robot's size is closing in on a
/// solution, slowly where that is singular: it gets so many times the usual steps.
const NEAR: f64 = 1e-2;
const PATIENCE: u32 = 8;
/// What lanes do: steps of a task, those of a feedback law, or those of a second aim.
const STEP: u8 = 0;
const LAW: u8 = 1;
const SECOND: u8 = 2;
/// Movement, rad or m, below which a joint counts as still.
const STILL: f64 = 1e-14;
/// Loop passes between two questions whether to go on.
const PASSES_PER_POLL: u32 = 512;

/// Solves the rows of every run that `next` hands out, until it hands out none or
/// `keep_going` says no; false in the latter case.
#[inline(always)]
pub fn run<'a, R: Real>(
    plan: &Plan<'_>,
    next: &mut dyn FnMut() -> Option<AnswersMut<'a>>,
    keep_going: &mut dyn FnMut() -> bool,
) -> bool {
    // Two loops in one source: feedback laws would slow the others down.
    match (&plan.setup().feedback, plan.setup().measure()) {
        (None, _) => run_task::<R, STEP>(plan, next, keep_going),
        (Some(_), Measure::Position(rows)) => {
            Engine::<R, _, 3, LAW>::new(plan, rows).run(next, keep_going)
        }
        (Some(_), _) => run_slowly::<LAW>(plan, next, keep_going),
    }
}

/// Moves the answers of every run that `next` hands out to where the plan's second aim is best,
/// as far as they stay answers.
#[inline(always)]
pub fn run_second<'a, R: Real>(
    plan: &Plan<'_>,
    next: &mut dyn FnMut() -> Option<AnswersMut<'a>>,
    keep_going: &mut dyn FnMut() -> bool,
) -> bool {
    match plan.setup().measure() {
        Measure::Position(rows) => Engine::<R, _, 3, SECOND>::new(plan, rows).run(next, keep_going),
        Measure::Pose(rows) => {
            let rows = PoseRows { onward: plan.setup().onward(), ..rows };
            Engine::<R, _, 6, SECOND>::new(plan, rows).run(next, keep_going)
        }
        _ => run_slowly::<SECOND>(plan, next, keep_going),
    }
}

/// Feedback laws with orientations, and second aims of other tasks: too rare for lanes to be
/// worth their code.
#[inline(never)]
pub fn run_slowly<'a, const WAY: u8>(
    plan: &Plan<'_>,
    next: &mut dyn FnMut() -> Option<AnswersMut<'a>>,
    keep_going: &mut dyn FnMut() -> bool,
) -> bool {
    run_task::<f64, WAY>(plan, next, keep_going)
}

#[inline(always)]
fn run_task<'a, R: Real, const WAY: u8>(
    plan: &Plan<'_>,
    next: &mut dyn FnMut() -> Option<AnswersMut<'a>>,
    keep_going: &mut dyn FnMut() -> bool,
) -> bool {
    let setup = plan.setup();
    match setup.measure() {
        Measure::Position(rows) => Engine::<R, _, 3, WAY>::new(plan, rows).run(next, keep_going),
        Measure::Pose(rows) => {
            let rows = PoseRows { onward: setup.onward(), ..rows };
            Engine::<R, _, 6, WAY>::new(plan, rows).run(next, keep_going)
        }
        Measure::Axis(rows) => Engine::<R, _, 5, WAY>::new(plan, rows).run(next, keep_going),
        Measure::Framed(rows) => Engine::<R, _, 6, WAY>::new(plan, rows).run(next, keep_going),
    }
}

/// The squares of the tolerances, a little smaller.
#[derive(Clone, Copy)]
struct Enough<R> {
    position2: R,
    orientation2: R,
}

impl<R: Real> Enough<R> {
    #[inline(always)]
    fn of(tolerance: Tolerance) -> Self {
        let square = |most: f64| R::splat((most * INSIDE) * (most * INSIDE));
        Self { position2: square(tolerance.position), orientation2: square(tolerance.orientation) }
    }

    /// Lanes in which an error is within the tolerances.
    #[inline(always)]
    fn holds<T: Rows<R, M>, const M: usize>(&self, error: &TaskError<R, M>) -> u32 {
        let place = error.position2.le(self.position2);
        let near = R::and(place, error.orientation2.le(self.orientation2));
        R::bits(if T::BOUNDED { R::and(near, error.outside.le(R::splat(INSIDE))) } else { near })
    }
}

struct Engine<'p, R: Real, T, const M: usize, const WAY: u8> {
    plan: &'p Plan<'p>,
    setup: &'p Setup,
    rows: T,
    variables: &'p [Variable],
    limits: PerJoint<Limit>,
    has_continuous: bool,
    /// Some joints have several angles for a posture.
    winds: bool,
    /// Ways of slides are measured by the robot's size.
    stretches: bool,
    relaxed: Relaxed<R>,
    /// Rows that attempts do not solve are given their nearest posture.
    completes: bool,
    most_restarts: u32,
    /// Steps of an attempt, and of one whose squared error is below `near2`.
    cap: u32,
    patient_cap: u32,
    near2: f64,
    /// One entry per lane, and behind them those of targets aside.
    jobs: SmallVec<[Job; 1]>,
    /// Which of these do what, in a call with a guard.
    aside: Option<Box<Aside>>,
    q: PerJoint<R>,
    /// Where continuous joints' values are kept near.
    reference: PerJoint<R>,
    change: PerJoint<R>,
    /// The second aim's share of a step.
    pull: PerJoint<R>,
    columns: PerJoint<[R; M]>,
    workspace: Workspace<R>,
    goal: Goal<R>,
    memory: Memory<R, M>,
    second: second::Memory<R, M>,
    second_aim: Option<&'p Second>,
    /// The postures that reach a target form curves, along which a second aim looks for the best.
    spares_one: bool,
    /// The joint values of a start on their way to a lane.
    begin: PerJoint<f64>,
}

impl<'p, R: Real, T: Rows<R, M>, const M: usize, const WAY: u8> Engine<'p, R, T, M, WAY> {
    #[inline(always)]
    fn new(plan: &'p Plan<'p>, rows: T) -> Self {
        let setup = plan.setup();
        let settings = &setup.settings;
        let variables = plan.request.chain().variables();
        let dof = variables.len();
        let limits = limits(plan);
        let first = setup.aim.puts_position_first();
        let spares_one = WAY == SECOND && plan.spares_one(M);
        let steps = match WAY {
            SECOND if spares_one => second::CURVE_STEPS,
            SECOND => second::STEPS,
            _ => settings.max_iterations,
        };
        let asks = WAY != SECOND && plan.request.guard().is_some();
        let aside = asks.then(|| Box::new(Aside::new(R::WIDTH, plan.request.len())));
        let places = R::WIDTH + aside.as_ref().map_or(0, |aside| aside.places());
        Self {
            plan,
            setup,
            rows,
            variables,
            winds: limits.iter().any(|v| v.winds),
            limits,
            stretches: setup.lengths.slides
                && !settings.plain
                && !matches!(settings.step, Step::FixedTranspose { .. }),
            relaxed: Relaxed::none(),
            // Other steps are compared as they are, and a cap on attempts is one on searches.
            completes: if first {
                !settings.plain && !settings.step.is_feedback()
            } else {
                matches!(settings.step, Step::LevenbergMarquardt { .. })
                    && !settings.plain
                    && settings.max_restarts >= attempts::MOST_STARTS
                    && (plan.bounds.is_none() || plan.limited)
                    && plan.pull.is_none()
            },
            most_restarts: if first {
                settings.max_restarts.min(attempts::POSES)
            } else {
                settings.max_restarts
            },
            has_continuous: variables.iter().any(|v| v.kind == JointKind::Continuous),
            cap: steps,
            patient_cap: steps.saturating_mul(if settings.plain || WAY == SECOND {
                1
            } else {
                PATIENCE
            }),
            near2: (NEAR * setup.rotation_scale).powi(2),
            jobs: smallvec![Job::idle(dof); places],
            aside,
            q: smallvec![R::zero(); dof],
            reference: smallvec![R::zero(); dof],
            change: smallvec![R::zero(); dof],
            pull: smallvec![R::zero(); dof],
            columns: smallvec![[R::zero(); M]; dof],
            workspace: Workspace::new(plan.request.chain().compiled()),
            goal: Goal::zero(),
            memory: Memory::new(setup.feedback.as_ref(), dof),
            second: second::Memory::new(if WAY == SECOND { dof } else { 0 }),
            second_aim: if WAY == SECOND { plan.second_aim() } else { None },
            spares_one,
            begin: smallvec![0.0; dof],
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<'a>(
        &mut self,
        next: &mut dyn FnMut() -> Option<AnswersMut<'a>>,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> bool {
        let enough = Enough::<R>::of(self.setup.aim.tolerance());
        let all = ((1u64 << R::WIDTH) - 1) as u32;

        let mut runs = Runs::new();
        let mut busy = 0u32;
        for lane in 0..R::WIDTH {
            busy |= u32::from(self.refill(lane, &mut runs, next)) << lane;
        }
        let mut halt = Halt::default();
        let mut passes = 0u32;
        while busy != 0 {
            passes += 1;
            if passes == PASSES_PER_POLL {
                passes = 0;
                if !keep_going() {
                    return false;
                }
            }
            let error = self.evaluate();
            let reached = enough.holds::<T, M>(&error) & busy;
            let near = R::bits(squared_norm(&error.rows).lt(R::splat(self.near2)));
            let mut ended = if WAY == SECOND {
                reached & self.second.settled
            } else {
                (reached | halt.stalled | halt.broken) & busy
            };
            for (lane, job) in self.jobs.iter().take(R::WIDTH).enumerate() {
                let closing_in = near >> lane & 1 != 0;
                let cap = if closing_in { self.patient_cap } else { self.cap };
                ended |= u32::from(job.steps >= cap) << lane & busy;
            }
            if ended != 0 {
                let mut left = ended;
                while left != 0 {
                    let lane = left.trailing_zeros() as usize;
                    left &= left - 1;
                    let solved = reached >> lane & 1 != 0;
                    if solved && self.winds && self.wind(lane) {
                        continue;
                    }
                    if WAY == SECOND {
                        self.end_second(lane, solved, &error, &mut runs);
                    }
                    let mut goes_on = false;
                    if WAY != SECOND && solved && self.aside.is_some() {
                        if self.step_aside(lane, &error) {
                            self.ask(&mut runs);
                        }
                    } else if WAY != SECOND {
                        let status = self.status(lane, solved, halt);
                        goes_on = self.end_attempt(lane, status, &error, &mut runs);
                    }
                    if goes_on || WAY != SECOND && self.take_back(lane) {
                        self.start_next(lane);
                    } else if !self.refill(lane, &mut runs, next) {
                        busy &= !(1 << lane);
                    }
                }
                if WAY != SECOND && busy != all && self.some_wait() {
                    // No other targets are left to go on with meanwhile.
                    self.ask(&mut runs);
                    let started = self.take_back_all(busy);
                    busy |= started;
                    ended |= started;
                }
                // Lanes that start anew are evaluated on the next pass.
                if ended | !busy & all == all {
                    halt = Halt::default();
                    continue;
                }
            }
            halt = match WAY {
                LAW => self.feedback_step(&error, busy & !ended),
                SECOND => {
                    self.second_step(&error, busy & !ended);
                    Halt::default()
                }
                _ => Halt { stalled: self.step(&error, busy & !ended), broken: 0 },
            };
        }
        true
    }

    #[inline(always)]
    fn evaluate(&mut self) -> TaskError<R, M> {
        let compiled = self.plan.request.chain().compiled();
        forward(compiled, &self.q, &mut self.workspace);
        let tool = self.workspace.tool_point(self.setup.point);
        let mut error = self.rows.error(&self.workspace, tool, &self.goal);
        if let Some(slack) = self.setup.slack {
            self.relaxed = Relaxed::of(&mut error.rows, slack);
        }
        error
    }

    /// Fills in the columns of the Jacobian in the task's rows; returns the squared error, and the
    /// way of slides that stands beside a radian.
    #[inline(always)]
    fn fill_columns(&mut self, error: &TaskError<R, M>) -> (R, R) {
        let compiled = self.plan.request.chain().compiled();
        let tool = self.workspace.tool_point(self.setup.point);
        if !compiled.simple {
            self.columns.fill([R::zero(); M]);
        }
        let (rows, workspace, goal) = (&self.rows, &self.workspace, &self.goal);
        let seen = rows.look(workspace, tool, goal);
        let store = &mut self.columns;
        columns(compiled, workspace, tool, |variable, linear, angular| {
            let column = rows.column(&seen, goal, linear, angular);
            if compiled.simple {
                store[variable] = column;
            } else {
                for (sum, x) in store[variable].iter_mut().zip(column) {
                    *sum += x;
                }
            }
        });
        if self.setup.slack.is_some() {
            self.relaxed.change(&mut self.columns);
        }
        let squared = squared_norm(&error.rows);
        let mut per_radian = R::splat(1.0);
        if self.stretches {
            per_radian = self.setup.lengths.per_radian(squared);
            for (v, column) in self.limits.iter().zip(&mut self.columns) {
                if v.slides {
                    for x in column {
                        *x *= per_radian;
                    }
                }
            }
        }
        (squared, per_radian)
    }

    /// One step of the lanes in `moving`; returns those that did not move.
    #[inline(always)]
    fn step(&mut self, error: &TaskError<R, M>, moving: u32) -> u32 {
        let (squared, per_radian) = self.fill_columns(error);
        if let Some((gain, toward)) = &self.plan.pull {
            for ((p, q), to) in self.pull.iter_mut().zip(&self.q).zip(toward) {
                *p = R::splat(*gain) * (R::splat(*to) - *q);
            }
            if self.stretches {
                for (v, p) in self.limits.iter().zip(&mut self.pull) {
                    if v.slides {
                        *p = *p / per_radian;
                    }
                }
            }
        }
        if !self.setup.settings.plain {
            self.hold(error);
        }
        if self.plan.pull.is_some() {
            let lengths = &self.setup.lengths;
            pulled::step(&self.columns, &error.rows, &self.pull, lengths, &mut self.change);
        } else {
            let (settings, lengths) = (&self.setup.settings, &self.setup.lengths);
            settings.change(&self.columns, &error.rows, lengths, &mut self.change);
        }
        self.apply(moving, squared, per_radian)
    }

    /// Active set: a joint at a limit whose downhill direction leads outward is held for
    /// this step, and the others take over its share.
    #[inline(always)]
    fn hold(&mut self, error: &TaskError<R, M>) {
        let mut at_limit = R::mask_from_bits(0);
        for (v, q) in self.limits.iter().zip(&self.q) {
            if !v.turns {
                let (lower, upper) = (R::splat(v.lower), R::splat(v.upper));
                at_limit = R::or(at_limit, R::or(q.le(lower), upper.le(*q)));
            }
        }
        // Mostly no joint of any lane is.
        if R::bits(at_limit) == 0 {
            return;
        }
        let joints = self.limits.iter().zip(&self.q).zip(&mut self.columns).zip(&mut self.pull);
        for (((v, q), column), pull) in joints {
            if v.turns {
                continue;
            }
            let downhill = dot(column, &error.rows);
            let low = R::and(q.le(R::splat(v.lower)), downhill.lt(R::zero()));
            let high = R::and(R::splat(v.upper).le(*q), R::zero().lt(downhill));
            let held = R::or(low, high);
            for x in column.iter_mut() {
                *x = R::select(held, R::zero(), *x);
            }
            *pull = R::select(held, R::zero(), *pull);
        }
    }

    /// Adds the change, no longer than the longest step, projected on the limits; returns the
    /// lanes that did not move. A way of slides that stands beside a radian is `per_radian`.
    #[inline(always)]
    fn apply(&mut self, moving: u32, squared: R, per_radian: R) -> u32 {
        let mask = R::mask_from_bits(moving);
        let turned = R::splat(self.setup.rotation_scale);
        let plain = self.setup.settings.plain;
        // Most arms have no slides.
        let way = if self.setup.lengths.slides {
            let (moved, slid) = self.advance::<true>(mask, per_radian);
            if plain { moved.max(slid) } else { (moved * turned).max(slid) }
        } else {
            let (moved, _) = self.advance::<false>(mask, per_radian);
            if plain { moved } else { moved * turned }
        };
        if self.has_continuous {
            self.wind_back(mask);
        }
        for (lane, job) in self.jobs.iter_mut().take(R::WIDTH).enumerate() {
            job.steps += moving >> lane & 1;
        }
        // Written so that a step that is not a number counts as none.
        if plain {
            return moving & !R::bits(R::splat(STILL).lt(way));
        }
        let least = R::splat(self.setup.settings.step.stall().powi(2));
        moving & !R::bits((squared * least).lt(way * way))
    }

    /// Moves the joints of the lanes in `mask`; returns the longest turn and way.
    #[inline(always)]
    fn advance<const SLIDES: bool>(&mut self, mask: R::Mask, per_radian: R) -> (R, R) {
        let mut longest = R::splat(1e-300);
        for dq in &self.change {
            longest = longest.max(dq.abs());
        }
        let scale = (R::splat(self.setup.settings.max_step) / longest).min(R::splat(1.0));
        let (mut moved, mut slid) = (R::zero(), R::zero());
        for ((v, q), dq) in self.limits.iter().zip(&mut self.q).zip(&self.change) {
            let scale = if SLIDES && v.slides { scale * per_radian } else { scale };
            let mut to = dq.mul_add(scale, *q);
            let (low, high) = (R::splat(v.ends.0), R::splat(v.ends.1));
            if v.turns {
                // Past one end of a full turn lies the same posture at the other end.
                let turn = R::splat(std::f64::consts::TAU);
                to = R::select(to.lt(low), to + turn, to);
                to = R::select(high.lt(to), to - turn, to);
            }
            // A lane at a new start stays there whatever came of the attempt before, even where
            // that is no number.
            to = R::select(mask, to.max(low).min(high), *q);
            if SLIDES && v.slides {
                slid = slid.max((to - *q).abs());
            } else {
                moved = moved.max((to - *q).abs());
            }
            *q = to;
        }
        (moved, slid)
    }

    /// Takes whole turns off continuous joints of the lanes that moved, to within half a turn
    /// of their reference. Lanes at a new start are left alone: without company they would not
    /// have come here.
    #[inline(always)]
    fn wind_back(&mut self, moved: R::Mask) {
        for ((v, q), reference) in self.variables.iter().zip(&mut self.q).zip(&self.reference) {
            if v.kind == JointKind::Continuous {
                *q = R::select(moved, nearest_turn(*q, *reference), *q);
            }
        }
    }

    /// Takes the whole turns between a lane's angles and those nearest to its reference, where
    /// limits allow it; true where there were some, so that the lane is evaluated again.
    #[inline(never)]
    fn wind(&mut self, lane: usize) -> bool {
        let mut wound = false;
        for ((v, q), reference) in self.limits.iter().zip(&mut self.q).zip(&self.reference) {
            if v.winds {
                let x = q.lane(lane);
                let to = v.wound(x, reference.lane(lane));
                q.set_lane(lane, to);
                wound |= to != x;
            }
        }
        wound
    }
}
