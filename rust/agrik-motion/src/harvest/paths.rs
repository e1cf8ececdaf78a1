//! The posture and the way into it, decided together.

use std::sync::Arc;

use agrik_compute::Allowed;
use agrik_compute::threads::share;

use super::aim::{Aim, Approach, Target};
use super::approach::open;
use super::decide::{Decision, Status, decide};
use super::openings::openings;
use super::scan::table;
use super::settings::Settings;
use super::station::Station;
use super::table::{Row, order};
use crate::planners::{self, Ends, PathBlockers, PathStatus, Planned};
use crate::{Collider, Error, Result, Touch};

/// Rounds of the trees with the goals of the first approach, before those of all others are
/// goals too.
const FIRST_ROUNDS: u32 = 40;

/// How paths to targets are looked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Picking {
    /// Where the arm starts, rad and m.
    pub start: Vec<f64>,
    /// What paths keep, and how they are looked for; the seed of a target is this one and its
    /// number.
    pub plan: planners::Settings,
    /// How near to the grip point the tool has to be for the target to be touched, m.
    pub touch_radius: f64,
    /// Name what stands in the way where there is a posture and no path.
    pub blockers: bool,
}

/// What became of a target: the posture, and the way into it.
#[derive(Debug, Clone, PartialEq)]
pub struct Picked {
    /// The decision for a posture.
    pub decision: Decision,
    /// The path; a posture that its goal is not is worse by the stated criteria, or no way was
    /// found to the best.
    pub path: Planned,
    /// All postures that were goals, one after the other.
    pub goals: Vec<f64>,
    /// What stands in the way.
    pub blockers: Option<PathBlockers>,
}

/// Decides for targets and plans the ways into their postures, on `threads` threads (0: the
/// number in force), one target on one thread; `poll` is asked now and then whether to go on.
/// Answers do not depend on the number of threads.
///
/// # Errors
///
/// A setting is out of its range, the start has another length or a number that is not finite,
/// a target names no object, or `poll` said no.
pub fn plan_paths(
    station: &Station,
    targets: &[Target],
    settings: &Settings,
    picking: &Picking,
    threads: usize,
    poll: &mut dyn FnMut() -> bool,
) -> Result<Vec<Picked>> {
    settings.check()?;
    picking.plan.check()?;
    Allowed::NOT_NEGATIVE.of("m").check("touch_radius", picking.touch_radius)?;
    let dof = station.chain().dof();
    if picking.start.len() != dof {
        return Err(Error::argument("start", format!("{dof} joint values"), picking.start.len()));
    }
    let mut out: Vec<Option<Result<Picked>>> = targets.iter().map(|_| None).collect();
    let work = |((number, target), to): ((usize, &Target), &mut Option<Result<Picked>>)| {
        let seed = picking.plan.seed.wrapping_add(number as u64);
        let plan = planners::Settings { seed, ..picking.plan };
        *to = Some(one(station, target, settings, picking, &plan));
    };
    if !share(targets.iter().enumerate().zip(&mut out).collect(), threads, &work, poll) {
        return Err(Error::Interrupted);
    }
    out.into_iter().map(|one| one.unwrap_or(Err(Error::Interrupted))).collect()
}

