//! The arm that the two-step method is for: six joints with a spherical wrist on a slide.

use std::sync::Arc;

use agrik::chain::{Chain, JointKind};
use agrik::closed_form::{ClosedForm, Lead};
use agrik::kinematics::{FRAME, moving_frames};
use agrik_solids::{Pose, Scene, Solid};

use super::surroundings::{Mode, Roles, Surroundings};
use super::table::DOF;
use crate::body::Bodies;
use crate::{Error, Result};

/// An arm on a slide, with bodies, in a crop.
#[derive(Debug)]
pub struct Station {
    pub(super) around: Surroundings,
    /// Bodies of the last link, where they are in its frame.
    hard: Vec<(usize, Solid)>,
    /// Bodies of the other links of the wrist, where they are in the last link's frame while
    /// the wrist is straight.
    soft: Vec<(usize, Solid)>,
    /// Moving bodies that are not on the last link, farthest out first.
    pub(super) rest: Vec<usize>,
}

impl Station {
    /// An arm with bodies in a scene.
    ///
    /// # Errors
    ///
    /// The arm is not six turning joints with a spherical wrist on a slide (says what is
    /// missing), or an index or a level is out of range.
    pub fn new(bodies: Arc<Bodies>, scene: Arc<Scene>, roles: &Roles, mode: Mode) -> Result<Self> {
        let chain = Arc::clone(bodies.chain());
        structure(&chain)?;
        let around = Surroundings::new(Arc::clone(&bodies), scene, roles, mode)?;
        let last = chain.compiled().links.len();
        let of = |wanted: std::ops::Range<usize>| -> Vec<usize> {
            (0..bodies.len()).filter(|body| wanted.contains(&bodies.moved_by(*body))).collect()
        };
        let straight = straight_wrist(&chain);
        let solid = |body: usize| &bodies.mounts()[body].solid;
        let mut rest = of(1..last);
        rest.sort_by_key(|body| std::cmp::Reverse(bodies.moved_by(*body)));
        Ok(Self {
            hard: of(last..last + 1).into_iter().map(|body| (body, solid(body).clone())).collect(),
            soft: of(last - 2..last)
                .into_iter()
                .map(|body| (body, solid(body).placed(&straight[bodies.moved_by(body) - 1])))
                .collect(),
            rest,
            around,
        })
    }

    /// The arm with its bodies in the crop.
    pub fn around(&self) -> &Surroundings {
        &self.around
    }

    /// The arm.
    pub fn chain(&self) -> &Arc<Chain> {
        self.around.chain()
    }

    /// The arm behind its slide.
    pub(super) fn lead(&self) -> Result<&Lead> {
        Lead::slide(self.around.chain()).ok_or_else(|| missing("a slide before six joints"))
    }

    /// Bodies of the last link where they are while it lies at a pose.
    pub(super) fn hard(&self, last: &Pose) -> impl Iterator<Item = (usize, Solid)> {
        self.hard.iter().map(|(body, solid)| (*body, solid.placed(last)))
    }

    /// Bodies of the wrist's other links, the wrist straight.
    pub(super) fn soft(&self, last: &Pose) -> impl Iterator<Item = (usize, Solid)> {
        self.soft.iter().map(|(body, solid)| (*body, solid.placed(last)))
    }
}

fn missing(what: &str) -> Error {
    Error::argument("robot", "a slide, then six turning joints with a spherical wrist", what)
}

/// Refuses arms that the two-step method is not for, and says what is missing.
fn structure(chain: &Chain) -> Result<()> {
    let name = chain.name();
    let variables = chain.variables();
    let first = chain.compiled().links.first().map(|link| &variables[link.variable]);
    if let Some(first) = first
        && first.kind != JointKind::Prismatic
    {
        let what = format!("'{name}', whose first joint '{}' turns: no slide", first.name);
        return Err(missing(&what));
    }
    let lead = Lead::of(chain).map_err(|error| missing(&format!("'{name}': {error}")))?;
    match ClosedForm::of(lead.rest()) {
        Ok(ClosedForm::SphericalWrist(_)) => {}
        Ok(_) => return Err(missing(&format!("'{name}', which has seven joints on its slide"))),
        Err(why) => return Err(missing(&format!("on its slide {why}"))),
    }
    if chain.dof() != DOF {
        return Err(missing(&format!("'{name}', which has {} joint values", chain.dof())));
    }
    let slide = &variables[lead.variable()];
    if !(slide.lower.is_finite() && slide.upper.is_finite()) {
        return Err(missing(&format!("'{name}', whose slide '{}' has no ends", slide.name)));
    }
    Ok(())
}

/// Where the frames of the moving joints are in that of the last one, with the last joints in
/// the middle of their limits.
fn straight_wrist(chain: &Chain) -> Vec<Pose> {
    let q: Vec<f64> = chain.variables().iter().map(|v| v.middle()).collect();
    let mut frames = vec![0.0; FRAME * chain.compiled().links.len()];
    moving_frames(chain, &q, &mut frames);
    let poses: Vec<Pose> = frames.as_chunks::<FRAME>().0.iter().map(pose_of_frame).collect();
    let last = poses[poses.len() - 1];
    poses.iter().map(|pose| inverse(&last).of(pose)).collect()
}

/// A frame as kinematics gives it.
fn pose_of_frame(m: &[f64; FRAME]) -> Pose {
    Pose {
        rotation: [[m[0], m[1], m[2]], [m[3], m[4], m[5]], [m[6], m[7], m[8]]],
        translation: [m[9], m[10], m[11]],
    }
}

/// The pose of the outer frame in the inner one.
fn inverse(pose: &Pose) -> Pose {
    let r = &pose.rotation;
    let row = |k: usize| [r[0][k], r[1][k], r[2][k]];
    let rotation = [row(0), row(1), row(2)];
    Pose { rotation, translation: pose.inner_direction(pose.translation).map(|x| -x) }
}
