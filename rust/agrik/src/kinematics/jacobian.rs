//! Columns of the geometric Jacobian from the axes that forward kinematics left behind.

use super::Workspace;
use crate::chain::Compiled;
use crate::lanes::{Real, V3, cross, scale, sub};

/// Hands each moving joint's column (variable, linear part at `point`, angular part) to
/// `column`. Joints that share a variable hand in one column each, to be added up.
#[inline(always)]
pub fn columns<R: Real>(
    chain: &Compiled,
    workspace: &Workspace<R>,
    point: V3<R>,
    mut column: impl FnMut(usize, V3<R>, V3<R>),
) {
    for (link, axis) in chain.links.iter().zip(&workspace.axes) {
        let (mut linear, mut angular) = if link.prismatic {
            (axis.direction, [R::zero(); 3])
        } else {
            (cross(axis.direction, sub(point, axis.origin)), axis.direction)
        };
        if !chain.simple {
            let factor = R::splat(link.multiplier);
            linear = scale(linear, factor);
            angular = scale(angular, factor);
        }
        column(link.variable, linear, angular);
    }
}
