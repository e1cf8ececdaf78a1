//! The posture nearest to a goal: Newton's method within the limits, where attempts in lanes
//! have failed.
//!
//! What is minimised is half the squared error, with its second derivatives for the place of
//! the tool: far from a goal out of reach the error does not shrink, and least squares alone
//! would creep. Joints at a limit that the slope pushes outward stand still for a step
//! (Bertsekas 1982); where a step does not help it is damped more.

use std::cmp::Ordering;

use smallvec::{SmallVec, smallvec};

use crate::call::Measure;
use crate::chain::Compiled;
use crate::kinematics::{PerJoint, Workspace, columns, forward};
use crate::lanes::{cross, dot};
use crate::solve::limit::Limit;
use crate::solve::plan::Plan;
use crate::task::{Goal, Rows};

/// Steps of one search.
const STEPS: u32 = 100;
/// First damping, factor from step to step, least and most, as shares of the squared size.
const DAMPING: f64 = 1e-3;
const FACTOR: f64 = 8.0;
const LEAST: f64 = 1e-9;
const MOST: f64 = 1e6;
/// A slope of the cost below this share of what errors can make, and a decrease below this
/// share of it, is an end.
const FLAT: f64 = 1e-14;
/// What orientations count beside places while the nearest place is looked for; how much less
/// at most so many times where that is too much to come within the tolerance, from errors below
/// this share of the length per radian.
const LITTLE: f64 = 1e-3;
const LESS: f64 = 0.1;
const FINER: u32 = 3;
const NEAR: f64 = 1e-3;
/// A pose that is off by less is nearly right, rad.
const CLOSE: f64 = 0.1;
/// Entries of a matrix that are held without an allocation.
const SQUARE: usize = 64;

/// An end of a search.
#[derive(Debug, Clone, Copy)]
pub(in crate::solve) struct End {
    /// Half the squared error, m^2.
    pub cost: f64,
    pub position_error: f64,
    pub orientation_error: f64,
    /// Within the tolerances.
    pub solved: bool,
    /// Nothing nearer is looked for.
    pub best: bool,
    pub steps: u32,
}

impl End {
    /// Whether the posture is nearer than another one, or as near: first by its place, to within
    /// a share of a length, then by how the tool is turned, to within that angle.
    pub fn compare(&self, other: &Self, same: f64, length: f64) -> Ordering {
        let order = |x: f64, y: f64, same: f64| {
            if x < y - same {
                Ordering::Less
            } else if x > y + same {
                Ordering::Greater
            } else {
                Ordering::Equal
            }
        };
        order(self.position_error, other.position_error, same * length).then(order(
            self.orientation_error,
            other.orientation_error,
            same,
        ))
    }

    /// The tool is off by little, beside a length per radian.
    pub fn is_close(&self, scale: f64) -> bool {
        self.orientation_error < CLOSE && self.position_error < CLOSE * scale
    }

    /// The better answer of the two.
    pub fn is_nearer(&self, other: &Self) -> bool {
        match (self.solved, other.solved) {
            (true, true) => self.orientation_error < other.orientation_error,
            (false, false) => self.cost < other.cost,
            (solved, _) => solved,
        }
    }
}

/// What searches for one row share.
#[derive(Clone, Copy)]
pub(in crate::solve) struct Search<'p> {
    pub plan: &'p Plan<'p>,
    pub limits: &'p [Limit],
    pub goal: Goal<f64>,
    /// Length per radian of orientations, m.
    pub scale: f64,
}

/// Cost, slope and curvature at a posture.
struct Point {
    end: End,
    slope: PerJoint<f64>,
    curvature: SmallVec<[f64; SQUARE]>,
}

