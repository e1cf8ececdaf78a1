//! Sine and cosine of every number type, against values worked out with 60 digits.

use agrik_compute::lanes::{Kernel, Level, Real, dispatch, dispatch_single};

/// Made by `tests/data/make_sin_cos.py`: x, then sine and cosine as sums of two doubles.
const GOLDEN: &str = include_str!("../../../tests/data/sin_cos.txt");
const MOST_ULPS: f64 = 2.0;

struct Row {
    x: f64,
    sin: [f64; 2],
    cos: [f64; 2],
}

/// The numbers are written as the 16 hexadecimal digits of their bits.
fn golden() -> Vec<Row> {
    let number = |text: &str| f64::from_bits(u64::from_str_radix(text, 16).expect("hexadecimal"));
    let row = |line: &str| {
        let numbers: Vec<f64> = line.split(' ').map(number).collect();
        let [x, s, s_low, c, c_low] = numbers.try_into().expect("five numbers a line");
        Row { x, sin: [s, s_low], cos: [c, c_low] }
    };
    GOLDEN.lines().filter(|line| !line.starts_with('#')).map(row).collect()
}

/// Distance from the true value in units in the last place of the double next to it.
fn ulps(got: f64, [high, low]: [f64; 2]) -> f64 {
    let size = high.abs();
    let unit = f64::from_bits(size.to_bits() + 1) - size;
    ((got - high) - low).abs() / unit
}

struct SinCos<'a>(&'a [Row]);

impl Kernel for SinCos<'_> {
    type Output = Vec<(f64, f64)>;
    #[inline(always)]
    fn run<R: Real>(self) -> Self::Output {
        let mut results = Vec::new();
        for rows in self.0.chunks(R::WIDTH) {
            // Another angle in each lane; what a short rest leaves over stays zero.
            let mut x = R::zero();
            for (lane, row) in rows.iter().enumerate() {
                x.set_lane(lane, row.x);
            }
            let (sin, cos) = x.sin_cos();
            for lane in 0..rows.len() {
                results.push((sin.lane(lane), cos.lane(lane)));
            }
        }
        results
    }
}

fn check(what: &str, rows: &[Row], results: &[(f64, f64)]) {
    assert_eq!(rows.len(), results.len());
    for (row, (sin, cos)) in rows.iter().zip(results) {
        let (of_sin, of_cos) = (ulps(*sin, row.sin), ulps(*cos, row.cos));
        assert!(of_sin <= MOST_ULPS, "{what}: sin {} is {of_sin} ulp off", row.x);
        assert!(of_cos <= MOST_ULPS, "{what}: cos {} is {of_cos} ulp off", row.x);
    }
}

#[test]
fn sine_and_cosine_are_within_two_ulps_in_every_number_type() {
    let rows = golden();
    assert!(rows.len() > 1000);
    assert!(rows.iter().any(|row| row.x == 1e4) && rows.iter().any(|row| row.x == -1e4));
    check("f64", &rows, &SinCos(&rows).run::<f64>());
    for level in Level::ALL.into_iter().filter(|level| level.is_available()) {
        check(level.name(), &rows, &dispatch(level, SinCos(&rows)));
        let single = dispatch_single(level, SinCos(&rows));
        check(&format!("{}, one lane", level.name()), &rows, &single);
    }
}

#[test]
fn lanes_of_all_levels_that_fuse_agree_bit_for_bit() {
    let rows = golden();
    let fused: Vec<Level> = Level::ALL
        .into_iter()
        .filter(|level| level.is_available() && *level != Level::Scalar)
        .collect();
    let results: Vec<_> = fused
        .iter()
        .flat_map(|level| [dispatch(*level, SinCos(&rows)), dispatch_single(*level, SinCos(&rows))])
        .collect();
    for pair in results.windows(2) {
        assert!(pair[0] == pair[1]);
    }
}
