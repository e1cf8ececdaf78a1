//! Freedom of collisions as what inverse kinematics may ask of its answers.

use std::sync::{Mutex, PoisonError};

use agrik::call::Accept;
use agrik::kinematics::{FRAME, moving_frames};
use agrik_compute::Allowed;
use agrik_compute::lanes::Lanes;

use super::collider::Collider;
use super::placed::Placed;
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
        Ok(Self { collider, clear, objects_keep, rooms: Mutex::default() })
    }

    /// Works in a room of the caller's own; a thread that panicked in one took it along.
    fn with_room<T>(&self, work: impl FnOnce(&mut Placed) -> T) -> T {
        let rooms = || self.rooms.lock().unwrap_or_else(PoisonError::into_inner);
        let free = rooms().pop();
        let mut room = free.unwrap_or_else(|| self.collider.bodies().room());
        let done = work(&mut room);
        rooms().push(room);
        done
    }

    fn at<T>(&self, q: &[f64], ask: impl FnOnce(&Placed) -> T) -> T {
        self.with_room(|placed| {
            self.collider.bodies().place_unchecked(q, placed);
            ask(placed)
        })
    }
}

impl Accept for Free<'_> {
    fn accepts(&self, q: &[f64]) -> Lanes {
        let (bodies, collider) = (self.collider.bodies(), self.collider);
        let chain = bodies.chain();
        let size = FRAME * chain.compiled().links.len();
        self.with_room(|placed| {
            let mut frames = std::mem::take(&mut placed.numbers);
            frames.resize(q.len() / chain.dof() * size, 0.0);
            moving_frames(chain, q, &mut frames);
            let mut accepted = 0;
            for (row, frames) in frames.chunks(size).enumerate() {
                placed.fill(bodies, frames);
                accepted |= Lanes::from(!collider.hits(placed, self.clear)) << row;
            }
            placed.numbers = frames;
            accepted
        })
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
