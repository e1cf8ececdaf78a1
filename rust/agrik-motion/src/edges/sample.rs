//! An arm at one posture of a way: where its frames are, and how fast they move.

use agrik::chain::Link;
use agrik::kinematics::FRAME;
use agrik_compute::lanes::{axpy, cross, dot};
use agrik_solids::{Point, Pose};

/// Frames at a posture, and what each of them does while the way goes on at a rate of 1.
#[derive(Debug, Clone)]
pub(super) struct Sample {
    /// The frame before each moving joint, and that after the last one.
    pub poses: Vec<Pose>,
    /// Of each of them the velocity that a point of it at the origin of the world would have,
    /// m, and the rotation, rad.
    twists: Vec<[Point; 2]>,
}

impl Sample {
    /// Of an arm whose base lies at `base`.
    pub fn new(base: Pose, links: usize) -> Self {
        Self { poses: vec![base; links + 1], twists: vec![[[0.0; 3]; 2]; links + 1] }
    }

    /// Takes up the frames of a posture, and the rate of each joint along the way.
    pub fn fill(&mut self, links: &[Link], frames: &[f64], rates: &[f64]) {
        let (frames, _) = frames.as_chunks::<FRAME>();
        for (i, (link, m)) in links.iter().zip(frames).enumerate() {
            let before = &self.poses[i];
            let [x, y, z] = before.rotation;
            let axis = [x[2], y[2], z[2]];
            let [linear, angular] = self.twists[i];
            self.twists[i + 1] = if link.prismatic {
                [axpy(axis, rates[i], linear), angular]
            } else {
                let moment = cross(before.translation, axis);
                [axpy(moment, rates[i], linear), axpy(axis, rates[i], angular)]
            };
            self.poses[i + 1] = Pose {
                rotation: [[m[0], m[1], m[2]], [m[3], m[4], m[5]], [m[6], m[7], m[8]]],
                translation: [m[9], m[10], m[11]],
            };
        }
    }

    /// The most that points of the frame after `to` joints move, seen from the frame after
    /// `from` of them, m for the whole way at the rate of now.
    pub fn speed(&self, from: usize, to: usize, points: &[Point]) -> f64 {
        let ([v, w], [u, t]) = (self.twists[to], self.twists[from]);
        let linear = [v[0] - u[0], v[1] - u[1], v[2] - u[2]];
        let angular = [w[0] - t[0], w[1] - t[1], w[2] - t[2]];
        let pose = &self.poses[to];
        let square = |p: &Point| {
            let v = axpy(cross(angular, pose.point(*p)), 1.0, linear);
            dot(v, v)
        };
        points.iter().map(square).fold(0.0, f64::max).sqrt()
    }
}
