//! Freedom of collisions as an argument of inverse kinematics.

use std::sync::Arc;

use agrik::call::Prefer;
use agrik::chain::Chain;
use agrik_motion::{Collider, Free};
use pyo3::prelude::*;

use super::collider;
use crate::convert::{real, word};
use crate::errors;

/// The arguments as Python gave them.
pub struct Given<'a, 'py> {
    pub collider: Option<&'a Bound<'py, PyAny>>,
    pub clear: Option<&'a Bound<'py, PyAny>>,
    pub prefer: Option<&'a Bound<'py, PyAny>>,
}

/// What answers have to be besides reaching their targets.
pub struct Scene {
    pub collider: Arc<Collider>,
    pub clear: f64,
    pub prefer: Prefer,
}

impl Scene {
    /// The scene of a call for an arm, if it has one.
    pub fn new(py: Python<'_>, chain: &Chain, given: &Given<'_, '_>) -> PyResult<Option<Self>> {
        let clear = given.clear.map_or(Ok(0.0), |clear| real("clear", clear))?;
        let prefer = given.prefer;
        let prefer = prefer.map_or(Ok(Prefer::default()), |p| word("prefer", p, &Prefer::ALL))?;
        let Some(value) = given.collider else {
            if clear == 0.0 && prefer == Prefer::default() {
                return Ok(None);
            }
            let expected = "a scene, since `clear` or `prefer` asks for one";
            return Err(errors::argument(py, "scene", "None", expected));
        };
        let Ok(made) = value.cast::<collider::Collider>() else {
            return Err(errors::value("scene", value, "a scene of agrik_fast.collision"));
        };
        let collider = made.get().core();
        let (own, of) = (chain.compiled(), collider.bodies().chain().compiled());
        // Another tool makes no other arm.
        let same = own.links == of.links
            && own.start_position == of.start_position
            && own.start_rotation == of.start_rotation;
        if !same {
            let received = format!("bodies of {:?}", collider.bodies().chain().name());
            let expected = format!("bodies of {:?} as it stands", chain.name());
            return Err(errors::argument(py, "scene", &received, &expected));
        }
        Ok(Some(Self { collider, clear, prefer }))
    }

    /// What a request asks; made here, so that a wrong distance is said before any work.
    pub fn free(&self, py: Python<'_>) -> PyResult<Free<'_>> {
        Free::new(&self.collider, self.clear).map_err(|error| errors::from_core(py, error))
    }
}
