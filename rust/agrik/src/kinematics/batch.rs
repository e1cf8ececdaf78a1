//! Poses and Jacobians of many configurations, several in step.

use smallvec::{SmallVec, smallvec};

use super::fk::{angle_of, forward_far};
use super::{Frame, PerJoint, Workspace, columns, forward};
use crate::chain::{Chain, JointKind, Tail, Variable};
use crate::lanes::{Kernel, Level, Real, V3, WIDEST, dispatch, dispatch_single};

/// Angles beyond this lose digits in sums, rad.
const MANY: f64 = 100.0;
/// Numbers of one pose.
const POSE: usize = 16;

/// Tool poses of all rows of `q` (`dof` numbers each), 16 numbers a pose, row by row.
pub fn tool_poses(chain: &Chain, q: &[f64], out: &mut [f64]) {
    run_rows(q.len() / chain.dof(), Poses { chain, q, out });
    let compiled = chain.compiled();
    far_rows(chain, q, |row, workspace| {
        let pose = pose_rows(workspace, &compiled.tail);
        out[row * POSE..(row + 1) * POSE].copy_from_slice(&pose);
    });
}

/// Hands over the rows in which a joint turns by more than rounded sums allow.
fn far_rows(chain: &Chain, q: &[f64], mut write: impl FnMut(usize, &Workspace<f64>)) {
    // Not a number is not far; mostly nothing is.
    if !q.iter().any(|x| x.abs() > MANY) {
        return;
    }
    let mut workspace = Workspace::new(chain.compiled());
    for (row, q) in q.chunks_exact(chain.dof()).enumerate() {
        let turns = |v: &Variable| v.kind != JointKind::Prismatic;
        if chain.variables().iter().zip(q).any(|(v, x)| turns(v) && x.abs() > MANY) {
            forward_far(chain.compiled(), q, &mut workspace);
            write(row, &workspace);
        }
    }
}

/// Geometric Jacobians of all rows of `q`, `6 * dof` numbers each, row by row: linear
/// velocity of the tool point, then angular velocity, both in the world frame.
pub fn tool_jacobians(chain: &Chain, q: &[f64], out: &mut [f64]) {
    run_rows(q.len() / chain.dof(), Jacobians { chain, q, out });
    let size = 6 * chain.dof();
    far_rows(chain, q, |row, workspace| {
        let mut sums = vec![0.0; size];
        add_columns(chain, workspace, &mut sums);
        out[row * size..(row + 1) * size].copy_from_slice(&sums);
    });
}

/// Adds the columns of a configuration to a Jacobian, row by row.
#[inline(always)]
fn add_columns<R: Real>(chain: &Chain, workspace: &Workspace<R>, sums: &mut [R]) {
    let (compiled, dof) = (chain.compiled(), chain.dof());
    let point = workspace.tool_point(compiled.tail.translation);
    columns(compiled, workspace, point, |variable, linear, angular| {
        for k in 0..3 {
            sums[k * dof + variable] += linear[k];
            sums[(k + 3) * dof + variable] += angular[k];
        }
    });
}

/// Numbers of one frame of [`moving_frames`].
pub const FRAME: usize = 12;

/// Where the frames of all moving joints are at all rows of `q`: of each row one frame after
/// another along [`Compiled::links`](crate::chain::Compiled), [`FRAME`] numbers each, the rotation
/// row by row and then the origin (m).
///
/// A frame moves with its joint, and lies where the axis of the next one does.
pub fn moving_frames(chain: &Chain, q: &[f64], out: &mut [f64]) {
    if q.len() == chain.dof() {
        dispatch(Level::in_use(), LoneFrames { chain, q, out });
    } else {
        run_rows(q.len() / chain.dof(), Frames { chain, q, out });
    }
}

/// [`moving_frames`] of up to [`WIDEST`] rows, side by side: place `i` of an entry is that of row
/// `i`, of the last row where there are fewer; number `k` of frame `j` is entry `FRAME * j + k`.
/// To the bit the same numbers.
pub fn frames_abreast(chain: &Chain, q: &[f64], out: &mut [[f64; WIDEST]]) {
    if q.len() == chain.dof() {
        let mut one: SmallVec<[f64; 8 * FRAME]> = smallvec![0.0; out.len()];
        moving_frames(chain, q, &mut one);
        for (to, x) in out.iter_mut().zip(one) {
            *to = [x; WIDEST];
        }
    } else {
        dispatch(Level::in_use(), Abreast { chain, q, out });
    }
}

