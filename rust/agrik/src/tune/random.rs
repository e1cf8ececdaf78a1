//! Random numbers of a search: one stream per generation and member, so that nothing but
//! the generation's number has to be stored.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// A stream of its own.
pub(super) struct Stream(Xoshiro256PlusPlus);

impl Stream {
    pub fn new(seed: u64, generation: u64, member: u64) -> Self {
        let key = seed ^ generation.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let key = key.rotate_left(23) ^ member.wrapping_mul(0xd1b5_4a32_d192_ed03);
        Self(Xoshiro256PlusPlus::seed_from_u64(key))
    }

    /// Uniform in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Normal with mean 0 and deviation 1 (Box and Muller).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }
}
