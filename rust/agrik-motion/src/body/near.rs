//! Everything near an arm, with how its distances change: what probabilities are made of.

use agrik_compute::Allowed;
use agrik_solids::{Point, Pose, Solid, closest, distance_within};

use super::bodies::check_postures;
use super::collider::{Collider, Contact, Other};
use super::placed::Placed;
use crate::{Error, Result};

/// Which things are near: of rows of joint values, one after the other.
#[derive(Debug, Clone, Copy)]
pub struct Near<'a> {
    /// Joint values, rad and m.
    pub q: &'a [f64],
    /// How far around the joint values postures are meant, one number a joint value.
    pub reach: &'a [f64],
    /// How near objects have to be to each body, one number a body of a row, m.
    pub within: &'a [f64],
    /// How near bodies of a pair have to be to each other, one number a row, m.
    pub own: &'a [f64],
}

/// A body, and something near it.
#[derive(Debug, Clone, PartialEq)]
pub struct Nearby {
    /// Which row.
    pub row: usize,
    /// The two.
    pub contact: Contact,
    /// The most that they come nearer to each other within the reach, m.
    pub motion: f64,
    /// How their distance changes with each joint value, m/rad or no unit.
    pub rates: Vec<f64>,
}

type Poll<'p> = &'p mut dyn FnMut() -> bool;

impl Collider {
    /// Every object and every pair of bodies that is near at some postures: row after row,
    /// bodies in their order with the nearest object first, then pairs. On `threads` threads
    /// (0: the number in force); answers do not depend on it.
    ///
    /// # Errors
    ///
    /// Numbers that are no rows of joint values, or not finite; lengths that do not match;
    /// `poll` said no.
    pub fn near(&self, ask: &Near<'_>, threads: usize, poll: Poll<'_>) -> Result<Vec<Nearby>> {
        let (dof, count) = (self.bodies().chain().dof(), self.bodies().len());
        let rows = ask.q.len() / dof;
        let sizes = [
            ("reach", ask.reach.len(), rows * dof),
            ("within", ask.within.len(), rows * count),
            ("own", ask.own.len(), rows),
        ];
        for (name, got, wanted) in sizes {
            if got != wanted {
                return Err(Error::argument(name, format!("{wanted} numbers"), got));
            }
        }
        for x in ask.reach {
            Allowed::NOT_NEGATIVE.check("reach", *x)?;
        }
        for (name, limits) in [("within", ask.within), ("own", ask.own)] {
            if limits.iter().any(|x| x.is_nan()) {
                return Err(Error::argument(name, "numbers", f64::NAN));
            }
        }
        let mut out: Vec<(usize, Vec<Nearby>)> = (0..rows).map(|row| (row, Vec::new())).collect();
        self.each(ask.q, 1, &mut out, threads, poll, |placed, out| {
            let (row, found) = &mut out[0];
            self.near_row(ask, *row, placed, found);
        })?;
        Ok(out.into_iter().flat_map(|(_, found)| found).collect())
    }

    fn near_row(&self, ask: &Near<'_>, row: usize, placed: &Placed, found: &mut Vec<Nearby>) {
        let bodies = self.bodies();
        let (dof, count) = (bodies.chain().dof(), bodies.len());
        let reach = &ask.reach[row * dof..][..dof];
        let levers = bodies.local_levers(placed, reach);
        for (body, cap) in ask.within[row * count..][..count].iter().enumerate() {
            for near in self.objects_within(placed, body, *cap) {
                let contact = Contact {
                    distance: near.distance,
                    body,
                    other: Other::Object(near.object),
                    on_body: near.on_solid,
                    on_other: near.on_object,
                    normal: near.normal,
                };
                let motion = bodies.motion_bound(&levers, body, reach);
                let rates = self.gradient(placed, &contact);
                found.push(Nearby { row, contact, motion, rates });
            }
        }
        let cap = ask.own[row];
        let solids = placed.solids();
        for &(i, j) in bodies.self_pairs() {
            // What is farther is told as the cap, or a little more.
            if distance_within(&solids[i], &solids[j], cap) >= cap {
                continue;
            }
            let near = closest(&solids[j], &solids[i]);
            let contact = Contact {
                distance: near.distance,
                body: i,
                other: Other::Body(j),
                on_body: near.on_b,
                on_other: near.on_a,
                normal: near.normal,
            };
            let motion = bodies.pair_bound(&levers, (i, j), reach);
            let rates = self.gradient(placed, &contact);
            found.push(Nearby { row, contact, motion, rates });
        }
    }

    /// Distances of the nearest pair of bodies, m, with each body of each row of `q` shifted
    /// by a vector of its own: see [`Collider::shifted_clearances`]. Infinite without pairs.
    ///
    /// # Errors
    ///
    /// As [`Collider::shifted_clearances`].
    pub fn shifted_own_clearances(
        &self,
        q: &[f64],
        shifts: &[Point],
        threads: usize,
        poll: Poll<'_>,
    ) -> Result<Vec<f64>> {
        let (dof, count) = (self.bodies().chain().dof(), self.bodies().len());
        check_postures(self.bodies().chain(), q)?;
        let rows = q.len() / dof;
        if shifts.len() != rows * count {
            let expected = format!("{} vectors, one a body of a posture", rows * count);
            return Err(Error::argument("shifts", expected, shifts.len()));
        }
        for x in shifts.iter().flatten() {
            Allowed::FINITE.check("shifts", *x)?;
        }
        let mut out: Vec<(usize, f64)> = (0..rows).map(|row| (row, f64::INFINITY)).collect();
        self.each(q, 1, &mut out, threads, poll, |placed, out| {
            let (row, least) = &mut out[0];
            let shifts = &shifts[*row * count..][..count];
            let at = |body: usize| -> Solid {
                let pose = Pose { translation: shifts[body], ..Pose::IDENTITY };
                placed.solids()[body].placed(&pose)
            };
            let moved: Vec<Solid> = (0..count).map(at).collect();
            for &(i, j) in self.bodies().self_pairs() {
                *least = distance_within(&moved[i], &moved[j], *least).min(*least);
            }
        })?;
        Ok(out.into_iter().map(|(_, least)| least).collect())
    }
}
