//! The pass from base to tool: one sine and cosine per joint, nothing allocated.

use smallvec::{SmallVec, smallvec};

use crate::chain::{Compiled, Link, Twist};
use crate::lanes::{Real, V3, axpy, blend, cross, dot, negate, scale, splat3, sub};

/// One entry per joint, on the stack up to 16 of them: a call for one target then
/// allocates nothing.
pub type PerJoint<T> = SmallVec<[T; 16]>;

/// Where a joint stands: a point on its axis and the axis, both in the world.
#[derive(Debug, Clone, Copy)]
pub struct Axis<R> {
    /// A point on the axis, m.
    pub origin: V3<R>,
    /// Unit vector along the axis.
    pub direction: V3<R>,
}

impl<R: Real> Axis<R> {
    /// A direction turned about the axis by the angle of a sine and cosine (Rodrigues).
    #[inline(always)]
    pub fn turned(&self, v: V3<R>, sine: R, cosine: R) -> V3<R> {
        let a = self.direction;
        let along = dot(a, v) * (R::splat(1.0) - cosine);
        axpy(a, along, blend(v, cosine, cross(a, v), sine))
    }

    /// A point turned about the axis by the angle of a sine and cosine.
    #[inline(always)]
    pub fn turned_point(&self, p: V3<R>, sine: R, cosine: R) -> V3<R> {
        let turned = self.turned(sub(p, self.origin), sine, cosine);
        axpy(self.origin, R::splat(1.0), turned)
    }
}

/// Buffers of one evaluation, sized once for a chain and used again and again.
#[derive(Debug, Clone)]
pub struct Workspace<R> {
    /// One entry per moving joint, filled by [`forward`].
    pub axes: PerJoint<Axis<R>>,
    x: V3<R>,
    y: V3<R>,
    z: V3<R>,
    position: V3<R>,
}

impl<R: Real> Workspace<R> {
    /// Buffers for a chain.
    pub fn new(chain: &Compiled) -> Self {
        let zero = [R::zero(); 3];
        let axis = Axis { origin: zero, direction: zero };
        Self { axes: smallvec![axis; chain.links.len()], x: zero, y: zero, z: zero, position: zero }
    }

    #[inline(always)]
    fn set_frame(&mut self, frame: Frame<R>) {
        self.set_joint_axes([frame.x, frame.y, frame.z]);
        self.position = frame.position;
    }

    /// A point given in the frame of the last moved joint, in the world.
    #[inline(always)]
    pub fn tool_point(&self, t: [f64; 3]) -> V3<R> {
        let p = axpy(self.x, R::splat(t[0]), self.position);
        let p = axpy(self.y, R::splat(t[1]), p);
        axpy(self.z, R::splat(t[2]), p)
    }

    /// A direction given in the frame of the last moved joint, in the world.
    #[inline(always)]
    pub fn tool_direction(&self, t: [f64; 3]) -> V3<R> {
        turn(self.joint_axes(), t)
    }

    /// Axes (columns) of the last moved joint's frame, in the world.
    #[inline(always)]
    pub fn joint_axes(&self) -> [V3<R>; 3] {
        [self.x, self.y, self.z]
    }

    /// Replaces the axes of the last moved joint's frame.
    #[inline(always)]
    pub fn set_joint_axes(&mut self, [x, y, z]: [V3<R>; 3]) {
        self.x = x;
        self.y = y;
        self.z = z;
    }

    /// Axes (columns) of a tool frame given by its columns in the last joint's frame.
    #[inline(always)]
    pub fn tool_axes(&self, columns: &[[f64; 3]; 3]) -> [V3<R>; 3] {
        [
            self.tool_direction(columns[0]),
            self.tool_direction(columns[1]),
            self.tool_direction(columns[2]),
        ]
    }
}

/// A vector given by its components along three axes.
#[inline(always)]
fn turn<R: Real>(axes: [V3<R>; 3], t: [f64; 3]) -> V3<R> {
    let v = scale(axes[2], R::splat(t[2]));
    axpy(axes[0], R::splat(t[0]), axpy(axes[1], R::splat(t[1]), v))
}

