//! Forward kinematics and Newton's steps of an arm given by its axes, in lanes.

use super::mirrors::{mirror, reflect, unrolled};
use super::rigid::Rigid;
use super::screws::Screws;
use crate::lanes::{Real, V3, axpy, blend, cross, dot, scale, splat3, sub};

/// From one joint's frame, turned, to the next one's: about x, after a shift.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Link {
    shift: V3<f64>,
    sine: f64,
    cosine: f64,
    /// Added to the joint's value, rad.
    offset: f64,
    /// Its sine and cosine.
    resting: (f64, f64),
}

/// An arm of `N` joints that turn.
#[derive(Debug, Clone, PartialEq)]
pub struct Serial<const N: usize> {
    start: Rigid<f64>,
    links: [Link; N],
    tail: Rigid<f64>,
}

/// A posture on its way to a goal.
#[derive(Clone, Copy)]
pub struct Posture<R, const N: usize> {
    /// Joint values, rad.
    pub q: [R; N],
    /// Squared distance and squared chord left, together.
    pub left: R,
}

/// Arm lengths and rad that a joint alone moves the tool below which it moves nothing.
const FLAT: f64 = 1e-8;
/// No step turns a joint by more, rad.
const LONGEST: f64 = 0.5;

impl<const N: usize> Serial<N> {
    /// The arm of a list of as many axes.
    pub fn new(screws: &Screws) -> Option<Self> {
        let screws = screws.gathered();
        if screws.joints.len() != N {
            return None;
        }
        let mut frames = Vec::with_capacity(N);
        let mut x_before: V3<f64> = [1.0, 0.0, 0.0];
        for k in 0..N {
            let z = screws.joints[k].axis;
            // x across this axis and the next one, so that only a turn about x is left.
            let across = screws.joints.get(k + 1).map_or([0.0; 3], |next| cross(z, next.axis));
            let guess = if dot(across, across) > 1e-20 { across } else { x_before };
            let mut x = flat(guess, z);
            if dot(x, x) < 1e-2 * dot(guess, guess) {
                x = flat(if z[0].abs() < 0.8 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] }, z);
            }
            let x = scale(x, 1.0 / dot(x, x).sqrt());
            x_before = x;
            frames.push(Rigid { axes: [x, cross(z, x), z], shift: screws.joints[k].point });
        }
        let mut links =
            [Link { shift: [0.0; 3], sine: 0.0, cosine: 1.0, offset: 0.0, resting: (0.0, 1.0) }; N];
        // Each link's frame before its joint turns is the one before, tilted.
        let mut resting = frames[0];
        for k in 0..N {
            let here = frames[k];
            let (x, y) = (resting.axes[0], resting.axes[1]);
            links[k].offset = dot(here.axes[0], y).atan2(dot(here.axes[0], x));
            links[k].resting = links[k].offset.sin_cos();
            if let Some(next) = frames.get(k + 1) {
                let z = next.axes[2];
                let (sine, cosine) = (-dot(z, here.axes[1]), dot(z, here.axes[2]));
                let size = (sine * sine + cosine * cosine).sqrt();
                (links[k].sine, links[k].cosine) = (sine / size, cosine / size);
                links[k].shift = here.turn_back(sub(next.shift, here.shift));
                let (sine, cosine) = (links[k].sine, links[k].cosine);
                let y = axpy(here.axes[1], cosine, scale(here.axes[2], sine));
                let z = axpy(here.axes[2], cosine, scale(here.axes[1], -sine));
                resting = Rigid { axes: [here.axes[0], y, z], shift: next.shift };
            }
        }
        let tail = frames[N - 1].inverse().after(&screws.tool);
        Some(Self { start: frames[0], links, tail })
    }

    /// Tool pose, and direction and place of each axis.
    #[inline(always)]
    pub fn forward<R: Real>(&self, q: &[R; N]) -> (Rigid<R>, [V3<R>; N], [V3<R>; N]) {
        let mut turns = [(R::zero(), R::zero()); N];
        for (k, link) in self.links.iter().enumerate() {
            turns[k] = (q[k] + R::splat(link.offset)).sin_cos();
        }
        self.walk(&turns)
    }

    /// The same of turns from where the links' common normals are.
    #[inline(always)]
    fn walk<R: Real>(&self, turns: &[(R, R); N]) -> (Rigid<R>, [V3<R>; N], [V3<R>; N]) {
        let mut frame = Rigid::<R>::splat(&self.start);
        let (mut directions, mut places) = ([[R::zero(); 3]; N], [[R::zero(); 3]; N]);
        for (k, link) in self.links.iter().enumerate() {
            (directions[k], places[k]) = (frame.axes[2], frame.shift);
            let (s, c) = turns[k];
            let [x, y, z] = frame.axes;
            let (x, y) = (blend(x, c, y, s), blend(y, c, x, -s));
            frame.axes = [x, y, z];
            if k + 1 < N {
                frame.shift = frame.apply(splat3(link.shift));
                let (s, c) = (R::splat(link.sine), R::splat(link.cosine));
                frame.axes = [x, blend(y, c, z, s), blend(z, c, y, -s)];
            }
        }
        (frame.after(&Rigid::splat(&self.tail)), directions, places)
    }

    /// What is left to a goal, squared as [`Self::errors`] has it, at joint values given as sine
    /// and cosine.
    #[inline(always)]
    pub fn left<R: Real>(&self, q: &[(R, R); N], goal: &Rigid<R>) -> R {
        let mut turns = *q;
        for (k, link) in self.links.iter().enumerate() {
            let (s, c) = (R::splat(link.resting.0), R::splat(link.resting.1));
            let (sine, cosine) = q[k];
            turns[k] = (sine.mul_add(c, cosine * s), cosine.mul_add(c, -(sine * s)));
        }
        left(&self.walk(&turns).0, goal)
    }

    /// What is left to a goal (ways and turns) and squared, and the Jacobian's columns at `q`.
    #[inline(always)]
    pub fn errors<R: Real>(&self, q: &[R; N], goal: &Rigid<R>) -> ([R; 6], R, [[R; 6]; N]) {
        let (tool, directions, places) = self.forward(q);
        let way = sub(goal.shift, tool.shift);
        let mut turn = [R::zero(); 3];
        for k in 0..3 {
            let c = cross(tool.axes[k], goal.axes[k]);
            turn = axpy(c, R::splat(0.5), turn);
        }
        let square = left(&tool, goal);
        let mut columns = [[R::zero(); 6]; N];
        for (k, column) in columns.iter_mut().enumerate() {
            let linear = cross(directions[k], sub(tool.shift, places[k]));
            let w = directions[k];
            *column = [linear[0], linear[1], linear[2], w[0], w[1], w[2]];
        }
        ([way[0], way[1], way[2], turn[0], turn[1], turn[2]], square, columns)
    }
}

