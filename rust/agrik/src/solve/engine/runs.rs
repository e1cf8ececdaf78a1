//! The runs of rows in work: which row is next, where its answer goes.

use smallvec::SmallVec;

use crate::call::{AnswersMut, Outcome, Status};

/// The runs in work, one to a slot.
pub(super) struct Runs<'a>(SmallVec<[Option<Open<'a>>; 2]>);

/// A run with the number of its unfinished rows.
struct Open<'a> {
    run: AnswersMut<'a>,
    /// Next row to hand to a lane.
    next: usize,
    unfinished: usize,
}

/// Slot of a row's run and the row inside it.
pub(super) type Place = (usize, usize);

impl<'a> Runs<'a> {
    pub fn new() -> Self {
        Self(SmallVec::new())
    }

    /// The next row of the open runs (its place, and its number in the whole call), from
    /// another run where they are used up.
    #[inline(always)]
    pub fn next_row(
        &mut self,
        next: &mut dyn FnMut() -> Option<AnswersMut<'a>>,
    ) -> Option<(Place, usize)> {
        loop {
            for (slot, entry) in self.0.iter_mut().enumerate() {
                if let Some(open) = entry
                    && open.next < open.run.len()
                {
                    let i = open.next;
                    open.next += 1;
                    return Some(((slot, i), open.run.first + i));
                }
            }
            let run = next()?;
            let fresh = Open { next: 0, unfinished: run.len(), run };
            match self.0.iter_mut().find(|entry| entry.is_none()) {
                Some(entry) => *entry = Some(fresh),
                None => self.0.push(Some(fresh)),
            }
        }
    }

    /// Writes the answer of a row, and lets its run go with the last one.
    #[inline(always)]
    pub fn finish(&mut self, (slot, i): Place, outcome: Outcome, q: impl Iterator<Item = f64>) {
        let Some(open) = &mut self.0[slot] else { return };
        for (to, from) in open.run.finish(i, outcome).iter_mut().zip(q) {
            *to = from;
        }
        open.unfinished -= 1;
        if open.unfinished == 0 {
            self.0[slot] = None;
        }
    }

    /// A row has an answer that reached its target.
    pub fn is_reached(&self, (slot, i): Place) -> bool {
        self.0[slot].as_ref().is_some_and(|open| open.run.ended(i, Status::Converged))
    }

    /// The joint values that a row has.
    pub fn q(&self, (slot, i): Place) -> &[f64] {
        self.0[slot].as_ref().map_or(&[], |open| open.run.q(i))
    }

    /// What a row says, which reached its target.
    pub fn outcome(&self, (slot, i): Place) -> Outcome {
        let none = Outcome::unanswered(Status::NotFound);
        self.0[slot].as_ref().map_or(none, |open| open.run.outcome(i))
    }

    /// Leaves a row as it is, and lets its run go with the last one.
    pub fn keep(&mut self, (slot, _): Place) {
        let Some(open) = &mut self.0[slot] else { return };
        open.unfinished -= 1;
        if open.unfinished == 0 {
            self.0[slot] = None;
        }
    }
}
