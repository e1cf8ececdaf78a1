//! Named objects, and the questions that a solid asks of all of them.

use std::collections::HashMap;

use agrik_compute::lanes::Level;
use agrik_compute::{Allowed, Error, Result};

use crate::broad_phase::{Asking, BroadPhase, Exempt, Found};
use crate::cover::Spheres;
use crate::distance::closest;
use crate::outline::View;
use crate::shapes::{Cloud, LARGEST, Point, Solid};

/// One thing of a scene: a fruit, a stem, a pipe.
#[derive(Debug, Clone, PartialEq)]
pub struct Object {
    /// Its name, which no other object has.
    pub name: String,
    /// What it is, in the words of the caller: fruit, stem, leaf, wire.
    pub kind: String,
    /// True for what may be taken out of the way.
    pub removable: bool,
    /// Distance that is to be kept from it, m, where a query asks for less.
    pub clearance: f64,
    /// What it is made of.
    pub solids: Vec<Solid>,
    /// What else it is made of: points with radii.
    pub clouds: Vec<Cloud>,
}

impl Object {
    /// An object of one kind, made of nothing yet.
    pub fn new(name: impl Into<String>, kind: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            kind: kind.into(),
            removable: false,
            clearance: 0.0,
            solids: Vec::new(),
            clouds: Vec::new(),
        }
    }

    /// The same with one more solid.
    #[must_use]
    pub fn with(mut self, solid: impl Into<Solid>) -> Self {
        self.solids.push(solid.into());
        self
    }

    /// The same with points.
    #[must_use]
    pub fn with_cloud(mut self, cloud: Cloud) -> Self {
        self.clouds.push(cloud);
        self
    }

    fn check(&self) -> Result<()> {
        if self.name.is_empty() {
            return Err(Error::argument("name", "a name of one character or more", "\"\""));
        }
        let argument = format!("clearance of {:?}", self.name);
        Allowed::between(0.0, LARGEST).check(&argument, self.clearance)
    }
}

/// Objects that a query leaves out, made by [`Scene::exempt`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Exemption(Exempt);

impl Exemption {
    /// No object is left out.
    pub fn none() -> Self {
        Self::default()
    }

    /// True for an object that is left out, by its index.
    pub fn contains(&self, object: usize) -> bool {
        self.0.contains(object as u32)
    }

    /// The same with some more objects, by their indices, of a scene of `count`.
    #[must_use]
    pub fn and(&self, more: impl IntoIterator<Item = usize>, count: usize) -> Self {
        Self(self.0.and(more.into_iter().map(|index| index as u32), count as u32))
    }
}

/// The object nearest to a solid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// Distance, m; 0 or less in contact.
    pub distance: f64,
    /// Which of [`Scene::objects`] it is.
    pub object: usize,
    /// The point of the solid, m.
    pub on_solid: Point,
    /// The point of the object, m.
    pub on_object: Point,
    /// Unit vector from the object to the solid, along which they would part; zeros where
    /// their cores meet.
    pub normal: Point,
}

/// Objects in one frame, ready for questions; what it holds does not change.
#[derive(Debug, Clone)]
pub struct Scene {
    objects: Vec<Object>,
    by_name: HashMap<String, usize>,
    phase: BroadPhase,
    /// The largest clearance of an object, m.
    clearance: f64,
}

