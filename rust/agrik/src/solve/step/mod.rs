//! Steps: from an error and a Jacobian to a change of the joint values.

mod damped;
mod pseudo_inverse;
mod transpose;

use crate::error::{Error, Result};
use crate::lanes::Real;

/// How a step is computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// `alpha J^T e` with the length that minimises the linear error (Buss 2004).
    Transpose,
    /// `J^+ e`, singular values below `cutoff` times the largest left out.
    PseudoInverse {
        /// Relative cutoff of singular values, in (0, 1).
        cutoff: f64,
    },
    /// `J^T (J J^T + damping^2)^-1 e` (Nakamura and Hanafusa 1986, Wampler 1986).
    Damped {
        /// Damping, m.
        damping: f64,
    },
    /// Damped by a share of the squared error, which vanishes at the solution
    /// (Levenberg-Marquardt as in Sugihara 2011).
    LevenbergMarquardt {
        /// Share of half the squared error that is added to the diagonal.
        damping: f64,
    },
}

/// A step rule and the caps of the loop around it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// How a step is computed.
    pub step: Step,
    /// Steps of one attempt before it is given up.
    pub max_iterations: u32,
    /// Attempts after the first before the target is given up.
    pub max_restarts: u32,
    /// Longest change of one joint in one step, rad or m.
    pub max_step: f64,
}

impl Settings {
    /// Levenberg-Marquardt, the default solver.
    pub const LEVENBERG_MARQUARDT: Self = Self {
        step: Step::LevenbergMarquardt { damping: 0.1 },
        max_iterations: 10,
        max_restarts: 100,
        max_step: 1.0,
    };
    /// Damped least squares.
    pub const DAMPED: Self = Self {
        step: Step::Damped { damping: 0.01 },
        max_iterations: 60,
        max_restarts: 100,
        max_step: 1.0,
    };
    /// Pseudo-inverse.
    pub const PSEUDO_INVERSE: Self = Self {
        step: Step::PseudoInverse { cutoff: 1e-3 },
        max_iterations: 60,
        max_restarts: 100,
        max_step: 1.0,
    };
    /// Jacobian transpose.
    pub const TRANSPOSE: Self =
        Self { step: Step::Transpose, max_iterations: 2000, max_restarts: 20, max_step: 1.0 };

    /// Refuses numbers outside their ranges.
    pub fn check(&self) -> Result<()> {
        let (name, value, ok) = match self.step {
            Step::Transpose => ("step", 0.0, true),
            Step::PseudoInverse { cutoff } => ("cutoff", cutoff, cutoff > 0.0 && cutoff < 1.0),
            Step::Damped { damping } | Step::LevenbergMarquardt { damping } => {
                ("damping", damping, damping > 0.0 && damping.is_finite())
            }
        };
        if !ok {
            return Err(Error::argument(name, "a number in its range (see the solver)", value));
        }
        if self.max_iterations == 0 {
            return Err(Error::argument("max_iterations", "at least 1", 0));
        }
        if !(self.max_step > 0.0 && self.max_step.is_finite()) {
            return Err(Error::argument("max_step", "a finite number above 0", self.max_step));
        }
        Ok(())
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self::LEVENBERG_MARQUARDT
    }
}

impl Step {
    /// A step that moves the tool by less than this share of the error leads nowhere: what
    /// would help is held at its limits. Steps down the gradient are short by nature.
    #[inline(always)]
    pub(super) fn stall(&self) -> f64 {
        match self {
            Self::Transpose => 1e-9,
            Self::PseudoInverse { .. } | Self::Damped { .. } => 3e-3,
            Self::LevenbergMarquardt { .. } => 0.1,
        }
    }

    /// The change of the joint values. Columns of joints that are held are zero; so is
    /// their change. `columns` are those of the Jacobian, in the task's rows.
    #[inline(always)]
    pub fn compute<R: Real, const M: usize>(
        &self,
        columns: &[[R; M]],
        error: &[R; M],
        change: &mut [R],
    ) {
        match *self {
            Self::Transpose => transpose::step(columns, error, change),
            Self::PseudoInverse { cutoff } => pseudo_inverse::step(columns, error, cutoff, change),
            Self::Damped { damping } => {
                damped::step(columns, error, R::splat(damping * damping), change);
            }
            Self::LevenbergMarquardt { damping } => {
                let squared = squared_norm(error);
                let added = squared.mul_add(R::splat(0.5 * damping), R::splat(1e-12));
                damped::step(columns, error, added, change);
            }
        }
    }
}

/// `v . v`
#[inline(always)]
pub(super) fn squared_norm<R: Real, const M: usize>(v: &[R; M]) -> R {
    let mut sum = v[0] * v[0];
    for x in &v[1..] {
        sum = x.mul_add(*x, sum);
    }
    sum
}

/// `column . v`
#[inline(always)]
pub(super) fn dot<R: Real, const M: usize>(column: &[R; M], v: &[R; M]) -> R {
    let mut sum = column[0] * v[0];
    for k in 1..M {
        sum = column[k].mul_add(v[k], sum);
    }
    sum
}

/// Lower triangle of `J J^T`.
#[inline(always)]
fn gram<R: Real, const M: usize>(columns: &[[R; M]]) -> [[R; M]; M] {
    let mut a = [[R::zero(); M]; M];
    for c in columns {
        for i in 0..M {
            for k in 0..=i {
                a[i][k] = c[i].mul_add(c[k], a[i][k]);
            }
        }
    }
    a
}
