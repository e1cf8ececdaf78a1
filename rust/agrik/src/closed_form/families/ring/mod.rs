//! Any six joints that turn: all postures of a pose, at most sixteen.
//!
//! A cut of the ring gives six equations in three angles ([`cut`]), their resultant is a
//! trigonometric polynomial in one of them ([`resultant`]) whose real roots are isolated by
//! Descartes' rule ([`isolate`]); at each root the null vector of the resultant's matrix gives
//! the other two ([`null`]), and the rest follows. Newton's steps on the arm itself end it
//! ([`passes`]).

mod cut;
mod isolate;
mod line;
mod null;
mod passes;
mod rescue;
mod resultant;
mod rows;

use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

use self::cut::Cut;
use self::passes::OneCut;
pub use self::passes::Work;
use super::postures::{MOST, Set};
use crate::closed_form::geometry::enclosure::Margin;
use crate::closed_form::geometry::rigid::Rigid;
use crate::closed_form::geometry::screws::Screws;
use crate::closed_form::geometry::serial::Serial;
use crate::lanes::{Level, cross, dispatch, dot, norm, sub};
use crate::random::Sequence;

/// Noise of the samples above which a polynomial is not trusted.
const NOISY: f64 = 1e-9;
/// Share of all lengths that rounding may add to them.
const ROUNDING: f64 = 1e-9;
/// Arm lengths and rad within which the first and the last joint meet or are parallel.
const PAIRED: f64 = 1e-6;
/// Poses of random postures that decide between the cuts.
const TRIALS: usize = 128;

/// An arm of six joints that turn.
#[derive(Debug, Clone)]
pub struct Ring {
    /// The axes, in arm lengths.
    axes: Screws,
    untool: Rigid<f64>,
    serial: Serial<6>,
    /// The cut that is asked first, and the other one: made when they are needed.
    cuts: [OnceLock<Cut>; 2],
    /// The first cut reads the arm from its tool.
    reversed: bool,
    /// Metres in an arm length.
    length: f64,
    /// Of an arm with roots that belong to no posture (nearly spherical wrists have them at
    /// most poses): how many postures a pose usually has. Fewer are looked into.
    usual: Option<usize>,
    /// Roots without a posture are common.
    idle: bool,
}

impl Ring {
    /// The arm; `None` unless it has six joints. What trials tell of it is taken from `like`, if
    /// there is such.
    pub fn new(screws: &Screws, like: Option<&Self>) -> Option<Self> {
        let screws = screws.gathered();
        let length = screws.length();
        let scaled = screws.scaled(1.0 / length);
        let serial = Serial::<6>::new(&scaled)?;
        let mut ring = Self {
            untool: scaled.tool.inverse(),
            axes: scaled,
            serial,
            cuts: Default::default(),
            reversed: like.is_none_or(|like| like.reversed),
            length,
            usual: like.and_then(|like| like.usual),
            idle: false,
        };
        if like.is_none() {
            ring.look();
        }
        Some(ring)
    }

    /// Metres in an arm length.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The cut that is asked first reads the arm from its tool.
    pub fn first_is_reversed(&self) -> bool {
        self.reversed
    }

    fn cut(&self, number: usize) -> &Cut {
        let reversed = self.reversed == (number == 0);
        self.cuts[number].get_or_init(|| Cut::new(&self.axes, reversed))
    }

    /// Roots that belong to no posture are common; they cost as much as others.
    pub fn has_idle_roots(&self) -> bool {
        self.idle
    }

    /// The arm in arm lengths.
    pub fn serial(&self) -> &Serial<6> {
        &self.serial
    }

    /// A goal in arm lengths.
    pub fn scaled(&self, goal: &Rigid<f64>) -> Rigid<f64> {
        Rigid { axes: goal.axes, shift: goal.shift.map(|x| x / self.length) }
    }

