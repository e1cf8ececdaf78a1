//! Straight lines of the tool backwards out of a posture.

use agrik::kinematics::{tool_jacobians, tool_poses};
use nalgebra::{Matrix3, Matrix6, Rotation3, SVector, Vector6};

use super::ask::Ask;

/// Longest piece of a line, m: on it the joints go straight.
const PIECE: f64 = 0.02;
/// How far lines go, m; ways to them start from all these places.
pub(super) const STOPS: [f64; 3] = [0.12, 0.24, 0.36];
/// A joint that turns farther than this on a piece goes over to another branch, rad.
const JUMP: f64 = 0.5;
/// What counts as on the line, m and rad, and the most steps to get there.
const CLOSE: f64 = 1e-6;
const STEPS: usize = 8;

/// A line out of a posture: postures along it, the first one that it comes out of, each piece
/// proven free; and which of them are the stops that it got to.
#[derive(Debug, Clone, Default)]
pub(super) struct Line {
    pub q: Vec<Vec<f64>>,
    pub stops: Vec<usize>,
}

/// The line of the tool out of a posture, against the tool's z axis, as far as it is free.
pub(super) fn backwards(ask: &mut Ask<'_>, from: &[f64]) -> Line {
    let chain = ask.collider().bodies().chain().clone();
    let mut pose = [0.0; 16];
    tool_poses(&chain, from, &mut pose);
    let mut line = Line { q: vec![from.to_vec()], stops: Vec::new() };
    let mut way = 0.0;
    for stop in STOPS {
        let pieces = ((stop - way) / PIECE).ceil() as usize;
        for piece in 1..=pieces {
            let at = way + (stop - way) * piece as f64 / pieces as f64;
            let target = [3, 7, 11].map(|k| pose[k] - at * pose[k - 1]);
            let last = &line.q[line.q.len() - 1];
            let Some(next) = follow(ask, last, &pose, target) else { return line };
            let last = last.clone();
            if !ask.free(&last, &next) {
                return line;
            }
            line.q.push(next);
        }
        way = stop;
        line.stops.push(line.q.len() - 1);
    }
    line
}

/// The posture near another one that has the tool at a place, turned as `pose` is.
fn follow(ask: &Ask<'_>, from: &[f64], pose: &[f64; 16], target: [f64; 3]) -> Option<Vec<f64>> {
    let chain = ask.collider().bodies().chain();
    let dof = chain.dof();
    let weights = ask.metric.weights();
    let mut q = from.to_vec();
    let (mut now, mut jacobian) = ([0.0; 16], vec![0.0; 6 * dof]);
    let turned = |m: &[f64; 16]| Matrix3::from_fn(|i, j| m[4 * i + j]);
    let wanted = turned(pose);
    for _ in 0..STEPS {
        tool_poses(chain, &q, &mut now);
        let turn = Rotation3::from_matrix_unchecked(wanted * turned(&now).transpose());
        let rotation = turn.scaled_axis();
        let error = Vector6::new(
            target[0] - now[3],
            target[1] - now[7],
            target[2] - now[11],
            rotation[0],
            rotation[1],
            rotation[2],
        );
        if error.amax() <= CLOSE {
            let jumps = |((a, b), v): ((&f64, &f64), &agrik::chain::Variable)| {
                let turns = v.kind != agrik::chain::JointKind::Prismatic;
                turns && (a - b).abs() > JUMP || *b < v.lower || *b > v.upper
            };
            let out = from.iter().zip(&q).zip(chain.variables()).any(jumps);
            return (!out).then_some(q);
        }
        tool_jacobians(chain, &q, &mut jacobian);
        // The least change in the metric: dq = W^-2 J^T (J W^-2 J^T)^-1 e.
        let column = |j: usize| -> Vector6<f64> { SVector::from_fn(|k, _| jacobian[k * dof + j]) };
        let mut square = Matrix6::<f64>::zeros();
        for (j, weight) in weights.iter().enumerate() {
            let column = column(j);
            square += column * column.transpose() / (weight * weight);
        }
        let damping = 1e-9 * square.trace();
        let inverse = (square + Matrix6::identity() * damping).cholesky()?;
        let force = inverse.solve(&error);
        for (j, (x, weight)) in q.iter_mut().zip(weights).enumerate() {
            *x += column(j).dot(&force) / (weight * weight);
        }
        if !q.iter().all(|x| x.is_finite()) {
            return None;
        }
    }
    None
}
