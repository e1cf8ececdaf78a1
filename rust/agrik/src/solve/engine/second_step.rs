//! Steps that keep a target reached and better a second measure, until that is as good as the
//! freedom around allows.
//!
//! The slope of the measure is projected on the null space of the task's Jacobian; how far a
//! step goes along it follows from the change of that projection over the step before (Barzilai
//! and Borwein 1988), which is the secant method where one joint is to spare. Joints at a limit
//! that the way would push outward stand still.

use smallvec::smallvec;

use super::Engine;
use super::runs::Runs;
use crate::call::{Merit, Outcome, Status};
use crate::kinematics::{PerJoint, columns};
use crate::lanes::{Real, V3, axpy, cross, dot, scale};
use crate::solve::linear::Factored;
use crate::solve::step::pulled;
use crate::task::{Rows, TaskError};

/// Most steps of a target, and of one along a curve.
pub(super) const STEPS: u32 = 40;
pub(super) const CURVE_STEPS: u32 = 28;
/// Longest change of a joint along the measure in one step, and the one of a first step whose
/// length nothing tells, rad or sizes of the robot.
const LONGEST: f64 = 0.3;
const FIRST: f64 = 0.1;
/// The longest towards manipulability, whose slope turns within tenths of a radian.
const CAREFUL: f64 = 0.2;
/// Steps at the end that are left to the target alone; before them steps along the measure get
/// shorter and shorter, so that none that go to and fro spoil the end.
const LAST: u32 = 8;
const SHORTER: u32 = 12;
/// A step along the measure below this is the last. Where the measure hardly bends along the way
/// much may be left after a short one, which counts where answers are to be the nearest; the
/// limits' measure is steep near them. Steps that a limit shortens are no end before `STUCK`.
const SETTLED: f64 = 3e-4;
const SETTLED_NEAR: f64 = 2e-5;
const SETTLED_STEEP: f64 = 3e-6;
const STUCK: f64 = 2e-5;
/// A joint this near to a limit stands at it, rad or m, and one that the way back to the target
/// would push outward by this is held as well.
const AT: f64 = 1e-6;
const PUSHED: f64 = 1e-4;
/// Times that joints are held in one step.
const HOLDS: usize = 3;
/// Part of the trace that keeps `J J^T` from being singular.
const FLOOR: f64 = 1e-9;

/// What is remembered from step to step, lane by lane.
#[derive(Debug, Clone)]
pub(super) struct Memory<R, const M: usize> {
    /// The projected way down the measure, and the one of the step before with its posture; of a
    /// curve its direction.
    pub along: PerJoint<R>,
    before: PerJoint<R>,
    before_q: PerJoint<R>,
    pub about: PerJoint<R>,
    /// Of a curve: how it bends, the way back to it, one over what a joint moves along it, and
    /// the columns of the Jacobian as `J J^T` sees them.
    pub bend: PerJoint<R>,
    pub back: PerJoint<R>,
    pub inverse: PerJoint<R>,
    pub worths: PerJoint<[R; M]>,
    columns: PerJoint<(usize, V3<R>, V3<R>)>,
    /// What manipulability was before the first step, and before the last.
    pub value: (R, R),
    /// Steps so far, the length of the last, and how fast the measure fell where it began.
    pub stepped: R,
    pub length: R,
    pub fall: R,
    /// Which joints are held, and were in the step before: a bit each, as a number.
    held: R,
    held_before: R,
    /// Lanes at which there is nothing more to do.
    pub settled: u32,
}

impl<R: Real, const M: usize> Memory<R, M> {
    pub fn new(dof: usize) -> Self {
        let zeros = || smallvec![R::zero(); dof];
        Self {
            along: zeros(),
            before: zeros(),
            before_q: zeros(),
            about: zeros(),
            bend: zeros(),
            back: zeros(),
            inverse: zeros(),
            worths: smallvec![[R::zero(); M]; dof],
            columns: PerJoint::new(),
            value: (R::zero(), R::zero()),
            stepped: R::zero(),
            length: R::zero(),
            fall: R::zero(),
            held: R::zero(),
            held_before: R::zero(),
            settled: 0,
        }
    }
}

