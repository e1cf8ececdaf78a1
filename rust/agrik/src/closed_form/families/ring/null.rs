//! The matrix whose determinant is the resultant, at a root: its null vectors, and the root made
//! sharper on the matrix itself, since a crowded polynomial carries the noise of its largest
//! values.

use super::cut::{Equations, ROWS, mirror, reflect};
use super::resultant::columns;
use crate::lanes::Real;

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
}

impl<R: Real> Factors<R> {
    /// Factors of the matrix of a value of the hidden angle, given as sine and cosine.
    #[inline(always)]
    pub fn new(equations: &Equations<R>, (s, c): (R, R)) -> Self {
        let below = columns(equations, (c, s));
        let mut above = below;
        let mut triangle = [[R::zero(); SIZE]; SIZE];
        let mut first = [([R::zero(); ROWS], R::zero()); 3];
        for k in 0..3 {
            let (head, rest) = above.split_at_mut(k + 1);
            let v = mirror(&mut head[k], k);
            for column in rest {
                reflect(&v, column, k);
            }
            first[k] = v;
        }
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
        for k in 0..REST {
            let (head, later) = rest.split_at_mut(k + 1);
            let v = mirror(&mut head[k], k);
            for column in later {
                reflect(&v, column, k);
            }
            second[k] = v;
        }
        for j in 0..REST {
            for i in 0..=j {
                triangle[3 + j][3 + i] = rest[j][i];
            }
        }
        // No division by zero where the matrix is singular to the last digit.
        for k in 0..SIZE {
            let (x, least) = (triangle[k][k], R::splat(1e-30));
            triangle[k][k] = R::select(x.abs().lt(least), least, x);
        }
        Self { above: first, rest: second, triangle }
    }

    /// The solution for a right side.
    #[inline(always)]
    pub fn solve(&self, right: &Products<R>) -> Products<R> {
        let mut top = [R::zero(); ROWS];
        top.copy_from_slice(&right[..ROWS]);
        for (k, v) in self.above.iter().enumerate() {
            reflect(v, &mut top, k);
        }
        let mut low = [R::zero(); REST];
        low[..3].copy_from_slice(&top[3..]);
        low[3..].copy_from_slice(&right[ROWS..]);
        for (k, v) in self.rest.iter().enumerate() {
            reflect(v, &mut low, k);
        }
        let mut out = [R::zero(); SIZE];
        out[..3].copy_from_slice(&top[..3]);
        out[3..].copy_from_slice(&low);
        self.up(&mut out);
        out
    }

    /// Back substitution.
    #[inline(always)]
    fn up(&self, x: &mut Products<R>) {
        for k in (0..SIZE).rev() {
            x[k] = x[k] / self.triangle[k][k];
            for i in 0..k {
                x[i] = self.triangle[k][i].neg_mul_add(x[k], x[i]);
            }
        }
    }

    /// Back substitution with the transposed triangle.
    #[inline(always)]
    fn down(&self, x: &mut Products<R>) {
        for k in 0..SIZE {
            let mut sum = x[k];
            for i in 0..k {
                sum = self.triangle[k][i].neg_mul_add(x[i], sum);
            }
            x[k] = sum / self.triangle[k][k];
        }
    }

