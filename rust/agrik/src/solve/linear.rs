//! Small symmetric systems, unrolled over the number of task rows.

use crate::lanes::Real;

/// Repeats a block for every index below the number of rows, each time with the index as a
/// constant: the matrices then live in registers, which a loop would not guarantee.
macro_rules! unrolled {
    ($index:ident < $end:expr, $block:block) => {
        unrolled!(@each $index, $end, $block, 0 1 2 3 4 5)
    };
    (@each $index:ident, $end:expr, $block:block, $($value:literal)*) => {
        $(if $value < $end {
            let $index: usize = $value;
            $block
        })*
    };
}

/// Solves `A x = b` for a positive definite `A` (lower triangle) by LDL^T.
///
/// Pivots are kept above `floor`, so that an `A` that is singular up to rounding gives a
/// long, finite `x`.
#[inline(always)]
pub(super) fn solve_spd<R: Real, const M: usize>(
    a: &mut [[R; M]; M],
    b: [R; M],
    floor: R,
) -> [R; M] {
    let [x] = solve_spd_for(a, [b], floor);
    x
}

/// [`solve_spd`] for several right sides.
#[inline(always)]
pub(super) fn solve_spd_for<R: Real, const M: usize, const K: usize>(
    a: &mut [[R; M]; M],
    mut b: [[R; M]; K],
    floor: R,
) -> [[R; M]; K] {
    let factored = Factored::above(*a, floor);
    for b in &mut b {
        *b = factored.solve(*b);
    }
    b
}

/// The factors `L D L^T` of a positive definite matrix, for many right-hand sides.
#[derive(Debug, Clone, Copy)]
pub(super) struct Factored<R, const M: usize> {
    /// Below the diagonal: `L`.
    lower: [[R; M]; M],
    /// `D`: what of each row is left by those before it.
    pub pivots: [R; M],
    inverse: [R; M],
}

impl<R: Real, const M: usize> Factored<R, M> {
    /// Factors of a matrix whose lower triangle is given.
    #[inline(always)]
    pub fn new(a: [[R; M]; M]) -> Self {
        Self::above(a, R::splat(f64::MIN_POSITIVE))
    }

    /// The same, with pivots kept above `floor` where they divide.
    #[inline(always)]
    fn above(mut a: [[R; M]; M], floor: R) -> Self {
        const { assert!(M <= 6, "`unrolled` counts to six") };
        let (mut pivots, mut inverse) = ([R::zero(); M], [R::zero(); M]);
        unrolled!(j < M, {
            pivots[j] = a[j][j];
            inverse[j] = R::splat(1.0) / a[j][j].max(floor);
            unrolled!(i < M, {
                if j < i {
                    let l = a[i][j] * inverse[j];
                    unrolled!(k < M, {
                        if j < k && k <= i {
                            a[i][k] = l.neg_mul_add(a[k][j], a[i][k]);
                        }
                    });
                }
            });
            // Column j now holds L D; scaling it waits until no pivot needs it any more.
            unrolled!(i < M, {
                if j < i {
                    a[i][j] *= inverse[j];
                }
            });
        });
        Self { lower: a, pivots, inverse }
    }

    /// The `x` of `A x = b`.
    #[inline(always)]
    pub fn solve(&self, mut b: [R; M]) -> [R; M] {
        unrolled!(j < M, {
            unrolled!(i < M, {
                if j < i {
                    b[i] = self.lower[i][j].neg_mul_add(b[j], b[i]);
                }
            });
        });
        unrolled!(j < M, {
            b[j] *= self.inverse[j];
        });
        unrolled!(l < M, {
            unrolled!(i < M, {
                if i < M - 1 - l {
                    b[i] = self.lower[M - 1 - l][i].neg_mul_add(b[M - 1 - l], b[i]);
                }
            });
        });
        b
    }
}

/// Eigenvalues and eigenvectors (columns) of a symmetric matrix, by cyclic Jacobi
/// rotations; a fixed number of sweeps, enough for full precision up to 6 rows.
#[inline(always)]
pub(super) fn eigen<R: Real, const M: usize>(mut a: [[R; M]; M]) -> ([R; M], [[R; M]; M]) {
    const SWEEPS: usize = 7;
    let mut v = [[R::zero(); M]; M];
    for (i, row) in v.iter_mut().enumerate() {
        row[i] = R::splat(1.0);
    }
    for _ in 0..SWEEPS {
        for p in 0..M {
            for q in p + 1..M {
                rotate(&mut a, &mut v, p, q);
            }
        }
    }
    let mut values = [R::zero(); M];
    for (i, value) in values.iter_mut().enumerate() {
        *value = a[i][i];
    }
    (values, v)
}

/// One Jacobi rotation that makes `a[p][q]` vanish (full symmetric storage).
#[inline(always)]
fn rotate<R: Real, const M: usize>(a: &mut [[R; M]; M], v: &mut [[R; M]; M], p: usize, q: usize) {
    let tiny = R::splat(1e-300);
    let apq = a[p][q];
    let vanishing = apq.abs().le(tiny);
    let theta = (a[q][q] - a[p][p]) / (R::select(vanishing, R::splat(1.0), apq) * R::splat(2.0));
    let t = R::splat(1.0) / (theta.abs() + theta.mul_add(theta, R::splat(1.0)).sqrt());
    let t = R::select(theta.lt(R::zero()), -t, t);
    let t = R::select(vanishing, R::zero(), t);
    let c = R::splat(1.0) / t.mul_add(t, R::splat(1.0)).sqrt();
    let s = t * c;
    for k in 0..M {
        let (akp, akq) = (a[k][p], a[k][q]);
        a[k][p] = c.mul_add(akp, -(s * akq));
        a[k][q] = s.mul_add(akp, c * akq);
    }
    for k in 0..M {
        let (apk, aqk) = (a[p][k], a[q][k]);
        a[p][k] = c.mul_add(apk, -(s * aqk));
        a[q][k] = s.mul_add(apk, c * aqk);
    }
    for row in v.iter_mut() {
        let (vp, vq) = (row[p], row[q]);
        row[p] = c.mul_add(vp, -(s * vq));
        row[q] = s.mul_add(vp, c * vq);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> [[f64; 3]; 3] {
        [[4.0, 1.0, -0.5], [1.0, 3.0, 0.25], [-0.5, 0.25, 2.0]]
    }

    #[test]
    fn ldlt_solves() {
        let a = sample();
        let x = solve_spd(&mut a.clone(), [1.0, -2.0, 0.5], 1e-300);
        for (row, b) in a.iter().zip([1.0, -2.0, 0.5]) {
            let got: f64 = row.iter().zip(x).map(|(a, x)| a * x).sum();
            assert!((got - b).abs() < 1e-14);
        }
    }

    #[test]
    fn factors_solve_as_well() {
        let a = sample();
        let factored = Factored::new(a);
        for b in [[4.0, 0.0, 0.0], [1.0, -2.0, 0.5]] {
            let once = solve_spd(&mut a.clone(), b, 1e-300);
            for (x, y) in factored.solve(b).iter().zip(once) {
                assert!((x - y).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn jacobi_rebuilds_the_matrix() {
        let a = sample();
        let (values, v) = eigen(a);
        for i in 0..3 {
            for j in 0..3 {
                let got: f64 = (0..3).map(|k| v[i][k] * values[k] * v[j][k]).sum();
                assert!((got - a[i][j]).abs() < 1e-13);
            }
        }
    }
}