impl Serial<6> {
    /// One of Newton's steps, not longer than half a radian in any joint.
    #[inline(always)]
    pub fn step<R: Real>(&self, error: &[R; 6], columns: &[[R; 6]; 6]) -> [R; 6] {
        let mut change = solve(*columns, *error);
        let mut longest = R::zero();
        for x in &change {
            longest = longest.max(x.abs());
        }
        let factor = R::splat(LONGEST) / longest.max(R::splat(LONGEST));
        for x in &mut change {
            *x *= factor;
        }
        change
    }

    /// Newton's steps, at most so many, from where a posture is: until all lanes are as near as
    /// rounding lets them come, or some lanes come no nearer.
    #[inline(always)]
    pub fn approach<R: Real>(
        &self,
        start: [R; 6],
        goal: &Rigid<R>,
        steps: usize,
        fine: f64,
    ) -> Posture<R, 6> {
        let mut q = start;
        let mut best = Posture { q, left: R::splat(f64::INFINITY) };
        // A lane that has arrived stays as it is, whatever its neighbours need.
        let mut active = lanes::<R>();
        for step in 0..=steps {
            let (error, left, columns) = self.errors(&q, goal);
            let better = R::and(left.lt(best.left), R::mask_from_bits(active));
            best.left = R::select(better, left, best.left);
            for k in 0..6 {
                best.q[k] = R::select(better, q[k], best.q[k]);
            }
            active &= !R::bits(best.left.le(R::splat(fine * fine)));
            if step == steps || active == 0 {
                break;
            }
            let change = self.step(&error, &columns);
            for k in 0..6 {
                q[k] += change[k];
            }
        }
        best
    }
}

