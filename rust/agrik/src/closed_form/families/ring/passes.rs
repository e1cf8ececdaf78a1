//! One cut for many goals, in passes: lanes hold goals while the polynomials are made, then
//! roots, then postures, so that a batch keeps them full; of a single goal they hold the samples
//! first. What a lane computes does not depend on the others.

use std::f64::consts::PI;

use super::cut::Cut;
use super::isolate::{Arcs, NOISE, Place, Sifted, Waiting, arcs, places, sifted};
use super::null::{Factors, angles, distance, two_products};
use super::resultant::{ANGLES, HARMONICS, Harmonics, SAMPLES, harmonics, sample, value};
use super::rows::{
    MOTION, NUMBERS, columns_at, flat, gather, in_row, lane_of, motion, spread, used,
};
use crate::closed_form::families::postures::{FINE, NEAR, Set, turned};
use crate::closed_form::geometry::rigid::Rigid;
use crate::closed_form::geometry::serial::Serial;
use crate::lanes::{Kernel, Real, WIDEST, atan2_each};

/// Most steps of a start, and what those may miss by at best that are left after some of them, arm
/// lengths and rad: of 800,000 postures one came from a start that missed by more.
const STEPS: usize = 28;
const PROMISING: [(usize, f64); 2] = [(3, 0.3), (8, 1e-2)];
/// A step as long as that may lead anywhere, rad.
const LONG: f64 = 0.3;
/// Steps that sharpen a root, the length below which there is no need, the longest of them, and
/// how far they may lead in all, rad.
const SHARPEN: usize = 5;
const SHARP: f64 = 1e-8;
const LONGEST: f64 = 0.02;
const FARTHEST: f64 = 0.03;
/// A root that moved by more is tried from where it was as well, rad.
const MOVED: f64 = 1e-7;
/// Share of the matrix' size below which a second singular value makes two null vectors.
const DOUBLE: f64 = 1e-2;
/// Steps of a root, and the step at which it is left, rad.
const REFINE: usize = 40;
const REFINED: f64 = 1e-9;
/// Noise of samples that seem to have none.
const EPSILON: f64 = 2e-16;

/// A start that misses by more is none, arm lengths and rad.
const HOPELESS: f64 = 0.5;
/// Starts of a goal nearer to one another lead to the same posture, rad; so many are looked at.
const SAME_START: f64 = 1e-6;
const VARIANTS: usize = 4;

/// The three angles that a null vector gives, as sine and cosine, before the rest is known.
#[derive(Clone, Copy)]
struct Third {
    goal: u32,
    turns: [f64; 6],
}

/// A place whose root is being sharpened.
#[derive(Clone, Copy)]
struct Open {
    place: u32,
    /// The root, and how far off it was taken to be before, rad.
    angle: f64,
    before: f64,
}

/// What a place can lead to: where it was before it was sharpened, after it, and as two products.
const KINDS: usize = 4;

/// A start of Newton's steps, on its way.
#[derive(Clone, Copy)]
struct Start {
    goal: u32,
    q: [f64; 6],
    /// The step that led there, rad.
    step: f64,
    /// The best posture before it, and what was left there, squared.
    best: [f64; 6],
    least: f64,
}

/// What a call needs room for.
#[derive(Default)]
pub struct Work {
    goals: Vec<[f64; MOTION]>,
    equations: Vec<[f64; NUMBERS]>,
    harmonics: Vec<Harmonics<f64>>,
    waiting: Waiting,
    places: Vec<Place>,
    open: [Vec<Open>; 2],
    /// Those that each place leads to.
    kinds: Vec<[Option<Third>; KINDS]>,
    thirds: Vec<Third>,
    starts: Vec<Start>,
    later: Vec<Start>,
}

