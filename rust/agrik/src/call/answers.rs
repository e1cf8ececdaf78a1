//! What comes out of a call: a record of one row a target.

/// What became of a target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Status {
    /// Reached within tolerance and limits, by forward kinematics.
    Converged = 0,
    /// Proven to lie outside a bound of the robot's reach.
    OutOfReach = 1,
    /// No attempt ended within tolerance.
    NotFound = 2,
    /// The target or its start held NaN, infinity or a number above [`crate::LARGEST`].
    BadInput = 3,
    /// The search came to rest before it reached the target, as in a local minimum (feedback
    /// laws, plain methods and population searches only).
    Stalled = 4,
    /// Numbers grew beyond all bounds (feedback laws only).
    NonFinite = 5,
    /// Reached within tolerance and limits, but by no posture found that the call's guard
    /// accepts: all of them hit something. The least bad one is given.
    InCollision = 6,
    /// There are postures, but none within the limits.
    JointLimits = 7,
    /// Reached, by postures of a family in which a joint turns freely (all branches only).
    SingularFamily = 8,
    /// The target asks for more than the arm has joints for: the nearest postures are given, with
    /// the angle that is left (all branches only).
    Overdetermined = 9,
    /// Nothing here solves such an arm (all branches only).
    Unsupported = 10,
    /// Not reached in this tick: the posture goes to the target, or as near to it as the reach
    /// allows, no faster than it may (control loops only).
    Held = 11,
}

impl Status {
    /// Every status, in the order of its codes.
    pub const ALL: [Self; 12] = [
        Self::Converged,
        Self::OutOfReach,
        Self::NotFound,
        Self::BadInput,
        Self::Stalled,
        Self::NonFinite,
        Self::InCollision,
        Self::JointLimits,
        Self::SingularFamily,
        Self::Overdetermined,
        Self::Unsupported,
        Self::Held,
    ];

    /// The name that users and files know it by.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::OutOfReach => "out_of_reach",
            Self::NotFound => "not_found",
            Self::BadInput => "bad_input",
            Self::Stalled => "stalled",
            Self::NonFinite => "non_finite",
            Self::InCollision => "in_collision",
            Self::JointLimits => "joint_limits",
            Self::SingularFamily => "singular_family",
            Self::Overdetermined => "overdetermined",
            Self::Unsupported => "unsupported",
            Self::Held => "held",
        }
    }
}

/// The answers of a call, one entry a target (`dof` entries of `q`).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Answers {
    /// Joint values, rad or m; the best found where the target was not reached.
    pub q: Vec<f64>,
    /// What became of each target.
    pub status: Vec<u8>,
    /// Distance left, m (infinite for bad input).
    pub position_error: Vec<f64>,
    /// Angle left, rad (infinite for bad input).
    pub orientation_error: Vec<f64>,
    /// Steps taken over all attempts.
    pub iterations: Vec<u32>,
    /// Attempts after the first.
    pub restarts: Vec<u32>,
}

impl Answers {
    /// Room for `rows` targets of a chain with `dof` joint values.
    pub fn new(rows: usize, dof: usize) -> Self {
        Self {
            q: vec![0.0; rows * dof],
            status: vec![Status::NotFound as u8; rows],
            position_error: vec![f64::INFINITY; rows],
            orientation_error: vec![f64::INFINITY; rows],
            iterations: vec![0; rows],
            restarts: vec![0; rows],
        }
    }

    /// How many targets.
    pub fn len(&self) -> usize {
        self.status.len()
    }
    /// No target at all.
    pub fn is_empty(&self) -> bool {
        self.status.is_empty()
    }
    /// True where target `row` was reached.
    pub fn success(&self, row: usize) -> bool {
        self.status[row] == Status::Converged as u8
    }
    /// All rows, writable.
    pub fn as_mut(&mut self) -> AnswersMut<'_> {
        AnswersMut {
            first: 0,
            q: &mut self.q,
            status: &mut self.status,
            position_error: &mut self.position_error,
            orientation_error: &mut self.orientation_error,
            iterations: &mut self.iterations,
            restarts: &mut self.restarts,
        }
    }
}

/// A run of consecutive rows of [`Answers`], owned by one thread while it is filled.
#[derive(Debug)]
pub struct AnswersMut<'a> {
    /// Row of the first entry in the whole call.
    pub first: usize,
    q: &'a mut [f64],
    status: &'a mut [u8],
    position_error: &'a mut [f64],
    orientation_error: &'a mut [f64],
    iterations: &'a mut [u32],
    restarts: &'a mut [u32],
}

