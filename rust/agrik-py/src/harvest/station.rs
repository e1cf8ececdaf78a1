//! The class `HarvestStation`: decisions as columns of numbers.

use std::sync::Arc;

use agrik_motion::harvest::{
    self, DOF, Decision, Mode, Roles, Row, Settings, Stage, Status, Target, plan, plan_blockers,
};
use agrik_solids::Split;
use pyo3::IntoPyObject;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::settings;
use crate::collision::bodies::Bodies;
use crate::collision::scene::Scene;
use crate::convert::{Floats, array, real, whole, wrong_shape};
use crate::ik::signals::Signals;
use crate::motion::check::posture;
use crate::motion::plan::planned;
use crate::motion::settings::read as motion_settings;
use crate::{errors, threads};

/// An arm on a slide, with bodies, in a crop.
#[pyclass(frozen, module = "agrik_fast._native")]
pub struct HarvestStation(harvest::Station);

/// Objects in the way, whether no smaller set does, and the posture's row.
type Blocking<'py> = (Vec<usize>, bool, Bound<'py, PyDict>);

/// Targets as they came: points, and the objects of each.
fn targets(
    points: &Bound<'_, PyAny>,
    objects: Vec<Vec<usize>>,
    names: Vec<String>,
) -> PyResult<Vec<Target>> {
    let floats = Floats::new("points", points)?;
    let count = objects.len();
    if floats.shape() != [count, 3] || names.len() != count {
        return Err(wrong_shape(points.py(), "points", floats.shape(), &format!("({count}, 3)")));
    }
    let points: &[[f64; 3]] = floats.values()?.as_chunks().0;
    let each = points.iter().zip(objects).zip(names);
    Ok(each.map(|((point, objects), name)| Target { name, point: *point, objects }).collect())
}

/// How bodies meet the crop: as they are without a level.
pub fn mode(
    py: Python<'_>,
    level: Option<&Bound<'_, PyAny>>,
    split: Option<&str>,
) -> PyResult<Mode> {
    let Some(level) = level else { return Ok(Mode::Exact) };
    let level = whole("level", level, 0, 3)? as usize;
    let split = match split {
        None | Some("equal") => Split::Equal,
        Some("near-cubic") => Split::NearCubic,
        Some(other) => {
            return Err(errors::unknown_name(py, "split", other, &["equal", "near-cubic"]));
        }
    };
    Ok(Mode::Tree { level, split })
}

/// What of a scene is crop, and who minds what.
pub fn roles(statics: Vec<usize>, skip: Vec<(usize, usize)>, touching: Vec<usize>) -> Roles {
    Roles { statics, skip, touching, moved: [0.0; 3] }
}

