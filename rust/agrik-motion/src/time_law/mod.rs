//! When an arm is where on its way: from rest to rest, within the limits of its joints'
//! velocity, acceleration and jerk.
//!
//! The geometry is never touched: what is proven of a way holds for the motion along it. On
//! straight pieces the place follows the double S of seven phases; over rounded corners and
//! smooth curves the curvature takes its share of the joints' acceleration and jerk. All
//! phases have a constant jerk along the way and are evaluated exactly.

mod caps;
mod law;
mod path;
mod profile;
mod spline;

use agrik::chain::MotionLimits;
use agrik_compute::{Error, Result};

pub use caps::Caps;
pub use path::{Path, Piece};
pub use profile::{Phase, Profile};

/// A motion along a way.
#[derive(Debug, Clone)]
pub struct Motion {
    path: Path,
    phases: Vec<Phase>,
    /// The run of the path that each phase is on.
    runs: Vec<usize>,
    /// When each phase begins, s, and when the last one ends.
    times: Vec<f64>,
}

impl Motion {
    /// The motion along a way within limits, one for each joint value; `most` is a speed along
    /// the way that is not passed either.
    pub fn new(path: Path, limits: &[MotionLimits], most: f64) -> Result<Self> {
        if limits.len() != path.dof() {
            let expected = format!("{} limits", path.dof());
            return Err(Error::argument("limits", expected, limits.len()));
        }
        for (joint, limit) in limits.iter().enumerate() {
            let place = |what: &str| format!("{what}[{joint}]");
            let numbers = [limit.velocity, limit.acceleration, limit.jerk];
            for (what, number) in ["velocity", "acceleration", "jerk"].into_iter().zip(numbers) {
                if number.is_nan() || number <= 0.0 {
                    return Err(Error::argument(place(what), "a number > 0", number));
                }
            }
            if limit.acceleration.is_infinite() && path.moves(joint) {
                let expected = "a finite limit of every joint that moves";
                return Err(Error::argument(place("acceleration"), expected, "inf"));
            }
        }
        if most.is_nan() || most <= 0.0 {
            return Err(Error::argument("speed", "a number > 0", most));
        }
        let (mut phases, mut runs, mut times) = (Vec::new(), Vec::new(), vec![0.0]);
        let (mut start, mut time) = (0.0, 0.0);
        for (number, run) in path.runs().enumerate() {
            let mut made = Vec::new();
            law::append_run(run, start, limits, most, &mut made);
            start = run.last().map_or(start, Piece::end);
            for phase in made {
                let end = time + phase.duration;
                // A phase too short for the clock of a long motion is none.
                if end > time {
                    time = end;
                    times.push(time);
                    phases.push(phase);
                    runs.push(number);
                }
            }
        }
        if !time.is_finite() {
            let expected = "limits and lengths of like sizes";
            return Err(Error::argument("limits", expected, "a motion that does not end"));
        }
        Ok(Self { path, phases, runs, times })
    }

    /// Duration, s.
    pub fn duration(&self) -> f64 {
        self.times[self.phases.len()]
    }

    /// When each phase begins, s, and when the last one ends.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The phases, in order.
    pub fn phases(&self) -> &[Phase] {
        &self.phases
    }

    /// The way.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Place on the way and its first three derivatives by time. Before the begin and behind
    /// the end the arm rests.
    pub fn place(&self, time: f64) -> [f64; 4] {
        let rest = |place: f64| [place, 0.0, 0.0, 0.0];
        if time <= 0.0 {
            return rest(0.0);
        }
        if time >= self.duration() {
            return rest(self.path.length());
        }
        let phase = self.phase(time);
        self.phases[phase].state(time - self.times[phase])
    }

    /// The phase at a time between begin and end; of no phases 0.
    fn phase(&self, time: f64) -> usize {
        self.times.partition_point(|begin| *begin <= time).saturating_sub(1)
    }

    /// Joint values, velocities, accelerations and jerks at a time, one joint after the other.
    pub fn at(&self, time: f64, mut put: impl FnMut(usize, [f64; 4])) {
        if time >= self.duration() {
            let last = self.path.last().iter().enumerate();
            last.for_each(|(joint, q)| put(joint, [*q, 0.0, 0.0, 0.0]));
            return;
        }
        let [place, v, a, j] = self.place(time);
        let run = self.runs.get(self.phase(time)).copied().unwrap_or(0);
        self.path.at(run, place, |joint, [q, first, second, third]| {
            let velocity = first * v;
            let acceleration = second * v * v + first * a;
            let jerk = third * v * v * v + 3.0 * second * v * a + first * j;
            put(joint, [q, velocity, acceleration, jerk]);
        });
    }
}
