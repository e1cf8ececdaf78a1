//! What the coordinates of a shape may be.

use agrik_compute::{Allowed, Error, Result};

use super::{LARGEST, Point};

/// Refuses a point with a coordinate that is not finite or too large; `argument` gives its
/// name, made only where it is needed.
pub(super) fn point<S: Into<String>>(argument: impl FnOnce() -> S, p: Point) -> Result<()> {
    let allowed = Allowed::between(-LARGEST, LARGEST);
    if p.iter().all(|x| allowed.contains(*x)) {
        return Ok(());
    }
    Err(Error::argument(argument(), format!("three coordinates, each {allowed}"), format!("{p:?}")))
}
