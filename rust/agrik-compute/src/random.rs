//! Random numbers that depend on a key alone: a [`Sequence`] of plain numbers, and a
//! [`Stream`] of eight interleaved generators that makes the words of a whole vector in step.
//! Both are xoshiro256++ (Blackman and Vigna 2021).

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use crate::lanes::{Real, Words};

/// The finaliser of SplitMix64 (Steele, Lea and Flood 2014): spreads every bit over all.
pub fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// One number after the other.
#[derive(Debug, Clone)]
pub struct Sequence(Xoshiro256PlusPlus);

impl Sequence {
    /// The sequence of a key.
    pub fn new(key: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(key))
    }

    /// 64 random bits.
    #[inline]
    pub fn word(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// A number in [0, 1) with 53 random bits.
    #[inline]
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// A number of the standard normal distribution (Box and Muller).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// Generators side by side: the widest vector there is.
const WIDE: usize = 8;
/// Words made in one go; a multiple of every vector's width.
const KEPT: usize = 16 * WIDE;
/// Bits of the number 1.
const ONE: u64 = 1.0f64.to_bits();

/// A stream of random words. What it yields depends on its key and on how it is asked,
/// never on the instruction set.
#[derive(Debug, Clone)]
pub struct Stream {
    state: [[u64; WIDE]; 4],
    /// Words made but not yet given out.
    kept: [u64; KEPT],
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
            *word = mix(x);
        }
        Self { state, kept: [0; KEPT], used: KEPT }
    }

    /// One word per lane, all its bits even.
    #[inline(always)]
    pub fn words<W: Words>(&mut self) -> W {
        if self.used + W::WIDTH > KEPT {
            self.refill::<W>();
        }
        let from = self.used;
        self.used = from + W::WIDTH;
        W::load(&self.kept[from..])
    }

    /// A number in [0, 1).
    #[inline(always)]
    pub fn uniform(&mut self) -> f64 {
        self.uniforms()
    }

    /// One number in [0, 1) per lane.
    #[inline(always)]
    pub fn uniforms<R: Real>(&mut self) -> R {
        let words: R::Words = self.words();
        R::from_words(words.down::<12>().or(R::Words::splat(ONE))) - R::splat(1.0)
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
    fn refill<W: Words>(&mut self) {
        for first in (0..WIDE).step_by(W::WIDTH) {
            let mut a = W::load(&self.state[0][first..]);
            let mut b = W::load(&self.state[1][first..]);
            let mut c = W::load(&self.state[2][first..]);
            let mut d = W::load(&self.state[3][first..]);
            for row in self.kept.as_chunks_mut::<WIDE>().0 {
                a.plus(d).rotated::<23, 41>().plus(a).store(&mut row[first..]);
                let t = b.up::<17>();
                c = c.xor(a);
                d = d.xor(b);
                b = b.xor(c);
                a = a.xor(d);
                c = c.xor(t);
                d = d.rotated::<45, 19>();
            }
            a.store(&mut self.state[0][first..]);
            b.store(&mut self.state[1][first..]);
            c.store(&mut self.state[2][first..]);
            d.store(&mut self.state[3][first..]);
        }
        self.used = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Squared deviation of the counts in 20 bins from even ones.
    fn unevenness(n: u32, mut draw: impl FnMut() -> f64) -> f64 {
        let mut bins = [0u32; 20];
        for _ in 0..n {
            bins[(draw() * 20.0) as usize] += 1;
        }
        let expected = f64::from(n) / 20.0;
        bins.iter().map(|b| (f64::from(*b) - expected).powi(2) / expected).sum()
    }

    #[test]
    fn numbers_are_uniform() {
        // 19 degrees of freedom: above 43.8 once in a thousand streams.
        let mut stream = Stream::new(3);
        let chi2 = unevenness(100_000, || stream.uniform());
        assert!(chi2 < 43.8, "chi2 {chi2}");
        // Their fine digits are, too.
        let chi2 = unevenness(100_000, || (stream.uniform() * 2f64.powi(40)).fract());
        assert!(chi2 < 43.8, "chi2 {chi2}");
        // So is every field of a word of which 16 bits are used alone.
        for field in 0..4 {
            let chi2 = unevenness(100_000, || {
                f64::from((stream.words::<u64>() >> (16 * field)) as u16) / 65_536.0
            });
            assert!(chi2 < 43.8, "field {field}: chi2 {chi2}");
        }
    }

    #[test]
    fn words_are_those_of_the_published_generator() {
        // xoshiro256++ as its authors print it, eight of them in turns.
        let seeded = Stream::new(5);
        let mut states: Vec<[u64; 4]> =
            (0..WIDE).map(|g| [0, 1, 2, 3].map(|i| seeded.state[i][g])).collect();
        let mut stream = seeded.clone();
        for turn in 0..1000 {
            let s = &mut states[turn % WIDE];
            let expected = s[0].wrapping_add(s[3]).rotate_left(23).wrapping_add(s[0]);
            let t = s[1] << 17;
            s[2] ^= s[0];
            s[3] ^= s[1];
            s[1] ^= s[2];
            s[0] ^= s[3];
            s[2] ^= t;
            s[3] = s[3].rotate_left(45);
            assert_eq!(stream.words::<u64>(), expected);
        }
    }

    #[test]
    fn neighbouring_keys_and_lanes_differ() {
        let mut all: Vec<u64> = Vec::new();
        for key in 0..50 {
            let mut stream = Stream::new(key);
            all.extend((0..128).map(|_| stream.uniform().to_bits()));
        }
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 50 * 128);
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
