//! What a file may hold: more is refused, so that reading takes time and memory in
//! proportion to the text. No robot comes near.

/// Bytes of a text.
pub(super) const TEXT: usize = 16 << 20;
/// Joints between base and tip.
pub(super) const PATH: usize = 4000;
/// Joints that follow each other in a row.
pub(super) const FOLLOWERS: usize = 100;
/// Attributes of an element.
pub(super) const ATTRIBUTES: usize = 64;
/// Bytes of a name.
pub(super) const NAME: usize = 1000;
/// Links that are handed out as what else the tip could be.
pub(super) const NAMED: usize = 100;
