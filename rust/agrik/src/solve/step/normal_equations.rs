//! The pseudo-inverse in closed form, `J^T (J J^T)^-1`, for full-rank Jacobians.

use super::{dot, gram};
use crate::lanes::Real;
use crate::solve::linear::solve_spd;

/// Below this share of `trace^M` the determinant of `J J^T` counts as zero.
const SINGULAR: f64 = 1e-14;

/// A row below this share of the trace is one that does not count.
const FREE: f64 = 1e-28;

/// `J^T (J J^T)^-1 e`; no change where `J J^T` of the rows that count is singular.
#[inline(always)]
pub(super) fn step<R: Real, const M: usize>(columns: &[[R; M]], error: &[R; M], change: &mut [R]) {
    let mut a = gram(columns);
    let mut trace = a[0][0];
    for (i, row) in a.iter().enumerate().skip(1) {
        trace += row[i];
    }
    for (i, row) in a.iter_mut().enumerate() {
        row[i] = R::select(row[i].le(trace * R::splat(FREE)), trace, row[i]);
    }
    // The product of the pivots of an elimination, as a share of the trace.
    let mut reduced = a;
    let scale = R::splat(1.0) / trace.max(R::splat(1e-300));
    let mut determinant = R::splat(1.0);
    for j in 0..M {
        determinant *= reduced[j][j] * scale;
        let inverse = R::splat(1.0) / reduced[j][j].max(R::splat(1e-300));
        for i in j + 1..M {
            let l = reduced[i][j] * inverse;
            for k in j + 1..=i {
                reduced[i][k] = (-l).mul_add(reduced[k][j], reduced[i][k]);
            }
        }
    }
    let regular = R::splat(SINGULAR).lt(determinant.abs());
    let y = solve_spd(&mut a, *error, R::splat(1e-300));
    for (dq, column) in change.iter_mut().zip(columns) {
        *dq = R::select(regular, dot(column, &y), R::zero());
    }
}