impl Search<'_> {
    /// Moves `q` to a least error nearby.
    #[inline(never)]
    pub fn run(&self, q: &mut PerJoint<f64>) -> End {
        let setup = self.plan.setup();
        match setup.aim.measure(self.scale) {
            Measure::Position(rows) => self.descend::<_, 3>(rows, true, q),
            Measure::Pose(rows) => self.descend::<_, 6>(rows, true, q),
            Measure::Axis(rows) => self.descend::<_, 5>(rows, true, q),
            Measure::Framed(rows) => self.descend::<_, 6>(rows, false, q),
        }
    }

    /// Moves `q` to the nearest place nearby, and turns the tool as well as that allows.
    pub fn place_first(&self, q: &mut PerJoint<f64>) -> End {
        let mut search = Self { scale: LITTLE * self.scale, ..*self };
        let mut end = search.run(q);
        // Where the place can be had, the little that orientations count may be too much.
        for _ in 0..FINER {
            let aim = &self.plan.setup().aim;
            if end.solved || !aim.puts_position_first() || end.position_error > self.scale * NEAR {
                break;
            }
            search.scale *= LESS;
            let next = search.run(q);
            end = End { steps: end.steps + next.steps, ..next };
        }
        end
    }

    fn descend<T: Rows<f64, M>, const M: usize>(
        &self,
        rows: T,
        places: bool,
        q: &mut PerJoint<f64>,
    ) -> End {
        let size2 = self.plan.setup().lengths.size2();
        let mut workspace = Workspace::new(self.plan.request.chain().compiled());
        let mut at = self.point::<T, M>(&rows, places, q, &mut workspace);
        let mut damping = DAMPING;
        let mut steps = 0;
        while steps < STEPS && !at.end.best && damping <= MOST {
            steps += 1;
            let free: PerJoint<usize> = (0..q.len())
                .filter(|&i| {
                    let (v, slope) = (&self.limits[i], at.slope[i]);
                    !(q[i] <= v.lower && slope > 0.0 || v.upper <= q[i] && slope < 0.0)
                })
                .collect();
            let weight = |i: usize| if self.limits[i].slides { 1.0 } else { size2 };
            let steep = |i: &usize| at.slope[*i].powi(2) > FLAT * FLAT * at.end.cost * weight(*i);
            if !free.iter().any(steep) {
                break;
            }
            let Some(mut change) = newton(&at, &free, |i| damping * weight(i)) else {
                damping *= FACTOR;
                continue;
            };
            // No joint more than a radian, no slide more than as far as the goal.
            let way = (2.0 * at.end.cost + size2).sqrt();
            let longest = free.iter().zip(&change).fold(1.0_f64, |longest, (&i, d)| {
                longest.max(d.abs() / if self.limits[i].slides { way } else { 1.0 })
            });
            change.iter_mut().for_each(|d| *d /= longest);
            let mut to = q.clone();
            for (&i, d) in free.iter().zip(&change) {
                to[i] = (to[i] + d).max(self.limits[i].lower).min(self.limits[i].upper);
            }
            let next = self.point::<T, M>(&rows, places, &to, &mut workspace);
            let decrease = at.end.cost - next.end.cost;
            if decrease > 0.0 {
                *q = to;
                let over = decrease <= FLAT * at.end.cost && !next.end.best;
                at = next;
                damping = (damping / FACTOR).max(LEAST);
                if over {
                    break;
                }
            } else {
                damping *= FACTOR;
            }
        }
        End { steps, ..at.end }
    }

    fn point<T: Rows<f64, M>, const M: usize>(
        &self,
        rows: &T,
        places: bool,
        q: &[f64],
        workspace: &mut Workspace<f64>,
    ) -> Point {
        let chain = self.plan.request.chain().compiled();
        forward(chain, q, workspace);
        let tool = workspace.tool_point(self.plan.setup().aim.tail().translation);
        let error = rows.error(workspace, tool, &self.goal);
        let dof = q.len();
        let mut jacobian: PerJoint<[f64; M]> = smallvec![[0.0; M]; dof];
        let mut linear: PerJoint<[f64; 3]> = SmallVec::new();
        let seen = rows.look(workspace, tool, &self.goal);
        columns(chain, workspace, tool, |variable, l, a| {
            linear.push(l);
            let column = rows.column(&seen, &self.goal, l, a);
            for (sum, x) in jacobian[variable].iter_mut().zip(column) {
                *sum += x;
            }
        });
        let product = |a: &[f64; M], b: &[f64; M]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let slope = jacobian.iter().map(|column| -product(column, &error.rows)).collect();
        let mut curvature = smallvec![0.0; dof * dof];
        for i in 0..dof {
            for j in 0..dof {
                curvature[i * dof + j] = product(&jacobian[i], &jacobian[j]);
            }
        }
        if places {
            let way = [error.rows[0], error.rows[1], error.rows[2]];
            bend(chain, workspace, &linear, way, &mut curvature);
        }
        let (aim, left) = (&self.plan.setup().aim, error.into());
        let end = End {
            cost: 0.5 * product(&error.rows, &error.rows),
            position_error: error.position2.sqrt(),
            orientation_error: error.orientation2.sqrt(),
            solved: aim.is_met(&left),
            best: aim.is_best(&left),
            steps: 0,
        };
        Point { end, slope, curvature }
    }
}

/// Adds to the curvature what the tool point's paths bend, seen along the way to the goal: a
/// joint that turns also turns the velocities that the joints after it give the tool.
fn bend(
    chain: &Compiled,
    workspace: &Workspace<f64>,
    linear: &[[f64; 3]],
    way: [f64; 3],
    curvature: &mut [f64],
) {
    let joints = chain.links.iter().zip(&workspace.axes).enumerate();
    for (first, (link, axis)) in joints.filter(|(_, (link, _))| !link.prismatic) {
        for (other, velocity) in chain.links[first..].iter().zip(&linear[first..]) {
            let bent = link.multiplier * dot(way, cross(axis.direction, *velocity));
            let (i, j) = (link.variable, other.variable);
            curvature[i * chain.dof + j] -= bent;
            if !std::ptr::eq(link, other) {
                curvature[j * chain.dof + i] -= bent;
            }
        }
    }
}

/// A damped Newton step of the free joints; none where the damped curvature is not positive.
fn newton(at: &Point, free: &[usize], damping: impl Fn(usize) -> f64) -> Option<PerJoint<f64>> {
    let (n, dof) = (free.len(), at.slope.len());
    let mut l: SmallVec<[f64; SQUARE]> = smallvec![0.0; n * n];
    let mut d: PerJoint<f64> = free.iter().map(|&i| -at.slope[i]).collect();
    for j in 0..n {
        let before = |i: usize| {
            at.curvature[free[i] * dof + free[j]]
                - (0..j).map(|k| l[i * n + k] * l[j * n + k]).sum::<f64>()
        };
        let pivot = before(j) + damping(free[j]);
        // A pivot that is no number is none.
        if pivot.is_nan() || pivot <= 1e-2 * damping(free[j]) {
            return None;
        }
        let root = pivot.sqrt();
        let below: PerJoint<f64> = (j + 1..n).map(|i| before(i) / root).collect();
        l[j * n + j] = root;
        for (i, x) in (j + 1..n).zip(below) {
            l[i * n + j] = x;
        }
    }
    for i in 0..n {
        let known: f64 = (0..i).map(|k| l[i * n + k] * d[k]).sum();
        d[i] = (d[i] - known) / l[i * n + i];
    }
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|k| l[k * n + i] * d[k]).sum();
        d[i] = (d[i] - known) / l[i * n + i];
    }
    d.iter().all(|x| x.is_finite()).then_some(d)
}
