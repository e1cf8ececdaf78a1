//! Going down a tree: where anything within reach is, and what is nearest.

use agrik_compute::lanes::Real32;

use super::build::rounded_up;
use super::{FAN, FARTHEST, Group, LEVELS, SphereTree};
use crate::distance::norm;
use crate::probe::Probe;
use crate::shapes::Core;

/// The labels of a query that takes all.
pub const ALL_LABELS: u64 = u64::MAX;

/// What the caller knows of the leaves, and decides in doubles.
pub trait Leaves {
    /// Looks at a leaf (by its place in [`SphereTree::order`]) that may be within reach, and
    /// gives the reach from then on, m: less once something nearer is found; negative
    /// infinity ends the search.
    fn look(&mut self, leaf: usize) -> f64;
}

/// Rounding errors of singles that distances add up to, in half units of the last place of
/// the largest length that comes into them; a third of it is what they can come to.
const ROUNDINGS: f64 = 64.0 / 16_777_216.0;

/// What one search asks.
struct Question<'a, R, P> {
    tree: &'a SphereTree,
    probe: &'a P,
    labels: u64,
    /// What is added to a distance in metres to make it a reach of singles.
    more: f64,
    lanes: std::marker::PhantomData<R>,
}

impl SphereTree {
    /// How far singles may be off, m, for a core with these bounds.
    fn margin(&self, core: &Core) -> f64 {
        let (centre, size) = core.bounding_sphere();
        let away = norm([0, 1, 2].map(|k| centre[k] - self.origin[k]));
        ROUNDINGS * (self.extent + away + size)
    }

    /// Shows to `leaves` every sphere that may be within `reach` (m) of all points within
    /// `radius` of a core, in any order, and those of labels without a bit in `labels` left
    /// out. Returns early when told so.
    ///
    /// `probe` is that of the core, from [`SphereTree::origin`].
    #[inline(always)]
    pub fn search<R: Real32, P: Probe<R>>(
        &self,
        probe: &P,
        core: &Core,
        radius: f64,
        reach: f64,
        labels: u64,
        leaves: &mut impl Leaves,
    ) {
        let more = radius + self.margin(core);
        Question::<R, P> { tree: self, probe, labels, more, lanes: std::marker::PhantomData }
            .any(reach, leaves);
    }

    /// The same, near ones first: for a `reach` that shrinks as leaves are looked at.
    #[inline(always)]
    pub fn search_nearest<R: Real32, P: Probe<R>>(
        &self,
        probe: &P,
        core: &Core,
        radius: f64,
        reach: f64,
        labels: u64,
        leaves: &mut impl Leaves,
    ) {
        let more = radius + self.margin(core);
        Question::<R, P> { tree: self, probe, labels, more, lanes: std::marker::PhantomData }
            .nearest(reach, leaves);
    }

    /// What probes count their coordinates from, m.
    pub fn origin(&self) -> [f64; 3] {
        self.origin
    }
}

