//! Covers of a box by spheres, as the paper on cucumber picking has them: 1, 8, 64 or 512
//! equal cells, each in the sphere round it, and the distance that they give.
//!
//! A sphere round a cell contains it, so a cover is never farther away from anything than
//! its box. How much nearer it seems is bounded by [`Cover::overestimate`]. Source: Van
//! Henten, Schenk, Van Willigenburg, Meuleman and Barreiro, "Collision-free inverse
//! kinematics of the redundant seven-link manipulator used in a cucumber picking robot",
//! Biosystems Engineering (2010), appendix A.

use agrik_compute::lanes::sub;

use crate::distance::{norm, point_to_core};
use crate::shapes::{Core, Cuboid, Point, Solid};

/// The finest level: 8^3 spheres.
pub const FINEST: usize = 3;

/// How the cells of one level are cut into those of the next, eight each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Split {
    /// Once along each axis, as in the paper: every cell has the shape of the box, and every
    /// sphere lies within that of its parent.
    Equal,
    /// Three times along the side that is longest then: cells of a long box come near to
    /// cubes, and their spheres are smaller.
    NearCubic,
}

/// The cells of all levels of a box, in its own frame: made once, wherever the box lies.
#[derive(Debug, Clone)]
pub struct Cover {
    /// Half lengths of the cells of each level, m.
    half: [Point; FINEST + 1],
    /// Their centres from the centre of the box, m.
    centres: [Vec<Point>; FINEST + 1],
}

impl Cover {
    /// The covers of boxes with the half lengths of this one.
    pub fn new(cuboid: &Cuboid, split: Split) -> Self {
        let mut half = [cuboid.half(); FINEST + 1];
        let mut centres = [vec![[0.0; 3]], Vec::new(), Vec::new(), Vec::new()];
        for level in 0..FINEST {
            let mut cell = half[level];
            let mut children = centres[level].clone();
            for axis in 0..3 {
                let cut = match split {
                    Split::Equal => axis,
                    Split::NearCubic => longest(cell),
                };
                cell[cut] /= 2.0;
                let moved = |centre: Point, side: f64| {
                    let mut moved = centre;
                    moved[cut] += side * cell[cut];
                    moved
                };
                children =
                    children.into_iter().flat_map(|c| [moved(c, -1.0), moved(c, 1.0)]).collect();
            }
            half[level + 1] = cell;
            centres[level + 1] = children;
        }
        Self { half, centres }
    }

    /// How many spheres a level has; here as below, a level above [`FINEST`] counts as that.
    pub fn count(level: usize) -> usize {
        1 << (3 * level.min(FINEST))
    }

    /// Half lengths of the cells of a level, m.
    pub fn half(&self, level: usize) -> Point {
        self.half[level.min(FINEST)]
    }

    /// Radius of the spheres of a level, m.
    pub fn radius(&self, level: usize) -> f64 {
        norm(self.half(level))
    }

    /// Centres of the spheres of a level in the frame of the box, from its centre, m. The
    /// children of sphere `s` are `8 s` to `8 s + 7` of the next level.
    pub fn centres(&self, level: usize) -> &[Point] {
        &self.centres[level.min(FINEST)]
    }

    /// The most that a level seems nearer to any sphere than the box is, m: what a sphere
    /// has beyond the largest ball within its cell.
    pub fn overestimate(&self, level: usize) -> f64 {
        let half = self.half(level);
        norm(half) - half[0].min(half[1]).min(half[2])
    }

    /// Distance of a level's spheres from others (x, y, z, radius, m), and `cap` where that is
    /// less, m: equation (A2), of every pair. `cuboid` is the box where it lies now.
    pub fn brute_force(
        &self,
        level: usize,
        cuboid: &Cuboid,
        spheres: &[[f64; 4]],
        cap: f64,
    ) -> f64 {
        let radius = self.radius(level);
        let mut least = cap;
        for sphere in spheres.iter().map(|sphere| local(cuboid, sphere)) {
            for centre in self.centres(level) {
                least = least.min(apart(*centre, sphere) - radius);
            }
        }
        least
    }

