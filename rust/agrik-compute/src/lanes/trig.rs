//! Sine, cosine and the angle of a rotation, as polynomials over [`Real`].
//!
//! Kernel coefficients of sine and cosine on [-pi/4, pi/4] are those of fdlibm
//! (Sun Microsystems, freely usable); the quotient acos(c) / sin(acos(c)) is a
//! Chebyshev fit of our own, made with 40-digit arithmetic.

use super::Real;

/// Adding and subtracting this number rounds a double of magnitude below 2^51 to the
/// nearest integer, in any rounding mode of SSE and AVX that programs use.
const ROUND: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52

/// Pi/2 in three parts; the first two have 33 bits, so that their product with a
/// quarter-turn count below 2^20 is exact.
const HALF_PI: [f64; 3] =
    [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21];

/// Nearest integer of a number of magnitude below 2^51.
#[inline(always)]
pub(super) fn round_small<R: Real>(x: R) -> R {
    (x + R::splat(ROUND)) - R::splat(ROUND)
}

/// The quarter turns nearest to an angle, as a number and as the low bits of another.
#[inline(always)]
fn quarter_turns<R: Real>(x: R) -> (R, R) {
    let counted = x.mul_add(R::splat(std::f64::consts::FRAC_2_PI), R::splat(ROUND));
    (counted - R::splat(ROUND), counted)
}

/// `x - quarter_turns * pi / 2`, accurate to the last place for |x| <= 1e4.
#[inline(always)]
fn reduce<R: Real>(x: R, quarter_turns: R) -> R {
    let r = quarter_turns.mul_add(R::splat(-HALF_PI[0]), x);
    let r = quarter_turns.mul_add(R::splat(-HALF_PI[1]), r);
    quarter_turns.mul_add(R::splat(-HALF_PI[2]), r)
}

/// Horner's rule, highest power first.
#[inline(always)]
fn horner<R: Real, const N: usize>(x: R, coefficients: [f64; N]) -> R {
    let mut sum = R::splat(coefficients[0]);
    for &c in &coefficients[1..] {
        sum = sum.mul_add(x, R::splat(c));
    }
    sum
}

/// Sine and cosine for |r| <= pi/4.
#[inline(always)]
fn reduced_sin_cos<R: Real>(r: R) -> (R, R) {
    const SIN: [f64; 6] = [
        1.589_690_995_211_55e-10,
        -2.505_076_025_340_686_3e-8,
        2.755_731_370_707_006_8e-6,
        -1.984_126_982_985_795e-4,
        8.333_333_333_322_49e-3,
        -1.666_666_666_666_663_2e-1,
    ];
    const COS: [f64; 6] = [
        -1.135_964_755_778_819_5e-11,
        2.087_572_321_298_175e-9,
        -2.755_731_435_139_066_3e-7,
        2.480_158_728_947_673e-5,
        -1.388_888_888_887_411e-3,
        4.166_666_666_666_66e-2,
    ];
    let r2 = r * r;
    let sin = (r2 * r).mul_add(horner(r2, SIN), r);
    // 1 - r2/2 loses a bit where r2 is near 1/2; carrying its rounding error back
    // keeps the cosine within one unit in the last place.
    let half = R::splat(0.5) * r2;
    let w = R::splat(1.0) - half;
    let lost = (R::splat(1.0) - w) - half;
    let cos = w + (r2 * r2).mul_add(horner(r2, COS), lost);
    (sin, cos)
}

/// Sine and cosine of the angle left after the nearest quarter turns are taken off, and a
/// number whose lowest bits count those: an odd count exchanges the two, bit 1 of the count
/// changes the sine's sign, bit 1 of the count plus one the cosine's.
///
/// What every number type's [`Real::sin_cos`] is made of; the rest is integer work that
/// each does in its own way.
#[inline(always)]
pub fn sin_cos_by_quadrant<R: Real>(x: R) -> (R, R, R) {
    let (quarter_turns, counted) = quarter_turns(x);
    let (sin, cos) = reduced_sin_cos(reduce(x, quarter_turns));
    (sin, cos, counted)
}

/// Horner's rule for several numbers in step, which share the loads of the coefficients and
/// hide one another's waiting.
#[inline(always)]
fn horner_each<R: Real, const N: usize, const M: usize>(
    x: &[R; N],
    coefficients: [f64; M],
) -> [R; N] {
    let mut sum = [R::splat(coefficients[0]); N];
    for &c in &coefficients[1..] {
        let c = R::splat(c);
        for i in 0..N {
            sum[i] = sum[i].mul_add(x[i], c);
        }
    }
    sum
}

