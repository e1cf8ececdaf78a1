//! What is asked of the family: its arm angles.

use crate::chain::Chain;
use crate::closed_form::families::ClosedForm;
use crate::error::{Error, Result};

/// The arm angles of a call, rad; of no account for arms without one.
#[derive(Debug, Clone, Copy)]
pub enum ArmAngle<'a> {
    /// That of the start values; for the best branch, the best of all arm angles.
    Free,
    /// The same for all targets.
    One(f64),
    /// One a target.
    Each(&'a [f64]),
}

/// The family of a chain, or the error of a call for it.
pub(crate) fn form_of(chain: &Chain) -> Result<&ClosedForm> {
    ClosedForm::of(chain).map_err(|why| Error::argument("solver", "an arm with a closed form", why))
}

/// Refuses arm angles that an arm has not, or that are no angles.
pub(crate) fn arm_angles(form: &ClosedForm, angle: ArmAngle<'_>, targets: usize) -> Result<()> {
    let angles: &[f64] = match &angle {
        ArmAngle::Free => &[],
        ArmAngle::One(x) => std::slice::from_ref(x),
        ArmAngle::Each(all) => all,
    };
    if matches!(angle, ArmAngle::Each(_)) && angles.len() != targets {
        let expected = format!("{targets} numbers, one a target");
        return Err(Error::argument("arm_angle", expected, angles.len()));
    }
    if let Some(bad) = angles.iter().find(|x| !x.is_finite()) {
        return Err(Error::argument("arm_angle", "finite numbers", bad));
    }
    if !angles.is_empty() && !matches!(form, ClosedForm::Srs(_)) {
        let expected = "none, as the arm is not redundant";
        return Err(Error::argument("arm_angle", expected, "arm angles"));
    }
    Ok(())
}
