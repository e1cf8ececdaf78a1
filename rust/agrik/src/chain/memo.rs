//! Facts that others derive from a chain, kept with it: each is made when it is first asked
//! for. The chain knows none of them.

use std::any::Any;
use std::fmt;
use std::sync::OnceLock;

/// Derived facts, one of each type, in a list that only grows. A look takes no lock.
#[derive(Default)]
pub(super) struct Memo {
    first: OnceLock<Box<Node>>,
}

struct Node {
    fact: Box<dyn Any + Send + Sync>,
    next: OnceLock<Box<Node>>,
}

impl Memo {
    /// The fact of type `T`, made by `make` where there is none yet.
    ///
    /// Two threads that ask at once may both make it, and one is kept: nobody waits while
    /// somebody else's fact is made, and a fact may be made out of others.
    pub fn get_or_make<T: Any + Send + Sync>(&self, make: impl Fn() -> T) -> &T {
        let mut place = &self.first;
        while let Some(node) = place.get() {
            if let Some(fact) = node.fact.downcast_ref() {
                return fact;
            }
            place = &node.next;
        }
        let mut made = Some(make());
        loop {
            let node = place.get_or_init(|| {
                // Once it is kept this loop ends, so it is made once.
                let fact = made.take().unwrap_or_else(&make);
                Box::new(Node { fact: Box::new(fact), next: OnceLock::new() })
            });
            if let Some(fact) = node.fact.downcast_ref() {
                return fact;
            }
            // Another fact has come in between.
            place = &node.next;
        }
    }
}

/// A copy of a chain makes its facts anew.
impl Clone for Memo {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl fmt::Debug for Memo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Memo").finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    #[derive(Debug, PartialEq)]
    struct Small(usize);
    #[derive(Debug, PartialEq)]
    struct Large(usize);

    #[test]
    fn each_fact_is_made_once_and_may_be_made_of_others() {
        let (memo, made) = (Memo::default(), AtomicUsize::new(0));
        let count = || made.fetch_add(1, Ordering::Relaxed);
        let large = || {
            count();
            Large(memo.get_or_make(|| Small(1 + count())).0 * 10)
        };
        assert_eq!(memo.get_or_make(large), &Large(20));
        assert_eq!(memo.get_or_make(large), &Large(20));
        assert_eq!(memo.get_or_make(|| Small(77)), &Small(2));
        assert_eq!(made.load(Ordering::Relaxed), 2);
    }

    #[test]
    fn threads_get_the_same_fact() {
        let memo = Memo::default();
        let places: Vec<usize> = std::thread::scope(|scope| {
            let ask = |i: usize| {
                let memo = &memo;
                scope.spawn(move || {
                    let small = || Small(i);
                    let large = || Large(i);
                    if i.is_multiple_of(2) {
                        memo.get_or_make(large);
                    }
                    std::ptr::from_ref(memo.get_or_make(small)) as usize
                })
            };
            let asked: Vec<_> = (0..8).map(ask).collect();
            asked.into_iter().map(|thread| thread.join().expect("no panic")).collect()
        });
        assert!(places.iter().all(|place| *place == places[0]), "{places:?}");
    }
}
