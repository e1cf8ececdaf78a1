//! Start points: a random stream of its own for every target and attempt.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use crate::chain::{JointKind, Variable};

/// Draws start points. A target's stream depends on the seed, the target's index and the
/// attempt alone, so that answers do not depend on slices, lanes or threads.
#[derive(Debug, Clone)]
pub struct Sampler {
    seed: u64,
    first_index: u64,
    /// Lower end and width per joint value; continuous joints sample [-pi, pi].
    ranges: Vec<(f64, f64)>,
}

impl Sampler {
    /// A sampler over the joints' limits.
    pub fn new(variables: &[Variable], seed: u64, first_index: u64) -> Self {
        use std::f64::consts::{PI, TAU};
        let range = |v: &Variable| match v.kind {
            JointKind::Continuous => (-PI, TAU),
            _ => (v.lower, v.upper - v.lower),
        };
        Self { seed, first_index, ranges: variables.iter().map(range).collect() }
    }

    /// The start of attempt `attempt` at target `row`.
    pub fn sample(&self, row: usize, attempt: u32, q: &mut [f64]) {
        let index = self.first_index.wrapping_add(row as u64);
        let key = mix(mix(self.seed ^ 0x9e37_79b9_7f4a_7c15) ^ index) ^ u64::from(attempt);
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(mix(key));
        for (x, (lower, width)) in q.iter_mut().zip(&self.ranges) {
            *x = width.mul_add(uniform(&mut stream), *lower);
        }
    }
}

/// A number in [0, 1) with 53 random bits.
fn uniform(stream: &mut Xoshiro256PlusPlus) -> f64 {
    (stream.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

/// The finaliser of SplitMix64 (Steele, Lea and Flood 2014): spreads every bit over all.
fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
