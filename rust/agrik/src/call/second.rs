//! Second aims: of the postures that reach a target the one that is best by another measure.

use crate::allowed::is_measure;
use crate::chain::{Chain, Variable};
use crate::error::{Error, Result};
use crate::kinematics::PerJoint;
use crate::lanes::Real;

/// By what the freedom that a target leaves is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Merit {
    /// Near a posture.
    Near,
    /// Near the middle of the limits, in shares of their width.
    Middle,
    /// Away from the limits: the sum of `(u - l)^2 / (4 (u - q) (q - l))` (Chan and Dubey 1995).
    Limits,
    /// Far from singularities: the root of `det(J J^T)` (Yoshikawa 1985).
    Manipulability,
}

impl Merit {
    /// Every measure with the name that users know it by.
    pub const ALL: [(&'static str, Self); 4] = [
        ("near", Self::Near),
        ("middle", Self::Middle),
        ("limits", Self::Limits),
        ("manipulability", Self::Manipulability),
    ];
}

/// Least distance from a limit that [`Merit::Limits`] counts, as a share of the range.
const LEAST: f64 = 1e-4;

/// A measure, checked for a chain.
#[derive(Debug, Clone, PartialEq)]
pub struct Second {
    pub(crate) measure: Merit,
    /// The posture of [`Merit::Near`]; without one the start values, or the middle.
    pub(crate) posture: Option<Vec<f64>>,
    /// What each joint counts.
    pub(crate) weights: Vec<f64>,
    joints: PerJoint<Joint>,
}

/// What a measure knows of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Joint {
    lower: f64,
    upper: f64,
    middle: f64,
    /// Half of its range; 0 where it has no limits to speak of.
    half: f64,
}

impl Joint {
    fn of(v: &Variable, size: f64) -> Self {
        let bounded = v.upper - v.lower < 1e3 * size.max(1.0) && v.lower < v.upper;
        let half = if bounded { 0.5 * (v.upper - v.lower) } else { 0.0 };
        Self { lower: v.lower, upper: v.upper, middle: v.middle(), half }
    }
}

/// What a joint value adds to a measure, and its derivatives.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bends<R> {
    pub value: R,
    pub slope: R,
    pub curvature: R,
    pub third: R,
}

impl Second {
    /// A checked second aim: `posture` for [`Merit::Near`] alone, and a weight a joint.
    pub fn new(
        chain: &Chain,
        measure: Merit,
        posture: Option<Vec<f64>>,
        weights: Option<Vec<f64>>,
    ) -> Result<Self> {
        let dof = chain.dof();
        if let Some(posture) = &posture
            && (posture.len() != dof || posture.iter().any(|x| !is_measure(*x)))
        {
            return Err(Error::argument("posture", format!("{dof} finite numbers"), "others"));
        }
        let weights = weights.unwrap_or_else(|| vec![1.0; dof]);
        check_weights(&weights, dof)?;
        let size = chain.reach().size;
        let joints = chain.variables().iter().map(|v| Joint::of(v, size)).collect();
        Ok(Self { measure, posture, weights, joints })
    }

    /// What it is good at.
    pub fn merit(&self) -> Merit {
        self.measure
    }

    /// The posture of [`Merit::Near`], if it has one of its own.
    pub fn posture(&self) -> Option<&[f64]> {
        self.posture.as_deref()
    }

    /// The same measure about a posture, unless it has one of its own.
    pub(crate) fn about(&self, posture: &[f64]) -> Self {
        let own = self.posture.clone().unwrap_or_else(|| posture.to_vec());
        Self { posture: Some(own), ..self.clone() }
    }

    /// What a joint value adds to the measure, and its first three derivatives; the less it adds
    /// the better. Nothing where the measure is no sum over the joints.
    #[inline(always)]
    pub(crate) fn bends<R: Real>(&self, i: usize, q: R, about: R) -> Bends<R> {
        let (joint, weight) = (&self.joints[i], self.weights[i]);
        let Joint { lower, upper, middle, half } = *joint;
        let quadratic = |off: R, weight: f64| {
            let slope = off * R::splat(weight);
            let value = R::splat(0.5) * slope * off;
            Bends { value, slope, curvature: R::splat(weight), third: R::zero() }
        };
        match self.measure {
            Merit::Near => quadratic(q - about, weight),
            Merit::Middle if half > 0.0 => quadratic(q - R::splat(middle), weight / (half * half)),
            Merit::Limits if half > 0.0 => {
                let least = R::splat(2.0 * half * LEAST);
                let up = (R::splat(upper) - q).max(least);
                let down = (q - R::splat(lower)).max(least);
                let (product, change) = (up * down, up - down);
                let inverse = R::splat(1.0) / product;
                let value = R::splat(weight * half * half) * inverse;
                let steep = change * inverse;
                let twice = value + value;
                let curvature = twice * steep.mul_add(steep, inverse);
                let third =
                    R::splat(-3.0) * twice * steep * steep.mul_add(steep, inverse + inverse);
                Bends { value, slope: R::zero() - value * steep, curvature, third }
            }
            _ => quadratic(R::zero(), 0.0),
        }
    }
}

/// Refuses what cannot weigh joints.
pub fn check_weights(weights: &[f64], dof: usize) -> Result<()> {
    if weights.len() != dof {
        return Err(Error::argument("weights", format!("{dof} numbers"), weights.len()));
    }
    match weights.iter().find(|x| !(x.is_finite() && **x >= 0.0)) {
        Some(bad) => Err(Error::argument("weights", "finite numbers, 0 or more", bad)),
        None if weights.iter().all(|x| *x == 0.0) => {
            Err(Error::argument("weights", "at least one number above 0", "none"))
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::IsometryMatrix3;

    use super::*;
    use crate::chain::{DhConvention, DhRow, JointKind};

    #[test]
    fn derivatives_are_those_of_the_value() {
        let joints = [(-1.0, 2.0), (-1.5, 1.2)].map(|(lower, upper)| {
            let row = DhRow { a: 0.3, alpha: 1.2, d: 0.1, theta: 0.0 };
            let name = format!("joint_{upper}");
            row.joint(DhConvention::Standard, name, JointKind::Revolute, lower, upper)
        });
        let none = IsometryMatrix3::identity();
        let chain = Chain::new("arm", joints.into(), none, none, None).expect("a chain");
        for (name, merit) in &Merit::ALL[..3] {
            let second = Second::new(&chain, *merit, None, Some(vec![0.7, 2.0])).expect("fine");
            for i in 0..2 {
                for q in [-0.9, -0.2, 0.4, 1.1] {
                    let (h, about) = (1e-5, 0.3);
                    let [below, at, above] = [q - h, q, q + h].map(|q| second.bends(i, q, about));
                    let close = |got: f64, a: f64, b: f64| {
                        let wanted = (b - a) / (2.0 * h);
                        assert!((got - wanted).abs() < 1e-6 * (1.0 + wanted.abs()), "{name} {q}");
                    };
                    close(at.slope, below.value, above.value);
                    close(at.curvature, below.slope, above.slope);
                    close(at.third, below.curvature, above.curvature);
                }
            }
        }
    }
}
