//! One cut for many goals, in passes: lanes hold goals while the polynomials are made, then
//! roots, then postures, so that a batch keeps them full; of a single goal they hold the samples
//! first. What a lane computes does not depend on the others.

use super::cut::Cut;
use super::isolate::{Arcs, Place, arcs, places};
use super::null::{Factors, angles, distance, two_products};
use super::resultant::{ANGLES, HARMONICS, Harmonics, SAMPLES, harmonics, sample, value};
use super::rows::{MOTION, NUMBERS, flat, from_row, gather, in_row, lane_of, motion, spread, used};
use crate::closed_form::families::postures::{FINE, NEAR, Set};
use crate::closed_form::geometry::rigid::Rigid;
use crate::closed_form::geometry::serial::Serial;
use crate::lanes::{Kernel, Real, WIDEST, atan2_each};

/// Steps of all starts, of those that have not arrived after them, and of those that are promising
/// even then. The many that need few do not wait for the few that need many.
const STEPS: [usize; 3] = [2, 6, 20];
const PROMISING: f64 = 1e-2;
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
/// Rounds of inverse iteration.
const ROUNDS: usize = 2;

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

/// A start of Newton's steps.
#[derive(Clone, Copy)]
struct Start {
    goal: u32,
    q: [f64; 6],
}