/// Runs a kernel over rows; a pass over all lanes does not pay for one or two of them.
pub(crate) fn run_rows<K: Kernel>(rows: usize, kernel: K) -> K::Output {
    let level = Level::in_use();
    if rows <= 2 { dispatch_single(level, kernel) } else { dispatch(level, kernel) }
}

struct Poses<'a> {
    chain: &'a Chain,
    q: &'a [f64],
    out: &'a mut [f64],
}

impl Kernel for Poses<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Real>(self) {
        let compiled = self.chain.compiled();
        let dof = compiled.dof;
        let mut workspace = Workspace::<R>::new(compiled);
        let mut q = vec![R::zero(); dof];
        let groups = self.q.chunks(dof * R::WIDTH).zip(self.out.chunks_mut(POSE * R::WIDTH));
        for (from, to) in groups {
            let rows = from.len() / dof;
            load_rows(from, dof, rows, &mut q);
            forward(compiled, &q, &mut workspace);
            unload_rows(&pose_rows(&workspace, &compiled.tail), to);
        }
    }
}

/// The 16 numbers of the tool's pose, row by row.
#[inline(always)]
fn pose_rows<R: Real>(workspace: &Workspace<R>, tail: &Tail) -> [R; POSE] {
    let [x, y, z]: [V3<R>; 3] = workspace.tool_axes(&tail.rotation);
    let p = workspace.tool_point(tail.translation);
    let (zero, one) = (R::zero(), R::splat(1.0));
    [x[0], y[0], z[0], p[0], x[1], y[1], z[1], p[1], x[2], y[2], z[2], p[2], zero, zero, zero, one]
}

struct Frames<'a> {
    chain: &'a Chain,
    q: &'a [f64],
    out: &'a mut [f64],
}

impl Kernel for Frames<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Real>(self) {
        let compiled = self.chain.compiled();
        let dof = compiled.dof;
        let size = FRAME * compiled.links.len();
        // On the stack for most arms, as a lone posture is what solvers ask about.
        let mut q: PerJoint<R> = smallvec![R::zero(); dof];
        let mut frames: SmallVec<[R; 8 * FRAME]> = smallvec![R::zero(); size];
        let groups = self.q.chunks(dof * R::WIDTH).zip(self.out.chunks_mut(size * R::WIDTH));
        for (from, to) in groups {
            let rows = from.len() / dof;
            load_rows(from, dof, rows, &mut q);
            let mut frame = Frame::start(compiled);
            for (i, one) in frames.as_chunks_mut::<FRAME>().0.iter_mut().enumerate() {
                frame = frame.after(compiled, i..i + 1, &q);
                *one = frame_numbers(&frame);
            }
            unload_rows(&frames, to);
        }
    }
}

struct Abreast<'a> {
    chain: &'a Chain,
    q: &'a [f64],
    out: &'a mut [[f64; WIDEST]],
}

impl Kernel for Abreast<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Real>(self) {
        let compiled = self.chain.compiled();
        let dof = compiled.dof;
        let mut q: PerJoint<R> = smallvec![R::zero(); dof];
        let mut lanes = 0;
        for from in self.q.chunks(dof * R::WIDTH) {
            load_rows(from, dof, from.len() / dof, &mut q);
            let mut frame = Frame::start(compiled);
            for (i, to) in self.out.as_chunks_mut::<FRAME>().0.iter_mut().enumerate() {
                frame = frame.after(compiled, i..i + 1, &q);
                for (to, x) in to.iter_mut().zip(frame_numbers(&frame)) {
                    x.store(&mut to[lanes..]);
                }
            }
            lanes += R::WIDTH;
        }
        // Lanes beyond the last group repeat it as well.
        for to in self.out.iter_mut().filter(|_| lanes < WIDEST) {
            let last = to[lanes - 1];
            to[lanes..].fill(last);
        }
    }
}

/// The frames of one row, with its angles side by side in the lanes: to the bit what the lanes
/// of [`Frames`] hold.
struct LoneFrames<'a> {
    chain: &'a Chain,
    q: &'a [f64],
    out: &'a mut [f64],
}

