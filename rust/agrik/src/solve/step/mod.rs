//! Steps: from an error and a Jacobian to a change of the joint values.

mod damped;
mod gains;
mod lengths;
mod normal_equations;
mod pace;
mod pseudo_inverse;
pub(super) mod pulled;
mod transpose;

use std::sync::Arc;

use smallvec::SmallVec;

use crate::error::Result;
use crate::lanes::Real;
use crate::{Allowed, Field};

pub(super) use gains::{Feedback, Sparse, middle};
pub use gains::{GainUnits, Matrix, Pid, PidOrder, StateSpace, StaticGain, frozen_gain};
pub use lengths::Lengths;
pub use pace::Pace;

/// Whole numbers of which there must be one.
const COUNT: Allowed = Allowed::whole(1, u32::MAX);

/// How a step is computed.
///
/// The first five work with the Jacobian of the present posture; the others are feedback
/// laws that look at the error alone and may remember something from step to step.
#[derive(Debug, Clone, PartialEq)]
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
    /// `J^T (J J^T)^-1 e`, with no step where `J J^T` is singular.
    ClosedPseudoInverse,
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
    /// One joint after the other, tip first, to where it brings the tool point nearest
    /// within its limits. Positions only.
    CyclicCoordinateDescent,
    /// One joint after the other, by a PID law of the error's length.
    IkPid(Pid),
    /// A linear discrete-time system from the error to the change. Without gains: the
    /// frozen pseudo-inverse of the posture in the middle of the limits.
    StateSpace(Option<Arc<StateSpace>>),
    /// A constant matrix from the error to the change; without one, as for a state space.
    StaticGain(Option<Arc<StaticGain>>),
    /// A matrix as for a static gain that learns from what each step did (Broyden's
    /// second update).
    Broyden {
        /// The first matrix.
        gain: Option<Arc<StaticGain>>,
        /// Steps without improvement after which the first matrix is taken again.
        patience: u32,
    },
}

/// Where the first attempt starts if the caller gives no start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum StartRule {
    /// A sampled posture.
    #[default]
    Sampled,
    /// All joint values zero, clamped into the limits.
    Zero,
    /// The middle of the limits; zero for continuous joints.
    Middle,
}

/// A step rule and the caps of the loop around it.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// How a step is computed.
    pub step: Step,
    /// Steps of one attempt before it is given up.
    pub max_iterations: u32,
    /// Attempts after the first before the target is given up.
    pub max_restarts: u32,
    /// Longest change of one joint in one step, rad; of a slide, in sizes of the robot or
    /// distances from the goal, whichever is more (m for plain methods). Feedback laws take
    /// full steps.
    pub max_step: f64,
    /// As textbooks have it: full use of `max_step`, then limits by saturation alone, no
    /// extra steps for slow convergence, and stalled attempts reported as such.
    pub plain: bool,
    /// Where the first attempt starts if the caller gives no start.
    pub start: StartRule,
    /// The part of the error that one step is to remove.
    pub pace: Pace,
}

impl Settings {
    /// All step solvers by their names, with their defaults.
    pub const KNOWN: [(&str, Self); 10] = [
        ("lm", Self::LEVENBERG_MARQUARDT),
        ("dls", Self::DAMPED),
        ("pinv", Self::PSEUDO_INVERSE),
        ("pinv-closed", Self::CLOSED_PSEUDO_INVERSE),
        ("transpose", Self::TRANSPOSE),
        ("ccd", Self::DESCENT),
        ("ik-pid", Self::IK_PID),
        ("state-space", Self::STATE_SPACE),
        ("static-gain", Self::STATIC_GAIN),
        ("broyden", Self::BROYDEN),
    ];

