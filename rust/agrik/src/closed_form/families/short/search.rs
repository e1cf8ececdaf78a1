//! The search for all postures that reach a goal, and for those that miss it by least: cells of
//! joint values, halved, and left out where none of them can hold an answer.

use std::f64::consts::PI;

use super::descend::Posture;
use super::look::Bound;
use super::{Room, Short, TURNING};
use crate::closed_form::families::postures::turned;
use crate::closed_form::geometry::rigid::Rigid;
use crate::lanes::Level;
use crate::random::Sequence;

/// Random starts of steps before the search.
const STARTS: usize = 12;
/// Cells from whose middle steps are taken at each size of cells.
const TRIED: usize = 4;
/// Cells that are looked at, at most.
const CELLS: usize = 400_000;
/// Cells whose middle is tried where there were more.
const LAST: usize = 64;
/// Cells in which no joint moves the tool by more than this share of the arm's size are tried.
const SMALL: f64 = 1e-6;
/// Postures nearer to one another are one, rad.
const SAME: f64 = 1e-5;
/// Share of the arm's size by which a posture in a cell that is left out might be better.
const GAP: f64 = 1e-3;
/// Joints move along a way that moves the tool by less than this share of what it could be.
const STILL: f64 = 1e-6;
/// How far a joint that may turn freely is turned to see whether it does, rad.
const TURNED: f64 = 0.05;
/// Share of the arm's size by which errors that are the same differ.
const EQUAL: f64 = 1e-9;

/// What was found.
#[derive(Debug, Clone, Default)]
pub struct Found {
    pub postures: Vec<Posture>,
    /// A joint that turns freely while a posture of these reaches the goal: nothing else was
    /// looked for.
    pub free: Option<usize>,
    /// Cells were left of which nothing is known: that there is no other posture is not proven.
    pub unproven: bool,
    /// Cells looked at.
    pub cells: usize,
}

impl Found {
    fn holds(&self, q: &[f64; TURNING]) -> bool {
        self.postures.iter().any(|one| far(&one.q, q) < SAME)
    }

    /// The least error, m.
    pub fn best(&self) -> f64 {
        self.postures.iter().map(|one| one.error).fold(f64::INFINITY, f64::min)
    }
}

/// Largest difference of any joint, whole turns aside.
fn far(a: &[f64; TURNING], b: &[f64; TURNING]) -> f64 {
    a.iter().zip(b).map(|(a, b)| turned(a - b).abs()).fold(0.0, f64::max)
}

/// Cells of one size.
struct Cells {
    half: [f64; TURNING],
    middles: Vec<[f64; TURNING]>,
}

impl Short {
    /// One cell for all that there is room for.
    fn whole(&self, room: &Room) -> Cells {
        let (mut half, mut middle) = ([0.0; TURNING], [0.0; TURNING]);
        for k in self.moving() {
            let wide = 0.5 * (room.upper[k] - room.lower[k]);
            half[k] = wide.clamp(0.0, PI);
            middle[k] = if wide < PI { 0.5 * (room.upper[k] + room.lower[k]) } else { 0.0 };
        }
        Cells { half, middles: vec![middle] }
    }

    /// What moves the tool most within a cell: a joint, and by how much, m.
    fn widest(&self, half: &[f64; TURNING]) -> (usize, f64) {
        let way = |k: usize| half[k] * self.levers[k];
        let widest = self.moving().max_by(|a, b| way(*a).total_cmp(&way(*b)));
        widest.map_or((0, 0.0), |k| (k, way(k)))
    }

    /// Every posture whose error is at most `most`, m, with the least error nearby. `most` is
    /// small beside the arm. The search ends at once where a joint turns freely.
    pub fn exact(
        &self,
        level: Level,
        goal: &Rigid<f64>,
        room: &Room,
        start: &[f64; TURNING],
        most: f64,
    ) -> Found {
        let mut found = Found::default();
        // Within its ball around it a posture is the only one.
        let mut balls: Vec<([f64; TURNING], f64)> = Vec::new();
        let mut cells = self.whole(room);
        let mut tries = self.tries(&cells, start);
        let mut bounds: Vec<Bound> = Vec::new();
        loop {
            for start in &tries {
                let one = self.descend(goal, room, start);
                if one.error <= most && !found.holds(&one.q) {
                    found.postures.push(one);
                    let (weakest, way) = self.weakest(goal, room, &one.q);
                    found.free = self.turning_freely(goal, room, &one, (weakest, way), most);
                    if found.free.is_some() {
                        return found;
                    }
                    balls.push((one.q, self.alone_within(weakest)));
                }
            }
            if cells.middles.is_empty() {
                return found;
            }
            found.cells += cells.middles.len();
            self.bounds(level, (goal, room.slide), cells.half, &cells.middles, &mut bounds);
            let mut left = Vec::with_capacity(cells.middles.len());
            for (middle, bound) in cells.middles.iter().zip(&bounds) {
                if bound.least <= most && !self.is_inside(&balls, middle, &cells.half) {
                    left.push((bound.error, *middle));
                }
            }
            let (widest, way) = self.widest(&cells.half);
            let small = way <= SMALL * self.size;
            let full = found.cells + 2 * left.len() > CELLS;
            let last = small || full;
            found.unproven = last && !left.is_empty();
            tries = nearest(&mut left, if last { LAST } else { TRIED });
            let next = if last { &[][..] } else { &left[..] };
            cells = halved(&cells.half, next.iter().map(|(_, middle)| middle), widest);
        }
    }

