//! Points with radii: leaves, stems, what a camera saw.

use agrik_compute::{Allowed, Error, Result};

use super::{LARGEST, Point, check};

/// Many spheres.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cloud {
    /// x, y, z and radius, m, each of all spheres in a row: so they come into lanes.
    columns: [Vec<f64>; 4],
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
        let rows = rows.into_iter();
        let mut columns = [const { Vec::new() }; 4];
        for column in &mut columns {
            column.reserve(rows.size_hint().0);
        }
        for (i, row) in rows.enumerate() {
            let [x, y, z, r] = row;
            check::point(|| format!("points[{i}]"), [x, y, z])?;
            let allowed = Allowed::between(0.0, LARGEST);
            if !allowed.contains(r) {
                return Err(Error::argument(format!("radii[{i}]"), allowed.to_string(), r));
            }
            for (column, value) in columns.iter_mut().zip(row) {
                column.push(value);
            }
        }
        Ok(Self { columns })
    }

    /// How many spheres there are.
    pub fn len(&self) -> usize {
        self.columns[0].len()
    }

    /// True where there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// One of the spheres: x, y, z and radius, m.
    pub fn sphere(&self, index: usize) -> [f64; 4] {
        let [x, y, z, r] = &self.columns;
        [x[index], y[index], z[index], r[index]]
    }

    /// The spheres as rows of x, y, z and radius, m.
    pub fn spheres(&self) -> impl Iterator<Item = [f64; 4]> {
        (0..self.len()).map(|index| self.sphere(index))
    }

    /// x, y, z and radius, m, each of all spheres in a row.
    pub fn columns(&self) -> &[Vec<f64>; 4] {
        &self.columns
    }
}
