//! Differential inverse kinematics: joint rates that move the tool by a twist, between bounds.
//!
//! Of the rates between the bounds those with the least squared error of the twist, and of these,
//! by a weight too small to cost the twist anything, those nearest to what a second aim wants: a
//! small convex problem with a strict minimum, which an active set finds. Near singularities the
//! weight grows (Nakamura and Hanafusa 1986), so that the rates stay small there.

use nalgebra::{DMatrix, DVector};

use crate::call::{Merit, Second};
use crate::chain::Chain;
use crate::error::{Error, Result};
use crate::kinematics::{Workspace, columns, forward};
use crate::threads::share;

/// Weight of the second aim, and the most that it grows to at a singularity, by the squared size.
const LITTLE: f64 = 1e-9;
const DAMPED: f64 = 1e-3;
/// Singular values below this share of the size are near a singularity.
const NEAR: f64 = 0.03;
/// Step of the difference by which the slope of the manipulability is had, rad.
const SMALL: f64 = 1e-6;
/// Rows that a thread takes at a time.
const RUN: usize = 64;

/// A batch of twists.
#[derive(Debug, Clone, Copy)]
pub struct Twists<'a> {
    /// The chain.
    pub chain: &'a Chain,
    /// Joint values, `dof` a row.
    pub q: &'a [f64],
    /// Velocity of the tool point, m/s, and of the tool, rad/s, base frame.
    pub twists: &'a [[f64; 6]],
    /// The turn counts too.
    pub turns: bool,
    /// Least and most rate of each joint, `dof` a row, rad/s or m/s.
    pub least: &'a [f64],
    /// Most rates.
    pub most: &'a [f64],
    /// What the freedom is used for, and how quickly, 1/s.
    pub second: Option<(&'a Second, f64)>,
}

impl Twists<'_> {
    /// Joint rates, `dof` a row, on `threads` threads; zeros for rows that hold no numbers.
    pub fn rates(&self, threads: usize, poll: &mut dyn FnMut() -> bool) -> Result<Vec<f64>> {
        let (dof, rows) = (self.chain.dof(), self.twists.len());
        for (name, got) in
            [("q", self.q.len()), ("least", self.least.len()), ("most", self.most.len())]
        {
            if got != rows * dof {
                return Err(Error::argument(name, format!("{} numbers", rows * dof), got));
            }
        }
        let mut rates = vec![0.0; rows * dof];
        let runs = rates.chunks_mut(RUN * dof).enumerate().collect();
        let work = |(run, rates): (usize, &mut [f64])| {
            let mut workspace = Workspace::new(self.chain.compiled());
            for (i, rates) in rates.chunks_exact_mut(dof).enumerate() {
                self.row(run * RUN + i, &mut workspace, rates);
            }
        };
        if share(runs, threads, &work, poll) { Ok(rates) } else { Err(Error::Interrupted) }
    }

    fn row(&self, row: usize, workspace: &mut Workspace<f64>, rates: &mut [f64]) {
        let dof = self.chain.dof();
        let all = row * dof..(row + 1) * dof;
        let (q, twist) = (&self.q[all.clone()], &self.twists[row]);
        let (least, most) = (&self.least[all.clone()], &self.most[all]);
        let numbers = q.iter().chain(twist).chain(least).chain(most);
        if numbers.clone().any(|x| !x.is_finite()) {
            return;
        }
        let size = self.chain.reach().size.max(f64::MIN_POSITIVE);
        let jacobian = self.jacobian(q, size, workspace);
        let rows = jacobian.nrows();
        let wanted = DVector::from_fn(rows, |r, _| twist[r] * if r < 3 { 1.0 } else { size });
        // A slide counts by the size of the robot beside a radian.
        let least_value = smallest(&jacobian, rows.min(dof));
        let near = (1.0 - (least_value / (NEAR * size)).powi(2)).max(0.0);
        let weight = (LITTLE + DAMPED * near * near) * size * size;
        let aim = self.aim(q, size, workspace);
        let mut square = jacobian.transpose() * &jacobian;
        let mut slope = jacobian.transpose() * wanted;
        for i in 0..dof {
            square[(i, i)] += weight;
            // Damping draws to rest, and only the little weight to the second aim.
            slope[i] += LITTLE * size * size * aim[i];
        }
        let x = between(&square, &slope, least, most);
        for (rate, x) in rates.iter_mut().zip(x) {
            *rate = if x.is_finite() { x } else { 0.0 };
        }
    }

    fn jacobian(&self, q: &[f64], size: f64, workspace: &mut Workspace<f64>) -> DMatrix<f64> {
        let chain = self.chain.compiled();
        forward(chain, q, workspace);
        let tool = workspace.tool_point(chain.tail.translation);
        let rows = if self.turns { 6 } else { 3 };
        let mut jacobian = DMatrix::zeros(rows, q.len());
        columns(chain, workspace, tool, |variable, linear, angular| {
            let turn = angular.map(|x| x * size);
            for (r, x) in linear.into_iter().chain(turn).take(rows).enumerate() {
                jacobian[(r, variable)] += x;
            }
        });
        jacobian
    }

    /// The rates that the second aim wants.
    fn aim(&self, q: &[f64], size: f64, workspace: &mut Workspace<f64>) -> Vec<f64> {
        let Some((second, gain)) = self.second else { return vec![0.0; q.len()] };
        let middle = |i: usize| self.chain.variables()[i].middle();
        if second.merit() != Merit::Manipulability {
            let about = |i: usize| second.posture().map_or_else(|| middle(i), |p| p[i]);
            return (0..q.len()).map(|i| -gain * second.bends(i, q[i], about(i)).slope).collect();
        }
        let mut dexterity = |q: &[f64]| {
            let jacobian = self.jacobian(q, size, workspace) / size;
            let square: DMatrix<f64> = &jacobian * jacobian.transpose();
            0.5 * square.determinant().max(f64::MIN_POSITIVE).ln()
        };
        let mut at = q.to_vec();
        let mut slope = |i: usize| {
            let mut beside = |by: f64| {
                at[i] = q[i] + by;
                dexterity(&at)
            };
            let slope = (beside(SMALL) - beside(-SMALL)) / (2.0 * SMALL);
            at[i] = q[i];
            gain * slope
        };
        (0..q.len()).map(&mut slope).collect()
    }
}