/// Forward kinematics at `q` (one value per entry of `q`, rad or m, per lane): fills the
/// workspace with the axes of all moving joints and the frame of the last one.
#[inline(always)]
pub fn forward<R: Real>(chain: &Compiled, q: &[R], workspace: &mut Workspace<R>) {
    let mut frame = Frame::of_first(chain);
    for (link, axis) in chain.links.iter().zip(&mut workspace.axes) {
        *axis = Axis { origin: frame.position, direction: frame.z };
        let value = value(chain, link, q);
        frame.pass(link, || value, turn_of(link, value));
    }
    workspace.set_frame(frame);
}

/// [`forward`] for those who need the last frame alone: the axes are left as they were.
///
/// Sines and cosines come first, into `turns`, one entry per moving joint: they do not wait
/// for each other, and the frame then stays in registers from joint to joint.
#[inline(always)]
pub fn forward_frame<R: Real>(
    chain: &Compiled,
    q: &[R],
    turns: &mut [(R, R)],
    workspace: &mut Workspace<R>,
) {
    for (link, turn) in chain.links.iter().zip(&mut *turns) {
        *turn = turn_of(link, value(chain, link, q));
    }
    let mut frame = Frame::of_first(chain);
    for (link, turn) in chain.links.iter().zip(turns) {
        frame.pass(link, || value(chain, link, q), *turn);
    }
    workspace.set_frame(frame);
}

/// What moves a joint.
#[inline(always)]
fn value<R: Real>(chain: &Compiled, link: &Link, q: &[R]) -> R {
    let value = q[link.variable];
    if chain.simple { value } else { value * R::splat(link.multiplier) }
}

/// Sine and cosine of a joint's turn.
#[inline(always)]
fn turn_of<R: Real>(link: &Link, value: R) -> (R, R) {
    if link.prismatic {
        let (s, c) = link.theta_sin_cos;
        (R::splat(s), R::splat(c))
    } else {
        (value + R::splat(link.theta)).sin_cos()
    }
}

/// A joint's frame in the world, on its way from base to tool.
#[derive(Debug, Clone, Copy)]
struct Frame<R> {
    x: V3<R>,
    y: V3<R>,
    z: V3<R>,
    position: V3<R>,
}

impl<R: Real> Frame<R> {
    /// The first joint's frame.
    #[inline(always)]
    fn of_first(chain: &Compiled) -> Self {
        let [x, y, z] = &chain.start_rotation;
        Self { x: splat3(*x), y: splat3(*y), z: splat3(*z), position: splat3(chain.start_position) }
    }

    /// Moves the joint, and goes on to the next one's frame.
    #[inline(always)]
    fn pass(&mut self, link: &Link, value: impl FnOnce() -> R, (s, c): (R, R)) {
        let (mut x, mut y, mut z, mut p) = (self.x, self.y, self.z, self.position);
        (x, y) = (blend(x, c, y, s), blend(y, c, x, -s));
        // Asked of the bits, which costs less than asking of the numbers.
        if link.prismatic {
            p = axpy(z, value() + R::splat(link.d), p);
        } else if link.d.to_bits() != 0 {
            p = axpy(z, R::splat(link.d), p);
        }
        if link.a.to_bits() != 0 {
            p = axpy(x, R::splat(link.a), p);
        }
        match link.twist {
            Twist::Zero => {}
            Twist::Half => {
                y = negate(y);
                z = negate(z);
            }
            Twist::Quarter => (y, z) = (z, negate(y)),
            Twist::Angle(sine, cosine) => {
                let (s, c) = (R::splat(sine), R::splat(cosine));
                (y, z) = (blend(y, c, z, s), blend(z, c, y, -s));
            }
            Twist::Full(columns) => {
                p = axpy(y, R::splat(link.b), p);
                let axes = [x, y, z];
                x = turn(axes, columns[0]);
                y = turn(axes, columns[1]);
                z = turn(axes, columns[2]);
            }
        }
        *self = Self { x, y, z, position: p };
    }
}
