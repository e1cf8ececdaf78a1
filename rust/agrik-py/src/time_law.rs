//! The class `Motion`: joint values along a way by time.

use agrik::chain::MotionLimits;
use agrik_motion::time_law;
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use crate::convert::{Floats, array, wrong_shape};
use crate::errors;

/// A motion along a way, from rest to rest within the limits of the joints.
#[pyclass(frozen, module = "agrik_fast._native")]
pub struct Motion(time_law::Motion);

type Array<'py> = PyResult<Bound<'py, PyArrayDyn<f64>>>;

#[pymethods]
impl Motion {
    /// The motion through waypoints, shape (n, dof), whose segments have `lengths`, shape
    /// (n - 1,): with corners rounded by `blends`, shape (n,), or as one smooth curve without;
    /// `limits`, shape (3, dof), are those of velocity, acceleration and jerk.
    #[new]
    #[pyo3(signature = (waypoints, lengths, blends, limits, speed))]
    fn new(
        py: Python<'_>,
        waypoints: &Bound<'_, PyAny>,
        lengths: &Bound<'_, PyAny>,
        blends: Option<&Bound<'_, PyAny>>,
        limits: &Bound<'_, PyAny>,
        speed: f64,
    ) -> PyResult<Self> {
        let waypoints = Floats::new("waypoints", waypoints)?;
        let [_, dof] = *waypoints.shape() else {
            return Err(wrong_shape(py, "waypoints", waypoints.shape(), "(n, dof)"));
        };
        let lengths = Floats::new("lengths", lengths)?;
        let blends = blends.map(|blends| Floats::new("blends", blends)).transpose()?;
        let limits = Floats::of_shape("limits", limits, &[3, dof])?;
        let numbers = limits.values()?;
        let limits: Vec<MotionLimits> = (0..dof)
            .map(|i| MotionLimits {
                velocity: numbers[i],
                acceleration: numbers[dof + i],
                jerk: numbers[2 * dof + i],
            })
            .collect();
        let (points, lengths) = (waypoints.values()?, lengths.values()?);
        let blends = blends.as_ref().map(Floats::values).transpose()?;
        let made = py.detach(|| {
            let path = match blends {
                Some(blends) => time_law::Path::with_corners(dof, points, lengths, blends),
                None => time_law::Path::smooth(dof, points, lengths),
            };
            path.and_then(|path| time_law::Motion::new(path, &limits, speed))
        });
        made.map(Self).map_err(|error| errors::from_core(py, error))
    }

    /// Duration, s.
    #[getter]
    fn duration(&self) -> f64 {
        self.0.duration()
    }

    /// Length of the way, in the measure of the segments' lengths.
    #[getter]
    fn length(&self) -> f64 {
        self.0.path().length()
    }

    /// How far a rounded corner leaves its waypoint at most, in any joint value, rad or m.
    #[getter]
    fn deviation(&self) -> f64 {
        self.0.path().deviation()
    }

    /// When the phases begin, and when the last one ends, shape (n + 1,), s.
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> Array<'py> {
        let times = self.0.times();
        array(py, &[times.len()], times.to_vec())
    }

    /// Place on the way and its derivatives by time at the begin of each phase, shape (n, 4).
    #[getter]
    fn phases<'py>(&self, py: Python<'py>) -> Array<'py> {
        let rows: Vec<f64> = self.0.phases().iter().flat_map(|phase| phase.at).collect();
        array(py, &[self.0.phases().len(), 4], rows)
    }

    /// Place on the way and its first three derivatives by time, shape (n, 4), at times, s.
    fn place<'py>(&self, py: Python<'py>, times: &Bound<'py, PyAny>) -> Array<'py> {
        let times = Floats::new("times", times)?;
        let times = times.values()?;
        let rows = times.iter().flat_map(|time| self.0.place(*time)).collect();
        array(py, &[times.len(), 4], rows)
    }

    /// Joint values, velocities, accelerations and jerks, shape (4, n, dof), at times, s.
    fn at<'py>(&self, py: Python<'py>, times: &Bound<'py, PyAny>) -> Array<'py> {
        let times = Floats::new("times", times)?;
        let times = times.values()?;
        let dof = self.0.path().dof();
        let block = times.len() * dof;
        let mut out = vec![0.0; 4 * block];
        py.detach(|| {
            for (row, time) in times.iter().enumerate() {
                self.0.at(*time, |joint, values| {
                    for (k, value) in values.into_iter().enumerate() {
                        out[k * block + row * dof + joint] = value;
                    }
                });
            }
        });
        array(py, &[4, times.len(), dof], out)
    }
}
