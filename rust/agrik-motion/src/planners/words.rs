//! What becomes of a plan, and how a path was found.

/// What became of a plan, in the order in which reasons are looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum PathStatus {
    /// There is a path.
    Ok = 0,
    /// Something that was given is no number, or no place.
    BadInput = 1,
    /// The start is outside the joint limits.
    StartOutOfLimits = 2,
    /// The start hits something, or is too near to it.
    StartInCollision = 3,
    /// The arm comes to the target in no way.
    OutOfReach = 4,
    /// It would, but for its joint limits.
    JointLimits = 5,
    /// The gripper hits something in every posture.
    ApproachBlocked = 6,
    /// The arm hits something, or is too near to it, in every posture.
    NoCollisionFree = 7,
    /// No goal was given.
    NoGoal = 8,
    /// It is proven that there is no path.
    PathImpossible = 9,
    /// None was found with the effort allowed; that is no proof.
    NoPathFound = 10,
    /// The time was over.
    TimeLimit = 11,
}

impl PathStatus {
    /// Every status, in the order of its codes.
    pub const ALL: [Self; 12] = [
        Self::Ok,
        Self::BadInput,
        Self::StartOutOfLimits,
        Self::StartInCollision,
        Self::OutOfReach,
        Self::JointLimits,
        Self::ApproachBlocked,
        Self::NoCollisionFree,
        Self::NoGoal,
        Self::PathImpossible,
        Self::NoPathFound,
        Self::TimeLimit,
    ];

    /// The name that users and files know it by.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ok => "OK",
            Self::BadInput => "BAD_INPUT",
            Self::StartOutOfLimits => "START_OUT_OF_LIMITS",
            Self::StartInCollision => "START_IN_COLLISION",
            Self::OutOfReach => "OUT_OF_REACH",
            Self::JointLimits => "JOINT_LIMITS",
            Self::ApproachBlocked => "APPROACH_BLOCKED",
            Self::NoCollisionFree => "NO_COLLISION_FREE",
            Self::NoGoal => "NO_GOAL",
            Self::PathImpossible => "PATH_IMPOSSIBLE",
            Self::NoPathFound => "NO_PATH_FOUND",
            Self::TimeLimit => "TIME_LIMIT",
        }
    }
}

/// How a path goes, or was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum How {
    /// There is none.
    None = 0,
    /// Straight in joint space.
    Straight = 1,
    /// One slide moves alone, then the others.
    SlideFirst = 2,
    /// One slide moves alone at the end.
    SlideLast = 3,
    /// Straight to the end of a line out of the goal, then along it.
    RetreatStraight = 4,
    /// The same with one slide moving alone first.
    RetreatSlideFirst = 5,
    /// The same with one slide moving alone before the line.
    RetreatSlideLast = 6,
    /// By two trees.
    RrtConnect = 7,
    /// By two trees, to the end of a line out of the goal.
    RetreatRrtConnect = 8,
}

impl How {
    /// Every one, in the order of its codes.
    pub const ALL: [Self; 9] = [
        Self::None,
        Self::Straight,
        Self::SlideFirst,
        Self::SlideLast,
        Self::RetreatStraight,
        Self::RetreatSlideFirst,
        Self::RetreatSlideLast,
        Self::RrtConnect,
        Self::RetreatRrtConnect,
    ];

    /// The name that users and files know it by.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "",
            Self::Straight => "straight",
            Self::SlideFirst => "slide_first",
            Self::SlideLast => "slide_last",
            Self::RetreatStraight => "retreat+straight",
            Self::RetreatSlideFirst => "retreat+slide_first",
            Self::RetreatSlideLast => "retreat+slide_last",
            Self::RrtConnect => "rrt_connect",
            Self::RetreatRrtConnect => "retreat+rrt_connect",
        }
    }
}
