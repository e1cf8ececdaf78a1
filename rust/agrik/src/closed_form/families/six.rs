//! Which way six joints that turn are solved.

use super::meeting::Meeting;
use super::postures::Set;
use super::ring::{Ring, Work};
use super::three_parallel::ThreeParallel;
use crate::closed_form::geometry::enclosure::Margin;
use crate::closed_form::geometry::rigid::Rigid;
use crate::closed_form::geometry::screws::{EXACT, Screws};
use crate::lanes::Level;

/// Values of a free joint that are tried.
const VALUES: u32 = 48;

/// An arm of six joints, by what was recognised.
#[derive(Debug, Clone)]
pub enum Way {
    /// Its last or first three axes meet.
    Meeting(Box<Meeting>),
    /// Axes 2, 3, 4 are parallel, 5 and 6 meet.
    ThreeParallel(Box<ThreeParallel>),
    /// Anything else.
    Ring(Box<Ring>),
}

/// An arm of six joints with all that there is to say of it.
#[derive(Debug, Clone)]
pub struct Six {
    way: Way,
    /// Why it is none of the families with a closed form, where it is none.
    why: String,
}

impl Six {
    /// The arm of six axes. `like` is one of the same arm at other values of its locked joints:
    /// what was found out about it by trials is taken over.
    pub fn new(screws: &Screws, like: Option<&Self>) -> Result<Self, String> {
        let known = like.and_then(|like| match &like.way {
            Way::Ring(ring) => Some((&**ring, &like.why)),
            _ => None,
        });
        // At most values of a locked joint it is plain that there is no closed form.
        let why = match known {
            Some((_, why)) if !may_be_closed(screws) => why.clone(),
            _ => match Self::closed(screws) {
                Ok(arm) => return Ok(arm),
                Err(why) => why,
            },
        };
        let like = known.map(|(ring, _)| ring);
        let ring = Ring::new(screws, like).ok_or("it has no six joints that turn")?;
        Ok(Self { way: Way::Ring(Box::new(ring)), why })
    }

    /// The arm of six axes, if it has a closed form; or why it has none.
    pub fn closed(screws: &Screws) -> Result<Self, String> {
        let exact = |way: Way| Ok(Self { way, why: String::new() });
        // A meeting needs the geometry of all links; its measure is looked at first.
        let length = screws.gathered().length();
        let gap = |range| screws.meeting(range).map_or(f64::INFINITY, |(_, gap)| gap / length);
        let mut why = Vec::new();
        for (range, reversed) in [(3..6, false), (0..3, true)] {
            if gap(range) > EXACT {
                continue;
            }
            match Meeting::new(screws, reversed) {
                Ok(arm) => return exact(Way::Meeting(Box::new(arm))),
                Err(reason) => why.push(reason),
            }
        }
        match ThreeParallel::new(screws) {
            Ok(arm) => return exact(Way::ThreeParallel(Box::new(arm))),
            Err(reason) => why.push(reason),
        }
        if why.len() == 1 {
            why.insert(0, "neither its first nor its last three axes meet".to_owned());
        }
        Err(why.join("; "))
    }

    /// The way.
    pub fn way(&self) -> &Way {
        &self.way
    }

    /// Why no closed form does.
    pub fn why(&self) -> &str {
        &self.why
    }

    /// Short name of what was recognised.
    pub fn name(&self) -> &'static str {
        match &self.way {
            Way::Meeting(arm) if arm.is_reversed() => "spherical shoulder",
            Way::Meeting(_) => "spherical wrist",
            Way::ThreeParallel(_) => "three parallel axes",
            Way::Ring(_) => "general 6R",
        }
    }

    /// Most postures of a pose.
    pub fn branches(&self) -> usize {
        match &self.way {
            Way::Ring(_) => 16,
            _ => 8,
        }
    }

    /// All postures of goals (m); an angle that nothing decides is taken from `near`, which are
    /// start values where somebody gave such. `margin` is what postures may miss a goal by and
    /// still count, when it is asked whether there are any.
    pub fn solve(
        &self,
        level: Level,
        (goals, margin): (&[Rigid<f64>], Margin),
        (near, given): (&[[f64; 6]], bool),
        sets: &mut [Set],
        work: &mut Work,
    ) {
        match &self.way {
            Way::Meeting(arm) => arm.solve(level, goals, near, sets),
            Way::ThreeParallel(arm) => arm.solve(level, goals, near, sets),
            Way::Ring(arm) => {
                arm.solve(level, goals, if given { near } else { &[] }, sets, work);
            }
        }
        let closed = !matches!(self.way, Way::Ring(_));
        for (i, (set, near)) in sets.iter_mut().zip(near).enumerate() {
            if closed && set.count == 0 && set.open != 0 {
                self.try_open(level, &goals[i], near, set);
            }
            set.keep_nearest(self.branches(), near);
            set.none = set.count == 0 && self.is_out_of_reach(&goals[i], margin);
            set.sort();
        }
    }

    /// No posture comes within a margin of a goal (m), whatever the limits: proven.
    fn is_out_of_reach(&self, goal: &Rigid<f64>, margin: Margin) -> bool {
        match &self.way {
            Way::Meeting(arm) => arm.is_out_of_reach(goal, margin),
            Way::ThreeParallel(arm) => arm.is_out_of_reach(goal, margin),
            Way::Ring(arm) => arm.is_out_of_reach(goal, margin),
        }
    }

    /// Where a joint is free, the others may not be able to follow it to where it is wanted: other
    /// values of it, the nearest first.
    fn try_open(&self, level: Level, goal: &Rigid<f64>, near: &[f64; 6], set: &mut Set) {
        for step in 1..=VALUES {
            let side = if step % 2 == 0 { 0.5 } else { -0.5 };
            let turn = side * f64::from(step) * (std::f64::consts::TAU / f64::from(VALUES));
            let mut other = *near;
            for (k, x) in other.iter_mut().enumerate() {
                *x += if set.open >> k & 1 != 0 { turn } else { 0.0 };
            }
            let mut found = [Set::EMPTY];
            match &self.way {
                Way::Meeting(arm) => arm.solve(level, &[*goal], &[other], &mut found),
                Way::ThreeParallel(arm) => arm.solve(level, &[*goal], &[other], &mut found),
                Way::Ring(_) => return,
            }
            if found[0].count > 0 {
                *set = found[0];
                return;
            }
        }
    }
}

/// Without a look at the whole: six axes of which three may meet or be parallel.
fn may_be_closed(screws: &Screws) -> bool {
    let gap = EXACT * screws.gathered().length();
    let parallel = || screws.tilt(1, 2).max(screws.tilt(2, 3)) <= EXACT;
    screws.joints.len() != 6
        || [3..6, 0..3].into_iter().any(|range| !screws.pass_by(range, gap))
        || parallel()
}
