//! Bodies in a scene: what hits what, and what is nearest.

use std::collections::BTreeMap;
use std::sync::Arc;

use agrik_compute::Allowed;
use agrik_compute::lanes::{dot, sub};
use agrik_solids::{
    Core, Cover, Cuboid, Exemption, Nearest, Point, Pose, Scene, Solid, closest, distance_within,
    within,
};

use super::bodies::Bodies;
use super::placed::Placed;
use super::shape::Shape;
use crate::{Error, Result};

/// What may be touched where the tool is near enough: a target fruit and its stalk.
#[derive(Debug, Clone, PartialEq)]
pub struct Touch {
    /// Pairs of a body and an object that do not mind each other then.
    pub pairs: Vec<(usize, usize)>,
    /// Where the tool point has to be near, m.
    pub target: Point,
    /// How near, m.
    pub radius: f64,
}

/// An arm with bodies in a scene.
#[derive(Debug, Clone)]
pub struct Collider {
    bodies: Arc<Bodies>,
    scene: Arc<Scene>,
    /// What each body does not mind.
    exempt: Vec<Exemption>,
    /// The same near the target, its place, and the square of how near, m^2.
    zone: Option<(Vec<Exemption>, Point, f64)>,
    /// Bodies that are asked about the scene, likely hits first.
    asked: Vec<usize>,
    /// Pairs of bodies that are asked about each other, likely hits first.
    pairs: Vec<(usize, usize)>,
}

/// What a body meets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Other {
    /// An object, by its index among [`Scene::objects`].
    Object(usize),
    /// Another body, by its index.
    Body(usize),
}

/// A body and what is nearest to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Distance, m; 0 or less in contact.
    pub distance: f64,
    /// The body.
    pub body: usize,
    /// What is near it.
    pub other: Other,
    /// The point of the body, m.
    pub on_body: Point,
    /// The point of the other, m.
    pub on_other: Point,
    /// Unit vector from the other to the body, along which they would part; zeros where their
    /// cores meet.
    pub normal: Point,
}

impl Collider {
    /// An arm with bodies in a scene. Bodies on the base are not asked about the scene, as
    /// they do not move in it; `exemptions` are pairs of a body and an object that do not mind
    /// each other, those of `touch` only while the tool is near its target.
    ///
    /// # Errors
    ///
    /// A pair names no body or no object, or the target or the radius is no finite number.
    pub fn new(
        bodies: Arc<Bodies>,
        scene: Arc<Scene>,
        exemptions: &[(usize, usize)],
        touch: Option<&Touch>,
    ) -> Result<Self> {
        let exempt = exempt(&bodies, &scene, "exemptions", exemptions)?;
        let zone = match touch {
            None => None,
            Some(touch) => {
                let largest = agrik_solids::shapes::LARGEST;
                for x in touch.target {
                    Allowed::between(-largest, largest).check("touch target", x)?;
                }
                Allowed::between(0.0, largest).check("touch radius", touch.radius)?;
                let both = [exemptions, &touch.pairs].concat();
                let exempt = self::exempt(&bodies, &scene, "touch pairs", &both)?;
                Some((exempt, touch.target, touch.radius * touch.radius))
            }
        };
        // What is farthest out sweeps most.
        let mut asked: Vec<usize> = (0..bodies.len()).filter(|b| bodies.moved_by(*b) > 0).collect();
        asked.sort_by_key(|body| std::cmp::Reverse(bodies.moved_by(*body)));
        let pairs = bodies.self_pairs().to_vec();
        Ok(Self { bodies, scene, exempt, zone, asked, pairs })
    }

    /// The same, with some objects out of the way.
    ///
    /// # Errors
    ///
    /// An index is none of an object.
    pub fn without(&self, gone: &[usize]) -> Result<Self> {
        let count = self.scene.objects().len();
        if let Some(object) = gone.iter().find(|object| **object >= count) {
            let expected = format!("objects, 0 to {count} - 1");
            return Err(Error::argument("gone", expected, object));
        }
        let mut out = self.clone();
        let zone = out.zone.iter_mut().flat_map(|(near, ..)| near);
        for exempt in out.exempt.iter_mut().chain(zone) {
            *exempt = exempt.and(gone.iter().copied(), count);
        }
        Ok(out)
    }

