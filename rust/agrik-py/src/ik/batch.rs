//! Calls for batches of any size, a single target included.

use std::sync::Arc;

use agrik::call::{Guard, solve as solve_call};
use agrik::chain::{Chain, DhConvention};
use agrik::closed_form::{self, Ask, Choice, ClosedForm, Query};
use agrik::lanes::Level;
use agrik::solve::population::Evolution;
use agrik::solvers::Solver;
use numpy::{PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;

use super::arguments::{Arguments, ArmAngles, Call};
use super::branches::Branches;
use super::locked::Locked;
use super::second::nearness;
use super::signals::Signals;
use crate::collision::guard;
use crate::convert::{self, Floats};
use crate::errors;
use crate::result::{IkResult, Origin};
use crate::solvers::solver::chosen;

/// Targets from which on all branches are written to an array of NumPy's.
const MANY: usize = 1024;
/// Most values of a sweep.
const MOST_VALUES: u64 = 100_000;

/// How near answers are to be, by which weights, and within which limits of each row.
type Wanted<'a, 'py> =
    (Option<&'a Bound<'py, PyAny>>, Option<&'a Bound<'py, PyAny>>, Option<&'a Bound<'py, PyAny>>);

/// Solves the targets of a call.
pub fn solve(
    py: Python<'_>,
    chain: &Arc<Chain>,
    convention: Option<DhConvention>,
    given: &Arguments<'_, '_>,
    scene: &guard::Given<'_, '_>,
    (nearest, weights, limits): Wanted<'_, '_>,
) -> PyResult<IkResult> {
    let call = Call::new(py, chain, given)?;
    let mut points = Vec::new();
    let scene = guard::Scene::new(py, chain, scene)?;
    let free = scene.as_ref().map(|scene| scene.free(py)).transpose()?;
    let mut request = call.request(py, chain, &mut points)?;
    if let (Some(scene), Some(accept)) = (&scene, &free) {
        request = request.with_guard(Guard { accept, prefer: scene.prefer });
    }
    let solver = chosen(given.solver, chain.name())?;
    let threads = call.options.threads;
    let nearness = nearness(py, chain, nearest, weights)?;
    let limits = limits.map(|limits| {
        let shape = [call.targets.leading_shape(), &[chain.dof(), 2]].concat();
        Floats::of_shape("limits", limits, &shape)
    });
    let limits = limits.transpose()?;
    let ready = match (&nearness, &limits) {
        (None, None) => solver.call(request).map(Some),
        (Some(nearness), None) => solver.nearest_call(request, nearness).map(Some),
        (None, Some(limits)) => solver.limited_call(request, limits.values()?.as_chunks().0),
        (Some(_), Some(_)) => Ok(None),
    };
    let ready = ready.map_err(|error| errors::from_core(py, error))?.ok_or_else(|| {
        let expected = "none, or a solver that takes them, with no wish beside";
        errors::argument(py, "limits", "limits of each row", expected)
    })?;
    let mut signals = Signals::new();
    // A single target takes less time than it takes to let the interpreter go and get it back.
    let answers = if request.len() <= 1 && !matches!(solver, Solver::Population(_)) {
        solve_call(&ready, 1, &mut || signals.go_on_attached(py))
    } else {
        py.detach(|| solve_call(&ready, threads, &mut || signals.go_on_detached()))
    };
    match answers {
        Ok(answers) => {
            let shape = call.targets.leading_shape().to_vec();
            let made = IkResult::new(shape, chain.dof(), answers).with_warnings(call.warnings());
            let made = made.to(Origin {
                chain: Arc::clone(chain),
                convention,
                aim: call.options.aim,
                are_poses: call.targets.are_poses(),
                turns: call.options.direction.is_none(),
            });
            Ok(made.in_scene(scene.as_ref().map(|scene| Arc::clone(&scene.collider))))
        }
        Err(error) => Err(signals.exception(py, error)),
    }
}

/// What `ik_all` is asked besides its targets.
pub struct Wishes<'a, 'py> {
    pub arm_angle: Option<&'a Bound<'py, PyAny>>,
    pub locked: Option<&'a Bound<'py, PyAny>>,
    pub sweep: Option<&'a Bound<'py, PyAny>>,
    pub wrap: bool,
}

/// All branches of the targets of a call.
pub fn solve_all<'py>(
    py: Python<'py>,
    chain: &Chain,
    given: &Arguments<'_, 'py>,
    wishes: &Wishes<'_, 'py>,
) -> PyResult<Branches> {
    let call = Call::new(py, chain, given)?;
    Ok(branches_of(py, chain, &call, wishes)?.with_warnings(call.warnings()))
}

