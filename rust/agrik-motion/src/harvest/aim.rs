//! A fruit to be picked: where the tool goes, and what may be touched there.

use std::collections::BTreeSet;

use agrik::chain::Tail;
use agrik_compute::lanes::sub;
use agrik_solids::{Exemption, Point, Pose, Scene, Solid};

use super::station::Station;
use super::surroundings::Minding;
use crate::Result;

/// What the tool is to reach.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// Its name.
    pub name: String,
    /// The grip point, m; no number where it is unknown.
    pub point: Point,
    /// Objects that the gripper may touch: the fruit and its stalk.
    pub objects: Vec<usize>,
}

/// How the tool comes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Approach {
    /// About the vertical, rad.
    pub psi: f64,
    /// Up, rad.
    pub tilt: f64,
    /// Grip point moved up the fruit, m.
    pub shift: f64,
}

impl Approach {
    /// Level, at the grip point.
    pub fn level(psi: f64) -> Self {
        Self { psi, tilt: 0.0, shift: 0.0 }
    }

    /// The pose of the tool, row by row: its z axis along the approach, its x axis down.
    pub fn pose(&self, [x, y, z]: Point) -> [f64; 16] {
        let (s, c) = self.psi.sin_cos();
        let (up, level) = self.tilt.sin_cos();
        let forward = [c * level, s * level, up];
        // At right angles to it and as far down as can be.
        let down = [c * up, s * up, -level];
        let side = [-s, c, 0.0];
        let side = [0, 1, 2].map(|k| {
            let cross = agrik_compute::lanes::cross(forward, down)[k];
            // Level approaches have the side to the last digit.
            if self.tilt == 0.0 { side[k] } else { cross }
        });
        let row = |k: usize, at: f64| [down[k], side[k], forward[k], at];
        let [a, b, c] = [row(0, x), row(1, y), row(2, z + self.shift)];
        let mut out = [0.0; 16];
        out[..4].copy_from_slice(&a);
        out[4..8].copy_from_slice(&b);
        out[8..12].copy_from_slice(&c);
        out[15] = 1.0;
        out
    }
}

/// A target at a station.
pub(super) struct Aim<'a> {
    pub station: &'a Station,
    pub point: Point,
    pub minding: Minding,
}

impl<'a> Aim<'a> {
    pub fn new(station: &'a Station, target: &Target) -> Result<Self> {
        let minding = Minding::new(&station.around, &target.objects)?;
        Ok(Self { station, point: target.point, minding })
    }

    /// What a body does not mind.
    pub fn exempt(&self, body: usize) -> &Exemption {
        self.minding.of(body)
    }

    /// What a body does not mind once some more objects are gone.
    pub fn exempt_and(&self, body: usize, gone: &BTreeSet<usize>) -> Exemption {
        self.exempt(body).and(gone.iter().copied(), self.station.around.scene.objects().len())
    }
}

impl Target {
    /// The object of a scene in which the grip point lies, if it is none of the target's.
    ///
    /// # Errors
    ///
    /// An object of the target is none of the scene's, or the point no place.
    pub fn inside(&self, scene: &Scene) -> Result<Option<usize>> {
        let solid = Solid::sphere(self.point, 0.0)?;
        let count = scene.objects().len();
        let own = Exemption::none().and(self.objects.iter().copied(), count);
        Ok(scene.hit(&solid, &own, 0.0))
    }
}

/// Where the last joint's frame is while the tool is at a pose.
pub(super) fn last_frame(pose: &[f64; 16], tail: &Tail) -> Pose {
    let target =
        [[pose[0], pose[1], pose[2]], [pose[4], pose[5], pose[6]], [pose[8], pose[9], pose[10]]];
    // R_joint = R_target R_tail^T; the tail's columns are its axes.
    let entry = |i: usize, j: usize| (0..3).map(|k| target[i][k] * tail.rotation[k][j]).sum();
    let rotation = [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j)));
    let turned = Pose { rotation, translation: [0.0; 3] };
    let place = [pose[3], pose[7], pose[11]];
    Pose { rotation, translation: sub(place, turned.direction(tail.translation)) }
}
