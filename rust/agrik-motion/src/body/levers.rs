//! How far a joint moves a body at most: bounds of motion for what lies between postures.
//!
//! A core point of a body moves by no more than the sum over joints of a lever times the
//! joint's own way. The lever of a turning joint is a bound of the distance of the core from
//! its axis, that of a slide is 1. The radius round a core only travels with it.
//!
//! Levers stand in rows, one a joint value, of one entry a body.

use agrik::chain::{JointKind, Link};
use agrik_compute::lanes::{cross, dot, norm, sub};
use agrik_solids::{Point, Pose};

use super::bodies::Bodies;
use super::placed::Placed;

impl Bodies {
    /// Levers that hold at all postures within the limits: the lengths between a joint and the
    /// body's frame, and its farthest core point from there. m/rad or no unit; infinite
    /// behind a slide without limits.
    pub fn levers(&self) -> Vec<f64> {
        let (links, count) = (&self.chain().compiled().links, self.len());
        let mut levers = vec![0.0; self.chain().dof() * count];
        for body in 0..count {
            for (link, lever) in links.iter().zip(self.lasting_levers(body)).rev() {
                levers[link.variable * count + body] += link.multiplier.abs() * lever;
            }
        }
        levers
    }

    /// The same of each moving joint, one body after another; 0 for those that do not move it.
    pub(super) fn levers_of_joints(&self) -> Vec<f64> {
        let chain = self.chain();
        let (joints, moving) = (chain.joints(), chain.compiled().links.len());
        let mut levers = vec![0.0; moving * self.len()];
        for (b, body) in self.bodies().iter().enumerate() {
            let mut length =
                self.extreme_points_in_frame(b).into_iter().map(norm).fold(0.0, f64::max);
            if body.frame > joints.len() {
                length += chain.tool().translation.vector.norm();
            }
            let links = &chain.compiled().links[..self.moved_by(b)];
            let mut links = links.iter().zip(&mut levers[moving * b..]).rev();
            for joint in joints[..body.frame.min(joints.len())].iter().rev() {
                length += joint.after.translation.vector.norm();
                if joint.kind != JointKind::Fixed
                    && let Some((link, lever)) = links.next()
                {
                    *lever = if link.prismatic { 1.0 } else { length };
                    if link.prismatic {
                        let v = &chain.variables()[link.variable];
                        let (low, high) = (v.lower * link.multiplier, v.upper * link.multiplier);
                        length += (low + link.d).abs().max((high + link.d).abs());
                    }
                }
                length += joint.origin.translation.vector.norm();
            }
        }
        levers
    }

    /// Levers that hold at all postures with every joint value within `margin` (one number a
    /// joint value, rad or m) of where the bodies are placed: much shorter ones, worked out
    /// from the tip inwards, as what a joint further out moves is all that can take a body
    /// away from an axis.
    pub fn local_levers(&self, placed: &Placed, margin: &[f64]) -> Vec<f64> {
        let (links, count) = (&self.chain().compiled().links, self.len());
        let mut levers = vec![0.0; self.chain().dof() * count];
        let (mut points, mut of_links) = (Vec::new(), vec![0.0; links.len()]);
        for body in 0..count {
            let links = &links[..self.moved_by(body)];
            let mount = &self.mounts()[body];
            let pose = placed.frame(mount.link);
            points.clear();
            points.extend(mount.points.iter().map(|p| pose.point(*p)));
            let way = |link: &Link| (link.multiplier * margin[link.variable]).abs();
            link_levers(links, placed.frames(), &points, way, &mut of_links);
            for (link, lever) in links.iter().zip(&of_links) {
                levers[link.variable * count + body] += link.multiplier.abs() * lever;
            }
        }
        levers
    }

    /// The most that core points of a body move while the joint values change by `change`.
    pub fn motion_bound(&self, levers: &[f64], body: usize, change: &[f64]) -> f64 {
        let count = self.len();
        change.iter().enumerate().map(|(j, dq)| levers[j * count + body] * dq.abs()).sum()
    }

    /// The same seen from another body on the way to it, which the joints before that one do
    /// not change: the most that two bodies come nearer to each other. A joint value that
    /// moves several joints counts as if it were all of them.
    pub fn pair_bound(&self, levers: &[f64], (i, j): (usize, usize), change: &[f64]) -> f64 {
        let (near, far) = if self.moved_by(i) <= self.moved_by(j) { (i, j) } else { (j, i) };
        let links = &self.chain().compiled().links[self.moved_by(near)..self.moved_by(far)];
        let count = self.len();
        let between = |variable: usize| links.iter().any(|link| link.variable == variable);
        let moves = change.iter().enumerate().filter(|(v, _)| between(*v));
        moves.map(|(v, dq)| levers[v * count + far] * dq.abs()).sum()
    }

    /// Extreme points of a body's core in its own frame, m.
    fn extreme_points_in_frame(&self, body: usize) -> Vec<Point> {
        self.bodies()[body].shape.extreme_points()
    }
}

/// Levers of points that all of some links carry, one a link, while each joint stays within
/// `way` (rad or m) of where `frames` has it: the frame before each link, and more behind.
pub(crate) fn link_levers(
    links: &[Link],
    frames: &[Pose],
    points: &[Point],
    mut way: impl FnMut(&Link) -> f64,
    levers: &mut [f64],
) {
    // How far joints further out may take the points.
    let mut moved = 0.0;
    for (i, link) in links.iter().enumerate().rev() {
        levers[i] = if link.prismatic {
            1.0
        } else {
            let [x, y, z] = frames[i].rotation;
            let (axis, origin) = ([x[2], y[2], z[2]], frames[i].translation);
            let square = |p: &Point| {
                let across = cross(axis, sub(*p, origin));
                dot(across, across)
            };
            points.iter().map(square).fold(0.0, f64::max).sqrt() + moved
        };
        moved += levers[i] * way(link);
    }
}
