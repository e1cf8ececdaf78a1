//! What is asked of a way, and what is found.

use agrik_compute::Allowed;

use crate::{Contact, Error, Result};

/// The most that bodies of an arm keep from each other where nothing is said, m: arms are
/// built with less between their links than they keep from what stands round them.
pub const OWN_CLEAR: f64 = 0.002;

/// How near is too near, and how hard to look.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Keep {
    /// Distance from the scene, m: as near or nearer is a hit. Objects that want more get it.
    pub clear: f64,
    /// The same between two bodies of the arm, m.
    pub own: f64,
    /// Up to where the distance that is kept is told, m; with `clear`, and that is quickest,
    /// nothing more than `clear` is told.
    pub cap: f64,
    /// A piece of the way on which a body moves no farther than this is not cut again, m.
    pub tolerance: f64,
    /// Most questions, one a body or a pair of bodies at one posture; a glance at a whole way
    /// counts as one of each.
    pub max_checks: u32,
}

impl Keep {
    /// A distance from the scene, and no more of the arm's bodies from each other than
    /// [`OWN_CLEAR`]; told without a limit.
    pub const fn clear(clear: f64) -> Self {
        Self {
            clear,
            own: clear.min(OWN_CLEAR),
            cap: f64::INFINITY,
            tolerance: 1e-5,
            max_checks: 100_000,
        }
    }

    /// The same, told up to a distance, m.
    #[must_use]
    pub const fn with_cap(self, cap: f64) -> Self {
        Self { cap, ..self }
    }

    /// Refuses numbers out of their ranges.
    ///
    /// # Errors
    ///
    /// Names the first of them.
    pub fn check(&self) -> Result<()> {
        Allowed::NOT_NEGATIVE.of("m").check("clear", self.clear)?;
        Allowed::NOT_NEGATIVE.of("m").check("own_clear", self.own)?;
        Allowed::POSITIVE.of("m").check("tolerance", self.tolerance)?;
        if self.cap.is_nan() || self.cap < self.clear {
            let expected = format!("no less than clear, {} m", self.clear);
            return Err(Error::argument("cap", expected, self.cap));
        }
        if self.max_checks == 0 {
            return Err(Error::argument("max_checks", "1 or more", 0));
        }
        Ok(())
    }
}

/// What is known of a way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Outcome {
    /// It is free, and that is proven.
    Safe = 0,
    /// A posture of it is too near to something.
    Hit = 1,
    /// Neither was found: it grazes what it must not touch, or questions ran out. Not safe.
    Undecided = 2,
}

impl Outcome {
    /// Every outcome, in the order of its codes.
    pub const ALL: [Self; 3] = [Self::Safe, Self::Hit, Self::Undecided];

    /// The name that users and files know it by.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Safe => "SAFE",
            Self::Hit => "HIT",
            Self::Undecided => "UNDECIDED",
        }
    }
}

/// The answer for a way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verdict {
    /// What is known.
    pub outcome: Outcome,
    /// Where it is safe the distance that is kept all along it, of bodies from the scene and
    /// from each other, m: never more than the true one. Else 0.
    pub clearance: f64,
    /// Where it is not, how far along it that was found, 0 to 1; else 0.
    pub at: f64,
    /// The body that is too near to something there, or may be, and the other one if it is
    /// another body.
    pub between: Option<(usize, Option<usize>)>,
    /// What that is, where it was asked for.
    pub contact: Option<Contact>,
    /// Questions asked.
    pub checks: u32,
}

impl Verdict {
    /// It is proven free.
    pub fn is_safe(&self) -> bool {
        self.outcome == Outcome::Safe
    }
}
