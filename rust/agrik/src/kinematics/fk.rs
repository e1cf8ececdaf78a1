//! The pass from base to tool: one sine and cosine per joint, nothing allocated.

use smallvec::{SmallVec, smallvec};

use crate::chain::{Compiled, Link, Twist};
use crate::lanes::{
    Real, V3, axpy, blend, cross, difference, dot, negate, scale, splat3, sub, turns_each,
};

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
    /// Sine and cosine of each joint's angle.
    turns: PerJoint<[R; 2]>,
    frame: Frame<R>,
}

impl<R: Real> Workspace<R> {
    /// Buffers for a chain.
    pub fn new(chain: &Compiled) -> Self {
        let zero = [R::zero(); 3];
        let axis = Axis { origin: zero, direction: zero };
        let frame = Frame { x: zero, y: zero, z: zero, position: zero };
        let joints = chain.links.len();
        Self { axes: smallvec![axis; joints], turns: smallvec![[R::zero(); 2]; joints], frame }
    }

    /// A point given in the frame of the last moved joint, in the world.
    #[inline(always)]
    pub fn tool_point(&self, t: [f64; 3]) -> V3<R> {
        self.frame.point(t)
    }

    /// A direction given in the frame of the last moved joint, in the world.
    #[inline(always)]
    pub fn tool_direction(&self, t: [f64; 3]) -> V3<R> {
        turn(self.joint_axes(), t)
    }

    /// Axes (columns) of the last moved joint's frame, in the world.
    #[inline(always)]
    pub fn joint_axes(&self) -> [V3<R>; 3] {
        self.frame.axes()
    }

    /// Replaces the axes of the last moved joint's frame.
    #[inline(always)]
    pub fn set_joint_axes(&mut self, [x, y, z]: [V3<R>; 3]) {
        self.frame = Frame { x, y, z, position: self.frame.position };
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
    // Sines and cosines first: beside the twelve numbers of a frame they would not fit the
    // registers, and here they do not wait for one another.
    for (link, turn) in chain.links.iter().zip(&mut workspace.turns) {
        *turn = turn_of(chain, link, q);
    }
    let mut frame = Frame::start(chain);
    let joints = chain.links.iter().zip(&mut workspace.axes).zip(&workspace.turns);
    for ((link, axis), turn) in joints {
        *axis = Axis { origin: frame.position, direction: frame.z };
        frame = over(chain, link, q, *turn, frame);
    }
    workspace.frame = frame;
}

/// [`forward`] for angles so large that sums with them lose digits: each is brought back to a
/// turn before anything is added to it.
#[inline(never)]
pub(super) fn forward_far(chain: &Compiled, q: &[f64], workspace: &mut Workspace<f64>) {
    let mut frame = Frame::start(chain);
    for (link, axis) in chain.links.iter().zip(&mut workspace.axes) {
        let (s, c) = link.theta_sin_cos;
        let mut turn = [s, c];
        if !link.prismatic {
            let (sine, cosine) = f64::sin_cos(value_of(chain, link, q));
            turn = [sine * c + cosine * s, cosine * c - sine * s];
        }
        *axis = Axis { origin: frame.position, direction: frame.z };
        frame = over(chain, link, q, turn, frame);
    }
    workspace.frame = frame;
}

/// [`forward`] for those who need the last frame alone, and know it well enough with an
/// error of [`turns_each`]'s size: the axes are left as they were.
#[inline(always)]
pub fn forward_frame<R: Real>(chain: &Compiled, q: &[R], workspace: &mut Workspace<R>) {
    // The commonest arms' angles are turned into sines and cosines all at once.
    match chain.links.len() {
        6 => last_frame::<R, 6>(chain, q, workspace),
        7 => last_frame::<R, 7>(chain, q, workspace),
        _ => last_frame::<R, 4>(chain, q, workspace),
    }
}

/// [`forward_frame`] with the sines and cosines of so many joints at a time.
#[inline(always)]
fn last_frame<R: Real, const N: usize>(chain: &Compiled, q: &[R], workspace: &mut Workspace<R>) {
    let (groups, rest) = chain.links.as_chunks::<N>();
    let mut frame = Frame::start(chain);
    for group in groups {
        frame = after_each(chain, group, q, frame);
    }
    for link in rest.as_chunks::<1>().0 {
        frame = after_each(chain, link, q, frame);
    }
    workspace.frame = frame;
}

/// The frame after some more joints, whose sines and cosines are worked out in step.
#[inline(always)]
fn after_each<R: Real, const N: usize>(
    chain: &Compiled,
    links: &[Link; N],
    q: &[R],
    mut frame: Frame<R>,
) -> Frame<R> {
    let mut angles = [R::zero(); N];
    match q.first_chunk::<N>() {
        Some(q) if chain.plain && chain.dof == N => {
            for i in 0..N {
                angles[i] = q[i] + R::splat(links[i].theta);
            }
        }
        _ => {
            for i in 0..N {
                angles[i] = angle_of(chain, &links[i], q);
            }
        }
    }
    let (sines, cosines) = turns_each(&angles);
    for i in 0..N {
        frame = over(chain, &links[i], q, [sines[i], cosines[i]], frame);
    }
    frame
}

/// The frame of a joint while a pass goes along the chain: its axes and its origin.
#[derive(Debug, Clone, Copy)]
pub struct Frame<R> {
    x: V3<R>,
    y: V3<R>,
    z: V3<R>,
    position: V3<R>,
}

impl<R: Real> Frame<R> {
    /// The frame before the first joint.
    #[inline(always)]
    pub fn start(chain: &Compiled) -> Self {
        let start = &chain.start_rotation;
        Self {
            x: splat3(start[0]),
            y: splat3(start[1]),
            z: splat3(start[2]),
            position: splat3(chain.start_position),
        }
    }

