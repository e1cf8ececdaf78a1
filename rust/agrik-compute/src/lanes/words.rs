//! Words of 64 bits in lanes: what random numbers and choices are made of.

/// One word, or a vector of words processed in step.
pub trait Words: Copy {
    /// How many words one value holds.
    const WIDTH: usize;

    /// The same word in every lane.
    fn splat(word: u64) -> Self;
    /// The first [`Words::WIDTH`] words of a slice, which holds at least as many.
    fn load(from: &[u64]) -> Self;
    /// Writes the words over the first ones of a slice, which holds at least as many.
    fn store(self, to: &mut [u64]);

    /// Sum, without what it carries out of a word.
    fn plus(self, other: Self) -> Self;
    /// Product of the lower halves.
    fn product(self, other: Self) -> Self;
    /// Bits that differ.
    fn xor(self, other: Self) -> Self;
    /// Bits that are set in at least one of both.
    fn or(self, other: Self) -> Self;
    /// Moved up by `BY` bits, 1 to 63.
    fn up<const BY: i32>(self) -> Self;
    /// Moved down by `BY` bits, 1 to 63.
    fn down<const BY: i32>(self) -> Self;

    /// All bits set in those fields of 16 bits that are equal.
    fn equal_fields(self, other: Self) -> Self;
    /// All bits set in those fields of 16 bits that are below the other's, both with a sign.
    fn fields_below(self, other: Self) -> Self;
    /// The smaller of each pair of fields of 16 bits, both with a sign.
    fn smaller_fields(self, other: Self) -> Self;

    /// The number in the low 16 bits of each word, in all four fields.
    #[inline(always)]
    fn in_all_fields(self) -> Self {
        let low = self.up::<48>().down::<48>();
        let two = low.or(low.up::<16>());
        two.or(two.up::<32>())
    }

    /// Moved up by the bits of a rotation; what leaves at the top comes in at the bottom.
    #[inline(always)]
    fn rotated<const UP: i32, const DOWN: i32>(self) -> Self {
        self.up::<UP>().or(self.down::<DOWN>())
    }
}

/// A function of each pair of 16-bit fields.
#[inline(always)]
fn of_fields(a: u64, b: u64, of: impl Fn(i16, i16) -> u16) -> u64 {
    let field = |k: u32| u64::from(of((a >> (16 * k)) as i16, (b >> (16 * k)) as i16)) << (16 * k);
    field(0) | field(1) | field(2) | field(3)
}

impl Words for u64 {
    const WIDTH: usize = 1;

    #[inline(always)]
    fn splat(word: u64) -> Self {
        word
    }
    #[inline(always)]
    fn load(from: &[u64]) -> Self {
        from[0]
    }
    #[inline(always)]
    fn store(self, to: &mut [u64]) {
        to[0] = self;
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self.wrapping_add(other)
    }
    #[inline(always)]
    fn product(self, other: Self) -> Self {
        u64::from(self as u32) * u64::from(other as u32)
    }
    #[inline(always)]
    fn xor(self, other: Self) -> Self {
        self ^ other
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        self | other
    }
    #[inline(always)]
    fn up<const BY: i32>(self) -> Self {
        self << BY
    }
    #[inline(always)]
    fn down<const BY: i32>(self) -> Self {
        self >> BY
    }
    #[inline(always)]
    fn equal_fields(self, other: Self) -> Self {
        of_fields(self, other, |a, b| if a == b { u16::MAX } else { 0 })
    }
    #[inline(always)]
    fn fields_below(self, other: Self) -> Self {
        of_fields(self, other, |a, b| if a < b { u16::MAX } else { 0 })
    }
    #[inline(always)]
    fn smaller_fields(self, other: Self) -> Self {
        of_fields(self, other, |a, b| a.min(b) as u16)
    }
}
