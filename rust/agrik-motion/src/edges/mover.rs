//! What moves on a way, and how far at most.

use agrik::chain::Link;

use super::sample::Sample;
use crate::body::link_levers;

/// Numbers are rounded: bounds are taken longer by this share, and by this length (m).
const ROUNDING: (f64, f64) = (1e-9, 1e-12);

/// What is asked about at a posture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Asked {
    /// A body, about the scene.
    Body(usize),
    /// Two bodies, about each other; the second is farther out.
    Pair(usize, usize),
}

/// Something that moves, and against what: only joints `from..to` count.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mover {
    pub asked: Asked,
    pub from: usize,
    pub to: usize,
}

/// How far a mover goes on a way at most.
///
/// Within a share `h` of the way to either side of a posture a core point goes no farther than
/// `rate * h`, the sum over joints of lever times way; and no farther than
/// `v h + curving h^2 / 2`, where `v` is the most that core points move at the rate of now.
/// The second holds since the acceleration of a point is a sum over pairs of joints, the lever
/// of the farther one times both rates; it is much less than the first where joints work
/// against each other.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Bound {
    pub rate: f64,
    pub curving: f64,
}

impl Bound {
    /// Of points that the first `links.len()` joints carry, where only those from `from` on
    /// count: `levers` as [`link_levers`] gives them, `rates` of the joints.
    pub fn new(links: &[Link], from: usize, levers: &[f64], rates: &[f64]) -> Self {
        let mut bound = Self::default();
        // Rates of turning joints so far.
        let mut turning = 0.0;
        for i in from..links.len() {
            let (lever, rate) = (levers[i], rates[i].abs());
            bound.rate += lever * rate;
            let own = if links[i].prismatic { 0.0 } else { rate };
            bound.curving += lever * rate * (own + 2.0 * turning);
            turning += own;
        }
        bound
    }

    /// Goes by levers alone: for ways whose direction is not known.
    pub fn forget_speed(&mut self) {
        self.curving = f64::INFINITY;
    }

    /// The most that it moves within `half` of a posture where it moves at `speed`, m.
    pub fn motion(&self, speed: f64, half: f64) -> f64 {
        let least = (self.rate * half).min((speed + 0.5 * self.curving * half) * half);
        least * (1.0 + ROUNDING.0) + ROUNDING.1
    }

    /// How far to either side it may go while it moves no farther than `way`, m.
    pub fn reach(&self, speed: f64, way: f64) -> f64 {
        let way = way * (1.0 - ROUNDING.0) - ROUNDING.1;
        if way <= 0.0 {
            return 0.0;
        }
        let along = way / self.rate;
        // The larger root of a h^2 / 2 + v h = way, in the form that loses no digits.
        let curved = 2.0 * way / (speed + (speed * speed + 2.0 * self.curving * way).sqrt());
        // What does not move at all may go anywhere.
        let far = |h: f64| if h.is_nan() { f64::INFINITY } else { h };
        far(along).max(far(curved))
    }
}

/// The levers of points of a frame on a way of which `middle` is the middle and that goes to
/// half the `rates` to either side.
pub(super) fn levers(
    links: &[Link],
    middle: &Sample,
    points: &[agrik_solids::Point],
    rates: &[f64],
    to: &mut Vec<f64>,
) {
    let pose = &middle.poses[links.len()];
    let placed: Vec<_> = points.iter().map(|p| pose.point(*p)).collect();
    to.clear();
    to.resize(links.len(), 0.0);
    // Links with one variable have rates of their own, so `way` goes by the link.
    let mut left = rates[..links.len()].iter().rev();
    link_levers(links, &middle.poses, &placed, |_| 0.5 * left.next().map_or(0.0, |r| r.abs()), to);
}