    /// Poses of random postures tell which cut finds more alone, or doubts itself less, and how
    /// many postures are usual where roots without any are.
    fn look(&mut self) {
        let mut random = Sequence::new(7);
        let goals: Vec<Rigid<f64>> = (0..TRIALS)
            .map(|_| {
                let q: [f64; 6] = std::array::from_fn(|_| TAU * random.uniform() - PI);
                self.serial.forward(&q).0
            })
            .collect();
        let mut work = Work::default();
        let [one, two] = [0, 1].map(|cut| {
            let mut sets = vec![Set::EMPTY; goals.len()];
            self.run_cut(Level::in_use(), cut, (&goals, &[]), &mut sets, &mut work);
            sets
        });
        let score = |sets: &[Set]| {
            let found: usize = sets.iter().map(|set| set.count).sum();
            (found, sets.iter().filter(|set| !self.is_doubtful(set)).count())
        };
        let second = score(&two) > score(&one);
        let sets = if second { &two } else { &one };
        let spare = sets.iter().filter(|set| set.count < set.places).count();
        let times = |count: usize| sets.iter().filter(|set| set.count == count).count();
        let usual = (0..=MOST).max_by_key(|count| times(*count));
        self.idle = 5 * spare > sets.len();
        if 2 * spare > sets.len() {
            self.usual = usual.filter(|count| 4 * times(*count) > 3 * sets.len());
        }
        if second {
            self.cuts.swap(0, 1);
            self.reversed = !self.reversed;
        }
    }

    /// Runs one cut on goals in arm lengths.
    fn run_cut(
        &self,
        level: Level,
        cut: usize,
        (goals, near): (&[Rigid<f64>], &[[f64; 6]]),
        sets: &mut [Set],
        work: &mut Work,
    ) {
        let (cut, serial) = (self.cut(cut), &self.serial);
        dispatch(level, OneCut { cut, serial, goals, near, sets, work });
    }

    /// All postures of each goal (in metres), also those that lead on from `near`: of a family
    /// the one there. No start values at all do as well.
    pub fn solve(
        &self,
        level: Level,
        goals: &[Rigid<f64>],
        near: &[[f64; 6]],
        sets: &mut [Set],
        work: &mut Work,
    ) {
        let scaled: Vec<Rigid<f64>> = goals.iter().map(|goal| self.scaled(goal)).collect();
        self.run_cut(level, 0, (&scaled, near), sets, work);
        let paired: Vec<bool> = scaled.iter().map(|goal| self.is_paired(goal)).collect();
        let doubtful = |i: &usize| paired[*i] || self.is_doubtful(&sets[*i]);
        let again: Vec<usize> = (0..sets.len()).filter(doubtful).collect();
        if !again.is_empty() {
            let chosen: Vec<Rigid<f64>> = again.iter().map(|i| scaled[*i]).collect();
            let mut second = vec![Set::EMPTY; again.len()];
            self.run_cut(level, 1, (&chosen, &[]), &mut second, work);
            for (i, other) in again.iter().zip(&second) {
                let set = &mut sets[*i];
                set.noise = set.noise.min(other.noise);
                set.second = true;
                set.places = set.places.max(other.places);
                for q in other.postures() {
                    set.add(q);
                }
                if paired[*i] || set.noise > NOISY || !set.count.is_multiple_of(2) {
                    self.rescue(level, &scaled[*i], (set, paired[*i]), work);
                }
            }
        }
    }

    /// No posture reaches so far from the first axis as a goal (m) is, but for a margin: the
    /// triangle inequality. That no root was found is no proof, however clean the samples are.
    pub fn is_out_of_reach(&self, goal: &Rigid<f64>, margin: Margin) -> bool {
        let way = sub(self.scaled(goal).shift, self.axes.joints[0].point);
        let margin = margin.position / self.length;
        norm(way) > (1.0 + ROUNDING) * self.axes.span() + margin
    }

    /// A goal (arm lengths) makes the last and the first joint meet or parallel: the pair that the
    /// cuts eliminate is then no generic one, and postures are lost without a sign.
    fn is_paired(&self, goal: &Rigid<f64>) -> bool {
        is_paired(&self.axes, &goal.after(&self.untool))
    }

    /// Something says that postures may be missing.
    fn is_doubtful(&self, set: &Set) -> bool {
        let expected = self.usual.unwrap_or(set.places).max(set.roots.min(set.places));
        !set.count.is_multiple_of(2) || set.noise > NOISY || set.count < expected
    }
}

/// The same of any axes; the goal is what all joints together have to bring about.
fn is_paired(axes: &Screws, wanted: &Rigid<f64>) -> bool {
    let (first, last) = (axes.joints[0], axes.joints[5].moved(wanted));
    let across = cross(first.axis, last.axis);
    let sine = norm(across);
    sine < PAIRED || dot(sub(last.point, first.point), across).abs() < PAIRED * sine
}
