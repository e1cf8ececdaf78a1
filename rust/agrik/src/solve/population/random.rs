//! Random numbers for a population: eight interleaved xoshiro256++ generators, so that the
//! numbers of a whole vector are made in step.

use crate::lanes::Real;

/// Generators side by side: the widest vector there is.
const WIDE: usize = 8;
/// Numbers made in one go; a multiple of every vector's width.
const KEPT: usize = 8 * WIDE;
/// Bits of the fraction of a double, and of the number 1.
const FRACTION: u64 = (1 << 52) - 1;
const ONE: u64 = 1.0f64.to_bits();

/// A stream of uniform numbers. What it yields depends on its key and on how it is asked,
/// never on the instruction set.
#[derive(Debug, Clone)]
pub struct Stream {
    state: [[u64; WIDE]; 4],
    fine: Kept,
    coarse: Kept,
}

/// Numbers made but not yet given out.
#[derive(Debug, Clone)]
struct Kept {
    numbers: [f64; KEPT],
    used: usize,
}

impl Kept {
    const EMPTY: Self = Self { numbers: [0.0; KEPT], used: KEPT };

    /// Whether so many are left.
    #[inline(always)]
    fn has(&self, count: usize) -> bool {
        self.used + count <= KEPT
    }

    /// One number per lane.
    #[inline(always)]
    fn take<R: Real>(&mut self) -> R {
        let from = self.used;
        self.used = from + R::WIDTH;
        R::load(&self.numbers[from..from + R::WIDTH])
    }
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
        Self { state, fine: Kept::EMPTY, coarse: Kept::EMPTY }
    }

    /// A number in [0, 1).
    #[inline(always)]
    pub fn uniform(&mut self) -> f64 {
        self.uniforms()
    }

    /// One number in [0, 1) per lane.
    #[inline(always)]
    pub fn uniforms<R: Real>(&mut self) -> R {
        if !self.fine.has(R::WIDTH) {
            self.refill();
        }
        self.fine.take()
    }

    /// One multiple of 2^-32 in [0, 1) per lane: enough for a choice, at half the price.
    #[inline(always)]
    pub fn choices<R: Real>(&mut self) -> R {
        if !self.coarse.has(R::WIDTH) {
            self.refill_coarse();
        }
        self.coarse.take()
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
        for row in self.fine.numbers.as_chunks_mut::<WIDE>().0 {
            words(&mut self.state, row.each_mut(), |word, x| {
                *x = f64::from_bits(word >> 12 | ONE) - 1.0;
            });
        }
        self.fine.used = 0;
    }

    /// Either half of a word makes a number.
    #[inline(always)]
    fn refill_coarse(&mut self) {
        let (first, second) = self.coarse.numbers.split_at_mut(KEPT / 2);
        let rows = first.as_chunks_mut::<WIDE>().0.iter_mut();
        for (first, second) in rows.zip(second.as_chunks_mut::<WIDE>().0) {
            words(&mut self.state, first.iter_mut().zip(second), |word, (x, y)| {
                *x = f64::from_bits(word >> 12 & !0xf_ffff | ONE) - 1.0;
                *y = f64::from_bits(word << 20 & FRACTION | ONE) - 1.0;
            });
        }
        self.coarse.used = 0;
    }
}

/// The next word of every generator, each handed to `put` with its place in `to`.
///
/// The loop is over references into the state, not over copies of it: so the compiler makes
/// vector instructions of it, which are a tenth as many.
#[inline(always)]
fn words<T>(
    state: &mut [[u64; WIDE]; 4],
    to: impl IntoIterator<Item = T>,
    mut put: impl FnMut(u64, T),
) {
    let [a, b, c, d] = state;
    for ((((a, b), c), d), to) in a.iter_mut().zip(b).zip(c).zip(d).zip(to) {
        put(a.wrapping_add(*d).rotate_left(23).wrapping_add(*a), to);
        let t = *b << 17;
        *c ^= *a;
        *d ^= *b;
        *b ^= *c;
        *a ^= *d;
        *c ^= t;
        *d = d.rotate_left(45);
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
        let mut stream = Stream::new(3);
        let chi2 = unevenness(100_000, || stream.choices());
        assert!(chi2 < 43.8, "chi2 {chi2}");
        // Their fine digits are, too.
        let chi2 = unevenness(100_000, || (stream.choices::<f64>() * f64::from(1 << 20)).fract());
        assert!(chi2 < 43.8, "chi2 {chi2}");
    }

    #[test]
    fn choices_have_32_bits() {
        let mut stream = Stream::new(5);
        let scaled: Vec<f64> =
            (0..10_000).map(|_| stream.choices::<f64>() * 2f64.powi(32)).collect();
        assert!(scaled.iter().all(|x| x.fract() == 0.0 && (0.0..2f64.powi(32)).contains(x)));
        let odd = scaled.iter().filter(|x| **x % 2.0 == 1.0).count();
        assert!((4_800..5_200).contains(&odd), "{odd}");
    }

    #[test]
    fn neighbouring_keys_and_lanes_differ() {
        let mut all: Vec<u64> = Vec::new();
        for key in 0..50 {
            let mut stream = Stream::new(key);
            all.extend((0..64).map(|_| stream.uniform().to_bits()));
            all.extend((0..64).map(|_| stream.choices::<f64>().to_bits()));
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
