//! Proven bounds of where a chain's tool point and last joint can be.
//!
//! Two bounds hold for every `q` inside the limits: a sphere about the first joint whose
//! radius is the sum of the lengths (triangle inequality), with an inner radius where one
//! length exceeds all others together, and a box from interval arithmetic. What counts as
//! one length is also the distance across an elbow, which its limits keep from closing. A
//! target outside either is out of reach; a target inside both may still be.

use super::{Compiled, Tail, Twist, Variable};
use crate::lanes::hypotenuse;

/// Where a point can be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// Centre of the sphere, m, world frame.
    pub center: [f64; 3],
    /// No point is farther from the centre, m.
    pub radius: f64,
    /// No point is nearer to the centre, m.
    pub inner_radius: f64,
    /// Smallest coordinates, m, world frame.
    pub lower: [f64; 3],
    /// Largest coordinates, m, world frame.
    pub upper: [f64; 3],
    /// What counts as the size of the robot, m: the radius, with ways that slides go counted
    /// no longer than all fixed lengths together. A rail of kilometres does not make the arm
    /// on it larger. Finite and above zero.
    pub size: f64,
}

/// Room for rounding, relative to the size of the robot.
const MARGIN: f64 = 1e-12;
/// Share of the slides' ways that is the least size: fixed lengths may be nothing but rounding.
const LEAST_SIZE: f64 = 1e-9;
/// No slide is this long: a limit so far out stands for none, whatever the unit.
const ENDLESS: f64 = 1e9;

impl Reach {
    /// Bounds of the tool point.
    pub(super) fn new(chain: &Compiled, variables: &[Variable]) -> Self {
        Self::with_tail(chain, variables, &chain.tail)
    }

    /// Bounds of the tool point with another tool.
    pub fn with_tail(chain: &Compiled, variables: &[Variable], tail: &Tail) -> Self {
        let limits: Vec<Interval> = variables.iter().map(Interval::of_limits).collect();
        Self::of_point(chain, &limits, tail.translation)
    }

    /// Bounds of the origin of the last joint, a point that its own motion does not move
    /// when it turns; `None` for a chain that ends in a slide.
    pub fn of_last_joint(chain: &Compiled, variables: &[Variable]) -> Option<Self> {
        let limits: Vec<Interval> = variables.iter().map(Interval::of_limits).collect();
        let last = chain.links.last()?;
        (!last.prismatic).then(|| Self::of_point(chain, &limits, [0.0; 3]))
    }

    /// How far `point` lies outside the bounds, m; zero or less where it may be reached.
    #[inline(always)]
    pub fn excess(&self, point: [f64; 3]) -> f64 {
        let mut outside: f64 = f64::NEG_INFINITY;
        let mut distance2 = 0.0;
        for (i, &x) in point.iter().enumerate() {
            outside = outside.max(self.lower[i] - x).max(x - self.upper[i]);
            distance2 += (x - self.center[i]).powi(2);
        }
        let distance = distance2.sqrt();
        outside.max(distance - self.radius).max(self.inner_radius - distance)
    }

    fn of_point(chain: &Compiled, limits: &[Interval], point: [f64; 3]) -> Self {
        let (lower, upper) = bounding_box(chain, limits, point);
        let (center, radius, inner_radius, size) = sphere(chain, limits, point);
        let margin = MARGIN * (1.0 + radius);
        Self {
            center,
            radius: radius + margin,
            inner_radius: (inner_radius - margin).max(0.0),
            lower: lower.map(|x| x - margin),
            upper: upper.map(|x| x + margin),
            // Without slides the two are the same.
            size: if size == radius { radius + margin } else { size },
        }
    }
}

/// The way from one joint to the next one, in the turned frame of the first.
#[derive(Debug, Clone, Copy)]
struct Piece {
    side: [f64; 2],
    /// Along the joint's axis.
    ahead: Interval,
}

impl Piece {
    fn longest(&self) -> f64 {
        let ahead = self.ahead.lower.abs().max(self.ahead.upper.abs());
        hypotenuse(hypotenuse(self.side[0], self.side[1]), ahead)
    }

    fn shortest(&self) -> f64 {
        let ahead = if self.ahead.lower <= 0.0 && self.ahead.upper >= 0.0 {
            0.0
        } else {
            self.ahead.lower.abs().min(self.ahead.upper.abs())
        };
        hypotenuse(hypotenuse(self.side[0], self.side[1]), ahead)
    }

    /// The way where no slide changes it.
    fn rigid(&self) -> Option<[f64; 3]> {
        let Interval { lower, upper } = self.ahead;
        (lower == upper).then_some([self.side[0], self.side[1], lower])
    }
}