    /// The arm with its bodies.
    pub fn bodies(&self) -> &Arc<Bodies> {
        &self.bodies
    }

    /// The objects.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// Names of the two that a contact is between: the body first.
    pub fn names(&self, contact: &Contact) -> [&str; 2] {
        let body = |index: usize| self.bodies.bodies()[index].name.as_str();
        let other = match contact.other {
            Other::Object(index) => self.scene.objects()[index].name.as_str(),
            Other::Body(index) => body(index),
        };
        [body(contact.body), other]
    }

    /// Objects that a body does not mind where the tool is now.
    pub fn exemption(&self, placed: &Placed, body: usize) -> &Exemption {
        self.exemption_with(|| placed.tool(), body)
    }

    /// The same with the tool point where it is said to be, m.
    pub(super) fn exemption_with(&self, tool: impl FnOnce() -> Point, body: usize) -> &Exemption {
        match &self.zone {
            Some((exempt, target, radius2)) => {
                let way = sub(tool(), *target);
                let near = dot(way, way) <= *radius2;
                if near { &exempt[body] } else { &self.exempt[body] }
            }
            None => &self.exempt[body],
        }
    }

    /// True where a body is `clear` (m) or less away from an object that it minds, or two
    /// bodies of a self pair touch.
    pub fn hits(&self, placed: &Placed, clear: f64) -> bool {
        self.hits_scene(placed, clear) || self.hits_itself(placed)
    }

    /// True where a body is `clear` (m) or less away from an object that it minds.
    pub fn hits_scene(&self, placed: &Placed, clear: f64) -> bool {
        self.asked.iter().any(|body| self.body_hits(placed, *body, clear))
    }

    /// True where two bodies of a self pair touch.
    pub fn hits_itself(&self, placed: &Placed) -> bool {
        self.pairs.iter().any(|&pair| pair_within(placed, pair, 0.0))
    }

    /// True where two bodies are `reach` (m) or less apart.
    pub fn pair_within(&self, placed: &Placed, pair: (usize, usize), reach: f64) -> bool {
        pair_within(placed, pair, reach)
    }

    /// True where one body is `clear` (m) or less away from an object that it minds.
    pub fn body_hits(&self, placed: &Placed, body: usize, clear: f64) -> bool {
        let (centre, radius) = placed.sphere(body);
        // The spheres of a cover stick out of the one round the box.
        let exact = matches!(self.bodies.bodies()[body].shape, Shape::Exact(_));
        if exact && self.scene.is_far(centre, radius, clear) {
            return false;
        }
        self.solid_hits(body, &placed.solids()[body], self.exemption(placed, body), clear)
    }

    /// The same of a body that lies as `solid`.
    pub(super) fn solid_hits(
        &self,
        body: usize,
        solid: &Solid,
        exempt: &Exemption,
        clear: f64,
    ) -> bool {
        match self.covered(body, solid) {
            None => self.scene.hits(solid, exempt, clear),
            Some(spheres) => spheres.hits(&self.scene, exempt, clear),
        }
    }

    /// Distance of the posture from the nearest collision, and `cap` where that is less, m; 0
    /// or less exactly where it hits. `own`: pairs of bodies count as well.
    pub fn clearance(&self, placed: &Placed, cap: f64, own: bool) -> f64 {
        let scene = self.asked.iter().fold(cap, |least, &body| {
            let exempt = self.exemption(placed, body);
            let solid = &placed.solids()[body];
            match self.covered(body, solid) {
                None => self.scene.distance(solid, exempt, least),
                Some(spheres) => {
                    spheres.nearest(&self.scene, exempt, least).map_or(least, |(d, _)| d)
                }
            }
        });
        if own { self.own_clearance(placed, scene) } else { scene }
    }

