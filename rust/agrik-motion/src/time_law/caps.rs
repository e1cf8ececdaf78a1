//! What the joints' limits leave for speed, acceleration and jerk along the way.

use agrik::chain::MotionLimits;

use super::path::Piece;

/// Limits along the way: of the first, second and third derivative of the place by time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Caps {
    /// Largest speed.
    pub velocity: f64,
    /// Largest acceleration.
    pub acceleration: f64,
    /// Largest jerk.
    pub jerk: f64,
}

/// Share of a joint's acceleration and of its jerk that the curvature of the way may take
/// where the speed changes as well.
const SHARE: f64 = 0.5;

/// Sizes of the derivatives of a joint value by the place, on a piece of the way.
#[derive(Debug, Clone, Copy)]
struct Sizes {
    first: f64,
    second: f64,
    third: f64,
}

impl Caps {
    /// Nothing is asked for.
    pub const FREE: Self =
        Self { velocity: f64::INFINITY, acceleration: f64::INFINITY, jerk: f64::INFINITY };

    /// The highest even speed on a piece: all of a joint's acceleration and jerk may go into
    /// the curvature.
    pub fn even(piece: &Piece, limits: &[MotionLimits]) -> f64 {
        speed(piece, limits, 1.0, 1.0)
    }

    /// Limits that hold on all of some pieces while the speed changes.
    pub fn over<'a>(
        pieces: impl Iterator<Item = &'a Piece> + Clone,
        limits: &[MotionLimits],
        most: f64,
    ) -> Self {
        let fast = |piece| speed(piece, limits, SHARE, 0.5 * SHARE);
        let velocity = pieces.clone().map(fast).fold(most, f64::min);
        let mut acceleration = f64::INFINITY;
        each(pieces.clone(), limits, |size, limit| {
            let left = limit.acceleration - bent(size.second, velocity.powi(2));
            acceleration = acceleration.min(left / size.first);
            // The third derivative has a part with speed times acceleration.
            if size.second > 0.0 && limit.jerk.is_finite() {
                let part = 0.5 * SHARE * limit.jerk;
                acceleration = acceleration.min(part / (3.0 * size.second * velocity));
            }
        });
        let mut jerk = f64::INFINITY;
        each(pieces, limits, |size, limit| {
            let bend = bent(size.third, velocity.powi(3))
                + bent(3.0 * size.second, velocity * acceleration);
            jerk = jerk.min((limit.jerk - bend) / size.first);
        });
        Self { velocity, acceleration, jerk }
    }
}

/// `size * rate`, nothing for what is not bent, however fast it goes.
fn bent(size: f64, rate: f64) -> f64 {
    if size > 0.0 { size * rate } else { 0.0 }
}

/// Goes through the joints that move on pieces.
fn each<'a>(
    pieces: impl Iterator<Item = &'a Piece>,
    limits: &[MotionLimits],
    mut look: impl FnMut(Sizes, &MotionLimits),
) {
    for piece in pieces {
        for (joint, limit) in limits.iter().enumerate() {
            let [first, second, third] = piece.sizes(joint);
            if first > 0.0 {
                look(Sizes { first, second, third }, limit);
            }
        }
    }
}

/// The highest speed on a piece whose curvature takes no more than shares of the joints'
/// acceleration and jerk.
fn speed(piece: &Piece, limits: &[MotionLimits], of_acceleration: f64, of_jerk: f64) -> f64 {
    let mut speed = f64::INFINITY;
    each(std::iter::once(piece), limits, |size, limit| {
        speed = speed.min(limit.velocity / size.first);
        if size.second > 0.0 {
            speed = speed.min((of_acceleration * limit.acceleration / size.second).sqrt());
            speed = speed.min((of_jerk * limit.jerk / size.third).cbrt());
        }
    });
    speed
}
