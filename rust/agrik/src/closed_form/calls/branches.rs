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
            .enumerate()
            .map(|(i, ((((q, valid), reached), singular), status))| BranchesMut {
                first: self.first + i * size,
                q,
                valid,
                reached,
                singular,
                status,
            })
            .collect()
    }
}
