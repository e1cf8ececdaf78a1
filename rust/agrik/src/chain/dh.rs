//! Chains from Denavit-Hartenberg rows, standard (distal) or modified (Craig).

use nalgebra::{IsometryMatrix3, Rotation3, Translation3, Vector3};

use super::{Joint, JointKind};

/// Which of the two DH conventions the rows follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DhConvention {
    /// `Rz(theta) Tz(d) Tx(a) Rx(alpha)`: row i holds a and alpha of its own link.
    Standard,
    /// `Rx(alpha) Tx(a) Rz(theta) Tz(d)`: row i holds a and alpha of the link before.
    Modified,
}

/// One row: lengths in m, angles in rad. The joint's value is added to `theta`
/// (revolute) or to `d` (prismatic).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DhRow {
    /// Link length, m.
    pub a: f64,
    /// Link twist, rad.
    pub alpha: f64,
    /// Link offset, m.
    pub d: f64,
    /// Joint angle, rad.
    pub theta: f64,
}

impl DhRow {
    /// The joint of this row.
    pub fn joint(
        &self,
        convention: DhConvention,
        name: impl Into<String>,
        kind: JointKind,
        lower: f64,
        upper: f64,
    ) -> Joint {
        let along_z = IsometryMatrix3::from_parts(
            Translation3::new(0.0, 0.0, self.d),
            Rotation3::from_axis_angle(&Vector3::z_axis(), self.theta),
        );
        let along_x = IsometryMatrix3::from_parts(
            Translation3::new(self.a, 0.0, 0.0),
            Rotation3::from_axis_angle(&Vector3::x_axis(), self.alpha),
        );
        let mut joint = Joint::new(name, kind, lower, upper);
        match convention {
            DhConvention::Standard => {
                joint.origin = along_z;
                joint.after = along_x;
            }
            DhConvention::Modified => joint.origin = along_x * along_z,
        }
        joint
    }
}
