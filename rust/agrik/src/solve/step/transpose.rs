//! The Jacobian transpose with Buss's step length.

use super::{dot, squared_norm};
use crate::lanes::Real;

/// Below this share of `trace(J J^T) |e|` the length of `J J^T e` counts as zero.
const VANISHING: f64 = 1e-12;

/// `alpha J^T e`, `alpha = |J^T e|^2 / |J J^T e|^2`; no step where the gradient vanishes.
#[inline(always)]
pub(super) fn step<R: Real, const M: usize>(columns: &[[R; M]], error: &[R; M], change: &mut [R]) {
    let mut through = [R::zero(); M];
    let mut gradient2 = R::zero();
    let mut trace = R::zero();
    for (dq, column) in change.iter_mut().zip(columns) {
        let g = dot(column, error);
        for (t, c) in through.iter_mut().zip(column) {
            *t = c.mul_add(g, *t);
        }
        gradient2 = g.mul_add(g, gradient2);
        trace += squared_norm(column);
        *dq = g;
    }
    let through2 = squared_norm(&through);
    // With no gradient the step length is 0/0 although an error is left.
    let floor = R::splat(VANISHING * VANISHING) * trace * trace * squared_norm(error);
    let vanishing = through2.le(floor.max(R::splat(1e-300)));
    let alpha = gradient2 / R::select(vanishing, R::splat(1.0), through2);
    let alpha = R::select(vanishing, R::zero(), alpha);
    for dq in change {
        *dq *= alpha;
    }
}

/// `alpha J^T e`.
#[inline(always)]
pub(super) fn fixed_step<R: Real, const M: usize>(
    columns: &[[R; M]],
    error: &[R; M],
    alpha: f64,
    change: &mut [R],
) {
    for (dq, column) in change.iter_mut().zip(columns) {
        *dq = dot(column, error) * R::splat(alpha);
    }
}
