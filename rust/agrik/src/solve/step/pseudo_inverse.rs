//! The Moore-Penrose pseudo-inverse through the eigenvectors of `J J^T`.

use super::{dot, gram};
use crate::lanes::Real;
use crate::solve::linear::eigen;

/// `J^+ e`; directions whose singular value is below `cutoff` times the largest are left
/// out, so that a singular posture gives a short step rather than a wild one.
#[inline(always)]
pub(super) fn step<R: Real, const M: usize>(
    columns: &[[R; M]],
    error: &[R; M],
    cutoff: f64,
    change: &mut [R],
) {
    let mut a = gram(columns);
    for i in 0..M {
        for k in i + 1..M {
            a[i][k] = a[k][i];
        }
    }
    let (values, vectors) = eigen(a);
    let mut largest = values[0];
    for value in &values[1..] {
        largest = largest.max(*value);
    }
    // Eigenvalues of J J^T are squares of singular values.
    let floor = (largest * R::splat(cutoff * cutoff)).max(R::splat(1e-300));
    let mut y = [R::zero(); M];
    for k in 0..M {
        let mut along = R::zero();
        for i in 0..M {
            along = vectors[i][k].mul_add(error[i], along);
        }
        let kept = floor.lt(values[k]);
        let scaled = along / R::select(kept, values[k], R::splat(1.0));
        let scaled = R::select(kept, scaled, R::zero());
        for i in 0..M {
            y[i] = vectors[i][k].mul_add(scaled, y[i]);
        }
    }
    for (dq, column) in change.iter_mut().zip(columns) {
        *dq = dot(column, &y);
    }
}