/// The smallest of the `count` largest singular values.
fn smallest(jacobian: &DMatrix<f64>, count: usize) -> f64 {
    let square = jacobian * jacobian.transpose();
    let mut values: Vec<f64> = square.symmetric_eigenvalues().iter().copied().collect();
    values.sort_by(|a, b| b.total_cmp(a));
    values.get(count - 1).map_or(0.0, |x| x.max(0.0).sqrt())
}

/// The least of `x . A x / 2 - b . x` between bounds, `A` positive definite: joints are held at a
/// bound that they come to, and one of them is let go where the rest is at its best (the bounded
/// least squares of Stark and Parker 1995).
fn between(a: &DMatrix<f64>, b: &DVector<f64>, least: &[f64], most: &[f64]) -> Vec<f64> {
    let n = b.len();
    let mut x = DVector::from_fn(n, |i, _| 0.0f64.max(least[i]).min(most[i]));
    let mut held = vec![false; n];
    let flat = 1e-12 * (1.0 + b.amax());
    for _ in 0..16 * n {
        let slope = a * &x - b;
        let free: Vec<usize> = (0..n).filter(|i| !held[*i]).collect();
        let part = DMatrix::from_fn(free.len(), free.len(), |i, j| a[(free[i], free[j])]);
        let down = DVector::from_fn(free.len(), |i, _| -slope[free[i]]);
        let Some(factors) = part.cholesky() else { break };
        let step = factors.solve(&down);
        // As far as the first bound on the way.
        let mut share = 1.0;
        let mut stops = None;
        for (k, &i) in free.iter().enumerate() {
            let end = if step[k] > 0.0 { most[i] } else { least[i] };
            if step[k] != 0.0 && (end - x[i]) / step[k] < share {
                share = ((end - x[i]) / step[k]).max(0.0);
                stops = Some((i, end));
            }
        }
        for (k, &i) in free.iter().enumerate() {
            x[i] = (x[i] + share * step[k]).max(least[i]).min(most[i]);
        }
        if let Some((i, end)) = stops {
            (x[i], held[i]) = (end, true);
            continue;
        }
        let slope = a * &x - b;
        let inward = |i: usize| if x[i] <= least[i] { -slope[i] } else { slope[i] };
        let steepest = (0..n).filter(|i| held[*i]).max_by(|i, k| inward(*i).total_cmp(&inward(*k)));
        match steepest {
            Some(i) if inward(i) > flat => held[i] = false,
            _ => break,
        }
    }
    x.iter().copied().collect()
}
