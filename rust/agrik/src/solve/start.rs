//! Start points: of the sampled postures around a target, the one that comes nearest to
//! it; for later attempts the nearest of a few from everywhere, and now and then any.

use super::postures::{BLOCK, FEATURES, Places, Postures};
use crate::call::Request;
use crate::chain::{Chain, JointKind, Variable};
use crate::kinematics::tool_poses;
use crate::lanes::{dot, sub};
use crate::random::{Sequence, mix};
use crate::task::{Goal, pose_goal, pose_parts};

/// Postures in the part of a chain's table that is sorted by place, and in the part that
/// is left in the order in which they were drawn, so that its windows hold all places.
const SORTED: usize = 8192;
const SCATTERED: usize = 4096;
/// Seed of the table: the same for every call, since calls choose windows of it.
const TABLE_SEED: u64 = 0x6167_7269_6b00_0001;
/// Blocks of postures compared for one start.
const WINDOW: usize = 4;
/// Attempts that search the windows around the target, each another one.
const NEARBY: u32 = 4;
/// Every so many attempts after these one starts anywhere, so that no start is out of the
/// question.
const ANYWHERE: u32 = 3;
/// Ways of slides longer than so many sizes of the robot are sampled near zero alone.
const LONG: f64 = 100.0;
/// Share of a joint's range by which a second attempt starts beside the caller's start.
const BESIDE: f64 = 0.02;
/// Low bits of a distance that give way to the posture's number in its window.
const NUMBER: u32 = (WINDOW * BLOCK - 1) as u32;

/// What a start is compared with the goal by.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ranking {
    /// The goal says where the tool point has to be.
    pub placed: bool,
    /// The call's tool point seen from the chain's own, in the last joint's frame, m.
    pub shift: [f64; 3],
    /// Squared length per radian for the frame's axes, m^2; zero leaves them out.
    pub axes: f64,
    /// A direction in the last joint's frame that has to meet the goal's z axis, with its
    /// squared length per radian, m^2; zero leaves it out.
    pub direction: ([f64; 3], f64),
}

/// The windows of a part of the table.
const fn windows(postures: usize) -> usize {
    postures / BLOCK - WINDOW + 1
}

/// Draws starts. A target's starts depend on the seed, the target and its index, and the
/// attempt alone, so that answers do not depend on slices, lanes or threads.
#[derive(Debug, Clone)]
pub(super) struct Sampler<'a> {
    seed: u64,
    first_index: u64,
    /// Where its targets are some of another request's: which of them.
    pub chosen: Option<&'a [usize]>,
    postures: &'a Postures,
    ranking: Ranking,
}

impl<'a> Sampler<'a> {
    /// A sampler over the joints' limits.
    pub fn new(request: &Request<'a>, ranking: Ranking) -> Self {
        let postures = request.chain().memo(sample_postures);
        let (seed, first_index) = (request.seed(), request.first_index());
        Self { seed, first_index, chosen: None, postures, ranking }
    }

    /// What alone decides the random numbers of an attempt at a target.
    #[inline(always)]
    pub fn key(&self, row: usize, attempt: u32) -> u64 {
        let row = self.chosen.map_or(row, |rows| rows[row]);
        let index = self.first_index.wrapping_add(row as u64);
        mix(mix(mix(self.seed ^ 0x9e37_79b9_7f4a_7c15) ^ index) ^ u64::from(attempt))
    }

    /// The start of attempt `attempt` at target `row`.
    #[inline(always)]
    pub fn sample(&self, row: usize, attempt: u32, goal: &Goal<f64>, q: &mut [f64]) {
        let key = self.key(row, attempt);
        let window = if self.ranking.placed && attempt < NEARBY {
            self.window_near(goal, attempt as usize, key)
        } else if attempt % ANYWHERE == ANYWHERE - 1 {
            let mut stream = Sequence::new(key);
            draw(&mut stream, &self.postures.ranges, q);
            if (attempt / ANYWHERE).is_multiple_of(2) {
                stand(&mut stream, &self.postures.ranges, q);
            }
            return;
        } else {
            let drawn = u128::from(key) * windows(SCATTERED) as u128;
            SORTED / BLOCK + (drawn >> 64) as usize
        };
        let dof = q.len();
        let best = self.nearest(window, goal);
        let ranges = &self.postures.ranges;
        for ((to, from), (lower, width)) in
            q.iter_mut().zip(&self.postures.q[best * dof..]).zip(ranges)
        {
            // Single precision may have rounded an end outward.
            *to = f64::from(*from).max(*lower).min(lower + width);
        }
    }

    /// A start around another one, the farther the later the attempt.
    pub fn around(&self, row: usize, attempt: u32, q: &mut [f64]) {
        let mut stream = Sequence::new(self.key(row, attempt));
        let share = BESIDE * f64::from(attempt * attempt);
        for (x, (_, width)) in q.iter_mut().zip(&self.postures.ranges) {
            *x += share * width * (2.0 * stream.uniform() - 1.0);
        }
    }

