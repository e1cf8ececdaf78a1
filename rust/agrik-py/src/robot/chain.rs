//! The class `Chain`: only names, signatures and conversions; the work is elsewhere.

use std::collections::HashMap;
use std::sync::Arc;

use agrik::chain::{self, MotionLimits};
use agrik::closed_form::{ClosedForm, Recognised};
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFloat};

use super::build::{self, DhTable, Frame};
use super::kinematics;
use crate::collision::guard;
use crate::convert::{self, array, transform};
use crate::errors;
use crate::ik::arguments::{Arguments, Options};
use crate::ik::batch::{self, Wishes};
use crate::ik::branches::Branches;
use crate::ik::control::TargetSolver;
use crate::ik::follow::{self, Along, Followed};
use crate::ik::rates;
use crate::result::IkResult;

/// A serial chain: geometry, limits, base and tool, compiled for the solvers.
#[pyclass(frozen, module = "agrik_fast._native")]
pub struct Chain(Arc<chain::Chain>, Option<chain::DhConvention>);

impl Chain {
    fn changed(&self, py: Python<'_>, made: agrik::Result<chain::Chain>) -> PyResult<Self> {
        let made = made.map_err(|error| errors::from_core(py, error))?;
        Ok(Self(Arc::new(made), self.1))
    }

    /// The core's chain.
    pub fn core(&self) -> Arc<chain::Chain> {
        Arc::clone(&self.0)
    }

    fn of_variables(&self, pick: impl Fn(&chain::Variable) -> f64) -> Vec<f64> {
        self.0.variables().iter().map(pick).collect()
    }
}

/// First link, last link, other tips, locked joints.
type Ends = (String, String, Vec<String>, Vec<String>);
/// Largest speed, acceleration, jerk.
type Motion = (f64, f64, f64);
type Array<'py> = PyResult<Bound<'py, PyArrayDyn<f64>>>;

