//! A plan from beginning to end.

use super::ask::{Ask, Settings};
use super::cheap::{direct, with_line};
use super::connect::connect;
use super::cut::{Cut, cut};
use super::goals::thinned;
use super::line::{Line, backwards};
use super::shorten::shorten;
use super::words::{How, PathStatus};
use crate::body::check_postures;
use crate::edges::{Certifier, Keep};
use crate::{Collider, Contact, Error, Result};

/// Joint values may be outside their limits by this, rad and m: files round them.
const SLACK: f64 = 1e-9;

/// The answer to a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Planned {
    /// What became of it.
    pub status: PathStatus,
    /// How the path goes, or was found.
    pub how: How,
    /// Which goal it ends at.
    pub goal: Option<usize>,
    /// Its waypoints, one after the other; none where there is no path.
    pub path: Vec<f64>,
    /// Distance that is kept on each piece, m, no more than was asked to be told: of a path of
    /// one waypoint that of the posture.
    pub clearance: Vec<f64>,
    /// Questions asked; see [`Keep::max_checks`].
    pub checks: u64,
    /// Rounds of the trees.
    pub rounds: u32,
    /// How near the trees came, m of the metric, where they did not meet; else 0.
    pub nearest: f64,
    /// What the start is too near to, where it is.
    pub contact: Option<Contact>,
    /// The proof that there is no path.
    pub proof: Option<Cut>,
}

impl Planned {
    /// A plan that came to nothing.
    pub fn none(status: PathStatus) -> Self {
        Self {
            status,
            how: How::None,
            goal: None,
            path: Vec::new(),
            clearance: Vec::new(),
            checks: 0,
            rounds: 0,
            nearest: 0.0,
            contact: None,
            proof: None,
        }
    }
}

/// A path from `start` to one of the rows of `goals`, the best first; all finite joint values,
/// rad and m. Answers do not depend on anything but the arguments, unless there is a time limit.
///
/// # Errors
///
/// `start` is not one row, `goals` no whole number of rows, a number is not finite, or a
/// setting is out of its range.
pub fn plan(
    collider: &Collider,
    start: &[f64],
    goals: &[f64],
    settings: &Settings,
) -> Result<Planned> {
    let chain = collider.bodies().chain();
    let dof = chain.dof();
    if start.len() != dof {
        return Err(Error::argument("start", format!("{dof} joint values"), start.len()));
    }
    check_postures(chain, start)?;
    check_postures(chain, goals)?;
    let mut ask = Ask::new(collider, *settings)?;
    let mut out = planned(&mut ask, start, goals);
    out.checks = ask.checks;
    Ok(out)
}

/// Joint values lie within the limits.
fn within(collider: &Collider, q: &[f64]) -> bool {
    let inside =
        |(v, x): (&agrik::chain::Variable, &f64)| (v.lower - SLACK..=v.upper + SLACK).contains(x);
    collider.bodies().chain().variables().iter().zip(q).all(inside)
}

fn planned(ask: &mut Ask<'_>, start: &[f64], goals: &[f64]) -> Planned {
    let collider = ask.collider();
    if !within(collider, start) {
        return Planned::none(PathStatus::StartOutOfLimits);
    }
    let at_start = ask.certifier().explained(start, start);
    ask.checks += u64::from(at_start.checks);
    if !at_start.is_safe() {
        let contact = at_start.contact;
        return Planned { contact, ..Planned::none(PathStatus::StartInCollision) };
    }
    let rows: Vec<&[f64]> = goals.chunks(start.len()).collect();
    if rows.is_empty() {
        return Planned::none(PathStatus::NoGoal);
    }
    let inside: Vec<usize> = (0..rows.len()).filter(|k| within(collider, rows[*k])).collect();
    if inside.is_empty() {
        return Planned::none(PathStatus::JointLimits);
    }
    let free: Vec<usize> = inside.into_iter().filter(|k| ask.free(rows[*k], rows[*k])).collect();
    if free.is_empty() {
        return Planned::none(PathStatus::NoCollisionFree);
    }
    let postures: Vec<&[f64]> = free.iter().map(|k| rows[*k]).collect();
    let taken = thinned(&postures, &ask.metric, ask.settings.goals);
    let mut chosen: Vec<usize> = taken.into_iter().map(|k| free[k]).collect();
    // Where it is narrow at the end, the way there is likely to be too.
    let keep = ask.settings.keep;
    let wide = Keep { clear: 2.0 * keep.clear, cap: 2.0 * keep.clear, ..keep };
    let mut wide = Certifier::new(collider, wide);
    chosen.sort_by_key(|k| !wide.segment(rows[*k], rows[*k]).is_safe());
    let mut found = Found { rows: &rows, chosen: &chosen, start };
    let (way, rounds, nearest) = found.look(ask);
    match way {
        Some(way) => found.finished(ask, way, rounds),
        None => {
            let mut out = Planned { rounds, nearest, ..Planned::none(PathStatus::NoPathFound) };
            if ask.is_late() {
                out.status = PathStatus::TimeLimit;
            } else if ask.settings.prove {
                // All goals that are free count, not only those that were tried.
                out.proof = cut(collider, start, &postures);
                if out.proof.is_some() {
                    out.status = PathStatus::PathImpossible;
                }
            }
            out
        }
    }
}