impl<R: Real32, P: Probe<R>> Question<'_, R, P> {
    /// A reach in singles, not less than that in metres.
    #[inline(always)]
    fn singles(&self, reach: f64) -> f32 {
        rounded_up((reach + self.more).min(FARTHEST))
    }

    #[inline(always)]
    fn group(&self, level: usize, index: usize) -> (&Group, u32) {
        let at = self.tree.first[level] as usize + index;
        let mut lanes = (1 << FAN) - 1;
        if self.labels != ALL_LABELS {
            lanes = 0;
            for (lane, labels) in self.tree.labels[at].iter().enumerate() {
                lanes |= u32::from(labels & self.labels != 0) << lane;
            }
        }
        (&self.tree.groups[at], lanes)
    }

    #[inline(always)]
    fn square(&self, group: &Group) -> R {
        self.probe.square(&[R::load(&group.x), R::load(&group.y), R::load(&group.z)])
    }

    /// The lanes of a group that are within reach.
    #[inline(always)]
    fn near(&self, level: usize, index: usize, within: R) -> u32 {
        let (group, lanes) = self.group(level, index);
        let reach = (R::load(&group.radius) + within).max(R::splat(0.0));
        let points = [R::load(&group.x), R::load(&group.y), R::load(&group.z)];
        let lanes = lanes & self.probe.maybe_within(&points, reach);
        // Mostly nothing of a group is near.
        if lanes == 0 {
            return 0;
        }
        R::bits(self.probe.square(&points).le(reach * reach)) & lanes
    }

    /// The same, and how far away the spheres are.
    #[inline(always)]
    fn measured(&self, level: usize, index: usize, within: f32, away: &mut [f32; FAN]) -> u32 {
        let (group, lanes) = self.group(level, index);
        let distance = self.square(group).sqrt() - R::load(&group.radius);
        distance.store(away);
        R::bits(distance.le(R::splat(f64::from(within)))) & lanes
    }

    /// How many groups a level has.
    #[inline(always)]
    fn groups(&self, level: usize) -> usize {
        self.tree.first[level + 1] as usize - self.tree.first[level] as usize
    }

    #[inline(always)]
    fn any(&self, reach: f64, leaves: &mut impl Leaves) {
        let Some(top) = self.tree.levels.checked_sub(1) else { return };
        let mut within = R::splat(f64::from(self.singles(reach)));
        // The group in hand on each level, and its lanes still to be gone into.
        let mut path = [(0, 0_u32); LEVELS];
        for root in 0..self.groups(top) {
            let mut level = top;
            path[top] = (root, self.near(top, root, within));
            loop {
                let (index, lanes) = path[level];
                if lanes == 0 {
                    if level == top {
                        break;
                    }
                    level += 1;
                    continue;
                }
                path[level].1 = lanes & (lanes - 1);
                let child = index * FAN + lanes.trailing_zeros() as usize;
                if level == 0 {
                    let reach = leaves.look(child);
                    if reach == f64::NEG_INFINITY {
                        return;
                    }
                    within = R::splat(f64::from(self.singles(reach)));
                } else {
                    level -= 1;
                    path[level] = (child, self.near(level, child, within));
                }
            }
        }
    }

    #[inline(always)]
    fn nearest(&self, reach: f64, leaves: &mut impl Leaves) {
        let Some(top) = self.tree.levels.checked_sub(1) else { return };
        let mut within = self.singles(reach);
        // As above, and how far away the spheres of the group are.
        let mut path = [(0, 0_u32); LEVELS];
        let mut away = [[0.0_f32; FAN]; LEVELS];
        for root in 0..self.groups(top) {
            let mut level = top;
            path[top] = (root, self.measured(top, root, within, &mut away[top]));
            loop {
                let (index, lanes) = path[level];
                let Some((lane, near)) = next(lanes, &away[level]) else {
                    if level == top {
                        break;
                    }
                    level += 1;
                    continue;
                };
                // The nearest is too far by now, and so are the others.
                if near > within {
                    path[level].1 = 0;
                    continue;
                }
                path[level].1 = lanes & !(1 << lane);
                let child = index * FAN + lane;
                if level == 0 {
                    let reach = leaves.look(child);
                    if reach == f64::NEG_INFINITY {
                        return;
                    }
                    within = self.singles(reach);
                } else {
                    level -= 1;
                    path[level] = (child, self.measured(level, child, within, &mut away[level]));
                }
            }
        }
    }
}

/// The lane of those given whose sphere is nearest, and how near.
#[inline(always)]
fn next(lanes: u32, away: &[f32; FAN]) -> Option<(usize, f32)> {
    let mut left = lanes;
    let mut best = None;
    let mut least = f32::INFINITY;
    while left != 0 {
        let lane = left.trailing_zeros() as usize;
        left &= left - 1;
        if away[lane] < least {
            least = away[lane];
            best = Some((lane, least));
        }
    }
    best
}
