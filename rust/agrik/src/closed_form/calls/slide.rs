//! The best branch of an arm on a slide: its slide is swept, and at each of its places the
//! arm behind it is solved in closed form.
//!
//! The sweep decides the branch and roughly the place; steps that are halved make it as near
//! to the start values as the branch comes. Every posture on the way reaches the target.

use super::all_branches::all;
use super::arm_angle::ArmAngle;
use super::locked::moved_tail;
use super::query::Query;
use crate::call::{Aim, AnswersMut, Goals, Outcome, Request, Starts, Status};
use crate::chain::{Reach, Tail};
use crate::closed_form::branch::choice::Choice;
use crate::closed_form::families::Lead;
use crate::error::Result;
use crate::kinematics::{Workspace, forward};

/// Places of the slide that are looked at.
const PLACES: usize = 32;
/// How often the way between two places is halved.
const HALVINGS: usize = 24;

/// A request to an arm on a slide for full poses.
#[derive(Debug, Clone, Copy)]
pub struct Sweep<'a> {
    request: Request<'a>,
    lead: &'a Lead,
    aim: Aim,
    reach: Reach,
    limits: [f64; 2],
}

/// A posture of the whole arm and what it costs.
struct Posture {
    slide: f64,
    q: Vec<f64>,
    cost: f64,
}

impl<'a> Sweep<'a> {
    /// The request, if it is one to an arm on a slide and for full poses.
    pub fn new(request: Request<'a>) -> Result<Option<Self>> {
        if !request.task().fixes_pose() {
            return Ok(None);
        }
        let Some(lead) = Lead::slide(request.chain()) else { return Ok(None) };
        let (rest, whole) = (lead.rest(), request.chain());
        let tail = moved_tail(whole, rest, request.tail());
        let aim = Aim::new(rest, request.task(), request.tolerance(), tail)?;
        let tail: &Tail = aim.tail();
        let reach = Reach::with_tail(rest.compiled(), rest.variables(), tail);
        let slide = &whole.variables()[lead.variable()];
        Ok(Some(Self { request, lead, aim, reach, limits: [slide.lower, slide.upper] }))
    }

    /// Writes the best branch of row `i` of a run, if the sweep finds one; true if it does.
    pub(crate) fn answer(&self, rows: &mut AnswersMut<'_>, i: usize) -> bool {
        let row = rows.first + i;
        let (Goals::Poses(poses), Some(goal)) = (self.request.goals(), self.request.goal(row))
        else {
            return false;
        };
        let Some(best) = self.best(&poses[row], self.request.start(row)) else { return false };
        let chain = self.request.chain();
        let mut workspace = Workspace::new(chain.compiled());
        forward(chain.compiled(), &best.q, &mut workspace);
        let left = self.request.left(&workspace, &goal);
        if !self.request.aim().is_met(&left) {
            return false;
        }
        let outcome = Outcome {
            position_error: left.position2.sqrt(),
            orientation_error: left.orientation2.sqrt(),
            ..Outcome::unanswered(Status::Converged)
        };
        rows.finish(i, outcome).copy_from_slice(&best.q);
        true
    }

    fn best(&self, pose: &[f64; 16], start: Option<&[f64]>) -> Option<Posture> {
        let (low, high) = self.lead.within_reach(pose, &self.reach, self.limits)?;
        let variables = self.request.chain().variables();
        let centre: Vec<f64> = match start {
            Some(q0) => {
                let place = [3, 7, 11].map(|k| pose[k]);
                let size = self.request.chain().reach().size;
                let most = self.request.aim().well_known(size, place);
                q0.iter().zip(variables).map(|(x, v)| v.reference(*x, most)).collect()
            }
            None => variables.iter().map(|v| v.middle()).collect(),
        };
        let here = centre[self.lead.variable()].clamp(low, high);
        let step = (high - low) / (PLACES - 1) as f64;
        let places = (0..PLACES).map(|k| step.mul_add(k as f64, low).min(high));
        let places: Vec<f64> = std::iter::once(here).chain(places).collect();
        let mut best = self.best_of(pose, &places, &centre)?;
        let mut step = step;
        for _ in 0..HALVINGS {
            step *= 0.5;
            let sides = [best.slide - step, best.slide + step].map(|x| x.clamp(low, high));
            if let Some(next) = self.best_of(pose, &sides, &centre)
                && next.cost < best.cost
            {
                best = next;
            }
        }
        Some(best)
    }

    /// The valid branch nearest to the centre at any of some places; the first of several.
    fn best_of(&self, pose: &[f64; 16], places: &[f64], centre: &[f64]) -> Option<Posture> {
        let lead = self.lead;
        let (rest, dof) = (lead.rest(), lead.rest().dof());
        let goals: Vec<[f64; 16]> = places.iter().map(|x| lead.seen(pose, *x)).collect();
        let mut near = centre.to_vec();
        near.remove(lead.variable());
        let starts = Starts::One(&near);
        let request = Request::new(rest, self.aim, Goals::Poses(&goals), starts).ok()?;
        let query = Query::new(request, ArmAngle::Free, Choice::default()).ok()?;
        let found = all(&query, 1, &mut || true).ok()?;
        let row = |b: usize| &found.q[b * dof..(b + 1) * dof];
        let place = |b: usize| places[b / found.branches];
        let apart = |(a, b): (&f64, &f64)| (a - b) * (a - b);
        let cost = |b: usize| {
            let off = place(b) - centre[lead.variable()];
            off.mul_add(off, row(b).iter().zip(&near).map(apart).sum())
        };
        let valid = (0..found.valid.len()).filter(|b| found.valid[*b]);
        let (cost, b) = valid.map(|b| (cost(b), b)).min_by(|a, b| a.0.total_cmp(&b.0))?;
        let mut q = row(b).to_vec();
        q.insert(lead.variable(), place(b));
        Some(Posture { slide: place(b), q, cost })
    }
}
