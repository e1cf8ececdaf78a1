//! Steps: from an error and a Jacobian to a change of the joint values.

mod damped;
mod pace;
mod pseudo_inverse;
mod transpose;

use crate::error::{Error, Result};
use crate::lanes::Real;

pub use pace::Pace;

/// How a step is computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// `alpha J^T e` with the length that minimises the linear error (Buss 2004).
    Transpose,
    /// `alpha J^T e` with the same `alpha` everywhere; converges for `alpha` below 2 over
    /// the largest eigenvalue of `J J^T`.
    FixedTranspose {
        /// Step length, rad or m per m^2 of the product.
        alpha: f64,
    },
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
    /// The part of the error that one step is to remove.
    pub pace: Pace,
}

impl Settings {
    /// Levenberg-Marquardt, the default solver.
    pub const LEVENBERG_MARQUARDT: Self = Self {
        step: Step::LevenbergMarquardt { damping: 0.1 },
        max_iterations: 10,
        max_restarts: 100,
        max_step: 1.0,
        pace: Pace::Full,
    };
    /// Damped least squares.
    pub const DAMPED: Self = Self {
        step: Step::Damped { damping: 0.01 },
        max_iterations: 60,
        max_restarts: 100,
        max_step: 1.0,
        pace: Pace::Full,
    };
    /// Pseudo-inverse.
    pub const PSEUDO_INVERSE: Self = Self {
        step: Step::PseudoInverse { cutoff: 1e-3 },
        max_iterations: 60,
        max_restarts: 100,
        max_step: 1.0,
        pace: Pace::Full,
    };
    /// Jacobian transpose.
    pub const TRANSPOSE: Self = Self {
        step: Step::Transpose,
        max_iterations: 2000,
        max_restarts: 20,
        max_step: 1.0,
        pace: Pace::Full,
    };

    /// Refuses numbers outside their ranges.
    pub fn check(&self) -> Result<()> {
        let (name, value, ok) = match self.step {
            Step::Transpose => ("step", 0.0, true),
            Step::FixedTranspose { alpha } => ("alpha", alpha, alpha > 0.0 && alpha.is_finite()),
            Step::PseudoInverse { cutoff } => ("cutoff", cutoff, cutoff > 0.0 && cutoff < 1.0),
            Step::Damped { damping } | Step::LevenbergMarquardt { damping } => {
                ("damping", damping, damping > 0.0 && damping.is_finite())
            }
        };
        if !ok {
            return Err(Error::argument(name, "a number in its range (see the solver)", value));
        }
        self.pace.check()?;
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

impl Settings {
    /// The change of the joint values for the part of the error that is wanted.
    #[inline(always)]
    pub(super) fn change<R: Real, const M: usize>(
        &self,
        columns: &[[R; M]],
        error: &[R; M],
        change: &mut [R],
    ) {
        self.step.compute(columns, error, change);
        self.pace.apply(error, change);
    }
}

impl Step {
    /// The change of the joint values. Columns of joints that are held are zero; so is
    /// their change.
    #[inline(always)]
    fn compute<R: Real, const M: usize>(
        &self,
        columns: &[[R; M]],
        error: &[R; M],
        change: &mut [R],
    ) {
        match *self {
            Self::Transpose => transpose::step(columns, error, change),
            Self::FixedTranspose { alpha } => transpose::fixed_step(columns, error, alpha, change),
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
