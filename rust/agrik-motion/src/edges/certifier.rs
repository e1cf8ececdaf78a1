//! Proofs for straight ways in joint space.

use std::collections::VecDeque;

use agrik::chain::Link;
use agrik::kinematics::{FRAME, moving_frames};
use agrik_compute::lanes::{dot, sub};
use agrik_solids::{Point, closest, distance_within};

use super::mover::{Asked, Bound, Mover, levers};
use super::sample::Sample;
use super::sweep::Glance;
use super::verdict::{Keep, Outcome, Verdict};
use crate::body::Mount;
use crate::{Collider, Contact, Other, Placed};

/// Postures whose frames are worked out together: one in each of the widest lanes.
const TOGETHER: usize = 8;

/// Pieces on which nothing moves farther than this leave no share of their margin over, m.
const END: f64 = 1e-4;

/// Margins are asked for up to a length more than is needed, so that rounding takes none away.
const SLACK: f64 = 1e-9;

/// Proves ways of one arm free among the things of one scene. Keeps its memory from one way
/// to the next; each thread has its own.
#[derive(Debug)]
pub struct Certifier<'c> {
    pub(super) collider: &'c Collider,
    keep: Keep,
    /// Share of a margin that a piece leaves over, so that more than nothing is kept.
    share: f64,
    pub(super) movers: Vec<Mover>,
    pub(super) bounds: Vec<Bound>,
    /// The same of the tool point, where that says what may be touched.
    pub(super) tool: Bound,
    /// Spheres round the bodies in their frames.
    spheres: Vec<(Point, f64)>,
    pub(super) middle: Sample,
    sample: Sample,
    pub(super) rates: Vec<f64>,
    pub(super) room: Room,
    pub(super) glance: Glance,
    /// Movers that a glance has left open.
    pub(super) left: Vec<usize>,
}

/// Memory for a way.
#[derive(Debug)]
pub(super) struct Room {
    pub q: Vec<f64>,
    pub frames: Vec<f64>,
    levers: Vec<f64>,
    queue: VecDeque<Piece>,
    placed: Placed,
}

/// A piece of a way that is open for one mover.
#[derive(Debug, Clone, Copy)]
struct Piece {
    mover: usize,
    low: f64,
    high: f64,
}

/// What is known of a way so far.
#[derive(Debug)]
pub(super) struct Known {
    /// Distance that is kept, m.
    pub least: f64,
    pub checks: u32,
    /// Where nothing could be said.
    pub open: Option<(usize, f64)>,
}

/// What a posture says about a mover.
#[derive(Debug, Clone, Copy)]
pub(super) struct Answer {
    /// How far to either side it is free; the whole piece where that is more than its half.
    pub reach: f64,
    /// It is too near to something at the posture itself.
    pub hit: bool,
}

impl<'c> Certifier<'c> {
    /// Of an arm in a scene. `keep` is taken to have been checked.
    pub fn new(collider: &'c Collider, keep: Keep) -> Self {
        let bodies = collider.bodies();
        let body =
            |body: &usize| Mover { asked: Asked::Body(*body), from: 0, to: bodies.moved_by(*body) };
        let pair = |&(i, j): &(usize, usize)| {
            let (near, far) =
                if bodies.moved_by(i) <= bodies.moved_by(j) { (i, j) } else { (j, i) };
            let (from, to) = (bodies.moved_by(near), bodies.moved_by(far));
            Mover { asked: Asked::Pair(near, far), from, to }
        };
        let movers: Vec<Mover> =
            collider.asked().iter().map(body).chain(bodies.self_pairs().iter().map(pair)).collect();
        let pairs = movers.iter().filter_map(|mover| match mover.asked {
            Asked::Pair(near, far) => Some((near, far)),
            Asked::Body(_) => None,
        });
        let pairs = pairs.collect();
        let links = bodies.chain().compiled().links.len();
        let placed = bodies.room();
        let sample = Sample::new(placed.frames()[0], links);
        Self {
            collider,
            keep,
            share: if keep.cap > keep.clear { 0.5 } else { 0.0 },
            bounds: vec![Bound::default(); movers.len()],
            tool: Bound::default(),
            spheres: bodies.mounts().iter().map(|mount| mount.solid.bounding_sphere()).collect(),
            middle: sample.clone(),
            sample,
            rates: vec![0.0; links],
            left: Vec::with_capacity(movers.len()),
            glance: Glance::new(collider.sifted(), pairs, bodies.len()),
            movers,
            room: Room {
                q: Vec::new(),
                frames: Vec::new(),
                levers: Vec::new(),
                queue: VecDeque::new(),
                placed,
            },
        }
    }

