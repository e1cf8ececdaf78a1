//! All solvers by their names, and one way to ask any of them.

use crate::auto::Auto;
use crate::call::{AnswersMut, Prefer, Request, Solve};
use crate::closed_form::{ArmAngle, Choice, Query};
use crate::error::Result;
use crate::lanes::Level;
use crate::nearest::{Nearest, Nearness};
use crate::solve::{Climb, Limited, Plan, Refined, Settings, population};

/// A solver with its settings.
#[derive(Debug, Clone)]
pub enum Solver {
    /// A step solver.
    Step(Settings),
    /// A population solver.
    Population(population::Settings),
    /// The best of all branches.
    ClosedForm {
        /// What the best branch is best at.
        choice: Choice,
        /// Arm angle of an S-R-S arm, rad; `None`: the best one.
        arm_angle: Option<f64>,
        /// The best arm angle is proven to be the best.
        proof: bool,
    },
    /// A closed form where the arm and the task have one, else the default step solver.
    Auto,
}

impl Solver {
    /// Name of the closed form.
    pub const CLOSED_FORM: &'static str = "closed_form";
    /// Name of the choice between a closed form and the default step solver.
    pub const AUTO: &'static str = "auto";

    /// The names of all solvers: step solvers, population solvers, the closed form, the choice.
    pub fn names() -> impl Iterator<Item = &'static str> {
        let steps = Settings::KNOWN.iter().map(|(name, _)| *name);
        let searches = population::Settings::KNOWN.iter().map(|(name, _)| *name);
        steps.chain(searches).chain([Self::CLOSED_FORM, Self::AUTO])
    }

    /// The solver of a name, with its defaults.
    pub fn named(name: &str) -> Option<Self> {
        if let Some((_, settings)) = Settings::KNOWN.iter().find(|(known, _)| *known == name) {
            return Some(Self::Step(settings.clone()));
        }
        let searches = population::Settings::KNOWN;
        if let Some((_, settings)) = searches.into_iter().find(|(known, _)| *known == name) {
            return Some(Self::Population(settings));
        }
        match name {
            Self::CLOSED_FORM => {
                Some(Self::ClosedForm { choice: Choice::default(), arm_angle: None, proof: false })
            }
            Self::AUTO => Some(Self::Auto),
            _ => None,
        }
    }

    /// Refuses settings outside their ranges.
    pub fn check(&self) -> Result<()> {
        match self {
            Self::Step(settings) => settings.check(),
            Self::Population(settings) => settings.check(),
            Self::ClosedForm { .. } | Self::Auto => Ok(()),
        }
    }

    /// A request to this solver, checked and ready.
    pub fn call<'a>(&self, request: Request<'a>) -> Result<Call<'a>> {
        let is_loop = matches!(self, Self::Step(s) if !s.plain && !s.step.is_feedback());
        let call = if request.second().is_none() || is_loop {
            self.plain_call(request)?
        } else {
            let call = self.plain_call(request.without_second())?;
            Call::Refined(Box::new(Refined::new(request, call)?))
        };
        match request.guard().filter(|guard| guard.prefer == Prefer::Clearance) {
            Some(guard) => Ok(Call::Climb(Box::new(Climb::new(request, guard, call)?))),
            None => Ok(call),
        }
    }

    /// The same, whose answers are the nearest ones to the start values.
    pub fn nearest_call<'a>(
        &self,
        request: Request<'a>,
        nearness: &'a Nearness,
    ) -> Result<Call<'a>> {
        let call = self.call(request)?;
        Ok(Call::Nearest(Box::new(Nearest::new(request, nearness, call)?)))
    }

    /// Rows may have limits of their own: solvers that follow the Jacobian.
    pub fn takes_limits(&self) -> bool {
        matches!(self, Self::Step(settings) if !settings.step.is_feedback())
    }

    /// A request whose rows have limits of their own; none for solvers without, and for wishes that
    /// move answers on by the limits of the arm: second aims, and the most clearance.
    pub fn limited_call<'a>(
        &self,
        request: Request<'a>,
        limits: &'a [[f64; 2]],
    ) -> Result<Option<Call<'a>>> {
        let climbs = request.guard().is_some_and(|guard| guard.prefer == Prefer::Clearance);
        let Self::Step(settings) = self else { return Ok(None) };
        if !self.takes_limits() || climbs || request.second().is_some() {
            return Ok(None);
        }
        Ok(Some(Call::Limited(Box::new(Limited::new(request, settings.clone(), limits)?))))
    }

    fn plain_call<'a>(&self, request: Request<'a>) -> Result<Call<'a>> {
        match self {
            Self::Step(settings) => Ok(Call::Plan(Plan::new(request, settings.clone())?)),
            Self::Population(settings) => {
                Ok(Call::Evolution(population::Evolution::new(request, *settings)?))
            }
            Self::ClosedForm { choice, arm_angle, proof } => {
                let angle = arm_angle.map_or(ArmAngle::Free, ArmAngle::One);
                let query = Query::new(request, angle, *choice)?;
                Ok(Call::Query(if *proof { query.with_proof() } else { query }))
            }
            Self::Auto if Auto::knows(&request) => Ok(Call::Auto(Auto::new(request)?)),
            Self::Auto => Ok(Call::Plan(Plan::new(request, Settings::default())?)),
        }
    }
}

