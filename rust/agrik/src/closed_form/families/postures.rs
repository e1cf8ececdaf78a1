//! The postures of one goal, and how candidates become such.

use std::f64::consts::{PI, TAU};

use crate::closed_form::geometry::rigid::Rigid;
use crate::closed_form::geometry::serial::Serial;
use crate::lanes::{Lanes, Real, WIDEST};

/// Most postures of a goal that are kept; sixteen are all that there are, but for singular
/// families.
pub const MOST: usize = 24;
/// Postures nearer to one another are one, rad.
const SAME: f64 = 1e-5;
/// Postures with less left (arm lengths and rad) are answers.
pub const NEAR: f64 = 1e-10;
/// Newton's steps stop below this.
pub const FINE: f64 = 1e-13;
/// A candidate of a closed form that misses by more (squared) is none.
const FAR: f64 = 1e-4;
/// Newton's steps of a candidate of axes that are only almost what they are taken for.
const STEPS: usize = 6;

/// The postures of one goal.
#[derive(Debug, Clone, Copy)]
pub struct Set {
    /// Joint values, rad, in (-pi, pi].
    pub q: [[f64; 6]; MOST],
    /// How many.
    pub count: usize,
    /// Near which singularities each is, as `Candidate::flags` has it.
    pub singular: [u8; MOST],
    /// Joints that the pose leaves free, a bit each.
    pub free: u8,
    /// Noise of the polynomial's samples.
    pub noise: f64,
    /// Real roots that are certain.
    pub roots: usize,
    /// Places where there may be roots.
    pub places: usize,
    /// The other cut was asked as well.
    pub second: bool,
    /// Joints that some candidate left free, whether or not it reached the goal; a bit each.
    pub open: u8,
    /// There is no posture, for sure.
    pub none: bool,
    /// There are more.
    pub more: bool,
}

impl Set {
    /// Nothing found yet.
    pub const EMPTY: Self = Self {
        q: [[0.0; 6]; MOST],
        count: 0,
        singular: [0; MOST],
        free: 0,
        noise: 0.0,
        roots: 0,
        places: 0,
        second: false,
        open: 0,
        none: false,
        more: false,
    };

    /// The postures.
    pub fn postures(&self) -> &[[f64; 6]] {
        &self.q[..self.count]
    }

    /// Takes a posture in that no other one is, in (-pi, pi], with its singularities and free
    /// joints.
    #[inline(always)]
    fn put(&mut self, q: &[f64; 6], singular: u8, free: u8) {
        if self.count < MOST {
            self.q[self.count] = *q;
            self.singular[self.count] = singular;
            self.free |= free;
            self.count += 1;
        }
    }

    /// Takes a posture in, unless it is there; true where it is new.
    pub fn add(&mut self, q: &[f64; 6]) -> bool {
        self.add_with(q, 0, 0)
    }

    /// The same with its singularities and free joints.
    pub fn add_with(&mut self, q: &[f64; 6], singular: u8, free: u8) -> bool {
        let q = q.map(turned);
        let same = |other: &[f64; 6]| other.iter().zip(&q).all(|(a, b)| turned(a - b).abs() < SAME);
        if self.count == MOST || self.postures().iter().any(same) {
            return false;
        }
        self.put(&q, singular, free);
        true
    }

    /// Leaves the `most` postures that are nearest to given ones.
    pub fn keep_nearest(&mut self, most: usize, near: &[f64; 6]) {
        while self.count > most {
            let far = |q: &[f64; 6]| -> f64 {
                q.iter().zip(near).map(|(a, b)| turned(a - b).powi(2)).sum()
            };
            let all = self.postures().iter().map(far);
            let worst = all.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(i, _)| i);
            self.count -= 1;
            self.q.swap(worst, self.count);
            self.singular.swap(worst, self.count);
            self.more = true;
        }
    }

    /// In an order that does not depend on the way they were found.
    pub fn sort(&mut self) {
        let mut order = [0_u8; MOST];
        let all = self.postures();
        // Few, and mostly in order: insertion, of places rather than of postures.
        let mut moved = false;
        for i in 0..all.len() {
            let mut k = i;
            while k > 0 && before(&all[i], &all[usize::from(order[k - 1])]) {
                order[k] = order[k - 1];
                k -= 1;
                moved = true;
            }
            order[k] = i as u8;
        }
        if moved {
            for to in 0..self.count {
                let mut from = usize::from(order[to]);
                // What stood there has been moved to where its place was taken from.
                while from < to {
                    from = usize::from(order[from]);
                }
                self.q.swap(to, from);
                self.singular.swap(to, from);
            }
        }
    }
}