fn branches_of<'py>(
    py: Python<'py>,
    chain: &Chain,
    call: &Call<'py>,
    wishes: &Wishes<'_, 'py>,
) -> PyResult<Branches> {
    let leading = call.targets.leading_shape();
    let angles = ArmAngles::new(wishes.arm_angle, leading)?;
    let mut points = Vec::new();
    let request = call.request(py, chain, &mut points)?;
    let form = ClosedForm::of(chain).ok().filter(|form| !form.is_rough());
    let family = form.is_some() && request.task().fixes_pose();
    let locked = Locked::new(wishes.locked, chain, leading)?;
    let sweep = wishes
        .sweep
        .map(|sweep| convert::whole("sweep", sweep, 1, MOST_VALUES))
        .transpose()?
        .map(|count| count as usize);
    if !locked.is_empty() || sweep.is_some() || wishes.wrap || !family {
        if call.targets.is_single()
            && locked.is_empty()
            && sweep.is_none()
            && !wishes.wrap
            && wishes.arm_angle.is_none()
            && let Some(alone) = closed_form::alone_of_six(&request)
        {
            return Ok(Branches::of_one(chain.dof(), alone));
        }
        let (locks, angle, threads) = (locked.locks()?, angles.values()?, call.options.threads);
        let ask = Ask { locks: &locks, angle, sweep, wrap: wishes.wrap };
        let mut signals = Signals::new();
        let all = if request.len() <= 1 && sweep.is_none() {
            closed_form::every(&request, &ask, 1, &mut || signals.go_on_attached(py))
        } else {
            py.detach(|| {
                closed_form::every(&request, &ask, threads, &mut || signals.go_on_detached())
            })
        };
        return match all {
            Ok(all) => Ok(Branches::new(leading.to_vec(), chain.dof(), all, None)),
            Err(error) => Err(signals.exception(py, error)),
        };
    }
    let query = Query::new(request, angles.values()?, Choice::default())
        .map_err(|error| errors::from_core(py, error))?;
    if call.targets.is_single() {
        return Ok(Branches::of_one(chain.dof(), closed_form::alone(&query)));
    }
    let threads = call.options.threads;
    let mut signals = Signals::new();
    let all = if request.len() < MANY {
        py.detach(|| closed_form::all(&query, threads, &mut || signals.go_on_detached()))
            .map(|all| (all, None))
    } else {
        // NumPy asks for large pages, which makes filling fresh memory several times cheaper.
        let branches = ClosedForm::of(chain).map_or(0, ClosedForm::branches);
        let shape = [leading, &[branches, chain.dof()]].concat();
        let array = PyArrayDyn::<f64>::zeros(py, shape, false);
        let mut open = array.try_readwrite().map_err(convert::internal)?;
        let q = open.as_slice_mut().map_err(convert::internal)?;
        let all = py
            .detach(|| closed_form::all_into(&query, q, threads, &mut || signals.go_on_detached()));
        drop(open);
        all.map(|all| (all, Some(array.unbind())))
    };
    match all {
        Ok((all, q)) => Ok(Branches::new(leading.to_vec(), chain.dof(), all, q)),
        Err(error) => Err(signals.exception(py, error)),
    }
}

/// The best cost of the first run of a population solver, generation by generation, for
/// the first target of a call.
pub fn cost_history(
    py: Python<'_>,
    chain: &Chain,
    given: &Arguments<'_, '_>,
) -> PyResult<Vec<f64>> {
    let call = Call::new(py, chain, given)?;
    let mut points = Vec::new();
    let request = call.request(py, chain, &mut points)?;
    let Solver::Population(settings) = chosen(given.solver, chain.name())? else {
        return Err(errors::argument(py, "solver", "another solver", "a population solver"));
    };
    if request.len() != 1 {
        let received = format!("{} targets", request.len());
        return Err(errors::argument(py, "targets", &received, "one target"));
    }
    let evolution =
        Evolution::new(request, settings).map_err(|error| errors::from_core(py, error))?;
    let mut signals = Signals::new();
    py.detach(|| evolution.trace(Level::in_use(), 0, &mut || signals.go_on_detached()))
        .map_err(|error| signals.exception(py, error))
}
