//! Differential inverse kinematics: joint rates for twists.

use agrik::chain::Chain;
use agrik::solve::Twists;
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use super::second::second;
use super::signals::Signals;
use crate::convert::{Floats, array};
use crate::threads as pool;

/// Joint values and twists, or least and most rates.
type Pair<'a, 'py> = (&'a Bound<'py, PyAny>, &'a Bound<'py, PyAny>);

/// Joint rates for a batch of twists.
pub fn rates<'py>(
    chain: &Chain,
    (q, twists): Pair<'_, 'py>,
    (least, most): Pair<'_, 'py>,
    turns: bool,
    (second_aim, gain): (Option<&Bound<'py, PyAny>>, f64),
    threads: Option<&Bound<'py, PyAny>>,
    py: Python<'py>,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let dof = chain.dof();
    let twists = Floats::new("twist", twists)?;
    let rows = twists.values()?.len() / 6;
    let q = Floats::of_shape("q", q, &[rows, dof])?;
    let least = Floats::of_shape("least", least, &[rows, dof])?;
    let most = Floats::of_shape("most", most, &[rows, dof])?;
    let second = second(chain, second_aim)?;
    let call = Twists {
        chain,
        q: q.values()?,
        twists: twists.values()?.as_chunks().0,
        turns,
        least: least.values()?,
        most: most.values()?,
        second: second.as_ref().map(|second| (second, gain)),
    };
    let threads = pool::number(threads, "threads")?;
    let mut signals = Signals::new();
    match py.detach(|| call.rates(threads, &mut || signals.go_on_detached())) {
        Ok(rates) => array(py, &[rows, dof], rates),
        Err(error) => Err(signals.exception(py, error)),
    }
}
