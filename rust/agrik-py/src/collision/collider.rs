//! The class `Collider`.

use std::sync::Arc;

use agrik_motion::Error;
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use super::bodies::{Bodies, touch};
use super::distances::Distances;
use super::scene::Scene;
use crate::convert::{Floats, array, real};
use crate::ik::signals::Signals;
use crate::robot::kinematics::JointValues;
use crate::{errors, threads};

/// An arm with bodies in a scene: what hits what at given joint values.
#[pyclass(frozen, module = "agrik_fast._native")]
pub struct Collider {
    core: Arc<agrik_motion::Collider>,
    bodies: Py<Bodies>,
    scene: Py<Scene>,
}

type Array<'py, T> = PyResult<Bound<'py, PyArrayDyn<T>>>;

impl Collider {
    pub fn core(&self) -> Arc<agrik_motion::Collider> {
        Arc::clone(&self.core)
    }

    fn joint_values<'py>(&self, q: &Bound<'py, PyAny>) -> PyResult<JointValues<'py>> {
        JointValues::new(q, self.core.bodies().chain().dof())
    }

    /// Asks about rows of joint values with the interpreter released.
    pub fn ask<T: Send>(
        py: Python<'_>,
        ask: impl FnOnce(&mut dyn FnMut() -> bool) -> Result<T, Error> + Send,
    ) -> PyResult<T> {
        let mut signals = Signals::new();
        let answer = py.detach(|| ask(&mut || signals.go_on_detached()));
        answer.map_err(|error| signals.exception(py, error))
    }
}

/// A cap, which may be left out.
fn cap(value: Option<&Bound<'_, PyAny>>) -> PyResult<f64> {
    value.map_or(Ok(f64::INFINITY), |value| real("cap", value))
}

#[pymethods]
impl Collider {
    /// Put bodies into a scene.
    #[new]
    #[pyo3(signature = (bodies, scene, exemptions=None, touch=None))]
    fn new(
        py: Python<'_>,
        bodies: Py<Bodies>,
        scene: Py<Scene>,
        exemptions: Option<Vec<(usize, usize)>>,
        touch: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let touch = touch.map(self::touch).transpose()?;
        let (of_arm, of_scene) = (bodies.get().core(), scene.get().core());
        let exemptions = exemptions.unwrap_or_default();
        let core = agrik_motion::Collider::new(of_arm, of_scene, &exemptions, touch.as_ref());
        let core = Arc::new(core.map_err(|error| errors::from_core(py, error))?);
        Ok(Self { core, bodies, scene })
    }

    /// The arm with its bodies.
    #[getter]
    fn bodies(&self, py: Python<'_>) -> Py<Bodies> {
        self.bodies.clone_ref(py)
    }

    /// The objects.
    #[getter]
    fn scene(&self, py: Python<'_>) -> Py<Scene> {
        self.scene.clone_ref(py)
    }

    /// Whether postures hit the scene or themselves.
    #[pyo3(signature = (q, clear=None, threads=None))]
    fn collides<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        clear: Option<&Bound<'py, PyAny>>,
        threads: Option<&Bound<'py, PyAny>>,
    ) -> Array<'py, bool> {
        let (py, q) = (q.py(), self.joint_values(q)?);
        let clear = clear.map_or(Ok(0.0), |clear| real("clear", clear))?;
        let threads = threads::number(threads, "threads")?;
        let values = q.values()?;
        let hits = Self::ask(py, |poll| self.core.collides(values, clear, threads, poll))?;
        array(py, &q.shape_with(&[]), hits)
    }

    /// Distance of postures from the nearest collision, m.
    #[pyo3(signature = (q, cap=None, threads=None, own=true))]
    fn clearance<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        cap: Option<&Bound<'py, PyAny>>,
        threads: Option<&Bound<'py, PyAny>>,
        own: bool,
    ) -> Array<'py, f64> {
        let (py, q, cap) = (q.py(), self.joint_values(q)?, self::cap(cap)?);
        let threads = threads::number(threads, "threads")?;
        let values = q.values()?;
        let found = Self::ask(py, |poll| self.core.clearances(values, cap, own, threads, poll))?;
        array(py, &q.shape_with(&[]), found)
    }

    /// Distance from the scene at joint values, shape (n, dof), with the bodies of each shifted
    /// by vectors, shape (n, bodies, 3); m.
    #[pyo3(signature = (q, shifts, threads=None))]
    fn shifted_clearance<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        shifts: &Bound<'py, PyAny>,
        threads: Option<&Bound<'py, PyAny>>,
    ) -> Array<'py, f64> {
        let (py, q) = (q.py(), self.joint_values(q)?);
        let shifts = Floats::new("shifts", shifts)?;
        let threads = threads::number(threads, "threads")?;
        let (values, vectors) = (q.values()?, shifts.values()?.as_chunks().0);
        let found =
            Self::ask(py, |poll| self.core.shifted_clearances(values, vectors, threads, poll))?;
        array(py, &q.shape_with(&[]), found)
    }

    /// Distance of each body, with the nearest object and the points; m.
    #[pyo3(signature = (q, cap=None, threads=None))]
    fn distances<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        cap: Option<&Bound<'py, PyAny>>,
        threads: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Distances> {
        let (py, q, cap) = (q.py(), self.joint_values(q)?, self::cap(cap)?);
        let threads = threads::number(threads, "threads")?;
        let values = q.values()?;
        let found = Self::ask(py, |poll| self.core.distances(values, cap, threads, poll))?;
        Ok(Distances::new(q.shape_with(&[]), self.core.bodies().len(), &found))
    }

    /// Clearance and how it changes with the joint values.
    #[pyo3(signature = (q, cap=None, threads=None, own=true))]
    #[allow(clippy::type_complexity)]
    fn gradient<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        cap: Option<&Bound<'py, PyAny>>,
        threads: Option<&Bound<'py, PyAny>>,
        own: bool,
    ) -> PyResult<(Bound<'py, PyArrayDyn<f64>>, Bound<'py, PyArrayDyn<f64>>)> {
        let (py, q, cap) = (q.py(), self.joint_values(q)?, self::cap(cap)?);
        let threads = threads::number(threads, "threads")?;
        let values = q.values()?;
        let (least, rates) =
            Self::ask(py, |poll| self.core.gradients(values, cap, own, threads, poll))?;
        let dof = self.core.bodies().chain().dof();
        Ok((array(py, &q.shape_with(&[]), least)?, array(py, &q.shape_with(&[dof]), rates)?))
    }
}
