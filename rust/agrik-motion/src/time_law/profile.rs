//! One stretch of the way in at most seven phases of constant jerk: from one speed to another,
//! the acceleration 0 at both ends (double S).

use super::caps::Caps;

/// Phases shorter than this share of their stretch are what rounding left.
const ROUNDING: f64 = 1e-13;

/// A phase of constant jerk, from the state that it begins in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Phase {
    /// Duration, s.
    pub duration: f64,
    /// Place on the way where it begins, and its first, second and third derivative by time.
    pub at: [f64; 4],
}

impl Phase {
    /// Place, speed, acceleration and jerk a time after its begin, s.
    pub fn state(&self, t: f64) -> [f64; 4] {
        let [s, v, a, j] = self.at;
        [s + t * (v + t * (a / 2.0 + t * j / 6.0)), v + t * (a + t * j / 2.0), a + t * j, j]
    }
}

/// A change of speed at limits: three phases, the outer two of the jerk's limit.
#[derive(Debug, Clone, Copy)]
struct Ramp {
    /// Speeds at both ends.
    from: f64,
    to: f64,
    /// Duration of each outer phase, and of all.
    outer: f64,
    time: f64,
}

impl Ramp {
    fn new(from: f64, to: f64, limits: &Caps) -> Self {
        let change = (to - from).abs();
        let (a, j) = (limits.acceleration, limits.jerk);
        let full = a / j;
        let (outer, time) = if change >= a * full {
            (full, full + change / a)
        } else {
            let outer = (change / j).sqrt();
            (outer, 2.0 * outer)
        };
        Self { from, to, outer, time }
    }

    fn way(&self) -> f64 {
        0.5 * (self.from + self.to) * self.time
    }

    fn phases(&self, start: f64, out: &mut Vec<Phase>) {
        if self.time <= 0.0 {
            return;
        }
        // The highest acceleration follows from the speeds, so that the last one is met.
        let top = (self.to - self.from) / (self.time - self.outer);
        let jerk = if self.outer > 0.0 { top / self.outer } else { 0.0 };
        let mut at = [start, self.from, if self.outer > 0.0 { 0.0 } else { top }, 0.0];
        let flat = self.time - 2.0 * self.outer;
        for (duration, jerk) in [(self.outer, jerk), (flat, 0.0), (self.outer, -jerk)] {
            if duration > ROUNDING * self.time {
                at[3] = jerk;
                let phase = Phase { duration, at };
                at = phase.state(duration);
                out.push(phase);
            }
        }
    }
}

/// A stretch: two ramps with an even speed between them.
#[derive(Debug, Clone, Copy)]
pub struct Profile {
    up: Ramp,
    down: Ramp,
    /// Duration at the even speed, s.
    even: f64,
}

impl Profile {
    /// The fastest stretch of that length between two speeds; `None` where the length is too
    /// short for the change of speed, or a speed is above the limit.
    pub fn new(length: f64, from: f64, to: f64, limits: &Caps) -> Option<Self> {
        if from > limits.velocity || to > limits.velocity {
            return None;
        }
        let of = |peak: f64| (Ramp::new(from, peak, limits), Ramp::new(peak, to, limits));
        let excess = |peak: f64| {
            let (up, down) = of(peak);
            up.way() + down.way() - length
        };
        let lowest = from.max(to);
        let at_lowest = excess(lowest);
        // What rounding leaves of a length is forgiven: the speeds would be missed by as little.
        if at_lowest > 1e-12 * length {
            return None;
        }
        let peak = if limits.velocity.is_finite() && excess(limits.velocity) <= 0.0 {
            limits.velocity
        } else if from == 0.0 && to == 0.0 {
            rest_to_rest_peak(length, limits)
        } else {
            highest(lowest, length, limits, excess)
        };
        let (up, down) = of(peak);
        let left = length - up.way() - down.way();
        let even = if peak > 0.0 { (left / peak).max(0.0) } else { 0.0 };
        Some(Self { up, down, even })
    }

    /// Duration, s.
    pub fn time(&self) -> f64 {
        self.up.time + self.even + self.down.time
    }

    /// The phases from a place on the way onwards.
    pub fn phases(&self, start: f64, out: &mut Vec<Phase>) {
        self.up.phases(start, out);
        let behind = start + self.up.way();
        if self.even > ROUNDING * self.time() {
            out.push(Phase { duration: self.even, at: [behind, self.up.to, 0.0, 0.0] });
        }
        self.down.phases(behind + self.even * self.up.to, out);
    }
}

/// The highest speed from rest to rest on a way too short for the speed's limit.
fn rest_to_rest_peak(length: f64, limits: &Caps) -> f64 {
    let (a, j) = (limits.acceleration, limits.jerk);
    let tj = a / j;
    // Half of the duration if the acceleration's limit is reached.
    let half = 0.5 * tj + (0.25 * tj * tj + length / a).sqrt();
    if half >= 2.0 * tj {
        a * (half - tj)
    } else {
        let tj = (0.5 * length / j).cbrt();
        j * tj * tj
    }
}

/// The highest speed at which `excess` is not above 0; it grows with the speed. False position,
/// the end that stays being halved (Illinois).
fn highest(lowest: f64, length: f64, limits: &Caps, excess: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (lowest, limits.velocity);
    if !high.is_finite() {
        high = lowest + rest_to_rest_peak(2.0 * length, limits);
        while excess(high) < 0.0 {
            high *= 2.0;
        }
    }
    let (mut below, mut above) = (excess(low).min(0.0), excess(high));
    let mut stays = 0;
    for _ in 0..100 {
        let mut next = (low * above - high * below) / (above - below);
        if !(low < next && next < high) {
            next = 0.5 * (low + high);
        }
        if high - low <= f64::EPSILON * high || next <= low || next >= high {
            break;
        }
        let found = excess(next);
        if found <= 0.0 {
            (low, below) = (next, found);
            above *= if stays > 0 { 0.5 } else { 1.0 };
            stays = 1;
        } else {
            (high, above) = (next, found);
            below *= if stays < 0 { 0.5 } else { 1.0 };
            stays = -1;
        }
        if below.abs() <= f64::EPSILON * length {
            break;
        }
    }
    low
}
