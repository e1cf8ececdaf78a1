//! The way through joint values: straight pieces with rounded corners, or one smooth curve.
//!
//! The place on the way, `s`, is measured in the lengths that the caller gives the segments
//! (rad, metres of the tool, anything); the geometry does not depend on them.

use agrik_compute::{Error, Result};

/// A piece on which every joint value is a polynomial of the place.
#[derive(Debug, Clone)]
pub struct Piece {
    start: f64,
    length: f64,
    /// For each joint, coefficients of the powers of the place from the piece's begin.
    powers: Vec<[f64; 5]>,
    /// For each joint, bounds of the sizes of its first three derivatives.
    sizes: Vec<[f64; 3]>,
}

impl Piece {
    /// Place at which it ends.
    pub fn end(&self) -> f64 {
        self.start + self.length
    }

    /// Its length.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Bounds of the first three derivatives of a joint value by the place.
    pub fn sizes(&self, joint: usize) -> [f64; 3] {
        self.sizes[joint]
    }

    /// A joint value and its first three derivatives by the place.
    fn values(&self, joint: usize, place: f64) -> [f64; 4] {
        let x = place - self.start;
        let [a, b, c, d, e] = self.powers[joint];
        [
            a + x * (b + x * (c + x * (d + x * e))),
            b + x * (2.0 * c + x * (3.0 * d + x * 4.0 * e)),
            2.0 * c + x * (6.0 * d + x * 12.0 * e),
            6.0 * d + x * 24.0 * e,
        ]
    }
}

/// A way through waypoints, in runs from rest to rest.
#[derive(Debug, Clone)]
pub struct Path {
    dof: usize,
    pieces: Vec<Piece>,
    /// Pieces before which the arm rests; the first is 0.
    rests: Vec<usize>,
    first: Vec<f64>,
    last: Vec<f64>,
    deviation: f64,
}

/// Waypoints without repeated ones, and what belongs to them.
struct Rows<'a> {
    points: Vec<&'a [f64]>,
    lengths: Vec<f64>,
    corners: Vec<f64>,
}

impl<'a> Rows<'a> {
    fn new(dof: usize, waypoints: &'a [f64], lengths: &[f64], corners: &[f64]) -> Result<Self> {
        let count = waypoints.len() / dof.max(1);
        if count == 0 || waypoints.len() != count * dof {
            let got = format!("{} numbers", waypoints.len());
            return Err(Error::argument("waypoints", format!("rows of {dof} numbers"), got));
        }
        check_count("lengths", lengths.len(), count - 1)?;
        check_count("blends", corners.len(), count)?;
        check_numbers("waypoints", waypoints, |x| x.is_finite(), "finite numbers")?;
        check_numbers("blends", corners, |x| x.is_finite() && x >= 0.0, "finite numbers >= 0")?;
        let mut rows =
            Self { points: vec![&waypoints[..dof]], lengths: Vec::new(), corners: vec![0.0] };
        for (i, point) in waypoints.chunks_exact(dof).enumerate().skip(1) {
            if rows.points.last() == Some(&point) {
                // The arm does not move: no segment.
                continue;
            }
            let length = lengths[i - 1];
            if !(length.is_finite() && length > 0.0) {
                let place = format!("lengths[{}]", i - 1);
                return Err(Error::argument(place, "a finite number > 0", length));
            }
            rows.points.push(point);
            rows.lengths.push(length);
            rows.corners.push(corners[i]);
        }
        if let Some(last) = rows.corners.last_mut() {
            *last = 0.0;
        }
        Ok(rows)
    }

    /// Change of each joint value over a segment, by the place.
    fn rates(&self, segment: usize) -> Vec<f64> {
        let (from, to) = (self.points[segment], self.points[segment + 1]);
        from.iter().zip(to).map(|(a, b)| (b - a) / self.lengths[segment]).collect()
    }
}

impl Path {
    /// Straight from waypoint to waypoint, the corner at each rounded from `blends` (one number
    /// a waypoint, in the measure of `lengths`) before it to as much behind it; with 0 the arm
    /// rests there. The ends' numbers are of no account.
    ///
    /// A rounded corner is a curve of the fourth degree whose first and second derivative are
    /// those of the straight pieces at both ends; it leaves the corner by 3/16 of
    /// `blends * |change of direction|` at most.
    pub fn with_corners(
        dof: usize,
        waypoints: &[f64],
        lengths: &[f64],
        blends: &[f64],
    ) -> Result<Self> {
        let rows = Rows::new(dof, waypoints, lengths, blends)?;
        let mut path = Self::without_pieces(dof, &rows);
        let segments = rows.lengths.len();
        for i in 0..segments {
            let (before, behind) = (rows.corners[i], rows.corners[i + 1]);
            let straight = rows.lengths[i] - before - behind;
            if straight < -1e-9 * rows.lengths[i] {
                let expected = format!("at most {} on segment {i}, both ends", rows.lengths[i]);
                return Err(Error::argument("blends", expected, before + behind));
            }
            let rates = rows.rates(i);
            if before == 0.0 {
                path.rests.push(path.pieces.len());
            }
            // What rounding leaves of a segment between two blends is no piece.
            if straight > 1e-9 * rows.lengths[i] {
                let point = rows.points[i].iter().zip(&rates);
                let powers = point.map(|(q, d)| [q + before * d, *d, 0.0, 0.0, 0.0]).collect();
                let sizes = rates.iter().map(|d| [d.abs(), 0.0, 0.0]).collect();
                path.push(straight, powers, sizes);
            }
            if behind > 0.0 {
                path.push_corner(rows.points[i + 1], behind, &rates, &rows.rates(i + 1));
            }
        }
        Ok(path)
    }

