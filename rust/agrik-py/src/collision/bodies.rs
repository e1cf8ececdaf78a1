//! The class `Bodies`.

use std::sync::Arc;

use agrik_motion::body::Reason;
use agrik_motion::{Body, Shape};
use agrik_solids::{Core, Cuboid, Hull, Segment, Solid, Split};
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use super::rows::of_row;
use super::scene::points;
use crate::convert::{Floats, array, real, wrong_shape};
use crate::errors;
use crate::robot::chain::Chain;
use crate::robot::kinematics::JointValues;

/// Solids on the frames of an arm, and which pairs of them may hit each other.
#[pyclass(frozen, module = "agrik_fast._native")]
pub struct Bodies(Arc<agrik_motion::Bodies>);

/// Kinds of bodies, by the words that they are known by.
const KINDS: [&str; 5] = ["sphere", "capsule", "box", "convex", "cover"];

impl Bodies {
    pub fn core(&self) -> Arc<agrik_motion::Bodies> {
        Arc::clone(&self.0)
    }
}

#[pymethods]
impl Bodies {
    /// Make the bodies of an arm.
    #[new]
    #[pyo3(signature = (
        chain, names, frames, kinds, cores, radii, self_pairs=None, attached=None
    ))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        chain: &Bound<'_, Chain>,
        names: Vec<String>,
        frames: Vec<usize>,
        kinds: Vec<String>,
        cores: Vec<Bound<'_, PyAny>>,
        radii: &Bound<'_, PyAny>,
        self_pairs: Option<Vec<(usize, usize)>>,
        attached: Option<Vec<bool>>,
    ) -> PyResult<Self> {
        let count = names.len();
        let radii = Floats::of_shape("radii", radii, &[count])?;
        let attached = attached.unwrap_or_else(|| vec![false; count]);
        let lengths = [
            ("frames", frames.len()),
            ("kinds", kinds.len()),
            ("cores", cores.len()),
            ("attached", attached.len()),
        ];
        if let Some((name, length)) = lengths.iter().find(|(_, length)| *length != count) {
            let expected = format!("one for each of {count} names");
            return Err(errors::argument(py, name, &format!("{length} entries"), &expected));
        }
        let mut bodies = Vec::with_capacity(count);
        for (i, name) in names.into_iter().enumerate() {
            let shape = shape(i, &kinds[i], &cores[i], radii.values()?[i])?;
            bodies.push(Body { name, frame: frames[i], shape, attached: attached[i] });
        }
        let chain = chain.get().core();
        let made = py.detach(|| agrik_motion::Bodies::new(chain, bodies, self_pairs.as_deref()));
        Ok(Self(Arc::new(made.map_err(|error| errors::from_core(py, error))?)))
    }

    /// Names of the bodies.
    #[getter]
    fn names(&self) -> Vec<&str> {
        self.0.bodies().iter().map(|body| body.name.as_str()).collect()
    }

    /// Frame of each body.
    #[getter]
    fn frames(&self) -> Vec<usize> {
        self.0.bodies().iter().map(|body| body.frame).collect()
    }

    /// Which bodies are tools or held objects.
    #[getter]
    fn attached(&self) -> Vec<bool> {
        self.0.bodies().iter().map(|body| body.attached).collect()
    }

    /// Pairs of bodies that are asked whether they hit each other.
    #[getter]
    fn self_pairs(&self) -> Vec<(usize, usize)> {
        self.0.self_pairs().to_vec()
    }

    /// Pairs that are not asked: two bodies, why, and the share of postures that hit.
    #[getter]
    fn excluded_pairs(&self) -> Vec<(usize, usize, &'static str, Option<f64>)> {
        let share =
            |reason| if let Reason::Structural(share) = reason { Some(share) } else { None };
        let each = self.0.excluded_pairs().iter();
        each.map(|e| (e.pair.0, e.pair.1, e.reason.name(), share(e.reason))).collect()
    }

    /// Return levers, shape (..., dof, bodies), m/rad or no unit: a joint that changes by no
    /// more than `margin`, shape (dof,), from the joint values, shape (..., dof), moves a core
    /// point of a body by no more than its lever times its change.
    fn levers<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        margin: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let dof = self.0.chain().dof();
        let (py, q) = (q.py(), JointValues::new(q, dof)?);
        let margin = Floats::of_shape("margin", margin, &[dof])?;
        let (values, margin) = (q.values()?, margin.values()?);
        let rows = py.detach(|| {
            let mut placed = self.0.room();
            let mut rows = Vec::with_capacity(values.len() * self.0.len());
            for q in values.chunks_exact(dof) {
                self.0.place(q, &mut placed)?;
                rows.extend(self.0.local_levers(&placed, margin));
            }
            Ok(rows)
        });
        let rows = rows.map_err(|error| errors::from_core(py, error))?;
        array(py, &q.shape_with(&[dof, self.0.len()]), rows)
    }

    /// Return the number of bodies.
    fn __len__(&self) -> usize {
        self.0.len()
    }
}

