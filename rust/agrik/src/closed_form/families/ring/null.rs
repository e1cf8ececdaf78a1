//! The matrix whose determinant is the resultant, at a root: its null vectors, and the root made
//! sharper on the matrix itself, since a crowded polynomial carries the noise of its largest
//! values.

use super::cut::ROWS;
use super::resultant::Columns;
use crate::closed_form::geometry::mirrors::{inner, mirror, reflect, unrolled};
use crate::closed_form::geometry::turn::unit_pair;
use crate::lanes::{Lanes, Real};

/// Rows and columns: products `x^i y^j` with `i` below 4 and `j` below 3.
pub const SIZE: usize = 12;
/// What the mirrors of the first three columns leave.
const REST: usize = SIZE - 3;

/// A vector of products.
pub type Products<R> = [R; SIZE];

/// The matrix as mirrors and a triangle.
pub struct Factors<R> {
    above: [([R; ROWS], R); 3],
    rest: [([R; REST], R); REST],
    /// Columns of the triangle.
    triangle: [[R; SIZE]; SIZE],
    /// One over its diagonal.
    inverse: [R; SIZE],
}

/// A number on the diagonal is not smaller: no division by zero where the matrix is singular to
/// the last digit.
const LEAST: f64 = 1e-20;
/// A singular value is not so many times smaller than it seems after one round.
const ROUGH: f64 = 8.0;

impl<R: Real> Factors<R> {
    /// Factors of the matrix with the equations' columns at a value of the hidden angle.
    #[inline(always)]
    // The last of written out loops have nothing to go through.
    #[allow(clippy::reversed_empty_ranges)]
    pub fn new(below: &Columns<R>) -> Self {
        let mut above = *below;
        let mut triangle = [[R::zero(); SIZE]; SIZE];
        let mut first = [([R::zero(); ROWS], R::zero()); 3];
        unrolled!(K in [0 1 2] {
            first[K] = mirror::<R, ROWS, K>(&mut above[K]);
            for j in K + 1..9 {
                reflect::<R, ROWS, K>(&first[K], &mut above[j]);
            }
        });
        for (j, column) in above.iter().enumerate() {
            let count = 3.min(j + 1);
            triangle[j][..count].copy_from_slice(&column[..count]);
        }
        let mut rest = [[R::zero(); REST]; REST];
        for j in 0..REST {
            for i in 0..3 {
                if j < 6 {
                    rest[j][i] = above[3 + j][3 + i];
                }
            }
            for i in 0..ROWS {
                rest[j][3 + i] = below[j][i];
            }
        }
        let mut second = [([R::zero(); REST], R::zero()); REST];
        unrolled!(K in [0 1 2 3 4 5 6 7 8] {
            second[K] = mirror::<R, REST, K>(&mut rest[K]);
            for j in K + 1..REST {
                reflect::<R, REST, K>(&second[K], &mut rest[j]);
            }
        });
        for j in 0..REST {
            for i in 0..=j {
                triangle[3 + j][3 + i] = rest[j][i];
            }
        }
        let mut inverse = [R::zero(); SIZE];
        for k in 0..SIZE {
            let (x, least) = (triangle[k][k], R::splat(LEAST));
            inverse[k] = R::splat(1.0) / R::select(x.abs().lt(least), least, x);
        }
        Self { above: first, rest: second, triangle, inverse }
    }

    /// The solution for a right side.
    #[inline(always)]
    pub fn solve(&self, right: &Products<R>) -> Products<R> {
        let mut top = [R::zero(); ROWS];
        top.copy_from_slice(&right[..ROWS]);
        unrolled!(K in [0 1 2] {
            reflect::<R, ROWS, K>(&self.above[K], &mut top);
        });
        let mut low = [R::zero(); REST];
        low[..3].copy_from_slice(&top[3..]);
        low[3..].copy_from_slice(&right[ROWS..]);
        unrolled!(K in [0 1 2 3 4 5 6 7 8] {
            reflect::<R, REST, K>(&self.rest[K], &mut low);
        });
        let mut out = [R::zero(); SIZE];
        out[..3].copy_from_slice(&top[..3]);
        out[3..].copy_from_slice(&low);
        self.up(&mut out);
        out
    }

    /// Back substitution. The last three columns have nothing in the first three rows.
    #[inline(always)]
    #[allow(clippy::reversed_empty_ranges)]
    fn up(&self, x: &mut Products<R>) {
        unrolled!(K in [11 10 9 8 7 6 5 4 3 2 1 0] {
            x[K] *= self.inverse[K];
            for i in if K < REST { 0 } else { 3 }..K {
                x[i] = self.triangle[K][i].neg_mul_add(x[K], x[i]);
            }
        });
    }

