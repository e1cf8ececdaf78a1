//! The record of all branches of the targets of a call.

use crate::call::Status;

/// All branches of each target: as many rows of `dof` joint values as its family has
/// branches.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Branches {
    /// Branches a target.
    pub branches: usize,
    /// Joint values, rad; where a branch does not exist those that come nearest.
    pub q: Vec<f64>,
    /// Reached by forward kinematics, inside the limits, and not an earlier branch again.
    pub valid: Vec<bool>,
    /// The same without regard to the limits.
    pub reached: Vec<bool>,
    /// Singularities of each branch: sum of [`super::SHOULDER`], [`super::ELBOW`] and
    /// [`super::WRIST`].
    pub singular: Vec<u8>,
    /// What became of each target.
    pub status: Vec<u8>,
    /// What else is to be said of each target, bits of [`super::warning`]; empty for nothing.
    pub warnings: Vec<u8>,
    /// Entry of `q` that a singularity leaves free for each target, -1 for none; empty for none.
    pub free: Vec<i8>,
    /// Value of the swept or locked joint or arm angle of each branch; empty without one.
    pub values: Vec<f64>,
    /// Number of each branch among those of its value; empty where it is its place.
    pub numbers: Vec<u32>,
    /// Angle left for each target that asks for too much, rad; empty without any.
    pub left: Vec<f64>,
    /// Distance left for each of them, m; empty likewise.
    pub off: Vec<f64>,
}

impl Branches {
    /// Room for `rows` targets, but for their joint values.
    pub(crate) fn new(rows: usize, branches: usize) -> Self {
        Self {
            branches,
            q: Vec::new(),
            valid: vec![false; rows * branches],
            reached: vec![false; rows * branches],
            singular: vec![0; rows * branches],
            status: vec![Status::NotFound as u8; rows],
            ..Self::default()
        }
    }

    /// All rows, writable, with the joint values in other memory than [`Self::q`].
    pub(crate) fn as_mut_with<'a>(&'a mut self, q: &'a mut [f64]) -> BranchesMut<'a> {
        BranchesMut {
            first: 0,
            q,
            valid: &mut self.valid,
            reached: &mut self.reached,
            singular: &mut self.singular,
            status: &mut self.status,
            warnings: &mut self.warnings,
            free: &mut self.free,
            left: &mut self.left,
            off: &mut self.off,
        }
    }
}

/// A run of consecutive targets of [`Branches`], owned by one thread while it is filled.
#[derive(Debug)]
pub struct BranchesMut<'a> {
    /// Row of the first target in the whole call.
    pub first: usize,
    pub(crate) q: &'a mut [f64],
    pub(crate) valid: &'a mut [bool],
    pub(crate) reached: &'a mut [bool],
    pub(crate) singular: &'a mut [u8],
    pub(crate) status: &'a mut [u8],
    /// Empty where nobody asks.
    pub(crate) warnings: &'a mut [u8],
    pub(crate) free: &'a mut [i8],
    pub(crate) left: &'a mut [f64],
    pub(crate) off: &'a mut [f64],
}

impl<'a> BranchesMut<'a> {
    /// How many targets.
    pub fn len(&self) -> usize {
        self.status.len()
    }
    /// No target at all.
    pub fn is_empty(&self) -> bool {
        self.status.is_empty()
    }

    /// The targets in runs of at most `size`.
    pub fn split(self, size: usize) -> Vec<Self> {
        let a_target = |numbers: usize| (numbers / self.status.len().max(1) * size).max(1);
        let (wide, branches) = (a_target(self.q.len()), a_target(self.valid.len()));
        self.q
            .chunks_mut(wide)
            .zip(self.valid.chunks_mut(branches))
            .zip(self.reached.chunks_mut(branches))
            .zip(self.singular.chunks_mut(branches))
            .zip(self.status.chunks_mut(size))
            .zip(pieces(self.warnings, size))
            .zip(pieces(self.free, size))
            .zip(pieces(self.left, size).zip(pieces(self.off, size)))
            .enumerate()
            .map(|(i, (((((((q, valid), reached), singular), status), warnings), free), error))| {
                let (left, off) = error;
                BranchesMut {
                    first: self.first + i * size,
                    q,
                    valid,
                    reached,
                    singular,
                    status,
                    warnings,
                    free,
                    left,
                    off,
                }
            })
            .collect()
    }
}

/// Pieces of a size; of nothing as many empty ones as are asked for.
fn pieces<T>(all: &mut [T], size: usize) -> impl Iterator<Item = &mut [T]> {
    let none = all.is_empty();
    all.chunks_mut(size).chain(std::iter::repeat_with(|| &mut [][..]).take(if none {
        usize::MAX
    } else {
        0
    }))
}
