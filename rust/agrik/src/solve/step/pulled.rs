//! A damped step with a second aim: to go towards a posture as far as the task leaves free.

use super::{Lengths, damped, dot, gram, squared_norm};
use crate::lanes::Real;
use crate::solve::linear::solve_spd_for;

/// Share of half the squared error that damps the step, as in Levenberg-Marquardt.
const DAMPING: f64 = 0.1;

/// `p + J^T (J J^T + added I)^-1 (e - J p)`: where the damping has vanished, `J^+ e` plus
/// the part of the pull `p` that lies in the null space of the task (Liegeois 1977).
///
/// Columns of joints that are held are zero, and so must be their entries of `pull`.
#[inline(always)]
pub(in crate::solve) fn step<R: Real, const M: usize>(
    columns: &[[R; M]],
    error: &[R; M],
    pull: &[R],
    lengths: &Lengths,
    change: &mut [R],
) {
    let added = lengths.added(squared_norm(error), DAMPING);
    let mut rest = *error;
    for (column, p) in columns.iter().zip(pull) {
        for (row, c) in rest.iter_mut().zip(column) {
            *row = (-*c).mul_add(*p, *row);
        }
    }
    damped::step(columns, &rest, added, lengths.pivot(), change);
    for (dq, p) in change.iter_mut().zip(pull) {
        *dq += *p;
    }
}

/// The part of a pull that lies in the null space of the task, and the step that removes the
/// error, from one elimination.
#[inline(always)]
pub(in crate::solve) fn apart<R: Real, const M: usize>(
    columns: &[[R; M]],
    error: &[R; M],
    pull: &[R],
    lengths: &Lengths,
    (along, back): (&mut [R], &mut [R]),
) {
    let added = lengths.added(squared_norm(error), DAMPING);
    let mut moved = [R::zero(); M];
    for (column, p) in columns.iter().zip(pull) {
        for (row, c) in moved.iter_mut().zip(column) {
            *row = c.mul_add(*p, *row);
        }
    }
    let mut a = gram(columns);
    for (i, row) in a.iter_mut().enumerate() {
        row[i] += added;
    }
    let [of_pull, of_error] = solve_spd_for(&mut a, [moved, *error], lengths.pivot());
    let joints = columns.iter().zip(pull).zip(along.iter_mut().zip(back));
    for ((column, p), (along, back)) in joints {
        *along = *p - dot(column, &of_pull);
        *back = dot(column, &of_error);
    }
}
