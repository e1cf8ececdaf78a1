//! The class `Distances`.

use numpy::PyArrayDyn;
use pyo3::prelude::*;

use crate::result::Column;

/// What `Collider.distances` returns.
#[pyclass(frozen, module = "agrik_fast._native")]
pub struct Distances {
    shape: Vec<usize>,
    bodies: usize,
    distance: Column<f64>,
    object: Column<i64>,
    on_body: Column<f64>,
    on_object: Column<f64>,
    own_distance: Column<f64>,
    own_pair: Column<i64>,
    own_points: Column<f64>,
}

type Array<'py, T> = PyResult<Bound<'py, PyArrayDyn<T>>>;

impl Distances {
    /// Of postures of a leading shape.
    pub fn new(shape: Vec<usize>, bodies: usize, found: &agrik_motion::body::Distances) -> Self {
        let index = |index: Option<usize>| index.map_or(-1, |index| index as i64);
        let (each, own) = (found.bodies.iter(), found.own.iter());
        let pairs = own.clone().flat_map(|one| match one.pair {
            Some((i, j)) => [i as i64, j as i64],
            None => [-1, -1],
        });
        Self {
            shape,
            bodies,
            distance: Column::new(each.clone().map(|one| one.distance).collect()),
            object: Column::new(each.clone().map(|one| index(one.object)).collect()),
            on_body: Column::new(each.clone().flat_map(|one| one.points[0]).collect()),
            on_object: Column::new(each.flat_map(|one| one.points[1]).collect()),
            own_distance: Column::new(own.clone().map(|one| one.distance).collect()),
            own_pair: Column::new(pairs.collect()),
            own_points: Column::new(own.flat_map(|one| one.points).flatten().collect()),
        }
    }

    fn shape_with(&self, more: &[usize]) -> Vec<usize> {
        [&self.shape, more].concat()
    }
}

#[pymethods]
impl Distances {
    /// Distance of each body from its nearest object, shape (..., bodies), m.
    #[getter]
    fn distance<'py>(&self, py: Python<'py>) -> Array<'py, f64> {
        self.distance.get(py, &self.shape_with(&[self.bodies]))
    }

    /// Index of the nearest object of each body, shape (..., bodies); -1 for none.
    #[getter]
    fn object<'py>(&self, py: Python<'py>) -> Array<'py, i64> {
        self.object.get(py, &self.shape_with(&[self.bodies]))
    }

    /// The body's point nearest to the object, shape (..., bodies, 3), m; 0 for none.
    #[getter]
    fn on_body<'py>(&self, py: Python<'py>) -> Array<'py, f64> {
        self.on_body.get(py, &self.shape_with(&[self.bodies, 3]))
    }

    /// The object's point nearest to the body, shape (..., bodies, 3), m; 0 for none.
    #[getter]
    fn on_object<'py>(&self, py: Python<'py>) -> Array<'py, f64> {
        self.on_object.get(py, &self.shape_with(&[self.bodies, 3]))
    }

    /// Distance of the nearest self pair, shape (...), m; infinite for none.
    #[getter]
    fn own_distance<'py>(&self, py: Python<'py>) -> Array<'py, f64> {
        self.own_distance.get(py, &self.shape)
    }

    /// The two bodies of the nearest self pair, shape (..., 2); -1 for none.
    #[getter]
    fn own_pair<'py>(&self, py: Python<'py>) -> Array<'py, i64> {
        self.own_pair.get(py, &self.shape_with(&[2]))
    }

    /// Where they come nearest, shape (..., 2, 3), m; 0 for none.
    #[getter]
    fn own_points<'py>(&self, py: Python<'py>) -> Array<'py, f64> {
        self.own_points.get(py, &self.shape_with(&[2, 3]))
    }
}
