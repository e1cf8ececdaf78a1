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
pub mod passes;
mod rescue;
mod resultant;

use std::f64::consts::{PI, TAU};

use self::cut::Cut;
use self::passes::{OneCut, Work};
use crate::closed_form::geometry::rigid::Rigid;
use crate::closed_form::geometry::screws::Screws;
use crate::closed_form::geometry::serial::Serial;
use crate::lanes::{Level, dispatch};
use crate::random::Sequence;

/// Most postures of a goal that are kept; sixteen are all that there are, but for singular
/// families.
pub const MOST: usize = 24;
/// Postures nearer to one another are one, rad.
const SAME: f64 = 1e-5;
/// Noise of the samples above which a polynomial is not trusted.
const NOISY: f64 = 1e-9;
/// Poses of random postures that decide between the cuts.
const TRIALS: usize = 400;

/// The postures of one goal.
#[derive(Debug, Clone, Copy)]
pub struct Set {
    /// Joint values, rad, in (-pi, pi].
    pub q: [[f64; 6]; MOST],
    /// How many.
    pub count: usize,
    /// Noise of the polynomial's samples.
    pub noise: f64,
    /// Real roots that are certain.
    pub roots: usize,
    /// Places where there may be roots.
    pub places: usize,
    /// The other cut was asked as well.
    pub second: bool,
}

impl Set {
    /// Nothing found yet.
    pub fn new() -> Self {
        Self { q: [[0.0; 6]; MOST], count: 0, noise: 0.0, roots: 0, places: 0, second: false }
    }

    /// The postures.
    pub fn postures(&self) -> &[[f64; 6]] {
        &self.q[..self.count]
    }

    /// Takes a posture in, unless it is there; true where it is new.
    pub fn add(&mut self, q: &[f64; 6]) -> bool {
        let q = q.map(turned);
        let same = |other: &[f64; 6]| {
            other.iter().zip(&q).all(|(a, b)| turned(a - b).abs() < SAME)
        };
        if self.count == MOST || self.postures().iter().any(same) {
            return false;
        }
        self.q[self.count] = q;
        self.count += 1;
        true
    }

    /// In an order that does not depend on the way they were found.
    pub fn sort(&mut self) {
        self.q[..self.count].sort_by(|a, b| {
            let order = a.iter().zip(b).map(|(x, y)| x.total_cmp(y));
            order.into_iter().find(|o| o.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
        });
    }
}

/// An angle less whole turns, in (-pi, pi].
pub fn turned(x: f64) -> f64 {
    let y = x - TAU * (x / TAU).round();
    if y <= -PI { y + TAU } else { y }
}

/// An arm of six joints that turn.
#[derive(Debug, Clone, PartialEq)]
pub struct Ring {
    serial: Serial<6>,
    cuts: [Cut; 2],
    /// Metres in an arm length.
    length: f64,
}

impl Ring {
    /// The arm; `None` unless it has six joints.
    pub fn new(screws: &Screws) -> Option<Self> {
        let screws = screws.gathered();
        let length = screws.length();
        let scaled = screws.scaled(1.0 / length);
        let serial = Serial::<6>::new(&scaled)?;
        let cuts = [Cut::new(&scaled, true), Cut::new(&scaled, false)];
        let mut ring = Self { serial, cuts, length };
        if ring.prefers_second() {
            ring.cuts.swap(0, 1);
        }
        Some(ring)
    }

    /// Metres in an arm length.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The cut that is asked first reads the arm from its tool.
    pub fn first_is_reversed(&self) -> bool {
        self.cuts[0].reversed
    }

    #[doc(hidden)]
    pub fn debug_one(&self, cut: usize, goals: &[Rigid<f64>]) -> Vec<Set> {
        let scaled: Vec<Rigid<f64>> = goals.iter().map(|goal| self.scaled(goal)).collect();
        let mut sets = vec![Set::new(); goals.len()];
        self.run_cut(Level::in_use(), cut, &scaled, &mut sets, &mut Work::default());
        sets
    }

    /// The arm in arm lengths.
    pub fn serial(&self) -> &Serial<6> {
        &self.serial
    }

    /// A goal in arm lengths.
    pub fn scaled(&self, goal: &Rigid<f64>) -> Rigid<f64> {
        Rigid { axes: goal.axes, shift: goal.shift.map(|x| x / self.length) }
    }

    /// Whether the second cut finds more postures alone: of all those that made the poses, and
    /// then by how often it doubts itself.
    fn prefers_second(&self) -> bool {
        let mut random = Sequence::new(7);
        let goals: Vec<Rigid<f64>> = (0..TRIALS)
            .map(|_| {
                let q: [f64; 6] = std::array::from_fn(|_| TAU * random.uniform() - PI);
                self.serial.forward(&q).0
            })
            .collect();
        let mut work = Work::default();
        let mut score = |cut: usize| {
            let mut sets = vec![Set::new(); goals.len()];
            self.run_cut(Level::in_use(), cut, &goals, &mut sets, &mut work);
            let found: usize = sets.iter().map(|set| set.count).sum();
            let sound = sets.iter().filter(|set| !set.is_doubtful()).count();
            (found, sound)
        };
        score(1) > score(0)
    }

    /// Runs one cut on goals in arm lengths.
    fn run_cut(&self, level: Level, cut: usize, goals: &[Rigid<f64>], sets: &mut [Set], work: &mut Work) {
        let (cut, serial) = (&self.cuts[cut], &self.serial);
        dispatch(level, OneCut { cut, serial, goals, sets, work });
    }

    /// All postures of each goal (in metres).
    pub fn solve(&self, level: Level, goals: &[Rigid<f64>], sets: &mut [Set], work: &mut Work) {
        let scaled: Vec<Rigid<f64>> = goals.iter().map(|goal| self.scaled(goal)).collect();
        self.run_cut(level, 0, &scaled, sets, work);
        let again: Vec<usize> = (0..sets.len()).filter(|i| sets[*i].is_doubtful()).collect();
        if !again.is_empty() {
            let chosen: Vec<Rigid<f64>> = again.iter().map(|i| scaled[*i]).collect();
            let mut second = vec![Set::new(); again.len()];
            self.run_cut(level, 1, &chosen, &mut second, work);
            for (i, other) in again.iter().zip(&second) {
                let set = &mut sets[*i];
                set.noise = set.noise.min(other.noise);
                set.second = true;
                for q in other.postures() {
                    set.add(q);
                }
                if !(set.noise <= NOISY) || set.count % 2 != 0 {
                    self.rescue(level, &scaled[*i], set, work);
                }
            }
        }
        for set in sets.iter_mut() {
            set.sort();
        }
    }
}

impl Set {
    /// Something says that postures may be missing.
    fn is_doubtful(&self) -> bool {
        self.count % 2 != 0 || !(self.noise <= NOISY) || self.count < self.roots
    }
}
