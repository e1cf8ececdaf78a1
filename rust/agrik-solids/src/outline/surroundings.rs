//! A scene as balls see it: things that are looked at one by one, and a crowd of small ones.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use agrik_compute::lanes::{Real32, dot, sub};

use super::{Field, Outline, roundings, single_above, singles, splat};
use crate::distance::{norm, point_cuboid};
use crate::shapes::{Core, Cuboid, Point, Solid};
use crate::sphere_tree::SphereTree;

/// Most spheres, and most other solids, that are looked at one by one.
const FEW: usize = 32;
const SOME: usize = 64;

/// A sphere that is larger than so many of the rest together is looked at by itself: a field
/// is made for what is small.
const LARGE: f64 = 0.1;

/// One solid, in a box along the axes of the frame.
#[derive(Debug, Clone)]
pub struct Thing {
    label: u32,
    centre: [f32; 3],
    half: [f32; 3],
    outline: Outline,
}

impl Thing {
    fn new(solid: &Solid, label: u32, origin: Point) -> Self {
        let (centre, half) = match solid.core() {
            Core::Point(p) => (*p, [0.0; 3]),
            Core::Segment(s) => (s.at(0.5), [0, 1, 2].map(|k| 0.5 * (s.b[k] - s.a[k]).abs())),
            Core::Cuboid(c) => (c.centre(), upright(c)),
            Core::Hull(hull) => (hull.bounding_box().centre(), upright(&hull.bounding_box())),
            Core::HalfSpace(_) => (origin, [1e18; 3]),
        };
        let centre = sub(centre, origin).map(|x| x as f32);
        let half = half.map(|h| single_above(h + solid.radius()));
        Self { label, centre, half, outline: Outline::new(solid, origin) }
    }

    /// Which object it belongs to.
    pub fn label(&self) -> usize {
        self.label as usize
    }

    /// The solid itself.
    pub fn outline(&self) -> &Outline {
        &self.outline
    }

    /// Lanes, a bit each, whose points may be within `reach` (m) of the box round it.
    #[inline(always)]
    pub fn maybe<R: Real32>(&self, p: &[R; 3], reach: R) -> u32 {
        let (centre, half) = (splat::<R>(self.centre), splat::<R>(self.half));
        let from = [p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]];
        let over = point_cuboid::beyond(&from, &half);
        let square = over[0].mul_add(over[0], over[1].mul_add(over[1], over[2] * over[2]));
        R::bits(square.le(reach * reach))
    }

    /// The same of boxes along the axes of the world, by their middles and half lengths.
    #[inline(always)]
    pub fn maybe_upright<R: Real32>(&self, p: &[R; 3], half: &[R; 3], reach: R) -> u32 {
        let (centre, of_this) = (splat::<R>(self.centre), splat::<R>(self.half));
        let mut gap = R::splat(-1e30);
        for k in 0..3 {
            gap = gap.max((p[k] - centre[k]).abs() - of_this[k] - half[k]);
        }
        R::bits(gap.le(reach))
    }
}

/// Half lengths of the upright box round a box, m.
fn upright(cuboid: &Cuboid) -> Point {
    let [x, y, z] = cuboid.axes();
    [0, 1, 2].map(|k| dot([x[k].abs(), y[k].abs(), z[k].abs()], cuboid.half()))
}

/// All of a scene.
#[derive(Debug)]
pub struct Surroundings {
    origin: Point,
    extent: f64,
    things: Vec<Thing>,
    /// The boxes round them, eight at a time.
    boxes: Vec<Boxes>,
    crowd: Option<Crowd>,
}

/// Eight boxes along the axes, by their middles and half lengths, m.
#[derive(Debug, Clone, Copy)]
struct Boxes {
    centre: [[f32; 8]; 3],
    half: [[f32; 8]; 3],
}

