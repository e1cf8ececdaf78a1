//! What rules out that postures hit, eight at a time.
//!
//! Bodies are seen as balls, in singles, a posture in each lane: first one ball a body, then, if
//! that is near something, the balls that cover it. What is far here is far in truth (see
//! [`agrik_solids::outline`]); the few bodies that may be near are left to doubles. Boxes are
//! seen as such by each other and by things that are few: a plane between two of them costs less
//! to look for than a ball for each of their cells.
//!
//! The eight may be places along a way, evenly from its beginning to its end. Between two of
//! them the middle of a ball leaves the straight line by no more than what its acceleration
//! gives, and the line is within half of its length of an end. So balls that are larger by
//! both rule out hits all along the way.

use agrik::kinematics::FRAME;
use agrik_compute::lanes::{Kernel32, Level, Real32, WIDEST, dispatch_eights, dot, norm, sub};
use agrik_solids::outline::{Block, Boxed, Outline, View, balls, roundings, single_above};
use agrik_solids::{Exemption, Object, Point};

use super::bodies::Mount;
use super::eights::{Eight, Frame, load, one, singles, store};
use super::shape::{Body, Shape};

/// Parts of a way that eight places cut it into.
pub(crate) const PARTS: f64 = (WIDEST - 1) as f64;

/// The bodies of an arm as balls.
#[derive(Debug, Clone)]
pub(crate) struct Sieve {
    bodies: Vec<Outlined>,
    /// No point of a body is farther from its frame than this, m.
    size: f64,
}

/// One of them, in the frame that it stands in.
#[derive(Debug, Clone)]
struct Outlined {
    link: usize,
    /// All round it.
    ball: [f32; 4],
    /// Those that cover it.
    balls: Vec<[f32; 4]>,
    /// The same, eight at a time; the last ones again where they are fewer.
    eights: Vec<[Eight; 4]>,
    outline: Outline,
    /// The body as the box that it is, and whether objects see it as such.
    block: Option<Block>,
    is_seen_as_box: bool,
}

/// Memory for eight postures, and what is found.
#[derive(Debug, Clone, Default)]
pub(crate) struct Sifted {
    /// The frames of [`agrik::kinematics::frames_abreast`].
    pub frames: Vec<[f64; WIDEST]>,
    /// What may be too near to something, and in which lanes, a bit each: bodies that are asked,
    /// by their place, and behind them pairs.
    pub maybe: Vec<(usize, u32)>,
    singles: Vec<Eight>,
    centres: Vec<[Eight; 3]>,
    /// The middles of boxes and their axes.
    boxes: Vec<[[Eight; 3]; 4]>,
    /// Things that may be near a body, and in which lanes.
    near: Vec<(u32, u32)>,
}

/// How far a way may lead beyond the places that are looked at.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bends<'a> {
    /// The most that balls of a body leave the lines between places, m.
    pub bodies: &'a [f32],
    /// The same seen from the nearer body of a pair.
    pub pairs: &'a [f32],
    /// The most that the farther body of a pair moves from a place, seen from the nearer one, m.
    pub moves: &'a [f32],
}

/// What is asked.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Question<'a> {
    pub view: View<'a>,
    pub objects: &'a [Object],
    /// What each body does not mind.
    pub exempt: &'a [Exemption],
    /// Bodies that are asked about objects.
    pub asked: &'a [usize],
    /// Pairs of bodies, on a way the nearer one first.
    pub pairs: &'a [(usize, usize)],
    /// What is to be kept from objects, m, where they ask for no more, and the most that one
    /// asks for.
    pub clear: f64,
    pub most: f64,
    /// The same for pairs, m.
    pub own: f64,
    pub way: Option<Bends<'a>>,
    /// All lanes hold the same posture, which is told of the first alone.
    pub alone: bool,
}

impl Question<'_> {
    /// What is to be kept from an object, m.
    #[inline(always)]
    fn keep(&self, label: usize) -> f64 {
        self.objects[label].clearance.max(self.clear)
    }
}

impl Sifted {
    /// Of an arm with so many moving joints.
    pub fn new(links: usize) -> Self {
        Self { frames: vec![[0.0; WIDEST]; FRAME * links], ..Self::default() }
    }
}