impl Kernel for LoneFrames<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Real>(self) {
        let compiled = self.chain.compiled();
        let q: PerJoint<R::Single> = self.q.iter().map(|x| R::Single::splat(*x)).collect();
        let mut frame = Frame::<R::Single>::start(compiled);
        let links = compiled.links.chunks(R::WIDTH).zip(self.out.chunks_mut(R::WIDTH * FRAME));
        for (links, out) in links {
            let mut angles = R::zero();
            for (lane, link) in links.iter().enumerate() {
                angles.set_lane(lane, angle_of(compiled, link, &q).lane(0));
            }
            let (sines, cosines) = angles.sin_cos();
            for (lane, (link, out)) in links.iter().zip(out.chunks_mut(FRAME)).enumerate() {
                let (s, c) = if link.prismatic {
                    link.theta_sin_cos
                } else {
                    (sines.lane(lane), cosines.lane(lane))
                };
                let turn = [R::Single::splat(s), R::Single::splat(c)];
                frame = frame.after_turn(compiled, link, &q, turn);
                for (to, x) in out.iter_mut().zip(frame_numbers(&frame)) {
                    *to = x.lane(0);
                }
            }
        }
    }
}

/// The numbers of a frame, as [`moving_frames`] has them.
#[inline(always)]
fn frame_numbers<R: Real>(frame: &Frame<R>) -> [R; FRAME] {
    let [x, y, z] = frame.axes();
    let p = frame.point([0.0; 3]);
    [x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2], p[0], p[1], p[2]]
}

struct Jacobians<'a> {
    chain: &'a Chain,
    q: &'a [f64],
    out: &'a mut [f64],
}

impl Kernel for Jacobians<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Real>(self) {
        let compiled = self.chain.compiled();
        let dof = compiled.dof;
        let size = 6 * dof;
        let mut workspace = Workspace::<R>::new(compiled);
        let mut q = vec![R::zero(); dof];
        let mut sums = vec![R::zero(); size];
        let groups = self.q.chunks(dof * R::WIDTH).zip(self.out.chunks_mut(size * R::WIDTH));
        for (from, to) in groups {
            let rows = from.len() / dof;
            load_rows(from, dof, rows, &mut q);
            forward(compiled, &q, &mut workspace);
            sums.fill(R::zero());
            add_columns(self.chain, &workspace, &mut sums);
            unload_rows(&sums, to);
        }
    }
}

/// Puts `rows` rows of joint values into the lanes; lanes without a row repeat the last.
#[inline(always)]
pub(crate) fn load_rows<R: Real>(from: &[f64], dof: usize, rows: usize, q: &mut [R]) {
    let whole = if rows == R::WIDTH { dof - dof % R::WIDTH } else { 0 };
    let (squares, rest) = q.split_at_mut(whole);
    for (k, values) in squares.chunks_exact_mut(R::WIDTH).enumerate() {
        for (row, value) in values.iter_mut().enumerate() {
            *value = R::load(&from[row * dof + k * R::WIDTH..]);
        }
        R::transpose(values);
    }
    for (i, x) in rest.iter_mut().enumerate() {
        for lane in 0..R::WIDTH {
            x.set_lane(lane, from[lane.min(rows - 1) * dof + whole + i]);
        }
    }
}

/// Writes what the lanes hold row by row, as many numbers a row as there are values.
#[inline(always)]
pub(crate) fn unload_rows<R: Real>(values: &[R], to: &mut [f64]) {
    let size = values.len();
    let whole = if to.len() == size * R::WIDTH { size - size % R::WIDTH } else { 0 };
    let (squares, rest) = values.split_at(whole);
    for (k, values) in squares.chunks_exact(R::WIDTH).enumerate() {
        let mut square = [R::zero(); WIDEST];
        square[..R::WIDTH].copy_from_slice(values);
        R::transpose(&mut square);
        for (row, value) in square[..R::WIDTH].iter().enumerate() {
            value.store(&mut to[row * size + k * R::WIDTH..]);
        }
    }
    for (row, to) in to.chunks_exact_mut(size).enumerate() {
        for (to, value) in to[whole..].iter_mut().zip(rest) {
            *to = value.lane(row);
        }
    }
}