    /// A start, and random ones all over a cell.
    fn tries(&self, cell: &Cells, start: &[f64; TURNING]) -> Vec<[f64; TURNING]> {
        let mut random = Sequence::new(23);
        let middle = cell.middles[0];
        let spread = (0..STARTS).map(|_| -> [f64; TURNING] {
            std::array::from_fn(|k| middle[k] + cell.half[k] * (2.0 * random.uniform() - 1.0))
        });
        std::iter::once(*start).chain(spread).collect()
    }

    /// The joint that moves most along the way in which a posture can move on without leaving
    /// the goal, if there is such a way.
    fn turning_freely(
        &self,
        goal: &Rigid<f64>,
        room: &Room,
        one: &Posture,
        (weakest, way): (f64, [f64; TURNING]),
        most: f64,
    ) -> Option<usize> {
        let joint = self.moving().max_by(|a, b| way[*a].abs().total_cmp(&way[*b].abs()))?;
        if weakest > STILL || way[joint] == 0.0 {
            return None;
        }
        let moves = |side: f64| {
            let factor = side * TURNED / way[joint].abs();
            let start = std::array::from_fn(|k| one.q[k] + factor * way[k]);
            let mut held = *room;
            (held.lower[joint], held.upper[joint]) = (start[joint], start[joint]);
            self.descend(goal, &held, &start).error <= most
        };
        (moves(1.0) || moves(-1.0)).then_some(joint)
    }

    /// A radius, of joint values times their levers, m, within which a posture that reaches a goal
    /// is the only one: a way of z from it moves the tool by more than
    /// weakest |z| - curved |z|^2 / 2.
    fn alone_within(&self, weakest: f64) -> f64 {
        let mut curved: f64 = 0.0;
        for i in self.moving() {
            let lever = |j: usize| self.levers[i.max(j)];
            let row = self.moving().map(|j| lever(j) / (self.levers[i] * self.levers[j]));
            curved = curved.max(row.sum());
        }
        if curved > 0.0 { weakest / curved } else { f64::INFINITY }
    }

    /// A cell is inside a ball.
    fn is_inside(
        &self,
        balls: &[([f64; TURNING], f64)],
        middle: &[f64; TURNING],
        half: &[f64; TURNING],
    ) -> bool {
        balls.iter().any(|(at, radius)| {
            let way = |k: usize| self.levers[k] * (turned(middle[k] - at[k]).abs() + half[k]);
            self.moving().map(|k| way(k).powi(2)).sum::<f64>() < radius * radius
        })
    }

    /// The postures of least error.
    pub fn least(
        &self,
        level: Level,
        goal: &Rigid<f64>,
        room: &Room,
        start: &[f64; TURNING],
    ) -> Found {
        let mut found = Found::default();
        let mut cells = self.whole(room);
        let mut tries = self.tries(&cells, start);
        let mut bounds: Vec<Bound> = Vec::new();
        let add = |found: &mut Found, start: &[f64; TURNING]| {
            let one = self.descend(goal, room, start);
            if !found.holds(&one.q) {
                found.postures.push(one);
            }
        };
        loop {
            for start in &tries {
                add(&mut found, start);
            }
            let best = found.best();
            found.cells += cells.middles.len();
            self.bounds(level, (goal, room.slide), cells.half, &cells.middles, &mut bounds);
            let (widest, way) = self.widest(&cells.half);
            let small = way <= SMALL * self.size;
            let (mut left, mut last) = (Vec::with_capacity(cells.middles.len()), Vec::new());
            for (middle, bound) in cells.middles.iter().zip(&bounds) {
                if bound.least > best + EQUAL * self.size {
                    continue;
                }
                if small || bound.least > best - GAP * self.size {
                    // None in it is better by much; whether one is by a little is tried.
                    last.push((bound.error, *middle));
                } else {
                    left.push((bound.error, *middle));
                }
            }
            for middle in nearest(&mut last, TRIED) {
                let near = |one: &Posture| {
                    let way = |k: usize| turned(one.q[k] - middle[k]).abs() <= 2.0 * cells.half[k];
                    self.moving().all(way)
                };
                if !found.postures.iter().any(near) {
                    add(&mut found, &middle);
                }
            }
            let full = found.cells + 2 * left.len() > CELLS;
            if full {
                for middle in nearest(&mut left, LAST) {
                    add(&mut found, &middle);
                }
            }
            if full || left.is_empty() {
                found.unproven = full && !left.is_empty();
                break;
            }
            tries = nearest(&mut left, TRIED);
            cells = halved(&cells.half, left.iter().map(|(_, middle)| middle), widest);
        }
        let best = found.best();
        found.postures.retain(|one| one.error <= best + EQUAL * self.size);
        found
    }
}

/// The middles of the cells with the smallest errors there, which come first then.
fn nearest(cells: &mut [(f64, [f64; TURNING])], count: usize) -> Vec<[f64; TURNING]> {
    let count = count.min(cells.len());
    let by_error = |a: &(f64, _), b: &(f64, _)| a.0.total_cmp(&b.0);
    if count < cells.len() {
        cells.select_nth_unstable_by(count, by_error);
    }
    cells[..count].sort_by(by_error);
    cells[..count].iter().map(|(_, middle)| *middle).collect()
}

/// Cells cut in two across a joint.
fn halved<'a>(
    half: &[f64; TURNING],
    middles: impl Iterator<Item = &'a [f64; TURNING]>,
    joint: usize,
) -> Cells {
    let mut smaller = *half;
    smaller[joint] *= 0.5;
    let sides = |middle: &[f64; TURNING]| {
        [-1.0, 1.0].map(|side| {
            let mut one = *middle;
            one[joint] += side * smaller[joint];
            one
        })
    };
    Cells { half: smaller, middles: middles.flat_map(sides).collect() }
}