    /// The frame after some more of the moving joints, so that postures with the same first
    /// joints can share those.
    #[inline(always)]
    pub fn after(self, chain: &Compiled, links: std::ops::Range<usize>, q: &[R]) -> Self {
        let mut frame = self;
        for link in &chain.links[links] {
            frame = over(chain, link, q, turn_of(chain, link, q), frame);
        }
        frame
    }

    /// The same after one joint, of whose angle the sine and cosine are known.
    #[inline(always)]
    pub(super) fn after_turn(self, chain: &Compiled, link: &Link, q: &[R], turn: [R; 2]) -> Self {
        over(chain, link, q, turn, self)
    }

    /// Axes (columns).
    #[inline(always)]
    pub fn axes(&self) -> [V3<R>; 3] {
        [self.x, self.y, self.z]
    }

    /// A point given in this frame, in the world.
    #[inline(always)]
    pub fn point(&self, t: [f64; 3]) -> V3<R> {
        let p = axpy(self.x, R::splat(t[0]), self.position);
        let p = axpy(self.y, R::splat(t[1]), p);
        axpy(self.z, R::splat(t[2]), p)
    }
}

/// The value that moves a joint, rad or m.
#[inline(always)]
fn value_of<R: Real>(chain: &Compiled, link: &Link, q: &[R]) -> R {
    let value = q[link.variable];
    if chain.simple { value } else { value * R::splat(link.multiplier) }
}

/// A joint's angle.
#[inline(always)]
pub(super) fn angle_of<R: Real>(chain: &Compiled, link: &Link, q: &[R]) -> R {
    let offset = R::splat(link.theta);
    if link.prismatic { offset } else { value_of(chain, link, q) + offset }
}

/// Sine and cosine of a joint's angle.
#[inline(always)]
fn turn_of<R: Real>(chain: &Compiled, link: &Link, q: &[R]) -> [R; 2] {
    let (s, c) = if link.prismatic {
        let (s, c) = link.theta_sin_cos;
        (R::splat(s), R::splat(c))
    } else {
        angle_of(chain, link, q).sin_cos()
    };
    [s, c]
}

/// The frame after one joint more, whose angle has this sine and cosine.
#[inline(always)]
fn over<R: Real>(
    chain: &Compiled,
    link: &Link,
    q: &[R],
    [s, c]: [R; 2],
    frame: Frame<R>,
) -> Frame<R> {
    let Frame { x: x0, y: y0, mut z, position: mut p } = frame;
    let mut x = blend(x0, c, y0, s);
    // Asked of the bits, which costs less than asking of the numbers.
    if link.prismatic {
        p = axpy(z, value_of(chain, link, q) + R::splat(link.d), p);
    } else if link.d.to_bits() != 0 {
        p = axpy(z, R::splat(link.d), p);
    }
    if link.a.to_bits() != 0 {
        p = axpy(x, R::splat(link.a), p);
    }
    // The other turned axis this way round or that, as it is needed.
    let y;
    match link.twist {
        Twist::Zero => y = blend(y0, c, x0, -s),
        Twist::Half => {
            y = difference(x0, s, y0, c);
            z = negate(z);
        }
        Twist::Quarter => (y, z) = (z, difference(x0, s, y0, c)),
        Twist::Angle(sine, cosine) => {
            let across = blend(y0, c, x0, -s);
            let (s, c) = (R::splat(sine), R::splat(cosine));
            (y, z) = (blend(across, c, z, s), blend(z, c, across, -s));
        }
        Twist::Full(columns) => {
            let axes = [x, blend(y0, c, x0, -s), z];
            p = axpy(axes[1], R::splat(link.b), p);
            x = turn(axes, columns[0]);
            y = turn(axes, columns[1]);
            z = turn(axes, columns[2]);
        }
    }
    Frame { x, y, z, position: p }
}
