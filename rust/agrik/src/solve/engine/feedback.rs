//! Steps that need no Jacobian: feedback laws of the error, some with a memory.
//!
//! Without optimisation everything inlined would share one huge stack frame, so a debug
//! build keeps the laws apart.

use smallvec::{SmallVec, smallvec};

use super::{Engine, Enough, STILL};
use crate::chain::JointKind;
use crate::kinematics::{PerJoint, forward};
use crate::lanes::{Real, atan2, axpy, cross, dot, scale, sub};
use crate::solve::step::{Feedback, Pid, PidOrder, Sparse, squared_norm};
use crate::task::{Rows, TaskError};

/// Relative change below which a state counts as settled.
const SETTLED: f64 = 1e-12;
/// Share of the reach by which the error must shrink for a try of IK-PID to count: less is
/// the rounding of a joint that does not move the tool.
const ROUNDING: f64 = 1e-14;
/// Angle beyond which whole turns are not taken off with digits to spare, rad.
const RUNAWAY: f64 = 1e9;
/// Entries of a matrix that are held without an allocation: of six rows and up to ten joints.
const GAINS: usize = 64;

/// Lanes whose attempt ends because nothing more will come of it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Halt {
    /// Further steps would change nothing.
    pub stalled: u32,
    /// Numbers grew beyond what a number can hold.
    pub broken: u32,
}

/// What a feedback law remembers from step to step of an attempt, lane by lane.
#[derive(Debug, Clone)]
pub(super) struct Memory<R, const M: usize> {
    /// State of a state space.
    state: PerJoint<R>,
    next_state: PerJoint<R>,
    /// Broyden's matrix, row by row, with the step and error before.
    gain: SmallVec<[R; GAINS]>,
    change: PerJoint<R>,
    rows: [R; M],
    /// 1 where a step was taken in this attempt, else 0.
    stepped: R,
    best: R,
    misses: R,
    /// Sum of the errors of IK-PID.
    sum: R,
    /// The error one joint earlier; negative at the start of an attempt.
    previous: R,
}

impl<R: Real, const M: usize> Memory<R, M> {
    #[inline(always)]
    pub fn new(law: Option<&Feedback>, dof: usize) -> Self {
        let (states, gains) = match law {
            Some(Feedback::StateSpace { a, .. }) => (a.rows.len(), 0),
            Some(Feedback::Broyden { gain, .. }) => (0, gain.len()),
            _ => (0, 0),
        };
        let zero = R::zero();
        Self {
            state: smallvec![zero; states],
            next_state: smallvec![zero; states],
            gain: smallvec![zero; gains],
            change: smallvec![zero; if gains > 0 { dof } else { 0 }],
            rows: [zero; M],
            stepped: zero,
            best: zero,
            misses: zero,
            sum: zero,
            previous: zero,
        }
    }

    /// Forgets everything about a lane.
    #[inline(always)]
    pub fn reset(&mut self, law: Option<&Feedback>, lane: usize) {
        match law {
            Some(Feedback::StateSpace { .. }) => {
                for x in &mut self.state {
                    x.set_lane(lane, 0.0);
                }
            }
            Some(Feedback::Broyden { gain, .. }) => {
                for (to, from) in self.gain.iter_mut().zip(gain) {
                    to.set_lane(lane, *from);
                }
                self.stepped.set_lane(lane, 0.0);
                self.best.set_lane(lane, f64::INFINITY);
                self.misses.set_lane(lane, 0.0);
            }
            Some(Feedback::Pid(_)) => {
                self.sum.set_lane(lane, 0.0);
                self.previous.set_lane(lane, -1.0);
            }
            _ => {}
        }
    }
}

/// Row of a matrix times a vector.
#[inline(always)]
fn times<R: Real>(row: &[(usize, f64)], v: &[R]) -> R {
    let mut sum = R::zero();
    for (k, value) in row {
        sum = v[*k].mul_add(R::splat(*value), sum);
    }
    sum
}

