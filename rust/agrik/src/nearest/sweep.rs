//! The postures of a sweep that are nearer to the start values than their neighbours.
//!
//! The branches at all values of the free quantity lie along a few curves. How far they are from
//! the start values has a least value on each arc of these curves: near a posture that is nearer
//! than those next to it.

use super::Nearest;
use crate::chain::Variable;
use crate::closed_form::Branches;
use crate::solve::wound;

/// Values of the free quantity.
pub const VALUES: usize = 64;
/// Most postures that are moved on; the nearest ones.
const MOST: usize = 24;
/// Postures of neighbouring values farther apart in a joint than this are on different arcs, rad
/// or m.
const SAME_ARC: f64 = 1.0;

impl<C> Nearest<'_, C> {
    /// Postures of entry `i` of a sweep that are nearer than their neighbours to the start values
    /// of target `row`, one after the other, the nearest first.
    ///
    /// Postures outside the limits count too, by how far they are outside: between two of them, or
    /// beside the last one, there may be some inside.
    pub(super) fn least_of_sweep(&self, found: &Branches, i: usize, row: usize) -> Vec<f64> {
        let (chain, q0) = (self.request.chain(), self.request.start(row));
        let Some(q0) = q0.filter(|_| self.request.goal(row).is_some()) else { return Vec::new() };
        let (dof, total) = (chain.dof(), found.branches);
        let each = (total / VALUES).max(1);
        // The swept value itself may be whole turns away.
        let mut q = found.q[i * total * dof..(i + 1) * total * dof].to_vec();
        for posture in q.chunks_exact_mut(dof) {
            for ((x, v), about) in posture.iter_mut().zip(chain.variables()).zip(q0) {
                *x = wound(v, *x, *about);
            }
        }
        let reached = &found.reached[i * total..(i + 1) * total];
        let posture = |b: usize| &q[b * dof..(b + 1) * dof];
        let score = |b: usize| {
            let outside = |(x, v): (&f64, &Variable)| {
                let over = x - x.max(v.lower).min(v.upper);
                over * over
            };
            let outside: f64 = posture(b).iter().zip(chain.variables()).map(outside).sum();
            self.far(posture(b), q0) + outside
        };
        let scores: Vec<f64> =
            (0..total).map(|b| if reached[b] { score(b) } else { f64::INFINITY }).collect();
        let apart = |a: usize, b: usize| {
            let ways = posture(a).iter().zip(posture(b)).map(|(x, y)| (x - y).abs());
            ways.fold(0.0, f64::max)
        };
        // The posture of another value on the same arc.
        let beside = |b: usize, value: usize| {
            let there = (value * each..(value + 1) * each).filter(|other| reached[*other]);
            let there = there.map(|other| (apart(b, other), other));
            let next = there.min_by(|x, y| x.0.total_cmp(&y.0));
            next.filter(|(away, _)| *away < SAME_ARC).map(|(_, other)| other)
        };
        let is_least = |b: &usize| {
            let value = b / each;
            let around = [(value + 1) % VALUES, (value + VALUES - 1) % VALUES];
            let nearer = |other: usize| scores[other] < scores[*b];
            reached[*b] && !around.into_iter().any(|value| beside(*b, value).is_some_and(nearer))
        };
        let mut least: Vec<usize> = (0..total).filter(is_least).collect();
        least.sort_by(|a, b| scores[*a].total_cmp(&scores[*b]));
        least.truncate(MOST);
        least.into_iter().flat_map(|b| posture(b).to_vec()).collect()
    }
}
