//! Many solids under one tree, and a few half-spaces beside it.
//!
//! A sphere is a leaf of the tree as it is. A capsule, a box, a hull is covered by spheres
//! that lead to it, and looked at exactly where one of them is within reach.

mod covering;
mod exempt;

pub use exempt::Exempt;

use std::sync::Arc;

use agrik_compute::lanes::{Kernel32, Level, Real32, dispatch_eights};

use crate::cover::Spheres;
use crate::distance::{distance_within, point_to_core};
use crate::outline::{Surroundings, View};
use crate::probe::{CuboidProbe, PointProbe, Probe, SegmentProbe};
use crate::shapes::{Core, Solid};
use crate::sphere_tree::{ALL_LABELS, Leaves, SphereTree};
use covering::covering;

/// A leaf that is a sphere, and needs no other solid.
const SPHERE: u32 = u32::MAX;

/// Solids looked at last: the spheres of a cover lead to the same one.
const SEEN: usize = 8;

/// The nearest of many solids.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// Distance, m.
    pub distance: f64,
    /// Its label.
    pub label: u32,
    place: Place,
}

#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
enum Place {
    Leaf(usize),
    Solid(usize),
}

/// What asks: a solid, or the spheres that stand for a box.
#[derive(Debug, Clone, Copy)]
pub enum Asking<'a> {
    /// A solid as it is.
    Solid(&'a Solid),
    /// A level of a cover.
    Spheres(&'a Spheres<'a>),
}

impl Asking<'_> {
    /// Distance from a sphere (x, y, z, radius, m), m.
    fn to_sphere(self, sphere: [f64; 4]) -> f64 {
        match self {
            Self::Solid(solid) => {
                let [x, y, z, r] = sphere;
                point_to_core([x, y, z], solid.core()) - solid.radius() - r
            }
            Self::Spheres(spheres) => spheres.distance_from_sphere(sphere),
        }
    }

    /// Distance from a solid, m, or more than `cap` where it is more.
    fn to_solid(self, other: &Solid, cap: f64) -> f64 {
        match self {
            Self::Solid(solid) => distance_within(solid, other, cap),
            Self::Spheres(spheres) => spheres.distance_from_solid(other, cap),
        }
    }
}

/// Many solids with labels, arranged for quick answers.
#[derive(Debug, Clone)]
pub struct BroadPhase {
    tree: SphereTree,
    /// For each leaf its sphere (m), its label and the solid that it leads to.
    spheres: Vec<[f64; 4]>,
    labels: Vec<u32>,
    leads_to: Vec<u32>,
    /// Those that are no spheres.
    solids: Vec<(Solid, u32)>,
    /// Which of them have no bounds.
    unbounded: Vec<usize>,
    /// The same, to be ruled out for many balls at a time.
    surroundings: Arc<Surroundings>,
    level: Level,
}

impl BroadPhase {
    /// Spheres (x, y, z, radius, m) and other solids, each with a label.
    pub fn new(spheres: &[([f64; 4], u32)], solids: Vec<(Solid, u32)>) -> Self {
        let mut leaves: Vec<([f64; 4], u32, u32)> =
            spheres.iter().map(|(sphere, label)| (*sphere, *label, SPHERE)).collect();
        let mut kept = Vec::with_capacity(solids.len());
        let mut unbounded = Vec::new();
        for (solid, label) in solids {
            if let Core::Point([x, y, z]) = solid.core() {
                leaves.push(([*x, *y, *z, solid.radius()], label, SPHERE));
                continue;
            }
            if let Core::HalfSpace(_) = solid.core() {
                unbounded.push(kept.len());
            } else {
                let leads_to = kept.len() as u32;
                leaves.extend(covering(&solid).into_iter().map(|s| (s, label, leads_to)));
            }
            kept.push((solid, label));
        }
        let tree = SphereTree::new(leaves.iter().map(|(sphere, label, _)| (*sphere, *label)));
        let ordered: Vec<_> = tree.order().iter().map(|given| leaves[*given as usize]).collect();
        let outlined = ordered.iter().map(|(sphere, label, to)| (sphere, *label, *to == SPHERE));
        let surroundings = Arc::new(Surroundings::new(&tree, outlined, &kept));
        Self {
            surroundings,
            spheres: ordered.iter().map(|leaf| leaf.0).collect(),
            labels: ordered.iter().map(|leaf| leaf.1).collect(),
            leads_to: ordered.iter().map(|leaf| leaf.2).collect(),
            tree,
            solids: kept,
            unbounded,
            level: Level::in_use(),
        }
    }