impl<R: Real, T: Rows<R, M>, const M: usize, const WAY: u8> Engine<'_, R, T, M, WAY> {
    /// One step of the lanes in `moving`; returns those that will not get further.
    #[inline(always)]
    pub(super) fn feedback_step(&mut self, error: &TaskError<R, M>, moving: u32) -> Halt {
        let mask = R::mask_from_bits(moving);
        let halt = match &self.setup.feedback {
            Some(Feedback::StateSpace { a, b, c }) => self.state_space(a, b, c, error, mask),
            Some(Feedback::Static { gain }) => self.static_gain(gain, error, mask),
            Some(Feedback::Broyden { gain, patience }) => {
                self.broyden(gain, *patience, error, mask)
            }
            Some(Feedback::Pid(pid)) => self.pid(pid, error, mask),
            Some(Feedback::Descent) if !T::ORIENTS => self.descent(mask),
            Some(Feedback::Descent) | None => Halt::default(),
        };
        if self.has_continuous {
            self.forget_runaways(mask);
            self.wind_back(mask);
        }
        for (lane, job) in self.jobs.iter_mut().take(R::WIDTH).enumerate() {
            job.steps += moving >> lane & 1;
        }
        Halt { stalled: halt.stalled & moving, broken: halt.broken & moving }
    }

    /// Puts free joints back to their reference that a law's step, which has no bound, has turned
    /// so far that what is left of a turn is rounding.
    #[inline(always)]
    fn forget_runaways(&mut self, moved: R::Mask) {
        for ((v, q), reference) in self.variables.iter().zip(&mut self.q).zip(&self.reference) {
            if v.kind == JointKind::Continuous {
                let runs_away = R::and(moved, R::splat(RUNAWAY).lt(q.abs()));
                *q = R::select(runs_away, *reference, *q);
            }
        }
    }

    /// Moves a joint by as much of `dq` as its limits leave; returns how much that is.
    #[inline(always)]
    fn saturate(&mut self, joint: usize, dq: R, mask: R::Mask) -> R {
        let (q, limit) = (self.q[joint], self.limits[joint]);
        let to = (q + dq).max(R::splat(limit.lower)).min(R::splat(limit.upper));
        let to = R::select(mask, to, q);
        self.q[joint] = to;
        to - q
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn state_space(
        &mut self,
        a: &Sparse,
        b: &Sparse,
        c: &Sparse,
        error: &TaskError<R, M>,
        mask: R::Mask,
    ) -> Halt {
        let mut moved = R::zero();
        for (joint, row) in c.rows.iter().enumerate() {
            // Equation (14) read strictly: the output is that of the state before.
            let dq = times(row, &self.memory.state);
            moved = moved.max(self.saturate(joint, dq, mask).abs());
        }
        let memory = &mut self.memory;
        let (mut largest, mut change, mut sum) = (R::zero(), R::zero(), R::zero());
        for (k, (to, row)) in memory.next_state.iter_mut().zip(&a.rows).enumerate() {
            *to = times(row, &memory.state) + times(&b.rows[k], &error.rows);
            change = change.max((*to - memory.state[k]).abs());
            largest = largest.max(memory.state[k].abs());
            sum += to.abs();
        }
        for (x, to) in memory.state.iter_mut().zip(&memory.next_state) {
            *x = R::select(mask, *to, *x);
        }
        let settled = change.le(R::splat(SETTLED) * largest);
        let still = moved.le(R::zero());
        let finite = R::bits(sum.lt(R::splat(f64::INFINITY)));
        Halt { stalled: R::bits(R::and(settled, still)), broken: !finite }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn static_gain(&mut self, gain: &Sparse, error: &TaskError<R, M>, mask: R::Mask) -> Halt {
        let mut moved = R::zero();
        for (joint, row) in gain.rows.iter().enumerate() {
            let dq = times(row, &error.rows);
            moved = moved.max(self.saturate(joint, dq, mask).abs());
        }
        Halt { stalled: R::bits(moved.le(R::splat(STILL))), broken: 0 }
    }

    /// Broyden's second ("bad") update of an inverse Jacobian.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn broyden(
        &mut self,
        first: &[f64],
        patience: f64,
        error: &TaskError<R, M>,
        mask: R::Mask,
    ) -> Halt {
        let dof = self.q.len();
        let memory = &mut self.memory;
        // How the error changed over the step before: the goal stands still.
        let stepped = R::and(mask, R::zero().lt(memory.stepped));
        let mut way = [R::zero(); M];
        for (to, (before, now)) in way.iter_mut().zip(memory.rows.iter().zip(&error.rows)) {
            *to = *before - *now;
        }
        let way2 = squared_norm(&way);
        let usable = R::and(stepped, R::splat(1e-300).lt(way2));
        let share = R::splat(1.0) / R::select(usable, way2, R::splat(1.0));
        for i in 0..dof {
            let mut predicted = R::zero();
            for k in 0..M {
                predicted = memory.gain[i * M + k].mul_add(way[k], predicted);
            }
            let wrong = (memory.change[i] - predicted) * share;
            for k in 0..M {
                let entry = &mut memory.gain[i * M + k];
                // Not by a factor of zero: the way of an attempt that ended may be no number.
                *entry = R::select(usable, wrong.mul_add(way[k], *entry), *entry);
            }
        }
        // Where it leads nowhere for a while, what was learned is forgotten.
        let squared = squared_norm(&error.rows);
        let better = squared.lt(memory.best);
        memory.best = R::select(R::and(mask, better), squared, memory.best);
        let misses = R::select(better, R::zero(), memory.misses + R::splat(1.0));
        let forget = R::and(mask, R::splat(patience).le(misses));
        memory.misses = R::select(mask, R::select(forget, R::zero(), misses), memory.misses);
        for (entry, value) in memory.gain.iter_mut().zip(first) {
            *entry = R::select(forget, R::splat(*value), *entry);
        }
        memory.stepped = R::select(mask, R::splat(1.0), memory.stepped);
        for (to, now) in memory.rows.iter_mut().zip(&error.rows) {
            *to = R::select(mask, *now, *to);
        }
        let mut moved = R::zero();
        for i in 0..dof {
            let mut dq = R::zero();
            for k in 0..M {
                dq = self.memory.gain[i * M + k].mul_add(error.rows[k], dq);
            }
            let change = self.saturate(i, dq, mask);
            self.memory.change[i] = R::select(mask, change, self.memory.change[i]);
            moved = moved.max(change.abs());
        }
        // Standing still with the first matrix means standing still for good; with a
        // learned one it means forgetting it.
        let still = moved.le(R::splat(STILL));
        let stuck = R::and(mask, still);
        let mut learned = R::zero();
        for (entry, value) in self.memory.gain.iter_mut().zip(first) {
            learned = learned.max((*entry - R::splat(*value)).abs());
            *entry = R::select(stuck, R::splat(*value), *entry);
        }
        let unlearned = learned.le(R::zero());
        let finite = R::bits(learned.lt(R::splat(f64::INFINITY)));
        Halt { stalled: R::bits(R::and(still, unlearned)), broken: !finite }
    }

    /// A sweep of IK-PID: each joint is tried on either side of where it is, at a distance
    /// that a PID law takes from the length of the error.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn pid(&mut self, pid: &Pid, error: &TaskError<R, M>, mask: R::Mask) -> Halt {
        let compiled = self.plan.request.chain().compiled();
        let enough = Enough::of(self.setup.aim.tolerance());
        let rounding = R::splat(ROUNDING * self.plan.request.chain().reach().size);
        let dof = self.q.len();
        // Turning the tool about one axis moves no axis before it, so a sweep from the tip
        // needs one pass of forward kinematics.
        let full = pid.full_passes || pid.order == PidOrder::BaseFirst || !compiled.simple;
        let mut tip = self.workspace.tool_point(self.setup.aim.tail().translation);
        let mut axes = self.workspace.joint_axes();
        let mut length = squared_norm(&error.rows).sqrt();
        let memory = &mut self.memory;
        let first = R::and(mask, memory.previous.lt(R::zero()));
        memory.previous = R::select(first, length, memory.previous);
        let mut going = mask;
        let mut moved = R::zero();
        for turn in 0..dof {
            let joint = match pid.order {
                PidOrder::TipFirst => dof - 1 - turn,
                PidOrder::BaseFirst => turn,
            };
            let memory = &mut self.memory;
            memory.sum = R::select(going, memory.sum + length, memory.sum);
            let difference = length - memory.previous;
            memory.previous = R::select(going, length, memory.previous);
            let step = length * R::splat(pid.proportional);
            let step = memory.sum.mul_add(R::splat(pid.integral), step);
            let step = difference.mul_add(R::splat(pid.derivative), step);
            let (q, limit) = (self.q[joint], self.limits[joint]);
            let (lower, upper) = (R::splat(limit.lower), R::splat(limit.upper));
            let plus = (q + step).max(lower).min(upper);
            let minus = if pid.literal { plus - step - step } else { q - step };
            let minus = minus.max(lower).min(upper);
            let mut best = (q, tip, axes, length * length);
            let mut chosen = length;
            let mut arrived = 0u32;
            for side in 0..2 {
                let to = if side == 0 { plus } else { minus };
                let (point, turned) = if full {
                    self.q[joint] = to;
                    forward(compiled, &self.q, &mut self.workspace);
                    let point = self.workspace.tool_point(self.setup.aim.tail().translation);
                    (point, self.workspace.joint_axes())
                } else {
                    self.swing(joint, to - q, tip, axes)
                };
                self.workspace.set_joint_axes(turned);
                let tried = self.rows.error(&self.workspace, point, &self.goal);
                let squared = squared_norm(&tried.rows);
                let norm = squared.sqrt();
                let wins = R::and(going, (norm + rounding).lt(chosen));
                best.0 = R::select(wins, to, best.0);
                for k in 0..3 {
                    best.1[k] = R::select(wins, point[k], best.1[k]);
                    if T::ORIENTS {
                        for (to, from) in best.2[k].iter_mut().zip(turned[k]) {
                            *to = R::select(wins, from, *to);
                        }
                    }
                }
                chosen = R::select(wins, norm, chosen);
                let wins = R::bits(wins);
                arrived = enough.holds::<T, M>(&tried) & wins | arrived & !wins;
            }
            moved = moved.max((best.0 - q).abs());
            self.q[joint] = best.0;
            (tip, axes, length) = (best.1, best.2, chosen);
            going = R::mask_from_bits(R::bits(going) & !arrived);
            if R::bits(going) == 0 {
                break;
            }
        }
        // With an integral part the next sweep tries other distances.
        let still = if pid.integral == 0.0 { R::bits(moved.le(R::zero())) } else { 0 };
        Halt { stalled: still, broken: !R::bits(length.lt(R::splat(f64::INFINITY))) }
    }

    /// Tool point and axes after one joint moved by `by`.
    #[inline(always)]
    fn swing(&self, joint: usize, by: R, tip: [R; 3], axes: [[R; 3]; 3]) -> ([R; 3], [[R; 3]; 3]) {
        let axis = self.workspace.axes[joint];
        if self.variables[joint].kind == JointKind::Prismatic {
            return (axpy(axis.direction, by, tip), axes);
        }
        let (sine, cosine) = by.sin_cos();
        let turned = if T::ORIENTS {
            [
                axis.turned(axes[0], sine, cosine),
                axis.turned(axes[1], sine, cosine),
                axis.turned(axes[2], sine, cosine),
            ]
        } else {
            axes
        };
        (axis.turned_point(tip, sine, cosine), turned)
    }

    /// A sweep of cyclic coordinate descent over the tool point.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn descent(&mut self, mask: R::Mask) -> Halt {
        let compiled = self.plan.request.chain().compiled();
        let mut tip = self.workspace.tool_point(self.setup.aim.tail().translation);
        let axes = self.workspace.joint_axes();
        let mut moved = R::zero();
        for joint in (0..self.q.len()).rev() {
            let dq = if compiled.simple { self.nearest(joint, tip) } else { self.newton(joint) };
            let change = self.saturate(joint, dq, mask);
            moved = moved.max(change.abs());
            if compiled.simple {
                tip = self.swing(joint, change, tip, axes).0;
            }
        }
        Halt { stalled: R::bits(moved.le(R::splat(STILL))), broken: 0 }
    }

    /// The change of one joint that brings the tool point nearest, inside the limits.
    #[inline(always)]
    fn nearest(&self, joint: usize, tip: [R; 3]) -> R {
        let axis = self.workspace.axes[joint];
        if self.variables[joint].kind == JointKind::Prismatic {
            return dot(axis.direction, sub(self.goal.position, tip));
        }
        let a = axis.direction;
        let arm = sub(tip, axis.origin);
        let arm = sub(arm, scale(a, dot(a, arm)));
        let wanted = sub(self.goal.position, axis.origin);
        let wanted = sub(wanted, scale(a, dot(a, wanted)));
        let sine = dot(a, cross(arm, wanted));
        let cosine = dot(arm, wanted);
        // On the axis, or with a goal on it, every angle is as good.
        let idle = (sine.abs() + cosine.abs()).le(R::splat(1e-24));
        let dq = R::select(idle, R::zero(), atan2(sine, cosine));
        let (q, limit) = (self.q[joint], self.limits[joint]);
        let (lower, upper) = (R::splat(limit.lower), R::splat(limit.upper));
        let turn = R::splat(std::f64::consts::TAU);
        let inside = |to: R| R::and(lower.le(to), to.le(upper));
        let to = q + dq;
        let back = R::select(inside(to - turn), to - turn, to);
        let to = R::select(inside(to), to, R::select(inside(to + turn), to + turn, back));
        // The distance grows with the angle off the best one: the nearer end is next best.
        let share = R::splat(1.0 / std::f64::consts::TAU);
        let off = |end: R| {
            let by = end - to;
            (by - (by * share).round() * turn).abs()
        };
        let end = if limit.lower.is_finite() && limit.upper.is_finite() {
            R::select(off(lower).le(off(upper)), lower, upper)
        } else {
            to
        };
        R::select(inside(to), to, end) - q
    }

    /// A Gauss-Newton step of one joint value that moves several joints.
    #[inline(always)]
    fn newton(&mut self, joint: usize) -> R {
        let compiled = self.plan.request.chain().compiled();
        forward(compiled, &self.q, &mut self.workspace);
        let tip = self.workspace.tool_point(self.setup.aim.tail().translation);
        let mut column = [R::zero(); 3];
        crate::kinematics::columns(compiled, &self.workspace, tip, |variable, linear, _| {
            if variable == joint {
                for (sum, x) in column.iter_mut().zip(linear) {
                    *sum += x;
                }
            }
        });
        let downhill = dot(column, sub(self.goal.position, tip));
        downhill / dot(column, column).max(R::splat(1e-24))
    }
}