    /// A start near the end `q` of another attempt: with some joint values put elsewhere.
    ///
    /// What keeps an end from being a solution is often one joint at the wrong limit.
    pub fn hop(&self, row: usize, attempt: u32, q: &mut [f64]) {
        let mut stream = Sequence::new(self.key(row, attempt));
        let surely = (stream.word() % q.len() as u64) as usize;
        for (i, x) in q.iter_mut().enumerate() {
            if i == surely || stream.word() >> 62 == 0 {
                let range = &self.postures.ranges[i..=i];
                let mut value = [0.0];
                draw(&mut stream, range, &mut value);
                stand(&mut stream, range, &mut value);
                *x = value[0];
            }
        }
    }

    /// First block of the window around the goal's place; for later attempts of those next
    /// to it, by turns after and before it.
    ///
    /// A window of an even number of blocks has the goal's block on one side or the other of
    /// its middle; the random stream says on which.
    #[inline(always)]
    fn window_near(&self, goal: &Goal<f64>, attempt: usize, key: u64) -> usize {
        let mut place = goal.position;
        if self.ranking.axes > 0.0 {
            // Where the chain's own tool point is while the call's is at its goal.
            for (axis, along) in goal.axes.iter().zip(self.ranking.shift) {
                for (x, a) in place.iter_mut().zip(axis) {
                    *x -= a * along;
                }
            }
        }
        let windows = windows(SORTED);
        let block = self.postures.places.block(place) + (key & 1) as usize;
        let around = block.saturating_sub(WINDOW / 2).min(windows - 1);
        let away = attempt.div_ceil(2) * WINDOW;
        let beside = if attempt % 2 == 1 { around + away } else { around + windows - away };
        beside % windows
    }

    /// The posture of a window whose frame comes nearest to the goal.
    #[inline(always)]
    fn nearest(&self, window: usize, goal: &Goal<f64>) -> usize {
        let Ranking { shift, axes, direction: (_, turned), .. } = self.ranking;
        let (constant, factors) = self.distance(goal);
        // Rows that do not count are not read.
        if shift != [0.0; 3] {
            self.search::<FEATURES>(window, constant, &factors)
        } else if axes > 0.0 || turned > 0.0 {
            self.search::<13>(window, constant, &factors)
        } else {
            self.search::<4>(window, constant, &factors)
        }
    }

    /// The squared distance between a goal and a posture's frame as a linear function of
    /// the table's rows: its constant term and its factors.
    #[inline(always)]
    fn distance(&self, goal: &Goal<f64>) -> (f32, [f32; FEATURES]) {
        let Ranking { shift, axes, direction: (along, turned), .. } = self.ranking;
        let middle = self.postures.places.middle;
        let p = sub(goal.position, middle);
        let mut factors = [0.0; FEATURES];
        factors[0] = 1.0;
        for k in 0..3 {
            factors[1 + k] = (-2.0 * p[k]) as f32;
            for j in 0..3 {
                // |a - b|^2 of unit vectors is 2 - 2 a.b, and for small angles their angle
                // squared; three axes count each rotation twice.
                let wanted = axes * goal.axes[j][k] + 2.0 * turned * along[j] * goal.axes[2][k];
                factors[4 + 3 * j + k] = (-wanted - 2.0 * shift[j] * p[k]) as f32;
            }
            factors[13 + k] = (2.0 * shift[k]) as f32;
        }
        let constant = dot(p, p) + dot(shift, shift) + 3.0 * axes + 2.0 * turned;
        (constant as f32, factors)
    }

    /// The posture of least distance in a window, by the table's first `N` rows.
    ///
    /// Every operation is a single-precision one that no instruction set fuses, so that the
    /// choice is the same at every SIMD level. Loops over a block, without choices, become
    /// vector instructions whatever they are inlined into.
    #[inline(always)]
    fn search<const N: usize>(
        &self,
        window: usize,
        constant: f32,
        factors: &[f32; FEATURES],
    ) -> usize {
        let mut least = [f32::INFINITY; BLOCK];
        let blocks = &self.postures.blocks[window..window + WINDOW];
        for (b, block) in blocks.iter().enumerate() {
            let mut distance = [constant; BLOCK];
            for (row, factor) in block[..N].iter().zip(factors) {
                for (d, x) in distance.iter_mut().zip(row) {
                    *d += factor * x;
                }
            }
            for (i, (l, d)) in least.iter_mut().zip(&distance).enumerate() {
                // The number rides along, so that no second pass has to look for it.
                let d = f32::from_bits(d.to_bits() & !NUMBER | (b * BLOCK + i) as u32);
                *l = if d < *l { d } else { *l };
            }
        }
        let least = least.iter().fold(f32::INFINITY, |a, b| if *b < a { *b } else { a });
        window * BLOCK + (least.to_bits() & NUMBER) as usize
    }
}