    /// Back substitution with the transposed triangle: what is known goes to all others at once,
    /// which then do not wait for one another.
    #[inline(always)]
    #[allow(clippy::reversed_empty_ranges)]
    fn down(&self, x: &mut Products<R>) {
        unrolled!(I in [0 1 2 3 4 5 6 7 8 9 10 11] {
            x[I] *= self.inverse[I];
            for k in I + 1..if I < 3 { REST } else { SIZE } {
                x[k] = self.triangle[k][I].neg_mul_add(x[I], x[k]);
            }
        });
    }

    /// The right singular vector of the smallest singular value, by inverse iteration: near a
    /// root a step brings it nearer by as much as the value is smaller than the next one.
    #[inline(always)]
    pub fn smallest(&self) -> Singular<R> {
        let mut right = start(0);
        self.up(&mut right);
        normalise(&mut right);
        let mut left = right;
        self.down(&mut left);
        normalise(&mut left);
        right = left;
        self.up(&mut right);
        let size = R::splat(1.0) / normalise(&mut right);
        Singular { right, left, size }
    }

    /// The same of the next one after the smallest, where it is below `small`; where it is not, one
    /// round is enough to see that.
    #[inline(always)]
    pub fn next(&self, known: &Singular<R>, small: f64) -> Singular<R> {
        let mut right = start(5);
        let (mut left, mut size) = (right, R::zero());
        for round in 0..2 {
            without(&mut right, &known.right);
            left = right;
            self.down(&mut left);
            without(&mut left, &known.left);
            normalise(&mut left);
            right = left;
            self.up(&mut right);
            without(&mut right, &known.right);
            let now = R::splat(1.0) / normalise(&mut right);
            if round > 0 {
                // A lane that was done before its neighbours stays so.
                size = R::select(size.lt(R::splat(ROUGH * small)), now, size);
                break;
            }
            size = now;
            if R::bits(size.lt(R::splat(ROUGH * small))) == 0 {
                break;
            }
        }
        Singular { right, left, size }
    }
}

/// A singular value of the triangle and its vectors.
pub struct Singular<R> {
    /// Right one: that of the matrix as well.
    pub right: Products<R>,
    left: Products<R>,
    /// The value.
    pub size: R,
}

/// Nothing special: a start that no vector of an arm is likely to be across of.
const START: [f64; SIZE] =
    [1.0, 0.71, -0.53, 0.87, -0.95, 0.62, 0.44, -0.78, 0.91, 0.37, 0.83, -0.59];

#[inline(always)]
fn start<R: Real>(shift: usize) -> Products<R> {
    let mut v = [R::zero(); SIZE];
    for (i, x) in v.iter_mut().enumerate() {
        *x = R::splat(START[(i + shift) % SIZE]);
    }
    v
}

#[inline(always)]
fn without<R: Real>(v: &mut Products<R>, w: &Products<R>) {
    let along = inner::<R, SIZE, 0>(v, w);
    for i in 0..SIZE {
        v[i] = w[i].neg_mul_add(along, v[i]);
    }
}

/// Makes the length 1; the length before.
#[inline(always)]
fn normalise<R: Real>(v: &mut Products<R>) -> R {
    let square = inner::<R, SIZE, 0>(v, v).max(R::splat(f64::MIN_POSITIVE));
    let size = square.sqrt();
    let inverse = R::splat(1.0) / size;
    for x in v.iter_mut() {
        *x *= inverse;
    }
    size
}

/// How far the hidden angle is from where the matrix is singular, rad: the step of nonlinear
/// inverse iteration from a vector near to its null vector; `slopes` are the columns' derivatives.
#[inline(always)]
pub fn distance<R: Real>(factors: &Factors<R>, slopes: &Columns<R>, v: &Products<R>) -> R {
    let mut right = [R::zero(); SIZE];
    for j in 0..9 {
        for i in 0..ROWS {
            let slope = slopes[j][i];
            right[i] = slope.mul_add(v[j], right[i]);
            right[ROWS + i] = slope.mul_add(v[3 + j], right[ROWS + i]);
        }
    }
    let w = factors.solve(&right);
    let along = inner::<R, SIZE, 0>(v, &w);
    let tiny = R::splat(1e-300);
    R::splat(1.0) / R::select(along.abs().lt(tiny), tiny, along)
}

