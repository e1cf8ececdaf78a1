//! All real roots of the resultant, each in an interval of its own: Descartes' rule of signs for
//! the coefficients in Bernstein's basis, on eight arcs of the turn.

use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

use super::resultant::{DEGREE, HARMONICS, Harmonics};
use crate::lanes::{Lanes, Real, WIDEST};

const ARCS: usize = 8;
/// Coefficients on an arc: those of degree 16 in the tangent of half the angle.
const COUNT: usize = 2 * DEGREE + 1;
/// Half an arc, rad.
const HALF: f64 = PI / ARCS as f64;
/// An interval is not parted further once it is narrower, rad (at the arc's centre).
const NARROW: f64 = 1e-3;
/// A coefficient's sign is sure above this share of the largest one, or so many times the
/// noise of the samples.
const SURE: f64 = 4e-15;
pub const NOISE: f64 = 20.0;
/// Most parts of one arc that wait at a time.
const DEPTH: usize = 16;

/// Where a root is, or may be.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    /// Which goal.
    pub goal: u32,
    /// Centre of the arc, rad.
    pub centre: f64,
    /// The root, rad, once it is known better than by its place.
    pub angle: f64,
    /// Tangents of half the angles from the centre on both sides.
    pub lower: f64,
    pub upper: f64,
    /// The polynomial is below zero at the lower one.
    pub rising: bool,
    /// The interval holds one root for sure; else it only is narrow.
    pub single: bool,
    /// The root is where the matrix is singular, as far as the samples' noise can tell.
    pub sharp: bool,
}

/// Bernstein coefficients of `(1 + x^2)^8 cos(k phi)` and `(1 + x^2)^8 sin(k phi)` with
/// `x = tan(phi / 2)` over an arc about 0.
static BASIS: LazyLock<[[f64; COUNT]; HARMONICS]> = LazyLock::new(|| {
    let choose = |n: usize, k: usize| -> f64 {
        (0..k).fold(1.0, |product, i| product * (n - i) as f64 / (i + 1) as f64)
    };
    let mut out = [[0.0; COUNT]; HARMONICS];
    for k in 0..=DEGREE {
        // (1 + i x)^(8 + k) (1 - i x)^(8 - k): its polar form at j times the arc's end and
        // 16 - j times its begin, a mean of unit numbers.
        let (plus, minus) = (DEGREE + k, DEGREE - k);
        for j in 0..COUNT {
            let (mut re, mut im) = (0.0, 0.0);
            for i in j.saturating_sub(minus)..=j.min(plus) {
                let share = choose(plus, i) * choose(minus, j - i) / choose(2 * DEGREE, j);
                let turns = 2.0 * i as f64 - j as f64 - k as f64;
                let (s, c) = (turns * HALF).sin_cos();
                (re, im) = (re + share * c, im + share * s);
            }
            if k == 0 {
                out[0][j] = re;
            } else {
                (out[2 * k - 1][j], out[2 * k][j]) = (re, im);
            }
        }
    }
    out
});

/// Coefficients filled up to whole vectors.
const WIDE: usize = COUNT.next_multiple_of(WIDEST);

/// The table of [`HALVES`], each row at the start of a line of the cache.
#[repr(align(64))]
struct Halves([[[f64; WIDE]; COUNT]; 2]);

/// What each coefficient of an interval counts in those of its left and of its right half: de
/// Casteljau's means of means as sums, in which nothing waits for anything.
static HALVES: LazyLock<Halves> = LazyLock::new(|| {
    let mut out = [[[0.0; WIDE]; COUNT]; 2];
    // Pascal's triangle, each row half as large as counted.
    let mut row = [0.0; COUNT];
    row[0] = 1.0;
    for i in 0..COUNT {
        for (j, share) in row.iter().enumerate().take(i + 1) {
            out[0][j][i] = *share;
            out[1][COUNT - 1 - j][COUNT - 1 - i] = *share;
        }
        for j in (1..COUNT).rev() {
            row[j] = 0.5 * (row[j] + row[j - 1]);
        }
        row[0] *= 0.5;
    }
    Halves(out)
});

/// Cosine and sine of multiples of the centres of the arcs.
static CENTRES: LazyLock<[(f64, f64); ARCS]> = LazyLock::new(|| {
    std::array::from_fn(|k| {
        let (s, c) = (k as f64 * (TAU / ARCS as f64)).sin_cos();
        (c, s)
    })
});

