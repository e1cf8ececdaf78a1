//! Rounded corners: curves that stay between the two straight ways of a path and what cuts the
//! corner off.
//!
//! Whatever a curve does in time, it is free where the whole triangle of postures is, in joint
//! space, whose vertices are where it leaves the one way, the corner, and where it comes to the
//! other. Every posture of a triangle has joint values within a margin of those of its middle,
//! and a body moves no farther on the way there than the sum of its levers times the margins.
//! Where that is not less than the distance that it has in the middle, the triangle is cut
//! into four.

use agrik_compute::threads::share;

use super::certifier::{Certifier, Known};
use super::mover::Bound;
use super::verdict::Keep;
use crate::body::check_postures;
use crate::{Collider, Error, Result};

/// How often a triangle may be cut.
const DEEPEST: u32 = 6;

impl Certifier<'_> {
    /// True where all postures of the triangle of three are proven free.
    pub fn corner(&mut self, vertices: [&[f64]; 3]) -> bool {
        let mut open = vec![(vertices.map(<[f64]>::to_vec), 0)];
        while let Some((triangle, depth)) = open.pop() {
            if self.is_free_round(&triangle) {
                continue;
            }
            if depth == DEEPEST {
                return false;
            }
            let [a, b, c] = &triangle;
            let half = |a: &[f64], b: &[f64]| -> Vec<f64> {
                a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect()
            };
            let (ab, bc, ca) = (half(a, b), half(b, c), half(c, a));
            open.extend([
                ([a.clone(), ab.clone(), ca.clone()], depth + 1),
                ([ab.clone(), b.clone(), bc.clone()], depth + 1),
                ([ca.clone(), bc.clone(), c.clone()], depth + 1),
                ([ab, bc, ca], depth + 1),
            ]);
        }
        true
    }

    /// The middle of a triangle is so far from everything that nothing is met in any of it.
    fn is_free_round(&mut self, [a, b, c]: &[Vec<f64>; 3]) -> bool {
        let middle: Vec<f64> =
            a.iter().zip(b).zip(c).map(|((a, b), c)| (a + b + c) / 3.0).collect();
        let margin = |k: usize| {
            let away = |vertex: &Vec<f64>| (vertex[k] - middle[k]).abs();
            away(a).max(away(b)).max(away(c))
        };
        // As far to either side as half of a way on which every joint goes twice its margin.
        let links = self.links();
        for (rate, link) in self.rates.iter_mut().zip(links) {
            *rate = 2.0 * link.multiplier.abs() * margin(link.variable);
        }
        self.take_middle(&middle);
        self.left.clear();
        self.left.extend(0..self.movers.len());
        self.take_bounds();
        // Which way bodies go is not known: nothing but the levers counts.
        self.bounds.iter_mut().chain([&mut self.tool]).for_each(Bound::forget_speed);
        let mut known = Known { least: f64::INFINITY, checks: 0, open: None };
        known.least = self.keep().clear;
        (0..self.movers.len()).all(|mover| {
            let answer = self.ask(mover, &self.middle, 0.5, &mut known);
            !answer.hit && answer.reach > 0.5
        })
    }
}

/// [`Certifier::corner`] for each row of three arrays (where curves leave, corners, where they
/// come to), on `threads` threads (0: the number in force).
///
/// # Errors
///
/// The arrays have not as many whole rows, a number is not finite, a number of `keep` is out of
/// its range, or `poll` said no.
pub fn check_corners(
    collider: &Collider,
    keep: Keep,
    [from, corners, to]: [&[f64]; 3],
    threads: usize,
    poll: &mut dyn FnMut() -> bool,
) -> Result<Vec<bool>> {
    keep.check()?;
    let chain = collider.bodies().chain();
    let dof = chain.dof();
    for q in [from, corners, to] {
        check_postures(chain, q)?;
        if q.len() != corners.len() {
            let expected = format!("{} rows, as there are corners", corners.len() / dof);
            return Err(Error::argument("corners", expected, q.len() / dof));
        }
    }
    // No more is told than is kept.
    let keep = keep.with_cap(keep.clear);
    let mut out = vec![false; corners.len() / dof];
    let work = |(row, to_row): (usize, &mut bool)| {
        let at = |q: &'_ [f64]| q[row * dof..(row + 1) * dof].to_vec();
        let (a, b, c) = (at(from), at(corners), at(to));
        *to_row = Certifier::new(collider, keep).corner([&a, &b, &c]);
    };
    if share(out.iter_mut().enumerate().collect(), threads, &work, poll) {
        Ok(out)
    } else {
        Err(Error::Interrupted)
    }
}