/// Joints' turns (sine, cosine) of the two angles behind a product: that of `x`, that of `y`.
#[inline(always)]
pub fn angles<R: Real>(v: &Products<R>) -> [(R, R); 2] {
    [half_angle(v, 3, &[0, 3, 6, 1, 4, 7, 2, 5, 8]), half_angle(v, 1, &[0, 1, 3, 4, 6, 7, 9, 10])]
}

/// Twice the angle in which pairs of neighbouring powers point.
#[inline(always)]
fn half_angle<R: Real>(v: &Products<R>, stride: usize, firsts: &[usize]) -> (R, R) {
    let (mut a, mut b, mut c) = (R::zero(), R::zero(), R::zero());
    for i in firsts {
        let (x, y) = (v[*i], v[*i + stride]);
        a = x.mul_add(x, a);
        b = x.mul_add(y, b);
        c = y.mul_add(y, c);
    }
    unit_pair(b + b, a - c)
}

/// Combinations of two null vectors that are products.
pub struct TwoProducts<R> {
    pub products: [Products<R>; 2],
    /// Lanes where that is the first null vector over again, which is a product of its own.
    pub known: [Lanes; 2],
}

/// The combinations of two null vectors that are products: those that keep their direction from
/// one power of `x` to the next.
#[inline(always)]
pub fn two_products<R: Real>(one: &Products<R>, two: &Products<R>) -> TwoProducts<R> {
    // Powers of the tangent of half an angle turned by a fixed one, so that none is infinite
    // where it matters.
    let (c, s) = (R::splat(TURN.0), R::splat(TURN.1));
    let ((l1, h1), (l2, h2)) = (low_high(one, c, s), low_high(two, c, s));
    let by = inner::<R, 9, 0>;
    let (aa, ab, bb) = (by(&l1, &l1), by(&l1, &l2), by(&l2, &l2));
    let det = aa * bb - ab * ab;
    let det = R::select(det.lt(R::splat(1e-200)), R::splat(1e-200), det);
    let (x1, y1, x2, y2) = (by(&l1, &h1), by(&l2, &h1), by(&l1, &h2), by(&l2, &h2));
    let product = R::splat(1.0 - ALONG * ALONG) * aa * by(&h1, &h1);
    let product = R::bits(product.le(x1 * x1));
    let (p11, p21) = ((bb * x1 - ab * y1) / det, (aa * y1 - ab * x1) / det);
    let (p12, p22) = ((bb * x2 - ab * y2) / det, (aa * y2 - ab * x2) / det);
    // Eigenvectors of ((p11, p12), (p21, p22)); where they are complex their real part.
    let half = R::splat(0.5) * (p11 - p22);
    let root = half.mul_add(half, p12 * p21).max(R::zero()).sqrt();
    let mean = R::splat(0.5) * (p11 + p22);
    let mut out = TwoProducts { products: [*one; 2], known: [0; 2] };
    for (k, value) in [mean + root, mean - root].into_iter().enumerate() {
        let (x1, y1) = (p12, value - p11);
        let (x2, y2) = (value - p22, p21);
        let (n1, n2) = (x1.mul_add(x1, y1 * y1), x2.mul_add(x2, y2 * y2));
        let first = n2.lt(n1);
        let (x, y) = (R::select(first, x1, x2), R::select(first, y1, y2));
        for i in 0..SIZE {
            out.products[k][i] = one[i].mul_add(x, two[i] * y);
        }
        out.known[k] = product & R::bits(y.abs().lt(R::splat(BESIDE) * x.abs()));
    }
    out
}

/// Sine of the angle between powers of a vector that is a product, and share of the second null
/// vector in a combination that is the first one.
const ALONG: f64 = 1e-3;
const BESIDE: f64 = 0.1;

/// The lower and the upper three of four powers of a turned tangent.
#[inline(always)]
fn low_high<R: Real>(v: &Products<R>, c: R, s: R) -> ([R; 9], [R; 9]) {
    let (mut low, mut high) = ([R::zero(); 9], [R::zero(); 9]);
    for i in 0..9 {
        low[i] = v[i].mul_add(c, v[i + 3] * s);
        high[i] = v[i + 3].mul_add(c, -(v[i] * s));
    }
    (low, high)
}

/// Cosine and sine of the fixed angle.
const TURN: (f64, f64) = (0.877_582_561_890_372_8, 0.479_425_538_604_203);