impl Scene {
    /// A scene of objects, all in one frame. Takes about 0.3 us for each point of a cloud.
    ///
    /// # Errors
    ///
    /// Two objects have one name, a name is empty, or a clearance is no finite number of 0 or
    /// more.
    ///
    /// ```
    /// use agrik_solids::{Exemption, Object, Scene, Solid};
    ///
    /// let stem = Solid::capsule([0.4, 0.0, 0.0], [0.4, 0.0, 2.0], 0.01)?;
    /// let fruit = Solid::sphere([0.4, 0.1, 1.0], 0.04)?;
    /// let scene = Scene::new(vec![
    ///     Object::new("stem", "stem").with(stem),
    ///     Object::new("fruit", "fruit").with(fruit),
    /// ])?;
    /// let gripper = Solid::sphere([0.4, 0.25, 1.0], 0.05)?;
    /// let found = scene.nearest(&gripper, &Exemption::none(), f64::INFINITY);
    /// assert_eq!(found.map(|found| found.object), Some(1));
    /// assert!(!scene.hits(&gripper, &Exemption::none(), 0.0));
    /// assert!(scene.exempt(["leaf"]).is_err());
    /// # Ok::<(), agrik_solids::Error>(())
    /// ```
    pub fn new(objects: Vec<Object>) -> Result<Self> {
        let mut by_name = HashMap::with_capacity(objects.len());
        let (mut spheres, mut solids) = (Vec::new(), Vec::new());
        let mut clearance = 0.0_f64;
        for (index, object) in objects.iter().enumerate() {
            object.check()?;
            if by_name.insert(object.name.clone(), index).is_some() {
                let expected = "names that differ from each other";
                return Err(Error::argument(
                    "objects",
                    expected,
                    format!("{:?} twice", object.name),
                ));
            }
            let label = index as u32;
            clearance = clearance.max(object.clearance);
            solids.extend(object.solids.iter().map(|solid| (solid.clone(), label)));
            for cloud in &object.clouds {
                spheres.extend(cloud.spheres().map(|sphere| (sphere, label)));
            }
        }
        Ok(Self { objects, by_name, phase: BroadPhase::new(&spheres, solids), clearance })
    }

    /// The objects, in the order given.
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// Which object has this name.
    ///
    /// # Errors
    ///
    /// None has.
    pub fn object(&self, name: &str) -> Result<usize> {
        self.by_name.get(name).copied().ok_or_else(|| {
            let mut names = self.objects.iter().map(|object| object.name.as_str());
            let some: Vec<&str> = names.by_ref().take(8).collect();
            let more = if names.next().is_some() { ", ..." } else { "" };
            Error::argument(
                "object",
                format!("one of {}{more}", some.join(", ")),
                format!("{name:?}"),
            )
        })
    }