#[pymethods]
impl Chain {
    /// Build a chain from Denavit-Hartenberg rows.
    #[staticmethod]
    #[pyo3(signature = (
        name, convention, rows, joint_types, joint_names, lower, upper, base=None, tool=None,
        variable_order=None
    ))]
    #[allow(clippy::too_many_arguments)]
    fn from_dh(
        py: Python<'_>,
        name: &str,
        convention: &str,
        rows: &Bound<'_, PyAny>,
        joint_types: Vec<String>,
        joint_names: Vec<String>,
        lower: &Bound<'_, PyAny>,
        upper: &Bound<'_, PyAny>,
        base: Option<&Bound<'_, PyAny>>,
        tool: Option<&Bound<'_, PyAny>>,
        variable_order: Option<Vec<String>>,
    ) -> PyResult<Self> {
        let frame = Frame { name, base, tool, variable_order };
        let table = DhTable { rows, joint_types, joint_names, lower, upper };
        let (made, convention) = build::from_dh(py, frame, convention, table)?;
        Ok(Self(Arc::new(made), Some(convention)))
    }

    /// Build a chain from joints with origins and axes.
    #[staticmethod]
    #[pyo3(signature = (name, joints, base=None, tool=None, variable_order=None))]
    fn from_joints(
        py: Python<'_>,
        name: &str,
        joints: Vec<Bound<'_, PyDict>>,
        base: Option<&Bound<'_, PyAny>>,
        tool: Option<&Bound<'_, PyAny>>,
        variable_order: Option<Vec<String>>,
    ) -> PyResult<Self> {
        let frame = Frame { name, base, tool, variable_order };
        Ok(Self(Arc::new(build::from_joints(py, frame, &joints)?), None))
    }

    /// Build a chain from the text of a URDF; with it come the names of its first and its last
    /// link, of other links that the last could be, and of the joints that their limits lock.
    #[staticmethod]
    #[pyo3(signature = (text, base_link=None, tip_link=None))]
    fn from_urdf(
        py: Python<'_>,
        text: &str,
        base_link: Option<&str>,
        tip_link: Option<&str>,
    ) -> PyResult<(Self, Ends)> {
        let made = chain::Chain::from_urdf_with_ends(text, base_link, tip_link);
        let (chain, ends) = made.map_err(|error| errors::from_core(py, error))?;
        Ok((Self(Arc::new(chain), None), (ends.base, ends.tip, ends.others, ends.locked)))
    }

    /// Name of the robot.
    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    /// Number of joint variables, the length of q.
    #[getter]
    fn dof(&self) -> usize {
        self.0.dof()
    }

    /// Names of the joint variables, in the order of q.
    #[getter]
    fn joint_names(&self) -> Vec<&str> {
        self.0.variables().iter().map(|v| v.name.as_str()).collect()
    }

    /// Types of the joint variables, in the order of q.
    #[getter]
    fn joint_types(&self) -> Vec<&str> {
        self.0.variables().iter().map(|v| v.kind.as_str()).collect()
    }

    /// The joints, fixed ones and followers too, as `from_joints` takes them.
    fn joints<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        build::specs(py, &self.0)
    }

    /// Base transform, shape (4, 4), m.
    #[getter]
    fn base<'py>(&self, py: Python<'py>) -> Array<'py> {
        array(py, &[4, 4], build::rows_of(self.0.base()))
    }

    /// Tool transform, shape (4, 4), m.
    #[getter]
    fn tool<'py>(&self, py: Python<'py>) -> Array<'py> {
        array(py, &[4, 4], build::rows_of(self.0.tool()))
    }

    /// True for a chain of the same name, joints, links, limits, base and tool.
    fn same(&self, other: &Self) -> bool {
        self.0.is_same(&other.0)
    }

    /// Smallest values, shape (dof,), rad or m; -inf for continuous joints.
    #[getter]
    fn lower<'py>(&self, py: Python<'py>) -> Array<'py> {
        array(py, &[self.0.dof()], self.of_variables(|v| v.lower))
    }

    /// Largest values, shape (dof,), rad or m; inf for continuous joints.
    #[getter]
    fn upper<'py>(&self, py: Python<'py>) -> Array<'py> {
        array(py, &[self.0.dof()], self.of_variables(|v| v.upper))
    }

    /// Largest speed, acceleration and jerk, shape (3, dof), rad or m and s; inf where unknown.
    #[getter]
    fn motion_limits<'py>(&self, py: Python<'py>) -> Array<'py> {
        let picks = [
            self.of_variables(|v| v.motion.velocity),
            self.of_variables(|v| v.motion.acceleration),
            self.of_variables(|v| v.motion.jerk),
        ];
        array(py, &[3, self.0.dof()], picks.concat())
    }

    /// Return the same by the names of the joints, as `with_motion_limits` takes it; of the joints of
    /// which anything is known.
    fn joint_motion_limits(&self) -> Vec<(&str, Motion)> {
        let known = self.0.joints().iter().filter(|j| j.motion != MotionLimits::UNKNOWN);
        known
            .map(|j| (&*j.name, (j.motion.velocity, j.motion.acceleration, j.motion.jerk)))
            .collect()
    }

    /// Return the chain with other limits of motion of the joints that are named.
    fn with_motion_limits(
        &self,
        py: Python<'_>,
        limits: HashMap<String, Motion>,
    ) -> PyResult<Self> {
        let limits = limits.iter().map(|(name, &(velocity, acceleration, jerk))| {
            (name.as_str(), MotionLimits { velocity, acceleration, jerk })
        });
        self.changed(py, self.0.with_motion_limits(limits))
    }

    /// Return the chain with other limits of the joint variables that are named.
    fn with_limits(&self, py: Python<'_>, limits: HashMap<String, (f64, f64)>) -> PyResult<Self> {
        let limits = limits.iter().map(|(name, &(lower, upper))| (name.as_str(), lower, upper));
        self.changed(py, self.0.with_limits(limits))
    }

    /// Return the chain with the joint variables that are named at rest, at their values.
    fn locked(&self, py: Python<'_>, locks: HashMap<String, f64>) -> PyResult<Self> {
        let variables = self.0.variables().iter().enumerate();
        let at = variables.filter_map(|(i, v)| locks.get(&v.name).map(|value| (i, *value)));
        self.changed(py, self.0.locked(&at.collect::<Vec<_>>()))
    }

    /// Return joint rates, shape (n, dof), for twists, shape (n, 6), between bounds, shape
    /// (n, dof); the turns count where `turns`.
    #[pyo3(signature = (q, twists, least, most, turns, second_aim=None, gain=1.0, threads=None))]
    #[allow(clippy::too_many_arguments)]
    fn velocity<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        twists: &Bound<'py, PyAny>,
        least: &Bound<'py, PyAny>,
        most: &Bound<'py, PyAny>,
        turns: bool,
        second_aim: Option<&Bound<'py, PyAny>>,
        gain: f64,
        threads: Option<&Bound<'py, PyAny>>,
    ) -> Array<'py> {
        rates::rates(&self.0, (q, twists), (least, most), turns, (second_aim, gain), threads, py)
    }

    /// Names of the frames of `fk_links`, the tool last.
    #[getter]
    fn link_names(&self) -> Vec<&str> {
        let links = self.0.joints().iter().map(|joint| joint.child_link.as_str());
        links.chain(["tool"]).collect()
    }

    /// Proven bound, m, on the tool point's distance from `reach_center`.
    #[getter]
    fn reach_radius(&self) -> f64 {
        self.0.reach().radius
    }

    /// Centre of the reach ball, base frame, shape (3,), m.
    #[getter]
    fn reach_center<'py>(&self, py: Python<'py>) -> Array<'py> {
        array(py, &[3], self.0.reach().center.to_vec())
    }

    /// Proven bounds of the tool point, base frame, shape (2, 3), m.
    #[getter]
    fn reach_box<'py>(&self, py: Python<'py>) -> Array<'py> {
        let reach = self.0.reach();
        array(py, &[2, 3], [reach.lower, reach.upper].concat())
    }

    /// Return the chain with another tool, shape (4, 4), m.
    fn with_tool(&self, tool: &Bound<'_, PyAny>) -> PyResult<Self> {
        self.changed(tool.py(), self.0.with_tool(transform("tool", tool)?))
    }

    /// Return the chain with another base, shape (4, 4), m.
    fn with_base(&self, base: &Bound<'_, PyAny>) -> PyResult<Self> {
        self.changed(base.py(), self.0.with_base(transform("base", base)?))
    }

    /// Return tool poses, shape (..., 4, 4), of joint values, shape (..., dof).
    fn fk<'py>(&self, q: &Bound<'py, PyAny>) -> Array<'py> {
        kinematics::fk(&self.0, q)
    }

    /// Return link poses, shape (..., links, 4, 4), of joint values, shape (..., dof).
    fn fk_links<'py>(&self, q: &Bound<'py, PyAny>) -> Array<'py> {
        kinematics::fk_links(&self.0, q)
    }

    /// Return geometric Jacobians, shape (..., 6, dof), linear rows first.
    fn jacobian<'py>(&self, q: &Bound<'py, PyAny>) -> Array<'py> {
        kinematics::jacobian(&self.0, q)
    }

    /// Gain that feedback solvers without matrices start from: for positions, or with the
    /// length that a radian counts as for poses.
    #[pyo3(signature = (per_radian=None))]
    fn frozen_gain<'py>(&self, py: Python<'py>, per_radian: Option<f64>) -> Array<'py> {
        let gain =
            agrik::solve::frozen_gain(&self.0, per_radian).map_err(|e| errors::from_core(py, e))?;
        array(py, &[gain.rows(), gain.columns], gain.values)
    }

    /// Solve a batch of targets; see `agrik_fast.Robot.ik`.
    #[pyo3(signature = (
        targets, task=None, solver=None, q0=None, seed=None, tool=None, threads=None,
        position_tolerance=None, orientation_tolerance=None, first_index=None,
        tolerance_frame=None, collider=None, clear=None, prefer=None, invalid=None,
        second_aim=None, nearest=None, joint_weights=None, limits=None
    ))]
    #[allow(clippy::too_many_arguments)]
    fn ik(
        &self,
        py: Python<'_>,
        targets: &Bound<'_, PyAny>,
        task: Option<&Bound<'_, PyAny>>,
        solver: Option<&Bound<'_, PyAny>>,
        q0: Option<&Bound<'_, PyAny>>,
        seed: Option<&Bound<'_, PyAny>>,
        tool: Option<&Bound<'_, PyAny>>,
        threads: Option<&Bound<'_, PyAny>>,
        position_tolerance: Option<&Bound<'_, PyAny>>,
        orientation_tolerance: Option<&Bound<'_, PyAny>>,
        first_index: Option<&Bound<'_, PyAny>>,
        tolerance_frame: Option<&Bound<'_, PyAny>>,
        collider: Option<&Bound<'_, PyAny>>,
        clear: Option<&Bound<'_, PyAny>>,
        prefer: Option<&Bound<'_, PyAny>>,
        invalid: Option<&Bound<'_, PyAny>>,
        second_aim: Option<&Bound<'_, PyAny>>,
        nearest: Option<&Bound<'_, PyAny>>,
        joint_weights: Option<&Bound<'_, PyAny>>,
        limits: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<IkResult> {
        let given = Arguments {
            targets,
            task,
            solver,
            q0,
            seed,
            tool,
            threads,
            position_tolerance,
            orientation_tolerance,
            tolerance_frame,
            first_index,
            invalid,
            second_aim,
        };
        let guard = guard::Given { collider, clear, prefer };
        batch::solve(py, &self.0, self.1, &given, &guard, (nearest, joint_weights, limits))
    }

    /// Make a solver for one target at a time; see `agrik_fast.Robot.solver`.
    #[pyo3(signature = (
        task=None, solver=None, seed=None, tool=None, position_tolerance=None,
        orientation_tolerance=None, tolerance_frame=None, second_aim=None, max_change=None, recipe=None
    ))]
    #[allow(clippy::too_many_arguments)]
    fn solver(
        &self,
        py: Python<'_>,
        task: Option<&Bound<'_, PyAny>>,
        solver: Option<&Bound<'_, PyAny>>,
        seed: Option<&Bound<'_, PyAny>>,
        tool: Option<&Bound<'_, PyAny>>,
        position_tolerance: Option<&Bound<'_, PyAny>>,
        orientation_tolerance: Option<&Bound<'_, PyAny>>,
        tolerance_frame: Option<&Bound<'_, PyAny>>,
        second_aim: Option<&Bound<'_, PyAny>>,
        max_change: Option<&Bound<'_, PyAny>>,
        recipe: Option<Py<PyAny>>,
    ) -> PyResult<TargetSolver> {
        let none = py.None().into_bound(py);
        let given = Arguments {
            targets: &none,
            task,
            solver,
            q0: None,
            seed,
            tool,
            threads: None,
            position_tolerance,
            orientation_tolerance,
            tolerance_frame,
            first_index: None,
            invalid: None,
            second_aim,
        };
        let options = Options::new(&self.0, &given, true)?;
        TargetSolver::new(py, Arc::clone(&self.0), solver, options, max_change, recipe)
    }

    /// Follow a sequence of targets; see `agrik_fast.Robot.follow`.
    #[pyo3(signature = (
        targets, max_joint_step, q0=None, pull=None, task=None, seed=None, tool=None,
        position_tolerance=None, orientation_tolerance=None, tolerance_frame=None
    ))]
    #[allow(clippy::too_many_arguments)]
    fn follow<'py>(
        &self,
        py: Python<'py>,
        targets: &Bound<'py, PyAny>,
        max_joint_step: &Bound<'py, PyAny>,
        q0: Option<&Bound<'py, PyAny>>,
        pull: Option<&Bound<'py, PyAny>>,
        task: Option<&Bound<'py, PyAny>>,
        seed: Option<&Bound<'py, PyAny>>,
        tool: Option<&Bound<'py, PyAny>>,
        position_tolerance: Option<&Bound<'py, PyAny>>,
        orientation_tolerance: Option<&Bound<'py, PyAny>>,
        tolerance_frame: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Followed<'py>> {
        let given = Arguments {
            targets,
            task,
            solver: None,
            q0: None,
            seed,
            tool,
            threads: None,
            position_tolerance,
            orientation_tolerance,
            tolerance_frame,
            first_index: None,
            invalid: None,
            second_aim: None,
        };
        let usual = PyFloat::new(py, 0.5).into_any();
        let along = Along { q0, max_joint_step, pull: pull.unwrap_or(&usual) };
        follow::follow(py, &self.0, &given, &along)
    }

    /// Return the best cost of a population solver's first run, generation by generation.
    #[pyo3(signature = (target, solver, task=None, q0=None, seed=None, tool=None))]
    #[allow(clippy::too_many_arguments)]
    fn cost_history<'py>(
        &self,
        py: Python<'py>,
        target: &Bound<'py, PyAny>,
        solver: &Bound<'py, PyAny>,
        task: Option<&Bound<'py, PyAny>>,
        q0: Option<&Bound<'py, PyAny>>,
        seed: Option<&Bound<'py, PyAny>>,
        tool: Option<&Bound<'py, PyAny>>,
    ) -> Array<'py> {
        let given = Arguments {
            targets: target,
            task,
            solver: Some(solver),
            q0,
            seed,
            tool,
            threads: None,
            position_tolerance: None,
            orientation_tolerance: None,
            tolerance_frame: None,
            first_index: None,
            invalid: None,
            second_aim: None,
        };
        let costs = batch::cost_history(py, &self.0, &given)?;
        array(py, &[costs.len()], costs)
    }

    /// All branches of a batch of poses; see `agrik_fast.Robot.ik_all`.
    #[pyo3(signature = (
        targets, q0=None, tool=None, threads=None, arm_angle=None, position_tolerance=None,
        orientation_tolerance=None, tolerance_frame=None, locked=None, sweep=None, wrap=None,
        task=None, invalid=None
    ))]
    #[allow(clippy::too_many_arguments)]
    fn ik_all(
        &self,
        py: Python<'_>,
        targets: &Bound<'_, PyAny>,
        q0: Option<&Bound<'_, PyAny>>,
        tool: Option<&Bound<'_, PyAny>>,
        threads: Option<&Bound<'_, PyAny>>,
        arm_angle: Option<&Bound<'_, PyAny>>,
        position_tolerance: Option<&Bound<'_, PyAny>>,
        orientation_tolerance: Option<&Bound<'_, PyAny>>,
        tolerance_frame: Option<&Bound<'_, PyAny>>,
        locked: Option<&Bound<'_, PyAny>>,
        sweep: Option<&Bound<'_, PyAny>>,
        wrap: Option<&Bound<'_, PyAny>>,
        task: Option<&Bound<'_, PyAny>>,
        invalid: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Branches> {
        let given = Arguments {
            targets,
            task,
            solver: None,
            q0,
            seed: None,
            tool,
            threads,
            position_tolerance,
            orientation_tolerance,
            tolerance_frame,
            first_index: None,
            invalid,
            second_aim: None,
        };
        let wrap = wrap.map_or(Ok(false), |wrap| convert::truth("wrap", wrap))?;
        batch::solve_all(py, &self.0, &given, &Wishes { arm_angle, locked, sweep, wrap })
    }

    /// Arm angles, shape (...), rad, of joint values, shape (..., dof), of an S-R-S arm.
    fn arm_angle<'py>(&self, q: &Bound<'py, PyAny>) -> Array<'py> {
        kinematics::arm_angle(&self.0, q)
    }

    /// Arm angles that the limits allow for one pose: for each branch (lower, upper), rad.
    #[pyo3(signature = (target, tool=None))]
    fn arm_angle_intervals(
        &self,
        target: &Bound<'_, PyAny>,
        tool: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Vec<Vec<(f64, f64)>>> {
        kinematics::arm_angle_intervals(&self.0, target, tool)
    }

    /// What the arm was recognised as: name, method, reason, most branches, locked joint.
    #[getter]
    fn family(&self) -> (String, &'static str, String, usize, Option<String>) {
        let family = Recognised::of(&self.0);
        let locked = family.locked.map(|variable| self.0.variables()[variable].name.clone());
        (family.name, family.method, family.reason, family.branches, locked)
    }

    /// Family of the chain's closed form, or why it has none: (name, reason).
    #[getter]
    fn closed_form(&self) -> (Option<&'static str>, Option<&str>) {
        match ClosedForm::of(&self.0) {
            Ok(form) => (Some(form.name()), None),
            Err(why) => (None, Some(why)),
        }
    }
}
