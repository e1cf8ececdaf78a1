//! A joint's limits as solvers see them, and the turns that they leave open.

use super::plan::Plan;
use crate::call::Starts;
use crate::chain::{JointKind, Variable, reference};
use crate::kinematics::PerJoint;
use crate::lanes::Real;

/// A full turn, with room for rounding.
const TURN: f64 = std::f64::consts::TAU + 1e-9;

/// An angle without the whole turns that part it from a reference.
#[inline(always)]
pub(super) fn nearest_turn<R: Real>(angle: R, reference: R) -> R {
    use std::f64::consts::TAU;
    let turns = ((angle - reference) * R::splat(1.0 / TAU)).round();
    turns.mul_add(R::splat(-TAU), angle)
}

/// The limits of one joint value, rad or m.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limit {
    pub lower: f64,
    pub upper: f64,
    /// The joint can take every angle, so that its limits hold nothing back.
    pub turns: bool,
    /// What steps keep between: the limits, or of a joint that turns one turn inside them, past
    /// whose ends it goes on at the other one.
    pub ends: (f64, f64),
    /// There may be several angles for a posture.
    pub winds: bool,
    /// The joint slides.
    pub slides: bool,
    pub middle: f64,
}

impl Limit {
    fn of(v: &Variable) -> Self {
        let turns = v.turns();
        let slides = v.kind == JointKind::Prismatic;
        let winds = turns && v.kind != JointKind::Continuous;
        let (lower, upper) = (v.lower, v.upper);
        Self { lower, upper, turns, ends: (lower, upper), winds, slides, middle: v.middle() }
    }
}

impl Limit {
    /// The same where answers are to be near the middle, so that none has to be wound.
    fn about_middle(self) -> Self {
        use std::f64::consts::PI;
        let ends = (self.middle - PI, self.middle + PI);
        let inside = self.lower <= ends.0 && ends.1 <= self.upper;
        if self.turns && self.winds && inside { Self { ends, winds: false, ..self } } else { self }
    }

    /// The same where these are limits in place of a joint's own.
    fn in_place_of_own(self) -> Self {
        let bounded = self.lower.is_finite() && self.upper.is_finite();
        let middle = if bounded { 0.5 * (self.lower + self.upper) } else { self.middle };
        let winds = !self.slides && self.upper - self.lower > TURN;
        Self { middle: middle.max(self.lower).min(self.upper), winds, ..self }
    }

    /// A start inside, for one between a joint's own limits: as far from one end as that is.
    pub fn inside(&self, x: f64, (lower, upper): (f64, f64)) -> f64 {
        use std::f64::consts::PI;
        if self.lower <= x && x <= self.upper || !(self.upper - self.lower).is_finite() {
            return x;
        }
        let (lower, upper) = if (upper - lower).is_finite() { (lower, upper) } else { (-PI, PI) };
        let share = ((x - lower) / (upper - lower)).clamp(0.0, 1.0);
        self.lower + share * (self.upper - self.lower)
    }

    /// The value that answers stay near, for the caller's `about`; no angle beyond `most` where
    /// that can be helped.
    #[inline(always)]
    pub fn reference(&self, about: f64, most: f64) -> f64 {
        reference(about, (self.lower, self.upper), self.turns, most)
    }

    /// The angle of the same posture that is nearest to `about` inside the limits.
    #[inline(always)]
    pub fn wound(&self, x: f64, about: f64) -> f64 {
        use std::f64::consts::TAU;
        let mut y = nearest_turn(x, about);
        if y < self.lower {
            y += TAU;
        } else if y > self.upper {
            y -= TAU;
        }
        // Half a turn away on either side is as near.
        let nearer = (y - about).abs() < (x - about).abs() - 1e-9;
        if nearer && self.lower <= y && y <= self.upper { y } else { x }
    }
}

/// The angle of the same posture that is nearest to `about` inside a joint's own limits.
pub(crate) fn wound(v: &Variable, x: f64, about: f64) -> f64 {
    let turns = v.periodic && v.kind != JointKind::Prismatic;
    if turns { Limit::of(v).wound(x, about) } else { x }
}

/// Takes the whole turns between angles and those nearest to the start values, or without any to
/// the middle of the limits; no start beyond `most` where that can be helped.
pub(super) fn bring_near(limits: &[Limit], q: &mut [f64], start: Option<&[f64]>, most: f64) {
    for (i, (x, v)) in q.iter_mut().zip(limits).enumerate() {
        if v.turns || v.winds {
            let about = start.map_or(v.middle, |start| v.reference(start[i], most));
            *x = v.wound(*x, about);
        }
    }
}

/// The limits of a plan: those of the joints, unless it has narrower ones.
pub(super) fn limits(plan: &Plan<'_>) -> PerJoint<Limit> {
    match &plan.bounds {
        None => {
            // With starts given, joints wider than a turn stay on the side where they stand.
            let started = !matches!(plan.request.starts(), Starts::Free);
            let stays = |v: &Limit| started && v.winds && v.upper - v.lower > TURN;
            // Without one they stay within half a turn of the middle: no turns to take off.
            let setup = plan.setup();
            let moves_freely = !started && setup.usual_start.is_none();
            let anywhere = moves_freely && !setup.settings.step.is_feedback();
            let limits = plan.request.chain().variables().iter().map(Limit::of);
            let limits = limits.map(|v| Limit { turns: v.turns && !stays(&v), ..v });
            limits.map(|v| if anywhere { v.about_middle() } else { v }).collect()
        }
        Some(bounds) => {
            let variables = plan.request.chain().variables().iter().map(Limit::of);
            variables
                .zip(bounds)
                .map(|(v, &(lower, upper))| {
                    let ends = (lower, upper);
                    let v = Limit { lower, upper, ends, turns: false, winds: false, ..v };
                    if plan.limited { v.in_place_of_own() } else { v }
                })
                .collect()
        }
    }
}
