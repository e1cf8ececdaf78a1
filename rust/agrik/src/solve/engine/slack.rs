//! Steps towards the nearest place that is near enough, where tolerances are wide.
//!
//! The distance `d = |e| - r` of an error `e` from a sphere of radius `r` has the gradient
//! `e / |e|`: near the sphere the part of the rows' Jacobian along the error is all that
//! counts, and far away all of it does. Where an exact solution does not exist, least squares
//! about the goal come to rest outside the sphere although places inside may be had.

use crate::lanes::Real;
use crate::solve::setup::Slack;

/// How the rows of one block are changed.
#[derive(Debug, Clone, Copy)]
struct Block<R> {
    /// Share of the columns that is left.
    share: R,
    /// What of them is added along the error.
    along: R,
    /// The error's direction.
    direction: [R; 3],
}

/// How the rows of an error are changed: of the first three, then of the rest.
#[derive(Debug, Clone, Copy)]
pub(super) struct Relaxed<R>([Block<R>; 2]);

impl<R: Real> Block<R> {
    #[inline(always)]
    fn none() -> Self {
        Self { share: R::splat(1.0), along: R::zero(), direction: [R::zero(); 3] }
    }

    /// Takes `radius` off the length of an error.
    #[inline(always)]
    fn of(rows: &mut [R], radius: f64) -> Self {
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
        // Inside the error may grow as far as the sphere, and no farther: from half a radius on
        // it is held more and more, or a step for the other rows would lead far out again.
        let inside = (squared.sqrt() * R::splat(2.0 / radius) - R::splat(1.0)).max(R::zero());
        let along = R::select(outside, R::splat(1.0) - share, inside);
        Self { share, along, direction }
    }

    #[inline(always)]
    fn change(&self, column: &mut [R]) {
        let mut along = R::zero();
        for (d, x) in self.direction.iter().zip(column.iter()) {
            along = d.mul_add(*x, along);
        }
        let along = along * self.along;
        for (d, x) in self.direction.iter().zip(column) {
            *x = d.mul_add(along, *x * self.share);
        }
    }
}

impl<R: Real> Relaxed<R> {
    /// Nothing changes.
    #[inline(always)]
    pub fn none() -> Self {
        Self([Block::none(); 2])
    }

    /// Leaves of an error what is outside the tolerances.
    #[inline(always)]
    pub fn of<const M: usize>(rows: &mut [R; M], slack: Slack) -> Self {
        let (place, turn) = rows.split_at_mut(3);
        let mut relaxed = Self::none();
        if slack.position > 0.0 {
            relaxed.0[0] = Block::of(place, slack.position);
        }
        if slack.orientation > 0.0 {
            relaxed.0[1] = Block::of(turn, slack.orientation);
        }
        relaxed
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