    /// Distance of the bodies from the scene, each of them shifted by a vector, m.
    pub(super) fn shifted_clearance(&self, placed: &Placed, shifts: &[Point]) -> f64 {
        self.asked.iter().fold(f64::INFINITY, |least, &body| {
            let exempt = self.exemption(placed, body);
            let at = Pose { translation: shifts[body], ..Pose::IDENTITY };
            let solid = placed.solids()[body].placed(&at);
            match self.covered(body, &solid) {
                None => self.scene.distance(&solid, exempt, least),
                Some(spheres) => {
                    spheres.nearest(&self.scene, exempt, least).map_or(least, |(d, _)| d)
                }
            }
        })
    }

    /// By how much farther than is to be kept a body that lies as `solid` is from every object
    /// that it minds, m, and `cap` where that is less; see [`Scene::margin`].
    pub(crate) fn margin(
        &self,
        (body, solid): (usize, &Solid),
        exempt: &Exemption,
        clear: f64,
        cap: f64,
    ) -> f64 {
        match self.covered(body, solid) {
            None => self.scene.margin(solid, exempt, clear, cap),
            Some(spheres) => spheres.margin(&self.scene, exempt, clear, cap),
        }
    }

    /// What the bodies do not mind away from the target.
    pub(super) fn exemptions(&self) -> &[Exemption] {
        &self.exempt
    }

    /// What a body does not mind away from the target.
    pub(crate) fn usual_exemption(&self, body: usize) -> &Exemption {
        &self.exempt[body]
    }

    /// What a body does not mind near the target, the target's place, and how near that is, m.
    pub(crate) fn touch_exemption(&self, body: usize) -> Option<(&Exemption, Point, f64)> {
        let (exempt, target, radius2) = self.zone.as_ref()?;
        let more = exempt[body] != self.exempt[body];
        more.then(|| (&exempt[body], *target, radius2.sqrt()))
    }

    /// Bodies that are asked about the scene, likely hits first.
    pub(crate) fn asked(&self) -> &[usize] {
        &self.asked
    }

    /// Distance of the nearest pair of bodies, and `cap` where that is less, m.
    pub fn own_clearance(&self, placed: &Placed, cap: f64) -> f64 {
        self.pairs.iter().fold(cap, |least, &(i, j)| {
            let solids = placed.solids();
            distance_within(&solids[i], &solids[j], least).min(least)
        })
    }

    /// The object nearest to a body, if it is `cap` (m) or less away; none for a body on the
    /// base.
    pub fn nearest(&self, placed: &Placed, body: usize, cap: f64) -> Option<Nearest> {
        if self.bodies.moved_by(body) == 0 {
            return None;
        }
        let exempt = self.exemption(placed, body);
        let solid = &placed.solids()[body];
        match self.covered(body, solid) {
            None => self.scene.nearest(solid, exempt, cap),
            Some(spheres) => {
                let (_, sphere) = spheres.nearest(&self.scene, exempt, cap)?;
                self.scene.nearest(&sphere, exempt, cap)
            }
        }
    }

    /// Every object that is `cap` (m) or less away from a body, the nearest first; none for a
    /// body on the base.
    pub(super) fn objects_within(&self, placed: &Placed, body: usize, cap: f64) -> Vec<Nearest> {
        if self.bodies.moved_by(body) == 0 {
            return Vec::new();
        }
        let exempt = self.exemption(placed, body);
        let solid = &placed.solids()[body];
        match self.covered(body, solid) {
            None => self.scene.all_within(solid, exempt, cap),
            Some(spheres) => spheres.objects_within(&self.scene, exempt, cap),
        }
    }

    /// The nearest pair of bodies, if they are `cap` (m) or less apart: the first of several.
    pub fn nearest_pair(&self, placed: &Placed, cap: f64) -> Option<Contact> {
        let mut best: Option<(f64, (usize, usize))> = None;
        let solids = placed.solids();
        for &(i, j) in self.bodies.self_pairs() {
            let least = best.map_or(cap, |(least, _)| least);
            let found = distance_within(&solids[i], &solids[j], least);
            if found < least || best.is_none() && found <= least && found < f64::INFINITY {
                best = Some((found, (i, j)));
            }
        }
        best.map(|(distance, (i, j))| {
            let found = closest(&solids[j], &solids[i]);
            let (on_body, on_other, normal) = (found.on_b, found.on_a, found.normal);
            Contact { distance, body: i, other: Other::Body(j), on_body, on_other, normal }
        })
    }

