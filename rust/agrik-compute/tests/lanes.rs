//! Every operation of every lane type of this machine against the same operation on plain
//! doubles: special values, random bits, every mask, every lane.
//!
//! This is the test that Miri and the sanitizers run over the `unsafe` code of `lanes`.

use agrik_compute::lanes::{Kernel, Level, Real, Words, dispatch, dispatch_single};

/// Zeros, numbers of every size with both signs, and what is no number.
const SPECIAL: [f64; 20] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    1.5,
    -2.5,
    0.1,
    -1e4,
    3.0e-9,
    1e155,
    -1e-155,
    5e-324,
    -5e-324,
    2.225_073_858_507_201e-308,
    f64::MIN_POSITIVE,
    f64::MAX,
    f64::MIN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
];

/// Miri is some thousand times slower, and looks at what is done to memory, not at numbers.
const RANDOM: usize = if cfg!(miri) { 16 } else { 200_000 };
const STEP: usize = if cfg!(miri) { 61 } else { 1 };

fn available() -> Vec<Level> {
    Level::ALL.into_iter().filter(|level| level.is_available()).collect()
}

/// All triples of special values, and random bit patterns: of every exponent alike often.
fn triples() -> Vec<[f64; 3]> {
    let n = SPECIAL.len();
    let special = (0..n * n * n).step_by(STEP);
    let mut all: Vec<[f64; 3]> =
        special.map(|i| [SPECIAL[i % n], SPECIAL[i / n % n], SPECIAL[i / (n * n)]]).collect();
    let mut state = 1_u64;
    let mut random = || {
        // splitmix64
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (state ^ state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        f64::from_bits(z ^ z >> 31)
    };
    all.extend((0..RANDOM).map(|_| [random(), random(), random()]));
    all
}

const NAMES: [&str; 22] = [
    "add",
    "sub",
    "mul",
    "div",
    "neg",
    "add_assign",
    "sub_assign",
    "mul_assign",
    "mul_add",
    "sqrt",
    "abs",
    "min",
    "max",
    "round",
    "lt",
    "le",
    "and",
    "or",
    "not both",
    "load",
    "splat",
    "zero",
];

/// What each operation of [`NAMES`] makes of one triple.
#[inline(always)]
fn operations<R: Real>(a: R, b: R, c: R) -> [R; NAMES.len()] {
    let assigned = |change: fn(&mut R, R)| {
        let mut changed = a;
        change(&mut changed, b);
        changed
    };
    let shown = |mask: R::Mask| R::select(mask, a, c);
    let loaded: Vec<f64> = (0..R::WIDTH + 1).map(|i| b.lane(i % R::WIDTH)).collect();
    [
        a + b,
        a - b,
        a * b,
        a / b,
        -a,
        assigned(|x, y| *x += y),
        assigned(|x, y| *x -= y),
        assigned(|x, y| *x *= y),
        a.mul_add(b, c),
        a.sqrt(),
        a.abs(),
        a.min(b),
        a.max(b),
        a.round(),
        shown(a.lt(b)),
        shown(a.le(b)),
        shown(R::and(a.lt(b), b.lt(c))),
        shown(R::or(a.lt(b), b.lt(c))),
        // A mask that comes from numbers is as good as one that comes from bits.
        R::select(R::mask_from_bits(!R::bits(a.le(b)) & ((1 << R::WIDTH) - 1)), a, c),
        R::load(&loaded),
        R::splat(2.5),
        R::zero(),
    ]
}

/// The results of all triples, neighbours in the list side by side in the lanes.
struct Operations<'a>(&'a [[f64; 3]]);

impl Kernel for Operations<'_> {
    type Output = Vec<[f64; NAMES.len()]>;
    #[inline(always)]
    fn run<R: Real>(self) -> Self::Output {
        let mut results = Vec::with_capacity(self.0.len());
        for rows in self.0.chunks(R::WIDTH) {
            let mut operands = [R::zero(); 3];
            for (lane, row) in rows.iter().enumerate() {
                for (operand, x) in operands.iter_mut().zip(row) {
                    operand.set_lane(lane, *x);
                }
            }
            let [a, b, c] = operands;
            let found = operations(a, b, c);
            for lane in 0..rows.len() {
                results.push(std::array::from_fn(|k| found[k].lane(lane)));
            }
        }
        results
    }
}

/// The same bits, or both no number: what is in a NaN is left to the processor.
fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