fn one(
    station: &Station,
    target: &Target,
    settings: &Settings,
    picking: &Picking,
    plan: &planners::Settings,
) -> Result<Picked> {
    let decision = decide(station, target, settings)?;
    let start = &picking.start[..];
    let Some(best) = decision.row else {
        let path = match decision.status {
            Status::BadInput => Planned::none(PathStatus::BadInput),
            // What is wrong with the start comes before what is wrong with the target.
            _ => {
                let around = Around::new(station, target, picking);
                let at_start = planners::plan(&around.collider()?, start, &[], plan)?;
                match at_start.status {
                    PathStatus::NoGoal => Planned { status: of(decision.status), ..at_start },
                    _ => at_start,
                }
            }
        };
        return Ok(Picked { decision, path, goals: Vec::new(), blockers: None });
    };
    let around = Around::new(station, target, picking);
    let collider = around.collider()?;
    let first = Approach { psi: best.psi, tilt: decision.tilt, shift: decision.shift };
    let mut rows = admissible(station, target, &first, settings)?;
    rows.retain(|row| row.q != best.q);
    rows.insert(0, best);
    let rounds = plan.rounds.min(FIRST_ROUNDS);
    let quick = planners::Settings { rounds, prove: false, ..*plan };
    let flat = |rows: &[Row]| -> Vec<f64> { rows.iter().flat_map(|row| row.q).collect() };
    let mut goals = flat(&rows);
    let mut path = planners::plan(&collider, start, &goals, &quick)?;
    let may_go_on = matches!(path.status, PathStatus::NoPathFound | PathStatus::NoCollisionFree);
    if may_go_on {
        let aim = Aim::new(station, target)?;
        let level: Vec<Approach> = settings.psis().into_iter().map(Approach::level).collect();
        let mut more = Vec::new();
        for other in open(&aim, &level) {
            if other.approach != first {
                more.extend(admissible(station, target, &other.approach, settings)?);
            }
        }
        more.sort_by(order);
        rows.extend(more);
        goals = flat(&rows);
        let before = path.checks;
        let wide = planners::Settings { goals: 2 * plan.goals, ..*plan };
        path = planners::plan(&collider, start, &goals, &wide)?;
        path.checks += before;
    }
    let no_way = matches!(path.status, PathStatus::NoPathFound | PathStatus::PathImpossible);
    let mut blockers = None;
    if no_way && picking.blockers {
        let level = settings.psis().into_iter().map(Approach::level);
        // A first approach that is tilted or shifted is none of the level ones.
        let others = std::iter::once(first).filter(|one| *one != Approach::level(one.psi));
        let approaches: Vec<Approach> = others.chain(level).collect();
        let open = openings(station, target, &approaches, settings)?;
        let ends = flat(&open.rows);
        let to = Ends { goals: &ends, needs: &open.needs };
        let without = |gone: &[usize]| collider.without(gone);
        let known = path.status;
        blockers = planners::blockers(without, start, to, &around.removable(), known, plan)?;
        // A way was met with that nothing stands in.
        if let Some(found) = blockers.take_if(|found| found.objects.is_empty()) {
            let before = path.checks;
            path = found.path;
            path.checks += before;
            if let Some(goal) = path.goal {
                let q = &ends[goal * start.len()..][..start.len()];
                path.goal = Some(goals.len() / start.len());
                goals.extend_from_slice(q);
            }
        }
    }
    Ok(Picked { decision, path, goals, blockers })
}

/// The path's status where there is no posture.
const fn of(status: Status) -> PathStatus {
    match status {
        Status::Ok => PathStatus::Ok,
        Status::BadInput => PathStatus::BadInput,
        Status::OutOfReach => PathStatus::OutOfReach,
        Status::JointLimits => PathStatus::JointLimits,
        Status::ApproachBlocked => PathStatus::ApproachBlocked,
        Status::NoCollisionFree => PathStatus::NoCollisionFree,
        Status::TimeLimit => PathStatus::TimeLimit,
    }
}

/// Admissible postures of an approach, the best first.
fn admissible(
    station: &Station,
    target: &Target,
    approach: &Approach,
    settings: &Settings,
) -> Result<Vec<Row>> {
    let at = [approach.psi, approach.tilt, approach.shift];
    let mut rows = table(station, target, at, settings)?.rows;
    rows.retain(|row| row.admissible);
    rows.sort_by(order);
    Ok(rows)
}

/// A target in its crop, as paths see it.
struct Around<'a> {
    station: &'a Station,
    skip: Vec<(usize, usize)>,
    touch: Touch,
}

impl<'a> Around<'a> {
    fn new(station: &'a Station, target: &Target, picking: &Picking) -> Self {
        let around = &station.around;
        let touching = (0..around.bodies.len()).filter(|body| around.touching[*body]);
        let pairs = touching
            .flat_map(|body| target.objects.iter().map(move |object| (body, *object)))
            .collect();
        let touch = Touch { pairs, target: target.point, radius: picking.touch_radius };
        Self { station, skip: around.skip.clone(), touch }
    }

    fn collider(&self) -> Result<Collider> {
        let around = &self.station.around;
        let (bodies, scene) = (Arc::clone(&around.bodies), Arc::clone(&around.scene));
        Collider::new(bodies, scene, &self.skip, Some(&self.touch))
    }

    fn removable(&self) -> Vec<usize> {
        let objects = self.station.around.scene.objects();
        (0..objects.len()).filter(|k| objects[*k].removable).collect()
    }
}
