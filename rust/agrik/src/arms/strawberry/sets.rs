//! What a target leaves open: the box, the set of s10, the set of theta, and why a set
//! is empty.

use super::{Angle, Arm, SLIDE_TOLERANCE, Turn};
use crate::call::Status;

/// A closed interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Smallest number.
    pub low: f64,
    /// Largest number.
    pub high: f64,
}

impl Interval {
    /// The numbers from `low` to `high`.
    #[inline]
    pub fn new(low: f64, high: f64) -> Self {
        Self { low, high }
    }

    /// The numbers in both intervals; `None` where they are more than `tolerance` apart.
    /// Intervals that just miss each other share the point between.
    #[inline]
    pub fn common(self, other: Self, tolerance: f64) -> Option<Self> {
        let both = Self { low: self.low.max(other.low), high: self.high.min(other.high) };
        if both.low <= both.high {
            return Some(both);
        }
        let middle = both.middle();
        (both.low - both.high <= tolerance).then_some(Self { low: middle, high: middle })
    }

    /// The number halfway.
    #[inline]
    pub fn middle(self) -> f64 {
        0.5 * (self.low + self.high)
    }

    /// The number of the interval that is nearest to `x`.
    #[inline]
    pub fn nearest(self, x: f64) -> f64 {
        x.max(self.low).min(self.high)
    }

    /// True where `x` lies in the interval.
    #[inline]
    pub fn holds(self, x: f64) -> bool {
        self.low <= x && x <= self.high
    }
}

/// What lies in the way of a target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Place {
    /// Nothing: the target is reached.
    Reached = 0,
    /// Slide s10: the set (12) is empty.
    S10 = 1,
    /// Slide s21: the part (14) of the set of theta is empty.
    S21 = 2,
    /// Slide s32: the part (15) of the set of theta is empty.
    S32 = 3,
    /// Theta: slides s21 and s32 each leave some, but nothing in common, (16).
    Theta = 4,
    /// The target is not finite.
    BadInput = 5,
}

/// What lies in the way of a target, and by how much.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// What lies in the way.
    pub place: Place,
    /// Travel that the slide lacks, m: positive past its upper limit, negative past its
    /// lower one. For [`Place::Theta`] the distance in x and z that both slides lack
    /// together.
    pub amount: f64,
    /// [`Status::OutOfReach`] where no joint values reach the target,
    /// [`Status::NotFound`] where the method's choice of beta does not.
    pub status: Status,
}

impl Gap {
    pub(super) fn bad_input() -> Self {
        Self { place: Place::BadInput, amount: f64::INFINITY, status: Status::BadInput }
    }
    fn of(place: Place, amount: f64) -> Self {
        Self { place, amount, status: Status::OutOfReach }
    }
}

/// The set of theta at a given beta: its parts and what they have in common.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThetaSets {
    /// What slide s21 leaves, (14), rad.
    pub s21: Option<Interval>,
    /// What slide s32 leaves, (15), rad, with the branch that (15) forgets.
    pub s32: [Option<Interval>; 2],
    /// What both and the joint's limits leave, (16), rad, in ascending order.
    pub all: [Option<Interval>; 2],
}

/// Limits of `r sin(theta)` and `r cos(theta)` that the slides s21 and s32 impose, m.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    pub u: Interval,
    pub w: Interval,
}

impl Arm {
    /// Bounds of the targets, (5)-(10) corrected, m: nothing outside can be reached, not
    /// everything inside can.
    pub fn target_box(&self) -> [[f64; 3]; 2] {
        self.target_box
    }

    pub(super) fn find_target_box(&self) -> [[f64; 3]; 2] {
        let p = &self.parameters;
        let (low, high) = (&p.lower, &p.upper);
        // The reach is longest where |beta| is smallest, which need not be at a limit.
        let longest = self.reach(0.0f64.clamp(low[4], high[4]));
        let shortest = self.reach(low[4]).min(self.reach(high[4]));
        let across = |theta: f64| {
            let sin = theta.sin();
            [sin * longest, sin * shortest]
        };
        let most = across(high[3]).into_iter().fold(f64::MIN, f64::max);
        let least = across(low[3]).into_iter().fold(f64::MAX, f64::min);
        let down = 0.0f64.clamp(low[3], high[3]).cos() * longest;
        let up = low[3].cos().min(high[3].cos()) * shortest;
        let y = p.l1 - p.d[1];
        [
            [low[1] + p.d[0] - most, low[0] + y + self.rise[0], -high[2] + p.d[2] - down],
            [high[1] + p.d[0] - least, high[0] + y + self.rise[1], -low[2] + p.d[2] - up],
        ]
    }

    /// The set of s10, (12), m, or by how much it is empty.
    #[inline]
    pub fn s10_set(&self, target: [f64; 3]) -> Result<Interval, Gap> {
        let p = &self.parameters;
        let straight = target[1] - p.l1 + p.d[1];
        let reached = Interval::new(straight - self.rise[1], straight - self.rise[0]);
        let slide = Interval::new(p.lower[0], p.upper[0]);
        reached.common(slide, SLIDE_TOLERANCE).ok_or_else(|| {
            let amount = if reached.low > slide.high {
                reached.low - slide.high
            } else {
                reached.high - slide.low
            };
            Gap::of(Place::S10, amount)
        })
    }

