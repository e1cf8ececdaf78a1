//! Questions about many postures at once.

use agrik::kinematics::{FRAME, moving_frames};
use agrik_compute::Allowed;
use agrik_compute::lanes::WIDEST;
use agrik_compute::threads::share;
use agrik_solids::Point;

use super::bodies::check_postures;
use super::collider::{Collider, Contact, Other};
use super::placed::Placed;
use crate::{Error, Result};

/// Postures that a thread takes at a time.
const RUN: usize = 256;
/// Postures whose frames are worked out together: they stay in the nearest cache.
const TOGETHER: usize = 32;

/// Body by body what is nearest, posture after posture.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Distances {
    /// Of each posture one entry a body.
    pub bodies: Vec<BodyDistance>,
    /// Of each posture the nearest pair of bodies.
    pub own: Vec<OwnDistance>,
}

/// What is nearest to a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyDistance {
    /// Distance, m; infinite where nothing is within the cap, or the body minds nothing.
    pub distance: f64,
    /// Index of the object, if there is one.
    pub object: Option<usize>,
    /// The body's point and the object's, m; zeros where there is none.
    pub points: [Point; 2],
}

/// What two bodies of a pair are nearest to each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OwnDistance {
    /// Distance, m; infinite where no pair is within the cap.
    pub distance: f64,
    /// The pair, if there is one.
    pub pair: Option<(usize, usize)>,
    /// Their points, m; zeros where there is none.
    pub points: [Point; 2],
}

impl BodyDistance {
    const NONE: Self = Self { distance: f64::INFINITY, object: None, points: [[0.0; 3]; 2] };
}

impl OwnDistance {
    const NONE: Self = Self { distance: f64::INFINITY, pair: None, points: [[0.0; 3]; 2] };
}

/// What may go wrong in a call besides its arguments.
type Poll<'p> = &'p mut dyn FnMut() -> bool;

impl Collider {
    /// Which postures hit: [`Collider::hits`] for each row of `q` (as many numbers as joint
    /// values, rad and m), on `threads` threads (0: the number in force). `poll` is asked now
    /// and then whether to go on. Answers do not depend on the number of threads.
    ///
    /// # Errors
    ///
    /// `q` is no whole number of rows or holds a number that is not finite, `clear` is no
    /// finite number of 0 or more, or `poll` said no.
    pub fn collides(&self, q: &[f64], clear: f64, threads: usize, poll: Poll) -> Result<Vec<bool>> {
        Allowed::NOT_NEGATIVE.check("clear", clear)?;
        let dof = self.dof();
        check_postures(self.bodies().chain(), q)?;
        let mut out = vec![false; q.len() / dof];
        // All questions at once, so that the first of them knows whether a field is worth it.
        self.scene().view(out.len().div_ceil(WIDEST));
        let work = |(q, out): (&[f64], &mut [bool])| {
            let mut room = self.sifted();
            for (q, out) in q.chunks(dof * WIDEST).zip(out.chunks_mut(WIDEST)) {
                let hits = self.hits_together(q, clear, 0, &mut room);
                for (row, to) in out.iter_mut().enumerate() {
                    *to = hits >> row & 1 != 0;
                }
            }
        };
        let runs = q.chunks(dof * RUN).zip(out.chunks_mut(RUN)).collect();
        if share(runs, threads, &work, poll) { Ok(out) } else { Err(Error::Interrupted) }
    }

    /// Distances of postures from the nearest collision, m, no more than `cap` (no number is
    /// none): [`Collider::clearance`] for each row of `q`.
    ///
    /// # Errors
    ///
    /// As [`Collider::collides`]; `cap` is NaN.
    pub fn clearances(
        &self,
        q: &[f64],
        cap: f64,
        own: bool,
        threads: usize,
        poll: Poll,
    ) -> Result<Vec<f64>> {
        check_cap(cap)?;
        let mut out = vec![0.0; q.len() / self.dof()];
        self.each(q, 1, &mut out, threads, poll, |placed, out| {
            out[0] = self.clearance(placed, cap, own);
        })?;
        Ok(out)
    }

    /// What is nearest to each body, and the nearest pair of bodies, of each row of `q`.
    ///
    /// # Errors
    ///
    /// As [`Collider::clearances`].
    pub fn distances(&self, q: &[f64], cap: f64, threads: usize, poll: Poll) -> Result<Distances> {
        check_cap(cap)?;
        let (rows, count) = (q.len() / self.dof(), self.bodies().len());
        // The pair stands behind the bodies, so that threads fill one array.
        let empty = (BodyDistance::NONE, OwnDistance::NONE);
        let mut out = vec![empty; rows * (count + 1)];
        self.each(q, count + 1, &mut out, threads, poll, |placed, out| {
            for (body, (to, _)) in out[..count].iter_mut().enumerate() {
                if let Some(found) = self.nearest(placed, body, cap) {
                    *to = BodyDistance {
                        distance: found.distance,
                        object: Some(found.object),
                        points: [found.on_solid, found.on_object],
                    };
                }
            }
            if let Some(found) = self.nearest_pair(placed, cap)
                && let Other::Body(other) = found.other
            {
                out[count].1 = OwnDistance {
                    distance: found.distance,
                    pair: Some((found.body, other)),
                    points: [found.on_body, found.on_other],
                };
            }
        })?;
        let rows = out.chunks(count + 1);
        Ok(Distances {
            own: rows.clone().map(|row| row[count].1).collect(),
            bodies: rows.flat_map(|row| row[..count].iter().map(|one| one.0)).collect(),
        })
    }

