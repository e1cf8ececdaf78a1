//! Poses that are no rigid transforms: straightened where rounding explains it, or marked.

use nalgebra::{Matrix3, SVD};
use pyo3::intern;
use pyo3::prelude::*;

use crate::convert::{is_rigid, word};

/// Code of `agrik_fast.Warnings.STRAIGHTENED`.
pub const STRAIGHTENED: u8 = 32;
/// By which part a rotation of three printed decimals may stretch or shrink a length at most.
const ROUNDED: f64 = 1.5e-3;
/// The same of a matrix that is to be straightened by the user's own word.
const ROUGH: f64 = 0.02;
/// Sweeps after which a decomposition that has not ended is given up.
const SWEEPS: usize = 100;
const WORDS: [(&str, Invalid); 3] =
    [("mark", Invalid::Mark), ("raise", Invalid::Raise), ("straighten", Invalid::Straighten)];

/// What becomes of poses that are no rigid transforms.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Invalid {
    /// Rounded ones are straightened, others are bad input.
    #[default]
    Mark,
    /// They are refused.
    Raise,
    /// Rough ones are straightened, others are bad input.
    Straighten,
}

impl Invalid {
    /// What a word means, the first of them where there is none.
    #[inline]
    pub fn new(given: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        match given {
            None => Ok(Self::default()),
            // What the Python layer hands on where nobody said anything is this very object.
            Some(given) if given.is(intern!(given.py(), "mark")) => Ok(Self::Mark),
            Some(given) => word("invalid", given, &WORDS),
        }
    }
}

/// Poses with those that are no rigid transforms replaced, and a code for each.
#[derive(Debug)]
pub struct Mended {
    pub poses: Vec<f64>,
    pub warnings: Vec<u8>,
}

impl Mended {
    pub fn new(poses: &[[f64; 16]], invalid: Invalid) -> Self {
        let most = if invalid == Invalid::Straighten { ROUGH } else { ROUNDED };
        let mut mended =
            Self { poses: poses.as_flattened().to_vec(), warnings: vec![0; poses.len()] };
        let (rows, _) = mended.poses.as_chunks_mut::<16>();
        for (pose, warning) in rows.iter_mut().zip(&mut mended.warnings) {
            if is_rigid(pose) {
                continue;
            }
            match straight(pose, most) {
                Some(rigid) => {
                    *pose = rigid;
                    *warning = STRAIGHTENED;
                }
                // Not a number: its row is bad input.
                None => pose.fill(f64::NAN),
            }
        }
        mended
    }
}

/// The pose with the nearest rotation, if its own stretches no length by more than `most`.
fn straight(m: &[f64; 16], most: f64) -> Option<[f64; 16]> {
    if m[12..] != [0.0, 0.0, 0.0, 1.0] || !m.iter().all(|x| x.is_finite()) {
        return None;
    }
    let matrix = Matrix3::new(m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]);
    let svd = SVD::try_new(matrix, true, true, f64::EPSILON, SWEEPS)?;
    let rotation = svd.u? * svd.v_t?;
    let off = svd.singular_values.iter().fold(0.0f64, |off, s| off.max((s - 1.0).abs()));
    if off > most || rotation.determinant() < 0.0 {
        return None;
    }
    let mut rigid = *m;
    for i in 0..3 {
        for j in 0..3 {
            rigid[4 * i + j] = rotation[(i, j)];
        }
    }
    Some(rigid)
}