impl Sieve {
    pub fn new(bodies: &[Body], mounts: &[Mount]) -> Self {
        let bodies: Vec<Outlined> = bodies.iter().zip(mounts).map(Outlined::new).collect();
        let far = |one: &Outlined| {
            let [x, y, z, r] = one.ball.map(f64::from);
            norm([x, y, z]) + r
        };
        let size = bodies.iter().map(far).fold(0.0, f64::max);
        Self { bodies, size }
    }

    /// Looks at the postures whose frames are in place. What bodies and pairs are not asked
    /// about is not told.
    pub fn sift(&self, level: Level, question: &Question<'_>, room: &mut Sifted) {
        let Some(frames) = room.frames.len().checked_div(FRAME) else { return };
        room.maybe.clear();
        room.centres.resize(self.bodies.len(), [[0.0; WIDEST]; 3]);
        room.boxes.resize(self.bodies.len(), [[[0.0; WIDEST]; 3]; 4]);
        room.singles.resize((frames + 1) * FRAME, [0.0; WIDEST]);
        dispatch_eights(level, Sifting { sieve: self, question, room });
    }
}

impl Outlined {
    fn new((body, mount): (&Body, &Mount)) -> Self {
        let solid = &mount.solid;
        let ([x, y, z], mut radius) = solid.bounding_sphere();
        let mut covering = balls(solid);
        if let (
            Shape::Cover { cover, level, radius: more, .. },
            agrik_solids::Core::Cuboid(cuboid),
        ) = (&body.shape, solid.core())
        {
            // The spheres of a cover stick out of the box.
            let of = cover.radius(*level) + more;
            let coarse = cover.centres((*level).min(1));
            let each = cover.centres(*level).len() / coarse.len();
            let far = |from: Point, p: &Point| norm([0, 1, 2].map(|k| p[k] - from[k])) + of;
            let reach = |from: Point, some: &[Point]| {
                some.iter().map(|p| far(from, p)).fold(0.0, f64::max) * (1.0 + 1e-12)
            };
            radius = reach([0.0; 3], cover.centres(*level));
            let cells = coarse.iter().zip(cover.centres(*level).chunks(each));
            covering = cells
                .map(|(centre, some)| {
                    let [x, y, z] = cuboid.point(*centre);
                    [x, y, z, reach(*centre, some)]
                })
                .collect();
        }
        let ball = |[x, y, z, r]: [f64; 4]| [x as f32, y as f32, z as f32, single_above(r)];
        let balls: Vec<[f32; 4]> = covering.into_iter().map(ball).collect();
        let eight = |some: &[[f32; 4]]| {
            [0, 1, 2, 3].map(|k| std::array::from_fn(|lane| some[lane.min(some.len() - 1)][k]))
        };
        Self {
            link: mount.link,
            ball: ball([x, y, z, radius]),
            eights: balls.chunks(WIDEST).map(eight).collect(),
            balls,
            outline: Outline::new(solid, [0.0; 3]),
            block: Block::new(solid),
            is_seen_as_box: matches!(body.shape, Shape::Exact(_)),
        }
    }

    /// The box in each of eight postures, where it lies, and how far the body reaches beyond it.
    #[inline(always)]
    fn boxed<R: Real32>(&self, at: &[[Eight; 3]; 4]) -> Option<(Boxed<R>, R)> {
        let block = self.block.as_ref()?;
        let half = [one(block.half[0]), one(block.half[1]), one(block.half[2])];
        let axes = [load(&at[1]), load(&at[2]), load(&at[3])];
        Some((Boxed { centre: load(&at[0]), axes, half }, one(block.radius)))
    }
}

struct Sifting<'a> {
    sieve: &'a Sieve,
    question: &'a Question<'a>,
    room: &'a mut Sifted,
}

