//! The arm with its bodies in a crop, as the two-step method asks it.

use std::sync::Arc;

use agrik::chain::{Chain, JointKind};
use agrik::closed_form::{ClosedForm, Lead};
use agrik::kinematics::{FRAME, moving_frames};
use agrik_solids::{Core, Cover, Exemption, Pose, Scene, Solid, Spheres, Split, distance, within};

use super::table::DOF;
use crate::body::{Bodies, Collider, Placed};
use crate::{Error, Result};

/// How the bodies meet the crop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Boxes as the spheres of their cells, as in the paper: 8^level of them.
    Tree {
        /// 0 to [`agrik_solids::cover::FINEST`].
        level: usize,
        /// How cells are cut.
        split: Split,
    },
    /// Every body as it is.
    Exact,
}

/// A thing that a posture may not touch, but may be near: the slide's rail, the vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Static {
    /// Which object of the scene.
    pub object: usize,
}

/// An arm on a slide, with bodies, in a crop.
#[derive(Debug)]
pub struct Station {
    pub(super) bodies: Arc<Bodies>,
    pub(super) scene: Arc<Scene>,
    collider: Collider,
    mode: Mode,
    covers: Vec<Option<Cover>>,
    /// Objects that count as touched or not, and for each solid of them who minds it.
    pub(super) statics: Vec<usize>,
    fixed: Vec<(Solid, Vec<usize>)>,
    /// What may touch a target.
    pub(super) touching: Vec<bool>,
    /// Bodies of the last link, where they are in its frame.
    hard: Vec<(usize, Solid)>,
    /// Bodies of the other links of the wrist, where they are in the last link's frame while
    /// the wrist is straight.
    soft: Vec<(usize, Solid)>,
    /// Bodies that the two above leave, farthest out first.
    pub(super) rest: Vec<usize>,
}

impl Station {
    /// An arm with bodies in a scene. Objects of `statics` are only never touched;
    /// `static_skip` are pairs of a body and an object that do not mind each other; `touching`
    /// are bodies that may touch a target.
    ///
    /// # Errors
    ///
    /// The arm is not six turning joints with a spherical wrist on a slide (says what is
    /// missing), or an index or a level is out of range.
    pub fn new(
        bodies: Arc<Bodies>,
        scene: Arc<Scene>,
        statics: &[Static],
        static_skip: &[(usize, usize)],
        touching: &[usize],
        mode: Mode,
    ) -> Result<Self> {
        let chain = Arc::clone(bodies.chain());
        structure(&chain)?;
        let count = bodies.len();
        if let Some(body) = touching.iter().find(|body| **body >= count) {
            return Err(Error::argument("touching", format!("bodies, 0 to {count} - 1"), body));
        }
        if let Mode::Tree { level, .. } = mode
            && level > agrik_solids::cover::FINEST
        {
            let expected = format!("a whole number, 0 to {}", agrik_solids::cover::FINEST);
            return Err(Error::argument("level", expected, level));
        }
        let collider = Collider::new(Arc::clone(&bodies), Arc::clone(&scene), static_skip, None)?;
        let mut fixed = Vec::new();
        for Static { object } in statics {
            let Some(of) = scene.objects().get(*object) else {
                let expected = format!("objects, 0 to {} - 1", scene.objects().len());
                return Err(Error::argument("statics", expected, object));
            };
            let minds: Vec<usize> = (0..count)
                .filter(|body| bodies.moved_by(*body) > 0)
                .filter(|body| !static_skip.contains(&(*body, *object)))
                .collect();
            let spheres = of.clouds.iter().flat_map(|cloud| cloud.spheres());
            for solid in of.solids.iter().cloned() {
                fixed.push((solid, minds.clone()));
            }
            for [x, y, z, r] in spheres {
                fixed.push((Solid::sphere([x, y, z], r)?, minds.clone()));
            }
        }
        let last = chain.compiled().links.len();
        let hard: Vec<usize> = (0..count).filter(|b| bodies.moved_by(*b) == last).collect();
        let wrist = |b: &usize| bodies.moved_by(*b) + 2 >= last && bodies.moved_by(*b) < last;
        let soft: Vec<usize> = (0..count).filter(wrist).collect();
        let mut rest: Vec<usize> =
            (0..count).filter(|b| bodies.moved_by(*b) > 0 && bodies.moved_by(*b) < last).collect();
        rest.sort_by_key(|b| std::cmp::Reverse(bodies.moved_by(*b)));
        let straight = straight_wrist(&chain);
        let covers = (0..count).map(|body| match (mode, bodies.mounts()[body].solid.core()) {
            (Mode::Tree { split, .. }, Core::Cuboid(cuboid)) => Some(Cover::new(cuboid, split)),
            _ => None,
        });
        Ok(Self {
            covers: covers.collect(),
            collider,
            mode,
            statics: statics.iter().map(|of| of.object).collect(),
            fixed,
            touching: (0..count).map(|body| touching.contains(&body)).collect(),
            hard: hard.into_iter().map(|b| (b, bodies.mounts()[b].solid.clone())).collect(),
            soft: soft
                .into_iter()
                .map(|b| (b, bodies.mounts()[b].solid.placed(&straight[bodies.moved_by(b) - 1])))
                .collect(),
            rest,
            bodies,
            scene,
        })
    }

