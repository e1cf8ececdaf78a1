//! Sets that have something in common with each of some sets.

use std::collections::BTreeSet;

/// Sets that are looked at before the search for a least one is given up.
const MOST: usize = 200_000;

pub(super) type Set = BTreeSet<usize>;

/// What a search for a least set came to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Least {
    /// There is none with fewer elements.
    Set(Set),
    /// No set of so few elements will do.
    None,
    /// It was given up.
    Unknown,
}

/// A set of the fewest elements that meets each of `sets`, of `most` elements at most.
pub(super) fn least(sets: &[&Set], most: usize) -> Least {
    let mut looks = 0;
    for size in 0..=most {
        let mut taken = Set::new();
        match extend(sets, size, &mut taken, &mut looks) {
            Some(true) => return Least::Set(taken),
            Some(false) => {}
            None => return Least::Unknown,
        }
    }
    Least::None
}

/// Adds `more` elements at most so that each set is met: whether that can be, or nothing where
/// too much was looked at.
fn extend(sets: &[&Set], more: usize, taken: &mut Set, looks: &mut usize) -> Option<bool> {
    *looks += 1;
    if *looks > MOST {
        return None;
    }
    let open: Vec<&Set> = sets.iter().copied().filter(|set| set.is_disjoint(taken)).collect();
    let Some(smallest) = open.iter().min_by_key(|set| set.len()) else { return Some(true) };
    // Each of some sets that have nothing in common asks for an element of its own.
    let (mut apart, mut seen) = (0, Set::new());
    for set in &open {
        if set.is_disjoint(&seen) {
            apart += 1;
            seen.extend(set.iter());
        }
    }
    if apart > more {
        return Some(false);
    }
    for element in *smallest {
        taken.insert(*element);
        match extend(sets, more - 1, taken, looks) {
            Some(false) => {}
            settled => return settled,
        }
        taken.remove(element);
    }
    Some(false)
}

/// Few elements that meet each of `sets`, none of which is empty: always the one that most sets
/// have which are not met; then those are dropped that are not needed.
pub(super) fn few(sets: &[Set]) -> Set {
    let mut taken = Set::new();
    loop {
        let open: Vec<&Set> = sets.iter().filter(|set| set.is_disjoint(&taken)).collect();
        let all: Set = open.iter().flat_map(|set| set.iter().copied()).collect();
        let count = |element: &usize| open.iter().filter(|set| set.contains(element)).count();
        // Of several the first.
        let Some(best) = all.iter().rev().max_by_key(|element| count(element)) else { break };
        taken.insert(*best);
    }
    for element in taken.clone() {
        taken.remove(&element);
        if sets.iter().any(|set| set.is_disjoint(&taken)) {
            taken.insert(element);
        }
    }
    taken
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sets(given: &[&[usize]]) -> Vec<Set> {
        given.iter().map(|set| set.iter().copied().collect()).collect()
    }

    fn least_of(given: &[Set], most: usize) -> Least {
        least(&given.iter().collect::<Vec<_>>(), most)
    }

    #[test]
    fn least_sets_are_least() {
        // Taking what most sets have first needs three.
        let tricky = sets(&[&[0, 1, 9], &[2, 3, 9], &[0, 4, 9], &[2, 5], &[0, 6]]);
        assert_eq!(least_of(&tricky, 5), Least::Set([0, 2].into()));
        assert_eq!(least_of(&tricky, 1), Least::None);
        assert_eq!(least_of(&[], 3), Least::Set(Set::new()));
        assert_eq!(least_of(&sets(&[&[]]), 3), Least::None);
    }

    #[test]
    fn least_sets_are_those_of_brute_force() {
        let mut state = 7_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) as usize
        };
        for _ in 0..300 {
            let given: Vec<Set> = (0..1 + next() % 7)
                .map(|_| (0..1 + next() % 4).map(|_| next() % 9).collect())
                .collect();
            let meets = |mask: usize| {
                given.iter().all(|set| set.iter().any(|element| mask >> element & 1 == 1))
            };
            let by_force = (0..512_usize)
                .filter(|mask| meets(*mask))
                .map(|mask| mask.count_ones() as usize)
                .min();
            let Least::Set(found) = least_of(&given, 9) else { unreachable!("nine are enough") };
            assert_eq!(Some(found.len()), by_force);
            let few = few(&given);
            assert!(few.len() >= found.len());
            for set in [&found, &few] {
                assert!(given.iter().all(|one| !one.is_disjoint(set)));
            }
        }
    }
}
