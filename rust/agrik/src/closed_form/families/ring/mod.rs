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

use std::f64::consts::{PI, TAU};

use self::cut::Cut;
use self::passes::OneCut;
pub use self::passes::Work;
use super::postures::Set;
use crate::closed_form::geometry::rigid::Rigid;
use crate::closed_form::geometry::screws::Screws;
use crate::closed_form::geometry::serial::Serial;
use crate::lanes::{Level, dispatch};
use crate::random::Sequence;

/// Noise of the samples above which a polynomial is not trusted.
const NOISY: f64 = 1e-9;
/// Poses of random postures that decide between the cuts.
const TRIALS: usize = 128;

/// An arm of six joints that turn.
#[derive(Debug, Clone, PartialEq)]
pub struct Ring {
    serial: Serial<6>,
    cuts: [Cut; 2],
    /// Metres in an arm length.
    length: f64,
}

impl Ring {
    /// The arm; `None` unless it has six joints. Which cut is asked first is found out by trials
    /// unless `reversed` says it.
    pub fn new(screws: &Screws, reversed: Option<bool>) -> Option<Self> {
        let screws = screws.gathered();
        let length = screws.length();
        let scaled = screws.scaled(1.0 / length);
        let serial = Serial::<6>::new(&scaled)?;
        let cuts = [Cut::new(&scaled, true), Cut::new(&scaled, false)];
        let mut ring = Self { serial, cuts, length };
        if reversed.map_or_else(|| ring.prefers_second(), |reversed| !reversed) {
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
            let sound = sets.iter().filter(|set| !is_doubtful(set)).count();
            (found, sound)
        };
        score(1) > score(0)
    }

    /// Runs one cut on goals in arm lengths.
    fn run_cut(
        &self,
        level: Level,
        cut: usize,
        goals: &[Rigid<f64>],
        sets: &mut [Set],
        work: &mut Work,
    ) {
        let (cut, serial) = (&self.cuts[cut], &self.serial);
        dispatch(level, OneCut { cut, serial, goals, sets, work });
    }

    /// All postures of each goal (in metres).
    pub fn solve(&self, level: Level, goals: &[Rigid<f64>], sets: &mut [Set], work: &mut Work) {
        let scaled: Vec<Rigid<f64>> = goals.iter().map(|goal| self.scaled(goal)).collect();
        self.run_cut(level, 0, &scaled, sets, work);
        let again: Vec<usize> = (0..sets.len()).filter(|i| is_doubtful(&sets[*i])).collect();
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

/// Something says that postures may be missing.
fn is_doubtful(set: &Set) -> bool {
    set.count % 2 != 0 || !(set.noise <= NOISY) || set.count < set.places
}