/// How far a point gets from each of eight places before it is nearer to another one, m, but
/// for its bends: half of the way to the farther of its neighbours.
#[inline(always)]
fn spread<R: Real32>(p: &[R; 3]) -> R {
    let mut rows = [[0.0; WIDEST + 2]; 3];
    for (row, p) in rows.iter_mut().zip(p) {
        p.store(&mut row[1..]);
        row[0] = row[1];
        row[WIDEST + 1] = row[WIDEST];
    }
    let [x, y, z] = &rows;
    let before = [R::load(x), R::load(y), R::load(z)];
    let after = [R::load(&x[2..]), R::load(&y[2..]), R::load(&z[2..])];
    let (before, after) = (sub(*p, before), sub(*p, after));
    let most = dot(before, before).max(dot(after, after));
    most.sqrt() * R::splat(0.5)
}

/// How far a ball reaches from the places of its middle, m.
#[inline(always)]
fn reach_round<R: Real32>(p: &[R; 3], radius: f32, bend: Option<f32>) -> R {
    match bend {
        Some(bend) => one::<R>(radius) + (spread(p) + one(bend)),
        None => one(radius),
    }
}

impl Kernel32 for Sifting<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Real32>(self) {
        let Self { sieve, question, room } = self;
        let away = singles::<R>(&room.frames, question.view.origin(), &mut room.singles);
        let more = roundings(question.view.extent() + 2.0 * f64::from(away) + sieve.size);
        let more = single_above(more);
        let places = room.centres.iter_mut().zip(&mut room.boxes);
        for (body, (centre, boxed)) in sieve.bodies.iter().zip(places) {
            let frame = Frame::<R>::load(&room.singles, body.link);
            store(frame.place(&body.ball), centre);
            // Of ways balls alone are known.
            if let (Some(block), None) = (&body.block, &question.way) {
                let [x, y, z] = block.centre;
                store(frame.place(&[x, y, z, 0.0]), &mut boxed[0]);
                for (axis, to) in block.axes.iter().zip(&mut boxed[1..]) {
                    store(frame.turned(axis), to);
                }
            }
        }
        for (place, body) in question.asked.iter().enumerate() {
            let bend = question.way.map(|way| way.bodies[*body]);
            let lanes = if question.alone {
                u32::from(objects_alone::<R>(sieve, question, room, *body, more))
            } else {
                objects::<R>(sieve, question, room, *body, more, bend)
            };
            if lanes != 0 {
                room.maybe.push((place, lanes));
            }
        }
        for (index, pair) in question.pairs.iter().enumerate() {
            let way = question.way.map(|way| (way.moves[index], way.pairs[index]));
            let lanes = pairs::<R>(sieve, question, room, *pair, more, way);
            if lanes != 0 {
                room.maybe.push((question.asked.len() + index, lanes));
            }
        }
    }
}

/// Lanes in which a body may be too near to an object.
#[inline(always)]
fn objects<R: Real32>(
    sieve: &Sieve,
    question: &Question<'_>,
    room: &mut Sifted,
    index: usize,
    more: f32,
    bend: Option<f32>,
) -> u32 {
    let (body, view) = (&sieve.bodies[index], &question.view);
    let exempt = &question.exempt[index];
    let things = view.things();
    let most = R::splat(question.most);
    let centre = load::<R>(&room.centres[index]);
    let reach = reach_round(&centre, body.ball[3] + more, bend);
    // Boxes are seen with the roundings of their axes on top.
    let mut boxed = None;
    if body.is_seen_as_box
        && bend.is_none()
        && let Some((block, radius)) = body.boxed::<R>(&room.boxes[index])
    {
        boxed = Some((block, block.extent(), radius + one(more + more)));
    }
    room.near.clear();
    let mut maybe = 0;
    for (place, thing) in things.iter().enumerate() {
        if exempt.contains(thing.label()) {
            continue;
        }
        let keep = R::splat(question.keep(thing.label()));
        let mut lanes = thing.maybe(&centre, reach + keep);
        if lanes != 0
            && let Some((boxed, extent, radius)) = &boxed
        {
            lanes &= thing.maybe_upright(&boxed.centre, extent, *radius + keep);
            if lanes != 0 {
                lanes &= thing.outline().maybe_box(boxed, *radius + keep);
            }
        }
        if lanes != 0 {
            room.near.push((place as u32, lanes));
            maybe |= lanes;
        }
    }
    let crowd = view.maybe_crowd(&centre, reach + most);
    maybe |= crowd;
    if maybe == 0 {
        return 0;
    }
    let frame = Frame::<R>::load(&room.singles, body.link);
    let mut left = 0;
    for ball in &body.balls {
        let centre = frame.place(ball);
        let reach = reach_round(&centre, ball[3] + more, bend);
        for (place, lanes) in &room.near {
            if lanes & !left == 0 {
                continue;
            }
            let thing = &things[*place as usize];
            let keep = R::splat(question.keep(thing.label()));
            left |= lanes & thing.outline().maybe(&centre, reach + keep);
        }
        if crowd & !left != 0 {
            left |= crowd & view.maybe_crowd(&centre, reach + most);
        }
        if maybe & !left == 0 {
            return maybe;
        }
    }
    maybe & left
}