/// Coefficients on all arcs.
pub type Arcs<R> = [[R; COUNT]; ARCS];

/// The coefficients of a polynomial on all arcs.
#[inline(always)]
pub fn arcs<R: Real>(h: &Harmonics<R>) -> Arcs<R> {
    let (basis, centres) = (&*BASIS, &*CENTRES);
    let mut out = [[R::zero(); COUNT]; ARCS];
    for (arc, coefficients) in out.iter_mut().enumerate() {
        let mut turned = *h;
        for k in 1..=DEGREE {
            let (c, s) = centres[k * arc % ARCS];
            let (c, s) = (R::splat(c), R::splat(s));
            let (a, b) = (h[2 * k - 1], h[2 * k]);
            turned[2 * k - 1] = a.mul_add(c, b * s);
            turned[2 * k] = b.mul_add(c, -(a * s));
        }
        // Cosines are the same on both sides of the centre, sines the opposite.
        for j in 0..=DEGREE {
            let mut even = turned[0] * R::splat(basis[0][j]);
            let mut odd = R::zero();
            for k in 1..=DEGREE {
                even = turned[2 * k - 1].mul_add(R::splat(basis[2 * k - 1][j]), even);
                odd = turned[2 * k].mul_add(R::splat(basis[2 * k][j]), odd);
            }
            coefficients[j] = even + odd;
            coefficients[COUNT - 1 - j] = even - odd;
        }
    }
    out
}

/// Which arcs of which lanes may hold roots, and below what a coefficient's sign is not sure.
pub struct Sifted<R> {
    open: [Lanes; ARCS],
    least: R,
    /// Lanes with numbers to look at.
    known: Lanes,
}

/// Sets the arcs aside all of whose coefficients are surely on one side; `noise` as the samples
/// have it.
#[inline(always)]
pub fn sifted<R: Real>(arcs: &Arcs<R>, noise: R) -> Sifted<R> {
    let (mut low, mut high) = ([R::zero(); ARCS], [R::zero(); ARCS]);
    let mut largest = R::zero();
    for (arc, coefficients) in arcs.iter().enumerate() {
        (low[arc], high[arc]) = (coefficients[0], coefficients[0]);
        for x in &coefficients[1..] {
            low[arc] = low[arc].min(*x);
            high[arc] = high[arc].max(*x);
        }
        largest = largest.max(high[arc]).max(-low[arc]);
    }
    let least = largest * (R::splat(NOISE) * noise).max(R::splat(SURE));
    let mut open = [0; ARCS];
    for (arc, open) in open.iter_mut().enumerate() {
        *open = !R::bits(R::or(least.lt(low[arc]), high[arc].lt(-least)));
    }
    let finite = largest.lt(R::splat(f64::INFINITY));
    Sifted { open, least, known: R::bits(R::and(R::zero().lt(largest), finite)) }
}

/// A part of an arc: its coefficients, and where it begins and how long it is, as shares of the
/// arc.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Part {
    b: [f64; WIDE],
    begin: f64,
    size: f64,
}

impl Part {
    const NONE: Self = Self { b: [0.0; WIDE], begin: 0.0, size: 1.0 };
}

/// Parts of an arc that wait; without room until it is needed.
#[derive(Default)]
pub struct Waiting(Vec<Part>);

/// The places of all real roots of the polynomial of the goal in a lane.
#[inline(always)]
pub fn places<R: Real>(
    goal: u32,
    lane: usize,
    arcs: &Arcs<R>,
    sifted: &Sifted<R>,
    (waiting, out): (&mut Waiting, &mut Vec<Place>),
) {
    if sifted.known >> lane & 1 == 0 {
        return;
    }
    let least = sifted.least.lane(lane);
    let half = (0.5 * HALF).tan();
    let table = &HALVES.0;
    waiting.0.resize(DEPTH, Part::NONE);
    let waiting = &mut waiting.0[..];
    for (arc, coefficients) in arcs.iter().enumerate() {
        if sifted.open[arc] >> lane & 1 == 0 {
            continue;
        }
        for (to, from) in waiting[0].b.iter_mut().zip(coefficients) {
            *to = from.lane(lane);
        }
        (waiting[0].begin, waiting[0].size) = (0.0, 1.0);
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let Part { b, begin, size } = &waiting[count];
            let (begin, size) = (*begin, *size);
            let seen = signs::<R>(b, least);
            if seen.changes == 0 && !seen.unsure {
                continue;
            }
            let rising = b[0] < 0.0;
            let place = |lower: f64, upper: f64, single: bool| Place {
                goal,
                centre: arc as f64 * (TAU / ARCS as f64),
                angle: f64::NAN,
                lower: half * (2.0 * lower - 1.0),
                upper: half * (2.0 * upper - 1.0),
                rising,
                single,
                sharp: false,
            };
            let at = |part: f64| place(begin + part * size, begin + part * size, false);
            if seen.changes == 1 && !seen.unsure {
                out.push(place(begin, begin + size, true));
            } else if seen.all_unsure || size < NARROW / (4.0 * half) || count + 2 > DEPTH {
                if seen.all_unsure || seen.changes < 2 {
                    out.push(at(0.5));
                } else {
                    out.extend([at(0.25), at(0.75)]);
                }
            } else {
                let size = 0.5 * size;
                let [left, right] = halves::<R>(b, table);
                save(&right, &mut waiting[count].b);
                save(&left, &mut waiting[count + 1].b);
                (waiting[count].begin, waiting[count].size) = (begin + size, size);
                (waiting[count + 1].begin, waiting[count + 1].size) = (begin, size);
                count += 2;
            }
        }
    }
}

