//! The lengths by which steps are damped and ways of slides measured, so that the unit of
//! length is of no account.

use crate::lanes::Real;

/// What is added to the diagonal of `J J^T` in any case, as a share of the squared size.
const LEAST: f64 = 1e-12;
/// Least pivot of an elimination, as a share of the squared size.
const PIVOT: f64 = 1e-14;
/// A robot with slides may have to go many times its own size, which its slides do in one
/// step: errors above this many sizes damp the other joints no further.
const FAR: f64 = 2.0;

/// Lengths of a robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lengths {
    /// Square of what counts as its size, m^2.
    size2: f64,
    /// Squared errors damp a step as if they were no more than this, m^2.
    most2: f64,
    /// Some joints slide.
    pub slides: bool,
}

impl Lengths {
    /// Of a robot of some size, m, with slides or without.
    pub fn new(size: f64, slides: bool) -> Self {
        let size2 = size * size;
        Self { size2, most2: if slides { FAR * FAR * size2 } else { f64::INFINITY }, slides }
    }

    /// Square of the robot's size, m^2.
    pub fn size2(&self) -> f64 {
        self.size2
    }

    /// What a share of half the squared error adds to the diagonal of `J J^T`.
    #[inline(always)]
    pub fn added<R: Real>(&self, squared: R, share: f64) -> R {
        let squared = squared.min(R::splat(self.most2));
        squared.mul_add(R::splat(0.5 * share), R::splat(LEAST * self.size2))
    }

    /// Least pivot of an elimination of `J J^T`.
    #[inline(always)]
    pub fn pivot<R: Real>(&self) -> R {
        R::splat(PIVOT * self.size2)
    }

    /// The way of a slide that stands beside a radian of the other joints, m: the robot's
    /// size, and more while the goal is farther away than that.
    #[inline(always)]
    pub fn per_radian<R: Real>(&self, squared: R) -> R {
        (squared + R::splat(self.size2)).sqrt()
    }
}