/// One cut for goals in arm lengths.
pub struct OneCut<'a> {
    pub cut: &'a Cut,
    pub serial: &'a Serial<6>,
    pub goals: &'a [Rigid<f64>],
    /// Start values of the goals, if there are any: what the roots may lead past.
    pub near: &'a [[f64; 6]],
    pub sets: &'a mut [Set],
    pub work: &'a mut Work,
}

impl Kernel for OneCut<'_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(mut self) {
        let work = &mut *self.work;
        work.goals.clear();
        work.equations.clear();
        work.harmonics.clear();
        work.places.clear();
        work.thirds.clear();
        work.starts.clear();
        work.later.clear();
        for goal in self.goals {
            work.goals.push(flat(goal));
        }
        self.polynomials::<R>();
        self.refine::<R>();
        self.null_vectors::<R>();
        for (goal, q) in self.near.iter().enumerate() {
            let start =
                Start { goal: goal as u32, q: *q, step: PI, best: *q, least: f64::INFINITY };
            self.work.starts.push(start);
        }
        self.complete::<R>();
        self.polish::<R>();
    }
}

impl OneCut<'_> {
    /// Equations, polynomials and the places of their roots.
    #[inline(always)]
    fn polynomials<R: Real>(&mut self) {
        let table = &*ANGLES;
        let alone = self.goals.len() == 1;
        let mut first = 0;
        while first < self.goals.len() {
            let count = R::WIDTH.min(self.goals.len() - first);
            let mut rows = [&self.work.goals[first]; WIDEST];
            for lane in 1..count {
                rows[lane] = &self.work.goals[first + lane];
            }
            let goal = motion(&gather::<R, MOTION>(&rows));
            let k = self.cut.equations(&self.cut.far(&self.cut.wanted(&goal)));
            // All samples of each lane's goal; of a single goal a sample in each lane.
            let mut samples = [R::zero(); SAMPLES];
            let step = if alone { R::WIDTH } else { 1 };
            let mut next = 0;
            while next < SAMPLES {
                let (mut c, mut s) = ([0.0; WIDEST], [0.0; WIDEST]);
                for lane in 0..R::WIDTH {
                    let at = if alone { (next + lane) % SAMPLES } else { next };
                    (c[lane], s[lane]) = table[at];
                }
                let found = sample(&k, (R::load(&c), R::load(&s)));
                if alone {
                    for lane in 0..step.min(SAMPLES - next) {
                        samples[next + lane] = R::splat(found.lane(lane));
                    }
                } else {
                    samples[next] = found;
                }
                next += step;
            }
            let (h, noise) = harmonics(&samples);
            let on_arcs = arcs(&h);
            let sifted = sifted(&on_arcs, noise);
            let row = in_row(&k);
            for lane in 0..count {
                self.work.equations.push(lane_of(&row, lane));
                self.work.harmonics.push(lane_of(&h, lane));
                self.look(first + lane, lane, &on_arcs, (&sifted, noise.lane(lane)));
            }
            first += R::WIDTH;
        }
    }

    /// Isolates the roots of the polynomial of a goal, which is in a lane.
    #[inline(always)]
    fn look<R: Real>(
        &mut self,
        goal: usize,
        lane: usize,
        on_arcs: &Arcs<R>,
        (sifted, noise): (&Sifted<R>, f64),
    ) {
        let all = &mut self.work.places;
        let before = all.len();
        places(goal as u32, lane, on_arcs, sifted, (&mut self.work.waiting, all));
        let found = &all[before..];
        let set = &mut self.sets[goal];
        set.noise = if noise.is_finite() { noise } else { f64::INFINITY };
        set.places = found.len();
        set.roots = found.iter().filter(|place| place.single).count();
    }

    /// Newton's steps on the polynomials, kept inside the places of single roots.
    #[inline(always)]
    fn refine<R: Real>(&mut self) {
        let Work { harmonics, places, .. } = &mut *self.work;
        for group in places.chunks_mut(R::WIDTH) {
            let mut rows = [&harmonics[group[0].goal as usize]; WIDEST];
            let (mut low, mut high) = ([0.0; WIDEST], [0.0; WIDEST]);
            let (mut signs, mut single) = ([1.0; WIDEST], 0_u32);
            let (mut centres, mut noise) = ([0.0; WIDEST], [0.0; WIDEST]);
            for (lane, place) in group.iter().enumerate() {
                rows[lane] = &harmonics[place.goal as usize];
                noise[lane] = NOISE * self.sets[place.goal as usize].noise.max(EPSILON);
                centres[lane] = place.centre;
                (low[lane], high[lane]) = (place.lower, place.upper);
                signs[lane] = if place.rising { 1.0 } else { -1.0 };
                single |= u32::from(place.single) << lane;
            }
            let h: [R; HARMONICS] = spread(&rows);
            let mut largest = R::zero();
            for x in &h {
                largest = largest.max(x.abs());
            }
            let (centre, sign) = (R::load(&centres), R::load(&signs));
            let ends = atan2_each([R::load(&low), R::load(&high)], [R::splat(1.0); 2]);
            let [mut lower, mut upper] = ends.map(|end| centre + (end + end));
            let half = R::splat(0.5);
            let mut at = half * (lower + upper);
            let (mut active, mut steep) = (single, R::zero());
            for _ in 0..REFINE {
                if active == 0 {
                    break;
                }
                let (x, slope) = value(&h, at.sin_cos());
                let mask = R::mask_from_bits(active);
                let below = (x * sign).lt(R::zero());
                lower = R::select(R::and(mask, below), at, lower);
                let above = R::zero().le(x * sign);
                upper = R::select(R::and(mask, above), at, upper);
                let next = at - x / slope;
                let inside = R::and(lower.le(next), next.le(upper));
                let next = R::select(inside, next, half * (lower + upper));
                let step = (next - at).abs();
                at = R::select(mask, next, at);
                steep = R::select(mask, slope.abs(), steep);
                active &= R::bits(R::splat(REFINED).lt(step));
            }
            // What the noise of the samples may move the root by.
            let blur = R::load(&noise) * largest;
            let sharp = single & !active & R::bits(blur.lt(R::splat(SHARP) * steep));
            for (lane, place) in group.iter_mut().enumerate() {
                place.angle = at.lane(lane);
                place.sharp = sharp >> lane & 1 != 0;
            }
        }
    }

    /// The two other angles, from the null vectors at the roots.
    #[inline(always)]
    fn null_vectors<R: Real>(&mut self) {
        let Work { equations, places, open, kinds, thirds, .. } = &mut *self.work;
        let [now, next] = open;
        now.clear();
        // Those that need no sharpening side by side, so that they need not wait for it.
        for sharp in [true, false] {
            for (i, place) in places.iter().enumerate().filter(|(_, one)| one.sharp == sharp) {
                let before = if sharp { 0.0 } else { f64::INFINITY };
                now.push(Open { place: i as u32, angle: place.angle, before });
            }
        }
        kinds.clear();
        kinds.resize(places.len(), [None; KINDS]);
        for round in 0..=SHARPEN {
            next.clear();
            for group in now.chunks(R::WIDTH) {
                let of = |one: &Open| &places[one.place as usize];
                let mut rows = [&equations[of(&group[0]).goal as usize]; WIDEST];
                let (mut roots, mut last) = ([group[0].angle; WIDEST], [0.0; WIDEST]);
                let mut given = roots;
                for (lane, one) in group.iter().enumerate() {
                    rows[lane] = &equations[of(one).goal as usize];
                    (roots[lane], last[lane]) = (one.angle, one.before);
                    given[lane] = of(one).angle;
                }
                let used = used(group.len());
                let (angle, given, before) = (R::load(&roots), R::load(&given), R::load(&last));
                let turn = angle.sin_cos();
                let factors = Factors::new(&columns_at::<R, false>(&rows, turn));
                let first = factors.smallest();
                let (mut active, mut off) = (0, R::zero());
                if round < SHARPEN && group.iter().any(|one| one.before > 0.0) {
                    off = distance(&factors, &columns_at::<R, true>(&rows, turn), &first.right);
                    // At a double root without end, and no use.
                    let nearer = off.abs().lt(R::splat(0.3) * before);
                    let blunt = R::splat(SHARP).lt(off.abs());
                    active = R::bits(R::and(blunt, nearer)) & used;
                }
                let moved = R::bits(R::splat(MOVED).lt((angle - given).abs()));
                // What is taken: null vector and the lanes that have it. Where a root was before
                // it was sharpened is no other place than where it is if it has not moved.
                let mut found = [(first.right, 0_u32); KINDS];
                found[0].1 = if round == 0 { active } else { 0 };
                let done = used & !active;
                found[1].1 = done;
                if done != 0 {
                    let second = factors.next(&first, DOUBLE);
                    let double = R::bits(second.size.lt(R::splat(DOUBLE))) & done;
                    if double != 0 {
                        let two = two_products(&first.right, &second.right);
                        for k in 0..2 {
                            found[2 + k] = (two.products[k], double & !two.known[k]);
                        }
                    }
                }
                for (kind, (v, lanes)) in found.iter().enumerate() {
                    if *lanes == 0 {
                        continue;
                    }
                    let [x, y] = angles(v);
                    let turns = [turn.0, turn.1, x.0, x.1, y.0, y.1];
                    for (lane, one) in group.iter().enumerate() {
                        if lanes >> lane & 1 != 0 {
                            let goal = of(one).goal;
                            kinds[one.place as usize][kind] =
                                Some(Third { goal, turns: lane_of(&turns, lane) });
                        }
                    }
                }
                let size = off.abs();
                let off = off.max(R::splat(-LONGEST)).min(R::splat(LONGEST));
                let far = R::splat(FARTHEST);
                let onward = (angle - off).max(given - far).min(given + far);
                for (lane, one) in group.iter().enumerate() {
                    if active >> lane & 1 != 0 {
                        let (angle, before) = (onward.lane(lane), size.lane(lane));
                        next.push(Open { place: one.place, angle, before });
                    } else if moved >> lane & 1 == 0 {
                        kinds[one.place as usize][0] = None;
                    }
                }
            }
            std::mem::swap(now, next);
            if now.is_empty() {
                break;
            }
        }
        // Place by place, so that the order does not depend on what shares the lanes.
        thirds.extend(kinds.iter().flatten().flatten());
    }

    /// All six angles, and one of Newton's steps from them.
    #[inline(always)]
    fn complete<R: Real>(&mut self) {
        let Work { goals, thirds, starts, .. } = &mut *self.work;
        for group in thirds.chunks(R::WIDTH) {
            let mut rows = [&goals[group[0].goal as usize]; WIDEST];
            let mut turns = [&group[0].turns; WIDEST];
            for (lane, third) in group.iter().enumerate() {
                rows[lane] = &goals[third.goal as usize];
                turns[lane] = &third.turns;
            }
            let goal = motion(&spread::<R, MOTION>(&rows));
            let wanted = self.cut.wanted(&goal);
            let far = self.cut.far(&wanted);
            let t: [R; 6] = gather(&turns);
            let q = self.cut.complete(&wanted, &far, [(t[0], t[1]), (t[2], t[3]), (t[4], t[5])]);
            let (mut y, mut x) = ([R::zero(); 6], [R::zero(); 6]);
            for k in 0..6 {
                let from = if self.cut.reversed { 5 - k } else { k };
                (y[k], x[k]) = q[from];
            }
            let q = atan2_each(y, x);
            let (error, left, columns) = self.serial.errors(&q, &goal);
            let near = R::bits(left.lt(R::splat(HOPELESS * HOPELESS)));
            let next = stepped(self.serial, &q, (&error, &columns));
            for (lane, third) in group.iter().enumerate() {
                let start = Start::new(third.goal, lane, (&q, left), &next);
                // The variants of a place are often the same posture.
                let known = starts.iter().rev().take(VARIANTS).any(|other| {
                    other.goal == start.goal && nearer(&other.q, &start.q, SAME_START)
                });
                if near >> lane & 1 != 0 && !known {
                    starts.push(start);
                }
            }
        }
    }

    /// Newton's steps from all starts; what comes near enough goes into the sets. After each step
    /// those that are left close up, so that the many that need few do not wait for the few that
    /// need many.
    #[inline(always)]
    fn polish<R: Real>(&mut self) {
        let (serial, sets) = (self.serial, &mut *self.sets);
        let Work { goals, starts, later, .. } = &mut *self.work;
        for step in 1..=STEPS {
            if starts.is_empty() {
                break;
            }
            later.clear();
            for group in starts.chunks(R::WIDTH) {
                let mut rows = [&goals[group[0].goal as usize]; WIDEST];
                let mut from = [&group[0].q; WIDEST];
                for (lane, start) in group.iter().enumerate() {
                    rows[lane] = &goals[start.goal as usize];
                    from[lane] = &start.q;
                }
                let goal = motion(&spread::<R, MOTION>(&rows));
                let q = gather(&from);
                let (error, left, columns) = serial.errors(&q, &goal);
                let fine = R::bits(left.le(R::splat(FINE * FINE)));
                let next = if fine & used(group.len()) == used(group.len()) {
                    (q, R::zero())
                } else {
                    stepped(serial, &q, (&error, &columns))
                };
                for (lane, start) in group.iter().enumerate() {
                    let set = &mut sets[start.goal as usize];
                    let mut here = Start::new(start.goal, lane, (&q, left), &next);
                    if start.least < here.least {
                        (here.best, here.least) = (start.best, start.least);
                    }
                    let enough = match step {
                        1 => FINE,
                        STEPS => NEAR,
                        _ => 100.0 * FINE,
                    };
                    if here.least <= enough * enough {
                        set.add(&here.best);
                    } else if is_promising(step, here.least) {
                        later.push(here);
                    }
                }
            }
            // A step that has led to a posture by nine tenths of its way leads nowhere else.
            later.retain(|start| {
                let known = sets[start.goal as usize].postures();
                start.step > LONG || !known.iter().any(|q| nearer(q, &start.q, 0.1 * start.step))
            });
            std::mem::swap(starts, later);
        }
    }
}

