//! Distances from a crowd of spheres, cell by cell: never more than they are.
//!
//! A cell holds how far it is from the nearest cell that a sphere has a part in, box to box.
//! That is a sum over the axes, so three passes along them find it: the first counts cells from
//! those that are taken, the others look at so many to either side. What is in the grid is seen
//! from a point outside of it at no less than a right angle from the way to the point of the grid
//! next to it: so squares of both ways add up.

use agrik_compute::lanes::Real32;

use crate::shapes::Point;

/// Cells of a grid: so many for each sphere, but no fewer and no more than this.
const EACH: usize = 100;
const FEWEST: usize = 4096;
const MOST: usize = 1 << 20;
/// Most cells in a row.
const ROW: f64 = 1024.0;
/// So many cells are made in the time that they save a question of eight lanes: some 7 ns each,
/// of 4.5 us.
const CELLS_A_QUESTION: usize = 640;
/// Spheres that have parts in so many times the cells and themselves are no crowd of small ones.
const MANY: f64 = 30.0;
/// Cells to either side that a pass looks at.
const WINDOW: usize = 24;
/// Parts of the edge of a cell that distances are told in.
const PARTS: f32 = 8.0;
/// The square of a distance, in cells, that no pass comes to.
const UNKNOWN: i16 = 10_000;
/// What added to a number below 2^22 puts its whole part into the lowest bits.
const WHOLE: f32 = 8_388_608.0;

/// A grid of distances.
#[derive(Debug, Clone)]
pub struct Field {
    /// Middle of the first cell, m.
    first: [f32; 3],
    /// Cells to a metre.
    per_metre: f32,
    /// The last cell along each axis.
    last: [f32; 3],
    /// Steps from cell to cell along each axis.
    steps: [f32; 3],
    /// Distances in parts of the edge of a cell.
    parts: Vec<u8>,
}

/// How many cells there are about for so many spheres.
fn wanted(spheres: usize) -> usize {
    (EACH * spheres).clamp(FEWEST, MOST)
}

impl Field {
    /// After so many questions, of eight lanes each, a field of so many spheres is worth its
    /// making.
    pub fn worth(spheres: usize) -> usize {
        wanted(spheres) / CELLS_A_QUESTION
    }

    /// Of spheres (x, y, z, radius, m), with coordinates that count from `origin`; none where
    /// they lie in one point, or cells would not be any smaller than they are.
    pub fn new(spheres: &[[f64; 4]], origin: Point) -> Option<Self> {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for sphere in spheres {
            for k in 0..3 {
                low[k] = low[k].min(sphere[k] - sphere[3]);
                high[k] = high[k].max(sphere[k] + sphere[3]);
            }
        }
        let side = [0, 1, 2].map(|k| high[k] - low[k]);
        let longest = side[0].max(side[1]).max(side[2]);
        if !(longest > 0.0 && longest.is_finite()) {
            return None;
        }
        // No more cells in a row than are of use: nothing is told beyond the window.
        let wanted = wanted(spheres.len()) as f64;
        let edge = (side.iter().product::<f64>() / wanted).cbrt().max(longest / ROW);
        let counts = side.map(|s| (s / edge).ceil().max(1.0) as usize);
        let steps = [1, counts[0], counts[0] * counts[1]];
        let all = (counts[0] * counts[1] * counts[2]) as f64;
        let covered = |[.., r]: &[f64; 4]| (2.0 * r / edge + 1.0).powi(3).min(all);
        if spheres.iter().map(covered).sum::<f64>() > MANY * (wanted + spheres.len() as f64) {
            return None;
        }
        let mut squares = vec![UNKNOWN; counts[0] * counts[1] * counts[2]];
        let cell = |x: f64, k: usize| (((x - low[k]) / edge).max(0.0) as usize).min(counts[k] - 1);
        for sphere in spheres {
            // What rounding may have taken away is given back.
            let r = sphere[3] + 1e-9 * longest;
            let from = |k: usize| cell(sphere[k] - r, k);
            let to = |k: usize| cell(sphere[k] + r, k);
            for z in from(2)..=to(2) {
                for y in from(1)..=to(1) {
                    let row = z * steps[2] + y * steps[1];
                    squares[row + from(0)..=row + to(0)].fill(0);
                }
            }
        }
        count(&mut squares, counts[0]);
        for k in 1..3 {
            spread(&mut squares, counts[k], steps[k]);
        }
        let far = (WINDOW - 1) * (WINDOW - 1);
        let told: Vec<u8> = (0..=far).map(|d| ((d as f32).sqrt() * PARTS) as u8).collect();
        let parts = |square: &i16| told[(*square as usize).min(far)];
        Some(Self {
            first: [0, 1, 2].map(|k| (low[k] + 0.5 * edge - origin[k]) as f32),
            per_metre: (1.0 / edge) as f32,
            last: counts.map(|count| (count - 1) as f32),
            steps: steps.map(|step| step as f32),
            parts: squares.iter().map(parts).collect(),
        })
    }