    /// The same, asked with the instructions of another level than the one in use. Answers
    /// are the same at all levels.
    pub fn at_level(self, level: Level) -> Self {
        Self { level, ..self }
    }

    /// All of it as balls see it, for so many questions; see [`Surroundings`].
    pub fn view(&self, questions: usize) -> View<'_> {
        self.surroundings.view(questions, |leaf| self.spheres[leaf as usize])
    }

    /// True where a ball is sure to be farther than `reach` (m) from everything.
    pub fn is_far(&self, centre: [f64; 3], reach: f64) -> bool {
        self.surroundings.is_far(centre, reach)
    }

    /// The nearest solid that is `cap` (m) or less away, or none. Of several at the same
    /// distance it is one with the lowest label.
    pub fn nearest(&self, asking: Asking<'_>, exempt: &Exempt, cap: f64) -> Option<Found> {
        let mut search = Nearest { asked: Asked::new(self, asking, exempt), cap, best: None };
        for index in &self.unbounded {
            search.offer(Place::Solid(*index));
        }
        self.descend(asking, exempt, (search.cap, true), &mut search);
        search.best
    }

    /// The label of a solid that is no farther away (m) than `limit` of its label, or none.
    /// `most` is the largest of these limits. Which one it is of several is not said.
    pub fn any_within(
        &self,
        asking: Asking<'_>,
        exempt: &Exempt,
        most: f64,
        limit: impl Fn(u32) -> f64,
    ) -> Option<u32> {
        let mut search = Within { asked: Asked::new(self, asking, exempt), most, limit, hit: None };
        for index in &self.unbounded {
            if search.offer(Place::Solid(*index)) {
                return search.hit;
            }
        }
        self.descend(asking, exempt, (most, false), &mut search);
        search.hit
    }

    /// Shows the distance of every solid that is `cap` (m) or less away, in no special order;
    /// some may come twice.
    pub fn each_within(
        &self,
        asking: Asking<'_>,
        exempt: &Exempt,
        cap: f64,
        show: impl FnMut(Found),
    ) {
        let mut search = Each { asked: Asked::new(self, asking, exempt), cap, show };
        for index in &self.unbounded {
            search.offer(Place::Solid(*index));
        }
        self.descend(asking, exempt, (cap, false), &mut search);
    }

    /// Goes down the tree; near ones first where that is said.
    fn descend(
        &self,
        asking: Asking<'_>,
        exempt: &Exempt,
        (reach, nearest): (f64, bool),
        leaves: &mut impl Leaves,
    ) {
        let hull;
        let solid = match asking {
            Asking::Solid(solid) => solid,
            Asking::Spheres(spheres) => {
                hull = spheres.hull();
                &hull
            }
        };
        if let Core::HalfSpace(_) = solid.core() {
            // Without bounds there is nothing to rule out.
            for leaf in 0..self.spheres.len() {
                if leaves.look(leaf) == f64::NEG_INFINITY {
                    return;
                }
            }
            return;
        }
        let work = Descent { phase: self, solid, exempt, reach, nearest, leaves };
        dispatch_eights(self.level, work);
    }

    /// The solid found.
    pub fn solid(&self, found: &Found) -> Solid {
        match found.place {
            Place::Solid(index) => self.solids[index].0.clone(),
            Place::Leaf(leaf) => {
                let [x, y, z, r] = self.spheres[leaf];
                Solid::known_sphere([x, y, z], r)
            }
        }
    }
}

/// What is asked about, and what has been answered.
struct Asked<'a> {
    phase: &'a BroadPhase,
    asking: Asking<'a>,
    exempt: &'a Exempt,
    /// Solids looked at last, and the next place to be used.
    seen: [u32; SEEN],
    next: usize,
}

impl<'a> Asked<'a> {
    fn new(phase: &'a BroadPhase, asking: Asking<'a>, exempt: &'a Exempt) -> Self {
        Self { phase, asking, exempt, seen: [SPHERE; SEEN], next: 0 }
    }

    /// The solid that a leaf stands for, unless it was asked for a moment ago.
    fn place(&mut self, leaf: usize) -> Option<Place> {
        let leads_to = self.phase.leads_to[leaf];
        if leads_to == SPHERE {
            return Some(Place::Leaf(leaf));
        }
        if self.seen.contains(&leads_to) {
            return None;
        }
        self.seen[self.next % SEEN] = leads_to;
        self.next += 1;
        Some(Place::Solid(leads_to as usize))
    }

