//! The two steps together: a decision for one target.

use std::time::{Duration, Instant};

use agrik::closed_form::ClosedForm;
use agrik_compute::allowed::is_measure;

use super::aim::{Aim, Approach, Target};
use super::approach::{self, Open};
use super::recovery;
use super::refine;
use super::settings::{Settings, evenly};
use super::station::Station;
use super::table::{Room, Row, STRAIGHT, Table, better, judge, postures};
use crate::Result;

/// What became of a target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Status {
    /// There is a posture.
    Ok = 0,
    /// The grip point is no place.
    BadInput = 1,
    /// The arm comes there at no approach angle and no place of the slide.
    OutOfReach = 2,
    /// It would, but for its joint limits.
    JointLimits = 3,
    /// The gripper hits something at every approach angle.
    ApproachBlocked = 4,
    /// The arm hits something, or comes too near, at all postures that were looked at.
    NoCollisionFree = 5,
    /// The time was over; a posture is the best so far.
    TimeLimit = 6,
}

impl Status {
    /// Every status, in the order of its codes.
    pub const ALL: [Self; 7] = [
        Self::Ok,
        Self::BadInput,
        Self::OutOfReach,
        Self::JointLimits,
        Self::ApproachBlocked,
        Self::NoCollisionFree,
        Self::TimeLimit,
    ];

    /// The name that users and files know it by.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ok => "OK",
            Self::BadInput => "BAD_INPUT",
            Self::OutOfReach => "OUT_OF_REACH",
            Self::JointLimits => "JOINT_LIMITS",
            Self::ApproachBlocked => "APPROACH_BLOCKED",
            Self::NoCollisionFree => "NO_COLLISION_FREE",
            Self::TimeLimit => "TIME_LIMIT",
        }
    }
}

/// Which part of the method found the posture, in the order in which they are tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Stage {
    /// The best approach angle.
    First = 0,
    /// Another approach angle.
    NextAngle = 1,
    /// A finer grid round near misses.
    FinerGrid = 2,
    /// A tilted gripper, or a shifted grip point.
    TiltShift = 3,
    /// All angles that were left.
    FullScan = 4,
}

impl Stage {
    /// Every stage, in the order of its codes.
    pub const ALL: [Self; 5] =
        [Self::First, Self::NextAngle, Self::FinerGrid, Self::TiltShift, Self::FullScan];

    /// The name that users and files know it by.
    pub const fn name(self) -> &'static str {
        match self {
            Self::First => "first",
            Self::NextAngle => "next_angle",
            Self::FinerGrid => "finer_grid",
            Self::TiltShift => "tilt_shift",
            Self::FullScan => "full_scan",
        }
    }
}

/// One approach whose table was made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attempt {
    /// Approach angle, rad.
    pub psi: f64,
    /// Tilt of the gripper up, rad.
    pub tilt: f64,
    /// Shift of the grip point up, m.
    pub shift: f64,
    /// Part of the method that made it.
    pub stage: Stage,
    /// Postures without regard to limits.
    pub reached: usize,
    /// Postures within the limits.
    pub within: usize,
    /// Admissible postures.
    pub admissible: usize,
}

/// The answer for one target.
#[derive(Debug, Clone, PartialEq)]
pub struct Decision {
    /// What became of it.
    pub status: Status,
    /// The posture, if there is one.
    pub row: Option<Row>,
    /// Its approach: tilt (rad) and shift (m).
    pub tilt: f64,
    /// See `tilt`.
    pub shift: f64,
    /// Which part of the method found it.
    pub stage: Stage,
    /// Exact distance of the posture from the crop, m; that of the row in exact mode.
    pub exact: f64,
    /// A pattern search made it better.
    pub refined: bool,
    /// Its wrist is nearly straight, which motion control dislikes.
    pub straight: bool,
    /// Approach angles looked at.
    pub angles: usize,
    /// Approach angles at which the gripper is free.
    pub open: usize,
    /// Places of the slide that were skipped, as the shoulder is singular there.
    pub singular: usize,
    /// Every approach whose table was made, in order.
    pub attempts: Vec<Attempt>,
}

