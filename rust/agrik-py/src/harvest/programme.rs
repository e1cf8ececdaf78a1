//! The class `HarvestProgramme`: the non-linear programme of one target.

use agrik::solve::population::{Algorithm, Settings as Search};
use agrik_motion::harvest::{
    DIFFERENTIAL, GENETIC, Programme, Surroundings, Target, Terms, Weights,
};
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::station::{mode, put, roles};
use crate::collision::bodies::Bodies;
use crate::collision::scene::Scene;
use crate::convert::{array, real, whole};
use crate::ik::signals::Signals;
use crate::robot::kinematics::JointValues;
use crate::{errors, threads};

/// A target for an arm with bodies in a crop, and what a posture costs.
#[pyclass(frozen, module = "agrik_fast._native")]
pub struct HarvestProgramme {
    around: Surroundings,
    target: Target,
    weights: Weights,
}

impl HarvestProgramme {
    fn core(&self, py: Python<'_>) -> PyResult<Programme<'_>> {
        Programme::new(&self.around, &self.target, self.weights)
            .map_err(|error| errors::from_core(py, error))
    }
}

#[pymethods]
impl HarvestProgramme {
    /// Put an arm with bodies into a crop, with a target; weights are position, orientation
    /// and distance, then the distance that is enough, m.
    #[new]
    #[pyo3(signature = (
        bodies, scene, statics, static_skip, touching, point, objects, weights, level=None,
        split=None
    ))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        bodies: &Bound<'_, Bodies>,
        scene: &Bound<'_, Scene>,
        statics: Vec<usize>,
        static_skip: Vec<(usize, usize)>,
        touching: Vec<usize>,
        point: [f64; 3],
        objects: Vec<usize>,
        weights: [f64; 4],
        level: Option<&Bound<'_, PyAny>>,
        split: Option<&str>,
    ) -> PyResult<Self> {
        let (bodies, scene) = (bodies.get().core(), scene.get().core());
        let roles = roles(statics, static_skip, touching);
        let around = Surroundings::new(bodies, scene, &roles, mode(py, level, split)?)
            .map_err(|error| errors::from_core(py, error))?;
        let [position, orientation, distance, enough] = weights;
        let weights = Weights { position, orientation, distance, enough };
        let made = Self { around, target: Target { name: String::new(), point, objects }, weights };
        made.core(py)?;
        Ok(made)
    }

    /// The terms of the cost at joint values, shape (..., dof).
    fn terms<'py>(&self, q: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
        let py = q.py();
        let dof = self.around.chain().dof();
        let q = JointValues::new(q, dof)?;
        let programme = self.core(py)?;
        let each = q.values()?.chunks(dof).map(|q| programme.terms(q));
        let all: Vec<Terms> =
            each.collect::<Result<_, _>>().map_err(|error| errors::from_core(py, error))?;
        columns(py, &q.shape_with(&[]), &all)
    }

    /// Search from seeds by "ga" or "de", with options by name.
    #[pyo3(signature = (algorithm, seeds, options=None, threads=None))]
    fn search<'py>(
        &self,
        py: Python<'py>,
        algorithm: &str,
        seeds: Vec<u64>,
        options: Option<&Bound<'py, PyDict>>,
        threads: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let mut settings = match algorithm {
            "ga" => GENETIC,
            "de" => DIFFERENTIAL,
            _ => return Err(errors::unknown_name(py, "algorithm", algorithm, &["ga", "de"])),
        };
        for (name, value) in options.into_iter().flatten() {
            set(&mut settings, &name.extract::<String>()?, &value)?;
        }
        let threads = threads::number(threads, "threads")?;
        let programme = self.core(py)?;
        let mut signals = Signals::new();
        let runs = py.detach(|| {
            programme.searches(&settings, &seeds, threads, &mut || signals.go_on_detached())
        });
        let runs = runs.map_err(|error| signals.exception(py, error))?;
        let terms: Vec<Terms> = runs.iter().map(|run| run.terms).collect();
        let out = columns(py, &[runs.len()], &terms)?;
        let dof = self.around.chain().dof();
        let q: Vec<f64> = runs.iter().flat_map(|run| run.q.iter().copied()).collect();
        out.set_item("q", array(py, &[runs.len(), dof], q)?)?;
        put(py, &out, "generations", &runs, |run| i64::from(run.generations))?;
        put(py, &out, "evaluations", &runs, |run| run.evaluations as i64)?;
        let history: Vec<Bound<'_, PyArrayDyn<f64>>> = runs
            .iter()
            .map(|run| array(py, &[run.history.len()], run.history.clone()))
            .collect::<PyResult<_>>()?;
        out.set_item("history", history)?;
        Ok(out)
    }
}

/// One of the terms.
type Of = fn(&Terms) -> f64;

/// Terms as columns.
fn columns<'py>(py: Python<'py>, shape: &[usize], all: &[Terms]) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    let of: [(&str, Of); 5] = [
        ("cost", |terms| terms.cost),
        ("position", |terms| terms.position),
        ("orientation", |terms| terms.orientation),
        ("nearness", |terms| terms.nearness),
        ("distance", |terms| terms.distance),
    ];
    for (name, of) in of {
        out.set_item(name, array(py, shape, all.iter().map(of).collect())?)?;
    }
    Ok(out)
}

/// Sets one option of a search by its name.
fn set(to: &mut Search, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
    let count = || Ok::<_, PyErr>(whole(name, value, 0, u64::from(u32::MAX))? as u32);
    match (name, &mut to.algorithm) {
        ("population", _) => to.population = count()?,
        ("generations", _) => to.generations = count()?,
        ("target_cost", _) => to.target_cost = real(name, value)?,
        ("stagnation", _) => to.stagnation = count()?,
        ("tournament", Algorithm::Genetic(it)) => it.tournament = count()?,
        ("elites", Algorithm::Genetic(it)) => it.elites = count()?,
        ("crossover_rate", Algorithm::Genetic(it)) => it.crossover_rate = real(name, value)?,
        ("crossover_index", Algorithm::Genetic(it)) => it.crossover_index = real(name, value)?,
        ("mutation_rate", Algorithm::Genetic(it)) => it.mutation_rate = real(name, value)?,
        ("mutation_width", Algorithm::Genetic(it)) => it.mutation_width = real(name, value)?,
        ("mutation_end", Algorithm::Genetic(it)) => it.mutation_end = real(name, value)?,
        ("weight", Algorithm::Differential(it)) => it.weight = real(name, value)?,
        ("dither", Algorithm::Differential(it)) => it.dither = real(name, value)?,
        ("crossover_rate", Algorithm::Differential(it)) => {
            let rate = real(name, value)?;
            it.crossover = (rate, rate);
        }
        (_, Algorithm::Genetic(_)) => return Err(unknown(value.py(), name, &GENETIC_OPTIONS)),
        _ => return Err(unknown(value.py(), name, &DIFFERENTIAL_OPTIONS)),
    }
    to.check().map_err(|error| errors::from_core(value.py(), error))
}

const GENETIC_OPTIONS: [&str; 11] = [
    "population",
    "generations",
    "target_cost",
    "stagnation",
    "tournament",
    "elites",
    "crossover_rate",
    "crossover_index",
    "mutation_rate",
    "mutation_width",
    "mutation_end",
];
const DIFFERENTIAL_OPTIONS: [&str; 7] = [
    "population",
    "generations",
    "target_cost",
    "stagnation",
    "weight",
    "dither",
    "crossover_rate",
];

fn unknown(py: Python<'_>, name: &str, known: &[&str]) -> PyErr {
    errors::unknown_name(py, "option", name, known)
}
