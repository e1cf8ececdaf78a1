//! Six revolute joints of which the last three axes meet in a point.
//!
//! The wrist's centre does not move with the wrist, so the first three joints follow from
//! its place (see [`super::shoulder`]), at most four ways; the last three follow from the
//! orientation that is left, two ways each.

use super::Family;
use super::shoulder::{Arm, Kind, Shoulder};
use crate::closed_form::geometry::axes::Geometry;
use crate::closed_form::geometry::candidate::{Candidate, MOST_BRANCHES, values};
use crate::closed_form::geometry::enclosure::{Rotation, none_inside};
use crate::closed_form::geometry::limit::Limit;
use crate::closed_form::geometry::turn::{Meeting, Side, Turn, advance, components, identity};
use crate::lanes::{Real, V3, axpy, splat3, sub};
use crate::task::Goal;

/// No coordinate of a wrist's centre is taken to be larger, m.
const FARTHEST: f64 = 1e100;

/// A recognised arm.
#[derive(Debug, Clone, PartialEq)]
pub struct SphericalWrist {
    geometry: Geometry,
    shoulder: Shoulder,
    wrist: Meeting,
}

/// Up to four postures of the first three joints, two ways to turn the wrist.
impl Family for SphericalWrist {
    const BRANCHES: usize = 8;
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

    /// The first three joints.
    pub(crate) fn shoulder(&self) -> &Shoulder {
        &self.shoulder
    }

    /// The last three.
    pub(crate) fn wrist(&self) -> &Meeting {
        &self.wrist
    }

    /// No posture, whatever the limits, puts the last joint's frame within `off` (m) of where a
    /// goal has it with its orientation within `turn`, rad: proven.
    pub fn is_out_of_reach(&self, goal: &Goal<f64>, off: f64, turn: f64) -> bool {
        let wanted = self.wanted(goal, [0.0; 3]);
        let links = &self.geometry.links;
        self.shoulder.arcs(wanted.center, off).iter().all(|arcs| {
            let mut frame = identity::<f64>();
            for (arc, link) in arcs.iter().zip(links) {
                frame = advance(frame, arc.middle.sin_cos(), link);
            }
            let off = arcs.iter().map(|arc| arc.off).sum::<f64>() + turn;
            let (x, z) = (components(frame, wanted.x), components(frame, wanted.z));
            none_inside(&self.wrist, &Rotation { x, z, off }, &[(Limit::FREE, 0.0); 3])
        })
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
        out: &mut [Candidate<R>; MOST_BRANCHES],
    ) {
        let wanted = self.wanted(goal, tool);
        let arms = self.shoulder.solve(wanted.center, &first_three(preferred));
        for (arm, pair) in arms.iter().zip(out.as_chunks_mut().0) {
            *pair = self.with_wrist(arm, &wanted, preferred[3]);
        }
    }

    /// The branches `2 (first + i)` and the one after it in lane `i`, for one goal that is
    /// in every lane; over again from the fifth pair.
    #[inline(always)]
    pub fn side_by_side<R: Real>(
        &self,
        goal: &Goal<R>,
        tool: [f64; 3],
        preferred: &[Turn<R>],
        first: usize,
    ) -> [Candidate<R>; 2] {
        let wanted = self.wanted(goal, tool);
        let arm = self.shoulder.side_by_side(wanted.center, first, &first_three(preferred));
        self.with_wrist(&arm, &wanted, preferred[3])
    }

    /// A goal seen from the first joint.
    #[inline(always)]
    fn wanted<R: Real>(&self, goal: &Goal<R>, tool: [f64; 3]) -> Wanted<R> {
        let g = &self.geometry;
        let base = [splat3::<R>(g.axes[0]), splat3(g.axes[1]), splat3(g.axes[2])];
        // Farther away squares overflow, and what is out of reach gets no angles at all.
        let mut center = wrist_center(g, goal, tool);
        for x in &mut center {
            *x = x.max(R::splat(-FARTHEST)).min(R::splat(FARTHEST));
        }
        Wanted {
            center: components(base, sub(center, splat3(g.origin))),
            x: components(base, goal.axes[0]),
            z: components(base, goal.axes[2]),
        }
    }

    /// Both ways to turn the wrist at the end of an arm.
    #[inline(always)]
    fn with_wrist<R: Real>(
        &self,
        arm: &Arm<R>,
        wanted: &Wanted<R>,
        preferred: Turn<R>,
    ) -> [Candidate<R>; 2] {
        let links = &self.geometry.links;
        let mut frame = identity::<R>();
        for (turn, link) in arm.turns.iter().zip(links) {
            frame = advance(frame, *turn, link);
        }
        let (mx, mz) = (components(frame, wanted.x), components(frame, wanted.z));
        let first = values(&arm.turns, [links[0].theta, links[1].theta, links[2].theta]);
        let [one, two] = Side::both();
        [
            self.branch(arm, first, mx, mz, preferred, one),
            self.branch(arm, first, mx, mz, preferred, two),
        ]
    }

    #[inline(always)]
    fn branch<R: Real>(
        &self,
        arm: &Arm<R>,
        first: [R; 3],
        mx: V3<R>,
        mz: V3<R>,
        preferred: Turn<R>,
        side: Side<R>,
    ) -> Candidate<R> {
        let links = &self.geometry.links;
        let wrist = self.wrist.solve(mx, mz, preferred, side);
        let offsets = [links[3].theta, links[4].theta, self.geometry.last_theta];
        let last = values(&wrist.turns, offsets);
        Candidate {
            q: [first[0], first[1], first[2], last[0], last[1], last[2], R::zero()],
            merged: arm.merged | wrist.merged,
            singular: [arm.shoulder, arm.elbow, wrist.singular],
        }
    }
}

/// A goal seen from the first joint: the wrist's centre, and the x and z axes of the last
/// joint's frame.
struct Wanted<R> {
    center: V3<R>,
    x: V3<R>,
    z: V3<R>,
}

#[inline(always)]
fn first_three<R: Real>(preferred: &[Turn<R>]) -> [Turn<R>; 3] {
    [preferred[0], preferred[1], preferred[2]]
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