    /// Lanes, a bit each, whose points may be within `reach` (m, 0 or more) of a sphere.
    #[inline(always)]
    pub fn maybe<R: Real32>(&self, p: &[R; 3], reach: R) -> u32 {
        let (zero, half) = (R::splat(0.0), R::splat(0.5));
        let (per_metre, whole) = (R::splat(f64::from(self.per_metre)), R::splat(f64::from(WHOLE)));
        let (mut index, mut outside) = (whole, zero);
        for k in 0..3 {
            let last = R::splat(f64::from(self.last[k]));
            let at = (p[k] - R::splat(f64::from(self.first[k]))) * per_metre;
            let middle = last * half;
            let over = ((at - middle).abs() - (middle + half)).max(zero);
            outside = over.mul_add(over, outside);
            // The nearest whole number, by rounding alone.
            let at = (at.max(zero).min(last) + whole) - whole;
            index = at.mul_add(R::splat(f64::from(self.steps[k])), index);
        }
        let reach = reach * per_metre;
        let left = reach * reach - outside;
        let near = R::bits(zero.le(left));
        if near == 0 {
            return 0;
        }
        // A part more for what the index was rounded by.
        let needed = left.max(zero).sqrt().mul_add(R::splat(f64::from(PARTS)), R::splat(1.0));
        let (mut cells, mut parts) = ([0.0_f32; 8], [0.0_f32; 8]);
        index.store(&mut cells);
        needed.store(&mut parts);
        let mut within = 0;
        for (lane, (cell, needed)) in cells.iter().zip(&parts).enumerate() {
            let cell = (cell.to_bits() & 0x007f_ffff) as usize;
            let is_far = self.parts.get(cell).is_some_and(|parts| f32::from(*parts) > *needed);
            within |= u32::from(!is_far) << lane;
        }
        near & within
    }

    /// The same of one point, m from the origin of coordinates.
    pub fn maybe_one(&self, p: [f32; 3], reach: f32) -> bool {
        let (mut index, mut outside) = (0, 0.0);
        for k in 0..3 {
            let at = (p[k] - self.first[k]) * self.per_metre;
            let middle = 0.5 * self.last[k];
            let over = ((at - middle).abs() - (middle + 0.5)).max(0.0);
            outside += over * over;
            index += (at.clamp(0.0, self.last[k]) + 0.5) as usize * self.steps[k] as usize;
        }
        let reach = reach * self.per_metre;
        let left = reach * reach - outside;
        let needed = left.max(0.0).sqrt() * PARTS + 1.0;
        left >= 0.0 && !self.parts.get(index).is_some_and(|parts| f32::from(*parts) > needed)
    }
}

/// Squares of distances along rows, of which cells are known that are at none.
fn count(squares: &mut [i16], count: usize) {
    let square = |away: usize| match away {
        0 => 0,
        WINDOW.. => UNKNOWN,
        _ => ((away - 1) * (away - 1)) as i16,
    };
    let squared: Vec<i16> = (0..=WINDOW).map(square).collect();
    for row in squares.chunks_exact_mut(count) {
        let mut away = WINDOW;
        for cell in row.iter_mut() {
            away = if *cell == 0 { 0 } else { WINDOW.min(away + 1) };
            *cell = away as i16;
        }
        away = WINDOW;
        for cell in row.iter_mut().rev() {
            away = (*cell as usize).min(away + 1);
            *cell = squared[away];
        }
    }
}

/// Takes over from neighbours along an axis what they know, and the way to them.
fn spread(squares: &mut [i16], count: usize, step: usize) {
    let mut before = vec![0; count * step];
    for squares in squares.chunks_exact_mut(count * step) {
        before.copy_from_slice(squares);
        for away in 1..WINDOW.min(count) {
            let (shift, more) = (away * step, ((away - 1) * (away - 1)) as i16);
            let take = |to: &mut [i16], from: &[i16]| {
                for (to, from) in to.iter_mut().zip(from) {
                    *to = (*to).min(*from + more);
                }
            };
            take(&mut squares[shift..], &before);
            take(squares, &before[shift..]);
        }
    }
}