    /// What is nearest to a collision of all bodies, if it is `cap` (m) or less away; with
    /// `own` a pair of bodies too. Of several at the same distance it is that of the first
    /// body, and an object before a body.
    pub fn nearest_of_all(&self, placed: &Placed, cap: f64, own: bool) -> Option<Contact> {
        let mut best: Option<Contact> = None;
        for body in 0..self.bodies.len() {
            let cap = best.map_or(cap, |best| best.distance);
            if let Some(found) = self.nearest(placed, body, cap)
                && best.is_none_or(|best| found.distance < best.distance)
            {
                best = Some(Contact {
                    distance: found.distance,
                    body,
                    other: Other::Object(found.object),
                    on_body: found.on_solid,
                    on_other: found.on_object,
                    normal: found.normal,
                });
            }
        }
        if !own {
            return best;
        }
        let cap = best.map_or(cap, |best| best.distance);
        let pair = self.nearest_pair(placed, cap);
        match (best, pair) {
            (Some(best), Some(pair)) if pair.distance >= best.distance => Some(best),
            (best, pair) => pair.or(best),
        }
    }

    /// How the distance of a contact changes with each joint value, m/rad or no unit: that of
    /// its two points along the line between them; zeros where cores meet.
    pub fn gradient(&self, placed: &Placed, contact: &Contact) -> Vec<f64> {
        let chain = self.bodies.chain().compiled();
        let mut rates = vec![0.0; chain.dof];
        let Contact { body, other, on_body, on_other, normal, .. } = *contact;
        placed.add_rates(chain, self.bodies.moved_by(body), on_body, normal, 1.0, &mut rates);
        if let Other::Body(other) = other {
            let joints = self.bodies.moved_by(other);
            placed.add_rates(chain, joints, on_other, normal, -1.0, &mut rates);
        }
        rates
    }

    /// The spheres that a body meets the scene as, if it does.
    fn covered<'a>(&'a self, body: usize, solid: &Solid) -> Option<Spheres<'a>> {
        match (&self.bodies.bodies()[body].shape, solid.core()) {
            (Shape::Cover { cover, level, radius, .. }, Core::Cuboid(cuboid)) => {
                Some(Spheres { cover, level: *level, cuboid: *cuboid, radius: *radius })
            }
            _ => None,
        }
    }
}

/// True where two bodies are `reach` (m) or less apart.
fn pair_within(placed: &Placed, (i, j): (usize, usize), reach: f64) -> bool {
    let ((p, r), (q, s)) = (placed.sphere(i), placed.sphere(j));
    let way = sub(p, q);
    let near = (r + s + reach) * (1.0 + 1e-12);
    dot(way, way) <= near * near && within(&placed.solids()[i], &placed.solids()[j], reach)
}

/// For each body the objects that it does not mind.
fn exempt(
    bodies: &Bodies,
    scene: &Scene,
    argument: &str,
    pairs: &[(usize, usize)],
) -> Result<Vec<Exemption>> {
    let objects = scene.objects();
    let mut names = vec![Vec::new(); bodies.len()];
    for &(body, object) in pairs {
        if body >= bodies.len() || object >= objects.len() {
            let (bodies, objects) = (bodies.len(), objects.len());
            let expected = format!("a body of {bodies} and an object of {objects}, from 0");
            return Err(Error::argument(argument, expected, format!("({body}, {object})")));
        }
        names[body].push(objects[object].name.as_str());
    }
    names.into_iter().map(|names| scene.exempt(names)).collect()
}

/// A cover of a box where it lies.
struct Spheres<'a> {
    cover: &'a Cover,
    level: usize,
    cuboid: Cuboid,
    radius: f64,
}

