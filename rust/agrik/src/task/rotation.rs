//! Rotations between frames and directions, as vectors.

use crate::lanes::{Real, V3, angle_over_sine, axpy, cross, dot, scale, select3};

/// The factor from a rotation's sine (squared) and cosine to its angle over its sine, and
/// where the two directions are opposite, so that the sine says nothing.
#[inline(always)]
pub(super) fn angle_factor<R: Real>(sine2: R, cosine: R) -> (R, R::Mask) {
    let near = angle_over_sine(cosine.abs().min(R::splat(1.0)));
    let obtuse = cosine.lt(R::zero());
    let never = R::mask_from_bits(0);
    if R::bits(obtuse) == 0 {
        return (near, never);
    }
    // angle = pi - acos(|c|) beyond a right angle.
    let sine = sine2.max(R::splat(1e-200)).sqrt();
    let far = R::splat(std::f64::consts::PI) / sine - near;
    let opposite = R::and(obtuse, sine2.lt(R::splat(1e-14)));
    (R::select(obtuse, far, near), opposite)
}

/// The rotation vector that takes the frame `from` (columns) to the frame `to`.
#[inline(always)]
pub fn rotation_between<R: Real>(from: [V3<R>; 3], to: [V3<R>; 3]) -> V3<R> {
    let half = R::splat(0.5);
    let mut twice = cross(from[0], to[0]);
    let mut trace = dot(from[0], to[0]);
    for k in 1..3 {
        let c = cross(from[k], to[k]);
        twice = [twice[0] + c[0], twice[1] + c[1], twice[2] + c[2]];
        trace += dot(from[k], to[k]);
    }
    let sine = scale(twice, half);
    let cosine = (trace - R::splat(1.0)) * half;
    let (factor, opposite) = angle_factor(dot(sine, sine), cosine);
    let vector = scale(sine, factor);
    if R::bits(opposite) == 0 {
        return vector;
    }
    let turned = scale(half_turn_axis(from, to), R::splat(std::f64::consts::PI));
    select3::<R>(opposite, turned, vector)
}

/// Axis of a rotation by half a turn: the longest column of R + 1, made unit length.
#[inline(always)]
fn half_turn_axis<R: Real>(from: [V3<R>; 3], to: [V3<R>; 3]) -> V3<R> {
    // R = sum of to_k from_k^T; column j of R is sum of to_k * from_k[j].
    let zero = [R::zero(); 3];
    let mut best = zero;
    let mut best2 = R::zero();
    for j in 0..3 {
        let mut column = zero;
        for k in 0..3 {
            column = axpy(to[k], from[k][j], column);
        }
        column[j] += R::splat(1.0);
        let length2 = dot(column, column);
        let better = best2.lt(length2);
        best2 = R::select(better, length2, best2);
        best = select3::<R>(better, column, best);
    }
    scale(best, R::splat(1.0) / best2.sqrt())
}
