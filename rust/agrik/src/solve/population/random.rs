//! Random numbers for a population: eight interleaved xoshiro256++ generators, so that the
//! numbers of a whole vector are made in step.

use crate::lanes::Real;

/// Generators side by side: the widest vector there is.
const WIDE: usize = 8;
/// Numbers made in one go; a multiple of every vector's width.
const KEPT: usize = 8 * WIDE;

/// A stream of uniform numbers. What it yields depends on its key and on how it is asked,
/// never on the instruction set.
#[derive(Debug, Clone)]
pub struct Stream {
    state: [[u64; WIDE]; 4],
    kept: [f64; KEPT],
    used: usize,
}

impl Stream {
    /// The stream of a key.
    pub fn new(key: u64) -> Self {
        let mut state = [[0; WIDE]; 4];
        let mut x = key;
        for word in state.iter_mut().flatten() {
            // SplitMix64, which xoshiro's authors recommend for seeding.
            x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = x;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            *word = z ^ (z >> 31);
        }
        Self { state, kept: [0.0; KEPT], used: KEPT }
    }

    /// A number in [0, 1).
    #[inline(always)]
    pub fn uniform(&mut self) -> f64 {
        if self.used == KEPT {
            self.refill();
        }
        let x = self.kept[self.used];
        self.used += 1;
        x
    }

    /// One number in [0, 1) per lane.
    #[inline(always)]
    pub fn uniforms<R: Real>(&mut self) -> R {
        if self.used + R::WIDTH > KEPT {
            self.refill();
        }
        let from = &self.kept[self.used..self.used + R::WIDTH];
        self.used += R::WIDTH;
        R::load(from)
    }

    /// A whole number below `n`, which is small beside 2^52.
    #[inline(always)]
    pub fn below(&mut self, n: usize) -> usize {
        // The product may round up to `n` itself.
        ((self.uniform() * n as f64) as usize).min(n - 1)
    }

    /// A number of the standard normal distribution (Marsaglia's polar method).
    pub fn normal(&mut self) -> f64 {
        loop {
            let (u, v) = (2.0 * self.uniform() - 1.0, 2.0 * self.uniform() - 1.0);
            let s = u * u + v * v;
            if s > 0.0 && s < 1.0 {
                return u * (-2.0 * s.ln() / s).sqrt();
            }
        }
    }

    /// A number of the Cauchy distribution about zero with scale one.
    pub fn cauchy(&mut self) -> f64 {
        (std::f64::consts::PI * (self.uniform() - 0.5)).tan()
    }

    #[inline(always)]
    fn refill(&mut self) {
        let [mut a, mut b, mut c, mut d] = self.state;
        for row in self.kept.chunks_exact_mut(WIDE) {
            for i in 0..WIDE {
                let word = a[i].wrapping_add(d[i]).rotate_left(23).wrapping_add(a[i]);
                // 52 bits as the fraction of a number in [1, 2).
                row[i] = f64::from_bits(word >> 12 | 1.0f64.to_bits()) - 1.0;
                let t = b[i] << 17;
                c[i] ^= a[i];
                d[i] ^= b[i];
                b[i] ^= c[i];
                a[i] ^= d[i];
                c[i] ^= t;
                d[i] = d[i].rotate_left(45);
            }
        }
        self.state = [a, b, c, d];
        self.used = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_uniform() {
        let mut stream = Stream::new(3);
        let n = 100_000;
        let mut bins = [0u32; 20];
        for _ in 0..n {
            bins[(stream.uniform() * 20.0) as usize] += 1;
        }
        let expected = f64::from(n) / 20.0;
        let chi2: f64 = bins.iter().map(|b| (f64::from(*b) - expected).powi(2) / expected).sum();
        // 19 degrees of freedom: above 43.8 once in a thousand streams.
        assert!(chi2 < 43.8, "chi2 {chi2}");
    }

    #[test]
    fn neighbouring_keys_and_lanes_differ() {
        let mut all: Vec<u64> = Vec::new();
        for key in 0..50 {
            let mut stream = Stream::new(key);
            all.extend((0..64).map(|_| stream.uniform().to_bits()));
        }
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 50 * 64);
    }

    #[test]
    fn normal_numbers_have_mean_zero_and_variance_one() {
        let mut stream = Stream::new(9);
        let x: Vec<f64> = (0..50_000).map(|_| stream.normal()).collect();
        let mean = x.iter().sum::<f64>() / 50_000.0;
        let variance = x.iter().map(|v| v * v).sum::<f64>() / 50_000.0;
        assert!(mean.abs() < 0.02 && (variance - 1.0).abs() < 0.03, "{mean} {variance}");
    }
}