impl Spheres<'_> {
    fn sphere(&self, level: usize, index: usize) -> Option<Solid> {
        let centre = self.cuboid.point(self.cover.centres(level)[index]);
        Solid::sphere(centre, self.cover.radius(level) + self.radius).ok()
    }

    /// The nearest sphere of the level that counts, if it is `cap` (m) or less away, with its
    /// distance: what brute force over all of them gives, found through the levels above,
    /// whose spheres contain what lies below them but for a known rest.
    fn nearest(&self, scene: &Scene, exempt: &Exemption, cap: f64) -> Option<(f64, Solid)> {
        let mut best: Option<(f64, Solid)> = None;
        // Spheres still to be looked at, by level and index, the next one last.
        let mut open = vec![(0, 0)];
        while let Some((level, index)) = open.pop() {
            let least = best.as_ref().map_or(cap, |(least, _)| *least);
            let Some(sphere) = self.sphere(level, index) else { continue };
            // Cells of other shapes than their box may stick out of the sphere above.
            let slack = if level == self.level { 0.0 } else { self.beyond(level) };
            let Some(found) = scene.nearest(&sphere, exempt, least + slack) else { continue };
            if level == self.level {
                let nearer = found.distance < least || best.is_none();
                if nearer {
                    best = Some((found.distance, sphere));
                }
            } else {
                open.extend((0..8).rev().map(|child| (level + 1, 8 * index + child)));
            }
        }
        best
    }

    /// [`Scene::all_within`] of all spheres: of each object what its nearest sphere says.
    fn objects_within(&self, scene: &Scene, exempt: &Exemption, cap: f64) -> Vec<Nearest> {
        let mut best: BTreeMap<usize, Nearest> = BTreeMap::new();
        let mut open = vec![(0, 0)];
        while let Some((level, index)) = open.pop() {
            let Some(sphere) = self.sphere(level, index) else { continue };
            if level < self.level {
                if scene.hits_plain(&sphere, exempt, cap + self.beyond(level)) {
                    open.extend((0..8).rev().map(|child| (level + 1, 8 * index + child)));
                }
                continue;
            }
            for found in scene.all_within(&sphere, exempt, cap) {
                let least = best.entry(found.object).or_insert(found);
                if found.distance < least.distance {
                    *least = found;
                }
            }
        }
        let mut all: Vec<Nearest> = best.into_values().collect();
        all.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.object.cmp(&b.object)));
        all
    }

    /// [`Scene::margin`] of the sphere that has least.
    fn margin(&self, scene: &Scene, exempt: &Exemption, clear: f64, cap: f64) -> f64 {
        let mut least = cap;
        let mut open = vec![(0, 0)];
        while let Some((level, index)) = open.pop() {
            let Some(sphere) = self.sphere(level, index) else { continue };
            let slack = if level == self.level { 0.0 } else { self.beyond(level) };
            let found = scene.margin(&sphere, exempt, clear, least + slack);
            if level == self.level {
                least = least.min(found);
            } else if found < least + slack {
                open.extend((0..8).rev().map(|child| (level + 1, 8 * index + child)));
            }
        }
        least
    }

    fn hits(&self, scene: &Scene, exempt: &Exemption, clear: f64) -> bool {
        let mut open = vec![(0, 0)];
        while let Some((level, index)) = open.pop() {
            let Some(sphere) = self.sphere(level, index) else { continue };
            let slack = if level == self.level { 0.0 } else { self.beyond(level) };
            if scene.hits(&sphere, exempt, clear + slack) {
                if level == self.level {
                    return true;
                }
                open.extend((0..8).rev().map(|child| (level + 1, 8 * index + child)));
            }
        }
        false
    }

    /// How far spheres of the level that counts may reach beyond the sphere of a level above
    /// that they are cells of, m, rounding included.
    fn beyond(&self, level: usize) -> f64 {
        let spread = sub(self.cover.half(level), self.cover.half(self.level));
        let reach = dot(spread, spread).sqrt() + self.cover.radius(self.level);
        (reach - self.cover.radius(level)).max(0.0) + 1e-13 * (self.cover.radius(0) + self.radius)
    }
}
