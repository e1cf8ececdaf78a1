//! Angles known up to a bound: what a closed form's angles can be at most and at least where
//! its numbers are not known exactly.
//!
//! A target counts as reached within a tolerance, the recognised geometry differs a little
//! from the chain's, and numbers are rounded. An angle is therefore enclosed: the arc holds
//! the angle of every posture whose pose is that near to the target. Near a singularity arcs
//! grow, to the whole turn in the end. Every bound here errs towards arcs too long.

use std::f64::consts::{PI, TAU};

use super::limit::Limit;
use super::range::Range;
use super::turn::Meeting;
use crate::lanes::{V3, cross, hypotenuse};

/// Added to the half length of every arc that a function of the library made, rad: more than
/// the rounding of any of them.
const ROUNDING: f64 = 1e-12;

/// How far from a pose another one may be that still counts for it.
#[derive(Debug, Clone, Copy)]
pub struct Margin {
    /// Of the position, m.
    pub position: f64,
    /// Of the orientation, rad.
    pub turn: f64,
}

impl Margin {
    /// The same in other units of length, wider by what an arm is off from what it is taken for,
    /// and by the rounding of coordinates of a size.
    pub fn widened(self, length: f64, misfit: f64, size: f64) -> Self {
        Self {
            position: self.position / length + misfit + ROUNDED * size,
            turn: self.turn + misfit + ROUNDED,
        }
    }

    /// How far a point that is so far from the tool may be from where it is taken to be.
    pub fn at(&self, far: f64) -> f64 {
        self.position + far * self.turn
    }

    /// So wide that nothing follows.
    pub fn is_wide(&self) -> bool {
        !(self.position.is_finite() && self.turn < 1.0)
    }
}

/// The angles within `off` of `middle`, rad; all of them where `off` is pi or more.
#[derive(Debug, Clone, Copy)]
pub struct Arc {
    /// Middle of the arc.
    pub middle: f64,
    /// Half its length.
    pub off: f64,
}

impl Arc {
    /// The direction of a point of the plane that is known to within `error`.
    pub fn toward(x: f64, y: f64, error: f64) -> Self {
        let length = hypotenuse(x, y);
        if error < length {
            Self { middle: y.atan2(x), off: (error / length).asin() + ROUNDING }
        } else {
            Self::all()
        }
    }

    /// Any angle at all.
    pub fn all() -> Self {
        Self { middle: 0.0, off: PI }
    }

    /// Sums of an angle of this arc and one of another.
    pub fn plus(self, other: Self) -> Self {
        Self { middle: self.middle + other.middle, off: self.off + other.off }
    }

    /// Differences of an angle of this arc and one of another.
    pub fn minus(self, other: Self) -> Self {
        Self { middle: self.middle - other.middle, off: self.off + other.off }
    }

    /// The arc turned on by a known angle.
    pub fn turned(self, by: f64) -> Self {
        Self { middle: self.middle + by, ..self }
    }

    /// The angles of the other sign.
    fn mirrored(self) -> Self {
        Self { middle: -self.middle, ..self }
    }

    /// How far a point at unit distance can be from where the middle puts it.
    pub fn chord(&self) -> f64 {
        self.off.min(2.0)
    }

    /// No whole number of turns brings any angle of the arc inside the limits.
    pub fn is_outside(&self, limit: &Limit) -> bool {
        if !limit.half.is_finite() {
            return false;
        }
        let off = self.middle - limit.middle;
        let nearest = (off - TAU * (off / TAU).round()).abs();
        nearest > limit.half + self.off + ROUNDING
    }
}

/// What rounding may do to coordinates, as a share of their size.
const ROUNDED: f64 = 1e-11;

/// The angles between 0 and pi whose cosines are in a range; `None` where none is.
pub fn arc_cosines(range: Range) -> Option<Arc> {
    if range.low > 1.0 || range.high < -1.0 {
        return None;
    }
    let least = range.high.min(1.0).acos();
    let most = range.low.max(-1.0).acos();
    Some(Arc { middle: 0.5 * (least + most), off: 0.5 * (most - least) + ROUNDING })
}

/// Angles with `a cos + b sin = c` for every `(a, b)` within `error` and `c` of a range, on
/// each of the two sides; `None` where there is none.
pub fn linear_arcs(a: f64, b: f64, error: f64, c: Range) -> Option<[Arc; 2]> {
    let length = hypotenuse(a, b);
    if length <= error {
        let least = if c.low <= 0.0 && c.high >= 0.0 { 0.0 } else { c.low.abs().min(c.high.abs()) };
        return (least <= length + error).then(|| [Arc::all(), Arc::all()]);
    }
    let inverse = Range { low: length - error, high: length + error }.inverse();
    let away = arc_cosines(c.times(inverse))?;
    let toward = Arc::toward(a, b, error);
    Some([toward.plus(away), toward.minus(away)])
}

/// A rotation that is known to within an angle: its columns x and z, and that angle.
#[derive(Debug, Clone, Copy)]
pub struct Rotation {
    pub x: V3<f64>,
    pub z: V3<f64>,
    /// Angle of the rotation from here to any that is meant, rad.
    pub off: f64,
}

/// Three joints whose axes meet bring about no rotation that is meant within their limits, on
/// either side of the second one. See [`Meeting::solve`].
pub fn none_inside(meeting: &Meeting, wanted: &Rotation, limits: &[(Limit, f64); 3]) -> bool {
    let (s1, c1) = (meeting.one.sine, meeting.one.cosine);
    let (s2, c2) = (meeting.two.sine, meeting.two.cosine);
    let Rotation { x, z, off } = *wanted;
    let chord = off.min(2.0) + ROUNDING;
    let cosine = (c1 * c2 - z[2]) / (s1 * s2);
    let wide = chord / (s1 * s2).abs();
    let Some(second) = arc_cosines(Range { low: cosine - wide, high: cosine + wide }) else {
        return true;
    };
    let outside = |j: usize, arc: Arc| arc.turned(-limits[j].1).is_outside(&limits[j].0);
    [second, second.mirrored()].into_iter().all(|second| {
        if outside(1, second) {
            return true;
        }
        let (sine, cosine) = second.middle.sin_cos();
        let error = second.chord() + ROUNDING;
        let column = Arc::toward(z[0], z[1], chord);
        let up = Arc::toward(s2 * sine, -c1 * s2 * cosine - s1 * c2, s2.abs() * error);
        if outside(0, column.minus(up)) {
            return true;
        }
        // The third row's part across the third axis.
        let row = Arc::toward(x[2], cross(z, x)[2], chord);
        let down = Arc::toward(s1 * sine, c2 * s1 * cosine + s2 * c1, s1.abs() * error);
        outside(2, down.minus(row))
    })
}

/// Some joint is outside its limits, whichever of the arcs' angles it stands at; arcs of
/// turns, which are counted from offsets.
pub fn any_outside(arcs: &[Arc; 3], limits: &[(Limit, f64); 3]) -> bool {
    arcs.iter().zip(limits).any(|(arc, (limit, offset))| arc.turned(-offset).is_outside(limit))
}
