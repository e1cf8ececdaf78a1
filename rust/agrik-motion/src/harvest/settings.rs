//! The numbers of the two-step method.

use std::f64::consts::FRAC_PI_2;

use agrik_compute::Allowed;

use crate::{Error, Result};

/// What the two-step method looks at and what it prefers. The paper prints none of these
/// numbers; the defaults are our choice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Approach angles from `-range` to `range`.
    pub angles: usize,
    /// Farthest approach angle to either side, rad.
    pub range: f64,
    /// Places of the slide, from one end to the other.
    pub slides: usize,
    /// Distance that a posture keeps from the crop, m.
    pub min_distance: f64,
    /// Joint freedom that a posture keeps, 0 to 1.
    pub min_freedom: f64,
    /// Distance beyond which more is of no use, m.
    pub enough: f64,
    /// Weight of the distance in the score.
    pub distance_weight: f64,
    /// Weight of the joint freedom in the score.
    pub freedom_weight: f64,
    /// Go on after the best approach angle has failed.
    pub recovery: bool,
    /// Least way between approach angles that are tried first, rad.
    pub spread: f64,
    /// Most approach angles whose tables are made one after the other.
    pub most_angles: usize,
    /// Tilt of the gripper up or down that it tolerates, rad; 0 for none.
    pub tilt: f64,
    /// Way up or down the fruit that the grip point may be shifted, m; 0 for none.
    pub shift: f64,
    /// Improve the answer by a pattern search in approach angle and slide.
    pub refine: bool,
    /// Seconds after which a decision is broken off; answers then depend on the machine.
    pub time_limit: Option<f64>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            angles: 73,
            range: FRAC_PI_2,
            slides: 41,
            min_distance: 0.005,
            min_freedom: 0.03,
            enough: 0.075,
            distance_weight: 0.6,
            freedom_weight: 0.4,
            recovery: true,
            spread: 10.0_f64.to_radians(),
            most_angles: 8,
            tilt: 0.0,
            shift: 0.0,
            refine: false,
            time_limit: None,
        }
    }
}

impl Settings {
    /// Refuses numbers out of their ranges.
    ///
    /// # Errors
    ///
    /// Names the first of them.
    pub fn check(&self) -> Result<()> {
        let whole = |name: &str, value: usize, least: u32| {
            let value = u32::try_from(value).unwrap_or(u32::MAX);
            Allowed::whole(least, 100_000).check(name, value)
        };
        whole("angles", self.angles, 1)?;
        whole("slides", self.slides, 1)?;
        whole("most_angles", self.most_angles, 1)?;
        Allowed::between(0.0, std::f64::consts::PI).of("rad").check("range", self.range)?;
        Allowed::NOT_NEGATIVE.of("m").check("min_distance", self.min_distance)?;
        Allowed::SHARE.check("min_freedom", self.min_freedom)?;
        Allowed::POSITIVE.of("m").check("enough", self.enough)?;
        Allowed::NOT_NEGATIVE.check("distance_weight", self.distance_weight)?;
        Allowed::NOT_NEGATIVE.check("freedom_weight", self.freedom_weight)?;
        if self.distance_weight + self.freedom_weight == 0.0 {
            let expected = "one of distance_weight and freedom_weight above 0";
            return Err(Error::argument("weights", expected, "all zero"));
        }
        Allowed::NOT_NEGATIVE.of("rad").check("spread", self.spread)?;
        Allowed::between(0.0, FRAC_PI_2).of("rad").check("tilt", self.tilt)?;
        Allowed::NOT_NEGATIVE.of("m").check("shift", self.shift)?;
        if let Some(limit) = self.time_limit {
            Allowed::POSITIVE.of("s").check("time_limit", limit)?;
        }
        Ok(())
    }

    /// The approach angles, rad, in order.
    pub(super) fn psis(&self) -> Vec<f64> {
        evenly(-self.range, self.range, self.angles)
    }

    /// The score of a posture, 0 to the sum of the weights; NaN never.
    pub(super) fn score(&self, distance: f64, freedom: f64) -> f64 {
        let near = (distance.min(self.enough) / self.enough).max(0.0);
        self.distance_weight * near + self.freedom_weight * freedom
    }
}

/// So many numbers from `lower` to `upper`; the middle where it is one.
pub(super) fn evenly(lower: f64, upper: f64, count: usize) -> Vec<f64> {
    if count == 1 {
        return vec![0.5 * (lower + upper)];
    }
    let step = (upper - lower) / (count - 1) as f64;
    (0..count).map(|k| if k + 1 == count { upper } else { lower + step * k as f64 }).collect()
}
