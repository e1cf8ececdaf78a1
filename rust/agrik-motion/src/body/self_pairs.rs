//! Which bodies of an arm may hit each other, and why others are not asked.

use std::collections::HashSet;

use agrik::chain::{Chain, JointKind};
use agrik_compute::random::mix;
use agrik_solids::within;

use super::bodies::Bodies;
use crate::{Error, Result};

/// Postures that the structure of an arm is judged by.
const POSTURES: usize = 4000;
/// Share of them above which two bodies at most [`NEAR`] joints apart are made to hit, and
/// above which any two are.
const OFTEN: f64 = 0.25;
const ALWAYS: f64 = 0.95;
const NEAR: usize = 2;

/// Why a pair of bodies is not asked whether it hits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reason {
    /// No joint lies between them.
    SameLink,
    /// One joint lies between them.
    Adjacent,
    /// They hit in this share of 4,000 postures drawn evenly from the limits: more than a
    /// quarter at two joints apart, or more than 95 % at any distance.
    Structural(f64),
    /// Whoever gave the pairs left it out.
    NotListed,
}

impl Reason {
    /// The words that users know it by.
    pub fn name(self) -> &'static str {
        match self {
            Self::SameLink => "same link",
            Self::Adjacent => "adjacent",
            Self::Structural(_) => "structural",
            Self::NotListed => "not listed",
        }
    }
}

/// A pair of bodies that is not asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Excluded {
    /// The bodies, the lower index first.
    pub pair: (usize, usize),
    /// Why.
    pub reason: Reason,
}

/// All pairs of an arm's bodies.
#[derive(Debug, Clone, Default)]
pub(super) struct Pairs {
    pub asked: Vec<(usize, usize)>,
    pub excluded: Vec<Excluded>,
}

/// Pairs that somebody gave, in their order.
pub(super) fn given(pairs: &[(usize, usize)], count: usize) -> Result<Pairs> {
    let (mut made, mut listed) = (Pairs::default(), HashSet::new());
    for &(i, j) in pairs {
        if i == j || i.max(j) >= count {
            let expected = format!("pairs of two different bodies, 0 to {}", count as i64 - 1);
            return Err(Error::argument("self_pairs", expected, format!("({i}, {j})")));
        }
        if listed.insert((i.min(j), i.max(j))) {
            made.asked.push((i.min(j), i.max(j)));
        }
    }
    let listed = |pair: &(usize, usize)| listed.contains(pair);
    made.excluded = all(count)
        .filter(|pair| !listed(pair))
        .map(|pair| Excluded { pair, reason: Reason::NotListed })
        .collect();
    Ok(made)
}

/// Pairs by the rules. Those that were never seen hitting stay, as a sample is no proof.
pub(super) fn by_the_rules(bodies: &Bodies) -> Pairs {
    let mut made = Pairs::default();
    let joints_between = |(i, j): (usize, usize)| bodies.moved_by(i).abs_diff(bodies.moved_by(j));
    for pair in all(bodies.len()) {
        match joints_between(pair) {
            0 => made.excluded.push(Excluded { pair, reason: Reason::SameLink }),
            1 => made.excluded.push(Excluded { pair, reason: Reason::Adjacent }),
            _ => made.asked.push(pair),
        }
    }
    let mut hits = vec![0; made.asked.len()];
    let mut placed = bodies.room();
    for q in postures(bodies.chain(), POSTURES) {
        bodies.place_unchecked(&q, &mut placed);
        let solids = placed.solids();
        for (count, &(i, j)) in hits.iter_mut().zip(&made.asked) {
            *count += usize::from(within(&solids[i], &solids[j], 0.0));
        }
    }
    let mut asked = Vec::with_capacity(made.asked.len());
    for (pair, count) in made.asked.into_iter().zip(hits) {
        let share = count as f64 / POSTURES as f64;
        let near = joints_between(pair) <= NEAR;
        if share > ALWAYS || near && share > OFTEN {
            made.excluded.push(Excluded { pair, reason: Reason::Structural(share) });
        } else {
            asked.push(pair);
        }
    }
    made.asked = asked;
    made.excluded.sort_unstable_by_key(|excluded| excluded.pair);
    made
}

/// All pairs of so many bodies, the lower index first.
fn all(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |i| (i + 1..count).map(move |j| (i, j)))
}

/// Postures drawn evenly from the limits (SplitMix64 with seed 1), turns without limits from
/// one turn, slides without them from as far as the arm reaches.
pub(super) fn postures(chain: &Chain, count: usize) -> impl Iterator<Item = Vec<f64>> {
    use std::f64::consts::PI;
    let ranges: Vec<(f64, f64)> = chain
        .variables()
        .iter()
        .map(|v| {
            let most = if v.kind == JointKind::Prismatic { chain.reach().size } else { PI };
            let bounded = v.lower.is_finite() && v.upper.is_finite();
            if bounded { (v.lower, v.upper) } else { (v.lower.max(-most), v.upper.min(most)) }
        })
        .collect();
    let mut state = 1_u64;
    let mut uniform = move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (mix(state) >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..count).map(move |_| {
        ranges.iter().map(|(lower, upper)| lower + (upper - lower) * uniform()).collect()
    })
}
