//! One joint of a serial chain.

use nalgebra::{IsometryMatrix3, Unit, Vector3};

use crate::allowed::LARGEST;

/// Limits this far out on both sides, and infinite ones, are how files say "no limit": a
/// joint that turns between them turns freely.
pub const UNLIMITED: f64 = 1e4;

/// A value of a size that means something keeps these limits.
pub fn hold_a_value(lower: f64, upper: f64) -> bool {
    lower <= upper && lower <= LARGEST && -LARGEST <= upper
}

/// The value that answers stay near, for the caller's `about`: inside the limits, and of a joint
/// that `turns` freely no farther from 0 than `most` where whole turns bring it nearer: the last
/// digits of a larger angle are too coarse.
#[inline(always)]
pub fn reference(about: f64, (lower, upper): (f64, f64), turns: bool, most: f64) -> f64 {
    let about = about.max(lower).min(upper);
    if turns && about.abs() > most { brought_back(about, (lower, upper)) } else { about }
}

/// The angle nearest to 0 that is whole turns away, and inside the limits if any is.
#[cold]
fn brought_back(about: f64, (lower, upper): (f64, f64)) -> f64 {
    use std::f64::consts::TAU;
    let near = about - (about / TAU).round() * TAU;
    let inside = if near < lower {
        near + ((lower - near) / TAU).ceil() * TAU
    } else {
        near - ((near - upper) / TAU).ceil().max(0.0) * TAU
    };
    if lower <= inside && inside <= upper { inside } else { about }
}

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// Turns about its axis between limits; value in rad.
    Revolute,
    /// Turns about its axis without limits; value in rad.
    Continuous,
    /// Slides along its axis between limits; value in m.
    Prismatic,
    /// Does not move.
    Fixed,
}

impl JointKind {
    /// The lower-case name used in files and in Python.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Revolute => "revolute",
            Self::Continuous => "continuous",
            Self::Prismatic => "prismatic",
            Self::Fixed => "fixed",
        }
    }

    /// The kind of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Revolute, Self::Continuous, Self::Prismatic, Self::Fixed]
            .into_iter()
            .find(|kind| kind.as_str() == name)
    }
}

/// How fast a joint may move; infinite where nobody says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionLimits {
    /// Largest speed, rad/s or m/s.
    pub velocity: f64,
    /// Largest acceleration and deceleration, rad/s^2 or m/s^2.
    pub acceleration: f64,
    /// Largest change of the acceleration, rad/s^3 or m/s^3.
    pub jerk: f64,
}

impl MotionLimits {
    /// Nothing is known.
    pub const UNKNOWN: Self =
        Self { velocity: f64::INFINITY, acceleration: f64::INFINITY, jerk: f64::INFINITY };

    /// The stricter of both, number by number, where the other's belong to `factor` times the
    /// joint; a factor of 0 asks for nothing.
    pub(super) fn narrowed(self, other: Self, factor: f64) -> Self {
        if factor == 0.0 {
            return self;
        }
        Self {
            velocity: self.velocity.min(other.velocity / factor.abs()),
            acceleration: self.acceleration.min(other.acceleration / factor.abs()),
            jerk: self.jerk.min(other.jerk / factor.abs()),
        }
    }

    pub(super) fn numbers(self) -> [(&'static str, f64); 3] {
        [("velocity", self.velocity), ("acceleration", self.acceleration), ("jerk", self.jerk)]
    }
}

/// A joint that follows another: value = `multiplier` * source + `offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct Mimic {
    /// Name of the joint that is followed; it need not lie on the chain itself.
    pub source: String,
    /// Factor on the source's value.
    pub multiplier: f64,
    /// Added after the factor, rad or m.
    pub offset: f64,
    /// Limits of a source that does not lie on the chain, rad or m.
    pub source_limits: Option<(f64, f64)>,
}

/// A joint with its constant transforms: `parent -> origin -> motion -> after -> child`.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Unique name.
    pub name: String,
    /// How it moves.
    pub kind: JointKind,
    /// Joint frame in the parent link's frame.
    pub origin: IsometryMatrix3<f64>,
    /// Axis of motion in the joint frame.
    pub axis: Unit<Vector3<f64>>,
    /// Child link's frame in the moved joint frame; the identity but for standard DH.
    pub after: IsometryMatrix3<f64>,
    /// Smallest value, rad or m (`-inf` for continuous joints).
    pub lower: f64,
    /// Largest value, rad or m (`inf` for continuous joints).
    pub upper: f64,
    /// How fast it may move.
    pub motion: MotionLimits,
    /// The joint this one follows, if any.
    pub mimic: Option<Mimic>,
    /// Name of the link it carries.
    pub child_link: String,
}

impl Joint {
    /// A joint about or along z without constant transforms.
    pub fn new(name: impl Into<String>, kind: JointKind, lower: f64, upper: f64) -> Self {
        let name = name.into();
        Self {
            child_link: format!("{name}_link"),
            name,
            kind,
            origin: IsometryMatrix3::identity(),
            axis: Vector3::z_axis(),
            after: IsometryMatrix3::identity(),
            lower,
            upper,
            motion: MotionLimits::UNKNOWN,
            mimic: None,
        }
    }

    /// The joint as a chain goes through it from its child to its parent, which then is the link
    /// that it carries; its value stays the same.
    pub(super) fn reversed(self, parent_link: &str) -> Self {
        Self {
            origin: self.after.inverse(),
            axis: -self.axis,
            after: self.origin.inverse(),
            child_link: parent_link.to_owned(),
            ..self
        }
    }
}
