//! Joints that a call keeps at given values, by name.

use agrik::chain::Chain;
use agrik::closed_form::{Lock, Values};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFloat};

use super::arguments::spread;
use crate::convert::Floats;
use crate::errors;

/// Values of one joint as they came: one for all targets, or one a target.
enum Given<'py> {
    One(f64),
    Each(Floats<'py>),
}

/// The argument `locked`.
pub struct Locked<'py>(Vec<(usize, Given<'py>)>);

impl<'py> Locked<'py> {
    pub fn new(
        locked: Option<&Bound<'py, PyAny>>,
        chain: &Chain,
        leading: &[usize],
    ) -> PyResult<Self> {
        let Some(locked) = locked else { return Ok(Self(Vec::new())) };
        let py = locked.py();
        let Ok(named) = locked.cast::<PyDict>() else {
            let expected = "a dict of joint names and values, such as {\"d1\": 0.5}";
            return Err(errors::value("locked", locked, expected));
        };
        let mut all = Vec::with_capacity(named.len());
        for (name, value) in named.iter() {
            let text: Option<String> = name.extract().ok();
            let variables = chain.variables();
            let at = text.as_ref().and_then(|text| variables.iter().position(|v| v.name == *text));
            let Some(variable) = at else {
                let names: Vec<&str> = variables.iter().map(|v| v.name.as_str()).collect();
                let name = text.map_or_else(|| Ok(name.repr()?.to_string()), PyResult::Ok)?;
                return Err(errors::unknown_name(py, "joint", &name, &names));
            };
            let given = match value.cast_exact::<PyFloat>() {
                Ok(value) => Given::One(value.value()),
                Err(_) => Given::Each(spread("locked", &value, leading)?),
            };
            all.push((variable, given));
        }
        Ok(Self(all))
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub fn locks(&self) -> PyResult<Vec<Lock<'_>>> {
        let mut locks = Vec::with_capacity(self.0.len());
        for (variable, given) in &self.0 {
            let values = match given {
                Given::One(value) => Values::One(*value),
                Given::Each(all) => Values::Each(all.values()?),
            };
            locks.push(Lock { variable: *variable, values });
        }
        Ok(locks)
    }
}
