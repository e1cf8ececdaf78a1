//! An arm with its bodies among things: what it touches, and how near it is to what counts.

use std::sync::Arc;

use agrik::chain::Chain;
use agrik_compute::Allowed;
use agrik_solids::{Core, Cover, Exemption, Point, Pose, Scene, Solid, Spheres, Split, within};

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

/// What of a scene is crop, and who minds what.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Roles {
    /// Objects that are not to be touched, however near the arm comes: the slide's rail, the
    /// vehicle.
    pub statics: Vec<usize>,
    /// How far they have moved with the arm from where the scene has them, m.
    pub moved: Point,
    /// Pairs of a body and one of them that do not mind each other.
    pub skip: Vec<(usize, usize)>,
    /// Bodies that may touch a target.
    pub touching: Vec<usize>,
}

/// An arm with bodies in a scene.
#[derive(Debug)]
pub struct Surroundings {
    pub(super) bodies: Arc<Bodies>,
    pub(super) scene: Arc<Scene>,
    pub(super) mode: Mode,
    pub(super) statics: Vec<usize>,
    collider: Collider,
    covers: Vec<Option<Cover>>,
    /// Solids of the static things, and which bodies mind each.
    fixed: Vec<(Solid, Vec<usize>)>,
    pub(super) touching: Vec<bool>,
    /// Pairs of a body and a static thing that do not mind each other.
    pub(super) skip: Vec<(usize, usize)>,
}

impl Surroundings {
    /// An arm with bodies in a scene.
    ///
    /// # Errors
    ///
    /// An index or a level is out of range.
    pub fn new(bodies: Arc<Bodies>, scene: Arc<Scene>, roles: &Roles, mode: Mode) -> Result<Self> {
        let count = bodies.len();
        if let Some(body) = roles.touching.iter().find(|body| **body >= count) {
            return Err(Error::argument("touching", format!("bodies, 0 to {count} - 1"), body));
        }
        if let Mode::Tree { level, .. } = mode
            && level > agrik_solids::cover::FINEST
        {
            let expected = format!("a whole number, 0 to {}", agrik_solids::cover::FINEST);
            return Err(Error::argument("level", expected, level));
        }
        for x in roles.moved {
            Allowed::FINITE.check("moved", x)?;
        }
        let collider = Collider::new(Arc::clone(&bodies), Arc::clone(&scene), &roles.skip, None)?;
        let mut fixed = Vec::new();
        for object in &roles.statics {
            let Some(of) = scene.objects().get(*object) else {
                let expected = format!("objects, 0 to {} - 1", scene.objects().len());
                return Err(Error::argument("statics", expected, object));
            };
            let minds: Vec<usize> = (0..count)
                .filter(|body| bodies.moved_by(*body) > 0)
                .filter(|body| !roles.skip.contains(&(*body, *object)))
                .collect();
            let at = Pose { translation: roles.moved, ..Pose::IDENTITY };
            fixed.extend(of.solids.iter().map(|solid| (solid.placed(&at), minds.clone())));
            for [x, y, z, r] in of.clouds.iter().flat_map(|cloud| cloud.spheres()) {
                fixed.push((Solid::sphere(at.point([x, y, z]), r)?, minds.clone()));
            }
        }
        let covers = (0..count).map(|body| match (mode, bodies.mounts()[body].solid.core()) {
            (Mode::Tree { split, .. }, Core::Cuboid(cuboid)) => Some(Cover::new(cuboid, split)),
            _ => None,
        });
        Ok(Self {
            covers: covers.collect(),
            statics: roles.statics.clone(),
            skip: roles.skip.clone(),
            touching: (0..count).map(|body| roles.touching.contains(&body)).collect(),
            collider,
            mode,
            fixed,
            bodies,
            scene,
        })
    }

    /// The arm with its bodies.
    pub fn bodies(&self) -> &Arc<Bodies> {
        &self.bodies
    }

    /// The scene.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// The arm.
    pub fn chain(&self) -> &Arc<Chain> {
        self.bodies.chain()
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

    /// Distance of all moving bodies from the crop, and `cap` where that is less, m.
    pub(super) fn clearance(&self, placed: &Placed, minding: &Minding, cap: f64) -> f64 {
        (0..self.bodies.len()).rev().filter(|body| self.bodies.moved_by(*body) > 0).fold(
            cap,
            |least, body| {
                if least <= 0.0 {
                    return least;
                }
                self.distance(body, &placed.solids()[body], minding.of(body), least)
            },
        )
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
}

/// What the bodies do not mind while the tool goes for a target.
#[derive(Debug)]
pub(super) struct Minding {
    touching: Exemption,
    others: Exemption,
    may_touch: Vec<bool>,
}

impl Minding {
    /// Of a target made of some objects: static things count for nobody, as they are asked
    /// about otherwise, and the target not for those that may touch it.
    pub fn new(around: &Surroundings, objects: &[usize]) -> Result<Self> {
        let count = around.scene.objects().len();
        if let Some(object) = objects.iter().find(|object| **object >= count) {
            let expected = format!("objects, 0 to {count} - 1");
            return Err(Error::argument("objects of a target", expected, object));
        }
        let others = Exemption::none().and(around.statics.iter().copied(), count);
        let touching = others.and(objects.iter().copied(), count);
        Ok(Self { touching, others, may_touch: around.touching.clone() })
    }

    /// What a body does not mind.
    pub fn of(&self, body: usize) -> &Exemption {
        if self.may_touch[body] { &self.touching } else { &self.others }
    }
}