/// Squared distance and squared chord between a tool pose and a goal, together.
#[inline(always)]
fn left<R: Real>(tool: &Rigid<R>, goal: &Rigid<R>) -> R {
    let way = sub(goal.shift, tool.shift);
    let mut square = dot(way, way);
    for k in 0..3 {
        let d = sub(goal.axes[k], tool.axes[k]);
        square += R::splat(0.5) * dot(d, d);
    }
    square
}

/// All lanes, a bit each.
#[inline(always)]
pub fn lanes<R: Real>() -> u32 {
    u32::MAX >> (32 - R::WIDTH as u32)
}

/// The solution of six equations in six unknowns, columns given; by mirrors.
#[inline(always)]
// The last of written out loops have nothing to go through.
#[allow(clippy::reversed_empty_ranges)]
fn solve<R: Real>(mut columns: [[R; 6]; 6], mut right: [R; 6]) -> [R; 6] {
    unrolled!(K in [0 1 2 3 4 5] {
        let normal = mirror::<R, 6, K>(&mut columns[K]);
        for j in K + 1..6 {
            reflect::<R, 6, K>(&normal, &mut columns[j]);
        }
        reflect::<R, 6, K>(&normal, &mut right);
    });
    // A joint that moves nothing of its own stays where it is.
    unrolled!(K in [5 4 3 2 1 0] {
        let end = columns[K][K];
        let flat = end.abs().lt(R::splat(FLAT));
        let inverse = R::splat(1.0) / R::select(flat, R::splat(1.0), end);
        right[K] = R::select(flat, R::zero(), right[K] * inverse);
        for i in 0..K {
            right[i] = columns[K][i].neg_mul_add(right[K], right[i]);
        }
    });
    right
}

/// The part of a vector across a unit vector.
fn flat(v: V3<f64>, z: V3<f64>) -> V3<f64> {
    axpy(z, -dot(z, v), v)
}

#[cfg(test)]
mod tests {
    use super::super::screws::Screw;
    use super::*;
    use crate::random::Sequence;

    fn arm(random: &mut Sequence) -> Screws {
        let mut vector = || [0; 3].map(|_| random.normal());
        let mut joint = || {
            let (v, point) = (vector(), vector());
            Screw { axis: scale(v, 1.0 / dot(v, v).sqrt()), point }
        };
        let joints = (0..6).map(|_| joint()).collect();
        Screws { joints, tool: Rigid { shift: vector(), ..Rigid::identity() } }
    }

    #[test]
    fn angles_and_their_sines_and_cosines_miss_a_goal_by_the_same() {
        let mut random = Sequence::new(8);
        for _ in 0..50 {
            let screws = arm(&mut random);
            let serial = Serial::<6>::new(&screws).unwrap();
            let q: [f64; 6] = std::array::from_fn(|_| 6.0 * random.uniform() - 3.0);
            let goal = screws.pose(&std::array::from_fn::<f64, 6, _>(|_| random.uniform()));
            let (_, far, _) = serial.errors(&q, &goal);
            let left = serial.left(&q.map(f64::sin_cos), &goal);
            assert!((left - far).abs() < 1e-12 * far, "{left} {far}");
            assert!(serial.left(&q.map(f64::sin_cos), &screws.pose(&q)) < 1e-26);
        }
    }

    #[test]
    fn a_step_solves_six_equations() {
        let mut random = Sequence::new(9);
        for _ in 0..50 {
            let columns = [[0; 6]; 6].map(|column| column.map(|_| random.normal()));
            let x = [0; 6].map(|_| random.normal());
            let mut right = [0.0; 6];
            for (column, x) in columns.iter().zip(x) {
                for (sum, entry) in right.iter_mut().zip(column) {
                    *sum += entry * x;
                }
            }
            let found = solve(columns, right);
            assert!(found.iter().zip(x).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?} {x:?}");
        }
    }

    #[test]
    fn lines_that_pass_by_do_not_meet() {
        let mut random = Sequence::new(10);
        for _ in 0..50 {
            let mut screws = arm(&mut random);
            assert!(screws.pass_by(3..6, 1e-7));
            let point = screws.joints[3].point;
            for joint in &mut screws.joints[4..] {
                joint.point = axpy(joint.axis, random.normal(), point);
            }
            assert!(!screws.pass_by(3..6, 1e-12));
        }
    }
}