impl Start {
    /// A posture in a lane with what is left squared, and where the next step leads.
    #[inline(always)]
    fn new<R: Real>(goal: u32, lane: usize, at: (&[R; 6], R), next: &([R; 6], R)) -> Self {
        Self {
            goal,
            q: lane_of(&next.0, lane),
            step: next.1.lane(lane),
            best: lane_of(at.0, lane),
            least: at.1.lane(lane),
        }
    }
}

/// A posture after one of Newton's steps, and how long that was, rad.
#[inline(always)]
fn stepped<R: Real>(
    serial: &Serial<6>,
    q: &[R; 6],
    (error, columns): (&[R; 6], &[[R; 6]; 6]),
) -> ([R; 6], R) {
    let change = serial.step(error, columns);
    let (mut out, mut longest) = (*q, R::zero());
    for k in 0..6 {
        out[k] += change[k];
        longest = longest.max(change[k].abs());
    }
    (out, longest)
}

/// A start that is left after a step with what it misses by at best, squared, is worth another.
#[inline(always)]
fn is_promising(step: usize, least: f64) -> bool {
    PROMISING.iter().all(|(after, most)| step != *after || least < most * most)
}

/// All joints are, whole turns aside.
#[inline(always)]
fn nearer(a: &[f64; 6], b: &[f64; 6], far: f64) -> bool {
    let mut all = true;
    for k in 0..6 {
        all &= turned(a[k] - b[k]).abs() < far;
    }
    all
}