    /// Beta that belongs to s10, (13), rad.
    #[inline]
    pub(super) fn beta_at(&self, target: [f64; 3], s10: f64) -> Angle {
        self.beta_angle(self.beta_of_sine(self.beta_sine(target, s10)))
    }

    /// Sine of beta that belongs to s10, (13), not held to any limit.
    #[inline]
    pub(super) fn beta_sine(&self, target: [f64; 3], s10: f64) -> f64 {
        let p = &self.parameters;
        (target[1] - s10 - p.l1 + p.d[1]) / p.l3
    }

    /// Beta of a sine, held to its limits.
    #[inline]
    pub(super) fn beta_of_sine(&self, sine: f64) -> Turn {
        let [low, high] = self.ends;
        if sine <= low.turn.sin {
            low.turn
        } else if sine >= high.turn.sin {
            high.turn
        } else {
            Turn::of_sine(sine)
        }
    }

    /// Beta within its limits, rad; the limits themselves as they were given.
    #[inline]
    pub(super) fn beta_angle(&self, beta: Turn) -> Angle {
        let [low, high] = self.ends;
        if beta == low.turn {
            low
        } else if beta == high.turn {
            high
        } else {
            beta.angle()
        }
    }

    #[inline]
    pub(super) fn window(&self, target: [f64; 3]) -> Window {
        let p = &self.parameters;
        let (x, z) = (p.d[0] - target[0], p.d[2] - target[2]);
        Window {
            u: Interval::new(p.lower[1] + x, p.upper[1] + x),
            w: Interval::new(z - p.upper[2], z - p.lower[2]),
        }
    }

    /// The set of theta, (14)-(16) corrected, at a given beta.
    pub fn theta_sets(&self, target: [f64; 3], beta: f64) -> ThetaSets {
        self.theta_sets_of(&self.window(target), self.reach(beta))
    }

    pub(super) fn theta_sets_of(&self, window: &Window, r: f64) -> ThetaSets {
        let p = &self.parameters;
        let joint = Interval::new(p.lower[3], p.upper[3]);
        // Rounding of a slide, as an angle.
        let tolerance = SLIDE_TOLERANCE / r;
        let whole = Interval::new(-1.0, 1.0);
        let share = |limits: Interval| {
            Interval::new(limits.low / r, limits.high / r).common(whole, tolerance)
        };
        let s21 = share(window.u).map(|s| Interval::new(s.low.asin(), s.high.asin()));
        let s32 = share(window.w).map(|c| Interval::new(c.high.acos(), c.low.acos()));
        let s32 = [s32.map(|t| Interval::new(-t.high, -t.low)), s32];
        let both = s21.and_then(|s| s.common(joint, tolerance));
        let mut all = [0, 1].map(|i| both?.common(s32[i]?, tolerance));
        if all[0].is_none() {
            all.swap(0, 1);
        }
        ThetaSets { s21, s32, all }
    }

    /// Why no theta is left at reaches from `r.low` to `r.high`: the slide that lacks
    /// travel, or else the distance that both lack together.
    pub(super) fn theta_gap(&self, window: &Window, r: Interval) -> Gap {
        let [low, high] = self.pitch_ends.map(|end| end.turn);
        let (sin_low, sin_high) = (low.sin, high.sin);
        // Theta = 0 reaches deepest, where it may.
        let deep = if sin_low <= 0.0 && sin_high >= 0.0 { 1.0 } else { low.cos.max(high.cos) };
        let (u, w) = (window.u, window.w);
        let least = (r.low * sin_low).min(r.high * sin_low);
        let most = (r.low * sin_high).max(r.high * sin_high);
        let deepest = r.high * deep;
        let highest = r.low * low.cos.min(high.cos);
        if least > u.high + SLIDE_TOLERANCE {
            return Gap::of(Place::S21, least - u.high);
        }
        if most < u.low - SLIDE_TOLERANCE {
            return Gap::of(Place::S21, most - u.low);
        }
        if deepest < w.low - SLIDE_TOLERANCE {
            return Gap::of(Place::S32, w.low - deepest);
        }
        if highest > w.high + SLIDE_TOLERANCE {
            return Gap::of(Place::S32, w.high - highest);
        }
        Gap::of(Place::Theta, self.window_distance(window, r))
    }

    /// The same at the one reach that a method chose, where others may do.
    #[inline(never)]
    pub(super) fn theta_gap_at(&self, target: [f64; 3], window: &Window, beta: Turn) -> Gap {
        let r = self.reach_of(beta);
        let mut gap = self.theta_gap(window, Interval::new(r, r));
        let [low, high] = self.target_box;
        let outside = (0..3)
            .any(|i| target[i] < low[i] - SLIDE_TOLERANCE || target[i] > high[i] + SLIDE_TOLERANCE);
        gap.status = if outside { Status::OutOfReach } else { Status::NotFound };
        gap
    }
}
