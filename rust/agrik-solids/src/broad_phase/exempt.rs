//! Labels that a query leaves out.

/// Which labels a query leaves out.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Exempt {
    /// One bit a label; labels beyond the end are not exempt.
    words: Vec<u64>,
    /// Bits `label % 64` of those that none but exempt labels have.
    pub(super) closed: u64,
}

impl Exempt {
    /// Leaves out some of `count` labels.
    pub fn new(labels: impl IntoIterator<Item = u32>, count: u32) -> Self {
        let mut words = vec![0; count.div_ceil(64) as usize];
        for label in labels {
            if let Some(word) = words.get_mut(label as usize / 64) {
                *word |= 1 << (label % 64);
            }
        }
        let taken = |label: &u32| words[*label as usize / 64] >> (label % 64) & 1 == 0;
        let open = (0..count).filter(taken).fold(0, |bits, label| bits | 1 << (label % 64));
        let closed = if words.iter().all(|word| *word == 0) { 0 } else { !open };
        Self { words, closed }
    }

    /// The same with some more labels.
    pub fn and(&self, more: impl IntoIterator<Item = u32>, count: u32) -> Self {
        let before = (0..count).filter(|label| self.contains(*label));
        Self::new(before.chain(more), count)
    }

    /// True for a label that is left out.
    pub fn contains(&self, label: u32) -> bool {
        self.words.get(label as usize / 64).is_some_and(|word| word >> (label % 64) & 1 != 0)
    }
}
