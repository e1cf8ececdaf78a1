//! Points with radii: leaves, stems, what a camera saw.

use agrik_compute::{Allowed, Error, Result};

use super::{LARGEST, Point, check};

/// Many spheres.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cloud {
    spheres: Vec<[f64; 4]>,
}

impl Cloud {
    /// Spheres of one radius round points, m. No points are no error: a cloud may be empty.
    ///
    /// # Errors
    ///
    /// A coordinate is not finite or beyond [`LARGEST`], or the radius is negative as well.
    pub fn new(points: &[Point], radius: f64) -> Result<Self> {
        Allowed::between(0.0, LARGEST).check("radius", radius)?;
        Self::of(points.iter().map(|p| [p[0], p[1], p[2], radius]))
    }

    /// Spheres, each with a radius of its own, m.
    ///
    /// # Errors
    ///
    /// There are not as many radii as points; else as [`Cloud::new`].
    pub fn with_radii(points: &[Point], radii: &[f64]) -> Result<Self> {
        if points.len() != radii.len() {
            let expected = format!("one radius for each of {} points", points.len());
            return Err(Error::argument("radii", expected, radii.len()));
        }
        Self::of(points.iter().zip(radii).map(|(p, r)| [p[0], p[1], p[2], *r]))
    }

    /// Spheres as rows of x, y, z and radius, m.
    ///
    /// # Errors
    ///
    /// As [`Cloud::new`].
    pub fn of(rows: impl IntoIterator<Item = [f64; 4]>) -> Result<Self> {
        let spheres: Vec<[f64; 4]> = rows.into_iter().collect();
        for (i, [x, y, z, r]) in spheres.iter().enumerate() {
            check::point(&format!("points[{i}]"), [*x, *y, *z])?;
            let allowed = Allowed::between(0.0, LARGEST);
            if !allowed.contains(*r) {
                return Err(Error::argument(format!("radii[{i}]"), allowed.to_string(), r));
            }
        }
        Ok(Self { spheres })
    }

    /// The spheres as rows of x, y, z and radius, m.
    pub fn spheres(&self) -> &[[f64; 4]] {
        &self.spheres
    }
}
