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
    /// choice is the same at every SIMD level.
    #[inline(always)]
    fn nearest(&self, first: usize, goal: &Goal<f64>) -> usize {
        let frame = |row: usize| &self.postures.frames[row][first..first + WINDOW];
        let to = [0, 1, 2].map(|k| goal.position[k] as f32);
        let axes = goal.axes.map(|axis| axis.map(|x| x as f32));
        let Ranking { point, axes: weight, direction: (along, direction_weight) } = self.ranking;
        let mut best = [f32::INFINITY; STRIDE];
        let mut chosen = [0u32; STRIDE];
        let rows: [&[f32]; 12] = std::array::from_fn(frame);
        for start in (0..WINDOW).step_by(STRIDE) {
            for lane in 0..STRIDE {
                let i = start + lane;
                let at = |row: usize| rows[row][i];
                let mut distance = 0.0f32;
                for k in 0..3 {
                    let tool =
                        at(k) + at(3 + k) * point[0] + at(6 + k) * point[1] + at(9 + k) * point[2];
                    distance += (tool - to[k]) * (tool - to[k]);
                }
                // |a - b|^2 of unit vectors is 2 - 2 a.b, and for small angles their angle
                // squared; three axes count each rotation twice.
                let mut cosines = 0.0f32;
                let mut cosine = 0.0f32;
                for k in 0..3 {
                    cosines +=
                        at(3 + k) * axes[0][k] + at(6 + k) * axes[1][k] + at(9 + k) * axes[2][k];
                    let d = at(3 + k) * along[0] + at(6 + k) * along[1] + at(9 + k) * along[2];
                    cosine += d * axes[2][k];
                }
                distance += weight * (3.0 - cosines) + direction_weight * (2.0 - 2.0 * cosine);
                let better = distance < best[lane];
                best[lane] = if better { distance } else { best[lane] };
                chosen[lane] = if better { i as u32 } else { chosen[lane] };
            }
        }
        let mut lane = 0;
        for other in 1..STRIDE {
            if best[other] < best[lane] {
                lane = other;
            }
        }
        first + chosen[lane] as usize
    }
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
