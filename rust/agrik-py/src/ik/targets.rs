//! Targets: points or poses of any leading shape, copied once, poses checked.

use std::sync::atomic::{AtomicUsize, Ordering};

use agrik::call::Goals;
use agrik::threads::share;
use numpy::{PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::convert::{
    Floats, RIGID_TRANSFORM, is_rigid, numbers, shape_text, why_not_rigid, wrong_shape,
};
use crate::errors;

/// Poses that a thread looks at in one go.
const PIECE: usize = 1024;

const EXPECTED: &str = "(..., 4, 4) for poses or (..., 3) for positions";

/// Targets as they came, in memory of our own.
pub enum Targets<'py> {
    /// A single pose, row by row.
    Lone([f64; 16]),
    /// Any number of points.
    Points(Floats<'py>),
    /// Any number of poses.
    Poses(Floats<'py>),
}

impl<'py> Targets<'py> {
    /// Copies the targets, on up to so many threads; their kind follows from their shape.
    pub fn new(value: &Bound<'py, PyAny>, threads: usize) -> PyResult<Self> {
        if let Some(pose) = lone_pose(value) {
            return Ok(Self::Lone(pose));
        }
        let array = numbers("targets", value)?;
        match array.shape() {
            [.., 4, 4] => Ok(Self::Poses(Floats::many("targets", array.as_any(), threads)?)),
            [.., 3] => Ok(Self::Points(Floats::many("targets", array.as_any(), threads)?)),
            other => {
                let seven = other.last() == Some(&7);
                let order = if seven { ", or with order= for seven numbers" } else { "" };
                let expected = format!("{EXPECTED}{order}");
                Err(wrong_shape(value.py(), "targets", other, &expected))
            }
        }
    }

    /// Poses rather than points.
    pub fn are_poses(&self) -> bool {
        !matches!(self, Self::Points(_))
    }

    /// One target, and not a batch of one.
    pub fn is_single(&self) -> bool {
        self.leading_shape().is_empty()
    }

    /// The shape without the dimensions of a single target.
    pub fn leading_shape(&self) -> &[usize] {
        match self {
            Self::Lone(_) => &[],
            Self::Points(points) => points.shape().split_last().map_or(&[], |(_, rest)| rest),
            Self::Poses(poses) => {
                poses.shape().split_last_chunk::<2>().map_or(&[], |(rest, _)| rest)
            }
        }
    }

    /// The numbers of all targets.
    pub fn values(&self) -> PyResult<&[f64]> {
        match self {
            Self::Lone(pose) => Ok(pose),
            Self::Points(floats) | Self::Poses(floats) => floats.values(),
        }
    }
}

/// A single pose in an array of doubles, without a detour over NumPy's functions.
fn lone_pose(value: &Bound<'_, PyAny>) -> Option<[f64; 16]> {
    let array = value.cast::<PyArray2<f64>>().ok()?;
    if array.dims() != numpy::Ix2(4, 4) || !array.is_aligned() {
        return None;
    }
    if array.is_c_contiguous() {
        return array.to_vec().ok()?.try_into().ok();
    }
    let mut pose = [0.0; 16];
    for (i, x) in pose.iter_mut().enumerate() {
        *x = array.get_owned([i / 4, i % 4])?;
    }
    Some(pose)
}

/// Goals of the core from the numbers of all targets. With one direction for all, only
/// the poses' points count; `points` then holds them.
pub fn goals<'a>(
    values: &'a [f64],
    are_poses: bool,
    direction: Option<[f64; 3]>,
    points: &'a mut Vec<[f64; 3]>,
) -> Goals<'a> {
    if !are_poses {
        return Goals::Positions { points: values.as_chunks().0, direction };
    }
    let poses: &[[f64; 16]] = values.as_chunks().0;
    if direction.is_none() {
        return Goals::Poses(poses);
    }
    points.extend(poses.iter().map(|m| [m[3], m[7], m[11]]));
    Goals::Positions { points, direction }
}

/// The first pose that is finite, yet not a rigid transform, looked for by several threads.
pub fn first_not_rigid(poses: &[[f64; 16]], threads: usize) -> Option<usize> {
    // NaN and infinity are never rigid, so most poses are read once.
    let in_piece = |piece: &[[f64; 16]]| {
        piece.iter().position(|m| !is_rigid(m) && m.iter().all(|x| x.is_finite()))
    };
    if poses.len() <= PIECE {
        return in_piece(poses);
    }
    let first = AtomicUsize::new(usize::MAX);
    let pieces = poses.chunks(PIECE).enumerate().collect();
    let look = |(i, piece): (usize, &[[f64; 16]])| {
        if let Some(row) = in_piece(piece) {
            first.fetch_min(i * PIECE + row, Ordering::Relaxed);
        }
    };
    share(pieces, threads, &look, &mut || true);
    Some(first.into_inner()).filter(|row| *row < poses.len())
}

/// The exception for a pose that is no rigid transform.
pub fn not_rigid_error(py: Python<'_>, leading: &[usize], row: usize, pose: &[f64; 16]) -> PyErr {
    let mut index = vec![0; leading.len()];
    let mut rest = row;
    for (i, size) in index.iter_mut().zip(leading).rev() {
        *i = rest % size;
        rest /= size;
    }
    let place = match &index[..] {
        [] => "targets".to_owned(),
        [one] => format!("targets[{one}]"),
        several => {
            let text = shape_text(several);
            format!("targets[{}]", &text[1..text.len() - 1])
        }
    };
    errors::argument(py, &place, &why_not_rigid(pose), RIGID_TRANSFORM)
}
