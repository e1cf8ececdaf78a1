//! Targets each within limits of its own.
//!
//! Rows are solved one after the other: what the chain knows of its limits, such as the table of
//! postures that starts are taken from, is used for all of them, with starts brought inside.

use super::Settings;
use super::plan::Plan;
use crate::call::{AnswersMut, Outcome, Request, Solve, Status};
use crate::chain::{Variable, hold_a_value};
use crate::error::{Error, Result};
use crate::lanes::Level;

/// A call of a step solver in which every row has limits.
#[derive(Debug, Clone)]
pub struct Limited<'a> {
    plan: Plan<'a>,
    /// Row by row, and joint by joint: the least and the largest value, rad or m.
    limits: &'a [[f64; 2]],
}

impl<'a> Limited<'a> {
    /// A call for a request: `limits` has a pair for each joint of each target, in place of the
    /// chain's. A row in which a pair is none, the larger number first or NaN, is bad input.
    pub fn new(request: Request<'a>, settings: Settings, limits: &'a [[f64; 2]]) -> Result<Self> {
        let wanted = request.len() * request.chain().dof();
        if limits.len() != wanted {
            return Err(Error::argument("limits", format!("{wanted} pairs"), limits.len()));
        }
        settings.check()?;
        Ok(Self { plan: Plan::new(request, settings)?, limits })
    }
}

impl Solve for Limited<'_> {
    fn rows(&self) -> usize {
        self.plan.rows()
    }
    fn dof(&self) -> usize {
        self.plan.dof()
    }
    fn run_length(&self) -> usize {
        64
    }
    fn run<'b>(
        &self,
        level: Level,
        next: &mut dyn FnMut() -> Option<AnswersMut<'b>>,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> bool {
        let dof = self.dof();
        while let Some(rows) = next() {
            for mut row in rows.split(1) {
                let limits = &self.limits[row.first * dof..][..dof];
                if limits.iter().all(|[lower, upper]| hold_a_value(*lower, *upper)) {
                    let plan = self.plan.within(limits);
                    let mut one = Some(row);
                    if !plan.run(level, &mut || one.take(), keep_going) {
                        return false;
                    }
                } else {
                    let none = self.plan.request().chain().variables().iter();
                    let q = row.finish(0, Outcome::unanswered(Status::BadInput));
                    q.iter_mut().zip(none.map(Variable::near_zero)).for_each(|(to, x)| *to = x);
                }
            }
            if !keep_going() {
                return false;
            }
        }
        true
    }
}
