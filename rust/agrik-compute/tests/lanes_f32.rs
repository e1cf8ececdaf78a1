//! Every operation of every lane type of singles against the same operation on plain
//! singles: special values, random bits, every mask.
//!
//! Miri and the sanitizers run this over the `unsafe` code of `lanes`, as they do `lanes.rs`.

use agrik_compute::lanes::{Kernel32, Level, Real32, dispatch_eights, dispatch_singles};

/// Zeros, numbers of every size with both signs, and what is no number.
const SPECIAL: [f32; 20] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    1.5,
    -2.5,
    0.1,
    -1e4,
    3.0e-9,
    1e19,
    -1e-19,
    1e-45,
    -1e-45,
    1.175_494_2e-38,
    f32::MIN_POSITIVE,
    f32::MAX,
    f32::MIN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
];

/// Miri is some thousand times slower, and looks at what is done to memory, not at numbers.
const RANDOM: usize = if cfg!(miri) { 16 } else { 200_000 };
const STEP: usize = if cfg!(miri) { 61 } else { 1 };

fn available() -> Vec<Level> {
    Level::ALL.into_iter().filter(|level| level.is_available()).collect()
}

/// All triples of special values, and random bit patterns: of every exponent alike often.
fn triples() -> Vec<[f32; 3]> {
    let n = SPECIAL.len();
    let special = (0..n * n * n).step_by(STEP);
    let mut all: Vec<[f32; 3]> =
        special.map(|i| [SPECIAL[i % n], SPECIAL[i / n % n], SPECIAL[i / (n * n)]]).collect();
    let mut state = 1_u64;
    let mut random = || {
        // splitmix64
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (state ^ state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        f32::from_bits((z >> 32) as u32)
    };
    all.extend((0..RANDOM).map(|_| [random(), random(), random()]));
    all
}

const NAMES: [&str; 16] = [
    "add", "sub", "mul", "div", "neg", "mul_add", "sqrt", "abs", "min", "max", "lt", "le", "and",
    "or", "splat", "stored",
];

/// What each operation of [`NAMES`] makes of one triple.
#[inline(always)]
fn operations<R: Real32>(a: R, b: R, c: R) -> [R; NAMES.len()] {
    let shown = |mask: R::Mask| R::select(mask, a, c);
    let mut stored = vec![7.0; R::WIDTH + 1];
    b.store(&mut stored);
    assert_eq!(stored[R::WIDTH], 7.0);
    [
        a + b,
        a - b,
        a * b,
        a / b,
        -a,
        a.mul_add(b, c),
        a.sqrt(),
        a.abs(),
        a.min(b),
        a.max(b),
        shown(a.lt(b)),
        shown(a.le(b)),
        shown(R::and(a.lt(b), b.lt(c))),
        shown(R::or(a.lt(b), b.lt(c))),
        R::splat(0.1),
        R::load(&stored),
    ]
}

/// The same on plain singles.
fn expected([a, b, c]: [f32; 3], fused: bool) -> [f32; NAMES.len()] {
    let shown = |mask: bool| if mask { a } else { c };
    [
        a + b,
        a - b,
        a * b,
        a / b,
        -a,
        if fused { a.mul_add(b, c) } else { a * b + c },
        a.sqrt(),
        a.abs(),
        if a < b { a } else { b },
        if a > b { a } else { b },
        shown(a < b),
        shown(a <= b),
        shown(a < b && b < c),
        shown(a < b || b < c),
        0.1,
        b,
    ]
}

/// The results of all triples, neighbours in the list side by side in the lanes.
struct Operations<'a>(&'a [[f32; 3]]);

impl Kernel32 for Operations<'_> {
    type Output = (usize, Vec<[f32; NAMES.len()]>);
    #[inline(always)]
    fn run<R: Real32>(self) -> Self::Output {
        let mut results = Vec::with_capacity(self.0.len());
        for rows in self.0.chunks(R::WIDTH) {
            let mut operands = [const { [0.0; 16] }; 3];
            for (lane, row) in rows.iter().enumerate() {
                for (operand, x) in operands.iter_mut().zip(row) {
                    operand[lane] = *x;
                }
            }
            let [a, b, c] = &operands;
            let mut found = [[0.0; 16]; NAMES.len()];
            for (to, value) in found.iter_mut().zip(operations(R::load(a), R::load(b), R::load(c)))
            {
                value.store(to);
            }
            for lane in 0..rows.len() {
                results.push(std::array::from_fn(|k| found[k][lane]));
            }
        }
        (R::WIDTH, results)
    }
}