impl Decision {
    fn none(status: Status) -> Self {
        Self {
            status,
            row: None,
            tilt: 0.0,
            shift: 0.0,
            stage: Stage::First,
            exact: 0.0,
            refined: false,
            straight: false,
            angles: 0,
            open: 0,
            singular: 0,
            attempts: Vec::new(),
        }
    }
}

/// A decision under way.
pub(super) struct Work<'a> {
    pub aim: Aim<'a>,
    pub settings: &'a Settings,
    pub slides: Vec<f64>,
    pub room: Room,
    pub decision: Decision,
    /// The best inadmissible rows that touch nothing, with their approach.
    pub misses: Vec<(Approach, Row)>,
    deadline: Option<Instant>,
    /// Some posture exists, whatever the limits; and one within them.
    reached: bool,
    within: bool,
}

/// Near misses that are kept.
const MISSES: usize = 3;

impl<'a> Work<'a> {
    fn new(station: &'a Station, target: &Target, settings: &'a Settings) -> Result<Self> {
        let aim = Aim::new(station, target)?;
        let slide = &station.chain().variables()[station.lead()?.variable()];
        let limit = settings.time_limit.map(Duration::from_secs_f64);
        Ok(Self {
            slides: evenly(slide.lower, slide.upper, settings.slides),
            room: Room::new(&aim),
            aim,
            settings,
            decision: Decision::none(Status::NoCollisionFree),
            misses: Vec::new(),
            deadline: limit.and_then(|limit| Instant::now().checked_add(limit)),
            reached: false,
            within: false,
        })
    }