    fn label(&self, place: Place) -> u32 {
        match place {
            Place::Leaf(leaf) => self.phase.labels[leaf],
            Place::Solid(index) => self.phase.solids[index].1,
        }
    }

    /// The distance and the label of a solid that is `cap` or less away, and not exempt.
    fn measure(&self, place: Place, cap: f64) -> Option<Found> {
        let label = self.label(place);
        if self.exempt.contains(label) {
            return None;
        }
        let distance = match place {
            Place::Leaf(leaf) => self.asking.to_sphere(self.phase.spheres[leaf]),
            Place::Solid(index) => self.asking.to_solid(&self.phase.solids[index].0, cap),
        };
        (distance <= cap).then_some(Found { distance, label, place })
    }
}

/// One descent, for the lanes to be chosen.
struct Descent<'a, L> {
    phase: &'a BroadPhase,
    solid: &'a Solid,
    exempt: &'a Exempt,
    reach: f64,
    nearest: bool,
    leaves: &'a mut L,
}

impl<L: Leaves> Kernel32 for Descent<'_, L> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real32>(self) {
        let origin = self.phase.tree.origin();
        match self.solid.core() {
            Core::Point(p) => self.with::<R, _>(&PointProbe::new(*p, origin)),
            Core::Segment(segment) => self.with::<R, _>(&SegmentProbe::new(segment, origin)),
            Core::Cuboid(cuboid) => self.with::<R, _>(&CuboidProbe::new(cuboid, origin)),
            Core::Hull(hull) => {
                self.with::<R, _>(&CuboidProbe::new(&hull.bounding_box(), origin));
            }
            Core::HalfSpace(_) => {}
        }
    }
}

impl<L: Leaves> Descent<'_, L> {
    #[inline(always)]
    fn with<R: Real32, P: Probe<R>>(self, probe: &P) {
        let Self { phase, solid, exempt, .. } = self;
        let labels = if exempt.closed == 0 { ALL_LABELS } else { !exempt.closed };
        let (core, radius, tree) = (solid.core(), solid.radius(), &phase.tree);
        // Called by name: what is called through a pointer is not compiled for the lanes.
        if self.nearest {
            tree.search_nearest::<R, P>(probe, core, radius, self.reach, labels, self.leaves);
        } else {
            tree.search::<R, P>(probe, core, radius, self.reach, labels, self.leaves);
        }
    }
}

/// The nearest so far.
struct Nearest<'a> {
    asked: Asked<'a>,
    /// What is farther away is of no account, m.
    cap: f64,
    best: Option<Found>,
}

impl Nearest<'_> {
    fn offer(&mut self, place: Place) {
        let Some(found) = self.asked.measure(place, self.cap) else { return };
        let nearer = self.best.is_none_or(|best| {
            (found.distance, found.label, found.place) < (best.distance, best.label, best.place)
        });
        if nearer {
            self.cap = found.distance;
            self.best = Some(found);
        }
    }
}

impl Leaves for Nearest<'_> {
    fn look(&mut self, leaf: usize) -> f64 {
        if let Some(place) = self.asked.place(leaf) {
            self.offer(place);
        }
        self.cap
    }
}

/// Whether anything is too near.
struct Within<'a, F> {
    asked: Asked<'a>,
    most: f64,
    limit: F,
    hit: Option<u32>,
}

impl<F: Fn(u32) -> f64> Within<'_, F> {
    fn offer(&mut self, place: Place) -> bool {
        let limit = (self.limit)(self.asked.label(place));
        self.hit = self.asked.measure(place, limit).map(|found| found.label);
        self.hit.is_some()
    }
}

impl<F: Fn(u32) -> f64> Leaves for Within<'_, F> {
    fn look(&mut self, leaf: usize) -> f64 {
        match self.asked.place(leaf) {
            Some(place) if self.offer(place) => f64::NEG_INFINITY,
            _ => self.most,
        }
    }
}

/// All that are near enough.
struct Each<'a, F> {
    asked: Asked<'a>,
    cap: f64,
    show: F,
}

impl<F: FnMut(Found)> Each<'_, F> {
    fn offer(&mut self, place: Place) {
        if let Some(found) = self.asked.measure(place, self.cap) {
            (self.show)(found);
        }
    }
}

impl<F: FnMut(Found)> Leaves for Each<'_, F> {
    fn look(&mut self, leaf: usize) -> f64 {
        if let Some(place) = self.asked.place(leaf) {
            self.offer(place);
        }
        self.cap
    }
}
