//! The class `Scene`.

use std::sync::Arc;

use agrik_solids::{Cloud, Core, Cuboid, HalfSpace, Hull, Object, Solid};
use pyo3::prelude::*;

use super::rows::{Rows, labels, of_row};
use crate::convert::Floats;
use crate::errors;

/// Objects in the base frame of an arm, ready for questions; holds no arm.
#[pyclass(frozen, module = "agrik_fast._native")]
pub struct Scene(Arc<agrik_solids::Scene>);

impl Scene {
    pub fn core(&self) -> Arc<agrik_solids::Scene> {
        Arc::clone(&self.0)
    }
}

/// Points of a hull, or of a body.
pub fn points(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; 3]>> {
    let floats = Floats::new(name, value)?;
    if floats.shape() != [3] && (floats.shape().len() != 2 || floats.shape()[1] != 3) {
        return Err(crate::convert::wrong_shape(value.py(), name, floats.shape(), "(k, 3)"));
    }
    Ok(floats.values()?.as_chunks().0.to_vec())
}

#[pymethods]
impl Scene {
    /// Make a scene of objects, each of any number of solids.
    #[new]
    #[pyo3(signature = (
        names, removable=None, *, spheres=None, sphere_labels=None, capsules=None,
        capsule_labels=None, boxes=None, box_labels=None, halfspaces=None, halfspace_labels=None,
        hulls=None, hull_radii=None, hull_labels=None
    ))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        names: Vec<String>,
        removable: Option<Vec<bool>>,
        spheres: Option<&Bound<'_, PyAny>>,
        sphere_labels: Option<&Bound<'_, PyAny>>,
        capsules: Option<&Bound<'_, PyAny>>,
        capsule_labels: Option<&Bound<'_, PyAny>>,
        boxes: Option<&Bound<'_, PyAny>>,
        box_labels: Option<&Bound<'_, PyAny>>,
        halfspaces: Option<&Bound<'_, PyAny>>,
        halfspace_labels: Option<&Bound<'_, PyAny>>,
        hulls: Option<Vec<Bound<'_, PyAny>>>,
        hull_radii: Option<&Bound<'_, PyAny>>,
        hull_labels: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let count = names.len();
        let removable = removable.unwrap_or_else(|| vec![false; count]);
        if removable.len() != count {
            let received = format!("{} entries", removable.len());
            let expected = format!("one for each of {count} names");
            return Err(errors::argument(py, "removable", &received, &expected));
        }
        let named = names.into_iter().zip(removable);
        let mut objects: Vec<Object> =
            named.map(|(name, removable)| Object { removable, ..Object::new(name, "") }).collect();

        let spheres = Rows::<4>::new("spheres", spheres)?;
        let of = labels(py, "sphere_labels", sphere_labels, spheres.rows()?.len(), count)?;
        clouds(spheres.rows()?, &of, &mut objects)
            .map_err(|(row, error)| spheres.error(py, row, error))?;

        let capsules = Rows::<7>::new("capsules", capsules)?;
        let of = labels(py, "capsule_labels", capsule_labels, capsules.rows()?.len(), count)?;
        for (row, ([ax, ay, az, bx, by, bz, r], label)) in
            capsules.rows()?.iter().zip(of).enumerate()
        {
            let solid = Solid::capsule([*ax, *ay, *az], [*bx, *by, *bz], *r);
            objects[label].solids.push(solid.map_err(|error| capsules.error(py, row, error))?);
        }

        let boxes = Rows::<16>::new("boxes", boxes)?;
        let of = labels(py, "box_labels", box_labels, boxes.rows()?.len(), count)?;
        for (row, (values, label)) in boxes.rows()?.iter().zip(of).enumerate() {
            let [three, half, x, y, z] =
                [0, 3, 6, 9, 12].map(|k| [values[k], values[k + 1], values[k + 2]]);
            let solid = Cuboid::new(three, half, [x, y, z])
                .and_then(|cuboid| Solid::new(Core::Cuboid(cuboid), values[15]));
            objects[label].solids.push(solid.map_err(|error| boxes.error(py, row, error))?);
        }

        let halfspaces = Rows::<4>::new("halfspaces", halfspaces)?;
        let of = labels(py, "halfspace_labels", halfspace_labels, halfspaces.rows()?.len(), count)?;
        for (row, ([x, y, z, d], label)) in halfspaces.rows()?.iter().zip(of).enumerate() {
            let solid = HalfSpace::new([*x, *y, *z], *d);
            let solid = solid.map_err(|error| halfspaces.error(py, row, error))?;
            objects[label].solids.push(solid.into());
        }

        let hulls = hulls.unwrap_or_default();
        let of = labels(py, "hull_labels", hull_labels, hulls.len(), count)?;
        let radii = match hull_radii {
            Some(radii) => {
                Floats::of_shape("hull_radii", radii, &[hulls.len()])?.values()?.to_vec()
            }
            None => vec![0.0; hulls.len()],
        };
        for (row, ((hull, radius), label)) in hulls.iter().zip(radii).zip(of).enumerate() {
            let solid = Hull::new(points(&format!("hulls[{row}]"), hull)?)
                .and_then(|hull| Solid::new(Core::Hull(hull), radius));
            let solid = solid.map_err(|error| of_row(py, "hulls", row, error))?;
            objects[label].solids.push(solid);
        }
        let made = py.detach(|| agrik_solids::Scene::new(objects));
        Ok(Self(Arc::new(made.map_err(|error| errors::from_core(py, error))?)))
    }

    /// Names of the objects.
    #[getter]
    fn names(&self) -> Vec<&str> {
        self.0.objects().iter().map(|object| object.name.as_str()).collect()
    }

    /// Which objects may be taken out of the way.
    #[getter]
    fn removable(&self) -> Vec<bool> {
        self.0.objects().iter().map(|object| object.removable).collect()
    }

    /// Return the number of objects.
    fn __len__(&self) -> usize {
        self.0.objects().len()
    }
}

/// Puts spheres into the clouds of their objects; an error comes with the row at fault.
fn clouds(
    rows: &[[f64; 4]],
    labels: &[usize],
    objects: &mut [Object],
) -> Result<(), (usize, agrik::Error)> {
    let mut counts = vec![0; objects.len()];
    labels.iter().for_each(|label| counts[*label] += 1);
    let mut of: Vec<Vec<[f64; 4]>> = counts.into_iter().map(Vec::with_capacity).collect();
    for (row, label) in rows.iter().zip(labels) {
        of[*label].push(*row);
    }
    for (label, (object, spheres)) in objects.iter_mut().zip(of).enumerate() {
        if spheres.is_empty() {
            continue;
        }
        match Cloud::of(spheres) {
            Ok(cloud) => object.clouds.push(cloud),
            // Which row it was is looked for only now.
            Err(error) => {
                let faulty =
                    |(row, of): &(usize, &usize)| **of == label && Cloud::of([rows[*row]]).is_err();
                let row = labels.iter().enumerate().find(faulty).map_or(0, |(row, _)| row);
                return Err((row, Cloud::of([rows[row]]).err().unwrap_or(error)));
            }
        }
    }
    Ok(())
}