/// Sines and cosines of several angles in step, at most 2e-15 off for |x| <= 4 pi: for
/// those who look at many postures roughly. Near their zeros they lack digits that
/// [`Real::sin_cos`] has, at two thirds of its price.
#[inline(always)]
pub fn turns_each<R: Real, const N: usize>(x: &[R; N]) -> ([R; N], [R; N]) {
    use std::f64::consts::TAU;
    // `sqrt(2) sin(r / 2) / r` and `sqrt(2) cos(r / 2)` in powers of r^2 for |r| <= pi, of
    // which double angles make sine and cosine without a choice between quadrants:
    // Chebyshev fits of our own, made with 50-digit arithmetic.
    const SIN: [f64; 8] = [
        -3.182_655_625_597_071e-17,
        2.770_451_039_529_846_5e-14,
        -1.729_917_536_495_980_2e-11,
        7.611_705_252_019_93e-9,
        -2.192_171_318_829_607e-6,
        3.682_847_818_657_579_3e-4,
        -2.946_278_254_943_843e-2,
        7.071_067_811_865_475e-1,
    ];
    const COS: [f64; 9] = [
        9.945_757_848_617_837e-19,
        -9.894_402_506_885_16e-16,
        7.207_987_502_588_164e-13,
        -3.805_852_595_838_588_3e-10,
        1.370_107_074_065_888_2e-7,
        -3.069_039_848_874_325e-5,
        3.682_847_818_679_688_7e-3,
        -1.767_766_952_966_367_8e-1,
        std::f64::consts::SQRT_2,
    ];
    let mut r = *x;
    let mut squared = *x;
    for i in 0..N {
        let turns = round_small(x[i] * R::splat(1.0 / TAU));
        r[i] = turns.neg_mul_add(R::splat(TAU), x[i]);
        squared[i] = r[i] * r[i];
    }
    let mut sin = horner_each(&squared, SIN);
    let mut cos = horner_each(&squared, COS);
    for i in 0..N {
        let half = sin[i] * r[i];
        sin[i] = half * cos[i];
        cos[i] = half.neg_mul_add(half, R::splat(1.0));
    }
    (sin, cos)
}

/// Squared angles between directions of unit length whose squared distance is known and at
/// most [`CHORD2`], to the last place; of larger ones nonsense.
#[inline(always)]
pub fn squared_angles<R: Real, const N: usize>(chord2: [R; N]) -> [R; N] {
    // `4 asin(sqrt(x) / 2)^2 / x`, a Chebyshev fit of our own, made with 50-digit arithmetic.
    const RATIO: [f64; 10] = [
        1.909_997_965_952_488e-7,
        4.102_272_676_323_132e-7,
        2.488_618_458_155_137e-6,
        1.187_067_875_420_778_2e-5,
        6.013_004_644_421_385_4e-5,
        0.000_317_459_639_388_883_2,
        0.001_785_714_338_477_973_4,
        0.011_111_111_109_031_36,
        0.083_333_333_333_365_07,
        1.0,
    ];
    let ratio = horner_each(&chord2, RATIO);
    let mut squared = chord2;
    for i in 0..N {
        squared[i] *= ratio[i];
    }
    squared
}

/// The squared chord up to which [`squared_angles`] is exact: of 41 degrees.
pub const CHORD2: f64 = 0.5;