/// A body may be too near to an object, in a posture that is in all lanes: they take things
/// then, and balls.
#[inline(always)]
fn objects_alone<R: Real32>(
    sieve: &Sieve,
    question: &Question<'_>,
    room: &mut Sifted,
    index: usize,
    more: f32,
) -> bool {
    let (body, view) = (&sieve.bodies[index], &question.view);
    let (exempt, things) = (&question.exempt[index], view.things());
    let most = R::splat(question.most);
    let centre = load::<R>(&room.centres[index]);
    let reach = one::<R>(body.ball[3] + more) + most;
    let near = &mut room.near;
    near.clear();
    view.each_near(&centre, reach, |place| {
        if !exempt.contains(things[place].label()) {
            near.push((place as u32, 1));
        }
    });
    let crowded = view.maybe_crowd(&centre, reach) != 0;
    if near.is_empty() && !crowded {
        return false;
    }
    let frame = Frame::<R>::load(&room.singles, body.link);
    for [x, y, z, r] in &body.eights {
        let centre = frame.point([R::load(x), R::load(y), R::load(z)]);
        let reach = R::load(r) + one(more);
        for (place, _) in &room.near {
            let thing = &things[*place as usize];
            let keep = R::splat(question.keep(thing.label()));
            if thing.outline().maybe(&centre, reach + keep) != 0 {
                return true;
            }
        }
        if crowded && view.maybe_crowd(&centre, reach + most) != 0 {
            return true;
        }
    }
    false
}

/// Lanes in which two bodies may be too near to each other.
#[inline(always)]
fn pairs<R: Real32>(
    sieve: &Sieve,
    question: &Question<'_>,
    room: &Sifted,
    (i, j): (usize, usize),
    more: f32,
    way: Option<(f32, f32)>,
) -> u32 {
    let (a, b) = (&sieve.bodies[i], &sieve.bodies[j]);
    let own = one::<R>(more) + R::splat(question.own);
    let apart = sub(load::<R>(&room.centres[i]), load(&room.centres[j]));
    let mut reach = one::<R>(a.ball[3] + b.ball[3]) + own;
    if let Some((moves, _)) = way {
        reach = reach + one(moves);
    }
    let maybe = R::bits(dot(apart, apart).le(reach * reach));
    if maybe == 0 {
        return 0;
    }
    if way.is_none()
        && b.block.is_some()
        && let Some((a, r)) = a.boxed::<R>(&room.boxes[i])
        && let Some((b, s)) = b.boxed::<R>(&room.boxes[j])
    {
        return maybe & a.maybe(&b, r + s + own + one(more));
    }
    // On a way the farther one is seen from the nearer one.
    let (a, b) = if way.is_none() && a.balls.len() < b.balls.len() { (b, a) } else { (a, b) };
    let (frame, of) =
        (Frame::<R>::load(&room.singles, a.link), Frame::<R>::load(&room.singles, b.link));
    let mut left = 0;
    if question.alone {
        for [x, y, z, r] in &b.eights {
            let p = frame.inner(&of.point([R::load(x), R::load(y), R::load(z)]));
            if a.outline.maybe(&p, R::load(r) + own) != 0 {
                return 1;
            }
        }
        return 0;
    }
    for ball in &b.balls {
        let p = frame.inner(&of.place(ball));
        let reach = reach_round(&p, ball[3], way.map(|way| way.1)) + own;
        left |= a.outline.maybe(&p, reach);
        if maybe & !left == 0 {
            return maybe;
        }
    }
    maybe & left
}