/// What a call needs room for.
#[derive(Default)]
pub struct Work {
    goals: Vec<[f64; MOTION]>,
    equations: Vec<[f64; NUMBERS]>,
    harmonics: Vec<Harmonics<f64>>,
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
            self.work.starts.push(Start { goal: goal as u32, q: *q });
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
            let row = in_row(&k);
            for lane in 0..count {
                self.work.equations.push(lane_of(&row, lane));
                self.work.harmonics.push(lane_of(&h, lane));
                let mut one = [[0.0; HARMONICS]; 8];
                for (to, from) in one.iter_mut().zip(&on_arcs) {
                    *to = lane_of(from, lane);
                }
                self.look(first + lane, &one, noise.lane(lane));
            }
            first += R::WIDTH;
        }
    }

    /// Isolates the roots of a goal's polynomial.
    #[inline(always)]
    fn look(&mut self, goal: usize, on_arcs: &Arcs<f64>, noise: f64) {
        let all = &mut self.work.places;
        let before = all.len();
        places(goal as u32, on_arcs, noise, all);
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
            let mut centres = [0.0; WIDEST];
            for (lane, place) in group.iter().enumerate() {
                rows[lane] = &harmonics[place.goal as usize];
                centres[lane] = place.centre;
                (low[lane], high[lane]) = (place.lower, place.upper);
                signs[lane] = if place.rising { 1.0 } else { -1.0 };
                single |= u32::from(place.single) << lane;
            }
            let h: [R; HARMONICS] = spread(&rows);
            let (centre, sign) = (R::load(&centres), R::load(&signs));
            let ends = atan2_each([R::load(&low), R::load(&high)], [R::splat(1.0); 2]);
            let [mut lower, mut upper] = ends.map(|end| centre + (end + end));
            let half = R::splat(0.5);
            let mut at = half * (lower + upper);
            let mut active = single;
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
                active &= R::bits(R::splat(REFINED).lt(step));
            }
            for (lane, place) in group.iter_mut().enumerate() {
                place.angle = at.lane(lane);
            }
        }
    }

    /// The two other angles, from the null vectors at the roots.
    #[inline(always)]
    fn null_vectors<R: Real>(&mut self) {
        let Work { equations, places, open, kinds, thirds, .. } = &mut *self.work;
        let [now, next] = open;
        now.clear();
        let all = places.iter().enumerate();
        let first = |(i, place): (usize, &Place)| Open {
            place: i as u32,
            angle: place.angle,
            before: f64::INFINITY,
        };
        now.extend(all.map(first));
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
                let k = from_row(&spread::<R, NUMBERS>(&rows));
                let used = used(group.len());
                let (angle, given, before) = (R::load(&roots), R::load(&given), R::load(&last));
                let turn = angle.sin_cos();
                let factors = Factors::new(&k, turn);
                let first = factors.next(None, ROUNDS);
                let off = distance(&factors, &k, turn, &first.right);
                // At a double root without end, and no use.
                let nearer = off.abs().lt(R::splat(0.3) * before);
                let blunt = R::splat(SHARP).lt(off.abs());
                let mut active = R::bits(R::and(blunt, nearer)) & used;
                if round == SHARPEN {
                    active = 0;
                }
                // What is taken: null vector and the lanes that have it.
                let mut found = [(first.right, 0_u32); KINDS];
                found[0].1 = if round == 0 { used } else { 0 };
                let done = used & !active;
                found[1].1 = done;
                if done != 0 {
                    let second = factors.next(Some(&first), ROUNDS);
                    let double = R::bits(second.size.lt(R::splat(DOUBLE))) & done;
                    if double != 0 {
                        let [one, two] = two_products(&first.right, &second.right);
                        (found[2], found[3]) = ((one, double), (two, double));
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
                let moved = R::bits(R::splat(MOVED).lt((angle - given).abs()));
                let size = off.abs();
                let off = off.max(R::splat(-LONGEST)).min(R::splat(LONGEST));
                let far = R::splat(FARTHEST);
                let onward = (angle - off).max(given - far).min(given + far);
                for (lane, one) in group.iter().enumerate() {
                    if active >> lane & 1 != 0 {
                        let (angle, before) = (onward.lane(lane), size.lane(lane));
                        next.push(Open { place: one.place, angle, before });
                    } else if moved >> lane & 1 == 0 {
                        // It is where it was: the one before is no other.
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

    /// All six angles.
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
            let (_, left, _) = self.serial.errors(&q, &goal);
            let near = R::bits(left.lt(R::splat(HOPELESS * HOPELESS)));
            for (lane, third) in group.iter().enumerate() {
                let start = Start { goal: third.goal, q: lane_of(&q, lane) };
                // The variants of a place are often the same posture.
                let known = starts.iter().rev().take(VARIANTS).any(|other| {
                    other.goal == start.goal
                        && other.q.iter().zip(&start.q).all(|(a, b)| (a - b).abs() < SAME_START)
                });
                if near >> lane & 1 != 0 && !known {
                    starts.push(start);
                }
            }
        }
    }

    /// Newton's steps from all starts; what comes near enough goes into the sets.
    #[inline(always)]
    fn polish<R: Real>(&mut self) {
        let (serial, sets) = (self.serial, &mut *self.sets);
        let Work { goals, starts, later, .. } = &mut *self.work;
        for (stage, steps) in STEPS.into_iter().enumerate() {
            let last = stage + 1 == STEPS.len();
            let list = std::mem::take(starts);
            later.clear();
            for group in list.chunks(R::WIDTH) {
                let mut rows = [&goals[group[0].goal as usize]; WIDEST];
                let mut from = [&group[0].q; WIDEST];
                for (lane, start) in group.iter().enumerate() {
                    rows[lane] = &goals[start.goal as usize];
                    from[lane] = &start.q;
                }
                let goal = motion(&spread::<R, MOTION>(&rows));
                let found = serial.approach(gather(&from), &goal, steps, FINE);
                for (lane, start) in group.iter().enumerate() {
                    let left = found.left.lane(lane);
                    let q = lane_of(&found.q, lane);
                    let enough = if last { NEAR } else { 100.0 * FINE };
                    if left <= enough * enough {
                        sets[start.goal as usize].add(&q);
                    } else if stage == 0 || !last && left < PROMISING * PROMISING {
                        later.push(Start { goal: start.goal, q });
                    }
                }
            }
            *starts = std::mem::replace(later, list);
        }
    }
}
