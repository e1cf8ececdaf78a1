//! The solver that needs no choice: the closed form, and the default step solver for targets
//! that it leaves open.
//!
//! A closed form ends with a solution, a proof that there is none, or neither. Targets of the
//! last kind (singular postures at joint limits, mostly) go on to the step solver, each by
//! itself: with the request's seed and its own index, so that its answer does not depend on
//! what else is in the batch.
//!
//! Of an arm on a slide the slide is swept, and the arm behind it solved in closed form; that
//! proves nothing, so the step solver gets all that the sweep leaves open.

use std::sync::OnceLock;

use crate::call::{AnswersMut, Outcome, Request, Solve, Status};
use crate::closed_form::{ArmAngle, Choice, ClosedForm, Lead, Query, Sweep};
use crate::error::Result;
use crate::lanes::Level;
use crate::solve::{Plan, Settings};

/// So many open targets are solved together: enough to fill the lanes.
const TOGETHER: usize = 64;
/// Rows that a thread takes at a time where each is a sweep.
const SWEPT: usize = 16;

/// How the closed form is asked.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant, reason = "there is one of them a call")]
enum Form<'a> {
    /// For the best branch of each target.
    Query(Query<'a>),
    /// The same of an arm on a slide.
    Sweep(Sweep<'a>),
}

/// A request to the closed form with the default step solver behind it.
#[derive(Debug, Clone)]
pub struct Auto<'a> {
    form: Form<'a>,
    request: Request<'a>,
    /// Made for the first target that needs it: mostly none does.
    plan: OnceLock<Result<Box<Plan<'a>>>>,
}

impl<'a> Auto<'a> {
    /// A checked request for full poses of an arm with a closed form; the nearest branch, of
    /// all arm angles or places of the slide where one is free.
    pub fn new(request: Request<'a>) -> Result<Self> {
        let form = match Sweep::new(request)? {
            Some(sweep) => Form::Sweep(sweep),
            None => Form::Query(Query::new(request, ArmAngle::Free, Choice::default())?),
        };
        Ok(Self { form, request, plan: OnceLock::new() })
    }

    /// A request that [`Self::new`] takes.
    pub fn knows(request: &Request<'_>) -> bool {
        let chain = request.chain();
        request.task().fixes_pose()
            && (ClosedForm::of(chain).is_ok() || Lead::slide(chain).is_some())
    }

    /// Puts the closed form's answers into rows; false where `keep_going` said no.
    fn ask(
        &self,
        level: Level,
        rows: &mut AnswersMut<'_>,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> bool {
        match &self.form {
            Form::Query(query) => {
                let mut all = Some(rows.reborrow());
                query.run(level, &mut || all.take(), keep_going)
            }
            Form::Sweep(sweep) => (0..rows.len()).all(|i| {
                if !sweep.answer(rows, i) {
                    let open = Outcome::unanswered(Status::NotFound);
                    rows.finish(i, open);
                }
                keep_going()
            }),
        }
    }

    /// A target may have answers that the closed form has not found: of an arm with a free arm
    /// angle also some that are accepted where those looked at are not.
    fn is_open(&self, row: &AnswersMut<'_>) -> bool {
        let redundant = match &self.form {
            Form::Query(query) => query.is_redundant(),
            Form::Sweep(_) => true,
        };
        row.any(Status::NotFound) || row.any(Status::InCollision) && redundant
    }

    /// Solves what is left open; false where `keep_going` said no.
    fn go_on<'b>(
        &self,
        level: Level,
        open: &mut Vec<AnswersMut<'b>>,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> bool {
        if open.is_empty() {
            return true;
        }
        let plan =
            self.plan.get_or_init(|| Plan::new(self.request, Settings::default()).map(Box::new));
        // The request is checked and the settings are the default: there is a plan. Without
        // one the targets would stay as the closed form left them.
        let Ok(plan) = plan else {
            open.clear();
            return true;
        };
        let mut open = open.drain(..);
        plan.run(level, &mut || open.next(), keep_going)
    }
}

impl Solve for Auto<'_> {
    fn rows(&self) -> usize {
        self.request.len()
    }
    fn dof(&self) -> usize {
        self.request.chain().dof()
    }
    fn run_length(&self) -> usize {
        match &self.form {
            Form::Query(query) => query.run_length(),
            Form::Sweep(_) => SWEPT,
        }
    }
    fn run<'b>(
        &self,
        level: Level,
        next: &mut dyn FnMut() -> Option<AnswersMut<'b>>,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> bool {
        let mut open = Vec::new();
        while let Some(mut rows) = next() {
            if !self.ask(level, &mut rows, keep_going) {
                return false;
            }
            if rows.any(Status::NotFound) || rows.any(Status::InCollision) {
                let single = rows.split(1).into_iter();
                open.extend(single.filter(|row| self.is_open(row)));
            }
            if open.len() >= TOGETHER && !self.go_on(level, &mut open, keep_going) {
                return false;
            }
        }
        self.go_on(level, &mut open, keep_going)
    }
}
