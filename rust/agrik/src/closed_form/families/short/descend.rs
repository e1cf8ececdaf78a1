//! Steps from a posture to where its error is least, within limits.

use nalgebra::{SMatrix, SVector};

use super::look::Look;
use super::{Room, Short, TURNING, Wish};
use crate::closed_form::geometry::rigid::Rigid;
use crate::lanes::{V3, axpy, dot, norm, scale};

/// Damped steps at most.
const STEPS: usize = 80;
/// Steps with second derivatives at most.
const FINE: usize = 6;
/// Errors below this share of the arm's size are rounding.
const ROUNDING: f64 = 1e-14;
/// Change of a joint by which second derivatives are told, rad.
const DIFFERENCE: f64 = 1e-5;
/// A joint's damping is that of a lever of this share of the longest one at least.
const LIGHT: f64 = 1e-3;
/// A damped step that gains less than this share is one of the last.
const SLOW: f64 = 1e-7;

type Vector = SVector<f64, TURNING>;
type Matrix = SMatrix<f64, TURNING, TURNING>;

/// A posture from which no small step comes nearer.
#[derive(Debug, Clone, Copy)]
pub struct Posture {
    /// Values of the joints that turn, at the places of the last ones.
    pub q: [f64; TURNING],
    /// Value of the slide; 0 without one.
    pub slide: f64,
    /// Distance left, m.
    pub position: f64,
    /// Angle left, rad.
    pub orientation: f64,
    /// Both, orientations by a length per radian, m.
    pub error: f64,
}

/// What a posture's error is made of and how it grows.
struct Slope {
    look: Look<f64>,
    /// Half of the error squared.
    cost: f64,
    gradient: Vector,
}

impl Short {
    /// The posture of least error that steps from a start lead to.
    pub fn descend(&self, goal: &Rigid<f64>, room: &Room, start: &[f64; TURNING]) -> Posture {
        let mut q = Vector::from(*start);
        for k in 0..TURNING {
            let moves = self.moving().contains(&k);
            q[k] = if moves { q[k].clamp(room.lower[k], room.upper[k]) } else { 0.0 };
        }
        let mut here = self.slope(goal, room, &q);
        let mut damping = 1e-3;
        let least = (ROUNDING * self.size).powi(2);
        for _ in 0..STEPS {
            if here.cost <= least {
                break;
            }
            let free = self.free(room, &q, &here.gradient);
            let curvature = self.curvature(&here.look, goal);
            let mut gained = 0.0;
            for _ in 0..12 {
                let step = solved(&curvature, &here.gradient, free, damping, &self.levers);
                let next = moved(&q, &step, room);
                let there = self.slope(goal, room, &next);
                if there.cost < here.cost {
                    gained = 1.0 - there.cost / here.cost;
                    (q, here) = (next, there);
                    damping = (damping * 0.2).max(1e-14);
                    break;
                }
                damping *= 8.0;
            }
            if gained < SLOW {
                break;
            }
        }
        if here.cost > least {
            self.finish(goal, room, &mut q, &mut here);
        }
        let (position, orientation) = (norm(here.look.way), norm(here.look.turn));
        let error = position.hypot(self.per_radian * orientation);
        Posture { q: q.into(), slide: here.look.slide, position, orientation, error }
    }

    /// Newton's steps with true second derivatives: damped ones only creep towards an error that
    /// stays large.
    fn finish(&self, goal: &Rigid<f64>, room: &Room, q: &mut Vector, here: &mut Slope) {
        for _ in 0..FINE {
            let free = self.free(room, q, &here.gradient);
            let mut second = Matrix::zeros();
            for k in (0..TURNING).filter(|k| free[*k]) {
                let mut sides = [Vector::zeros(); 2];
                for (side, way) in sides.iter_mut().zip([1.0, -1.0]) {
                    let mut there = *q;
                    there[k] += way * DIFFERENCE;
                    *side = self.slope(goal, room, &there).gradient;
                }
                second.set_column(k, &((sides[0] - sides[1]) / (2.0 * DIFFERENCE)));
            }
            let second = 0.5 * (second + second.transpose());
            let step = solved(&second, &here.gradient, free, 0.0, &self.levers);
            let next = moved(q, &step, room);
            let there = self.slope(goal, room, &next);
            let steepness = |slope: &Slope, free: [bool; TURNING]| -> f64 {
                let all = slope.gradient.iter().zip(free).filter(|(_, free)| *free);
                all.map(|(x, _)| x * x).sum()
            };
            let flatter = steepness(&there, free) < 0.25 * steepness(here, free);
            if !flatter || there.cost > here.cost * (1.0 + 1e-12) {
                break;
            }
            (*q, *here) = (next, there);
        }
    }