/// One finished target.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Outcome {
    pub status: Status,
    pub position_error: f64,
    pub orientation_error: f64,
    pub iterations: u32,
    pub restarts: u32,
}

impl Outcome {
    /// Of a target without an answer so far.
    pub fn unanswered(status: Status) -> Self {
        Self {
            status,
            position_error: f64::INFINITY,
            orientation_error: f64::INFINITY,
            iterations: 0,
            restarts: 0,
        }
    }
}

impl<'a> AnswersMut<'a> {
    /// How many rows.
    pub fn len(&self) -> usize {
        self.status.len()
    }
    /// No row at all.
    pub fn is_empty(&self) -> bool {
        self.status.is_empty()
    }

    /// The joint values of row `i` of this run.
    pub(crate) fn q(&self, i: usize) -> &[f64] {
        let dof = self.q.len() / self.status.len();
        &self.q[i * dof..(i + 1) * dof]
    }

    /// What became of row `i` of this run, which converged.
    pub(crate) fn outcome(&self, i: usize) -> Outcome {
        Outcome {
            status: Status::Converged,
            position_error: self.position_error[i],
            orientation_error: self.orientation_error[i],
            iterations: self.iterations[i],
            restarts: self.restarts[i],
        }
    }

    /// Row `i` of this run ended with a status.
    pub(crate) fn ended(&self, i: usize, status: Status) -> bool {
        self.status[i] == status as u8
    }

    /// Some row ended with a status.
    pub fn any(&self, status: Status) -> bool {
        self.status.contains(&(status as u8))
    }

    /// The same rows, lent for a while.
    pub fn reborrow(&mut self) -> AnswersMut<'_> {
        AnswersMut {
            first: self.first,
            q: self.q,
            status: self.status,
            position_error: self.position_error,
            orientation_error: self.orientation_error,
            iterations: self.iterations,
            restarts: self.restarts,
        }
    }

    /// The rows in runs of at most `size`.
    pub fn split(self, size: usize) -> Vec<AnswersMut<'a>> {
        let dof = if self.status.is_empty() { 1 } else { self.q.len() / self.status.len() };
        self.q
            .chunks_mut((size * dof).max(1))
            .zip(self.status.chunks_mut(size))
            .zip(self.position_error.chunks_mut(size))
            .zip(self.orientation_error.chunks_mut(size))
            .zip(self.iterations.chunks_mut(size))
            .zip(self.restarts.chunks_mut(size))
            .enumerate()
            .map(
                |(
                    i,
                    (((((q, status), position_error), orientation_error), iterations), restarts),
                )| {
                    AnswersMut {
                        first: self.first + i * size,
                        q,
                        status,
                        position_error,
                        orientation_error,
                        iterations,
                        restarts,
                    }
                },
            )
            .collect()
    }

    /// Tells the errors of solved rows from `first` to `end` of this run anew.
    pub(crate) fn tell_anew(
        &mut self,
        first: usize,
        end: usize,
        mut errors: impl FnMut(usize, &[f64]) -> Option<(f64, f64)>,
    ) {
        let dof = self.q.len() / self.status.len().max(1);
        for i in first..end {
            let q = &self.q[i * dof..(i + 1) * dof];
            if self.status[i] == Status::Converged as u8
                && let Some((position, orientation)) = errors(self.first + i, q)
            {
                (self.position_error[i], self.orientation_error[i]) = (position, orientation);
            }
        }
    }

    /// Writes row `i` of this run and returns its joint values to be filled.
    #[inline(always)]
    pub(crate) fn finish(&mut self, i: usize, outcome: Outcome) -> &mut [f64] {
        self.status[i] = outcome.status as u8;
        self.position_error[i] = outcome.position_error;
        self.orientation_error[i] = outcome.orientation_error;
        self.iterations[i] = outcome.iterations;
        self.restarts[i] = outcome.restarts;
        let dof = self.q.len() / self.status.len();
        &mut self.q[i * dof..(i + 1) * dof]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statuses_stand_at_their_codes() {
        for (code, status) in Status::ALL.into_iter().enumerate() {
            assert_eq!(status as usize, code, "{}", status.name());
        }
    }
}
