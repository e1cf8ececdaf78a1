//! Answers of any call, moved to where a second aim is best.

use super::plan::Plan;
use super::step::Settings;
use crate::call::{AnswersMut, Request, Solve};
use crate::error::Result;
use crate::lanes::Level;

/// A call, and the plan that moves its answers.
#[derive(Debug, Clone)]
pub struct Refined<'a, C> {
    call: C,
    plan: Plan<'a>,
}

impl<'a, C> Refined<'a, C> {
    /// A call for a request with a second aim.
    pub fn new(request: Request<'a>, call: C) -> Result<Self> {
        Ok(Self { call, plan: Plan::new(request, Settings::default())? })
    }
}

impl<C: Solve> Solve for Refined<'_, C> {
    fn rows(&self) -> usize {
        self.call.rows()
    }
    fn dof(&self) -> usize {
        self.call.dof()
    }
    fn run_length(&self) -> usize {
        self.call.run_length()
    }
    fn run<'b>(
        &self,
        level: Level,
        next: &mut dyn FnMut() -> Option<AnswersMut<'b>>,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> bool {
        while let Some(mut rows) = next() {
            let mut all = Some(rows.reborrow());
            if !self.call.run(level, &mut || all.take(), keep_going)
                || !self.plan.refine(level, rows, keep_going)
            {
                return false;
            }
        }
        true
    }
}