/// Lower end and width of what each joint value is drawn from.
fn ranges(chain: &Chain) -> Vec<(f64, f64)> {
    chain.variables().iter().map(|v| range(chain, v)).collect()
}

/// Lower end and width of what a joint value is drawn from: of joints that turn at most the
/// turn about the middle of the limits, of slides without limits to speak of the ways of the
/// robot's own size about zero.
pub(super) fn range(chain: &Chain, v: &Variable) -> (f64, f64) {
    let (half, wide) = match v.kind {
        JointKind::Prismatic => (chain.reach().size, LONG * chain.reach().size),
        _ => (std::f64::consts::PI, std::f64::consts::TAU),
    };
    if v.upper - v.lower <= wide {
        return (v.lower, v.upper - v.lower);
    }
    // Limits may be near the middle on one side.
    let middle = if v.kind == JointKind::Prismatic { v.near_zero() } else { v.middle() };
    let lower = (middle - half).min(v.upper - 2.0 * half).max(v.lower);
    (lower, 2.0 * half)
}

/// A table of uniform random postures and their frames.
fn sample_postures(chain: &Chain) -> Postures {
    let dof = chain.dof();
    let ranges = ranges(chain);
    let mut stream = Sequence::new(TABLE_SEED);
    let mut q = vec![0.0; (SORTED + SCATTERED) * dof];
    for (i, posture) in q.chunks_exact_mut(dof).enumerate() {
        draw(&mut stream, &ranges, posture);
        if i >= SORTED + SCATTERED / 2 {
            stand(&mut stream, &ranges, posture);
        }
    }
    let mut poses = vec![0.0; (SORTED + SCATTERED) * 16];
    tool_poses(chain, &q, &mut poses);
    let tail = &chain.compiled().tail;
    // Of a tool far out, where its nearer part is.
    let own = tail.translation;
    let near = chain.compiled().pose_point(own);
    let back = [0, 1, 2].map(|k| near[k] - own[k]);
    let frame = |pose: &[f64; 16]| {
        let (position, rotation) = pose_parts(pose);
        let mut goal = pose_goal(position, rotation, tail);
        for (axis, along) in goal.axes.iter().zip(back) {
            for (x, a) in goal.position.iter_mut().zip(axis) {
                *x += a * along;
            }
        }
        goal
    };
    let frames: Vec<Goal<f64>> = poses.as_chunks().0.iter().map(frame).collect();
    let points: Vec<[f64; 3]> = frames[..SORTED].iter().map(|frame| frame.position).collect();
    let (places, order) = Places::new(&points);

    let mut blocks = vec![[[0.0; BLOCK]; FEATURES]; (SORTED + SCATTERED) / BLOCK];
    let mut ordered = Vec::with_capacity(q.len());
    for (at, i) in order.into_iter().chain(SORTED..SORTED + SCATTERED).enumerate() {
        ordered.extend(q[i * dof..(i + 1) * dof].iter().map(|x| *x as f32));
        let Goal { position, axes } = frames[i];
        let p = [0, 1, 2].map(|k| position[k] - places.middle[k]);
        let [x, y, z] = axes;
        let along = axes.map(|axis| dot(axis, p));
        let features: [f64; FEATURES] = [
            dot(p, p),
            p[0],
            p[1],
            p[2],
            x[0],
            x[1],
            x[2],
            y[0],
            y[1],
            y[2],
            z[0],
            z[1],
            z[2],
            along[0],
            along[1],
            along[2],
        ];
        for (row, x) in blocks[at / BLOCK].iter_mut().zip(features) {
            row[at % BLOCK] = x as f32;
        }
    }
    Postures { ranges, q: ordered, blocks, places }
}

fn draw(stream: &mut Sequence, ranges: &[(f64, f64)], q: &mut [f64]) {
    for (x, (lower, width)) in q.iter_mut().zip(ranges) {
        *x = width * stream.uniform() + lower;
    }
}

/// Puts about half of the joint values where people put them: at a limit, in the middle, at
/// zero or a quarter turn. The solutions there have few starts that lead to them.
fn stand(stream: &mut Sequence, ranges: &[(f64, f64)], q: &mut [f64]) {
    use std::f64::consts::FRAC_PI_2;
    for (x, (lower, width)) in q.iter_mut().zip(ranges) {
        let place = match stream.word() >> 60 {
            0 | 1 => *lower,
            2 | 3 => lower + width,
            4 => lower + 0.5 * width,
            5 => 0.0,
            6 => FRAC_PI_2,
            7 => -FRAC_PI_2,
            _ => *x,
        };
        *x = place.max(*lower).min(lower + width);
    }
}