/// The size of a robot of these pieces.
fn size(chain: &Compiled, pieces: &[Piece]) -> f64 {
    let (mut fixed, mut ways) = (0.0, Vec::new());
    for (link, piece) in chain.links.iter().zip(pieces) {
        if link.prismatic {
            fixed += hypotenuse(piece.side[0], piece.side[1]);
            ways.push(piece.ahead.lower.abs().max(piece.ahead.upper.abs()));
        } else {
            fixed += piece.longest();
        }
    }
    let finite: f64 = ways.iter().filter(|way| **way < ENDLESS).sum();
    let counted: f64 = ways.iter().map(|way| way.min(fixed)).sum();
    let size = if fixed > 0.0 { (fixed + counted).max(LEAST_SIZE * finite) } else { finite };
    // A wrist alone, or slides without ends.
    if size > 0.0 { size } else { 1.0 }
}

/// The sphere: centre, radius, inner radius; the size.
fn sphere(chain: &Compiled, limits: &[Interval], point: [f64; 3]) -> ([f64; 3], f64, f64, f64) {
    let mut center = chain.start_position;
    let mut pieces: Vec<Piece> = Vec::new();
    let last = chain.links.len() - 1;
    for (i, link) in chain.links.iter().enumerate() {
        let along = if link.prismatic {
            limits[link.variable].scale(link.multiplier).add(Interval::point(link.d))
        } else {
            Interval::point(link.d)
        };
        let (ahead, side) = if i == last {
            (along.add(Interval::point(point[2])), [point[0], point[1]])
        } else {
            (along, [link.a, link.b])
        };
        // The first joint's axis stands still: move the centre along it to the middle.
        let ahead = if i == 0 {
            let middle = 0.5 * (ahead.lower + ahead.upper);
            let middle = if middle.is_finite() { middle } else { 0.0 };
            for (x, z) in center.iter_mut().zip(chain.start_rotation[2]) {
                *x += z * middle;
            }
            ahead.add(Interval::point(-middle))
        } else {
            ahead
        };
        pieces.push(Piece { side, ahead });
    }
    let radius: f64 = pieces.iter().map(Piece::longest).sum();
    let size = if chain.links.iter().any(|link| link.prismatic) || radius == 0.0 {
        size(chain, &pieces)
    } else {
        radius
    };
    let alone = pieces.iter().map(|p| p.shortest() - (radius - p.longest()));
    let elbows = (1..pieces.len()).filter_map(|joint| {
        let (distance, longest) = across(chain, limits, &pieces, joint)?;
        Some(distance - (radius - longest))
    });
    (center, radius, alone.chain(elbows).fold(0.0, f64::max), size)
}

/// The least distance across a turning joint, from the joint before it to the one after,
/// and the sum of the lengths that this takes the place of. Where the next piece lies along
/// its own axis, which the turn of its joint does not move, it counts as well.
fn across(
    chain: &Compiled,
    limits: &[Interval],
    pieces: &[Piece],
    joint: usize,
) -> Option<(f64, f64)> {
    let (link, before) = (&chain.links[joint], &chain.links[joint - 1]);
    if link.prismatic {
        return None;
    }
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let from = pieces[joint - 1].rigid()?;
    let from = axes_after(before.twist).map(|axis| dot(axis, from));
    let mut to = pieces[joint].rigid()?;
    let mut longest = pieces[joint - 1].longest() + pieces[joint].longest();
    if let Some(next) = pieces.get(joint + 1)
        && let Some([0.0, 0.0, ahead]) = next.rigid()
    {
        let axis = axes_after(link.twist)[2];
        for (x, z) in to.iter_mut().zip(axis) {
            *x += z * ahead;
        }
        longest += next.longest();
    }
    // The square of the distance is a constant and a cosine of the joint's angle.
    let (cosine, sine) = (from[0] * to[0] + from[1] * to[1], from[1] * to[0] - from[0] * to[1]);
    let angle = limits[link.variable].scale(link.multiplier).add(Interval::point(link.theta));
    let swing = hypotenuse(cosine, sine) * angle.cos_shifted(sine.atan2(cosine)).lower;
    let size = dot(from, from) + dot(to, to);
    let squared = size + 2.0 * (from[2] * to[2] + swing);
    // A root would make rounding large where the elbow folds.
    let sure = squared - 64.0 * f64::EPSILON * size;
    Some((sure.max(0.0).sqrt(), longest))
}

