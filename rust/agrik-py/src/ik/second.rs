//! Second aims and nearness: from words and objects of Python to the core's.

use agrik::call::{Merit, Second};
use agrik::chain::Chain;
use agrik::nearest::Nearness;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyString};

use crate::convert::{self, Floats};
use crate::errors;

/// Most starts of a nearest answer.
const MOST_STARTS: u64 = 100_000;

/// The second aim meant by nothing, a name or an object of `agrik_fast.tasks`.
pub fn second(chain: &Chain, value: Option<&Bound<'_, PyAny>>) -> PyResult<Option<Second>> {
    let Some(value) = value else { return Ok(None) };
    let py = value.py();
    if value.is_instance_of::<PyString>() {
        let merit = convert::word("second_aim", value, &Merit::ALL)?;
        return made(py, Second::new(chain, merit, None, None)).map(Some);
    }
    let expected = "a name or a SecondAim of agrik_fast.tasks, with all its fields";
    errors::whole_object("second_aim", value, expected, of_object(chain, value)).map(Some)
}

fn of_object(chain: &Chain, value: &Bound<'_, PyAny>) -> PyResult<Second> {
    let py = value.py();
    let measure = value.getattr("measure").and_then(|name| Ok(name.cast_into::<PyString>()?));
    let measure = measure.map_err(|_| {
        let expected = "a SecondAim of agrik_fast.tasks or one of near, middle, limits, \
                        manipulability";
        errors::value("second_aim", value, expected)
    })?;
    let merit = convert::word("second_aim", &measure, &Merit::ALL)?;
    let posture = numbers(chain, "posture", &value.getattr("posture")?)?;
    let weights = numbers(chain, "weights", &value.getattr("weights")?)?;
    made(py, Second::new(chain, merit, posture, weights))
}

fn made(py: Python<'_>, second: agrik::Result<Second>) -> PyResult<Second> {
    second.map_err(|error| errors::from_core(py, error))
}

/// Numbers of an argument, one a joint, if it is given.
fn numbers(chain: &Chain, argument: &str, value: &Bound<'_, PyAny>) -> PyResult<Option<Vec<f64>>> {
    if value.is_none() {
        return Ok(None);
    }
    Ok(Some(Floats::of_shape(argument, value, &[chain.dof()])?.values()?.to_vec()))
}

/// How near answers are asked for: `nearest` is a truth value, or a number of starts.
pub fn nearness(
    py: Python<'_>,
    chain: &Chain,
    nearest: Option<&Bound<'_, PyAny>>,
    weights: Option<&Bound<'_, PyAny>>,
) -> PyResult<Option<Nearness>> {
    let starts = match nearest.map(|value| (value, value.cast::<PyBool>())) {
        None => None,
        Some((_, Ok(truth))) => truth.is_true().then_some(None),
        Some((value, Err(_))) => {
            Some(Some(convert::whole("nearest", value, 1, MOST_STARTS)? as usize))
        }
    };
    let weights = match weights {
        Some(weights) => numbers(chain, "joint_weights", weights)?,
        None => None,
    };
    match (starts, weights) {
        (None, None) => Ok(None),
        (None, Some(_)) => {
            Err(errors::argument(py, "joint_weights", "numbers", "none without nearest=True"))
        }
        (Some(starts), weights) => Nearness::new(chain, weights, starts)
            .map(Some)
            .map_err(|error| errors::from_core(py, error)),
    }
}