/// The shape of body `i`.
fn shape(i: usize, kind: &str, core: &Bound<'_, PyAny>, radius: f64) -> PyResult<Shape> {
    let py = core.py();
    let name = format!("cores[{i}]");
    let of_points = |count: usize| {
        let points = points(&name, core)?;
        if points.len() == count {
            return Ok(points);
        }
        Err(wrong_shape(py, &name, &[points.len(), 3], &format!("({count}, 3)")))
    };
    let made = match kind {
        "sphere" => Solid::sphere(of_points(1)?[0], radius).map(Shape::from),
        "capsule" => {
            let ends = of_points(2)?;
            Segment::new(ends[0], ends[1])
                .and_then(|segment| Solid::new(Core::Segment(segment), radius))
                .map(Shape::from)
        }
        "box" => cuboid(&name, core, 3)?
            .and_then(|cuboid| Solid::new(Core::Cuboid(cuboid), radius))
            .map(Shape::from),
        "convex" => Hull::new(points(&name, core)?)
            .and_then(|hull| Solid::new(Core::Hull(hull), radius))
            .map(Shape::from),
        "cover" => {
            let cuboid = cuboid(&name, core, 5)?;
            let (level, split) = (core.get_item(3)?, core.get_item(4)?);
            let level = crate::convert::whole(&format!("{name}, level"), &level, 0, 3)?;
            let split = match split.extract::<String>().as_deref() {
                Ok("equal") => Split::Equal,
                Ok("near-cubic") => Split::NearCubic,
                _ => {
                    let expected = "'equal' or 'near-cubic'";
                    return Err(errors::value(&format!("{name}, split"), &split, expected));
                }
            };
            cuboid.and_then(|cuboid| Shape::cover(cuboid, level as usize, split, radius))
        }
        _ => return Err(errors::unknown_name(py, "body", kind, &KINDS)),
    };
    made.map_err(|error| of_row(py, "cores", i, error))
}

/// The box that the first three of so many entries are.
fn cuboid(name: &str, core: &Bound<'_, PyAny>, entries: usize) -> PyResult<agrik::Result<Cuboid>> {
    let expected = match entries {
        3 => "a tuple (centre, half, rotation)",
        _ => "a tuple (centre, half, rotation, level, split)",
    };
    if core.len().ok() != Some(entries) {
        return Err(errors::value(name, core, expected));
    }
    let three = |at: usize, what: &str| {
        let mut values = [0.0; 3];
        let given = core.get_item(at)?;
        values
            .copy_from_slice(Floats::of_shape(&format!("{name}, {what}"), &given, &[3])?.values()?);
        Ok::<_, PyErr>(values)
    };
    let turn = Floats::of_shape(&format!("{name}, rotation"), &core.get_item(2)?, &[3, 3])?;
    let mut rows = [[0.0; 3]; 3];
    rows.copy_from_slice(turn.values()?.as_chunks().0);
    Ok(Cuboid::new(three(0, "centre")?, three(1, "half")?, rows))
}

/// A pair of exemptions with a place: (pairs, target, radius).
pub fn touch(value: &Bound<'_, PyAny>) -> PyResult<agrik_motion::Touch> {
    let refuse = || errors::value("touch", value, "a tuple (pairs, target, radius)");
    if value.len().ok() != Some(3) {
        return Err(refuse());
    }
    let pairs: Vec<(usize, usize)> = value.get_item(0)?.extract().map_err(|_| refuse())?;
    let mut target = [0.0; 3];
    let given = Floats::of_shape("touch target", &value.get_item(1)?, &[3])?;
    target.copy_from_slice(given.values()?);
    let radius = real("touch radius", &value.get_item(2)?)?;
    Ok(agrik_motion::Touch { pairs, target, radius })
}