impl<R: Real, T: Rows<R, M>, const M: usize, const WAY: u8> Engine<'_, R, T, M, WAY> {
    /// Puts a lane to the beginning: what its measure is about, and no step so far.
    pub(super) fn begin_second(&mut self, lane: usize, row: usize) {
        let Some(second) = self.second_aim else { return };
        self.second.stepped.set_lane(lane, 0.0);
        self.second.settled &= !(1 << lane);
        let start = self.plan.start(row);
        for (i, about) in self.second.about.iter_mut().enumerate() {
            let at = match (&second.posture, start) {
                (Some(posture), _) => posture[i],
                (None, Some(start)) => start[i],
                (None, None) => self.limits[i].middle,
            };
            about.set_lane(lane, at);
        }
    }

    /// One step of the lanes in `moving`.
    #[inline(always)]
    pub(super) fn second_step(&mut self, error: &TaskError<R, M>, moving: u32) {
        let Some(second) = self.second_aim else { return };
        // In one place, or it would not be inlined.
        let (squared, per_radian) = self.fill_columns(error);
        if self.spares_one {
            return self.curve_step(second, error, moving, (squared, per_radian));
        }
        for (i, pull) in self.pull.iter_mut().enumerate() {
            *pull = -second.bends(i, self.q[i], self.second.about[i]).slope;
        }
        if second.measure == Merit::Manipulability {
            let value = self.pull_to_dexterity();
            let begins = self.second.stepped.lt(R::splat(0.5));
            self.second.value = (R::select(begins, value, self.second.value.0), value);
        }
        if self.stretches {
            for (v, pull) in self.limits.iter().zip(&mut self.pull) {
                if v.slides {
                    *pull *= per_radian;
                }
            }
        }
        let lengths = &self.setup.lengths;
        self.second.held = R::zero();
        for _ in 0..HOLDS {
            let ways = (&mut self.second.along[..], &mut self.change[..]);
            pulled::apart(&self.columns, &error.rows, &self.pull, lengths, ways);
            if !self.hold_outward() {
                break;
            }
        }
        // How far: by what the step before changed.
        let (mut moved, mut turned, mut longest) = (R::zero(), R::zero(), R::splat(1e-300));
        let (mut steep, mut bend) = (R::zero(), R::zero());
        let memory = &mut self.second;
        let ways = memory.along.iter().zip(&mut memory.before);
        let joints = self.limits.iter().zip(ways).zip(self.q.iter().zip(&mut memory.before_q));
        for (i, ((v, (way, before)), (q, q_before))) in joints.enumerate() {
            steep = way.mul_add(*way, steep);
            let turn = if self.stretches && v.slides { *way * per_radian } else { *way };
            bend = (turn * turn).mul_add(second.bends(i, *q, *q).curvature, bend);
            let change = *q - *q_before;
            let change = if self.stretches && v.slides { change / per_radian } else { change };
            moved = change.mul_add(change, moved);
            turned = change.mul_add(*before - *way, turned);
            longest = longest.max(way.abs());
            (*before, *q_before) = (*way, *q);
        }
        // Ways with other joints held do not tell how the slope changes.
        let same = memory.held.le(memory.held_before);
        let same = R::and(same, memory.held_before.le(memory.held));
        memory.held_before = memory.held;
        let before = R::splat(0.5).lt(memory.stepped);
        let comparable = R::and(before, same);
        let known = R::and(comparable, R::zero().lt(turned));
        let secant = moved / R::select(known, turned, R::splat(1.0));
        let usual = match second.measure {
            Merit::Manipulability => R::select(before, memory.length, R::splat(FIRST) / longest),
            // By how the measure itself bends along the way.
            _ => steep / bend.max(R::splat(1e-300)),
        };
        let most = if second.measure == Merit::Manipulability { CAREFUL } else { LONGEST };
        let last = f64::from(STEPS - LAST);
        let left = (R::splat(last) - memory.stepped) * R::splat(1.0 / (last - f64::from(SHORTER)));
        let far = left.max(R::zero()).min(R::splat(1.0)) * R::splat(most) / longest;
        let downward = R::and(comparable, turned.le(R::zero()));
        let usual = R::select(downward, far, usual);
        let length = R::select(known, secant, usual).min(far);
        memory.length = length;
        // No farther than to the first limit in the way: the arm stays at its target.
        let mut least = length;
        for (v, (q, way)) in self.limits.iter().zip(self.q.iter().zip(&memory.along)) {
            if !v.turns {
                let slides = self.stretches && v.slides;
                let way = if slides { *way * per_radian } else { *way };
                let up = R::zero().lt(way);
                let end = R::select(up, R::splat(v.upper), R::splat(v.lower));
                let moves = R::zero().lt(way.abs());
                let room = ((end - *q) / R::select(moves, way, R::splat(1.0))).max(R::zero());
                least = R::select(moves, least.min(room), least);
            }
        }
        let length = least;
        let settled = match second.measure {
            Merit::Limits => SETTLED_STEEP,
            Merit::Near => SETTLED_NEAR,
            _ => SETTLED,
        };
        let still = R::or(
            (memory.length * longest).lt(R::splat(settled)),
            (length * longest).lt(R::splat(settled.min(STUCK))),
        );
        let still = R::bits(still);
        let counted = memory.stepped + R::splat(1.0);
        memory.stepped = R::select(R::mask_from_bits(moving), counted, memory.stepped);
        for (change, way) in self.change.iter_mut().zip(&memory.along) {
            *change = length.mul_add(*way, *change);
        }
        memory.settled = memory.settled & !moving | still & moving;
        self.apply(moving, squared, per_radian);
    }

    /// Holds the joints at a limit that the way along the measure would push outward, or the way
    /// back to the target by much; true where there were some.
    #[inline(always)]
    fn hold_outward(&mut self) -> bool {
        let mut any = R::mask_from_bits(0);
        let memory = &mut self.second;
        let ways = memory.along.iter().zip(&self.change);
        let joints = self.limits.iter().zip(&self.q).zip(ways).enumerate();
        for ((i, ((v, q), (way, back))), (column, pull)) in
            joints.zip(self.columns.iter_mut().zip(&mut self.pull))
        {
            if v.turns {
                continue;
            }
            let (none, pushed) = (R::zero(), R::splat(PUSHED));
            let down = R::or(way.lt(none), back.lt(none - pushed));
            let up = R::or(none.lt(*way), pushed.lt(*back));
            let low = R::and(q.le(R::splat(v.lower + AT)), down);
            let high = R::and(R::splat(v.upper - AT).le(*q), up);
            let held = R::or(low, high);
            if R::bits(held) == 0 {
                continue;
            }
            any = R::or(any, held);
            memory.held += R::select(held, R::splat((i as f64).exp2()), none);
            for x in column.iter_mut() {
                *x = R::select(held, R::zero(), *x);
            }
            *pull = R::select(held, R::zero(), *pull);
        }
        R::bits(any) != 0
    }

    /// The slope of the logarithm of the manipulability as the pull: how the columns of the
    /// Jacobian change with each joint, seen by the inverse of `J J^T`; returns its determinant, of
    /// the tool's place, and of its turns too where a full pose is asked of six joints or more.
    #[inline(always)]
    fn pull_to_dexterity(&mut self) -> R {
        let compiled = self.plan.request.chain().compiled();
        let point = self.workspace.tool_point(self.setup.aim.tail().translation);
        let (found, workspace) = (&mut self.second.columns, &self.workspace);
        found.clear();
        columns(compiled, workspace, point, |variable, linear, angular| {
            found.push((variable, linear, angular));
        });
        let size = R::splat(self.setup.rotation_scale);
        let whole = self.setup.aim.fixes_pose() && compiled.dof >= 6;
        let row = |(_, linear, angular): &(usize, V3<R>, V3<R>)| {
            let turn = if whole { scale(*angular, size) } else { [R::zero(); 3] };
            [linear[0], linear[1], linear[2], turn[0], turn[1], turn[2]]
        };
        // Of the sums of the links that follow one joint.
        let mut sums: PerJoint<[R; 6]> = smallvec![[R::zero(); 6]; self.q.len()];
        for one in &self.second.columns {
            for (sum, x) in sums[one.0].iter_mut().zip(row(one)) {
                *sum += x;
            }
        }
        let mut square = [[R::zero(); 6]; 6];
        for c in &sums {
            for i in 0..6 {
                for k in 0..=i {
                    square[i][k] = c[i].mul_add(c[k], square[i][k]);
                }
            }
        }
        let mut trace = R::splat(1e-300);
        for (i, line) in square.iter().enumerate() {
            trace += line[i];
        }
        for (i, line) in square.iter_mut().enumerate() {
            line[i] += if whole || i < 3 { trace * R::splat(FLOOR) } else { R::splat(1.0) };
        }
        let factored = Factored::new(square);
        let links = &self.second.columns;
        // What a change of each column is worth, by the way of the tool point and by its turn; a
        // joint turns the columns of those after it, and its own is turned by those before it.
        let (mut after, mut before) = ([R::zero(); 3], [R::zero(); 3]);
        for pull in &mut self.pull {
            *pull = R::zero();
        }
        let mut worths: PerJoint<(V3<R>, V3<R>)> = smallvec![(after, after); links.len()];
        for (worth, link) in worths.iter_mut().zip(links) {
            let w = factored.solve(sums[link.0]);
            *worth = ([w[0], w[1], w[2]], [w[3] * size, w[4] * size, w[5] * size]);
        }
        let one = R::splat(1.0);
        for ((variable, linear, angular), (by_place, _)) in links.iter().zip(&worths) {
            self.pull[*variable] += dot(*linear, before);
            before = axpy(cross(*by_place, *angular), one, before);
        }
        for ((variable, linear, angular), (by_place, by_turn)) in links.iter().zip(&worths).rev() {
            after = axpy(cross(*linear, *by_place), one, after);
            if whole {
                after = axpy(cross(*angular, *by_turn), one, after);
            }
            self.pull[*variable] += dot(*angular, after);
        }
        let mut determinant = factored.pivots[0];
        for pivot in &factored.pivots[1..] {
            determinant *= *pivot;
        }
        determinant
    }

    /// Ends a lane: the better posture becomes its row's answer, or the row stays as it was.
    pub(super) fn end_second(
        &mut self,
        lane: usize,
        reached: bool,
        error: &TaskError<R, M>,
        runs: &mut Runs<'_>,
    ) {
        let Some(place) = self.jobs[lane].place.take() else { return };
        let Some(second) = self.second_aim else { return runs.keep(place) };
        let q: PerJoint<f64> = self.q.iter().map(|x| x.lane(lane)).collect();
        let about = |i: usize| self.second.about[i].lane(lane);
        let value = |q: &[f64]| -> f64 {
            q.iter().enumerate().map(|(i, x)| second.bends(i, *x, about(i)).value).sum()
        };
        let before = runs.q(place);
        let better = match second.measure {
            // The last step of all is so short that it is of no account.
            Merit::Manipulability => {
                let (first, last) = self.second.value;
                first.lane(lane) < last.lane(lane)
            }
            _ => value(&q) < value(before),
        };
        let free = |q: &[f64]| {
            let guard = self.plan.request.guard();
            guard.is_none_or(|guard| guard.accept.accepts(q) & 1 != 0)
        };
        if !reached || !better || !free(&q) {
            return runs.keep(place);
        }
        let before = runs.outcome(place);
        let outcome = Outcome {
            status: Status::Converged,
            position_error: error.position2.lane(lane).sqrt(),
            orientation_error: error.orientation2.lane(lane).sqrt(),
            iterations: before.iterations + self.jobs[lane].steps,
            restarts: before.restarts,
        };
        runs.finish(place, outcome, q.into_iter());
    }
}
