//! Python bindings of `agrik`, the module `agrik_fast._native`: converts and checks
//! arguments, releases the interpreter around compute, turns errors into exceptions.

mod branches;
mod build;
mod chain;
mod control;
mod convert;
mod errors;
mod follow;
mod gains;
mod ik;
mod kinematics;
mod population;
mod result;
mod single;
mod solver;
mod strawberry;
mod targets;
mod task;
mod threads;
mod tomato;
mod tune;

use pyo3::prelude::*;

/// The compiled core: chains, kinematics and solvers.
#[pymodule]
mod _native {
    use super::*;

    #[pymodule_export]
    use branches::Branches;
    #[pymodule_export]
    use chain::Chain;
    #[pymodule_export]
    use control::TargetSolver;
    #[pymodule_export]
    use result::IkResult;
    #[pymodule_export]
    use solver::default_settings;
    #[pymodule_export]
    use strawberry::{StrawberryArm, ik_record};
    #[pymodule_export]
    use threads::{get_num_threads, set_num_threads, simd_level};
    #[pymodule_export]
    use tomato::{TomatoArm, ik_paced};
    #[pymodule_export]
    use tune::Tuner;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        errors::warn_of_debug_build(module.py())?;
        threads::warn_of_unmet_wish(module.py())
    }
}