#[pymethods]
impl HarvestStation {
    /// Put an arm with bodies into a crop.
    #[new]
    #[pyo3(signature = (
        bodies, scene, statics, static_skip, touching, level=None, split=None, moved=None
    ))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        bodies: &Bound<'_, Bodies>,
        scene: &Bound<'_, Scene>,
        statics: Vec<usize>,
        static_skip: Vec<(usize, usize)>,
        touching: Vec<usize>,
        level: Option<&Bound<'_, PyAny>>,
        split: Option<&str>,
        moved: Option<[f64; 3]>,
    ) -> PyResult<Self> {
        let mode = mode(py, level, split)?;
        let roles =
            Roles { moved: moved.unwrap_or_default(), ..roles(statics, static_skip, touching) };
        let (mut bodies, scene) = (bodies.get().core(), scene.get().core());
        if roles.moved != [0.0; 3] {
            let moved = bodies.moved(roles.moved).map_err(|error| errors::from_core(py, error))?;
            bodies = Arc::new(moved);
        }
        harvest::Station::new(bodies, scene, &roles, mode)
            .map(Self)
            .map_err(|error| errors::from_core(py, error))
    }

    /// Decide for targets; with `scan_all` by a scan of everything.
    #[pyo3(signature = (points, objects, names, settings=None, scan_all=false, threads=None))]
    #[allow(clippy::too_many_arguments)]
    fn plan<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
        objects: Vec<Vec<usize>>,
        names: Vec<String>,
        settings: Option<&Bound<'py, PyDict>>,
        scan_all: bool,
        threads: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let targets = targets(points, objects, names)?;
        let settings = settings::read(settings)?;
        let threads = threads::number(threads, "threads")?;
        let mut signals = Signals::new();
        let made = py.detach(|| {
            let mut go = || signals.go_on_detached();
            plan(&self.0, &targets, &settings, scan_all, threads, &mut go)
        });
        let made = made.map_err(|error| signals.exception(py, error))?;
        decisions(py, self, &made)
    }

    /// Decide for targets, and plan the ways from `start` into their postures.
    #[pyo3(signature = (
        points, objects, names, start, motion, touch_radius, settings=None, blockers=true,
        threads=None
    ))]
    #[allow(clippy::too_many_arguments)]
    fn plan_paths<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
        objects: Vec<Vec<usize>>,
        names: Vec<String>,
        start: &Bound<'py, PyAny>,
        motion: &Bound<'py, PyDict>,
        touch_radius: &Bound<'py, PyAny>,
        settings: Option<&Bound<'py, PyDict>>,
        blockers: bool,
        threads: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let targets = targets(points, objects, names)?;
        let settings = settings::read(settings)?;
        let picking = harvest::Picking {
            start: posture("start", start, DOF)?,
            plan: motion_settings(motion)?,
            touch_radius: real("touch_radius", touch_radius)?,
            blockers,
        };
        let threads = threads::number(threads, "threads")?;
        let mut signals = Signals::new();
        let made = py.detach(|| {
            let mut go = || signals.go_on_detached();
            harvest::plan_paths(&self.0, &targets, &settings, &picking, threads, &mut go)
        });
        let made = made.map_err(|error| signals.exception(py, error))?;
        let of_postures: Vec<Decision> = made.iter().map(|one| one.decision.clone()).collect();
        let out = decisions(py, self, &of_postures)?;
        let each = made.iter();
        let paths = each.clone().map(|one| planned(py, &one.path, DOF));
        out.set_item("paths", paths.collect::<PyResult<Vec<_>>>()?)?;
        let goals =
            each.clone().map(|one| array(py, &[one.goals.len() / DOF, DOF], one.goals.clone()));
        out.set_item("goals", goals.collect::<PyResult<Vec<_>>>()?)?;
        let blockers = each.map(|one| {
            let found = one.blockers.as_ref();
            found.map(|found| (found.objects.clone(), found.fewest as u8, found.at_least))
        });
        out.set_item("blockers_path", blockers.collect::<Vec<_>>())?;
        Ok(out)
    }

    /// The fewest removable objects in the way of each target: (objects, proven) or None.
    #[pyo3(signature = (points, objects, names, settings=None, threads=None))]
    fn blockers<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
        objects: Vec<Vec<usize>>,
        names: Vec<String>,
        settings: Option<&Bound<'py, PyDict>>,
        threads: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Vec<Option<Blocking<'py>>>> {
        let targets = targets(points, objects, names)?;
        let settings = settings::read(settings)?;
        let threads = threads::number(threads, "threads")?;
        let mut signals = Signals::new();
        let made = py.detach(|| {
            let mut go = || signals.go_on_detached();
            plan_blockers(&self.0, &targets, &settings, threads, &mut go)
        });
        let made = made.map_err(|error| signals.exception(py, error))?;
        made.into_iter()
            .map(|one| {
                one.map(|one| Ok((one.objects, one.exact, rows(py, self, &[Some(one.row)])?)))
                    .transpose()
            })
            .collect()
    }

    /// The object in which each point lies, if it is none of its own; -1 for none.
    fn inside(&self, points: &Bound<'_, PyAny>, objects: Vec<Vec<usize>>) -> PyResult<Vec<i64>> {
        let names = vec![String::new(); objects.len()];
        let each = targets(points, objects, names)?;
        let scene = self.0.around().scene();
        // A point that is no place is in nothing.
        let inside = |target: &Target| target.inside(scene).ok().flatten();
        Ok(each.iter().map(|target| inside(target).map_or(-1, |index| index as i64)).collect())
    }

    /// All postures of one approach to a target, as rows of a table.
    #[pyo3(signature = (point, objects, psi, tilt=0.0, shift=0.0, settings=None))]
    #[allow(clippy::too_many_arguments)]
    fn table<'py>(
        &self,
        py: Python<'py>,
        point: [f64; 3],
        objects: Vec<usize>,
        psi: f64,
        tilt: f64,
        shift: f64,
        settings: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let settings: Settings = settings::read(settings)?;
        let target = Target { name: String::new(), point, objects };
        let table = harvest::table(&self.0, &target, [psi, tilt, shift], &settings)
            .map_err(|error| errors::from_core(py, error))?;
        let found: Vec<Option<Row>> = table.rows.iter().copied().map(Some).collect();
        rows(py, self, &found)
    }

    /// The scan of approach angles: for each angle whether it is open, and the distances of
    /// the last link's bodies and of the wrist's, m.
    #[pyo3(signature = (point, objects, settings=None))]
    fn approaches<'py>(
        &self,
        py: Python<'py>,
        point: [f64; 3],
        objects: Vec<usize>,
        settings: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let settings = settings::read(settings)?;
        let target = Target { name: String::new(), point, objects };
        let scan = harvest::approaches(&self.0, &target, &settings)
            .map_err(|error| errors::from_core(py, error))?;
        let out = PyDict::new(py);
        put(py, &out, "psi", &scan, |one| one.psi)?;
        put(py, &out, "open", &scan, |one| one.rank.is_some())?;
        put(py, &out, "rank", &scan, |one| one.rank.map_or(-1, |rank| rank as i64))?;
        put(py, &out, "hard", &scan, |one| one.hard)?;
        put(py, &out, "soft", &scan, |one| one.soft)?;
        Ok(out)
    }
}