/// `acos(c) / sqrt(1 - c^2)` for c in [0, 1]: the factor from the sine of a rotation
/// angle to the angle itself, smooth where the angle vanishes.
#[inline(always)]
pub fn angle_over_sine<R: Real>(c: R) -> R {
    // In powers of u = 1 - c; relative error below 1e-16 on [0, 1]. Split in even and
    // odd powers, which halves the chain of dependent multiplications.
    const EVEN: [f64; 11] = [
        -0.000_728_127_364_338_151_6,
        -0.008_217_500_897_654_82,
        -0.020_647_830_091_351_717,
        -0.017_185_237_019_630_522,
        -0.005_354_854_850_622_061_5,
        -0.000_396_749_895_693_602_73,
        0.001_140_381_433_810_797_8,
        0.005_327_576_046_333_906,
        0.025_396_823_882_017_35,
        0.133_333_333_332_627_7,
        1.0,
    ];
    const ODD: [f64; 11] = [
        8.121_007_252_839_173e-5,
        0.003_097_390_472_213_588_3,
        0.015_180_613_767_041_282,
        0.021_394_954_857_916_56,
        0.010_890_803_896_660_979,
        0.002_258_839_699_459_277_3,
        0.000_713_896_879_431_486_1,
        0.002_490_569_286_343_547,
        0.011_544_042_766_655_997,
        0.057_142_857_187_808_9,
        0.333_333_333_333_337_7,
    ];
    let u = R::splat(1.0) - c;
    let u2 = u * u;
    horner(u2, ODD).mul_add(u, horner(u2, EVEN))
}

/// Angle of the direction `(x, y)` in [-pi, pi], at most 3 units in the last place off;
/// 0 where both are zero.
#[inline(always)]
pub fn atan2<R: Real>(y: R, x: R) -> R {
    atan2_each([y], [x])[0]
}

/// [`atan2`] of several directions to 1.2e-5 rad.
#[inline(always)]
pub fn atan2_rough<R: Real, const N: usize>(y: [R; N], x: [R; N]) -> [R; N] {
    // Abramowitz and Stegun, Handbook of Mathematical Functions, 4.4.49.
    const ATAN: [f64; 5] = [0.020_835_1, -0.085_133, 0.180_141, -0.330_299_5, 0.999_866];
    use std::f64::consts::{FRAC_PI_2, PI};
    let mut out = [R::zero(); N];
    for i in 0..N {
        let (ay, ax) = (y[i].abs(), x[i].abs());
        let steep = ax.lt(ay);
        let large = R::select(steep, ay, ax).max(R::splat(f64::MIN_POSITIVE));
        let t = R::select(steep, ax, ay) / large;
        let angle = t * horner(t * t, ATAN);
        let angle = R::select(steep, R::splat(FRAC_PI_2) - angle, angle);
        let angle = R::select(x[i].lt(R::zero()), R::splat(PI) - angle, angle);
        out[i] = R::select(y[i].lt(R::zero()), -angle, angle);
    }
    out
}

