//! Second aims of arms with one joint to spare: a search along a curve.
//!
//! The postures that reach a target form curves then. A step goes along the curve's direction `z`
//! (what is left of the direction before without the part that moves the tool) and its bend
//! `q'' = -J^+ J' z`, so that it leaves the curve by no more than the third power of its length.
//! With the bend at hand the second derivative of a measure `f` along the curve is known as well,
//! `z^T H z + grad f . q''`, and steps are those of Newton. That of manipulability would take the
//! change of a change of `J`: there a cubic through the values and slopes of two steps tells where
//! the best place is.

use super::second_step::CURVE_STEPS;
use super::{Engine, Limit, dot};
use crate::call::{Merit, Second};
use crate::kinematics::columns;
use crate::lanes::{Real, V3, axpy, cross, sub};
use crate::solve::linear::Factored;
use crate::solve::step::gram;
use crate::task::{Rows, TaskError};

/// Longest change of a joint along the curve in one step, and the one of a first step whose length
/// nothing tells, rad or sizes of the robot.
const LONGEST: f64 = 0.5;
const FIRST: f64 = 0.3;
/// Share of a step's change that its bend may take away.
const BENT: f64 = 0.3;
/// Share of the last step by which one goes back where the slope has changed its sign.
const BACK: f64 = 0.7;
/// From this step on steps get shorter, and the last ones are left to the target alone.
const SHORTER: u32 = 10;
const LAST: u32 = 4;
/// A step shorter than this is the last: what it leaves is of the order of its square. Where
/// answers are to be the nearest, nearness counts, and so does half of it for the way back to the
/// target: near a singularity what is left of the error is worth a longer way. Of the limits'
/// measure the last step is one that gains less than this share of it.
const SETTLED: f64 = 3e-3;
const SETTLED_NEAR: f64 = 4e-4;
const SETTLED_STEEP: f64 = 3e-2;
const GAIN: f64 = 1e-4;
/// Steps shorter than this do not tell how a cubic bends.
const TOLD: f64 = 1e-2;
/// Part of the way to a limit that a step towards the limits' measure may go.
const SPARED: f64 = 0.8;
/// Joints that the curve moves less than this, of its length 1, are not what stops at a limit.
const IDLE: f64 = 1e-3;

/// What tells how far to go along the curve.
struct Slope<R: Real> {
    /// How fast the measure falls along the direction.
    fall: R,
    /// The way to where it is best, in lanes in which that is known.
    wanted: R,
    known: R::Mask,
    /// The measure itself.
    value: R,
}