    /// The same number, found through the levels above: of a pair of a sphere of the cover
    /// and one of the others only those children are looked at that may come nearer than what
    /// is sure so far.
    pub fn distance(&self, level: usize, cuboid: &Cuboid, spheres: &[[f64; 4]], cap: f64) -> f64 {
        let level = level.min(FINEST);
        let radius = self.radius(level);
        let others: Vec<[f64; 4]> = spheres.iter().map(|sphere| local(cuboid, sphere)).collect();
        let mut sure = cap;
        let mut pairs: Vec<(usize, usize)> = (0..others.len()).map(|other| (0, other)).collect();
        for above in 0..level {
            // The centres of all descendants are within `spread` of that of the cell, and
            // rounding must not lose the best of them.
            let spread = norm(sub(self.half(above), self.half(level))) + 1e-13 * self.radius(0);
            let away = |(sphere, other): &(usize, usize)| {
                apart(self.centres[above][*sphere], others[*other]) - radius
            };
            sure = pairs.iter().map(|pair| away(pair) + spread).fold(sure, f64::min);
            pairs = pairs
                .into_iter()
                .filter(|pair| away(pair) - spread <= sure)
                .flat_map(|(sphere, other)| (0..8).map(move |child| (8 * sphere + child, other)))
                .collect();
        }
        let centres = &self.centres[level];
        pairs.into_iter().map(|(i, j)| apart(centres[i], others[j]) - radius).fold(cap, f64::min)
    }
}

/// One level of a cover where its box lies: what asks a scene in place of the box.
#[derive(Debug, Clone, Copy)]
pub struct Spheres<'a> {
    cover: &'a Cover,
    level: usize,
    cuboid: Cuboid,
    /// The box with all that the spheres can reach beyond it.
    around: f64,
    radius: f64,
    cells: Point,
}

impl<'a> Spheres<'a> {
    /// The spheres of a level of a cover, each larger by `radius` (m), where the box is.
    pub fn new(cover: &'a Cover, level: usize, cuboid: Cuboid, radius: f64) -> Self {
        let (all, cell) = (cover.half(0), cover.half(level));
        let cells = [0, 1, 2].map(|k| if cell[k] > 0.0 { (all[k] / cell[k]).round() } else { 1.0 });
        let around = cover.overestimate(level) + radius + 1e-13 * cover.radius(0);
        let radius = radius + cover.radius(level);
        Self { cover, level, cuboid, around, radius, cells }
    }

    /// A solid that holds all spheres: the box with a radius.
    pub(crate) fn hull(&self) -> Solid {
        Solid::known(Core::Cuboid(self.cuboid), self.around)
    }

    /// Distance of the nearest sphere from a sphere (x, y, z, radius, m), m. The centres are
    /// the points of a grid, so that of the nearest one is known at once.
    pub(crate) fn distance_from_sphere(&self, [x, y, z, r]: [f64; 4]) -> f64 {
        let (local, cell) = (self.cuboid.local([x, y, z]), self.cover.half(self.level));
        let off = [0, 1, 2].map(|k| {
            if cell[k] == 0.0 {
                return local[k];
            }
            let (last, width) = (self.cells[k] - 1.0, 2.0 * cell[k]);
            let at = ((local[k] + self.cover.half(0)[k]) / width).floor().clamp(0.0, last);
            local[k] - (at.mul_add(2.0, -last) * cell[k])
        });
        norm(off) - self.radius - r
    }

    /// Distance of the nearest sphere from a solid, m; a number above `cap` (m) where it is
    /// farther away than that.
    pub(crate) fn distance_from_solid(&self, solid: &Solid, cap: f64) -> f64 {
        let mut least = f64::INFINITY;
        let mut open = vec![(0, 0)];
        while let Some((level, index)) = open.pop() {
            let centre = self.cuboid.point(self.cover.centres(level)[index]);
            let away = point_to_core(centre, solid.core()) - solid.radius() - self.radius;
            if level == self.level {
                least = least.min(away);
                continue;
            }
            let spread = norm(sub(self.cover.half(level), self.cover.half(self.level)));
            if away - spread <= least.min(cap) + 1e-13 * self.cover.radius(0) {
                open.extend((0..8).rev().map(|child| (level + 1, 8 * index + child)));
            }
        }
        least
    }
}

fn longest(sides: Point) -> usize {
    let longer = if sides[1] > sides[0] { 1 } else { 0 };
    if sides[2] > sides[longer] { 2 } else { longer }
}

/// A sphere in the frame of a box, from its centre.
fn local(cuboid: &Cuboid, [x, y, z, r]: &[f64; 4]) -> [f64; 4] {
    let [x, y, z] = cuboid.local([*x, *y, *z]);
    [x, y, z, *r]
}

/// Distance of a centre from a sphere, m.
fn apart(centre: Point, [x, y, z, r]: [f64; 4]) -> f64 {
    norm(sub([x, y, z], centre)) - r
}