/// [`atan2`] of several directions, which share the loads of the polynomial and hide one
/// another's waiting.
#[inline(always)]
pub fn atan2_each<R: Real, const N: usize>(y: [R; N], x: [R; N]) -> [R; N] {
    // fdlibm's polynomial for |t| <= 7/16.
    const ATAN: [f64; 11] = [
        1.628_582_011_536_578_2e-2,
        -3.653_157_274_421_691_6e-2,
        4.976_877_994_615_932_4e-2,
        -5.833_570_133_790_573_5e-2,
        6.661_073_137_387_531e-2,
        -7.691_876_205_044_83e-2,
        9.090_887_133_436_507e-2,
        -1.111_111_040_546_235_6e-1,
        1.428_571_427_250_346_6e-1,
        -1.999_999_999_987_648_3e-1,
        3.333_333_333_333_293e-1,
    ];
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
    let zero = [R::zero(); N];
    let (mut t, mut z, mut base) = (zero, zero, zero);
    for i in 0..N {
        let (ay, ax) = (y[i].abs(), x[i].abs());
        let steep = ax.lt(ay);
        // `max` keeps the quotient finite at the origin.
        let large = R::select(steep, ay, ax).max(R::splat(f64::MIN_POSITIVE));
        let small = R::select(steep, ax, ay);
        // Above tan(pi / 8) take atan(t) = pi / 4 + atan((t - 1) / (t + 1)).
        let upper = (large * R::splat(std::f64::consts::SQRT_2 - 1.0)).lt(small);
        t[i] = R::select(upper, small - large, small) / R::select(upper, small + large, large);
        base[i] = R::select(upper, R::splat(FRAC_PI_4), R::zero());
        z[i] = t[i] * t[i];
    }
    let sum = horner_each(&z, ATAN);
    let mut out = zero;
    for i in 0..N {
        let angle = base[i] + (t[i] - t[i] * (z[i] * sum[i]));
        let steep = x[i].abs().lt(y[i].abs());
        let angle = R::select(steep, R::splat(FRAC_PI_2) - angle, angle);
        let angle = R::select(x[i].lt(R::zero()), R::splat(PI) - angle, angle);
        out[i] = R::select(y[i].lt(R::zero()), -angle, angle);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn atan2_within_four_ulps() {
        let mut worst: f64 = 0.0;
        for i in 0..200_000 {
            let angle = 1.000_005 * (f64::from(i) * 3.141_59e-5 - std::f64::consts::PI);
            let radius = 10_f64.powf(f64::from(i % 25) - 12.0);
            let (y, x) = (radius * angle.sin(), radius * angle.cos());
            worst = worst.max(ulps(atan2(y, x), y.atan2(x), 0.0));
        }
        assert!(worst <= 4.0, "worst {worst} ulp");
        assert_eq!(atan2(0.0, 0.0), 0.0);
        assert_eq!(atan2(0.0, -1.0), std::f64::consts::PI);
        assert_eq!(atan2(-2.0, 0.0), -std::f64::consts::FRAC_PI_2);
    }

    #[test]
    fn atan2_rough_within_its_bound() {
        for i in 0..20_000 {
            let angle = 1.000_05 * (f64::from(i) * 3.141_59e-4 - std::f64::consts::PI);
            let (y, x) = angle.sin_cos();
            let [rough] = atan2_rough([0.3 * y], [0.3 * x]);
            assert!((rough - y.atan2(x)).abs() < 1.2e-5);
        }
        assert_eq!(atan2_rough([0.0], [0.0]), [0.0]);
    }

    /// Distance in units in the last place of the true value.
    fn ulps(got: f64, exact_high: f64, exact_low: f64) -> f64 {
        let unit = (f64::from_bits(exact_high.abs().to_bits() + 1) - exact_high.abs()).abs();
        ((got - exact_high) - exact_low).abs() / unit
    }

    #[test]
    fn sine_and_cosine_within_two_ulps() {
        // The system library is within 0.55 ulp; 2 - 0.55 is what is left for ours.
        let mut worst: f64 = 0.0;
        let mut x = -1e4;
        while x < 1e4 {
            let (s, c) = x.sin_cos();
            let (s2, c2) = Real::sin_cos(x);
            worst = worst.max(ulps(s2, s, 0.0)).max(ulps(c2, c, 0.0));
            x += 0.013_37;
        }
        for k in -6366..=6366 {
            let x = f64::from(k) * std::f64::consts::FRAC_PI_2;
            let (s, c) = x.sin_cos();
            let (s2, c2) = Real::sin_cos(x);
            worst = worst.max(ulps(s2, s, 0.0)).max(ulps(c2, c, 0.0));
        }
        assert!(worst <= 1.45, "worst {worst} ulp");
    }

    #[test]
    fn angle_over_sine_matches_its_definition() {
        for i in 1..=1570 {
            let angle = f64::from(i) / 1000.0;
            let exact = angle / angle.sin();
            assert!((angle_over_sine(angle.cos()) / exact - 1.0).abs() < 1e-15);
        }
        assert_eq!(angle_over_sine(1.0), 1.0);
    }

    #[test]
    fn turns_in_step_are_within_what_is_said() {
        let mut worst: f64 = 0.0;
        let mut x = -4.0 * std::f64::consts::PI;
        while x < 4.0 * std::f64::consts::PI {
            let (sin, cos) = turns_each(&[x, -0.5 * x, 1.0]);
            for (i, x) in [x, -0.5 * x, 1.0].into_iter().enumerate() {
                worst = worst.max((sin[i] - x.sin()).abs()).max((cos[i] - x.cos()).abs());
            }
            x += 1.37e-4;
        }
        assert!(worst <= 2e-15, "worst {worst}");
        assert_eq!(turns_each(&[0.0]), ([0.0], [1.0]));
    }

    #[test]
    fn squared_angles_come_from_chords() {
        let mut largest: f64 = 0.0;
        for i in 1..=7000 {
            let angle = f64::from(i) * 1e-4;
            let chord2 = 4.0 * (0.5 * angle).sin().powi(2);
            let [near, tiny] = squared_angles([chord2, 1e-20 * chord2]);
            assert!((near / (angle * angle) - 1.0).abs() < 1e-15, "{angle}");
            assert!((tiny / (1e-20 * chord2) - 1.0).abs() < 1e-15);
            largest = largest.max(chord2);
        }
        assert!(largest < CHORD2 && largest > 0.9 * CHORD2);
    }
}
