//! Goals and equations as rows of numbers, and rows side by side in the lanes.

use super::cut::{Equations, ROWS};
use super::resultant::Columns;
use crate::closed_form::geometry::rigid::Rigid;
use crate::lanes::{Real, WIDEST};

/// Numbers of the equations of a goal.
pub const NUMBERS: usize = 27 * ROWS;
/// Numbers of a goal.
pub const MOTION: usize = 12;

/// A goal as numbers in a row.
pub fn flat(goal: &Rigid<f64>) -> [f64; MOTION] {
    let [x, y, z] = goal.axes;
    let t = goal.shift;
    [x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2], t[0], t[1], t[2]]
}

/// Rows of numbers, one a lane (the last over again where there are fewer), as lanes.
#[inline(always)]
pub fn gather<R: Real, const N: usize>(rows: &[&[f64; N]; WIDEST]) -> [R; N] {
    let mut out = [R::zero(); N];
    for (k, x) in out.iter_mut().enumerate() {
        let mut one = [0.0; WIDEST];
        for lane in 0..R::WIDTH {
            one[lane] = rows[lane][k];
        }
        *x = R::load(&one);
    }
    out
}

/// The same of rows of which many lanes share one: a number is read once for all of them.
#[inline(always)]
pub fn spread<R: Real, const N: usize>(rows: &[&[f64; N]; WIDEST]) -> [R; N] {
    let mut out = rows[0].map(R::splat);
    let mut open = used(R::WIDTH);
    open &= !sharing::<R, N>(rows, rows[0]);
    while open != 0 {
        let row = rows[open.trailing_zeros() as usize];
        let lanes = sharing::<R, N>(rows, row);
        let mask = R::mask_from_bits(lanes);
        for (x, from) in out.iter_mut().zip(row) {
            *x = R::select(mask, R::splat(*from), *x);
        }
        open &= !lanes;
    }
    out
}

/// One lane of numbers.
#[inline(always)]
pub fn lane_of<R: Real, const N: usize>(numbers: &[R; N], lane: usize) -> [f64; N] {
    let mut out = [0.0; N];
    for (x, from) in out.iter_mut().zip(numbers) {
        *x = from.lane(lane);
    }
    out
}

/// The motion of twelve numbers.
#[inline(always)]
pub fn motion<R: Real>(x: &[R; MOTION]) -> Rigid<R> {
    let axes = [[x[0], x[1], x[2]], [x[3], x[4], x[5]], [x[6], x[7], x[8]]];
    Rigid { axes, shift: [x[9], x[10], x[11]] }
}

/// Equations in a row of numbers.
#[inline(always)]
pub fn in_row<R: Real>(k: &Equations<R>) -> [R; NUMBERS] {
    let mut out = [R::zero(); NUMBERS];
    for a in 0..3 {
        for j in 0..9 {
            for i in 0..ROWS {
                out[(9 * a + j) * ROWS + i] = k[a][j][i];
            }
        }
    }
    out
}

/// The columns of the equations at a value (sine, cosine) of the hidden angle in each lane, and
/// with `SLOPES` their derivatives, of rows as [`spread`] has them.
#[inline(always)]
pub fn columns_at<R: Real, const SLOPES: bool>(
    rows: &[&[f64; NUMBERS]; WIDEST],
    (s, c): (R, R),
) -> Columns<R> {
    const PART: usize = 9 * ROWS;
    let mut out = [[R::zero(); ROWS]; 9];
    let mut open = used(R::WIDTH);
    while open != 0 {
        let row = rows[open.trailing_zeros() as usize];
        let lanes = sharing::<R, NUMBERS>(rows, row);
        let mask = R::mask_from_bits(lanes);
        for j in 0..9 {
            for i in 0..ROWS {
                let part = |k: usize| R::splat(row[k * PART + j * ROWS + i]);
                let x = if SLOPES {
                    c.mul_add(part(2), -(s * part(1)))
                } else {
                    s.mul_add(part(2), c.mul_add(part(1), part(0)))
                };
                out[j][i] = R::select(mask, x, out[j][i]);
            }
        }
        open &= !lanes;
    }
    out
}

/// The lanes whose row is this one.
#[inline(always)]
fn sharing<R: Real, const N: usize>(rows: &[&[f64; N]; WIDEST], row: &[f64; N]) -> u32 {
    (0..R::WIDTH).fold(0, |all, lane| all | u32::from(std::ptr::eq(rows[lane], row)) << lane)
}

/// Lanes that hold something of a group, a bit each.
#[inline(always)]
pub fn used(count: usize) -> u32 {
    u32::MAX >> (32 - count as u32)
}
