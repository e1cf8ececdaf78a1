//! Making a tree: halving the spheres along their longest side until eight are left.

use super::{FAN, FAR, Group, LEVELS};
use crate::distance::norm;
use crate::shapes::Point;

/// Most nodes of the topmost level: a few groups looked at in a row cost less than a level
/// more.
const TOP: usize = 32;

/// Steps from the middle of a box round some spheres to the middle of a sphere round them.
const STEPS: i32 = 6;

/// Spheres in a tree of spheres.
#[derive(Debug, Clone)]
pub struct SphereTree {
    /// What coordinates of groups are counted from, m.
    pub(super) origin: Point,
    /// Distance from the origin that no sphere goes beyond, m.
    pub(super) extent: f64,
    /// The groups of all levels, the leaves first.
    pub(super) groups: Vec<Group>,
    /// Labels in each sphere of a group, label `l` as bit `l % 64`.
    pub(super) labels: Vec<[u64; FAN]>,
    /// First group of each level, and the end of the last one.
    pub(super) first: [u32; LEVELS + 1],
    /// How many levels there are; none where there is no sphere.
    pub(super) levels: usize,
    /// Which of the spheres given stands where.
    order: Vec<u32>,
}

/// A sphere on its way into the tree.
#[derive(Debug, Clone, Copy)]
struct Item {
    centre: Point,
    radius: f64,
    given: u32,
    /// The bits of the labels in it.
    marks: u64,
}

impl SphereTree {
    /// A tree of spheres (x, y, z, radius, m), each with a label.
    ///
    /// Takes about 0.2 us a sphere. The same spheres make the same tree.
    pub fn new(spheres: impl IntoIterator<Item = ([f64; 4], u32)>) -> Self {
        let mut items: Vec<Item> = (0..)
            .zip(spheres)
            .map(|(given, ([x, y, z, radius], label))| Item {
                centre: [x, y, z],
                radius,
                given,
                marks: 1 << (label % 64),
            })
            .collect();
        let n = items.len();
        let mut tree = Self {
            origin: [0.0; 3],
            extent: 0.0,
            groups: Vec::with_capacity(n / 7 + 2 * LEVELS),
            labels: Vec::with_capacity(n / 7 + 2 * LEVELS),
            first: [0; LEVELS + 1],
            levels: 0,
            order: Vec::new(),
        };
        if n == 0 {
            return tree;
        }
        let (lower, upper) = bounds(&items, true);
        tree.origin = [0, 1, 2].map(|k| (lower[k] + upper[k]) / 2.0);
        tree.extent = reach(&items, tree.origin);
        let mut in_node = 1;
        while n.div_ceil(in_node) > TOP {
            in_node *= FAN;
        }
        arrange(&mut items, in_node);

        // The nodes of a level and of the level below, whose spheres those of the next are laid
        // round: that of eight times eight spheres is hardly larger than that of their leaves.
        tree.add_level(&items);
        let (mut nodes, mut below): (Vec<Item>, Option<Vec<Item>>) = (Vec::new(), None);
        while in_node > 1 {
            let (children, inner, each) = match &below {
                None => (&items, &items, FAN),
                Some(below) if below.is_empty() => (&nodes, &items, FAN * FAN),
                Some(below) => (&nodes, below, FAN * FAN),
            };
            let above = children.chunks(FAN).zip(inner.chunks(each)).map(enclosing).collect();
            below = Some(nodes);
            nodes = above;
            tree.add_level(&nodes);
            in_node /= FAN;
        }
        tree.order = items.iter().map(|item| item.given).collect();
        tree
    }

    /// Adds a level of these nodes.
    fn add_level(&mut self, nodes: &[Item]) {
        for nodes in nodes.chunks(FAN) {
            let (mut group, mut marks) = (Group::NONE, [0; FAN]);
            for (lane, node) in nodes.iter().enumerate() {
                let stored = [0, 1, 2].map(|k| (node.centre[k] - self.origin[k]) as f32);
                // What the centre is off by rounding, the sphere is larger by.
                let off =
                    [0, 1, 2].map(|k| f64::from(stored[k]) - (node.centre[k] - self.origin[k]));
                let radius = (node.radius + norm(off)) * (1.0 + 1e-15) + 1e-15 * self.extent;
                [group.x[lane], group.y[lane], group.z[lane]] = stored;
                group.radius[lane] = rounded_up(radius);
                marks[lane] = node.marks;
            }
            self.groups.push(group);
            self.labels.push(marks);
        }
        self.levels += 1;
        self.first[self.levels] = self.groups.len() as u32;
    }