    /// Levenberg-Marquardt, the default solver.
    pub const LEVENBERG_MARQUARDT: Self = Self {
        step: Step::LevenbergMarquardt { damping: 0.1 },
        max_iterations: 10,
        max_restarts: 1500,
        max_step: 1.0,
        plain: false,
        start: StartRule::Sampled,
        pace: Pace::Full,
    };
    /// Damped least squares.
    pub const DAMPED: Self = Self {
        step: Step::Damped { damping: 0.01 },
        max_iterations: 60,
        max_restarts: 100,
        max_step: 1.0,
        plain: false,
        start: StartRule::Sampled,
        pace: Pace::Full,
    };
    /// Pseudo-inverse.
    pub const PSEUDO_INVERSE: Self = Self {
        step: Step::PseudoInverse { cutoff: 1e-3 },
        max_iterations: 60,
        max_restarts: 100,
        max_step: 1.0,
        plain: false,
        start: StartRule::Sampled,
        pace: Pace::Full,
    };
    /// Pseudo-inverse in closed form.
    pub const CLOSED_PSEUDO_INVERSE: Self = Self {
        step: Step::ClosedPseudoInverse,
        max_iterations: 60,
        max_restarts: 100,
        max_step: 1.0,
        plain: false,
        start: StartRule::Sampled,
        pace: Pace::Full,
    };
    /// Jacobian transpose.
    pub const TRANSPOSE: Self = Self {
        step: Step::Transpose,
        max_iterations: 2000,
        max_restarts: 20,
        max_step: 1.0,
        plain: false,
        start: StartRule::Sampled,
        pace: Pace::Full,
    };

    /// Cyclic coordinate descent.
    pub const DESCENT: Self = Self {
        step: Step::CyclicCoordinateDescent,
        max_iterations: 500,
        max_restarts: 20,
        max_step: 1.0,
        plain: true,
        start: StartRule::Sampled,
        pace: Pace::Full,
    };
    /// IK-PID with the published gains but the integral one.
    pub const IK_PID: Self = Self {
        step: Step::IkPid(Pid::FINE),
        max_iterations: 1000,
        max_restarts: 20,
        max_step: 1.0,
        plain: true,
        start: StartRule::Sampled,
        pace: Pace::Full,
    };
    /// State space with a frozen pseudo-inverse.
    pub const STATE_SPACE: Self = Self {
        step: Step::StateSpace(None),
        max_iterations: 400,
        max_restarts: 20,
        max_step: 1.0,
        plain: true,
        start: StartRule::Sampled,
        pace: Pace::Full,
    };
    /// Static gain: a frozen pseudo-inverse.
    pub const STATIC_GAIN: Self = Self {
        step: Step::StaticGain(None),
        max_iterations: 400,
        max_restarts: 20,
        max_step: 1.0,
        plain: true,
        start: StartRule::Sampled,
        pace: Pace::Full,
    };
    /// Broyden's update of a frozen pseudo-inverse.
    pub const BROYDEN: Self = Self {
        step: Step::Broyden { gain: None, patience: 8 },
        max_iterations: 100,
        max_restarts: 100,
        max_step: 1.0,
        plain: true,
        start: StartRule::Sampled,
        pace: Pace::Full,
    };

    /// The numbers that users choose; gains of feedback laws are read and checked for
    /// themselves.
    pub fn fields(&mut self) -> SmallVec<[Field<'_>; 4]> {
        let mut fields = SmallVec::new();
        let mut has_max_step = true;
        match &mut self.step {
            Step::PseudoInverse { cutoff } => {
                fields.push(Field::real("cutoff", cutoff, Allowed::below(1.0)));
            }
            Step::FixedTranspose { alpha } => {
                fields.push(Field::real("alpha", alpha, Allowed::POSITIVE));
            }
            Step::Damped { damping } => {
                fields.push(Field::real("damping", damping, Allowed::POSITIVE.of("m")));
            }
            Step::LevenbergMarquardt { damping } => {
                fields.push(Field::real("damping", damping, Allowed::POSITIVE));
            }
            Step::Transpose | Step::ClosedPseudoInverse => {}
            Step::Broyden { patience, .. } => {
                has_max_step = false;
                fields.push(Field::count("patience", patience, COUNT));
            }
            Step::CyclicCoordinateDescent
            | Step::IkPid(_)
            | Step::StateSpace(_)
            | Step::StaticGain(_) => has_max_step = false,
        }
        fields.push(Field::count("max_iterations", &mut self.max_iterations, COUNT));
        fields.push(Field::count("max_restarts", &mut self.max_restarts, Allowed::COUNT));
        if has_max_step {
            let allowed = Allowed::POSITIVE.of("rad or m");
            fields.push(Field::real("max_step", &mut self.max_step, allowed));
        }
        fields
    }

