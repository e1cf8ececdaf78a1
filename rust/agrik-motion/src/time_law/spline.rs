//! Cubic splines through given values.

/// Second derivatives at the knots of the cubic spline through values, one more than there are
/// `lengths` between them. The outer two pieces at each end are one polynomial (not a knot);
/// with fewer than three pieces the ends do not bend.
pub(super) fn second_derivatives(lengths: &[f64], value: impl Fn(usize) -> f64) -> Vec<f64> {
    let pieces = lengths.len();
    let mut bends = vec![0.0; pieces + 1];
    if pieces < 2 {
        return bends;
    }
    // Rows of a matrix with three diagonals, for the inner knots.
    let inner = pieces - 1;
    let (mut below, mut on, mut above) = (vec![0.0; inner], vec![0.0; inner], vec![0.0; inner]);
    let mut right = vec![0.0; inner];
    for k in 0..inner {
        let (h, next) = (lengths[k], lengths[k + 1]);
        below[k] = h;
        on[k] = 2.0 * (h + next);
        above[k] = next;
        let slope = |i: usize| (value(i + 1) - value(i)) / lengths[i];
        right[k] = 6.0 * (slope(k + 1) - slope(k));
    }
    let knots_count = pieces >= 3;
    if knots_count {
        // The third derivative is the same on both sides of the second knot, and of the last
        // but one.
        let (h, next) = (lengths[0], lengths[1]);
        on[0] += h * (1.0 + h / next);
        above[0] -= h * h / next;
        let (h, before) = (lengths[pieces - 1], lengths[pieces - 2]);
        on[inner - 1] += h * (1.0 + h / before);
        below[inner - 1] -= h * h / before;
    }
    for k in 1..inner {
        let factor = below[k] / on[k - 1];
        on[k] -= factor * above[k - 1];
        right[k] -= factor * right[k - 1];
    }
    bends[inner] = right[inner - 1] / on[inner - 1];
    for k in (0..inner - 1).rev() {
        bends[k + 1] = (right[k] - above[k] * bends[k + 2]) / on[k];
    }
    if knots_count {
        let ratio = lengths[0] / lengths[1];
        bends[0] = bends[1] * (1.0 + ratio) - bends[2] * ratio;
        let ratio = lengths[pieces - 1] / lengths[pieces - 2];
        bends[pieces] = bends[inner] * (1.0 + ratio) - bends[inner - 1] * ratio;
    }
    bends
}
