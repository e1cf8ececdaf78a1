//! What goes into a call, target by target: goals, and where to start from.

/// Targets, in the world frame.
#[derive(Debug, Clone, Copy)]
pub enum Goals<'a> {
    /// Tool points (m), for [`Position`](crate::task::Task::Position), or for
    /// [`Axis`](crate::task::Task::Axis) with one direction.
    Positions {
        /// One row a target.
        points: &'a [[f64; 3]],
        /// Direction of the tool axis, unit length, world frame.
        direction: Option<[f64; 3]>,
    },
    /// Homogeneous 4x4 matrices, row by row.
    Poses(&'a [[f64; 16]]),
}

impl Goals<'_> {
    /// How many targets.
    pub fn len(&self) -> usize {
        match self {
            Self::Positions { points, .. } => points.len(),
            Self::Poses(poses) => poses.len(),
        }
    }
    /// No target at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Where the first attempt of each target starts.
#[derive(Debug, Clone, Copy)]
pub enum Starts<'a> {
    /// Nowhere in particular: from the target's random stream.
    Free,
    /// The same joint values for all.
    One(&'a [f64]),
    /// `dof` joint values a target.
    Each(&'a [f64]),
}

impl<'a> Starts<'a> {
    /// The start of target `row`, if one was given.
    pub fn row(&self, row: usize, dof: usize) -> Option<&'a [f64]> {
        match self {
            Self::Free => None,
            Self::One(q) => Some(q),
            Self::Each(q) => Some(&q[row * dof..(row + 1) * dof]),
        }
    }
}

/// Copies of one target, for a subtask that tries several starts at once.
#[derive(Debug, Clone)]
pub(crate) enum Copies {
    /// Tool points, with the direction of all.
    Points(Vec<[f64; 3]>, Option<[f64; 3]>),
    /// Poses.
    Poses(Vec<[f64; 16]>),
}

impl Copies {
    /// So many copies of the first of them.
    pub fn repeated(&self, count: usize) -> Self {
        match self {
            Self::Points(points, direction) => Self::Points(vec![points[0]; count], *direction),
            Self::Poses(poses) => Self::Poses(vec![poses[0]; count]),
        }
    }

    /// The copies as the targets of a request.
    pub fn goals(&self) -> Goals<'_> {
        match self {
            Self::Points(points, direction) => Goals::Positions { points, direction: *direction },
            Self::Poses(poses) => Goals::Poses(poses),
        }
    }
}