    /// What is asked.
    pub fn keep(&self) -> &Keep {
        &self.keep
    }

    /// The arm in its scene.
    pub fn collider(&self) -> &'c Collider {
        self.collider
    }

    pub(super) fn links(&self) -> &'c [Link] {
        &self.collider.bodies().chain().compiled().links
    }

    /// Asks about the straight way in joint space from one posture to another, finite joint
    /// values both, rad and m; the way back has the same answer.
    pub fn segment(&mut self, from: &[f64], to: &[f64]) -> Verdict {
        let links = self.links();
        for (rate, link) in self.rates.iter_mut().zip(links) {
            *rate = link.multiplier * (to[link.variable] - from[link.variable]);
        }
        let mut known = Known { least: self.keep.cap, checks: 0, open: None };
        self.left.clear();
        if self.keep.cap > self.keep.clear {
            self.left.extend(0..self.movers.len());
        } else {
            known.checks = self.movers.len() as u32;
            if let Some((mover, at)) = self.glance(from, to) {
                return self.hit(mover, at, &known);
            }
            if self.left.is_empty() {
                return self.done(&known);
            }
        }
        self.frames(&[0.5], from, to);
        self.middle.fill(links, &self.room.frames, &self.rates);
        self.take_bounds();
        self.room.queue.clear();
        for place in 0..self.left.len() {
            let mover = self.left[place];
            // All of them are asked about the middle, which is in place.
            let piece = Piece { mover, low: 0.0, high: 1.0 };
            if self.look(piece, None, &mut known) {
                return self.hit(mover, 0.5, &known);
            }
        }
        let mut pieces = [Piece { mover: 0, low: 0.0, high: 0.0 }; TOGETHER];
        let mut places = [0.0; TOGETHER];
        let size = FRAME * self.rates.len();
        while !self.room.queue.is_empty() {
            let count = self.room.queue.len().min(TOGETHER);
            for (piece, place) in pieces.iter_mut().zip(&mut places).take(count) {
                if let Some(next) = self.room.queue.pop_front() {
                    (*piece, *place) = (next, 0.5 * (next.low + next.high));
                }
            }
            self.frames(&places[..count], from, to);
            for (row, piece) in pieces[..count].iter().enumerate() {
                if known.checks >= self.keep.max_checks {
                    known.open = known.open.or(Some((piece.mover, places[row])));
                    return self.done(&known);
                }
                if self.look(*piece, Some(row * size), &mut known) {
                    return self.hit(piece.mover, places[row], &known);
                }
            }
        }
        self.done(&known)
    }

    /// [`Certifier::segment`], with what is too near where the way is not safe.
    pub fn explained(&mut self, from: &[f64], to: &[f64]) -> Verdict {
        let mut verdict = self.segment(from, to);
        if let Some((body, other)) = verdict.between {
            let mut q = Vec::with_capacity(from.len());
            q.extend(from.iter().zip(to).map(|(a, b)| a + verdict.at * (b - a)));
            verdict.contact = self.contact(&q, body, other);
        }
        verdict
    }

    /// What a body is nearest to at a posture: the scene, or another body.
    pub(super) fn contact(
        &mut self,
        q: &[f64],
        body: usize,
        other: Option<usize>,
    ) -> Option<Contact> {
        let (collider, placed) = (self.collider, &mut self.room.placed);
        collider.bodies().place_unchecked(q, placed);
        match other {
            None => collider.nearest(placed, body, f64::INFINITY).map(|found| Contact {
                distance: found.distance,
                body,
                other: Other::Object(found.object),
                on_body: found.on_solid,
                on_other: found.on_object,
                normal: found.normal,
            }),
            Some(other) => {
                let found = closest(&placed.solids()[other], &placed.solids()[body]);
                let (on_body, on_other, normal) = (found.on_b, found.on_a, found.normal);
                let distance = found.distance;
                let other = Other::Body(other);
                Some(Contact { distance, body, other, on_body, on_other, normal })
            }
        }
    }

    /// Works out the frames at places of a way.
    fn frames(&mut self, places: &[f64], from: &[f64], to: &[f64]) {
        let room = &mut self.room;
        room.q.clear();
        for place in places {
            room.q.extend(from.iter().zip(to).map(|(a, b)| a + place * (b - a)));
        }
        room.frames.resize(FRAME * self.rates.len() * places.len(), 0.0);
        moving_frames(self.collider.bodies().chain(), &room.q, &mut room.frames);
    }

    /// Puts the middle of a way into its place; rates are there.
    pub(super) fn take_middle(&mut self, q: &[f64]) {
        self.frames(&[0.0], q, q);
        self.middle.fill(self.links(), &self.room.frames, &self.rates);
    }

    /// Works out how far the movers that are left open move on a way whose middle and rates are
    /// in place.
    pub(super) fn take_bounds(&mut self) {
        let (links, mounts) = (self.links(), self.collider.bodies().mounts());
        let levers_of = &mut self.room.levers;
        let (mut last, mut touches) = (usize::MAX, false);
        for place in &self.left {
            let mover = &self.movers[*place];
            let links = &links[..mover.to];
            let (Asked::Body(body) | Asked::Pair(_, body)) = mover.asked;
            if body != last {
                levers(links, &self.middle, &mounts[body].points, &self.rates, levers_of);
                last = body;
            }
            touches |= self.collider.touch_exemption(body).is_some();
            self.bounds[*place] = Bound::new(links, mover.from, levers_of, &self.rates);
        }
        if touches {
            let tail = self.collider.bodies().chain().compiled().tail.translation;
            levers(links, &self.middle, &[tail], &self.rates, levers_of);
            self.tool = Bound::new(links, 0, levers_of, &self.rates);
        }
    }

    /// Looks at the middle of a piece, whose frames start at a place of the room's (the middle
    /// of the whole way where none is said), and puts what it leaves open into the queue. True
    /// where the mover is too near to something.
    fn look(&mut self, piece: Piece, frames: Option<usize>, known: &mut Known) -> bool {
        let (middle, half) = (0.5 * (piece.low + piece.high), 0.5 * (piece.high - piece.low));
        let mover = self.movers[piece.mover];
        if let Some(start) = frames {
            let links = &self.links()[..self.depth(&mover)];
            self.sample.fill(links, &self.room.frames[start..], &self.rates);
        }
        let sample = if frames.is_some() { &self.sample } else { &self.middle };
        known.checks += 1;
        let answer = self.ask(piece.mover, sample, half, known);
        if answer.hit {
            return true;
        }
        if answer.reach > half {
            return false;
        }
        let bound = &self.bounds[piece.mover];
        if bound.rate * half <= self.keep.tolerance {
            known.open = known.open.or(Some((piece.mover, middle)));
            return false;
        }
        for (low, high) in [(piece.low, middle - answer.reach), (middle + answer.reach, piece.high)]
        {
            self.room.queue.push_back(Piece { mover: piece.mover, low, high });
        }
        false
    }

    /// How many joints count for a mover; all of them where the tool point says what may be
    /// touched.
    fn depth(&self, mover: &Mover) -> usize {
        match mover.asked {
            Asked::Body(body) if self.collider.touch_exemption(body).is_some() => self.rates.len(),
            _ => mover.to,
        }
    }

    /// Asks about one mover at a posture, for `half` of the way to either side.
    pub(super) fn ask(
        &self,
        index: usize,
        sample: &Sample,
        half: f64,
        known: &mut Known,
    ) -> Answer {
        let (mover, bound) = (&self.movers[index], &self.bounds[index]);
        let mounts = self.collider.bodies().mounts();
        match mover.asked {
            Asked::Pair(near, far) => {
                let speed = sample.speed(mover.from, mover.to, &mounts[far].points);
                let found = Judged { bound, speed, half, share: self.share, clear: self.keep.own };
                let cap = found.cap(known.least);
                let margin = self.pair_margin(sample, (near, far), cap);
                found.judge(margin, known)
            }
            Asked::Body(body) => {
                let Mount { solid, points, .. } = &mounts[body];
                let solid = solid.placed(&sample.poses[mover.to]);
                let speed = sample.speed(0, mover.to, points);
                let clear = self.keep.clear;
                let found = Judged { bound, speed, half, share: self.share, clear };
                let cap = found.cap(known.least);
                let usual = self.collider.usual_exemption(body);
                let Some((touching, target, radius)) = self.collider.touch_exemption(body) else {
                    let margin = self.collider.margin((body, &solid), usual, clear, cap);
                    return found.judge(margin, known);
                };
                // What may be touched counts only as far as the tool stays near the target.
                let links = self.links();
                let tail = self.collider.bodies().chain().compiled().tail.translation;
                let way = sub(sample.poses[links.len()].point(tail), target);
                let room = radius - dot(way, way).sqrt();
                if room < 0.0 {
                    let margin = self.collider.margin((body, &solid), usual, clear, cap);
                    return found.judge(margin, known);
                }
                let tool_speed = sample.speed(0, links.len(), &[tail]);
                let zone = self.tool.reach(tool_speed, room);
                let margin = self.collider.margin((body, &solid), touching, clear, cap);
                let mut answer = found.judge(margin, known);
                if zone > half || answer.hit {
                    return answer;
                }
                answer.reach = answer.reach.min(zone);
                let usual = self.collider.margin((body, &solid), usual, clear, cap);
                let reach = found.reach(usual);
                if reach > answer.reach {
                    known.least = known.least.min(found.kept(usual));
                    answer.reach = reach;
                }
                answer
            }
        }
    }

    /// By how much two bodies are farther from each other than is to be kept, m.
    fn pair_margin(&self, sample: &Sample, (near, far): (usize, usize), cap: f64) -> f64 {
        let bodies = self.collider.bodies();
        let (mounts, own) = (bodies.mounts(), self.keep.own);
        let (a, b) = (&sample.poses[mounts[near].link], &sample.poses[mounts[far].link]);
        // What stands on the base has its place in the world.
        let at = |body: usize, pose: &agrik_solids::Pose, p: Point| {
            if mounts[body].link == 0 { p } else { pose.point(p) }
        };
        let ((p, r), (q, s)) = (self.spheres[near], self.spheres[far]);
        let way = sub(at(near, a, p), at(far, b, q));
        let apart = own + cap + r + s;
        if dot(way, way) > apart * apart * (1.0 + 1e-12) {
            return cap;
        }
        let solid = |body: usize, pose: &agrik_solids::Pose| {
            let solid = &mounts[body].solid;
            if mounts[body].link == 0 { solid.clone() } else { solid.placed(pose) }
        };
        (distance_within(&solid(near, a), &solid(far, b), own + cap) - own).min(cap)
    }

    fn hit(&self, mover: usize, at: f64, known: &Known) -> Verdict {
        self.verdict(Outcome::Hit, Some((mover, at)), known)
    }

    pub(super) fn done(&self, known: &Known) -> Verdict {
        let outcome = if known.open.is_some() { Outcome::Undecided } else { Outcome::Safe };
        self.verdict(outcome, known.open, known)
    }

    pub(super) fn verdict(
        &self,
        outcome: Outcome,
        place: Option<(usize, f64)>,
        known: &Known,
    ) -> Verdict {
        Verdict {
            outcome,
            clearance: if outcome == Outcome::Safe { known.least } else { 0.0 },
            at: place.map_or(0.0, |(_, at)| at),
            between: place.map(|(mover, _)| match self.movers[mover].asked {
                Asked::Body(body) => (body, None),
                Asked::Pair(near, far) => (far, Some(near)),
            }),
            contact: None,
            checks: known.checks,
        }
    }
}

