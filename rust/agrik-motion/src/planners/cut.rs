//! A proof that there is no path: a ball that a body holds is shut in.
//!
//! Space is cut into cells. A cell in which the centre of the ball may be has its own centre no
//! nearer to the scene than the ball's radius less half the cell's diagonal; all others are
//! closed. However the arm moves, the centre of the ball moves without a jump, from cell to
//! neighbouring cell (those at corners too), and never through a closed one. So if the open
//! cells that hang together with those of all goals end somewhere, and that of the start is not
//! among them, there is no path. What the ball may touch at any time is left out of the scene,
//! so the proof is right whatever may be touched, and wherever the arm could go.

use std::collections::{BinaryHeap, HashSet};

use agrik_compute::lanes::{dot, sub};
use agrik_solids::{Core, Point, Solid};

use crate::Collider;

/// Cells to the radius of the ball.
const FINE: f64 = 11.0;
/// With more open cells than this a ball is not shut in.
const MOST: usize = 30_000;

/// A ball that is shut in.
#[derive(Debug, Clone, PartialEq)]
pub struct Cut {
    /// The body that holds it.
    pub body: usize,
    /// Its centre in the body's place at the start, and at every goal, m.
    pub start: Point,
    /// See `start`.
    pub goals: Vec<Point>,
    /// Its radius, m.
    pub radius: f64,
    /// Length of the cells, m; the cell of the numbers (0, 0, 0) has its centre at `origin`.
    pub cell: f64,
    /// See `cell`.
    pub origin: Point,
    /// Open cells that hang together with the goals.
    pub cells: usize,
    /// The goals are shut in; else the start is.
    pub at_goal: bool,
}

/// A proof that no path leads from `start` to any of `goals`, if one is found.
pub fn cut(collider: &Collider, start: &[f64], goals: &[&[f64]]) -> Option<Cut> {
    let bodies = collider.bodies();
    let mut placed = bodies.room();
    let mut balls: Vec<(usize, f64)> = (0..bodies.len())
        .filter(|body| bodies.moved_by(*body) > 0)
        .filter_map(|body| Some((body, ball(&bodies.mounts()[body].solid)?.1)))
        .collect();
    balls.sort_by(|a, b| b.1.total_cmp(&a.1));
    for (body, radius) in balls {
        let mut centre = |q: &[f64]| {
            bodies.place_unchecked(q, &mut placed);
            ball(&placed.solids()[body]).map(|found| found.0)
        };
        let Some(from) = centre(start) else { continue };
        let to: Vec<Point> = goals.iter().filter_map(|goal| centre(goal)).collect();
        let cells = Cells::new(collider, body, radius, from);
        for at_goal in [true, false] {
            let found =
                if at_goal { cells.shut_in(&to, &[from]) } else { cells.shut_in(&[from], &to) };
            if let Some(count) = found {
                let (cell, origin) = (cells.size, cells.origin);
                return Some(Cut {
                    body,
                    start: from,
                    goals: to,
                    radius,
                    cell,
                    origin,
                    cells: count,
                    at_goal,
                });
            }
        }
    }
    None
}

/// The largest ball inside a solid that has its centre in the middle: its centre and radius.
fn ball(solid: &Solid) -> Option<(Point, f64)> {
    let (centre, inner) = match solid.core() {
        Core::Point(p) => (*p, 0.0),
        Core::Segment(segment) => (segment.at(0.5), 0.0),
        Core::Cuboid(cuboid) => {
            (cuboid.centre(), cuboid.half().into_iter().fold(f64::INFINITY, f64::min))
        }
        Core::Hull(_) | Core::HalfSpace(_) => return None,
    };
    let radius = solid.radius() + inner;
    (radius > 0.0).then_some((centre, radius))
}

type Cell = [i64; 3];

/// Cells of a ball.
struct Cells<'c> {
    collider: &'c Collider,
    body: usize,
    /// A cell is open whose centre is as far from the scene, m.
    least: f64,
    size: f64,
    origin: Point,
}

impl<'c> Cells<'c> {
    fn new(collider: &'c Collider, body: usize, radius: f64, origin: Point) -> Self {
        let size = radius / FINE;
        Self { collider, body, least: radius - 0.5 * size * 3.0_f64.sqrt(), size, origin }
    }

    fn of(&self, p: Point) -> Cell {
        let way = sub(p, self.origin);
        way.map(|x| (x / self.size).round() as i64)
    }

    fn centre(&self, cell: Cell) -> Point {
        [0, 1, 2].map(|k| self.origin[k] + cell[k] as f64 * self.size)
    }

    fn is_open(&self, cell: Cell) -> bool {
        let Ok(point) = Solid::sphere(self.centre(cell), 0.0) else { return true };
        let exempt = match self.collider.touch_exemption(self.body) {
            Some((touching, ..)) => touching,
            None => self.collider.usual_exemption(self.body),
        };
        !self.collider.scene().hits_plain(&point, exempt, self.least)
    }

    /// How many open cells hang together with those of `inside`, if they come to an end without
    /// a cell of `outside`. Those towards it are looked at first: mostly they lead there.
    fn shut_in(&self, inside: &[Point], outside: &[Point]) -> Option<usize> {
        let wanted: HashSet<Cell> = outside.iter().map(|p| self.of(*p)).collect();
        let aim = *outside.first()?;
        let mut seen: HashSet<Cell> = HashSet::new();
        let mut open = BinaryHeap::new();
        let mut count = 0;
        let rank = |cell: Cell| {
            let way = sub(self.centre(cell), aim);
            // Nearest first; a whole number has an order.
            std::cmp::Reverse((dot(way, way).sqrt() / self.size) as i64)
        };
        for p in inside {
            let cell = self.of(*p);
            if seen.insert(cell) {
                open.push((rank(cell), cell));
            }
        }
        while let Some((_, cell)) = open.pop() {
            if wanted.contains(&cell) {
                return None;
            }
            count += 1;
            if count > MOST {
                return None;
            }
            for k in 0..27 {
                let next = [cell[0] + k % 3 - 1, cell[1] + k / 3 % 3 - 1, cell[2] + k / 9 - 1];
                if seen.insert(next) && self.is_open(next) {
                    open.push((rank(next), next));
                }
            }
        }
        Some(count)
    }
}
