//! What becomes of genes that leave their range.

use super::evaluator::Range;
use crate::lanes::Real;
use crate::random::Stream;

/// Rule for a gene out of its range; joints that turn freely are wrapped in any case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Boundary {
    /// The middle of the range.
    Median,
    /// The limit that was passed.
    Clamp,
    /// As far inside the limit as it was outside.
    Reflect,
    /// A new random value.
    #[default]
    Redraw,
}

impl Boundary {
    /// The rule applied to one gene of a block.
    #[inline(always)]
    pub fn apply<R: Real>(self, x: R, range: &Range<R>, stream: &mut Stream) -> R {
        let Range { lower, upper, middle, turns } = *range;
        let out = R::or(x.lt(lower), upper.lt(x));
        // A choice costs less than asking whether it is needed and guessing wrong.
        if self == Self::Median && !turns {
            return R::select(out, middle, x);
        }
        if R::bits(out) == 0 {
            return x;
        }
        if turns {
            let tau = std::f64::consts::TAU;
            let turns = ((x - middle) * R::splat(1.0 / tau)).round();
            return turns.mul_add(R::splat(-tau), x).max(lower).min(upper);
        }
        let inside = match self {
            Self::Median => middle,
            Self::Clamp => x.max(lower).min(upper),
            Self::Reflect => {
                let low = lower + (lower - x);
                let high = upper - (x - upper);
                R::select(x.lt(lower), low, high).max(lower).min(upper)
            }
            Self::Redraw => {
                let u: R = stream.uniforms();
                u.mul_add(upper - lower, lower)
            }
        };
        R::select(out, inside, x)
    }
}

#[cfg(test)]
mod tests {
    use super::super::evaluator::Gene;
    use super::*;

    const JOINT: Gene = Gene { lower: -2.0, upper: 2.5, turns: false };

    fn applied(rule: Boundary, x: f64) -> f64 {
        rule.apply(x, &JOINT.range(), &mut Stream::new(1))
    }

    #[test]
    fn the_median_rule_puts_a_gene_in_the_middle() {
        // The published case: 3.0 is out of joint 2's +-2 pi / 3 and becomes 0.
        let limit = 2.0 * std::f64::consts::FRAC_PI_3;
        let gene = Gene { lower: -limit, upper: limit, turns: false };
        assert_eq!(Boundary::Median.apply(3.0, &gene.range(), &mut Stream::new(0)), 0.0);
        assert_eq!(applied(Boundary::Median, -2.1), 0.25);
    }

    #[test]
    fn the_other_rules() {
        assert_eq!(applied(Boundary::Clamp, 3.0), 2.5);
        assert_eq!(applied(Boundary::Clamp, -3.0), -2.0);
        assert_eq!(applied(Boundary::Reflect, 3.0), 2.0);
        assert_eq!(applied(Boundary::Reflect, -2.5), -1.5);
        assert_eq!(applied(Boundary::Reflect, 90.0), -2.0);
        let drawn = applied(Boundary::Redraw, 3.0);
        assert!((-2.0..2.5).contains(&drawn));
    }

    #[test]
    fn genes_inside_stay_as_they_are() {
        for rule in [Boundary::Median, Boundary::Clamp, Boundary::Reflect, Boundary::Redraw] {
            for x in [-2.0, 0.1, 2.5] {
                assert_eq!(applied(rule, x), x);
            }
        }
    }

    #[test]
    fn free_joints_are_wrapped() {
        let pi = std::f64::consts::PI;
        let gene = Gene { lower: -pi, upper: pi, turns: true };
        let x = Boundary::Median.apply(4.0, &gene.range(), &mut Stream::new(0));
        assert!((x - (4.0 - 2.0 * pi)).abs() < 1e-14);
    }
}
