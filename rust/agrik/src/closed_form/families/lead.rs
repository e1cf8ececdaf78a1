//! An arm behind a first joint whose value is given: the pose to reach is moved back by what
//! the first joint does, and what is left is an arm with one joint less.
//!
//! This is the way of arms on a slide. Their slide is free, as an arm angle is: at each of
//! its values the arm behind it has its own branches.

use super::ClosedForm;
use crate::chain::{Chain, Reach};
use crate::error::{Error, Result};
use crate::lanes::{V3, axpy, cross, dot, scale, sub};

/// A chain without its first joint, and what that joint does.
#[derive(Debug)]
pub struct Lead {
    /// The arm behind the joint, which stands at [`Lead::at`].
    rest: Chain,
    /// Which entry of `q` the joint is.
    variable: usize,
    /// Value at which `rest` was made, rad or m.
    at: f64,
    /// Motion of the joint for each unit of its entry of `q`.
    multiplier: f64,
    prismatic: bool,
    /// Its axis: a point (m) and a unit vector, world.
    point: V3<f64>,
    axis: V3<f64>,
}

impl Lead {
    /// The first joint of a chain apart, or why it cannot be; found once for each chain.
    pub fn of(chain: &Chain) -> Result<&Self> {
        chain.memo(Self::apart).as_ref().map_err(Clone::clone)
    }

    /// The first joint apart, where it slides and the arm behind it has a spherical wrist.
    pub fn slide(chain: &Chain) -> Option<&Self> {
        // Cheap to refuse: most chains begin with a turn.
        if !chain.compiled().links.first().is_some_and(|link| link.prismatic) {
            return None;
        }
        let lead = Self::of(chain).ok()?;
        let wrist = matches!(ClosedForm::of(&lead.rest), Ok(ClosedForm::SphericalWrist(_)));
        wrist.then_some(lead)
    }

    fn apart(chain: &Chain) -> Result<Self> {
        let compiled = chain.compiled();
        let refuse = |why: &str| Error::argument("locked", "a first joint of its own", why);
        let Some(first) = compiled.links.first() else { return Err(refuse("no joint")) };
        if compiled.links[1..].iter().any(|link| link.variable == first.variable) {
            return Err(refuse("a first joint that another one follows"));
        }
        if chain.dof() < 2 {
            return Err(refuse("the only joint"));
        }
        let at = chain.variables()[first.variable].near_zero();
        Ok(Self {
            rest: chain.locked(&[(first.variable, at)])?,
            variable: first.variable,
            at,
            multiplier: first.multiplier,
            prismatic: first.prismatic,
            point: compiled.start_position,
            axis: compiled.start_rotation[2],
        })
    }

    /// The arm behind the joint.
    pub fn rest(&self) -> &Chain {
        &self.rest
    }

    /// Which entry of `q` the joint is.
    pub fn variable(&self) -> usize {
        self.variable
    }

    /// Way of the arm for each unit of the joint's value, world; none for a joint that turns.
    pub fn way(&self) -> Option<V3<f64>> {
        self.prismatic.then(|| scale(self.axis, self.multiplier))
    }

    /// A pose (4x4, row by row) that the whole chain is to reach with its first joint at
    /// `value`, as a pose for the rest.
    pub fn seen(&self, pose: &[f64; 16], value: f64) -> [f64; 16] {
        let back = self.multiplier * (self.at - value);
        let mut out = *pose;
        if self.prismatic {
            for (row, along) in self.axis.iter().enumerate() {
                out[4 * row + 3] = along.mul_add(back, pose[4 * row + 3]);
            }
            return out;
        }
        let column = |j: usize| [pose[j], pose[4 + j], pose[8 + j]];
        for j in 0..4 {
            let from = if j < 3 { column(j) } else { sub(column(3), self.point) };
            let turned = about(self.axis, back, from);
            let to = if j < 3 { turned } else { axpy(turned, 1.0, self.point) };
            for (row, x) in to.into_iter().enumerate() {
                out[4 * row + j] = x;
            }
        }
        out
    }

    /// Values of a slide between `lower` and `upper` at which a pose is within the rest's
    /// reach, which is that of the tool in use; `None` where there is none.
    pub fn within_reach(
        &self,
        pose: &[f64; 16],
        reach: &Reach,
        [lower, upper]: [f64; 2],
    ) -> Option<(f64, f64)> {
        let way = self.way()?;
        let place = [pose[3], pose[7], pose[11]];
        // |place - (value - at) way - center| <= radius, a quadratic in the value.
        let off = sub(axpy(way, self.at, place), reach.center);
        let (square, along) = (dot(way, way), dot(off, way));
        if square == 0.0 {
            return None;
        }
        let middle = along / square;
        let rest = dot(off, off) - along * middle;
        // Room for tolerances.
        let radius = reach.radius + 1e-3 * reach.size;
        let half = (radius * radius - rest) / square;
        if half.is_nan() || half < 0.0 {
            return None;
        }
        let half = half.sqrt();
        let (low, high) = ((middle - half).max(lower), (middle + half).min(upper));
        (low <= high).then_some((low, high))
    }
}

/// A vector turned about a unit vector.
fn about(axis: V3<f64>, angle: f64, v: V3<f64>) -> V3<f64> {
    let (s, c) = angle.sin_cos();
    let along = dot(axis, v);
    let across = axpy(axis, -along, v);
    let turned = axpy(cross(axis, v), s, scale(across, c));
    axpy(axis, along, turned)
}