/// A way that is free: its waypoints, its goal, how it goes, and how many pieces at its end are
/// a line of the tool.
struct Way {
    path: Vec<Vec<f64>>,
    goal: usize,
    how: How,
    line: usize,
}

struct Found<'a> {
    rows: &'a [&'a [f64]],
    chosen: &'a [usize],
    start: &'a [f64],
}

impl Found<'_> {
    /// Looks for a way in all manners, those that cost least first; with the rounds of the
    /// trees, and how near they came.
    fn look(&mut self, ask: &mut Ask<'_>) -> (Option<Way>, u32, f64) {
        let start = self.start;
        for goal in self.chosen {
            if let Some((how, between)) = direct(ask, start, self.rows[*goal]) {
                let mut path = vec![start.to_vec()];
                path.extend(between);
                path.push(self.rows[*goal].to_vec());
                return (Some(Way { path, goal: *goal, how, line: 0 }), 0, 0.0);
            }
            if ask.is_spent() {
                return (None, 0, 0.0);
            }
        }
        // Where trees may end: a goal, or a stop of a line out of it.
        let mut roots: Vec<(usize, Vec<Vec<f64>>)> = Vec::new();
        for goal in self.chosen {
            let line = if ask.settings.retreats {
                backwards(ask, self.rows[*goal])
            } else {
                Line::default()
            };
            for stop in line.stops.iter().rev() {
                let back: Vec<Vec<f64>> = line.q[..=*stop].iter().rev().cloned().collect();
                if let Some((how, between)) = direct(ask, start, &back[0]) {
                    let mut path = vec![start.to_vec()];
                    path.extend(between);
                    path.extend(back);
                    let way = Way { path, goal: *goal, how: with_line(how), line: *stop };
                    return (Some(way), 0, 0.0);
                }
                roots.push((*goal, back));
            }
            if ask.is_spent() {
                return (None, 0, 0.0);
            }
        }
        roots.extend(self.chosen.iter().map(|goal| (*goal, vec![self.rows[*goal].to_vec()])));
        let ends: Vec<&[f64]> = roots.iter().map(|(_, back)| &back[0][..]).collect();
        let grown = connect(ask, start, &ends);
        let way = grown.way.map(|(mut path, root)| {
            let (goal, back) = &roots[root];
            path.extend(back[1..].iter().cloned());
            let line = back.len() - 1;
            let how = How::RrtConnect;
            let how = if line > 0 { with_line(how) } else { how };
            Way { path, goal: *goal, how, line }
        });
        (way, grown.rounds, grown.nearest)
    }

    /// Makes a way shorter, goes to a better goal where one is near, and tells what it keeps.
    fn finished(&self, ask: &mut Ask<'_>, way: Way, rounds: u32) -> Planned {
        let Way { mut path, mut goal, how, line } = way;
        path.dedup();
        // Ways that slides make have their corners for a reason.
        if matches!(how, How::RrtConnect | How::RetreatRrtConnect) && line + 2 < path.len() {
            shorten(ask, &mut path, line);
        }
        if matches!(how, How::RrtConnect | How::RetreatRrtConnect) {
            let place = self.chosen.iter().position(|k| *k == goal).unwrap_or(0);
            for better in &self.chosen[..place] {
                let before = path.len().saturating_sub(2);
                if ask.free(&path[before], self.rows[*better]) {
                    path.truncate(before + 1);
                    path.push(self.rows[*better].to_vec());
                    goal = *better;
                    break;
                }
            }
        }
        let keep = ask.settings.keep;
        let mut telling = Certifier::new(ask.collider(), keep);
        let mut told = |ask: &mut Ask<'_>, a: &[f64], b: &[f64]| {
            let found = telling.segment(a, b);
            ask.checks += u64::from(found.checks);
            // Proven before; a share that is left over may take more questions than allowed.
            if found.is_safe() { found.clearance } else { keep.clear.min(keep.own) }
        };
        let clearance = if path.len() == 1 {
            vec![told(ask, &path[0], &path[0])]
        } else {
            path.windows(2).map(|pair| told(ask, &pair[0], &pair[1])).collect()
        };
        Planned {
            how,
            goal: Some(goal),
            path: path.concat(),
            clearance,
            rounds,
            ..Planned::none(PathStatus::Ok)
        }
    }
}