    /// The arm with its bodies.
    pub fn bodies(&self) -> &Arc<Bodies> {
        &self.bodies
    }

    /// The crop.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// How the bodies meet the crop.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// The arm.
    pub fn chain(&self) -> &Arc<Chain> {
        self.bodies.chain()
    }

    /// The arm behind its slide.
    pub(super) fn lead(&self) -> Result<&Lead> {
        Lead::slide(self.bodies.chain()).ok_or_else(|| missing("a slide before six joints"))
    }

    /// Bodies of the last link where they are while it lies at a pose.
    pub(super) fn hard(&self, last: &Pose) -> impl Iterator<Item = (usize, Solid)> {
        self.hard.iter().map(|(body, solid)| (*body, solid.placed(last)))
    }

    /// Bodies of the wrist's other links, the wrist straight.
    pub(super) fn soft(&self, last: &Pose) -> impl Iterator<Item = (usize, Solid)> {
        self.soft.iter().map(|(body, solid)| (*body, solid.placed(last)))
    }

    /// Bodies touch each other or a static thing.
    pub(super) fn hits_itself(&self, placed: &Placed) -> bool {
        self.collider.hits_itself(placed)
            || self.fixed.iter().any(|(solid, minds)| {
                minds.iter().any(|body| within(&placed.solids()[*body], solid, 0.0))
            })
    }

    /// A body touches a static thing.
    pub(super) fn hits_static(&self, body: usize, solid: &Solid) -> bool {
        self.fixed.iter().any(|(fixed, minds)| minds.contains(&body) && within(solid, fixed, 0.0))
    }

    /// Distance of a body from the crop, and `cap` where that is less, m.
    pub(super) fn distance(&self, body: usize, solid: &Solid, exempt: &Exemption, cap: f64) -> f64 {
        match self.spheres(body, solid) {
            None => self.scene.distance(solid, exempt, cap),
            Some(spheres) => self.scene.spheres_distance(&spheres, exempt, cap),
        }
    }

    /// Shows every object that a body has within `cap`; some come twice.
    pub(super) fn each_within(
        &self,
        (body, solid): (usize, &Solid),
        exempt: &Exemption,
        cap: f64,
        show: impl FnMut(usize),
    ) {
        match self.spheres(body, solid) {
            None => self.scene.each_within(solid, exempt, cap, show),
            Some(spheres) => self.scene.each_within_spheres(&spheres, exempt, cap, show),
        }
    }

    fn spheres(&self, body: usize, solid: &Solid) -> Option<Spheres<'_>> {
        match (self.mode, &self.covers[body], solid.core()) {
            (Mode::Tree { level, .. }, Some(cover), Core::Cuboid(cuboid)) => {
                Some(Spheres::new(cover, level, *cuboid, solid.radius()))
            }
            _ => None,
        }
    }

    /// Distance of two bodies' nearest pair, m, for reports.
    pub fn own_distance(&self, placed: &Placed) -> f64 {
        let pair = |&(i, j): &(usize, usize)| distance(&placed.solids()[i], &placed.solids()[j]);
        self.bodies.self_pairs().iter().map(pair).fold(f64::INFINITY, f64::min)
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
pub(super) fn inverse(pose: &Pose) -> Pose {
    let r = &pose.rotation;
    let row = |k: usize| [r[0][k], r[1][k], r[2][k]];
    let rotation = [row(0), row(1), row(2)];
    Pose { rotation, translation: pose.inner_direction(pose.translation).map(|x| -x) }
}
