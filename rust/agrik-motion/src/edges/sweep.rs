//! A whole way at a glance: eight places of it in the lanes, before doubles prove the rest.

use agrik::kinematics::frames_abreast;
use agrik_compute::lanes::WIDEST;
use agrik_solids::outline::single_above;

use super::certifier::Certifier;
use super::mover::{Asked, Bound};
use crate::body::{Bends, PARTS, Sifted};

/// What is seen of a crowd must not depend on what was asked before: its field is made at once.
const NOW: usize = usize::MAX;

/// Memory for a glance.
#[derive(Debug)]
pub(super) struct Glance {
    sifted: Sifted,
    q: Vec<f64>,
    /// Self pairs, the nearer body first.
    pairs: Vec<(usize, usize)>,
    of_bodies: Vec<f32>,
    of_pairs: Vec<f32>,
    moves: Vec<f32>,
}

impl Glance {
    pub fn new(sifted: Sifted, pairs: Vec<(usize, usize)>, bodies: usize) -> Self {
        let each = vec![0.0; pairs.len()];
        let of_bodies = vec![0.0; bodies];
        Self { sifted, q: Vec::new(), of_pairs: each.clone(), moves: each, pairs, of_bodies }
    }
}

impl Certifier<'_> {
    /// Proves as much of a way free as can be seen from eight places of it; what is left open are
    /// the movers in `left`. Where a mover is found too near to something, which and where.
    pub(super) fn glance(&mut self, from: &[f64], to: &[f64]) -> Option<(usize, f64)> {
        let (collider, links) = (self.collider, self.links());
        let keep = (self.keep().clear, self.keep().own);
        let stands = from == to;
        let glance = &mut self.glance;
        glance.q.clear();
        for place in 0..if stands { 1 } else { WIDEST } {
            let share = place as f64 / PARTS;
            glance.q.extend(from.iter().zip(to).map(|(a, b)| a + share * (b - a)));
        }
        frames_abreast(collider.bodies().chain(), &glance.q, &mut glance.sifted.frames);
        let mut pairs = glance.of_pairs.iter_mut().zip(&mut glance.moves);
        for mover in &self.movers {
            let (Asked::Body(body) | Asked::Pair(_, body)) = mover.asked;
            let levers = collider.bodies().lasting_levers(body);
            let bound = Bound::new(&links[..mover.to], mover.from, levers, &self.rates);
            let (bend, moves) = (bound.curving / (8.0 * PARTS * PARTS), 0.5 * bound.rate / PARTS);
            match mover.asked {
                Asked::Body(body) => glance.of_bodies[body] = above(bend),
                Asked::Pair(..) => {
                    if let Some(pair) = pairs.next() {
                        (*pair.0, *pair.1) = (above(bend), above(moves));
                    }
                }
            }
        }
        let (bodies, moves) = (&glance.of_bodies[..], &glance.moves[..]);
        let way = Bends { bodies, pairs: &glance.of_pairs, moves };
        // What is told to be kept holds for pairs as well.
        let told = (keep.0, keep.0.max(keep.1));
        collider.sift(&mut glance.sifted, told, &glance.pairs, NOW, Some(way), false);
        self.left.clear();
        self.left.extend(glance.sifted.maybe.iter().map(|(mover, _)| *mover));
        if self.left.is_empty() {
            return None;
        }
        // What is too near at one of the places is found at less cost than by proofs.
        if !stands {
            collider.sift(&mut glance.sifted, keep, &glance.pairs, NOW, None, false);
        }
        let lanes = if stands { 1 } else { WIDEST };
        let hit = |lane| {
            let mover = collider.hits_in_lane(&glance.sifted, lane, keep)?;
            Some((mover, lane as f64 / PARTS))
        };
        (0..lanes).find_map(hit)
    }
}

/// A bound in singles; what is no number is no bound.
fn above(bound: f64) -> f32 {
    if bound.is_finite() { single_above(bound * (1.0 + 1e-9) + 1e-12) } else { f32::INFINITY }
}
