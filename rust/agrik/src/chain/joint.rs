//! One joint of a serial chain.

use nalgebra::{IsometryMatrix3, Unit, Vector3};

/// Limits this far out on both sides, and infinite ones, are how files say "no limit": a
/// joint that turns between them turns freely.
pub const UNLIMITED: f64 = 1e4;

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
            mimic: None,
        }
    }
}