    /// An exemption of the objects with these names.
    ///
    /// # Errors
    ///
    /// There is no object of a name.
    pub fn exempt<'a>(&self, names: impl IntoIterator<Item = &'a str>) -> Result<Exemption> {
        let labels: Vec<u32> = names
            .into_iter()
            .map(|name| self.object(name).map(|index| index as u32))
            .collect::<Result<_>>()?;
        Ok(Exemption(Exempt::new(labels, self.objects.len() as u32)))
    }

    /// All objects as balls see them, for so many questions of eight lanes each to come: what is
    /// ruled out there is far from them in truth.
    pub fn view(&self, questions: usize) -> View<'_> {
        self.phase.view(questions)
    }

    /// True where all within `radius` (m) of a point is sure to be farther than is to be kept from
    /// every object; see [`Scene::hits`]. Where it is not, nothing is said.
    pub fn is_far(&self, centre: Point, radius: f64, clear: f64) -> bool {
        self.phase.is_far(centre, radius + clear.max(self.clearance))
    }

    /// The largest clearance that an object asks for, m.
    pub fn largest_clearance(&self) -> f64 {
        self.clearance
    }

    /// The same scene, asked with the instructions of another level than the one in use.
    /// Answers are the same at all levels.
    #[must_use]
    pub fn at_level(self, level: Level) -> Self {
        Self { phase: self.phase.at_level(level), ..self }
    }

    /// True where the solid comes nearer to an object than is to be kept: to `clear` (m) or
    /// less, or to the clearance of the object itself or less where that is more. With 0, as
    /// with anything below, and no clearances: where it touches or overlaps.
    pub fn hits(&self, solid: &Solid, exempt: &Exemption, clear: f64) -> bool {
        self.hit(solid, exempt, clear).is_some()
    }

    /// True where the solid comes to `reach` (m) or less of an object, whatever clearances say.
    pub fn hits_plain(&self, solid: &Solid, exempt: &Exemption, reach: f64) -> bool {
        let limit = |_| reach;
        self.phase.any_within(Asking::Solid(solid), &exempt.0, reach, limit).is_some()
    }

    /// An object that [`Scene::hits`] is true for, or none. Which one of several is not said,
    /// but always the same.
    pub fn hit(&self, solid: &Solid, exempt: &Exemption, clear: f64) -> Option<usize> {
        self.hit_by(Asking::Solid(solid), exempt, clear)
    }

    /// [`Scene::hits`] of the spheres of a cover.
    pub fn spheres_hit(&self, spheres: &Spheres<'_>, exempt: &Exemption, clear: f64) -> bool {
        self.hit_by(Asking::Spheres(spheres), exempt, clear).is_some()
    }

    fn hit_by(&self, asking: Asking<'_>, exempt: &Exemption, clear: f64) -> Option<usize> {
        let limit = |label: u32| self.objects[label as usize].clearance.max(clear);
        let most = self.clearance.max(clear);
        self.phase.any_within(asking, &exempt.0, most, limit).map(|label| label as usize)
    }

    /// Distance of the nearest object, and `cap` where that is less, m: infinity from an empty
    /// scene without a cap. `cap` is not NaN; the less it is, the quicker the answer.
    pub fn distance(&self, solid: &Solid, exempt: &Exemption, cap: f64) -> f64 {
        let found = self.phase.nearest(Asking::Solid(solid), &exempt.0, cap);
        found.map_or(cap, |found| found.distance)
    }

    /// By how much farther than is to be kept the solid is from every object, m, and `cap`
    /// where that is less: from `clear`, or from the clearance of the object itself where that
    /// is more. 0 or less exactly where [`Scene::hits`] is true.
    pub fn margin(&self, solid: &Solid, exempt: &Exemption, clear: f64, cap: f64) -> f64 {
        if self.clearance <= clear {
            return self.distance(solid, exempt, clear + cap) - clear;
        }
        let mut least = cap;
        self.phase.each_within(Asking::Solid(solid), &exempt.0, self.clearance + cap, |found| {
            let keep = self.objects[found.label as usize].clearance.max(clear);
            least = least.min(found.distance - keep);
        });
        least
    }

    /// [`Scene::distance`] of the spheres of a cover: of the nearest of them.
    pub fn spheres_distance(&self, spheres: &Spheres<'_>, exempt: &Exemption, cap: f64) -> f64 {
        let found = self.phase.nearest(Asking::Spheres(spheres), &exempt.0, cap);
        found.map_or(cap, |found| found.distance)
    }

    /// Shows the index of every object that a solid has within `cap` (m); some come twice.
    pub fn each_within(
        &self,
        solid: &Solid,
        exempt: &Exemption,
        cap: f64,
        mut show: impl FnMut(usize),
    ) {
        let show = |found: Found| show(found.label as usize);
        self.phase.each_within(Asking::Solid(solid), &exempt.0, cap, show);
    }

    /// [`Scene::each_within`] of the spheres of a cover.
    pub fn each_within_spheres(
        &self,
        spheres: &Spheres<'_>,
        exempt: &Exemption,
        cap: f64,
        mut show: impl FnMut(usize),
    ) {
        let show = |found: Found| show(found.label as usize);
        self.phase.each_within(Asking::Spheres(spheres), &exempt.0, cap, show);
    }

    /// The nearest object, if it is `cap` (m) or less away, and where they come nearest. Of
    /// several at the same distance it is the first.
    pub fn nearest(&self, solid: &Solid, exempt: &Exemption, cap: f64) -> Option<Nearest> {
        let found = self.phase.nearest(Asking::Solid(solid), &exempt.0, cap)?;
        Some(self.witnessed(solid, &found))
    }

    /// Every object that is `cap` (m) or less away, the nearest first, with the distance.
    pub fn all_within(&self, solid: &Solid, exempt: &Exemption, cap: f64) -> Vec<Nearest> {
        let mut by_object: HashMap<u32, Found> = HashMap::new();
        self.phase.each_within(Asking::Solid(solid), &exempt.0, cap, |found| {
            let best = by_object.entry(found.label).or_insert(found);
            if found.distance < best.distance {
                *best = found;
            }
        });
        let mut all: Vec<Nearest> =
            by_object.values().map(|found| self.witnessed(solid, found)).collect();
        all.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.object.cmp(&b.object)));
        all
    }

    fn witnessed(&self, solid: &Solid, found: &Found) -> Nearest {
        let where_ = closest(&self.phase.solid(found), solid);
        Nearest {
            distance: found.distance,
            object: found.label as usize,
            on_solid: where_.on_b,
            on_object: where_.on_a,
            normal: where_.normal,
        }
    }
}