#[test]
fn every_operation_is_that_of_plain_doubles_in_every_lane() {
    let mut triples = triples();
    let fused_at = NAMES.iter().position(|name| *name == "mul_add").unwrap();
    // With another first element, each triple comes to stand in another lane.
    for shift in 0..if cfg!(miri) { 1 } else { 8 } {
        let mut expected = Operations(&triples).run::<f64>();
        for level in available() {
            if level != Level::Scalar {
                for (row, [a, b, c]) in expected.iter_mut().zip(&triples) {
                    row[fused_at] = f64::mul_add(*a, *b, *c);
                }
            }
            let vector = dispatch(level, Operations(&triples));
            let single = dispatch_single(level, Operations(&triples));
            for (what, found) in [("lanes", vector), ("one lane", single)] {
                assert_eq!(found.len(), expected.len());
                for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
                    for k in 0..NAMES.len() {
                        assert!(
                            same(found[k], expected[k]),
                            "{level:?}, {what}, shift {shift}: {} of {:?}: {} instead of {}",
                            NAMES[k],
                            triples[i],
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

const WORD_NAMES: [&str; 14] = [
    "plus",
    "product",
    "xor",
    "or",
    "up 1",
    "up 48",
    "down 12",
    "down 63",
    "equal fields",
    "fields below",
    "smaller fields",
    "in all fields",
    "rotated",
    "highest bit",
];

/// What each operation of [`WORD_NAMES`] makes of pairs of words.
struct WordOperations<'a>(&'a [[u64; 2]]);

impl Kernel for WordOperations<'_> {
    type Output = Vec<[u64; WORD_NAMES.len()]>;
    #[inline(always)]
    fn run<R: Real>(self) -> Self::Output {
        let mut results = Vec::with_capacity(self.0.len());
        for rows in self.0.chunks(R::WIDTH) {
            // One word more than is wanted: loads and stores leave it alone.
            let (mut a, mut b) = (vec![7; R::WIDTH + 1], vec![9; R::WIDTH + 1]);
            for (lane, row) in rows.iter().enumerate() {
                (a[lane], b[lane]) = (row[0], row[1]);
            }
            let (a, b) = (R::Words::load(&a), R::Words::load(&b));
            let highest = R::select(R::highest_bits(a), R::splat(1.0), R::zero());
            let found = [
                a.plus(b),
                a.product(b),
                a.xor(b),
                a.or(b),
                a.up::<1>(),
                a.up::<48>(),
                a.down::<12>(),
                a.down::<63>(),
                a.equal_fields(b),
                a.fields_below(b),
                a.smaller_fields(b),
                a.in_all_fields(),
                a.rotated::<23, 41>(),
                highest.to_words(),
            ];
            let mut stored = [[0; 9]; WORD_NAMES.len()];
            for (words, found) in stored.iter_mut().zip(found) {
                words[R::WIDTH] = 11;
                found.store(words);
                assert_eq!(words[R::WIDTH], 11);
                // The way through numbers keeps the bits.
                let mut again = [0; 9];
                R::from_words(found).to_words().store(&mut again);
                assert_eq!(again[..R::WIDTH], words[..R::WIDTH]);
            }
            for lane in 0..rows.len() {
                results.push(std::array::from_fn(|k| stored[k][lane]));
            }
        }
        results
    }
}

/// The same by plain arithmetic.
fn word_operations([a, b]: [u64; 2]) -> [u64; WORD_NAMES.len()] {
    let fields = |of: fn(i16, i16) -> u16| {
        let [a, b] = [a.to_le_bytes(), b.to_le_bytes()];
        (0..4).fold(0, |all, k| {
            let field = |bytes: [u8; 8]| i16::from_le_bytes([bytes[2 * k], bytes[2 * k + 1]]);
            all | u64::from(of(field(a), field(b))) << (16 * k)
        })
    };
    [
        a.wrapping_add(b),
        (a & 0xffff_ffff) * (b & 0xffff_ffff),
        a ^ b,
        a | b,
        a << 1,
        a << 48,
        a >> 12,
        a >> 63,
        fields(|a, b| if a == b { 0xffff } else { 0 }),
        fields(|a, b| if a < b { 0xffff } else { 0 }),
        fields(|a, b| a.min(b).cast_unsigned()),
        (a & 0xffff) * 0x0001_0001_0001_0001,
        a.rotate_left(23),
        if a >> 63 == 0 { 0 } else { 1.0_f64.to_bits() },
    ]
}

#[test]
fn every_operation_on_words_is_that_of_plain_words_in_every_lane() {
    let mut pairs: Vec<[u64; 2]> =
        triples().iter().map(|[a, b, _]| [a.to_bits(), b.to_bits()]).collect();
    // Fields that are equal, or next to each other.
    let near: Vec<[u64; 2]> = pairs.iter().map(|[a, _]| [*a, a ^ 0x0001_0000_8000_0000]).collect();
    pairs.extend(near);
    for level in available() {
        for (what, found) in [
            ("lanes", dispatch(level, WordOperations(&pairs))),
            ("one lane", dispatch_single(level, WordOperations(&pairs))),
        ] {
            assert_eq!(found.len(), pairs.len());
            for (found, pair) in found.iter().zip(&pairs) {
                let expected = word_operations(*pair);
                for k in 0..WORD_NAMES.len() {
                    let name = WORD_NAMES[k];
                    assert_eq!(found[k], expected[k], "{level:?}, {what}: {name} of {pair:x?}");
                }
            }
        }
    }
}

/// Counts the lanes of a type after it has turned a square over.
struct Square;

impl Kernel for Square {
    type Output = usize;
    #[inline(always)]
    fn run<R: Real>(self) -> usize {
        // One row more, which stays as it is.
        let mut square = vec![R::splat(-1.0); R::WIDTH + 1];
        for row in 0..R::WIDTH {
            for lane in 0..R::WIDTH {
                square[row].set_lane(lane, (10 * row + lane) as f64);
            }
        }
        R::transpose(&mut square);
        for row in 0..R::WIDTH {
            for lane in 0..R::WIDTH {
                assert_eq!(square[row].lane(lane), (10 * lane + row) as f64);
            }
            assert_eq!(square[R::WIDTH].lane(row), -1.0);
        }
        R::WIDTH
    }
}

#[test]
fn squares_are_turned_over() {
    for level in available() {
        let lanes = dispatch(level, Square);
        assert_eq!(lanes == 1, level == Level::Scalar, "{level:?}: {lanes} lanes");
    }
}

/// Counts the lanes of a type while it checks all its masks.
struct Masks;

impl Kernel for Masks {
    type Output = usize;
    #[inline(always)]
    fn run<R: Real>(self) -> usize {
        let all = 1_u32 << R::WIDTH;
        let (mut a, mut b) = (R::zero(), R::zero());
        for lane in 0..R::WIDTH {
            a.set_lane(lane, 1.0 + lane as f64);
            b.set_lane(lane, -1.0 - lane as f64);
        }
        for bits in 0..all {
            let mask = R::mask_from_bits(bits);
            assert_eq!(R::bits(mask), bits);
            // Bits beyond the lanes do not count.
            assert_eq!(R::bits(R::mask_from_bits(bits | !(all - 1))), bits);
            let chosen = R::select(mask, a, b);
            for lane in 0..R::WIDTH {
                let from = if bits >> lane & 1 != 0 { a } else { b };
                assert_eq!(chosen.lane(lane), from.lane(lane));
            }
            for other in 0..all {
                let second = R::mask_from_bits(other);
                assert_eq!(R::bits(R::and(mask, second)), bits & other);
                assert_eq!(R::bits(R::or(mask, second)), bits | other);
            }
        }
        R::WIDTH
    }
}

#[test]
fn every_mask_keeps_its_bits() {
    for level in available() {
        let lanes = dispatch(level, Masks);
        assert_eq!(lanes == 1, level == Level::Scalar, "{level:?}: {lanes} lanes");
        assert_eq!(dispatch_single(level, Masks), 1);
    }
}

struct Beyond {
    write: bool,
}

impl Kernel for Beyond {
    type Output = f64;
    #[inline(always)]
    fn run<R: Real>(self) -> f64 {
        let mut x = R::splat(1.0);
        if self.write {
            x.set_lane(R::WIDTH, 2.0);
        }
        x.lane(R::WIDTH)
    }
}

#[test]
fn no_lane_beyond_the_last_is_read_or_written() {
    for level in available().into_iter().filter(|level| *level != Level::Scalar) {
        for write in [false, true] {
            let reached = std::panic::catch_unwind(|| dispatch(level, Beyond { write }));
            assert!(reached.is_err(), "{level:?}, write: {write}");
        }
    }
}

struct SinCos<'a>(&'a [f64]);

impl Kernel for SinCos<'_> {
    type Output = Vec<[f64; 2]>;
    #[inline(always)]
    fn run<R: Real>(self) -> Self::Output {
        let mut results = Vec::new();
        for angles in self.0.chunks(R::WIDTH) {
            let mut x = R::zero();
            for (lane, angle) in angles.iter().enumerate() {
                x.set_lane(lane, *angle);
            }
            let (sin, cos) = x.sin_cos();
            results.extend((0..angles.len()).map(|lane| [sin.lane(lane), cos.lane(lane)]));
        }
        results
    }
}

#[test]
fn sine_and_cosine_of_one_and_of_many_lanes_are_the_same() {
    // All quadrants of both signs; how far off they are is the business of `sin_cos.rs`.
    let count = if cfg!(miri) { 40 } else { 100_000 };
    let mut angles: Vec<f64> = (0..count).map(|i| 0.37 * (i - count / 2) as f64 % 1e4).collect();
    angles.extend([0.0, -0.0, 5e-324, f64::NAN, f64::INFINITY, f64::NEG_INFINITY]);
    for level in available() {
        let one = dispatch_single(level, SinCos(&angles));
        let many = dispatch(level, SinCos(&angles));
        for (angle, (one, many)) in angles.iter().zip(one.iter().zip(&many)) {
            assert!(same(one[0], many[0]) && same(one[1], many[1]), "{level:?}: {angle}");
            if angle.is_finite() {
                assert!((one[0].hypot(one[1]) - 1.0).abs() < 1e-15, "{level:?}: {angle}");
            } else {
                assert!(one[0].is_nan() && one[1].is_nan(), "{level:?}: {angle}");
            }
        }
    }
}