/// A mover at a posture, to be judged by its margin.
struct Judged<'b> {
    bound: &'b Bound,
    speed: f64,
    half: f64,
    share: f64,
    clear: f64,
}

impl Judged<'_> {
    /// The largest margin that makes a difference, m: one that frees the whole piece and tells
    /// nothing new of what is kept.
    fn cap(&self, least: f64) -> f64 {
        let motion = self.bound.motion(self.speed, self.half);
        (motion / (1.0 - self.share) + SLACK).max(motion + (least - self.clear).max(0.0))
    }

    /// How far to either side a margin frees; all of the piece where it can, with less left
    /// over where need be.
    fn reach(&self, margin: f64) -> f64 {
        let motion = self.bound.motion(self.speed, self.half);
        let at_end = self.bound.rate * self.half <= END;
        if motion <= margin * (1.0 - self.share) || at_end && motion <= margin {
            return f64::INFINITY;
        }
        self.bound.reach(self.speed, margin * (1.0 - self.share)).min(self.half)
    }

    /// Distance that is kept within reach, m.
    fn kept(&self, margin: f64) -> f64 {
        let reach = self.reach(margin).min(self.half);
        self.clear + (margin - self.bound.motion(self.speed, reach)).max(0.0)
    }

    fn judge(&self, margin: f64, known: &mut Known) -> Answer {
        if margin <= 0.0 {
            return Answer { reach: 0.0, hit: true };
        }
        let reach = self.reach(margin);
        if reach > 0.0 {
            known.least = known.least.min(self.kept(margin));
        }
        Answer { reach, hit: false }
    }
}
