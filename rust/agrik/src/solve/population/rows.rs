//! The genes of a population once more, individual by individual: what is needed of one
//! lies together, so that the individuals of other lanes come with whole vectors.

use super::evaluator::Population;
use crate::lanes::{Real, WIDEST, Words};

/// Above this number, 2^52, the lowest bits of a double are a whole number.
pub(super) const WHOLE: f64 = 4_503_599_627_370_496.0;

/// Each individual's genes in as many vectors as they need.
pub(super) struct Rows<R> {
    vectors: Vec<R>,
    /// Vectors of one individual.
    each: usize,
}

impl<R: Real> Rows<R> {
    /// The rows of a population.
    #[inline(always)]
    pub fn of(population: &Population<R>) -> Self {
        let each = population.dof.div_ceil(R::WIDTH);
        let count = population.blocks() * R::WIDTH * each;
        let mut rows = Self { vectors: vec![R::zero(); count], each };
        for block in 0..population.blocks() {
            rows.update(block, population.block(block));
        }
        rows
    }

    /// Room for what is gathered: a vector for each gene, and some that stay unused.
    pub fn buffer(&self) -> Vec<R> {
        vec![R::zero(); self.each * R::WIDTH]
    }

    /// Takes over the genes of a block.
    #[inline(always)]
    pub fn update(&mut self, block: usize, genes: &[R]) {
        // Loops of a length known beforehand, for the commonest arms in the commonest lanes.
        match self.each {
            2 => self.update_each(2, block, genes),
            each => self.update_each(each, block, genes),
        }
    }

    #[inline(always)]
    fn update_each(&mut self, each: usize, block: usize, genes: &[R]) {
        let size = each * R::WIDTH;
        let rows = &mut self.vectors[block * size..][..size];
        for k in 0..each {
            let mut square = [R::zero(); WIDEST];
            for lane in 0..R::WIDTH {
                if let Some(gene) = genes.get(k * R::WIDTH + lane) {
                    square[lane] = *gene;
                }
            }
            R::transpose(&mut square);
            for lane in 0..R::WIDTH {
                rows[lane * each + k] = square[lane];
            }
        }
    }

    /// The genes of the individuals whose numbers stand in the lanes.
    #[inline(always)]
    pub fn gather(&self, from: R, genes: &mut [R]) {
        let from = places(from);
        for (k, genes) in genes.chunks_exact_mut(R::WIDTH).enumerate() {
            let mut square = [R::zero(); WIDEST];
            for lane in 0..R::WIDTH {
                square[lane] = self.vectors[from[lane] * self.each + k];
            }
            R::transpose(&mut square);
            genes.copy_from_slice(&square[..R::WIDTH]);
        }
    }

    /// [`Rows::gather`] of some individuals minus the same of others.
    #[inline(always)]
    pub fn difference(&self, a: R, b: R, genes: &mut [R]) {
        let (a, b) = (places(a), places(b));
        // Loops of a length known beforehand, for the commonest arms in the commonest lanes.
        if self.each == 2 {
            return self.difference_each::<2>(a, b, genes);
        }
        for (k, genes) in genes.chunks_exact_mut(R::WIDTH).enumerate() {
            let mut square = [R::zero(); WIDEST];
            for lane in 0..R::WIDTH {
                let (a, b) = (a[lane] * self.each + k, b[lane] * self.each + k);
                square[lane] = self.vectors[a] - self.vectors[b];
            }
            R::transpose(&mut square);
            genes.copy_from_slice(&square[..R::WIDTH]);
        }
    }

    /// [`Rows::difference`] where an individual has so many vectors.
    #[inline(always)]
    fn difference_each<const EACH: usize>(&self, a: Places, b: Places, genes: &mut [R]) {
        let rows = self.vectors.as_chunks::<EACH>().0;
        let mut squares = [[R::zero(); WIDEST]; EACH];
        for lane in 0..R::WIDTH {
            let (a, b) = (&rows[a[lane]], &rows[b[lane]]);
            for k in 0..EACH {
                squares[k][lane] = a[k] - b[k];
            }
        }
        for (genes, square) in genes.chunks_exact_mut(R::WIDTH).zip(&mut squares) {
            R::transpose(square);
            genes.copy_from_slice(&square[..R::WIDTH]);
        }
    }
}

/// Numbers of individuals, one for each lane.
type Places = [usize; WIDEST];

/// Whole numbers as words, without the bits that mark them as doubles.
#[inline(always)]
fn places<R: Real>(individuals: R) -> Places {
    let mut words = [0; WIDEST];
    (individuals + R::splat(WHOLE)).to_words().store(&mut words);
    let mut places = [0; WIDEST];
    for lane in 0..R::WIDTH {
        places[lane] = words[lane] as u32 as usize;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{Kernel, Level, dispatch};

    /// Gathers individuals of populations whose genes say whose they are.
    struct Gathering;

    impl Kernel for Gathering {
        type Output = ();
        #[inline(always)]
        fn run<R: Real>(self) {
            for (size, dof) in [(4, 1), (13, 3), (16, 6), (100, 7), (33, 8), (9, 12)] {
                let mut population = Population::<R>::new(size, dof);
                let tell = |i: usize, g: usize| (100 * i + g) as f64;
                for i in 0..size {
                    let genes: Vec<f64> = (0..dof).map(|g| tell(i, g)).collect();
                    population.write(i, &genes);
                }
                let mut rows = Rows::of(&population);
                population.write(1, &vec![0.5; dof]);
                rows.update(1 / R::WIDTH, population.block(1 / R::WIDTH));
                let told = |i: usize, g: usize| if i == 1 { 0.5 } else { tell(i, g) };
                let (mut genes, mut difference) = (rows.buffer(), rows.buffer());
                for first in 0..size {
                    let (mut a, mut b) = (R::zero(), R::zero());
                    let of = |lane: usize| ((first + 3 * lane) % size, (first + lane + 1) % size);
                    for lane in 0..R::WIDTH {
                        a.set_lane(lane, of(lane).0 as f64);
                        b.set_lane(lane, of(lane).1 as f64);
                    }
                    rows.gather(a, &mut genes);
                    rows.difference(a, b, &mut difference);
                    for lane in 0..R::WIDTH {
                        let (i, j) = of(lane);
                        for g in 0..dof {
                            assert_eq!(genes[g].lane(lane), told(i, g));
                            assert_eq!(difference[g].lane(lane), told(i, g) - told(j, g));
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn individuals_come_to_other_lanes() {
        for level in Level::ALL.into_iter().filter(|level| level.is_available()) {
            dispatch(level, Gathering);
        }
    }
}
