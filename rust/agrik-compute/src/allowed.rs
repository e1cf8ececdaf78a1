//! The numbers that an argument may be, and the words for them.

use std::fmt;

use crate::error::{Error, Result};

/// The largest size of a measure: a length, coordinate, joint value, weight or gain. Beyond any
/// that means something, and small enough for products of six to be numbers still.
pub const LARGEST: f64 = 1e50;

/// True for a finite number no larger than a measure may be.
#[inline(always)]
pub fn is_measure(x: f64) -> bool {
    // False for NaN.
    x.abs() <= LARGEST
}

/// Refuses an argument with a number that is no measure.
pub fn check_measures(argument: &str, numbers: impl IntoIterator<Item = f64>) -> Result<()> {
    match numbers.into_iter().find(|x| !is_measure(*x)) {
        None => Ok(()),
        Some(x) if x.is_finite() => {
            let expected = format!("numbers of size {LARGEST:e} at most");
            Err(Error::argument(argument, expected, format!("{x:e}")))
        }
        Some(_) => Err(Error::argument(argument, "finite numbers", "NaN or infinity")),
    }
}

/// A range of finite numbers; written out as an error message wants it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Allowed {
    lower: f64,
    upper: f64,
    /// The lower end itself is out of the range.
    open_below: bool,
    /// The upper end itself is out of the range.
    open_above: bool,
    whole: bool,
    unit: &'static str,
}

impl Allowed {
    /// Any finite number.
    pub const FINITE: Self = Self {
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        open_below: false,
        open_above: false,
        whole: false,
        unit: "",
    };
    /// Above 0.
    pub const POSITIVE: Self = Self { lower: 0.0, open_below: true, ..Self::FINITE };
    /// 0 or above.
    pub const NOT_NEGATIVE: Self = Self { lower: 0.0, ..Self::FINITE };
    /// A count, 0 included.
    pub const COUNT: Self = Self::whole(0, u32::MAX);
    /// From 0 to 1.
    pub const SHARE: Self = Self { lower: 0.0, upper: 1.0, ..Self::FINITE };

    /// Above 0 and at most `upper`.
    pub const fn up_to(upper: f64) -> Self {
        Self { upper, ..Self::POSITIVE }
    }

    /// Above 0 and below `upper`.
    pub const fn below(upper: f64) -> Self {
        Self { upper, open_above: true, ..Self::POSITIVE }
    }

    /// From `lower` to `upper`.
    pub const fn between(lower: f64, upper: f64) -> Self {
        Self { lower, upper, ..Self::FINITE }
    }

    /// Whole numbers from `lower` to `upper`.
    pub const fn whole(lower: u32, upper: u32) -> Self {
        Self { lower: lower as f64, upper: upper as f64, whole: true, ..Self::FINITE }
    }

    /// The same numbers, said to be of a unit.
    pub const fn of(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// True for a number of the range.
    pub fn contains(&self, x: f64) -> bool {
        let above = if self.open_below { x > self.lower } else { x >= self.lower };
        let below = if self.open_above { x < self.upper } else { x <= self.upper };
        x.is_finite() && above && below && (!self.whole || x.fract() == 0.0)
    }

    /// Refuses an argument that is out of the range.
    pub fn check(&self, argument: &str, value: impl Into<f64>) -> Result<()> {
        let value = value.into();
        if self.contains(value) {
            return Ok(());
        }
        Err(Error::argument(argument, self.to_string(), value))
    }
}

impl fmt::Display for Allowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { lower, upper, open_below, open_above, whole, unit } = *self;
        if whole {
            return write!(f, "a whole number, {lower} to {upper}");
        }
        f.write_str("a finite number")?;
        if lower.is_finite() {
            write!(f, " {} {lower}", if open_below { ">" } else { ">=" })?;
        }
        if upper.is_finite() {
            let and = if lower.is_finite() { " and" } else { "" };
            write!(f, "{and} {} {upper}", if open_above { "<" } else { "<=" })?;
        }
        if unit.is_empty() { Ok(()) } else { write!(f, " {unit}") }
    }
}

/// A number among the settings of a solver: its name, where it is kept, what it may be.
#[derive(Debug)]
pub struct Field<'a> {
    /// Name as the caller knows it.
    pub name: &'static str,
    /// Where it is kept.
    pub value: Number<'a>,
    /// What it may be.
    pub allowed: Allowed,
}

/// A number of either kind.
#[derive(Debug)]
pub enum Number<'a> {
    /// A real number.
    Real(&'a mut f64),
    /// A count.
    Count(&'a mut u32),
}

impl<'a> Field<'a> {
    /// A real number.
    pub fn real(name: &'static str, value: &'a mut f64, allowed: Allowed) -> Self {
        Self { name, value: Number::Real(value), allowed }
    }

    /// A count.
    pub fn count(name: &'static str, value: &'a mut u32, allowed: Allowed) -> Self {
        Self { name, value: Number::Count(value), allowed }
    }

    /// Refuses a number that is not allowed.
    pub fn check(&self) -> Result<()> {
        match &self.value {
            Number::Real(x) => self.allowed.check(self.name, **x),
            Number::Count(n) => self.allowed.check(self.name, **n),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measures_are_finite_and_not_huge() {
        for x in [0.0, -0.0, 1.5, 5e-324, -LARGEST] {
            assert!(is_measure(x), "{x}");
        }
        let said = |x: f64| check_measures("tool", [0.0, x]).err().map(|error| error.to_string());
        assert_eq!(said(1.0), None);
        let expected = "tool: expected numbers of size 1e50 at most, got -1e160";
        assert_eq!(said(-1e160).as_deref(), Some(expected));
        for x in [f64::NAN, f64::INFINITY] {
            let expected = "tool: expected finite numbers, got NaN or infinity";
            assert_eq!(said(x).as_deref(), Some(expected));
        }
    }

    #[test]
    fn ends_belong_where_they_are_said_to() {
        let cases = [
            (Allowed::POSITIVE, "a finite number > 0", [(0.0, false), (5e-324, true)]),
            (Allowed::NOT_NEGATIVE, "a finite number >= 0", [(0.0, true), (-5e-324, false)]),
            (Allowed::SHARE, "a finite number >= 0 and <= 1", [(1.0, true), (1.1, false)]),
            (Allowed::up_to(2.0), "a finite number > 0 and <= 2", [(2.0, true), (0.0, false)]),
            (Allowed::below(1.0), "a finite number > 0 and < 1", [(1.0, false), (0.5, true)]),
            (Allowed::whole(1, 9), "a whole number, 1 to 9", [(9.0, true), (1.5, false)]),
            (Allowed::POSITIVE.of("m"), "a finite number > 0 m", [(1.0, true), (-1.0, false)]),
        ];
        for (range, words, numbers) in cases {
            assert_eq!(range.to_string(), words);
            for (x, inside) in numbers {
                assert_eq!(range.contains(x), inside, "{x} in {words}");
                let error = range.check("x", x).err().map(|error| error.to_string());
                let said = format!("x: expected {words}, got {x}");
                assert_eq!(error, (!inside).then_some(said));
            }
            for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                assert!(!range.contains(x), "{x} in {words}");
            }
        }
    }
}