    /// The right singular vector of the smallest singular value, or of the next one after one
    /// that is known, by inverse iteration beside it.
    #[inline(always)]
    pub fn next(&self, known: Option<&Singular<R>>, rounds: usize) -> Singular<R> {
        let mut v = [R::zero(); SIZE];
        for (i, x) in v.iter_mut().enumerate() {
            // Nothing special: a start that no vector of an arm is likely to be across of.
            *x = R::splat(START[if known.is_some() { (i + 5) % SIZE } else { i }]);
        }
        let mut u = v;
        let mut size = R::zero();
        for _ in 0..rounds {
            if let Some(known) = known {
                without(&mut v, &known.right);
            }
            u = v;
            self.down(&mut u);
            if let Some(known) = known {
                without(&mut u, &known.left);
            }
            normalise(&mut u);
            v = u;
            self.up(&mut v);
            if let Some(known) = known {
                without(&mut v, &known.right);
            }
            size = normalise(&mut v);
        }
        let size = R::splat(1.0) / size.max(R::splat(f64::MIN_POSITIVE));
        Singular { right: v, left: u, size }
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

const START: [f64; SIZE] =
    [1.0, 0.71, -0.53, 0.87, -0.95, 0.62, 0.44, -0.78, 0.91, 0.37, 0.83, -0.59];

#[inline(always)]
fn without<R: Real>(v: &mut Products<R>, w: &Products<R>) {
    let mut along = R::zero();
    for i in 0..SIZE {
        along = v[i].mul_add(w[i], along);
    }
    for i in 0..SIZE {
        v[i] = w[i].neg_mul_add(along, v[i]);
    }
}

/// Makes the length 1; the length before.
#[inline(always)]
fn normalise<R: Real>(v: &mut Products<R>) -> R {
    // Numbers may be as large as the smallest singular value is small.
    let mut largest = R::splat(f64::MIN_POSITIVE);
    for x in v.iter() {
        largest = largest.max(x.abs());
    }
    let inverse = R::splat(1.0) / largest;
    let mut square = R::zero();
    for x in v.iter_mut() {
        *x *= inverse;
        square = x.mul_add(*x, square);
    }
    let size = square.sqrt();
    let inverse = R::splat(1.0) / size;
    for x in v.iter_mut() {
        *x *= inverse;
    }
    size * largest
}

/// How far the hidden angle is from where the matrix is singular, rad: the step of nonlinear
/// inverse iteration from a vector near to its null vector.
#[inline(always)]
pub fn distance<R: Real>(
    factors: &Factors<R>,
    equations: &Equations<R>,
    (s, c): (R, R),
    v: &Products<R>,
) -> R {
    let [_, cosine, sine] = equations;
    let mut right = [R::zero(); SIZE];
    for j in 0..9 {
        for i in 0..ROWS {
            let slope = sine[j][i].mul_add(c, -(cosine[j][i] * s));
            right[i] = slope.mul_add(v[j], right[i]);
            right[ROWS + i] = slope.mul_add(v[3 + j], right[ROWS + i]);
        }
    }
    let w = factors.solve(&right);
    let mut along = R::zero();
    for i in 0..SIZE {
        along = v[i].mul_add(w[i], along);
    }
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
    super::cut::unit_pair(b + b, a - c)
}

/// The combinations of two null vectors that are products: those that keep their direction from
/// one power of `x` to the next.
#[inline(always)]
pub fn two_products<R: Real>(one: &Products<R>, two: &Products<R>) -> [Products<R>; 2] {
    // Powers of the tangent of half an angle turned by a fixed one, so that none is infinite
    // where it matters.
    let (c, s) = (R::splat(TURN.0), R::splat(TURN.1));
    let ((l1, h1), (l2, h2)) = (low_high(one, c, s), low_high(two, c, s));
    let (aa, ab, bb) = (inner(&l1, &l1), inner(&l1, &l2), inner(&l2, &l2));
    let det = aa * bb - ab * ab;
    let det = R::select(det.lt(R::splat(1e-200)), R::splat(1e-200), det);
    let (x1, y1, x2, y2) = (inner(&l1, &h1), inner(&l2, &h1), inner(&l1, &h2), inner(&l2, &h2));
    let (p11, p21) = ((bb * x1 - ab * y1) / det, (aa * y1 - ab * x1) / det);
    let (p12, p22) = ((bb * x2 - ab * y2) / det, (aa * y2 - ab * x2) / det);
    // Eigenvectors of ((p11, p12), (p21, p22)); where they are complex their real part.
    let half = R::splat(0.5) * (p11 - p22);
    let root = half.mul_add(half, p12 * p21).max(R::zero()).sqrt();
    let mean = R::splat(0.5) * (p11 + p22);
    let mut out = [*one; 2];
    for (k, value) in [mean + root, mean - root].into_iter().enumerate() {
        let (x1, y1) = (p12, value - p11);
        let (x2, y2) = (value - p22, p21);
        let (n1, n2) = (x1.mul_add(x1, y1 * y1), x2.mul_add(x2, y2 * y2));
        let first = n2.lt(n1);
        let (x, y) = (R::select(first, x1, x2), R::select(first, y1, y2));
        for i in 0..SIZE {
            out[k][i] = one[i].mul_add(x, two[i] * y);
        }
    }
    out
}

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

#[inline(always)]
fn inner<R: Real>(a: &[R; 9], b: &[R; 9]) -> R {
    let mut sum = R::zero();
    for i in 0..9 {
        sum = a[i].mul_add(b[i], sum);
    }
    sum
}

/// Cosine and sine of the fixed angle.
const TURN: (f64, f64) = (0.877_582_561_890_372_8, 0.479_425_538_604_203);