struct Signs {
    changes: u32,
    unsure: bool,
    all_unsure: bool,
}

#[inline(always)]
fn signs<R: Real>(b: &[f64; WIDE], least: f64) -> Signs {
    const ALL: u32 = (1 << COUNT) - 1;
    let (mut sure, mut below) = (0_u32, 0_u32);
    let mut i = 0;
    while i < COUNT {
        let x = R::load(&b[i..]);
        sure |= R::bits(R::splat(least).lt(x.abs())) << i;
        below |= R::bits(x.lt(R::zero())) << i;
        i += R::WIDTH;
    }
    let sure = sure & ALL;
    // Where a sign is unsure, that of the last sure one before it stands in.
    let (mut known, mut sign) = (sure, below & sure);
    for far in [1, 2, 4, 8, 16] {
        sign |= (sign << far) & !known;
        known |= known << far;
    }
    let changes = ((sign ^ (sign >> 1)) & known & (ALL >> 1)).count_ones();
    Signs { changes, unsure: sure != ALL, all_unsure: sure == 0 }
}

/// Coefficients in as few vectors as they fill.
type Filled<R> = [R; WIDE];

/// Both of de Casteljau's halves. Each coefficient is read once for all; two sums for each vector,
/// so that they need not wait long for one another.
#[inline(always)]
fn halves<R: Real>(b: &[f64; WIDE], shares: &[[[f64; WIDE]; COUNT]; 2]) -> [Filled<R>; 2] {
    let vectors = WIDE / R::WIDTH;
    let (mut even, mut odd) = ([[R::zero(); WIDE]; 2], [[R::zero(); WIDE]; 2]);
    let add = |sums: &mut [Filled<R>; 2], j: usize| {
        let x = R::splat(b[j]);
        for side in 0..2 {
            for k in 0..vectors {
                let share = R::load(&shares[side][j][k * R::WIDTH..]);
                sums[side][k] = x.mul_add(share, sums[side][k]);
            }
        }
    };
    add(&mut even, 0);
    for j in (1..COUNT).step_by(2) {
        add(&mut odd, j);
        add(&mut even, j + 1);
    }
    for side in 0..2 {
        for k in 0..vectors {
            even[side][k] += odd[side][k];
        }
    }
    even
}

/// Writes coefficients to where they wait.
#[inline(always)]
fn save<R: Real>(from: &Filled<R>, to: &mut [f64; WIDE]) {
    for k in 0..WIDE / R::WIDTH {
        from[k].store(&mut to[k * R::WIDTH..]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Sequence;

    #[test]
    fn halves_are_de_casteljaus() {
        let mut random = Sequence::new(3);
        let mut b = [0.0; WIDE];
        for x in &mut b[..COUNT] {
            *x = random.normal();
        }
        let (mut left, mut right) = ([0.0; COUNT], b);
        left[0] = b[0];
        for level in 1..COUNT {
            for i in 0..COUNT - level {
                right[i] = 0.5 * (right[i] + right[i + 1]);
            }
            left[level] = right[0];
        }
        let found = halves::<f64>(&b, &HALVES.0);
        for i in 0..COUNT {
            assert!((found[0][i] - left[i]).abs() < 1e-14);
            assert!((found[1][i] - right[i]).abs() < 1e-14);
        }
    }
}
