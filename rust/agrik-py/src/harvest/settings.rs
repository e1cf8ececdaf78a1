//! The settings of the two-step method, from a dict of names and numbers.

use agrik_motion::harvest::Settings;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict};

use crate::convert::{real, whole};
use crate::errors;

/// Names of all settings.
const NAMES: [&str; 15] = [
    "angles",
    "range",
    "slides",
    "min_distance",
    "min_freedom",
    "enough",
    "distance_weight",
    "freedom_weight",
    "recovery",
    "spread",
    "most_angles",
    "tilt",
    "shift",
    "refine",
    "time_limit",
];

/// Reads settings; those left out are the default.
pub fn read(given: Option<&Bound<'_, PyDict>>) -> PyResult<Settings> {
    let mut to = Settings::default();
    for (name, value) in given.into_iter().flatten() {
        let text: String = name.extract()?;
        let count = || Ok::<_, PyErr>(whole(&text, &value, 1, 100_000)? as usize);
        let flag = || {
            let flag = value.cast::<PyBool>().map(|flag| flag.is_true());
            flag.map_err(|_| errors::value(&text, &value, "True or False"))
        };
        match text.as_str() {
            "angles" => to.angles = count()?,
            "range" => to.range = real(&text, &value)?,
            "slides" => to.slides = count()?,
            "min_distance" => to.min_distance = real(&text, &value)?,
            "min_freedom" => to.min_freedom = real(&text, &value)?,
            "enough" => to.enough = real(&text, &value)?,
            "distance_weight" => to.distance_weight = real(&text, &value)?,
            "freedom_weight" => to.freedom_weight = real(&text, &value)?,
            "recovery" => to.recovery = flag()?,
            "spread" => to.spread = real(&text, &value)?,
            "most_angles" => to.most_angles = count()?,
            "tilt" => to.tilt = real(&text, &value)?,
            "shift" => to.shift = real(&text, &value)?,
            "refine" => to.refine = flag()?,
            "time_limit" if value.is_none() => to.time_limit = None,
            "time_limit" => to.time_limit = Some(real(&text, &value)?),
            _ => return Err(errors::unknown_name(value.py(), "setting", &text, &NAMES)),
        }
    }
    to.check().map_err(|error| match given {
        Some(given) => errors::from_core(given.py(), error),
        None => crate::convert::internal(error),
    })?;
    Ok(to)
}