    /// One curve through all waypoints without a rest between: cubic splines of the place, not
    /// a knot at the second waypoint and the last but one.
    pub fn smooth(dof: usize, waypoints: &[f64], lengths: &[f64]) -> Result<Self> {
        let count = waypoints.len() / dof.max(1);
        let rows = Rows::new(dof, waypoints, lengths, &vec![0.0; count])?;
        let mut path = Self::without_pieces(dof, &rows);
        let segments = rows.lengths.len();
        if segments == 0 {
            return Ok(path);
        }
        path.rests.push(0);
        let bends: Vec<Vec<f64>> = (0..dof)
            .map(|j| super::spline::second_derivatives(&rows.lengths, |i| rows.points[i][j]))
            .collect();
        for i in 0..segments {
            let h = rows.lengths[i];
            let (mut powers, mut sizes) = (Vec::with_capacity(dof), Vec::with_capacity(dof));
            for (j, bends) in bends.iter().enumerate() {
                let (q, next) = (rows.points[i][j], rows.points[i + 1][j]);
                let (bend, end) = (bends[i], bends[i + 1]);
                let slope = (next - q) / h - h * (2.0 * bend + end) / 6.0;
                let third = (end - bend) / h;
                powers.push([q, slope, 0.5 * bend, third / 6.0, 0.0]);
                let at_end = slope + 0.5 * h * (bend + end);
                let mut fastest = slope.abs().max(at_end.abs());
                if bend * end < 0.0 {
                    // The slope is extreme where the second derivative is 0.
                    fastest = fastest.max((slope - 0.5 * bend * bend / third).abs());
                }
                sizes.push([fastest, bend.abs().max(end.abs()), third.abs()]);
            }
            path.push(h, powers, sizes);
        }
        Ok(path)
    }

    fn without_pieces(dof: usize, rows: &Rows<'_>) -> Self {
        let end = |point: Option<&&[f64]>| point.map_or_else(Vec::new, |point| point.to_vec());
        let (first, last) = (end(rows.points.first()), end(rows.points.last()));
        Self { dof, pieces: Vec::new(), rests: Vec::new(), first, last, deviation: 0.0 }
    }

    fn push(&mut self, length: f64, powers: Vec<[f64; 5]>, sizes: Vec<[f64; 3]>) {
        self.pieces.push(Piece { start: self.length(), length, powers, sizes });
    }

    /// A rounded corner, from `half` before it to `half` behind it.
    fn push_corner(&mut self, corner: &[f64], half: f64, before: &[f64], behind: &[f64]) {
        let (mut powers, mut sizes) = (Vec::new(), Vec::new());
        let mut off: f64 = 0.0;
        for ((q, d), e) in corner.iter().zip(before).zip(behind) {
            let turn = e - d;
            // The turn is spread as 1 - x^2 over the corner, x from -1 to 1.
            powers.push([
                q - half * d,
                *d,
                0.0,
                turn / (4.0 * half * half),
                -turn / (16.0 * half * half * half),
            ]);
            sizes.push([
                d.abs().max(e.abs()),
                0.75 * turn.abs() / half,
                1.5 * turn.abs() / (half * half),
            ]);
            off = off.max(3.0 / 16.0 * half * turn.abs());
        }
        self.deviation = self.deviation.max(off);
        self.push(2.0 * half, powers, sizes);
    }

    /// Number of joint values.
    pub fn dof(&self) -> usize {
        self.dof
    }

    /// Length of the whole way.
    pub fn length(&self) -> f64 {
        self.pieces.last().map_or(0.0, Piece::end)
    }

    /// The pieces of each run from rest to rest.
    pub fn runs(&self) -> impl Iterator<Item = &[Piece]> {
        (0..self.rests.len()).map(|run| self.run(run))
    }

    fn run(&self, run: usize) -> &[Piece] {
        let to = self.rests.get(run + 1).copied().unwrap_or(self.pieces.len());
        self.rests.get(run).map_or(&[], |&from| &self.pieces[from..to])
    }

    /// How far a rounded corner leaves its waypoint at most, in any joint value, rad or m.
    pub fn deviation(&self) -> f64 {
        self.deviation
    }

    /// Joint values and their first three derivatives by the place, one joint after the other.
    /// Where the arm rests the place alone does not tell which run it is on.
    pub fn at(&self, run: usize, place: f64, mut put: impl FnMut(usize, [f64; 4])) {
        let pieces = self.run(run);
        let after = pieces.partition_point(|piece| piece.end() < place);
        match pieces.get(after).or(pieces.last()) {
            Some(piece) => {
                let place = place.clamp(piece.start, piece.end());
                (0..self.dof).for_each(|joint| put(joint, piece.values(joint, place)));
            }
            None => (0..self.dof).for_each(|joint| put(joint, [self.first[joint], 0.0, 0.0, 0.0])),
        }
    }

    /// True where a joint moves anywhere.
    pub fn moves(&self, joint: usize) -> bool {
        self.pieces.iter().any(|piece| piece.sizes(joint)[0] > 0.0)
    }

    /// Where the way ends.
    pub fn last(&self) -> &[f64] {
        &self.last
    }
}

fn check_count(argument: &str, got: usize, wanted: usize) -> Result<()> {
    if got == wanted {
        return Ok(());
    }
    Err(Error::argument(argument, format!("{wanted} numbers"), format!("{got} numbers")))
}

fn check_numbers(
    argument: &str,
    numbers: &[f64],
    fits: impl Fn(f64) -> bool,
    expected: &str,
) -> Result<()> {
    match numbers.iter().find(|x| !fits(**x)) {
        None => Ok(()),
        Some(x) => Err(Error::argument(argument, expected, x)),
    }
}