/// The box, by interval arithmetic over the limits.
fn bounding_box(chain: &Compiled, limits: &[Interval], point: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let fixed = |v: [f64; 3]| v.map(Interval::point);
    let [mut x, mut y, mut z] = chain.start_rotation.map(fixed);
    let mut p = fixed(chain.start_position);
    let last = chain.links.len() - 1;
    for (i, link) in chain.links.iter().enumerate() {
        let value = limits[link.variable].scale(link.multiplier);
        let (angle, along) = if link.prismatic {
            (Interval::point(link.theta), value.add(Interval::point(link.d)))
        } else {
            (value.add(Interval::point(link.theta)), Interval::point(link.d))
        };
        let (s, c) = angle.sin_cos();
        let turned_x = combine(&[(x, c), (y, s)]);
        let turned_y = combine(&[(x, s.scale(-1.0)), (y, c)]);
        (x, y) = (turned_x, turned_y);
        let (a, b) = if i == last { (point[0], point[1]) } else { (link.a, link.b) };
        let along = if i == last { along.add(Interval::point(point[2])) } else { along };
        for k in 0..3 {
            p[k] = p[k].add(z[k].mul(along)).add(x[k].scale(a)).add(y[k].scale(b));
        }
        if i < last {
            let [tx, ty, tz] = axes_after(link.twist);
            let column = |t: [f64; 3]| {
                combine(&[
                    (x, Interval::point(t[0])),
                    (y, Interval::point(t[1])),
                    (z, Interval::point(t[2])),
                ])
            };
            (x, y, z) = (column(tx), column(ty), column(tz));
        }
    }
    (p.map(|i| i.lower), p.map(|i| i.upper))
}

/// Axes of the next joint's frame in the turned frame of the one before.
fn axes_after(twist: Twist) -> [[f64; 3]; 3] {
    match twist {
        Twist::Full(columns) => columns,
        Twist::Zero => twist_columns(0.0, 1.0),
        Twist::Half => twist_columns(0.0, -1.0),
        Twist::Quarter => twist_columns(1.0, 0.0),
        Twist::Angle(sine, cosine) => twist_columns(sine, cosine),
    }
}

/// Columns of a rotation about x.
fn twist_columns(sine: f64, cosine: f64) -> [[f64; 3]; 3] {
    [[1.0, 0.0, 0.0], [0.0, cosine, sine], [0.0, -sine, cosine]]
}

/// A sum of products; entries of a rotation stay inside [-1, 1].
fn combine(terms: &[([Interval; 3], Interval)]) -> [Interval; 3] {
    [0, 1, 2].map(|k| {
        let sum =
            terms.iter().fold(Interval::point(0.0), |sum, (v, factor)| sum.add(v[k].mul(*factor)));
        Interval { lower: sum.lower.max(-1.0), upper: sum.upper.min(1.0) }
    })
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Interval {
    lower: f64,
    upper: f64,
}

impl Interval {
    fn point(x: f64) -> Self {
        Self { lower: x, upper: x }
    }
    fn of_limits(v: &Variable) -> Self {
        Self { lower: v.lower, upper: v.upper }
    }
    fn add(self, o: Self) -> Self {
        Self { lower: self.lower + o.lower, upper: self.upper + o.upper }
    }
    fn scale(self, k: f64) -> Self {
        if k == 0.0 {
            return Self::point(0.0);
        }
        let (a, b) = (self.lower * k, self.upper * k);
        Self { lower: a.min(b), upper: a.max(b) }
    }
    fn mul(self, o: Self) -> Self {
        // Nothing times a way without end is nothing, not NaN.
        let product = |a: f64, b: f64| if a == 0.0 || b == 0.0 { 0.0 } else { a * b };
        let products = [
            product(self.lower, o.lower),
            product(self.lower, o.upper),
            product(self.upper, o.lower),
            product(self.upper, o.upper),
        ];
        Self {
            lower: products.iter().copied().fold(f64::INFINITY, f64::min),
            upper: products.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        }
    }
    /// Sine and cosine of every angle in the interval.
    fn sin_cos(self) -> (Self, Self) {
        (self.cos_shifted(std::f64::consts::FRAC_PI_2), self.cos_shifted(0.0))
    }
    /// `cos(angle - shift)`.
    fn cos_shifted(self, shift: f64) -> Self {
        use std::f64::consts::{PI, TAU};
        let (a, b) = (self.lower - shift, self.upper - shift);
        // Unbounded joints give an infinite width, or none at all.
        if (b - a).is_nan() || b - a >= TAU {
            return Self { lower: -1.0, upper: 1.0 };
        }
        let (ca, cb) = (a.cos(), b.cos());
        // A maximum at a multiple of a turn, a minimum half a turn later.
        let has_max = (b / TAU).floor() >= (a / TAU).ceil();
        let has_min = ((b - PI) / TAU).floor() >= ((a - PI) / TAU).ceil();
        Self {
            lower: if has_min { -1.0 } else { ca.min(cb) },
            upper: if has_max { 1.0 } else { ca.max(cb) },
        }
    }
}
