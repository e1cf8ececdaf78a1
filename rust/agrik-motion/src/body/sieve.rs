//! What rules out that postures hit, eight at a time.
//!
//! Bodies are seen as balls, in singles, a posture in each lane: first one ball a body, then, if
//! that is near something, the balls that cover it. What is far here is far in truth (see
//! [`agrik_solids::outline`]); the few bodies that may be near are left to doubles.
//!
//! The eight may be places along a way, evenly from its beginning to its end. Between two of
//! them the middle of a ball leaves the straight line by no more than what its acceleration
//! gives, and the line is within half of its length of an end. So balls that are larger by
//! both rule out hits all along the way.

use agrik::kinematics::FRAME;
use agrik_compute::lanes::{Kernel32, Level, Real32, WIDEST, dispatch_eights, norm};
use agrik_solids::outline::{Outline, View, balls, roundings, single_above};
use agrik_solids::{Exemption, Object, Point};

use super::bodies::Mount;
use super::shape::{Body, Shape};

/// One number of each lane.
type Eight = [f32; WIDEST];

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
    near: Vec<u32>,
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
        }
    }
}

struct Sifting<'a> {
    sieve: &'a Sieve,
    question: &'a Question<'a>,
    room: &'a mut Sifted,
}

/// The axes of a frame and its origin, in lanes.
struct Frame<R> {
    m: [R; FRAME],
}

impl<R: Real32> Frame<R> {
    #[inline(always)]
    fn load(frames: &[Eight], link: usize) -> Self {
        let from = &frames[link * FRAME..(link + 1) * FRAME];
        let mut m = [R::splat(0.0); FRAME];
        for (to, from) in m.iter_mut().zip(from) {
            *to = R::load(from);
        }
        Self { m }
    }

    /// Where the middle of a ball is.
    #[inline(always)]
    fn place(&self, [x, y, z, _]: &[f32; 4]) -> [R; 3] {
        self.point([one(*x), one(*y), one(*z)])
    }

    /// Where points of the frame are.
    #[inline(always)]
    fn point(&self, [x, y, z]: [R; 3]) -> [R; 3] {
        let m = &self.m;
        [
            m[0].mul_add(x, m[1].mul_add(y, m[2].mul_add(z, m[9]))),
            m[3].mul_add(x, m[4].mul_add(y, m[5].mul_add(z, m[10]))),
            m[6].mul_add(x, m[7].mul_add(y, m[8].mul_add(z, m[11]))),
        ]
    }

    /// Coordinates in the frame.
    #[inline(always)]
    fn inner(&self, p: &[R; 3]) -> [R; 3] {
        let m = &self.m;
        let [x, y, z] = [p[0] - m[9], p[1] - m[10], p[2] - m[11]];
        [
            m[0].mul_add(x, m[3].mul_add(y, m[6] * z)),
            m[1].mul_add(x, m[4].mul_add(y, m[7] * z)),
            m[2].mul_add(x, m[5].mul_add(y, m[8] * z)),
        ]
    }
}

#[inline(always)]
fn one<R: Real32>(x: f32) -> R {
    R::splat(f64::from(x))
}

#[inline(always)]
fn square<R: Real32>(v: &[R; 3]) -> R {
    v[0].mul_add(v[0], v[1].mul_add(v[1], v[2] * v[2]))
}

#[inline(always)]
fn load<R: Real32>(at: &[Eight; 3]) -> [R; 3] {
    [R::load(&at[0]), R::load(&at[1]), R::load(&at[2])]
}

#[inline(always)]
fn difference<R: Real32>(a: &[R; 3], b: &[R; 3]) -> [R; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
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
    let most = square(&difference(p, &before)).max(square(&difference(p, &after)));
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
        for (body, to) in sieve.bodies.iter().zip(&mut room.centres) {
            let at = Frame::<R>::load(&room.singles, body.link).place(&body.ball);
            for (to, at) in to.iter_mut().zip(at) {
                at.store(to);
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

/// Frames as singles from an origin, before them the world's; the largest coordinate of an
/// origin of them, m.
#[inline(always)]
fn singles<R: Real32>(frames: &[[f64; WIDEST]], origin: Point, to: &mut [Eight]) -> f32 {
    let mut away = one::<R>(0.0);
    for (k, to) in to[..FRAME].iter_mut().enumerate() {
        let turn = if k < 9 && k % 4 == 0 { 1.0 } else { 0.0 };
        let number = if k < 9 { turn } else { -origin[k - 9] as f32 };
        away = if k < 9 { away } else { away.max(one(number.abs())) };
        *to = [number; WIDEST];
    }
    for (frame, to) in frames.chunks_exact(FRAME).zip(to[FRAME..].chunks_exact_mut(FRAME)) {
        for (k, (from, to)) in frame.iter().zip(to).enumerate() {
            let off = if k < 9 { 0.0 } else { origin[k - 9] };
            for (to, from) in to.iter_mut().zip(from) {
                *to = (from - off) as f32;
            }
            away = if k < 9 { away } else { away.max(R::load(to).abs()) };
        }
    }
    let mut each = [0.0_f32; WIDEST];
    away.store(&mut each);
    each.into_iter().fold(0.0, f32::max)
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
    room.near.clear();
    let mut maybe = 0;
    for (place, thing) in things.iter().enumerate() {
        if exempt.contains(thing.label()) {
            continue;
        }
        let lanes = thing.maybe(&centre, reach + R::splat(question.keep(thing.label())));
        if lanes != 0 {
            room.near.push(place as u32);
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
        for place in &room.near {
            let thing = &things[*place as usize];
            left |= thing.outline().maybe(&centre, reach + R::splat(question.keep(thing.label())));
        }
        if crowd & !left != 0 {
            left |= view.maybe_crowd(&centre, reach + most);
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
            near.push(place as u32);
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
        for place in &room.near {
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
    let apart = difference(&load::<R>(&room.centres[i]), &load(&room.centres[j]));
    let mut reach = one::<R>(a.ball[3] + b.ball[3]) + own;
    if let Some((moves, _)) = way {
        reach = reach + one(moves);
    }
    let maybe = R::bits(square(&apart).le(reach * reach));
    if maybe == 0 {
        return 0;
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
