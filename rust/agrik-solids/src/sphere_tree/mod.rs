//! Spheres in a tree of spheres: eight children to a node, one kernel at every level.
//!
//! The spheres of a node lie side by side in the lanes of singles, be they leaves or nodes
//! themselves, so a visit is the same few instructions everywhere. Singles only ever rule
//! out: what they let through by a margin for their rounding is left to the caller, who
//! decides in doubles. So answers do not depend on the lanes that found them.

mod build;
mod search;

pub use build::SphereTree;
pub use search::{ALL_LABELS, Leaves};

/// Children of a node.
const FAN: usize = 8;

/// Levels that 2^32 leaves need, and one more.
const LEVELS: usize = 12;

/// Eight spheres, coordinates m from the origin of the tree.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct Group {
    x: [f32; FAN],
    y: [f32; FAN],
    z: [f32; FAN],
    radius: [f32; FAN],
}

impl Group {
    /// Spheres that are farther away than anything: lanes without a sphere.
    const NONE: Self = Self { x: [FAR; FAN], y: [FAR; FAN], z: [FAR; FAN], radius: [0.0; FAN] };
}

/// A coordinate beyond all others whose square is still a number.
const FAR: f32 = 1e18;

/// A reach beyond all distances but those of [`FAR`].
const FARTHEST: f64 = 1e17;
