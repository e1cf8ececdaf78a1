//! Damped least squares, also the inner step of Levenberg-Marquardt.

use super::{dot, gram};
use crate::lanes::Real;
use crate::solve::linear::solve_spd;

/// `J^T (J J^T + added I)^-1 e`, by an elimination with pivots of at least `pivot`.
#[inline(always)]
pub(super) fn step<R: Real, const M: usize>(
    columns: &[[R; M]],
    error: &[R; M],
    added: R,
    pivot: R,
    change: &mut [R],
) {
    let mut a = gram(columns);
    for (i, row) in a.iter_mut().enumerate() {
        row[i] += added;
    }
    let y = solve_spd(&mut a, *error, pivot);
    for (dq, column) in change.iter_mut().zip(columns) {
        *dq = dot(column, &y);
    }
}