impl Default for Solver {
    fn default() -> Self {
        Self::Step(Settings::default())
    }
}

/// A call of any solver.
#[derive(Debug, Clone)]
pub enum Call<'a> {
    /// Of a step solver.
    Plan(Plan<'a>),
    /// Of a population solver.
    Evolution(population::Evolution<'a>),
    /// Of a closed form.
    Query(Query<'a>),
    /// Of a closed form, with the default step solver behind it.
    Auto(Auto<'a>),
    /// Of a step solver, within limits of each row.
    Limited(Box<Limited<'a>>),
    /// Of any of them, whose answers are moved to where a second aim is best.
    Refined(Box<Refined<'a, Self>>),
    /// Of any of them, whose answers are replaced by nearer ones.
    Nearest(Box<Nearest<'a, Self>>),
    /// Of any of them, whose answers are moved away from what they must not hit.
    Climb(Box<Climb<'a, Self>>),
}

impl Call<'_> {
    /// The solver's own call.
    fn inner(&self) -> &dyn Solve {
        match self {
            Self::Plan(plan) => plan,
            Self::Evolution(evolution) => evolution,
            Self::Query(query) => query,
            Self::Auto(auto) => auto,
            Self::Limited(limited) => &**limited,
            Self::Refined(refined) => &**refined,
            Self::Nearest(nearest) => &**nearest,
            Self::Climb(climb) => &**climb,
        }
    }
}

impl Solve for Call<'_> {
    fn rows(&self) -> usize {
        self.inner().rows()
    }
    fn dof(&self) -> usize {
        self.inner().dof()
    }
    fn run_length(&self) -> usize {
        self.inner().run_length()
    }
    fn run<'a>(
        &self,
        level: Level,
        next: &mut dyn FnMut() -> Option<AnswersMut<'a>>,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> bool {
        self.inner().run(level, next, keep_going)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_that_of_its_solver() {
        let names: Vec<&str> = Solver::names().collect();
        for (i, name) in names.iter().enumerate() {
            assert!(!names[..i].contains(name), "{name} twice");
            match Solver::named(name).expect("known") {
                Solver::Step(settings) => assert_eq!(settings.step.name(), *name),
                Solver::Population(settings) => assert_eq!(settings.name(), *name),
                Solver::ClosedForm { .. } => assert_eq!(*name, Solver::CLOSED_FORM),
                Solver::Auto => assert_eq!(*name, Solver::AUTO),
            }
        }
        assert!(Solver::named("newton").is_none());
        assert_eq!(names[0], "lm");
    }
}
