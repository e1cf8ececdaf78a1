//! Tasks: from nothing, a name or an object of `agrik_fast.tasks` to the core's task.

use agrik::task::{MaskFrame, Task, unit};
use pyo3::prelude::*;
use pyo3::types::PyString;

use crate::convert::Floats;
use crate::errors;

/// A task, and the one direction that all targets of an axis task share, if they do.
#[derive(Debug, Clone, Copy)]
pub struct Wanted {
    pub task: Task,
    pub direction: Option<[f64; 3]>,
}

impl From<Task> for Wanted {
    fn from(task: Task) -> Self {
        Self { task, direction: None }
    }
}

/// The task meant by nothing (inferred from the kind of targets), a name or an object
/// with the fields of that task.
pub fn wanted(task: Option<&Bound<'_, PyAny>>, targets_are_poses: bool) -> PyResult<Wanted> {
    let Some(task) = task else {
        let task = if targets_are_poses { Task::Pose } else { Task::Position };
        return Ok(task.into());
    };
    if let Ok(name) = task.cast::<PyString>() {
        return match &*name.to_string_lossy() {
            "position" => Ok(Task::Position.into()),
            "pose" => Ok(Task::Pose.into()),
            "axis" => Ok(Task::Axis { tool_axis: [0.0, 0.0, 1.0] }.into()),
            other => {
                Err(errors::unknown_name(task.py(), "task", other, &["position", "pose", "axis"]))
            }
        };
    }
    let expected = "a task of agrik_fast.tasks, with all its fields";
    errors::whole_object("task", task, expected, of_object(task))
}

/// The task with the fields of an object.
fn of_object(task: &Bound<'_, PyAny>) -> PyResult<Wanted> {
    let refuse = || {
        let expected = "a task of agrik_fast.tasks or one of position, pose, axis, position-first";
        errors::value("task", task, expected)
    };
    let name: String =
        task.getattr("name").and_then(|name| name.extract()).map_err(|_| refuse())?;
    match name.as_str() {
        "position" => Ok(Task::Position.into()),
        "pose" => Ok(Task::Pose.into()),
        "position-first" => Ok(Task::PositionFirst.into()),
        "axis" => {
            let given = task.getattr("direction")?;
            let direction =
                if given.is_none() { None } else { Some(direction("direction", &given)?) };
            let tool_axis = direction_of(task, "tool_axis")?;
            Ok(Wanted { task: Task::Axis { tool_axis }, direction })
        }
        "masked" => {
            let mut weights = [0.0; 6];
            let given = Floats::of_shape("weights", &task.getattr("weights")?, &[6])?;
            weights.copy_from_slice(given.values()?);
            let frame = frame("frame", &task.getattr("frame")?)?;
            Ok(Task::Masked { weights, frame }.into())
        }
        _ => Err(refuse()),
    }
}

/// A frame by its name.
pub fn frame(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<MaskFrame> {
    let given = value.extract::<String>();
    let named = |frame: &MaskFrame| given.as_deref().is_ok_and(|name| name == frame.name());
    let known = [MaskFrame::Base, MaskFrame::Tool];
    let found = known.into_iter().find(named);
    found.ok_or_else(|| errors::value(argument, value, "'base' or 'tool'"))
}

fn direction_of(task: &Bound<'_, PyAny>, field: &str) -> PyResult<[f64; 3]> {
    direction(field, &task.getattr(field)?)
}

/// A direction, made unit length.
fn direction(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<[f64; 3]> {
    let given = Floats::of_shape(argument, value, &[3])?;
    let mut v = [0.0; 3];
    v.copy_from_slice(given.values()?);
    unit(v).ok_or_else(|| errors::value(argument, value, "a finite direction of non-zero length"))
}
