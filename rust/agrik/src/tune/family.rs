//! Families of gains: which numbers of a feedback law a search may change.

use std::sync::Arc;

use nalgebra::{DMatrix, Schur};

use super::SWEEPS;
use crate::error::{Error, Result};
use crate::solve::{Matrix, Step};

/// Which entries of a state space are free.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// All entries of A, B and C.
    Full,
    /// The diagonal of A, and B.
    Diagonal,
    /// B alone; A is zero. As good as a static gain, one step later.
    Input,
}

/// A feedback law to start from and the numbers that are free in it.
#[derive(Debug, Clone)]
pub struct Family {
    template: Step,
    shape: Shape,
    /// Rows of B, or of a gain, that are free: those whose joints move the tool.
    active: Vec<bool>,
    /// Divides entries of C or K so that all parameters are of the order of one.
    unit: f64,
}

fn largest(m: &Matrix) -> f64 {
    m.values.iter().fold(0.0, |largest, x| x.abs().max(largest))
}

impl Family {
    /// The numbers of `template` that `shape` leaves free; rows of B and K only where
    /// `active` says that the joint moves the tool.
    pub fn new(template: Step, shape: Shape, active: Vec<bool>) -> Result<Self> {
        let unit = match &template {
            Step::IkPid(_) => 1.0,
            Step::StateSpace(Some(gains)) => 2.0 * largest(&gains.c),
            Step::StaticGain(Some(gain)) => largest(&gain.gain),
            _ => {
                let expected = "IK-PID, or a state space or static gain with its matrices";
                return Err(Error::argument("solver", expected, template.name()));
            }
        };
        if !(unit.is_finite() && unit > 0.0) {
            let expected = "matrices to start from that are finite and not zero";
            return Err(Error::argument("solver", expected, unit));
        }
        let rows = match &template {
            Step::StateSpace(Some(gains)) if gains.a.columns != active.len() => gains.a.columns,
            Step::StaticGain(Some(gain)) if gain.gain.rows() != active.len() => gain.gain.rows(),
            _ => active.len(),
        };
        if rows != active.len() && shape != Shape::Full {
            let expected = "as many states as joint values for this shape";
            return Err(Error::argument("solver", expected, rows));
        }
        Ok(Self { template, shape, active, unit })
    }

    fn rows<'m>(&'m self, m: &'m Matrix) -> impl Iterator<Item = usize> + 'm {
        let columns = m.columns.max(1);
        (0..m.values.len()).filter(move |i| self.active.get(i / columns).is_some_and(|a| *a))
    }

    /// The template as a vector.
    pub fn start(&self) -> Vec<f64> {
        match &self.template {
            // Relative to the start, so that one deviation serves all three.
            Step::IkPid(_) => vec![1.0; 3],
            Step::StateSpace(Some(gains)) => {
                let n = gains.a.columns;
                let mut x = match self.shape {
                    Shape::Full => gains.a.values.clone(),
                    Shape::Diagonal => (0..n).map(|i| gains.a.values[i * n + i]).collect(),
                    Shape::Input => Vec::new(),
                };
                match self.shape {
                    Shape::Full => {
                        x.extend_from_slice(&gains.b.values);
                        x.extend(gains.c.values.iter().map(|c| c / self.unit));
                    }
                    Shape::Diagonal => x.extend_from_slice(&gains.b.values),
                    Shape::Input => x.extend(self.rows(&gains.b).map(|i| gains.b.values[i])),
                }
                x
            }
            Step::StaticGain(Some(gain)) => {
                self.rows(&gain.gain).map(|i| gain.gain.values[i] / self.unit).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Whether the states of a vector's state space die out once the error is gone: whether
    /// the spectral radius of A is below one. States that no joint listens to may grow
    /// without any goal being missed for it.
    pub fn is_stable(&self, x: &[f64]) -> bool {
        let Step::StateSpace(Some(gains)) = self.step(x) else { return true };
        let a = &gains.a;
        if !a.values.iter().all(|value| value.is_finite()) {
            return false;
        }
        let a = DMatrix::from_row_slice(a.rows(), a.columns, &a.values);
        // One whose eigenvalues are not found does not count as stable.
        Schur::try_new(a, f64::EPSILON, SWEEPS)
            .is_some_and(|found| found.complex_eigenvalues().iter().all(|value| value.norm() < 1.0))
    }

    /// The feedback law of a vector.
    pub fn step(&self, x: &[f64]) -> Step {
        match &self.template {
            Step::IkPid(pid) => {
                let mut pid = *pid;
                let part = |k: usize| x.get(k).map_or(0.0, |x| x.max(0.0));
                pid.proportional *= part(0);
                pid.integral *= part(1);
                pid.derivative *= part(2);
                Step::IkPid(pid)
            }
            Step::StateSpace(Some(gains)) => {
                let mut set = gains.as_ref().clone();
                let n = set.a.columns;
                let mut from = x.iter().copied();
                let mut take = |to: &mut f64| *to = from.next().unwrap_or(0.0);
                match self.shape {
                    Shape::Full => {
                        set.a.values.iter_mut().for_each(&mut take);
                        set.b.values.iter_mut().for_each(&mut take);
                        set.c.values.iter_mut().for_each(&mut take);
                        set.c.values.iter_mut().for_each(|c| *c *= self.unit);
                    }
                    Shape::Diagonal => {
                        set.a.values.fill(0.0);
                        (0..n).for_each(|i| take(&mut set.a.values[i * n + i]));
                        set.b.values.iter_mut().for_each(&mut take);
                    }
                    Shape::Input => {
                        set.a.values.fill(0.0);
                        let free: Vec<usize> = self.rows(&gains.b).collect();
                        set.b.values.fill(0.0);
                        free.into_iter().for_each(|i| take(&mut set.b.values[i]));
                    }
                }
                Step::StateSpace(Some(Arc::new(set)))
            }
            Step::StaticGain(Some(gain)) => {
                let mut set = gain.as_ref().clone();
                let free: Vec<usize> = self.rows(&gain.gain).collect();
                set.gain.values.fill(0.0);
                for (i, x) in free.into_iter().zip(x) {
                    set.gain.values[i] = x * self.unit;
                }
                Step::StaticGain(Some(Arc::new(set)))
            }
            other => other.clone(),
        }
    }
}