    fn slope(&self, goal: &Rigid<f64>, room: &Room, q: &Vector) -> Slope {
        let look = self.look(&(*q).into(), goal, room.slide);
        let per_radian2 = self.per_radian * self.per_radian;
        let cost = 0.5 * (dot(look.way, look.way) + per_radian2 * dot(look.turn, look.turn));
        let each = |k| -dot(look.way, look.ways[k]) - per_radian2 * dot(look.turn, look.axes[k]);
        let gradient =
            Vector::from_fn(|k, _| if self.moving().contains(&k) { each(k) } else { 0.0 });
        Slope { look, cost, gradient }
    }

    /// Joints that are not held at a limit.
    fn free(&self, room: &Room, q: &Vector, gradient: &Vector) -> [bool; TURNING] {
        std::array::from_fn(|k| {
            let held = gradient[k] > 0.0 && q[k] <= room.lower[k]
                || gradient[k] < 0.0 && q[k] >= room.upper[k];
            self.moving().contains(&k) && !held && room.lower[k] < room.upper[k]
        })
    }

    /// How a joint moves the tool as far as it counts: way, m, and turn times the length of a
    /// radian.
    fn column(&self, look: &Look<f64>, goal: &Rigid<f64>, k: usize) -> [V3<f64>; 2] {
        let mut way = look.ways[k];
        if let (Some(along), true) = (self.slide, look.slides) {
            way = axpy(along, -dot(along, way) / dot(along, along), way);
        }
        let mut turn = look.axes[k];
        if self.wish == Wish::Axis {
            // About the axis nothing is asked.
            let axis = if dot(look.axis, goal.axes[2]) < 0.0 { goal.axes[2] } else { look.axis };
            turn = axpy(axis, -dot(axis, turn), turn);
        }
        [way, scale(turn, self.per_radian)]
    }

    /// Products of the joints' columns.
    fn curvature(&self, look: &Look<f64>, goal: &Rigid<f64>) -> Matrix {
        let columns: [_; TURNING] = std::array::from_fn(|k| self.column(look, goal, k));
        Matrix::from_fn(|i, j| {
            let ([a, b], [c, d]) = (columns[i], columns[j]);
            dot(a, c) + dot(b, d)
        })
    }

    /// What turns of the joints, times their levers, are least worth at a posture (1: all of the
    /// way that they could go), and the direction of it, rad; joints that room holds aside.
    pub fn weakest(
        &self,
        goal: &Rigid<f64>,
        room: &Room,
        q: &[f64; TURNING],
    ) -> (f64, [f64; TURNING]) {
        let look = self.look(q, goal, room.slide);
        let moves = |k: &usize| self.moving().contains(k) && room.lower[*k] < room.upper[*k];
        let held: Vec<usize> = (0..TURNING).filter(|k| !moves(k)).collect();
        let products = self.curvature(&look, goal);
        let mut all = Matrix::from_fn(|i, j| products[(i, j)] / (self.levers[i] * self.levers[j]));
        for k in held {
            all.row_mut(k).fill(0.0);
            all.column_mut(k).fill(0.0);
            // No weaker than any other.
            all[(k, k)] = 1.0;
        }
        let values = all.symmetric_eigen();
        let least = values.eigenvalues.imin();
        let along = values.eigenvectors.column(least);
        let way = std::array::from_fn(|k| along[k] / self.levers[k]);
        (values.eigenvalues[least].max(0.0).sqrt(), way)
    }
}

/// The step down a slope, of the joints that are free.
fn solved(
    curvature: &Matrix,
    gradient: &Vector,
    free: [bool; TURNING],
    damping: f64,
    levers: &[f64; TURNING],
) -> Vector {
    let (mut left, mut right) = (Matrix::identity(), Vector::zeros());
    // What hardly moves anything is not to be turned for nothing but rounding.
    let least = LIGHT * levers.iter().fold(0.0, |most: f64, x| most.max(*x));
    for i in (0..TURNING).filter(|i| free[*i]) {
        right[i] = -gradient[i];
        for j in (0..TURNING).filter(|j| free[*j]) {
            left[(i, j)] = curvature[(i, j)];
        }
        left[(i, i)] += damping * levers[i].max(least).powi(2);
    }
    left.lu().solve(&right).unwrap_or_else(Vector::zeros)
}

/// Joint values after a step, held within the limits; no joint turns by more than a radian.
fn moved(q: &Vector, step: &Vector, room: &Room) -> Vector {
    let shorter = 1.0 / step.amax().max(1.0);
    Vector::from_fn(|k, _| (q[k] + shorter * step[k]).clamp(room.lower[k], room.upper[k]))
}