    /// Refuses numbers that are not allowed. Matrices are checked against the chain when a
    /// plan is made.
    pub fn check(&self) -> Result<()> {
        if let Step::IkPid(pid) = &self.step {
            pid.check()?;
        }
        self.pace.check()?;
        self.clone().fields().iter().try_for_each(Field::check)
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
        lengths: &Lengths,
        change: &mut [R],
    ) {
        self.step.compute(columns, error, lengths, change);
        self.pace.apply(error, change);
    }
}

impl Step {
    /// The name by which users choose the step.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Transpose | Self::FixedTranspose { .. } => "transpose",
            Self::PseudoInverse { .. } => "pinv",
            Self::Damped { .. } => "dls",
            Self::LevenbergMarquardt { .. } => "lm",
            Self::ClosedPseudoInverse => "pinv-closed",
            Self::CyclicCoordinateDescent => "ccd",
            Self::IkPid(_) => "ik-pid",
            Self::StateSpace(_) => "state-space",
            Self::StaticGain(_) => "static-gain",
            Self::Broyden { .. } => "broyden",
        }
    }

    /// A step that moves the tool by less than this share of the error leads nowhere: what
    /// would help is held at its limits. Steps down the gradient are short by nature.
    #[inline(always)]
    pub(super) fn stall(&self) -> f64 {
        match self {
            Self::Transpose => 1e-9,
            Self::LevenbergMarquardt { .. } => 0.1,
            _ => 3e-3,
        }
    }

    /// A feedback law.
    pub(crate) fn is_feedback(&self) -> bool {
        matches!(
            self,
            Self::CyclicCoordinateDescent
                | Self::IkPid(_)
                | Self::StateSpace(_)
                | Self::StaticGain(_)
                | Self::Broyden { .. }
        )
    }

    /// The change of the joint values. Columns of joints that are held are zero; so is
    /// their change. `columns` are those of the Jacobian, in the task's rows.
    #[inline(always)]
    pub fn compute<R: Real, const M: usize>(
        &self,
        columns: &[[R; M]],
        error: &[R; M],
        lengths: &Lengths,
        change: &mut [R],
    ) {
        match *self {
            Self::ClosedPseudoInverse => normal_equations::step(columns, error, change),
            Self::Transpose => transpose::step(columns, error, change),
            Self::FixedTranspose { alpha } => transpose::fixed_step(columns, error, alpha, change),
            Self::PseudoInverse { cutoff } => pseudo_inverse::step(columns, error, cutoff, change),
            Self::Damped { damping } => {
                let added = R::splat(damping * damping);
                damped::step(columns, error, added, lengths.pivot(), change);
            }
            Self::LevenbergMarquardt { damping } => {
                let added = lengths.added(squared_norm(error), damping);
                damped::step(columns, error, added, lengths.pivot(), change);
            }
            // Feedback laws have no use for a Jacobian and never come here.
            Self::CyclicCoordinateDescent
            | Self::IkPid(_)
            | Self::StateSpace(_)
            | Self::StaticGain(_)
            | Self::Broyden { .. } => {}
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
///
/// In two passes over the columns: the sums of all rows at once would not fit the registers.
#[inline(always)]
pub(super) fn gram<R: Real, const M: usize>(columns: &[[R; M]]) -> [[R; M]; M] {
    let mut a = [[R::zero(); M]; M];
    let half = M.min(4);
    for c in columns {
        for i in 0..half {
            for k in 0..=i {
                a[i][k] = c[i].mul_add(c[k], a[i][k]);
            }
        }
    }
    for c in columns {
        for i in half..M {
            for k in 0..=i {
                a[i][k] = c[i].mul_add(c[k], a[i][k]);
            }
        }
    }
    a
}