fn before(a: &[f64; 6], b: &[f64; 6]) -> bool {
    for (x, y) in a.iter().zip(b) {
        // Rounding does not decide.
        if (x - y).abs() > 1e-9 {
            return x < y;
        }
    }
    false
}

/// The nearest whole number, of numbers of ordinary size. The library's own function is a call
/// where the processor is not asked for more than the oldest of its kind have.
#[inline(always)]
pub fn whole(x: f64) -> f64 {
    const SHIFT: f64 = 6_755_399_441_055_744.0;
    (x + SHIFT) - SHIFT
}

/// An angle less whole turns, in (-pi, pi].
#[inline(always)]
pub fn turned(x: f64) -> f64 {
    let y = x - TAU * whole(x * (1.0 / TAU));
    if y <= -PI { y + TAU } else { y }
}

/// The same in each lane.
#[inline(always)]
fn turned_each<R: Real>(x: R) -> R {
    let y = x - R::splat(TAU) * (x * R::splat(1.0 / TAU)).round();
    R::select(y.le(R::splat(-PI)), y + R::splat(TAU), y)
}

/// Candidates of goals in the lanes, as they come out of a closed form.
pub struct Candidates<R> {
    pub q: [R; 6],
    /// Lanes where this is another one over again.
    pub merged: Lanes,
    /// Lanes near a singular shoulder, elbow, wrist.
    pub singular: [Lanes; 3],
    /// Lanes where a joint is free, with its bit.
    pub open: [(Lanes, u8); 2],
}

impl<R: Real> Candidates<R> {
    /// Puts what reaches the goals into their sets: lane `i` into `sets[i]`, or all of `lanes`
    /// lanes into the only one. `left` is what is left to the goals, squared.
    #[inline(always)]
    pub fn settle(
        &self,
        serial: &Serial<6>,
        (goal, left): (&Rigid<R>, R),
        lanes: usize,
        sets: &mut [Set],
    ) {
        let mut left = left;
        let used = u32::MAX >> (32 - lanes as u32);
        let near = R::bits(left.lt(R::splat(FAR))) & !self.merged & used;
        let rough = near & !R::bits(left.le(R::splat(FINE * FINE)));
        let mut q = self.q;
        if rough != 0 {
            let better = serial.approach(self.q, goal, STEPS, FINE);
            // What a lane's neighbours need leaves it as it is.
            let mask = R::mask_from_bits(rough);
            for k in 0..6 {
                q[k] = R::select(mask, better.q[k], q[k]);
            }
            left = R::select(mask, better.left, left);
        }
        let near = near & R::bits(left.le(R::splat(NEAR * NEAR)));
        let one = sets.len() == 1;
        for x in &mut q {
            *x = turned_each(*x);
        }
        let special = self.singular.iter().fold(0, |all, lanes| all | lanes);
        let open = self.open[0].0 | self.open[1].0;
        let mut marks = [(0_u8, 0_u8); WIDEST];
        for lane in each(used & (special | open)) {
            let (flags, free) = &mut marks[lane];
            for (k, lanes) in self.singular.iter().enumerate() {
                *flags |= ((lanes >> lane & 1) as u8) << k;
            }
            for (lanes, bit) in self.open {
                *free |= if lanes >> lane & 1 != 0 { bit } else { 0 };
            }
            sets[if one { 0 } else { lane }].open |= *free;
        }
        for lane in each(near) {
            let set = &mut sets[if one { 0 } else { lane }];
            let mut posture = [0.0; 6];
            for (x, from) in posture.iter_mut().zip(&q) {
                *x = from.lane(lane);
            }
            let (flags, free) = marks[lane];
            // Whether steps were needed is the goal's own matter, not that of its neighbours.
            if rough >> lane & 1 != 0 {
                set.add_with(&posture, flags, free);
            } else {
                set.put(&posture, flags, free);
            }
        }
    }
}

/// The lanes of which there is a bit, in their order.
#[inline(always)]
fn each(mut lanes: Lanes) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = lanes.trailing_zeros() as usize;
        lanes &= lanes.wrapping_sub(1);
        (lane < WIDEST).then_some(lane)
    })
}
