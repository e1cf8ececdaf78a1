//! Gains: matrices with their units and axes, from the fields of a solver object.

use std::sync::Arc;

use agrik::solve::{GainUnits, Matrix, StaticGain};
use pyo3::prelude::*;

use crate::convert::{Floats, real, shape_text};
use crate::errors;

/// A matrix field; the core checks its size against the robot.
pub fn matrix(solver: &Bound<'_, PyAny>, name: &str) -> PyResult<Matrix> {
    let floats = Floats::new(name, &solver.getattr(name)?)?;
    let [_, columns] = *floats.shape() else {
        let received = format!("shape {}", shape_text(floats.shape()));
        return Err(errors::argument(solver.py(), name, &received, "a matrix"));
    };
    Ok(Matrix { columns, values: floats.values()?.to_vec() })
}

/// The units and axes that a solver's gains are written in.
pub fn units(solver: &Bound<'_, PyAny>) -> PyResult<GainUnits> {
    let number = |name: &str| real(name, &solver.getattr(name)?);
    let rows = Floats::of_shape("frame", &solver.getattr("frame")?, &[3, 3])?;
    let mut rotation = [[0.0; 3]; 3];
    rotation.as_flattened_mut().copy_from_slice(rows.values()?);
    let per_radian = solver.getattr("rotation_length_m")?;
    let per_radian = if per_radian.is_none() { None } else { Some(number("rotation_length_m")?) };
    let (length, angle) = (number("length_unit_m")?, number("angle_unit_rad")?);
    Ok(GainUnits { length, angle, rotation, per_radian })
}

/// The matrix of a static gain, if the solver has one.
pub fn static_gain(solver: &Bound<'_, PyAny>) -> PyResult<Option<Arc<StaticGain>>> {
    if solver.getattr("K")?.is_none() {
        return Ok(None);
    }
    Ok(Some(Arc::new(StaticGain { gain: matrix(solver, "K")?, units: units(solver)? })))
}

/// Refuses gains that say they are another robot's.
pub fn check_robot(solver: &Bound<'_, PyAny>, robot: &str) -> PyResult<()> {
    let made_for: Option<String> = solver.getattr("robot")?.extract()?;
    match made_for {
        Some(name) if name != robot => {
            let expected = format!("gains for robot {robot:?}");
            let received = format!("gains for robot {name:?}");
            Err(errors::argument(solver.py(), "solver", &received, &expected))
        }
        _ => Ok(()),
    }
}
