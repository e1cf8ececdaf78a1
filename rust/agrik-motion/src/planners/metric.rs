//! How far postures are apart.

use agrik::chain::JointKind;

use crate::Bodies;

/// Distances between postures as lengths in the workspace: a slide counts as it is, a turn as
/// far as it moves what is farthest from its axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Metric {
    weights: Vec<f64>,
}

impl Metric {
    /// Of an arm with bodies.
    pub fn new(bodies: &Bodies) -> Self {
        let (chain, levers) = (bodies.chain(), bodies.levers());
        let (count, size) = (bodies.len(), chain.reach().size);
        let weight = |(joint, v): (usize, &agrik::chain::Variable)| {
            if v.kind == JointKind::Prismatic {
                return 1.0;
            }
            let row = &levers[joint * count..(joint + 1) * count];
            let lever = row.iter().copied().fold(0.0, f64::max);
            // A joint that moves no body, or one behind a slide without ends.
            let known = |x: f64| x > 0.0 && x.is_finite();
            if known(lever) {
                lever
            } else if known(size) {
                size
            } else {
                1.0
            }
        };
        Self { weights: chain.variables().iter().enumerate().map(weight).collect() }
    }

    /// Length of a unit of each joint value, m/rad or no unit.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Distance of two postures, m.
    pub fn between(&self, a: &[f64], b: &[f64]) -> f64 {
        self.square(a, b).sqrt()
    }

    /// Its square, m^2.
    pub fn square(&self, a: &[f64], b: &[f64]) -> f64 {
        let each = a.iter().zip(b).zip(&self.weights);
        each.map(|((a, b), w)| (w * (a - b)) * (w * (a - b))).sum()
    }
}
