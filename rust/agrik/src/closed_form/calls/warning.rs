//! What is to be said of a target beside its status: a bit each.

/// An odd number of postures: two of them met, or nearly so.
pub const FOLD: u8 = 1;
/// Some posture is near a singularity.
pub const NEAR_SINGULAR: u8 = 2;
/// The general solver doubted itself, and asked in a second way.
pub const SECOND_CUT: u8 = 4;
/// A joint turns freely; its value is that of the start values.
pub const SINGULAR_FAMILY: u8 = 8;
/// There are more postures than the record has room for.
pub const MORE: u8 = 16;
/// The search was cut short: what it says of other postures is not proven. (32 is taken by what
/// becomes of targets before they are solved.)
pub const UNPROVEN: u8 = 64;
