//! Columns made into triangles by mirrors (Householder's), in lanes.
//!
//! From which entry on a mirror works is part of its type, and loops over it are written out by
//! [`unrolled`]: columns of which only known places are touched stay in registers.

use crate::lanes::Real;

/// A block over again with a constant that counts.
macro_rules! unrolled {
    ($k:ident in [$($number:literal)*] $block:block) => {
        $({
            const $k: usize = $number;
            $block
        })*
    };
}
pub(crate) use unrolled;

/// Sum of the products from an entry on, in chains that do not wait for one another.
#[inline(always)]
pub fn inner<R: Real, const N: usize, const FROM: usize>(a: &[R; N], b: &[R; N]) -> R {
    let mut sums = [R::zero(); 3];
    for i in FROM..N {
        sums[i % 3] = a[i].mul_add(b[i], sums[i % 3]);
    }
    (sums[0] + sums[1]) + sums[2]
}

/// A mirror that takes the part of a column from an entry on to that entry, which is left in
/// its place; the first number is what the mirror's normal counts.
#[inline(always)]
pub fn mirror<R: Real, const N: usize, const FROM: usize>(column: &mut [R; N]) -> ([R; N], R) {
    let square = inner::<R, N, FROM>(column, column);
    let size = square.sqrt();
    let head = column[FROM];
    let end = R::select(head.lt(R::zero()), size, -size);
    let mut normal = *column;
    normal[FROM] = head - end;
    let weight = R::splat(1.0) / (square - head * end).max(R::splat(f64::MIN_POSITIVE));
    column[FROM] = end;
    (normal, weight)
}

/// A column in such a mirror.
#[inline(always)]
pub fn reflect<R: Real, const N: usize, const FROM: usize>(
    (normal, weight): &([R; N], R),
    column: &mut [R; N],
) {
    let along = inner::<R, N, FROM>(normal, column) * *weight;
    for i in FROM..N {
        column[i] = normal[i].neg_mul_add(along, column[i]);
    }
}