/// The same bits, or both no number: what is in a NaN is left to the processor.
fn same(a: f32, b: f32) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

#[test]
fn every_operation_is_that_of_plain_singles_in_every_lane() {
    let mut triples = triples();
    // With another first element, each triple comes to stand in another lane.
    for shift in 0..if cfg!(miri) { 1 } else { 16 } {
        for level in available() {
            let widest = dispatch_singles(level, Operations(&triples));
            let eights = dispatch_eights(level, Operations(&triples));
            assert_eq!(widest.0, if level == Level::Avx512 { 16 } else { 8 });
            assert_eq!(eights.0, 8);
            for (lanes, found) in [widest, eights] {
                assert_eq!(found.len(), triples.len());
                for (found, triple) in found.iter().zip(&triples) {
                    let expected = expected(*triple, level != Level::Scalar);
                    for k in 0..NAMES.len() {
                        assert!(
                            same(found[k], expected[k]),
                            "{level:?}, {lanes} lanes, shift {shift}: {} of {triple:?}: {} \
                             instead of {}",
                            NAMES[k],
                            found[k],
                            expected[k]
                        );
                    }
                }
            }
        }
        triples.rotate_left(1);
    }
}

/// Checks all masks of a lane type, and gives their number.
struct Masks;

impl Kernel32 for Masks {
    type Output = u32;
    #[inline(always)]
    fn run<R: Real32>(self) -> u32 {
        let all = 1_u32 << R::WIDTH;
        let half = R::splat(0.5);
        let lanes = |bits: u32, low: f32, high: f32| {
            let mut numbers = [0.0; 16];
            for (lane, x) in numbers.iter_mut().enumerate() {
                *x = if bits >> lane & 1 != 0 { low } else { high };
            }
            R::load(&numbers)
        };
        let step = if cfg!(miri) { 29 } else { 1 };
        for bits in (0..all).step_by(step) {
            let mask = lanes(bits, 0.0, 1.0).lt(half);
            assert_eq!(R::bits(mask), bits);
            let mut chosen = [0.0; 16];
            R::select(mask, R::splat(3.0), R::splat(4.0)).store(&mut chosen);
            for lane in 0..R::WIDTH {
                assert_eq!(chosen[lane], if bits >> lane & 1 != 0 { 3.0 } else { 4.0 });
            }
            for other in [0, 1, 0x5555, 0xaaaa, bits.wrapping_mul(0x9e37), all - 1] {
                let second = lanes(other, 0.0, 1.0).le(half);
                assert_eq!(R::bits(R::and(mask, second)), bits & other & (all - 1));
                assert_eq!(R::bits(R::or(mask, second)), (bits | other) & (all - 1));
            }
        }
        all
    }
}

#[test]
fn every_mask_keeps_its_bits() {
    for level in available() {
        let widest = if level == Level::Avx512 { 16 } else { 8 };
        assert_eq!(dispatch_singles(level, Masks), 1 << widest, "{level:?}");
        assert_eq!(dispatch_eights(level, Masks), 1 << 8, "{level:?}");
    }
}

struct Short {
    write: bool,
}

impl Kernel32 for Short {
    type Output = ();
    #[inline(always)]
    fn run<R: Real32>(self) {
        let mut short = vec![0.0; R::WIDTH - 1];
        if self.write {
            R::splat(1.0).store(&mut short);
        } else {
            R::load(&short).store(&mut [0.0; 16]);
        }
    }
}

#[test]
fn nothing_beyond_the_end_of_a_slice_is_read_or_written() {
    for level in available() {
        for write in [false, true] {
            for dispatch in [dispatch_singles::<Short>, dispatch_eights::<Short>] {
                let reached = std::panic::catch_unwind(|| dispatch(level, Short { write }));
                assert!(reached.is_err(), "{level:?}, write: {write}");
            }
        }
    }
}