/// One column of a record.
pub fn put<'py, S, T: numpy::Element + Copy>(
    py: Python<'py>,
    out: &Bound<'py, PyDict>,
    name: &str,
    from: &[S],
    value: impl Fn(&S) -> T,
) -> PyResult<()>
where
    Bound<'py, numpy::PyArrayDyn<T>>: IntoPyObject<'py>,
{
    out.set_item(name, array(py, &[from.len()], from.iter().map(value).collect())?)
}

/// The columns of decisions.
fn decisions<'py>(
    py: Python<'py>,
    station: &HarvestStation,
    made: &[Decision],
) -> PyResult<Bound<'py, PyDict>> {
    let found: Vec<Option<Row>> = made.iter().map(|decision| decision.row).collect();
    let out = rows(py, station, &found)?;
    put(py, &out, "status", made, |decision| decision.status as u8)?;
    put(py, &out, "stage", made, |decision| decision.stage as u8)?;
    put(py, &out, "tilt", made, |decision| decision.tilt)?;
    put(py, &out, "shift", made, |decision| decision.shift)?;
    put(py, &out, "exact_distance", made, |decision| decision.exact)?;
    put(py, &out, "refined", made, |decision| decision.refined)?;
    put(py, &out, "straight", made, |decision| decision.straight)?;
    put(py, &out, "angles", made, |decision| decision.angles as i64)?;
    put(py, &out, "open", made, |decision| decision.open as i64)?;
    put(py, &out, "singular", made, |decision| decision.singular as i64)?;
    out.set_item("attempts", attempts(py, made)?)?;
    Ok(out)
}

/// The columns of rows, zeros and the nearest joint values where there is none.
fn rows<'py>(
    py: Python<'py>,
    station: &HarvestStation,
    all: &[Option<Row>],
) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    let rest: Vec<f64> = station.0.chain().near_zero();
    let q: Vec<f64> =
        all.iter().flat_map(|row| row.map_or_else(|| rest.clone(), |row| row.q.to_vec())).collect();
    out.set_item("q", array(py, &[all.len(), DOF], q)?)?;
    let number = |of: fn(&Row) -> f64| move |row: &Option<Row>| row.as_ref().map_or(0.0, of);
    put(py, &out, "found", all, Option::is_some)?;
    put(py, &out, "psi", all, number(|row| row.psi))?;
    put(py, &out, "slide", all, number(|row| row.slide))?;
    put(py, &out, "branch", all, |row| row.map_or(-1, |row| row.branch as i64))?;
    put(py, &out, "distance", all, number(|row| row.distance))?;
    put(py, &out, "freedom", all, number(|row| row.freedom))?;
    put(py, &out, "score", all, number(|row| row.score))?;
    put(py, &out, "hits_itself", all, |row| row.is_some_and(|row| row.hits_itself))?;
    put(py, &out, "admissible", all, |row| row.is_some_and(|row| row.admissible))?;
    Ok(out)
}

/// All attempts of all targets, one after the other.
fn attempts<'py>(py: Python<'py>, made: &[Decision]) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    let all: Vec<(usize, harvest::Attempt)> = made
        .iter()
        .enumerate()
        .flat_map(|(target, decision)| decision.attempts.iter().map(move |one| (target, *one)))
        .collect();
    put(py, &out, "target", &all, |(target, _)| *target as i64)?;
    put(py, &out, "psi", &all, |(_, one)| one.psi)?;
    put(py, &out, "tilt", &all, |(_, one)| one.tilt)?;
    put(py, &out, "shift", &all, |(_, one)| one.shift)?;
    put(py, &out, "stage", &all, |(_, one)| one.stage as u8)?;
    put(py, &out, "reached", &all, |(_, one)| one.reached as i64)?;
    put(py, &out, "within", &all, |(_, one)| one.within as i64)?;
    put(py, &out, "admissible", &all, |(_, one)| one.admissible as i64)?;
    Ok(out)
}

/// Names of the statuses and of the stages of a decision, at their codes.
#[pyfunction]
pub fn harvest_words() -> (Vec<&'static str>, Vec<&'static str>) {
    (Status::ALL.map(Status::name).to_vec(), Stage::ALL.map(Stage::name).to_vec())
}
