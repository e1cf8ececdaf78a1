//! Start points: the best of a few sampled postures, drawn for each target and attempt
//! from a random stream of its own.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use crate::chain::{Chain, JointKind, Postures};
use crate::kinematics::{Workspace, forward};
use crate::task::Goal;

/// Postures in a chain's table.
const TABLE: usize = 8192;
/// Seed of the table: the same for every call, since calls choose windows of it.
const TABLE_SEED: u64 = 0x6167_7269_6b00_0001;
/// Postures compared for one start.
pub(super) const WINDOW: usize = 64;
/// Postures compared in one go.
const STRIDE: usize = 16;
/// Every so many attempts one starts anywhere, so that no start is out of the question.
const ANYWHERE: u32 = 4;

/// What a start is compared with the goal by.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ranking {
    /// Tool point in the last joint's frame, m.
    pub point: [f32; 3],
    /// Squared length per radian for the frame's axes, m^2; zero leaves them out.
    pub axes: f32,
    /// A direction in the last joint's frame that has to meet the goal's z axis, with its
    /// squared length per radian, m^2; zero leaves it out.
    pub direction: ([f32; 3], f32),
}

/// Draws starts. A target's stream depends on the seed, the target's index and the attempt
/// alone, so that answers do not depend on slices, lanes or threads.
#[derive(Debug, Clone)]
pub(super) struct Sampler<'a> {
    seed: u64,
    first_index: u64,
    postures: &'a Postures,
    ranking: Ranking,
}

impl<'a> Sampler<'a> {
    /// A sampler over the joints' limits.
    pub fn new(chain: &'a Chain, ranking: Ranking, seed: u64, first_index: u64) -> Self {
        let postures = chain.postures(sample_postures);
        Self { seed, first_index, postures, ranking }
    }

    /// What alone decides the random numbers of an attempt at a target.
    #[inline(always)]
    pub fn key(&self, row: usize, attempt: u32) -> u64 {
        let index = self.first_index.wrapping_add(row as u64);
        mix(mix(mix(self.seed ^ 0x9e37_79b9_7f4a_7c15) ^ index) ^ u64::from(attempt))
    }

    /// The start of attempt `attempt` at target `row`.
    #[inline(always)]
    pub fn sample(&self, row: usize, attempt: u32, goal: &Goal<f64>, q: &mut [f64]) {
        let key = self.key(row, attempt);
        if attempt % ANYWHERE == ANYWHERE - 1 {
            draw(&mut Xoshiro256PlusPlus::seed_from_u64(key), &self.postures.ranges, q);
            return;
        }
        let windows = (TABLE - WINDOW) as u64;
        let first = ((u128::from(key) * u128::from(windows)) >> 64) as usize;
        let best = self.nearest(first, goal);
        q.copy_from_slice(&self.postures.q[best * q.len()..(best + 1) * q.len()]);
    }

    /// The posture of a window whose frame comes nearest to the goal.
    ///
    /// Every operation is a single-precision one that no instruction set fuses, so that the
    /// choice is the same at every SIMD level. One plain pass over the window a term: such
    /// loops become vector instructions whatever they are inlined into.
    #[inline(always)]
    fn nearest(&self, first: usize, goal: &Goal<f64>) -> usize {
        let row = |row: usize| window(&self.postures.frames[row][first..]);
        let Ranking { point, axes: weight, direction: (along, direction_weight) } = self.ranking;
        // |a - b|^2 of unit vectors is 2 - 2 a.b, and for small angles their angle squared;
        // three axes count each rotation twice. What is the same for all postures is left
        // out, and what remains is linear in the axes.
        let mut distance = [0.0f32; WINDOW];
        for j in 0..3 {
            for k in 0..3 {
                let wanted = weight * goal.axes[j][k] as f32
                    + 2.0 * direction_weight * along[j] * goal.axes[2][k] as f32;
                add_product(&mut distance, row(3 + 3 * j + k), -wanted);
            }
        }
        for k in 0..3 {
            let mut way = [-goal.position[k] as f32; WINDOW];
            add_product(&mut way, row(k), 1.0);
            for (j, along) in point.iter().enumerate() {
                add_product(&mut way, row(3 + 3 * j + k), *along);
            }
            for (d, w) in distance.iter_mut().zip(&way) {
                *d += w * w;
            }
        }
        first + least(&distance)
    }
}

/// The first numbers of a column of the table.
#[inline(always)]
fn window(column: &[f32]) -> &[f32; WINDOW] {
    match column.first_chunk() {
        Some(window) => window,
        // The first posture of a window leaves room for all of it.
        None => &[0.0; WINDOW],
    }
}

/// `sum += column * factor`
#[inline(always)]
fn add_product(sum: &mut [f32; WINDOW], column: &[f32; WINDOW], factor: f32) {
    for (s, x) in sum.iter_mut().zip(column) {
        *s += x * factor;
    }
}

/// Index of the least number, the first of equals.
#[inline(always)]
fn least(numbers: &[f32; WINDOW]) -> usize {
    let mut least = [f32::INFINITY; STRIDE];
    for group in numbers.as_chunks::<STRIDE>().0 {
        for (l, x) in least.iter_mut().zip(group) {
            *l = if *x < *l { *x } else { *l };
        }
    }
    let least = least.iter().fold(f32::INFINITY, |a, b| if *b < a { *b } else { a });
    numbers.iter().position(|x| *x == least).unwrap_or(0)
}

/// Lower end and width per joint value; continuous joints sample [-pi, pi].
fn ranges(chain: &Chain) -> Vec<(f64, f64)> {
    use std::f64::consts::{PI, TAU};
    chain
        .variables()
        .iter()
        .map(|v| match v.kind {
            JointKind::Continuous => (-PI, TAU),
            _ => (v.lower, v.upper - v.lower),
        })
        .collect()
}

/// A table of uniform random postures and their frames.
fn sample_postures(chain: &Chain) -> Postures {
    let mut stream = Xoshiro256PlusPlus::seed_from_u64(TABLE_SEED);
    let mut workspace = Workspace::<f64>::new(chain.compiled());
    let mut q = vec![0.0; chain.dof()];
    let mut postures = Postures { ranges: ranges(chain), ..Postures::default() };
    for _ in 0..TABLE {
        draw(&mut stream, &postures.ranges, &mut q);
        forward(chain.compiled(), &q, &mut workspace);
        postures.q.extend_from_slice(&q);
        let axes = workspace.joint_axes();
        let numbers = workspace.tool_point([0.0; 3]).into_iter().chain(axes.into_iter().flatten());
        for (column, x) in postures.frames.iter_mut().zip(numbers) {
            column.push(x as f32);
        }
    }
    postures
}

fn draw(stream: &mut Xoshiro256PlusPlus, ranges: &[(f64, f64)], q: &mut [f64]) {
    for (x, (lower, width)) in q.iter_mut().zip(ranges) {
        *x = width * uniform(stream) + lower;
    }
}

/// A number in [0, 1) with 53 random bits.
fn uniform(stream: &mut Xoshiro256PlusPlus) -> f64 {
    (stream.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

/// The finaliser of SplitMix64 (Steele, Lea and Flood 2014): spreads every bit over all.
fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
