//! What ways keep and how they are looked for, from a dict of names and numbers.

use agrik_motion::edges::{Keep, OWN_CLEAR};
use agrik_motion::planners::Settings;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict};

use crate::convert::{real, whole};
use crate::errors;

/// Names of all settings.
const NAMES: [&str; 14] = [
    "clear",
    "own_clear",
    "cap",
    "tolerance",
    "max_checks",
    "n_goals",
    "step",
    "rounds",
    "shortcuts",
    "retreats",
    "prove",
    "seed",
    "time_limit",
    "segment_checks",
];

/// Reads settings; those left out, and those that are None, are the default.
pub fn read(given: &Bound<'_, PyDict>) -> PyResult<Settings> {
    let mut to = Settings::default();
    let most = u64::from(u32::MAX);
    let (mut own, mut cap) = (None, None);
    for (name, value) in given {
        let text: String = name.extract()?;
        if !NAMES.contains(&text.as_str()) {
            return Err(errors::unknown_name(value.py(), "setting", &text, &NAMES));
        }
        if value.is_none() {
            continue;
        }
        let flag = || {
            let flag = value.cast::<PyBool>().map(|flag| flag.is_true());
            flag.map_err(|_| errors::value(&text, &value, "True or False"))
        };
        match text.as_str() {
            "clear" => to.keep.clear = real(&text, &value)?,
            "own_clear" => own = Some(real(&text, &value)?),
            "cap" => cap = Some(real(&text, &value)?),
            "tolerance" => to.keep.tolerance = real(&text, &value)?,
            "segment_checks" => to.keep.max_checks = whole(&text, &value, 1, most)? as u32,
            "max_checks" => to.max_checks = whole(&text, &value, 1, u64::MAX)?,
            "n_goals" => to.goals = whole(&text, &value, 1, most)? as usize,
            "step" => to.step = real(&text, &value)?,
            "rounds" => to.rounds = whole(&text, &value, 0, most)? as u32,
            "shortcuts" => to.shortcuts = whole(&text, &value, 0, most)? as u32,
            "retreats" => to.retreats = flag()?,
            "prove" => to.prove = flag()?,
            "seed" => to.seed = whole(&text, &value, 0, u64::MAX)?,
            _ => to.time_limit = Some(real(&text, &value)?),
        }
    }
    // What was not said follows what is kept from the scene.
    let Keep { clear, .. } = to.keep;
    to.keep.own = own.unwrap_or(clear.min(OWN_CLEAR));
    to.keep.cap = cap.unwrap_or(to.keep.cap.max(clear));
    to.check().map_err(|error| errors::from_core(given.py(), error))?;
    Ok(to)
}