    pub fn is_late(&self) -> bool {
        self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// Makes the table of an open approach; `None` where the arm has no posture there.
    pub fn attempt(&mut self, open: &Open, slides: &[f64], stage: Stage) -> Result<Option<Table>> {
        let approach = &open.approach;
        let mut table = postures(&self.aim, approach, slides, self.settings)?;
        self.reached |= table.reached > 0;
        self.within |= !table.rows.is_empty();
        self.decision.singular += table.singular;
        if table.rows.is_empty() {
            return Ok(None);
        }
        judge(&self.aim, &mut table.rows, open.hard, self.settings, &mut self.room);
        self.decision.attempts.push(Attempt {
            psi: approach.psi,
            tilt: approach.tilt,
            shift: approach.shift,
            stage,
            reached: table.reached,
            within: table.rows.len(),
            admissible: table.admissible(),
        });
        for row in &table.rows {
            let near = !row.admissible
                && !row.hits_itself
                && row.distance > 0.0
                && row.freedom >= self.settings.min_freedom;
            if near {
                self.misses.push((*approach, *row));
            }
        }
        // The nearest to success; of equal ones the first.
        self.misses.sort_by(|a, b| b.1.distance.total_cmp(&a.1.distance));
        self.misses.truncate(MISSES);
        Ok(Some(table))
    }

    /// Takes a row as the answer.
    pub fn take(&mut self, row: Row, approach: &Approach, stage: Stage) {
        self.decision.row = Some(row);
        (self.decision.tilt, self.decision.shift) = (approach.tilt, approach.shift);
        (self.decision.status, self.decision.stage) = (Status::Ok, stage);
    }

    /// Why there is no posture at any angle that was open: the other angles may have some.
    fn without_postures(&mut self, all: &[Approach]) -> Result<Status> {
        for approach in all {
            if self.within {
                return Ok(Status::NoCollisionFree);
            }
            let table = postures(&self.aim, approach, &self.slides, self.settings)?;
            self.reached |= table.reached > 0;
            self.within |= !table.rows.is_empty();
        }
        Ok(match (self.reached, self.within) {
            (_, true) => Status::NoCollisionFree,
            (true, false) => Status::JointLimits,
            (false, false) => Status::OutOfReach,
        })
    }

    /// Ends a decision: refines and judges its posture.
    fn finished(mut self) -> Result<Decision> {
        if let Some(row) = self.decision.row {
            let mut row = row;
            if self.settings.refine {
                let approach =
                    Approach { psi: row.psi, tilt: self.decision.tilt, shift: self.decision.shift };
                let found = refine::refined(&mut self, &approach, row)?;
                self.decision.refined = found != row;
                row = found;
            }
            self.decision.row = Some(row);
            self.decision.exact = self.exact(&row);
            self.decision.straight = wrist_sine(self.aim.station, &row)? < STRAIGHT;
        }
        Ok(self.decision)
    }

    /// Distance of all bodies from the crop as they are, m.
    fn exact(&mut self, row: &Row) -> f64 {
        let (station, placed) = (self.aim.station, &mut self.room.placed);
        station.around.bodies.place_unchecked(&row.q, placed);
        let around = &station.around;
        (0..around.bodies.len()).filter(|body| around.bodies.moved_by(*body) > 0).fold(
            f64::INFINITY,
            |least, body| {
                let exempt = self.aim.exempt(body);
                around.scene.distance(&placed.solids()[body], exempt, least)
            },
        )
    }
}

/// Sine of the angle between the first and the last axis of the wrist.
fn wrist_sine(station: &Station, row: &Row) -> Result<f64> {
    let rest = station.lead()?.rest();
    let Ok(form) = ClosedForm::of(rest) else { return Ok(1.0) };
    let (offset, links) = (form.geometry().offset(4), &station.chain().compiled().links);
    let middle = links[links.len() - 2].variable;
    Ok((row.q[middle] + offset).sin().abs())
}

/// Decides whether a target can be picked, and in which posture.
///
/// # Errors
///
/// An object of the target is none of the scene's. Settings are taken to have been checked.
pub fn decide(station: &Station, target: &Target, settings: &Settings) -> Result<Decision> {
    if !target.point.iter().all(|x| is_measure(*x)) {
        return Ok(Decision::none(Status::BadInput));
    }
    let mut work = Work::new(station, target, settings)?;
    let all: Vec<Approach> = settings.psis().into_iter().map(Approach::level).collect();
    let mut left = approach::open(&work.aim, &all);
    (work.decision.angles, work.decision.open) = (all.len(), left.len());
    let blocked = left.is_empty();
    let slides = work.slides.clone();
    let mut tried: Vec<f64> = Vec::new();
    while let Some(open) = recovery::next_angle(&mut left, &tried, settings.spread) {
        if work.is_late() {
            work.decision.status = Status::TimeLimit;
            return work.finished();
        }
        let stage = if tried.is_empty() { Stage::First } else { Stage::NextAngle };
        let Some(table) = work.attempt(&open, &slides, stage)? else { continue };
        tried.push(open.approach.psi);
        if let Some(best) = table.best() {
            work.take(*best, &open.approach, stage);
            return work.finished();
        }
        if !settings.recovery || tried.len() >= settings.most_angles {
            break;
        }
    }
    if settings.recovery {
        recovery::go_on(&mut work, left)?;
    }
    if work.decision.row.is_none() && work.decision.status != Status::TimeLimit {
        work.decision.status = if blocked {
            Status::ApproachBlocked
        } else if tried.is_empty() {
            work.without_postures(&all)?
        } else {
            Status::NoCollisionFree
        };
    }
    work.finished()
}

/// The best posture of all approach angles, places of the slide and branches: what [`decide`]
/// is measured by. An approach that is blocked counts as no free posture.
///
/// # Errors
///
/// As [`decide`].
pub fn full(station: &Station, target: &Target, settings: &Settings) -> Result<Decision> {
    if !target.point.iter().all(|x| is_measure(*x)) {
        return Ok(Decision::none(Status::BadInput));
    }
    let mut work = Work::new(station, target, settings)?;
    let all: Vec<Approach> = settings.psis().into_iter().map(Approach::level).collect();
    let left = approach::open(&work.aim, &all);
    (work.decision.angles, work.decision.open) = (all.len(), left.len());
    recovery::scan_all(&mut work, &left)?;
    if work.decision.row.is_none() && work.decision.status != Status::TimeLimit {
        work.decision.status = work.without_postures(&all)?;
    }
    work.finished()
}

/// The better of two rows with their approaches.
pub(super) fn best_of(
    best: Option<(Approach, Row)>,
    approach: Approach,
    row: &Row,
) -> Option<(Approach, Row)> {
    match best {
        Some(best) if !better(row, &best.1) => Some(best),
        _ => Some((approach, *row)),
    }
}