impl<R: Real, T: Rows<R, M>, const M: usize, const WAY: u8> Engine<'_, R, T, M, WAY> {
    /// One step along the curve of the lanes in `moving`, whose columns have been filled in.
    #[inline(always)]
    pub(super) fn curve_step(
        &mut self,
        second: &Second,
        error: &TaskError<R, M>,
        moving: u32,
        (squared, per_radian): (R, R),
    ) {
        let begins = self.second.stepped.lt(R::splat(0.5));
        let factored = self.follow_curve(begins);
        let unit = |slides: bool| if slides { per_radian } else { R::splat(1.0) };
        // How the columns change along the curve, seen from the base: what is behind a joint moves
        // against what is before it, for the tool stands still.
        let whole = second.measure == Merit::Manipulability;
        if whole {
            for (worth, column) in self.second.worths.iter_mut().zip(&self.columns) {
                *worth = factored.solve(*column);
            }
        }
        let (mut bend, mut growth) = ([R::zero(); M], R::zero());
        {
            let compiled = self.plan.request.chain().compiled();
            let (rows, goal, workspace) = (&self.rows, &self.goal, &self.workspace);
            let point = workspace.tool_point(self.setup.point);
            let seen = rows.look(workspace, point, goal);
            let (mut turned, mut moved): (V3<R>, V3<R>) = ([R::zero(); 3], [R::zero(); 3]);
            let (limits, stretches) = (&self.limits, self.stretches);
            let (along, worths) = (&self.second.along, &self.second.worths);
            columns(compiled, workspace, point, |variable, linear, angular| {
                let unit = unit(stretches && limits[variable].slides);
                let by = along[variable] * unit;
                turned = axpy(angular, by, turned);
                moved = axpy(linear, by, moved);
                let linear = sub(cross(turned, linear), cross(angular, moved));
                let change = rows.column(&seen, goal, linear, cross(turned, angular));
                for (sum, x) in bend.iter_mut().zip(change) {
                    *sum = by.mul_add(x, *sum);
                }
                if whole {
                    growth = unit.mul_add(dot(&worths[variable], &change), growth);
                }
            });
        }
        let of_bend = factored.solve(bend);
        let of_error = factored.solve(error.rows);
        let mut sharpest = R::splat(1e-9);
        let (mut longest, mut corrected) = (R::splat(1e-300), R::zero());
        let memory = &mut self.second;
        let ways = memory.bend.iter_mut().zip(&mut memory.back).zip(&memory.along);
        for (column, ((bend, back), along)) in self.columns.iter().zip(ways) {
            *bend = dot(column, &of_bend);
            *back = dot(column, &of_error);
            sharpest = sharpest.max(bend.abs());
            corrected = corrected.max(back.abs());
            longest = longest.max(along.abs());
        }
        let slope = if whole {
            let slope = self.rise_of_dexterity(growth, &factored, begins, longest);
            let value = self.second.value;
            self.second.value = (R::select(begins, slope.value, value.0), slope.value);
            slope
        } else {
            self.fall_of_sum(second, per_radian)
        };
        let Slope { fall, wanted, known, value } = slope;
        let memory = &mut self.second;
        // The longest way that is left to go, by the steps so far and by how sharp the curve bends.
        let last = f64::from(CURVE_STEPS - LAST);
        let left = (R::splat(last) - memory.stepped) * R::splat(1.0 / (last - f64::from(SHORTER)));
        let most = LONGEST.min(self.setup.settings.max_step);
        let far = R::splat(most) / longest;
        let mut room = far * left.max(R::zero()).min(R::splat(1.0));
        room = room.min(R::splat(2.0 * BENT) * longest / sharpest);
        let before = memory.length;
        let forth = R::zero().lt(memory.fall * before);
        let overshot = R::and(forth, (fall * memory.fall).lt(R::zero()));
        let part = R::select(overshot, before.abs() * R::splat(BACK), room);
        room = R::select(begins, room, room.min(part));
        let usual = if whole { R::select(begins, R::splat(FIRST) / longest, far) } else { far };
        let usual = R::select(fall.lt(R::zero()), R::zero() - usual, usual);
        let length = R::select(known, wanted, usual).max(R::zero() - room).min(room);
        let spared = if second.measure == Merit::Limits { 1.0 - SPARED } else { 0.0 };
        let length = self.before_limits(length, far, spared, per_radian, moving);
        let memory = &mut self.second;
        let way = length.abs() * longest;
        let settled = match second.measure {
            Merit::Limits => {
                let gains = (value * R::splat(GAIN)).lt((length * fall).abs());
                R::bits(way.lt(R::splat(SETTLED_STEEP))) & !R::bits(gains)
            }
            Merit::Near => R::bits(way.max(corrected + corrected).lt(R::splat(SETTLED_NEAR))),
            _ => R::bits(way.lt(R::splat(SETTLED))),
        };
        memory.settled = memory.settled & !moving | settled & moving;
        (memory.fall, memory.length) = (fall, length);
        let counted = memory.stepped + R::splat(1.0);
        memory.stepped = R::select(R::mask_from_bits(moving), counted, memory.stepped);
        let half = R::splat(-0.5) * length * length;
        let ways = memory.bend.iter().zip(&memory.back).zip(&memory.along);
        for (change, ((bend, back), along)) in self.change.iter_mut().zip(ways) {
            *change = length.mul_add(*along, half.mul_add(*bend, *back));
        }
        self.apply(moving, squared, per_radian);
    }

    /// The direction of the curve, on from that of the step before, of length 1; returns the
    /// factors of `J J^T`.
    #[inline(always)]
    fn follow_curve(&mut self, begins: R::Mask) -> Factored<R, M> {
        let mut a = gram(&self.columns);
        let least = self.setup.lengths.added(R::zero(), 0.0);
        for (i, row) in a.iter_mut().enumerate() {
            row[i] += least;
        }
        let factored = Factored::new(a);
        let mut moved = [R::zero(); M];
        for (i, (column, along)) in self.columns.iter().zip(&mut self.second.along).enumerate() {
            *along = R::select(begins, R::splat(any_direction(i)), *along);
            for (sum, x) in moved.iter_mut().zip(column) {
                *sum = along.mul_add(*x, *sum);
            }
        }
        let of_moved = factored.solve(moved);
        let mut length = R::splat(1e-300);
        for (column, along) in self.columns.iter().zip(&mut self.second.along) {
            *along -= dot(column, &of_moved);
            length = along.mul_add(*along, length);
        }
        let inverse = R::splat(1.0) / length.sqrt();
        for along in &mut self.second.along {
            *along *= inverse;
        }
        factored
    }

    /// The slope of a measure that is the sum of what the joints add.
    #[inline(always)]
    fn fall_of_sum(&mut self, second: &Second, per_radian: R) -> Slope<R> {
        let memory = &self.second;
        let none = R::zero();
        let (mut value, mut fall, mut curvature, mut third) = (none, none, none, none);
        let ways = memory.along.iter().zip(&memory.bend).zip(&memory.about);
        for (i, ((v, q), ((along, bend), about))) in
            self.limits.iter().zip(&self.q).zip(ways).enumerate()
        {
            let stretched = self.stretches && v.slides;
            let (along, bend) =
                if stretched { (*along * per_radian, *bend * per_radian) } else { (*along, *bend) };
            let of = second.bends(i, *q, *about);
            value += of.value;
            fall -= of.slope * along;
            let square = along * along;
            curvature = square.mul_add(of.curvature, curvature - of.slope * bend);
            third = (square * along).mul_add(of.third, third);
        }
        let known = none.lt(curvature);
        let inverse = R::splat(1.0) / R::select(known, curvature, R::splat(1.0));
        let mut wanted = fall * inverse;
        if second.measure == Merit::Limits {
            // Halley's step: near a limit Newton's is half the distance from it.
            let share = R::splat(-0.5) * fall * third * inverse * inverse;
            let share = share.max(none).min(R::splat(0.75));
            wanted = wanted / (R::splat(1.0) - share);
        }
        Slope { fall, wanted, known, value }
    }

    /// The slope of manipulability, by how fast its logarithm grows: of its square `det(J J^T)`,
    /// in shares of what that is now.
    #[inline(always)]
    fn rise_of_dexterity(
        &self,
        growth: R,
        factored: &Factored<R, M>,
        begins: R::Mask,
        longest: R,
    ) -> Slope<R> {
        let (memory, none, one) = (&self.second, R::zero(), R::splat(1.0));
        let mut value = factored.pivots[0];
        for pivot in &factored.pivots[1..] {
            value *= *pivot;
        }
        value = value.max(R::splat(1e-300));
        let rise = growth + growth;
        let share = R::select(begins, one, memory.value.1 / value);
        let rise_before = memory.fall * share;
        let far = R::splat(TOLD).lt(memory.length.abs() * longest);
        let moved =
            R::and(R::splat(1e-12).lt(memory.length.abs()), R::mask_from_bits(!R::bits(begins)));
        let inverse = one / R::select(moved, memory.length, one);
        // What has to be least is less the rise.
        let secant = (rise_before - rise) * inverse;
        let bends = R::and(moved, none.lt(secant));
        let by_secant = rise / R::select(bends, secant, one);
        let gained = (one - share) * inverse;
        let second = (R::splat(-2.0) * rise_before - R::splat(4.0) * rise + R::splat(6.0) * gained)
            * inverse;
        let third =
            (R::splat(12.0) * gained - R::splat(6.0) * (rise_before + rise)) * inverse * inverse;
        let inner = second.mul_add(second, R::splat(2.0) * third * rise);
        let below = second + inner.max(none).sqrt();
        let told = R::and(R::and(moved, far), R::and(none.le(inner), R::splat(1e-3).lt(below)));
        let by_cubic = R::splat(2.0) * rise / R::select(told, below, one);
        Slope {
            fall: rise,
            wanted: R::select(told, by_cubic, by_secant),
            known: R::or(told, bends),
            value,
        }
    }

    /// As much of a step along the curve as the limits leave, or what brings joints back inside
    /// that the way back to the target would push out; `spared` of the way to a limit is left.
    #[inline(always)]
    fn before_limits(&mut self, length: R, far: R, spared: f64, per_radian: R, moving: u32) -> R {
        let memory = &mut self.second;
        let half = R::splat(-0.5) * length * length;
        let mut outside = R::mask_from_bits(0);
        let stretches = self.stretches;
        let end = |limit: f64, q: R| {
            let end = R::splat(limit);
            let all = spared == 0.0 || limit.is_infinite();
            if all { end } else { (q - end).mul_add(R::splat(spared), end) }
        };
        let ends = |v: &Limit, q: R| (end(v.lower, q), end(v.upper, q));
        let unit = |v: &Limit| {
            if stretches && v.slides { per_radian } else { R::splat(1.0) }
        };
        let ways = memory.along.iter().zip(&memory.bend).zip(&memory.back);
        for ((v, q), ((along, bend), back)) in self.limits.iter().zip(&self.q).zip(ways) {
            if !v.turns {
                let (low, high) = ends(v, *q);
                let change = length.mul_add(*along, half.mul_add(*bend, *back));
                let to = change.mul_add(unit(v), *q);
                outside = R::or(outside, R::or(to.lt(low), high.lt(to)));
            }
        }
        if R::bits(outside) & moving == 0 {
            return length;
        }
        // First as if the curve were straight, then with its bend that far.
        let mut there = R::zero();
        for round in 0..2 {
            let half = R::splat(-0.5) * there * there;
            let (mut least, mut most) = (R::splat(f64::NEG_INFINITY), R::splat(f64::INFINITY));
            let ways = memory.along.iter().zip(&memory.bend).zip(&memory.back);
            let joints = self.limits.iter().zip(&self.q).zip(ways).zip(&mut memory.inverse);
            for (((v, q), ((along, bend), back)), inverse) in joints {
                if v.turns {
                    continue;
                }
                if round == 0 {
                    let moves = R::splat(IDLE).lt(along.abs());
                    *inverse = R::splat(1.0) / R::select(moves, *along * unit(v), R::splat(1.0));
                }
                let moves = R::splat(IDLE).lt(along.abs());
                let (low, high) = ends(v, *q);
                let base = half.mul_add(*bend, *back).mul_add(unit(v), *q);
                let (a, b) = ((low - base) * *inverse, (high - base) * *inverse);
                least = R::select(moves, least.max(a.min(b)), least);
                most = R::select(moves, most.min(a.max(b)), most);
            }
            there = length.max(least).min(most);
            let wide = R::splat(if round == 0 { 1.0 } else { 1.5 }) * far;
            there = there.max(R::zero() - wide).min(wide);
        }
        R::select(outside, there, length)
    }
}

/// An entry of a direction that no arm's curve is at right angles to by design.
#[inline(always)]
fn any_direction(i: usize) -> f64 {
    const SOME: [f64; 7] = [1.0, -0.9, 1.1, 0.8, -1.2, 0.7, 0.95];
    SOME[i % SOME.len()]
}
