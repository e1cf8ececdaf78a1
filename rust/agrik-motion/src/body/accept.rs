//! Freedom of collisions as what inverse kinematics may ask of its answers.

use std::sync::{Mutex, MutexGuard, PoisonError};

use agrik::call::Accept;
use agrik_compute::Allowed;
use agrik_compute::lanes::{Lanes, WIDEST};

use super::collider::Collider;
use super::placed::Placed;
use super::sieve::Sifted;
use crate::Result;

/// Accepts postures that are free: farther than a distance from everything, and with no two
/// bodies in contact.
#[derive(Debug)]
pub struct Free<'a> {
    collider: &'a Collider,
    clear: f64,
    /// Some objects want more distance than that.
    objects_keep: bool,
    /// Rooms that nobody uses at the moment.
    rooms: Mutex<Vec<Placed>>,
    sifted: Mutex<Vec<Sifted>>,
}

/// Rooms of one kind; a thread that panicked in one took it along.
fn held<T>(rooms: &Mutex<Vec<T>>) -> MutexGuard<'_, Vec<T>> {
    rooms.lock().unwrap_or_else(PoisonError::into_inner)
}

/// One of them.
fn taken<T>(rooms: &Mutex<Vec<T>>) -> Option<T> {
    held(rooms).pop()
}

impl<'a> Free<'a> {
    /// Accepts what is more than `clear` (m) away from the scene.
    ///
    /// # Errors
    ///
    /// `clear` is no finite number of 0 or more.
    pub fn new(collider: &'a Collider, clear: f64) -> Result<Self> {
        Allowed::NOT_NEGATIVE.check("clear", clear)?;
        let objects_keep = collider.scene().objects().iter().any(|o| o.clearance > clear);
        Ok(Self {
            collider,
            clear,
            objects_keep,
            rooms: Mutex::default(),
            sifted: Mutex::default(),
        })
    }

    fn at<T>(&self, q: &[f64], ask: impl FnOnce(&Placed) -> T) -> T {
        let mut room = taken(&self.rooms).unwrap_or_else(|| self.collider.bodies().room());
        self.collider.bodies().place_unchecked(q, &mut room);
        let answer = ask(&room);
        held(&self.rooms).push(room);
        answer
    }
}

impl Accept for Free<'_> {
    fn accepts(&self, q: &[f64]) -> Lanes {
        let eight = WIDEST * self.collider.bodies().chain().dof();
        let mut room = taken(&self.sifted).unwrap_or_else(|| self.collider.sifted());
        let mut accepted = 0;
        for (group, q) in q.chunks(eight).enumerate() {
            let hits = self.collider.hits_together(q, self.clear, 1, &mut room);
            let all = Lanes::MAX >> (Lanes::BITS as usize - q.len() * WIDEST / eight);
            accepted |= (!hits & all) << (group * WIDEST);
        }
        held(&self.sifted).push(room);
        accepted
    }

    fn margin(&self, q: &[f64], cap: f64) -> f64 {
        self.at(q, |placed| {
            let scene = self.collider.clearance(placed, cap + self.clear, false) - self.clear;
            let margin = self.collider.own_clearance(placed, scene.min(cap));
            let too_near = || self.collider.hits_scene(placed, self.clear);
            if self.objects_keep && margin > 0.0 && too_near() { 0.0 } else { margin }
        })
    }

    fn slope(&self, q: &[f64], rates: &mut [f64]) -> f64 {
        self.at(q, |placed| {
            let scene = self.collider.nearest_of_all(placed, f64::INFINITY, false);
            let margin = scene.map_or(f64::INFINITY, |found| found.distance - self.clear);
            let pair = self.collider.nearest_pair(placed, margin);
            rates.fill(0.0);
            if let Some(found) = pair.or(scene) {
                rates.copy_from_slice(&self.collider.gradient(placed, &found));
            }
            pair.map_or(margin, |pair| pair.distance)
        })
    }

    /// The midpoint rule: a body that is farther away in the middle than it moves on either
    /// half of the way meets nothing.
    fn is_way_sure(&self, q: &[f64], change: &[f64]) -> bool {
        let half: Vec<f64> = change.iter().map(|dq| 0.5 * dq).collect();
        let middle: Vec<f64> = q.iter().zip(&half).map(|(x, dq)| x + dq).collect();
        let (bodies, collider) = (self.collider.bodies(), self.collider);
        self.at(&middle, |placed| {
            let levers = bodies.local_levers(placed, &half);
            let scene = |body: usize| {
                bodies.moved_by(body) == 0 || {
                    let bound = bodies.motion_bound(&levers, body, &half);
                    !collider.body_hits(placed, body, self.clear + bound)
                }
            };
            let apart = |pair: &(usize, usize)| {
                let bound = bodies.pair_bound(&levers, *pair, &half);
                !collider.pair_within(placed, *pair, bound)
            };
            (0..bodies.len()).all(scene) && bodies.self_pairs().iter().all(apart)
        })
    }
}
