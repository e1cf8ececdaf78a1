//! Steps towards the nearest place that is near enough, where tolerances are wide.
//!
//! The distance `d = |e| - r` of an error `e` from a sphere of radius `r` has the gradient
//! `e / |e|`: near the sphere the part of the rows' Jacobian along the error is all that
//! counts, and far away all of it does. Where an exact solution does not exist, least squares
//! about the goal come to rest outside the sphere although places inside may be had. Rows with
//! bounds of their own are spheres of one dimension.

use crate::lanes::Real;
use crate::solve::setup::{Room, Slack};

/// How the rows of one block are changed.
#[derive(Debug, Clone, Copy)]
enum Block<R> {
    /// Not at all.
    Whole,
    /// Together.
    Ball {
        /// Share of the columns that is left.
        share: R,
        /// What of them is added along the error.
        along: R,
        /// The error's direction.
        direction: [R; 3],
    },
    /// Row by row: share of each that is left.
    Box([R; 3]),
}

/// How the rows of an error are changed: of the first three, then of the rest.
#[derive(Debug, Clone, Copy)]
pub(super) struct Relaxed<R>([Block<R>; 2]);

/// Share of its rows by which an error inside its sphere is held: it may grow as far as the
/// sphere, and no farther, or a step for the other rows would lead far out again. From the given
/// share of the radius on it is held more and more.
#[inline(always)]
fn held<R: Real>(length: R, radius: f64, from: f64) -> R {
    let slope = 1.0 / (1.0 - from);
    length.mul_add(R::splat(slope / radius), R::splat(-from * slope)).max(R::zero())
}

/// From which share of the radius on: of a sphere, and of a single row, which others may need
/// to be right at its bound.
const HELD: f64 = 0.5;
const HELD_ROW: f64 = 0.9;

impl<R: Real> Block<R> {
    #[inline(always)]
    fn of(rows: &mut [R], room: Room) -> Self {
        match room {
            Room::None => Self::Whole,
            Room::Ball(radius) => Self::ball(rows, radius),
            Room::Box(radii) => Self::each(rows, radii),
        }
    }

    /// Takes its radius off each row.
    #[inline(always)]
    fn each(rows: &mut [R], radii: [f64; 3]) -> Self {
        let mut shares = [R::splat(1.0); 3];
        for ((x, radius), share) in rows.iter_mut().zip(radii).zip(&mut shares) {
            if radius > 0.0 {
                let length = x.abs();
                let left = length - R::splat(radius);
                let outside = R::zero().lt(left);
                let sign = R::select(x.lt(R::zero()), R::splat(-1.0), R::splat(1.0));
                *share = R::select(outside, R::splat(1.0), held(length, radius, HELD_ROW));
                *x = R::select(outside, sign * left, R::zero());
            }
        }
        Self::Box(shares)
    }

    /// Takes `radius` off the length of an error.
    #[inline(always)]
    fn ball(rows: &mut [R], radius: f64) -> Self {
        let mut squared = R::splat(1e-300);
        for x in rows.iter() {
            squared = x.mul_add(*x, squared);
        }
        let inverse = R::splat(1.0) / squared.sqrt();
        let share = (-inverse).mul_add(R::splat(radius), R::splat(1.0));
        let outside = R::zero().lt(share);
        let left = R::select(outside, share, R::zero());
        let mut direction = [R::zero(); 3];
        for (d, x) in direction.iter_mut().zip(rows) {
            *d = *x * inverse;
            *x *= left;
        }
        // Nothing across from two radii on.
        let share = (left + left - R::splat(1.0)).max(R::zero());
        let held = held(squared.sqrt(), radius, HELD);
        let along = R::select(outside, R::splat(1.0) - share, held);
        Self::Ball { share, along, direction }
    }

    #[inline(always)]
    fn change(&self, column: &mut [R]) {
        match self {
            Self::Whole => {}
            Self::Ball { share, along, direction } => {
                let mut sum = R::zero();
                for (d, x) in direction.iter().zip(column.iter()) {
                    sum = d.mul_add(*x, sum);
                }
                let sum = sum * *along;
                for (d, x) in direction.iter().zip(column) {
                    *x = d.mul_add(sum, *x * *share);
                }
            }
            Self::Box(shares) => {
                for (share, x) in shares.iter().zip(column) {
                    *x *= *share;
                }
            }
        }
    }
}

impl<R: Real> Relaxed<R> {
    /// Nothing changes.
    #[inline(always)]
    pub fn none() -> Self {
        Self([Block::Whole; 2])
    }

    /// Leaves of an error what is outside the tolerances.
    #[inline(always)]
    pub fn of<const M: usize>(rows: &mut [R; M], slack: Slack) -> Self {
        let (place, turn) = rows.split_at_mut(3);
        Self([Block::of(place, slack.position), Block::of(turn, slack.orientation)])
    }

    /// Changes the columns of the Jacobian alike.
    #[inline(always)]
    pub fn change<const M: usize>(&self, columns: &mut [[R; M]]) {
        for column in columns {
            let (place, turn) = column.split_at_mut(3);
            self.0[0].change(place);
            self.0[1].change(turn);
        }
    }
}
