//! Sampled postures of a chain with the frames they lead to, kept for choosing starts.

/// Postures that stand side by side in the table and are compared with a goal together.
pub const BLOCK: usize = 16;
/// Numbers kept of a posture's frame.
pub const FEATURES: usize = 16;
/// Cells along each axis of the index of places, as a power of two.
const BITS: u32 = 4;
const CELLS: usize = 1 << (3 * BITS);

/// A table of joint values and of the frames they lead to. Its first part is in the order
/// of a curve through space: postures whose tool points are near one another are mostly
/// neighbours. The rest is in no order.
///
/// Numbers are in single precision: they only rank and give starts, and half the bytes
/// double the rate at which the table is searched.
#[derive(Debug, Clone, Default)]
pub struct Postures {
    /// Lower end and width of what each joint value is drawn from, rad or m.
    pub ranges: Vec<(f64, f64)>,
    /// Joint values, `dof` a posture.
    pub q: Vec<f32>,
    /// What the squared distance between two frames is linear in, a row a number: `|p|^2`,
    /// `p` (3 rows), the axes x, y and z of the last joint's frame (3 rows each), `p` along
    /// these axes (3 rows); `p` is the tool point seen from [`Places::middle`].
    pub blocks: Vec<[[f32; BLOCK]; FEATURES]>,
    /// Where in the first part of the table a place is.
    pub places: Places,
}

/// Which part of the table belongs to a place.
#[derive(Debug, Clone, Default)]
pub struct Places {
    /// Middle of the sampled places, m.
    pub middle: [f64; 3],
    low: [f64; 3],
    cells_per_metre: [f64; 3],
    /// Block of each cell.
    block: Vec<u16>,
}

impl Places {
    /// The index of some places (fewer than 2^20), and their order along the curve.
    pub fn new(points: &[[f64; 3]]) -> (Self, Vec<usize>) {
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        for p in points {
            for k in 0..3 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        // A chain may move in a plane, or along a line: no axis may be without length.
        let cells_per_metre =
            [0, 1, 2].map(|k| f64::from(1 << BITS) / (high[k] - low[k]).max(1e-9));
        let middle = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]));
        let mut places = Self { middle, low, cells_per_metre, block: vec![0; CELLS] };

        // A counting sort by the cells' places on the curve.
        let curve: Vec<usize> = (0..CELLS).map(|i| hilbert(cell_of(i))).collect();
        let at: Vec<usize> = points.iter().map(|p| curve[places.index(*p)]).collect();
        let mut first = vec![0; CELLS + 1];
        for h in &at {
            first[h + 1] += 1;
        }
        for h in 0..CELLS {
            first[h + 1] += first[h];
        }
        for (block, h) in places.block.iter_mut().zip(curve) {
            *block = ((first[h] + first[h + 1]) / (2 * BLOCK)) as u16;
        }
        let mut order = vec![0; points.len()];
        for (i, h) in at.into_iter().enumerate() {
            order[first[h]] = i;
            first[h] += 1;
        }
        (places, order)
    }

    /// The block of the table where the postures nearest to a place are.
    #[inline(always)]
    pub fn block(&self, place: [f64; 3]) -> usize {
        usize::from(self.block[self.index(place)])
    }

    /// Index of the cell of a place, or of the one nearest to it.
    #[inline(always)]
    fn index(&self, p: [f64; 3]) -> usize {
        let last = f64::from((1u32 << BITS) - 1);
        let along =
            |k: usize| ((p[k] - self.low[k]) * self.cells_per_metre[k]).max(0.0).min(last) as usize;
        along(0) | along(1) << BITS | along(2) << (2 * BITS)
    }
}

/// The cell of an index.
fn cell_of(index: usize) -> [u32; 3] {
    [0, BITS, 2 * BITS].map(|shift| (index >> shift) as u32 & ((1 << BITS) - 1))
}

/// Place of a cell on Hilbert's curve, by the bit exchanges of Skilling (2004).
fn hilbert(mut x: [u32; 3]) -> usize {
    let top = 1u32 << (BITS - 1);
    let mut bit = top;
    while bit > 1 {
        let below = bit - 1;
        for i in 0..3 {
            if x[i] & bit != 0 {
                x[0] ^= below;
            } else {
                let exchanged = (x[0] ^ x[i]) & below;
                x[0] ^= exchanged;
                x[i] ^= exchanged;
            }
        }
        bit >>= 1;
    }
    x[1] ^= x[0];
    x[2] ^= x[1];
    let mut flipped = 0;
    bit = top;
    while bit > 1 {
        if x[2] & bit != 0 {
            flipped ^= bit - 1;
        }
        bit >>= 1;
    }
    let mut place = 0;
    for bit in (0..BITS).rev() {
        for coordinate in x {
            place = place << 1 | ((coordinate ^ flipped) >> bit & 1) as usize;
        }
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_visits_every_cell_from_neighbour_to_neighbour() {
        let mut cells = vec![None; CELLS];
        for i in 0..CELLS {
            let cell = cell_of(i);
            assert_eq!(cells[hilbert(cell)].replace(cell), None, "visited twice");
        }
        let cells: Vec<[u32; 3]> = cells.into_iter().flatten().collect();
        assert_eq!(cells.len(), CELLS);
        for pair in cells.windows(2) {
            let steps: u32 = (0..3).map(|k| pair[0][k].abs_diff(pair[1][k])).sum();
            assert_eq!(steps, 1, "{pair:?}");
        }
    }

    #[test]
    fn a_place_is_found_where_its_posture_stands() {
        // A grid of places, the same in every cell.
        let points: Vec<[f64; 3]> = (0..8192)
            .map(|i| [i % 32, i / 32 % 16, i / 512].map(|x| f64::from(x) * 0.1 - 4.0))
            .collect();
        let (places, order) = Places::new(&points);
        let mut seen = order.clone();
        seen.sort_unstable();
        assert!(seen.into_iter().eq(0..points.len()), "an order holds each once");
        for (at, i) in order.into_iter().enumerate() {
            let found = places.block(points[i]);
            assert!(found.abs_diff(at / BLOCK) <= 1, "{found} for {}", at / BLOCK);
        }
        // Places outside belong to the border.
        assert_eq!(places.block([-1e9; 3]), places.block(points[0]));
        assert!(places.block([f64::INFINITY; 3]) < 8192 / BLOCK + 1);
    }
}