/// Spheres that are too many to be looked at one by one.
#[derive(Debug)]
struct Crowd {
    /// Their indices among those given.
    spheres: Vec<u32>,
    /// Balls round them, few and large, for as long as there is no field.
    nodes: Vec<[f32; 4]>,
    asked: AtomicUsize,
    field: OnceLock<Option<Field>>,
}

/// What is looked at now.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    all: &'a Surroundings,
    crowd: Few<'a>,
}

#[derive(Debug, Clone, Copy)]
enum Few<'a> {
    Nothing,
    Nodes(&'a [[f32; 4]]),
    Field(&'a Field),
}

impl Surroundings {
    /// Of the leaves of a tree: their spheres (x, y, z, radius, m), labels, and whether they are
    /// solids by themselves or lead to one of `solids`.
    pub(crate) fn new<'l>(
        tree: &SphereTree,
        leaves: impl Iterator<Item = (&'l [f64; 4], u32, bool)>,
        solids: &[(Solid, u32)],
    ) -> Self {
        let (origin, mut extent) = (tree.origin(), tree.extent());
        let bounded = |solid: &Solid| !matches!(solid.core(), Core::HalfSpace(_));
        let many = solids.iter().filter(|(solid, _)| bounded(solid)).count() > SOME;
        let mut things = Vec::new();
        for (solid, label) in solids {
            if let Core::HalfSpace(half_space) = solid.core() {
                extent = extent.max(half_space.height(origin).abs());
            } else if many {
                continue;
            }
            things.push(Thing::new(solid, *label, origin));
        }
        let mut left: Vec<(u32, [f64; 4], u32)> = (0..)
            .zip(leaves)
            .filter(|(_, (_, _, alone))| *alone || many)
            .map(|(index, (sphere, label, _))| (index, *sphere, label))
            .collect();
        if left.len() > FEW {
            // The largest are things, where they are few.
            let large = |r: f64| r > LARGE * extent;
            let count = left.iter().filter(|(_, [.., r], _)| large(*r)).count();
            if count <= FEW {
                let (big, rest) = left.into_iter().partition(|(_, [.., r], _)| large(*r));
                add(&mut things, big, origin);
                left = rest;
            }
        } else {
            add(&mut things, std::mem::take(&mut left), origin);
        }
        let crowd = (!left.is_empty()).then(|| Crowd {
            spheres: left.iter().map(|(index, ..)| *index).collect(),
            nodes: tree.top().collect(),
            asked: AtomicUsize::new(0),
            field: OnceLock::new(),
        });
        let boxes = things.chunks(8).map(Boxes::new).collect();
        Self { origin, extent, things, boxes, crowd }
    }

    /// True where a ball is sure to be farther than `reach` (m) from everything: known where
    /// there is a crowd with its field, as the tree is quick enough for a few things.
    pub(crate) fn is_far(&self, centre: Point, reach: f64) -> bool {
        let field = self.crowd.as_ref().and_then(|crowd| crowd.field.get());
        let Some(Some(field)) = field else { return false };
        let p = sub(centre, self.origin);
        let more = roundings(self.extent + norm(p));
        let (p, reach) = (singles(p), single_above(reach + more));
        !field.maybe_one(p, reach) && self.boxes.iter().all(|boxes| boxes.are_far(p, reach))
    }

    /// What there is to be looked at by `questions` more of eight lanes each. `sphere` gives
    /// those of the leaves that this was made of.
    pub(crate) fn view(&self, questions: usize, sphere: impl Fn(u32) -> [f64; 4]) -> View<'_> {
        let crowd = match &self.crowd {
            None => Few::Nothing,
            Some(crowd) => {
                let made = || {
                    let spheres: Vec<_> = crowd.spheres.iter().map(|i| sphere(*i)).collect();
                    Field::new(&spheres, self.origin)
                };
                let asked = |more| crowd.asked.fetch_add(more, Ordering::Relaxed) + more;
                let worth = Field::worth(crowd.spheres.len());
                let field = if questions < worth && asked(questions) < worth {
                    crowd.field.get()
                } else {
                    Some(crowd.field.get_or_init(made))
                };
                match field {
                    Some(Some(field)) => Few::Field(field),
                    _ => Few::Nodes(&crowd.nodes),
                }
            }
        };
        View { all: self, crowd }
    }
}

