//! Python bindings of `agrik` and the crates beside it, the module `agrik_fast._native`: converts and checks
//! arguments, releases the interpreter around compute, turns errors into exceptions.

mod arms;
mod collision;
mod convert;
mod errors;
mod files;
mod harvest;
mod ik;
mod motion;
mod records;
mod result;
mod robot;
mod single_use;
mod solvers;
mod threads;
mod time_law;

use pyo3::prelude::*;

/// The compiled core: chains, kinematics and solvers.
#[pymodule]
mod _native {
    use super::*;

    #[pymodule_export]
    use arms::strawberry::{StrawberryArm, ik_record};
    #[pymodule_export]
    use arms::tomato::{TomatoArm, ik_paced};
    #[pymodule_export]
    use collision::bodies::Bodies;
    #[pymodule_export]
    use collision::collider::Collider;
    #[pymodule_export]
    use collision::distances::Distances;
    #[pymodule_export]
    use collision::near::{collision_near, collision_shifted_own};
    #[pymodule_export]
    use collision::scene::Scene;
    #[pymodule_export]
    use errors::_panic;
    #[pymodule_export]
    use files::csv_reader::CsvRows;
    #[pymodule_export]
    use files::csv_writer::csv_lines;
    #[pymodule_export]
    use harvest::programme::HarvestProgramme;
    #[pymodule_export]
    use harvest::station::{HarvestStation, harvest_words};
    #[pymodule_export]
    use ik::branches::{Branches, branches};
    #[pymodule_export]
    use ik::control::TargetSolver;
    #[pymodule_export]
    use motion::check::{motion_check, motion_corners, motion_words};
    #[pymodule_export]
    use motion::plan::{motion_blockers, motion_plan};
    #[pymodule_export]
    use result::{IkResult, ik_result, statuses};
    #[pymodule_export]
    use robot::chain::Chain;
    #[pymodule_export]
    use solvers::solver::{check_solver, default_settings, limited_solver_names, solver_names};
    #[pymodule_export]
    use solvers::tune::Tuner;
    #[pymodule_export]
    use threads::{get_num_threads, set_num_threads, simd_level};
    #[pymodule_export]
    use time_law::Motion;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        errors::guard_against_panics(module.py())?;
        errors::warn_of_debug_build(module.py())?;
        threads::warn_of_unmet_wish(module.py())
    }
}
