//! Population solvers: from an object of `agrik_fast.solvers` to the core's settings, and
//! back for the defaults.

use agrik::solve::population::{
    Adaptation, Algorithm, Boundary, Mutation, Orientation, Redraw, Settings,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::solver::{read, write};
use crate::errors;

/// A choice that Python makes by a word.
type Words<T, const N: usize> = [(&'static str, T); N];

const MUTATIONS: Words<Mutation, 3> = [
    ("best1", Mutation::Best1),
    ("rand1", Mutation::Rand1),
    ("current-to-best1", Mutation::CurrentToBest1),
];
const ADAPTATIONS: Words<Adaptation, 3> =
    [("none", Adaptation::None), ("jde", Adaptation::Jde), ("lshade", Adaptation::LShade)];
const REDRAWS: Words<Redraw, 3> = [
    ("gene", Redraw::Gene),
    ("individual", Redraw::Individual),
    ("generation", Redraw::Generation),
];
const BOUNDARIES: Words<Boundary, 4> = [
    ("median", Boundary::Median),
    ("clamp", Boundary::Clamp),
    ("reflect", Boundary::Reflect),
    ("redraw", Boundary::Redraw),
];
const ORIENTATIONS: Words<Orientation, 2> =
    [("rotation-vector", Orientation::RotationVector), ("euler-zyz", Orientation::EulerZyz)];

/// The fields of a solver object.
struct Fields<'a, 'py>(&'a Bound<'py, PyAny>);

impl Fields<'_, '_> {
    fn word<T: Copy, const N: usize>(&self, name: &str, known: &Words<T, N>) -> PyResult<T> {
        let value = self.0.getattr(name)?;
        let word: String = value
            .extract()
            .map_err(|_| errors::value(name, &value, &format!("one of {}", listed(known))))?;
        match known.iter().find(|(known, _)| *known == word) {
            Some((_, meaning)) => Ok(*meaning),
            None => {
                let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
                Err(errors::unknown_name(value.py(), name, &word, &names))
            }
        }
    }
}

fn listed<T, const N: usize>(known: &Words<T, N>) -> String {
    known.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
}

/// Settings from an object with the fields of the solver `name`; a bare name means the
/// defaults.
pub fn settings(solver: &Bound<'_, PyAny>, defaults: Settings) -> PyResult<Settings> {
    let from = Fields(solver);
    let mut settings = defaults;
    match &mut settings.algorithm {
        Algorithm::Differential(it) => {
            let crossover = solver.getattr("crossover")?;
            it.crossover = crossover
                .extract()
                .map_err(|_| errors::value("crossover", &crossover, "two numbers"))?;
            it.mutation = from.word("mutation", &MUTATIONS)?;
            it.adaptation = from.word("adaptation", &ADAPTATIONS)?;
            it.redraw = from.word("redraw", &REDRAWS)?;
            it.boundary = from.word("boundary", &BOUNDARIES)?;
        }
        Algorithm::Genetic(it) => it.boundary = from.word("boundary", &BOUNDARIES)?,
    }
    settings.orientation = from.word("orientation", &ORIENTATIONS)?;
    settings.polish = solver.getattr("polish")?.is_truthy()?;
    let weighted = !solver.getattr("orientation_weight")?.is_none();
    settings.orientation_weight = weighted.then_some(0.0);
    read(solver, settings.fields())?;
    Ok(settings)
}

fn word_of<T: Copy + PartialEq, const N: usize>(known: &Words<T, N>, value: T) -> &'static str {
    known.iter().find(|(_, meaning)| *meaning == value).map_or("", |(name, _)| name)
}

/// The fields of a population solver with their defaults.
pub fn fields<'py>(py: Python<'py>, settings: &Settings) -> PyResult<Bound<'py, PyDict>> {
    let fields = PyDict::new(py);
    match &settings.algorithm {
        Algorithm::Differential(it) => {
            fields.set_item("mutation", word_of(&MUTATIONS, it.mutation))?;
            fields.set_item("adaptation", word_of(&ADAPTATIONS, it.adaptation))?;
            fields.set_item("crossover", it.crossover)?;
            fields.set_item("redraw", word_of(&REDRAWS, it.redraw))?;
            fields.set_item("boundary", word_of(&BOUNDARIES, it.boundary))?;
        }
        Algorithm::Genetic(it) => {
            fields.set_item("boundary", word_of(&BOUNDARIES, it.boundary))?;
        }
    }
    fields.set_item("orientation", word_of(&ORIENTATIONS, settings.orientation))?;
    fields.set_item("orientation_weight", settings.orientation_weight)?;
    fields.set_item("polish", settings.polish)?;
    let mut numbers = *settings;
    write(&fields, numbers.fields())?;
    Ok(fields)
}