impl Boxes {
    /// Those of up to eight things.
    fn new(things: &[Thing]) -> Self {
        // Lanes without a thing are far from everything, and their squares numbers.
        let mut made = Self { centre: [[1e18; 8]; 3], half: [[0.0; 8]; 3] };
        for (lane, thing) in things.iter().enumerate() {
            for k in 0..3 {
                made.centre[k][lane] = thing.centre[k];
                made.half[k][lane] = thing.half[k];
            }
        }
        made
    }

    fn are_far(&self, p: [f32; 3], reach: f32) -> bool {
        let mut squares = [0.0_f32; 8];
        for k in 0..3 {
            for (lane, square) in squares.iter_mut().enumerate() {
                let over = (p[k] - self.centre[k][lane]).abs() - self.half[k][lane];
                let over = if over > 0.0 { over } else { 0.0 };
                *square += over * over;
            }
        }
        let reach = reach * reach;
        !squares.iter().fold(false, |near, square| near | (*square <= reach))
    }
}

fn add(things: &mut Vec<Thing>, spheres: Vec<(u32, [f64; 4], u32)>, origin: Point) {
    for (_, [x, y, z, r], label) in spheres {
        things.push(Thing::new(&Solid::known_sphere([x, y, z], r), label, origin));
    }
}

impl<'a> View<'a> {
    /// What coordinates in lanes count from, m.
    pub fn origin(&self) -> Point {
        self.all.origin
    }

    /// Nothing is farther away from there than this, m, but for half-spaces.
    pub fn extent(&self) -> f64 {
        self.all.extent
    }

    /// What is to be looked at one by one.
    pub fn things(&self) -> &'a [Thing] {
        &self.all.things
    }

    /// Shows the places of things whose boxes may be within `reach` (m) of one point, which is in
    /// all of eight lanes: eight things at a time.
    #[inline(always)]
    pub fn each_near<R: Real32>(&self, p: &[R; 3], reach: R, mut show: impl FnMut(usize)) {
        for (group, boxes) in self.all.boxes.iter().enumerate() {
            let (c, h) = (&boxes.centre, &boxes.half);
            let mut square = R::splat(0.0);
            for k in 0..3 {
                let over = (p[k] - R::load(&c[k])).abs() - R::load(&h[k]);
                let over = over.max(R::splat(0.0));
                square = over.mul_add(over, square);
            }
            let mut near = R::bits(square.le(reach * reach));
            while near != 0 {
                let place = 8 * group + near.trailing_zeros() as usize;
                near &= near - 1;
                if place < self.all.things.len() {
                    show(place);
                }
            }
        }
    }

    /// There is more than things.
    pub fn is_crowded(&self) -> bool {
        !matches!(self.crowd, Few::Nothing)
    }

    /// Lanes, a bit each, whose points may be within `reach` (m, 0 or more) of any of the rest.
    #[inline(always)]
    pub fn maybe_crowd<R: Real32>(&self, p: &[R; 3], reach: R) -> u32 {
        match self.crowd {
            Few::Nothing => 0,
            Few::Field(field) => field.maybe(p, reach),
            Few::Nodes(nodes) => {
                let mut near = 0;
                for [x, y, z, r] in nodes {
                    let at = splat::<R>([*x, *y, *z]);
                    let from = [p[0] - at[0], p[1] - at[1], p[2] - at[2]];
                    let square =
                        from[0].mul_add(from[0], from[1].mul_add(from[1], from[2] * from[2]));
                    let reach = reach + R::splat(f64::from(*r));
                    near |= R::bits(square.le(reach * reach));
                }
                near
            }
        }
    }
}
