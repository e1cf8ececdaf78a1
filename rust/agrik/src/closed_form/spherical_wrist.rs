//! Six revolute joints of which the last three axes meet in a point.
//!
//! The wrist's centre does not move with the wrist, so the first three joints follow from
//! its place (see [`super::shoulder`]), at most four ways; the last three follow from the
//! orientation that is left, two ways each.

use super::candidates::{BRANCHES, Candidate, value};
use super::geometry::Geometry;
use super::shoulder::{Arm, Kind, Shoulder};
use super::turn::{Meeting, Turn, advance, components, identity};
use crate::lanes::{Real, V3, axpy, splat3, sub};
use crate::task::Goal;

/// A recognised arm.
#[derive(Debug, Clone, PartialEq)]
pub struct SphericalWrist {
    geometry: Geometry,
    shoulder: Shoulder,
    wrist: Meeting,
}

impl SphericalWrist {
    /// The arm of a geometry of six axes, or why it is none.
    pub fn new(geometry: Geometry) -> Result<Self, String> {
        let gap = geometry.gap(3);
        if gap > 0.0 {
            return Err(if gap.is_finite() {
                format!("its last three axes miss a common point by {:.3} mm", 1e3 * gap)
            } else {
                "two of its last three axes are parallel".to_owned()
            });
        }
        let shoulder = Shoulder::new(&geometry)?;
        let wrist = Meeting { one: geometry.links[3], two: geometry.links[4] };
        Ok(Self { geometry, shoulder, wrist })
    }

    /// The axes.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// How the position's equations come apart.
    pub fn kind(&self) -> Kind {
        self.shoulder.kind()
    }

    /// All branches for goals whose `position` is the tool point, `tool` away from the
    /// last joint's frame. An angle that nothing decides is taken from `preferred`, one
    /// turn a joint.
    #[inline(always)]
    pub fn solve<R: Real>(
        &self,
        goal: &Goal<R>,
        tool: [f64; 3],
        preferred: &[Turn<R>],
        out: &mut [Candidate<R>; BRANCHES],
    ) {
        let g = &self.geometry;
        let base = [splat3::<R>(g.axes[0]), splat3(g.axes[1]), splat3(g.axes[2])];
        let center = wrist_center(g, goal, tool);
        let p = components(base, sub(center, splat3(g.origin)));
        let mx = components(base, goal.axes[0]);
        let mz = components(base, goal.axes[2]);
        let wanted = [preferred[0], preferred[1], preferred[2]];
        let mut arms = [Arm::none(); 4];
        self.shoulder.solve(p, &wanted, &mut arms);
        for (i, arm) in arms.iter().enumerate() {
            let mut frame = identity::<R>();
            for (turn, link) in arm.turns.iter().zip(&g.links) {
                frame = advance(frame, *turn, link);
            }
            let (triples, merged, singular) =
                self.wrist.solve(components(frame, mx), components(frame, mz), preferred[3]);
            let first = [
                value(arm.turns[0], g.links[0].theta),
                value(arm.turns[1], g.links[1].theta),
                value(arm.turns[2], g.links[2].theta),
            ];
            for (j, triple) in triples.iter().enumerate() {
                let c = &mut out[2 * i + j];
                c.q[0] = first[0];
                c.q[1] = first[1];
                c.q[2] = first[2];
                c.q[3] = value(triple[0], g.links[3].theta);
                c.q[4] = value(triple[1], g.links[4].theta);
                c.q[5] = value(triple[2], g.last_theta);
                c.merged = arm.merged | if j == 1 { merged } else { 0 };
                c.singular = [arm.shoulder, arm.elbow, singular];
            }
        }
    }
}

/// The wrist's centre in the world: fixed to the last joint's frame, whose axes the goal
/// gives.
#[inline(always)]
pub fn wrist_center<R: Real>(g: &Geometry, goal: &Goal<R>, tool: [f64; 3]) -> V3<R> {
    let along = R::splat(g.last_shift - tool[2]);
    let p = axpy(goal.axes[2], along, goal.position);
    let p = axpy(goal.axes[0], R::splat(-tool[0]), p);
    axpy(goal.axes[1], R::splat(-tool[1]), p)
}
