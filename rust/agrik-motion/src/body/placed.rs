//! The bodies of an arm at one posture.

use agrik::chain::Compiled;
use agrik::kinematics::FRAME;
use agrik_compute::lanes::{cross, dot, sub};
use agrik_solids::{Point, Pose, Solid};

use super::bodies::Bodies;

/// The bodies of an arm where they are at a posture. Made once for an arm by
/// [`Bodies::room`], and filled again and again.
#[derive(Debug, Clone)]
pub struct Placed {
    /// The frames as the lanes left them.
    pub(super) numbers: Vec<f64>,
    /// Where the frame after each moving joint lies, the base of all before them.
    poses: Vec<Pose>,
    solids: Vec<Solid>,
    /// Spheres round the bodies.
    spheres: Vec<(Point, f64)>,
    /// The tool point, m.
    tool: Point,
}

impl Placed {
    pub(super) fn new(bodies: &Bodies) -> Self {
        let chain = bodies.chain().compiled();
        let start = chain.start_rotation;
        let row = |k: usize| [start[0][k], start[1][k], start[2][k]];
        let base = Pose { rotation: [row(0), row(1), row(2)], translation: chain.start_position };
        let solids: Vec<Solid> = bodies.mounts().iter().map(|mount| mount.solid.clone()).collect();
        Self {
            numbers: Vec::new(),
            poses: vec![base; chain.links.len() + 1],
            spheres: solids.iter().map(Solid::bounding_sphere).collect(),
            solids,
            tool: [0.0; 3],
        }
    }

    /// Takes up the frames of one posture.
    pub(crate) fn fill(&mut self, bodies: &Bodies, frames: &[f64]) {
        let (frames, _) = frames.as_chunks::<FRAME>();
        for (pose, m) in self.poses[1..].iter_mut().zip(frames) {
            *pose = Pose {
                rotation: [[m[0], m[1], m[2]], [m[3], m[4], m[5]], [m[6], m[7], m[8]]],
                translation: [m[9], m[10], m[11]],
            };
        }
        let places = self.solids.iter_mut().zip(&mut self.spheres);
        for ((solid, sphere), mount) in places.zip(bodies.mounts()) {
            // What stands on the base stays where it is.
            if mount.link > 0 {
                *solid = mount.solid.placed(&self.poses[mount.link]);
                sphere.0 = solid.bounding_sphere().0;
            }
        }
        let last = self.poses.len() - 1;
        self.tool = self.poses[last].point(bodies.chain().compiled().tail.translation);
    }

    /// The bodies.
    pub fn solids(&self) -> &[Solid] {
        &self.solids
    }

    /// The tool point of the chain, m.
    pub fn tool(&self) -> Point {
        self.tool
    }

    /// Where the frame after so many moving joints lies; before the first one it is the frame
    /// that its axis is the z axis of, as with all of them.
    pub fn frame(&self, joints: usize) -> &Pose {
        &self.poses[joints]
    }

    /// All of them, from that of no joint on.
    pub(crate) fn frames(&self) -> &[Pose] {
        &self.poses
    }

    /// Centre and radius of a sphere round a body, m.
    pub fn sphere(&self, body: usize) -> (Point, f64) {
        self.spheres[body]
    }

    /// How a point that the first `joints` moving joints carry moves with each joint value,
    /// m/rad or no unit, along a direction: added to `to`, one entry per joint value, times
    /// `share`.
    pub fn add_rates(
        &self,
        chain: &Compiled,
        joints: usize,
        point: Point,
        direction: Point,
        share: f64,
        to: &mut [f64],
    ) {
        for (link, before) in chain.links[..joints].iter().zip(&self.poses) {
            let [x, y, z] = before.rotation;
            let axis = [x[2], y[2], z[2]];
            let along = if link.prismatic {
                dot(axis, direction)
            } else {
                dot(cross(axis, sub(point, before.translation)), direction)
            };
            to[link.variable] += share * link.multiplier * along;
        }
    }
}
