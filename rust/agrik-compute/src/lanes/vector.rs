//! Vectors of three numbers, each in every lane.

use super::{Arithmetic, Real};

/// Three lanes-wide components.
///
/// The functions on them are written out: `array::map` does not always inline, and what
/// does not inline is not compiled for the instruction set of the loop around it.
pub type V3<R> = [R; 3];

/// `a . b`
#[inline(always)]
pub fn dot<R: Arithmetic>(a: V3<R>, b: V3<R>) -> R {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

/// Length of a vector.
#[inline(always)]
pub fn norm<R: Arithmetic>(v: V3<R>) -> R {
    dot(v, v).sqrt()
}

/// `a x b`
#[inline(always)]
pub fn cross<R: Real>(a: V3<R>, b: V3<R>) -> V3<R> {
    [
        a[1].mul_add(b[2], -(a[2] * b[1])),
        a[2].mul_add(b[0], -(a[0] * b[2])),
        a[0].mul_add(b[1], -(a[1] * b[0])),
    ]
}

/// `a * s + b`
#[inline(always)]
pub fn axpy<R: Real>(a: V3<R>, s: R, b: V3<R>) -> V3<R> {
    [a[0].mul_add(s, b[0]), a[1].mul_add(s, b[1]), a[2].mul_add(s, b[2])]
}

/// `a * s`
#[inline(always)]
pub fn scale<R: Real>(a: V3<R>, s: R) -> V3<R> {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// `a * s + b * t`
#[inline(always)]
pub fn blend<R: Real>(a: V3<R>, s: R, b: V3<R>, t: R) -> V3<R> {
    axpy(a, s, scale(b, t))
}

/// `a * s - b * t`
#[inline(always)]
pub fn difference<R: Real>(a: V3<R>, s: R, b: V3<R>, t: R) -> V3<R> {
    let a = scale(a, s);
    [b[0].neg_mul_add(t, a[0]), b[1].neg_mul_add(t, a[1]), b[2].neg_mul_add(t, a[2])]
}

/// `-a`
#[inline(always)]
pub fn negate<R: Real>(a: V3<R>) -> V3<R> {
    [-a[0], -a[1], -a[2]]
}

/// `a` where the mask holds, else `b`.
#[inline(always)]
pub fn select3<R: Real>(mask: R::Mask, a: V3<R>, b: V3<R>) -> V3<R> {
    [R::select(mask, a[0], b[0]), R::select(mask, a[1], b[1]), R::select(mask, a[2], b[2])]
}

/// `a - b`
#[inline(always)]
pub fn sub<R: Arithmetic>(a: V3<R>, b: V3<R>) -> V3<R> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The same three numbers in every lane.
#[inline(always)]
pub fn splat3<R: Real>(v: [f64; 3]) -> V3<R> {
    [R::splat(v[0]), R::splat(v[1]), R::splat(v[2])]
}