    /// How many spheres there are.
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// Balls (x, y, z, radius, m, from the origin of the tree) of the topmost level: all spheres
    /// lie in them.
    pub(crate) fn top(&self) -> impl Iterator<Item = [f32; 4]> {
        let first = if self.levels == 0 { 0 } else { self.first[self.levels - 1] };
        let groups = &self.groups[first as usize..];
        let lanes =
            groups.iter().flat_map(|g| (0..FAN).map(|i| [g.x[i], g.y[i], g.z[i], g.radius[i]]));
        lanes.filter(|[x, ..]| *x < FAR)
    }

    /// No sphere goes beyond this distance from the origin, m.
    pub(crate) fn extent(&self) -> f64 {
        self.extent
    }

    /// True where there is no sphere.
    pub fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// For each leaf, which of the spheres given it is.
    pub fn order(&self) -> &[u32] {
        &self.order
    }
}

/// The next single above a number, or itself.
pub(super) fn rounded_up(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) < x { near.next_up() } else { near }
}

/// Puts spheres that are near each other into the same nodes of so many.
fn arrange(items: &mut [Item], in_node: usize) {
    if in_node <= 1 {
        return;
    }
    if items.len() <= in_node {
        return arrange(items, in_node / FAN);
    }
    let nodes = items.len().div_ceil(in_node);
    let middle = nodes / 2 * in_node;
    let axis = longest_side(items);
    items.select_nth_unstable_by(middle, |a, b| {
        a.centre[axis].total_cmp(&b.centre[axis]).then(a.given.cmp(&b.given))
    });
    let (low, high) = items.split_at_mut(middle);
    arrange(low, in_node);
    arrange(high, in_node);
}

fn bounds(items: &[Item], radii: bool) -> (Point, Point) {
    let (mut lower, mut upper) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for item in items {
        let r = if radii { item.radius } else { 0.0 };
        for k in 0..3 {
            lower[k] = lower[k].min(item.centre[k] - r);
            upper[k] = upper[k].max(item.centre[k] + r);
        }
    }
    (lower, upper)
}

fn longest_side(items: &[Item]) -> usize {
    let (lower, upper) = bounds(items, false);
    let side = |k: usize| upper[k] - lower[k];
    let longer = if side(1) > side(0) { 1 } else { 0 };
    if side(2) > side(longer) { 2 } else { longer }
}

/// The node of up to eight children: a sphere round what lies in them.
fn enclosing((children, inner): (&[Item], &[Item])) -> Item {
    let centre = around(children);
    let marks = children.iter().fold(0, |marks, child| marks | child.marks);
    // Rounding must not leave anything outside.
    Item { centre, radius: reach(inner, centre) * (1.0 + 1e-15), given: 0, marks }
}

/// How far spheres reach from a point.
fn reach(items: &[Item], from: Point) -> f64 {
    items.iter().map(|item| far(item, from)).fold(0.0, f64::max)
}

fn far(item: &Item, from: Point) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|k| item.centre[k] - from[k]);
    (x * x + y * y + z * z).sqrt() + item.radius
}

/// About the centre of the smallest sphere round spheres: from the middle of the box round
/// them some steps towards what sticks out most, each shorter than the one before.
fn around(items: &[Item]) -> Point {
    let (lower, upper) = bounds(items, true);
    let mut at = [0, 1, 2].map(|k| (lower[k] + upper[k]) / 2.0);
    let mut best = (f64::INFINITY, at);
    for step in 0..=STEPS {
        let mut most = (0.0, at);
        for item in items {
            let far = far(item, at);
            if far > most.0 {
                most = (far, item.centre);
            }
        }
        if most.0 < best.0 {
            best = (most.0, at);
        }
        let share = 0.1 / f64::from(1 + step);
        at = [0, 1, 2].map(|k| at[k] + share * (most.1[k] - at[k]));
    }
    best.1
}