    /// Distances of postures from the nearest collision, and how they change with each joint
    /// value, m/rad or no unit: for each row of `q` as many numbers as joint values. Zeros
    /// where nothing is within `cap`, and where cores meet.
    ///
    /// # Errors
    ///
    /// As [`Collider::clearances`].
    pub fn gradients(
        &self,
        q: &[f64],
        cap: f64,
        own: bool,
        threads: usize,
        poll: Poll,
    ) -> Result<(Vec<f64>, Vec<f64>)> {
        check_cap(cap)?;
        let dof = self.dof();
        let rows = q.len() / dof;
        // The distance stands before its derivatives.
        let mut out = vec![0.0; rows * (dof + 1)];
        self.each(q, dof + 1, &mut out, threads, poll, |placed, out| {
            out[0] = cap;
            if let Some(found) = self.nearest_of_all(placed, cap, own) {
                out[0] = found.distance;
                out[1..].copy_from_slice(&self.gradient(placed, &found));
            }
        })?;
        let rows = out.chunks(dof + 1);
        let distances = rows.clone().map(|row| row[0]).collect();
        Ok((distances, rows.flat_map(|row| row[1..].iter().copied()).collect()))
    }

    /// What is nearest to a collision in each row of `q`, bodies of pairs too: nothing where
    /// there is neither an object nor a pair.
    ///
    /// # Errors
    ///
    /// As [`Collider::collides`].
    pub fn nearest_of_each(
        &self,
        q: &[f64],
        threads: usize,
        poll: Poll,
    ) -> Result<Vec<Option<Contact>>> {
        let mut out = vec![None; q.len() / self.dof()];
        self.each(q, 1, &mut out, threads, poll, |placed, out| {
            out[0] = self.nearest_of_all(placed, f64::INFINITY, true);
        })?;
        Ok(out)
    }

    /// Distances of bodies from the scene, m, that are not quite where the joints put them: each
    /// body of each row of `q` shifted by a vector of its own. What bodies touch near the target
    /// goes by where the joints put the tool.
    ///
    /// # Errors
    ///
    /// As [`Collider::collides`]; not one vector of finite numbers a body of a row.
    pub fn shifted_clearances(
        &self,
        q: &[f64],
        shifts: &[Point],
        threads: usize,
        poll: Poll,
    ) -> Result<Vec<f64>> {
        let (dof, count) = (self.dof(), self.bodies().len());
        check_postures(self.bodies().chain(), q)?;
        let rows = q.len() / dof;
        if shifts.len() != rows * count {
            let expected = format!("{} vectors, one a body of a posture", rows * count);
            return Err(Error::argument("shifts", expected, shifts.len()));
        }
        for x in shifts.iter().flatten() {
            Allowed::FINITE.check("shifts", *x)?;
        }
        let mut out = vec![0.0; rows];
        let work = |((q, shifts), out): ((&[f64], &[Point]), &mut [f64])| {
            let mut placed = self.bodies().room();
            for ((q, shifts), to) in q.chunks(dof).zip(shifts.chunks(count)).zip(out) {
                self.bodies().place_unchecked(q, &mut placed);
                *to = self.shifted_clearance(&placed, shifts);
            }
        };
        let runs =
            q.chunks(dof * RUN).zip(shifts.chunks(count * RUN)).zip(out.chunks_mut(RUN)).collect();
        if share(runs, threads, &work, poll) { Ok(out) } else { Err(Error::Interrupted) }
    }

    fn dof(&self) -> usize {
        self.bodies().chain().dof()
    }

    /// Asks `ask` of each row of `q`, with room for `size` answers.
    pub(super) fn each<T: Send>(
        &self,
        q: &[f64],
        size: usize,
        out: &mut [T],
        threads: usize,
        poll: Poll,
        ask: impl Fn(&Placed, &mut [T]) + Sync,
    ) -> Result<()> {
        let (bodies, dof) = (self.bodies(), self.dof());
        let chain = bodies.chain();
        check_postures(chain, q)?;
        let frame = FRAME * chain.compiled().links.len();
        let work = |(q, out): (&[f64], &mut [T])| {
            let mut placed = bodies.room();
            let mut frames = vec![0.0; frame * TOGETHER];
            for (q, out) in q.chunks(dof * TOGETHER).zip(out.chunks_mut(size * TOGETHER)) {
                let rows = q.len() / dof;
                moving_frames(chain, q, &mut frames[..rows * frame]);
                for (frames, out) in frames.chunks(frame).zip(out.chunks_mut(size)) {
                    placed.fill(bodies, frames);
                    ask(&placed, out);
                }
            }
        };
        let runs = q.chunks(dof * RUN).zip(out.chunks_mut(size * RUN)).collect();
        if share(runs, threads, &work, poll) { Ok(()) } else { Err(Error::Interrupted) }
    }
}

fn check_cap(cap: f64) -> Result<()> {
    if cap.is_nan() {
        return Err(Error::argument("cap", "a number", cap));
    }
    Ok(())
}
