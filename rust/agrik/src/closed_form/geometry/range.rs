//! Ranges of numbers.

/// A range of numbers.
#[derive(Debug, Clone, Copy)]
pub struct Range {
    pub low: f64,
    pub high: f64,
}

impl Range {
    pub fn of(a: f64, b: f64) -> Self {
        Self { low: a.min(b), high: a.max(b) }
    }
    /// Numbers within `by` of `x`.
    pub fn about(x: f64, by: f64) -> Self {
        Self { low: x - by, high: x + by }
    }
    pub fn times(self, o: Self) -> Self {
        let all = [self.low * o.low, self.low * o.high, self.high * o.low, self.high * o.high];
        Self {
            low: all.into_iter().fold(f64::INFINITY, f64::min),
            high: all.into_iter().fold(f64::NEG_INFINITY, f64::max),
        }
    }
    pub fn plus(self, o: Self) -> Self {
        Self { low: self.low + o.low, high: self.high + o.high }
    }
    pub fn by(self, factor: f64) -> Self {
        Self::of(self.low * factor, self.high * factor)
    }
    pub fn square(self) -> Self {
        let (a, b) = (self.low * self.low, self.high * self.high);
        let low = if self.low <= 0.0 && self.high >= 0.0 { 0.0 } else { a.min(b) };
        Self { low, high: a.max(b) }
    }
    /// Wider by so much on both sides.
    pub fn wider(self, by: f64) -> Self {
        Self { low: self.low - by, high: self.high + by }
    }
    /// The inverse of positive numbers.
    pub fn inverse(self) -> Self {
        Self { low: 1.0 / self.high, high: 1.0 / self.low }
    }
}
