//! The two scans of the method by themselves, for tables and pictures.

use super::aim::{Aim, Approach, Target, last_frame};
use super::approach::{self, hard_distance};
use super::settings::{Settings, evenly};
use super::station::Station;
use super::table::{Room, Table, judge, postures};
use crate::{Error, Result};

/// One approach angle of the first scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scanned {
    /// The angle, rad.
    pub psi: f64,
    /// Its place in the order of trying, from 0; none for an angle that is not open.
    pub rank: Option<usize>,
    /// Distance of the last link's bodies from the crop, m; 0 where they touch something.
    pub hard: f64,
    /// The same of the wrist's other bodies, the wrist straight.
    pub soft: f64,
}

/// The scan of approach angles, in the order of the angles.
///
/// # Errors
///
/// A setting is out of its range, or an object of the target is none of the scene's.
pub fn approaches(station: &Station, target: &Target, settings: &Settings) -> Result<Vec<Scanned>> {
    settings.check()?;
    let aim = Aim::new(station, target)?;
    let all: Vec<Approach> = settings.psis().into_iter().map(Approach::level).collect();
    let ranked = approach::open(&aim, &all);
    let tail = &station.chain().compiled().tail;
    Ok(all
        .iter()
        .map(|approach| {
            let rank = ranked.iter().position(|open| open.approach == *approach);
            let last = last_frame(&approach.pose(aim.point), tail);
            let soft = station.soft(&last).fold(f64::INFINITY, |least, (body, solid)| {
                station.around.distance(body, &solid, aim.exempt(body), least)
            });
            Scanned {
                psi: approach.psi,
                rank,
                hard: hard_distance(&aim, &last, 0.0).unwrap_or(0.0),
                soft: soft.max(0.0),
            }
        })
        .collect())
}

/// The table of one approach: angle (rad), tilt (rad) and shift (m).
///
/// # Errors
///
/// As [`approaches`]; a number of the approach is not finite.
pub fn table(
    station: &Station,
    target: &Target,
    [psi, tilt, shift]: [f64; 3],
    settings: &Settings,
) -> Result<Table> {
    settings.check()?;
    if ![psi, tilt, shift].iter().all(|x| x.is_finite()) {
        let received = format!("{psi}, {tilt}, {shift}");
        return Err(Error::argument("approach", "finite numbers", received));
    }
    let aim = Aim::new(station, target)?;
    let approach = Approach { psi, tilt, shift };
    let last = last_frame(&approach.pose(aim.point), &station.chain().compiled().tail);
    let hard = hard_distance(&aim, &last, 0.0).unwrap_or(0.0);
    let slide = &station.chain().variables()[station.lead()?.variable()];
    let slides = evenly(slide.lower, slide.upper, settings.slides);
    let mut table = postures(&aim, &approach, &slides, settings)?;
    judge(&aim, &mut table.rows, hard, settings, &mut Room::new(&aim));
    Ok(table)
}
