//! How joint values follow their target, by the implicit function theorem.
//!
//! At an answer the error's rows that count, `A`, vanish. They stay so where `A J dq = A dt` for a
//! displacement `dt` of the target (a way, and a turn about the world's axes); of all changes
//! that do it the smallest is `dq = (A J)^+ A dt`. A number `p` of the arm that displaces the tool
//! by `J_p dp` is answered by `dq = -(A J)^+ A J_p dp`.

use nalgebra::{DMatrix, IsometryMatrix3};
use smallvec::smallvec;

use super::linear::Factored;
use super::step::{dot, gram};
use crate::call::{Aim, Measure};
use crate::chain::{Chain, DhConvention, Joint, JointKind};
use crate::kinematics::{PerJoint, Workspace, columns, forward, load_rows, run_rows, unload_rows};
use crate::lanes::{self, Kernel, Real, V3, axpy, blend, cross, splat3, sub};
use crate::task::{Goal, Rows, axis_goal, rotation_scale};

/// Numbers of a displacement: a way, m, and a turn, rad.
pub const TWIST: usize = 6;
/// Numbers of a row of Denavit and Hartenberg.
pub const DH: usize = 4;

/// Most joints of an arm that has fewer than a pose has rows.
const FEW: usize = 5;
/// A row of `A J` whose square is left with less than this share by the rows before it: products
/// of it would lose half of the digits.
const LOST: f64 = 1e-8;
/// A row below this share of the largest one does not count.
const FREE: f64 = 1e-28;
/// Singular values below this share of the largest one are directions the arm cannot go.
const STUCK: f64 = 1e-7;

/// Derivatives of answers by their targets.
#[derive(Debug, Clone, Copy)]
pub struct Sensitivity<'a> {
    /// The arm.
    pub chain: &'a Chain,
    /// What was to be reached.
    pub aim: &'a Aim,
    /// The target's turn matters; not where all targets share one direction.
    pub turns: bool,
}

impl Sensitivity<'_> {
    /// The derivatives of joint values at answers `q` (`dof` numbers a row): of each value those
    /// by the [`TWIST`] numbers of a displacement, rad or m per m and rad.
    pub fn by_target(&self, q: &[f64], out: &mut [f64]) {
        run_rows(q.len() / self.chain.dof(), Twists { of: *self, q, out, dh: None });
    }

    /// The derivatives at answers by the rows of a chain that was made of such: of each value
    /// those by `a`, `alpha`, `d` and `theta` of each row.
    pub fn by_dh(&self, convention: DhConvention, q: &[f64], out: &mut [f64]) {
        let rows = DhRows::new(self.chain, convention);
        // A number of the arm turns the tool, whatever the targets have in common.
        let of = Sensitivity { turns: true, ..*self };
        run_rows(q.len() / self.chain.dof(), Twists { of, q, out, dh: Some(&rows) });
    }
}

/// The rows of a chain, ready to be gone along.
struct DhRows {
    convention: DhConvention,
    base: Constant,
    rows: Vec<DhRow>,
}

struct DhRow {
    /// What moves it: which entry of `q`, and whether it slides.
    motion: Option<(usize, bool)>,
    origin: Constant,
    after: Constant,
}

/// A transform: its axes, and its origin.
struct Constant {
    axes: [[f64; 3]; 3],
    origin: [f64; 3],
}

impl From<&IsometryMatrix3<f64>> for Constant {
    fn from(transform: &IsometryMatrix3<f64>) -> Self {
        let rotation = transform.rotation.matrix();
        let origin = transform.translation.vector.into();
        Self { axes: [0, 1, 2].map(|j| [0, 1, 2].map(|i| rotation[(i, j)])), origin }
    }
}

impl DhRows {
    fn new(chain: &Chain, convention: DhConvention) -> Self {
        let row = |joint: &Joint| {
            let variable = chain.variables().iter().position(|v| v.name == joint.name);
            DhRow {
                motion: variable.map(|variable| (variable, joint.kind == JointKind::Prismatic)),
                origin: Constant::from(&joint.origin),
                after: Constant::from(&joint.after),
            }
        };
        let rows = chain.joints().iter().map(row).collect();
        Self { convention, base: Constant::from(chain.base()), rows }
    }

    /// Writes the derivatives by the rows from those by displacements of the target.
    #[inline(always)]
    fn write<R: Real>(&self, q: &[R], point: V3<R>, twists: &[R], out: &mut [R]) {
        let [x, y, z] = &self.base.axes;
        let axes = [splat3(*x), splat3(*y), splat3(*z)];
        let start = Placed { axes, origin: splat3(self.base.origin) };
        let width = self.rows.len() * DH;
        let mut before = start;
        for (k, row) in self.rows.iter().enumerate() {
            let after = before.then(&row.origin).moved(row.motion, q).then(&row.after);
            let (x, z) = match self.convention {
                DhConvention::Standard => (&after, &before),
                DhConvention::Modified => (&before, &after),
            };
            let (along_x, along_z) = (x.axes[0], z.axes[2]);
            let about_x = cross(along_x, sub(point, x.origin));
            let about_z = cross(along_z, sub(point, z.origin));
            for (twist, out) in twists.chunks_exact(TWIST).zip(out.chunks_exact_mut(width)) {
                let way = [twist[0], twist[1], twist[2]];
                let turn = [twist[3], twist[4], twist[5]];
                // A tool that is moved on has to come back.
                out[DH * k] = -lanes::dot(way, along_x);
                out[DH * k + 1] = -(lanes::dot(way, about_x) + lanes::dot(turn, along_x));
                out[DH * k + 2] = -lanes::dot(way, along_z);
                out[DH * k + 3] = -(lanes::dot(way, about_z) + lanes::dot(turn, along_z));
            }
            before = after;
        }
    }
}

/// A frame in the world.
#[derive(Clone, Copy)]
struct Placed<R> {
    axes: [V3<R>; 3],
    origin: V3<R>,
}

impl<R: Real> Placed<R> {
    #[inline(always)]
    fn then(&self, next: &Constant) -> Self {
        let none = [R::zero(); 3];
        let [x, y, z] = &next.axes;
        Self {
            axes: [self.along(x, none), self.along(y, none), self.along(z, none)],
            origin: self.along(&next.origin, self.origin),
        }
    }

    /// What is given along the frame's axes, and something more.
    #[inline(always)]
    fn along(&self, v: &[f64; 3], more: V3<R>) -> V3<R> {
        let sum = axpy(self.axes[2], R::splat(v[2]), more);
        let sum = axpy(self.axes[1], R::splat(v[1]), sum);
        axpy(self.axes[0], R::splat(v[0]), sum)
    }

    /// The frame after the motion of a joint along or about its z.
    #[inline(always)]
    fn moved(&self, motion: Option<(usize, bool)>, q: &[R]) -> Self {
        let [x, y, z] = self.axes;
        match motion {
            None => *self,
            Some((variable, true)) => {
                Self { axes: self.axes, origin: axpy(z, q[variable], self.origin) }
            }
            Some((variable, false)) => {
                let (s, c) = q[variable].sin_cos();
                let axes = [blend(x, c, y, s), blend(y, c, x, -s), z];
                Self { axes, origin: self.origin }
            }
        }
    }
}

struct Twists<'a> {
    of: Sensitivity<'a>,
    q: &'a [f64],
    out: &'a mut [f64],
    /// Derivatives by these are wanted.
    dh: Option<&'a DhRows>,
}

impl Kernel for Twists<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Real>(self) {
        let scale = rotation_scale(self.of.chain.reach().radius);
        let scale = if scale > 0.0 { scale } else { 1.0 };
        match self.of.aim.measure(scale) {
            Measure::Position(rows) => self.rows::<R, _, 3>(rows, None),
            Measure::Pose(rows) => self.rows::<R, _, 6>(rows, None),
            Measure::Axis(rows) => self.rows::<R, _, 5>(rows, Some(rows.axis)),
            Measure::Framed(rows) => self.rows::<R, _, 6>(rows, rows.axis),
        }
    }
}

impl Twists<'_> {
    #[inline(always)]
    fn rows<R: Real, T: Rows<R, M>, const M: usize>(self, task: T, axis: Option<[f64; 3]>) {
        let Sensitivity { chain, aim, turns } = self.of;
        let compiled = chain.compiled();
        let dof = compiled.dof;
        // A frame whose z is the tool's axis, in the last joint's.
        let frame = axis.map(|axis| axis_goal([0.0; 3], axis).axes);
        let mut workspace = Workspace::<R>::new(compiled);
        let mut q: PerJoint<R> = smallvec![R::zero(); dof];
        let mut moved: PerJoint<[R; M]> = smallvec![[R::zero(); M]; dof];
        let mut derivatives = vec![R::zero(); dof * TWIST];
        let size = dof * self.dh.map_or(TWIST, |dh| DH * dh.rows.len());
        let mut by_dh = vec![R::zero(); if self.dh.is_some() { size } else { 0 }];
        let groups = self.q.chunks(dof * R::WIDTH).zip(self.out.chunks_mut(size * R::WIDTH));
        for (from, to) in groups {
            let rows = from.len() / dof;
            load_rows(from, dof, rows, &mut q);
            forward(compiled, &q, &mut workspace);
            let position = workspace.tool_point(aim.tail().translation);
            // The target is where the tool is.
            let axes = match &frame {
                None => workspace.joint_axes(),
                Some(columns) => workspace.tool_axes(columns),
            };
            let goal = Goal { position, axes };
            let seen = task.look(&workspace, position, &goal);
            moved.fill([R::zero(); M]);
            columns(compiled, &workspace, position, |variable, linear, angular| {
                let column = task.column(&seen, &goal, linear, angular);
                for (sum, x) in moved[variable].iter_mut().zip(column) {
                    *sum += x;
                }
            });
            let wanted = displacements(&task, &seen, &goal, turns);
            let lost = if dof < M && dof <= FEW {
                fewer_joints(&moved, &wanted, &mut derivatives)
            } else {
                enough_joints(&moved, &wanted, &mut derivatives)
            };
            for lane in (0..rows).filter(|lane| lost & (1 << lane) != 0) {
                singular(&moved, &wanted, lane, &mut derivatives);
            }
            match self.dh {
                None => unload_rows(&derivatives, to),
                Some(dh) => {
                    dh.write(&q, position, &derivatives, &mut by_dh);
                    unload_rows(&by_dh, to);
                }
            }
        }
    }
}

/// What unit displacements of the target are in the task's rows.
#[inline(always)]
fn displacements<R: Real, T: Rows<R, M>, const M: usize>(
    task: &T,
    seen: &T::Seen,
    goal: &Goal<R>,
    turns: bool,
) -> [[R; M]; TWIST] {
    let none = [R::zero(); 3];
    let mut all = [[R::zero(); M]; TWIST];
    for (j, one) in all.iter_mut().enumerate() {
        let mut unit = none;
        unit[j % 3] = R::splat(1.0);
        if j < 3 {
            *one = task.column(seen, goal, unit, none);
        } else if turns {
            *one = task.column(seen, goal, none, unit);
        }
    }
    all
}

/// `(A J)^+ A` where the joints are as many as the rows, or more; tells the lanes in which rows
/// are all but lost.
#[inline(always)]
fn enough_joints<R: Real, const M: usize>(
    moved: &[[R; M]],
    wanted: &[[R; M]; TWIST],
    derivatives: &mut [R],
) -> u32 {
    let mut a = gram(moved);
    let mut largest = a[0][0];
    for (i, row) in a.iter().enumerate().skip(1) {
        largest = largest.max(row[i]);
    }
    for (i, row) in a.iter_mut().enumerate() {
        // A row that is free gets a pivot of its own, and an answer of zero.
        let free = row[i].le(largest * R::splat(FREE));
        row[i] = R::select(free, largest.max(R::splat(f64::MIN_POSITIVE)), row[i]);
    }
    let (factored, lost) = factored(a);
    for (j, wanted) in wanted.iter().enumerate() {
        let y = factored.solve(*wanted);
        for (derivative, moved) in derivatives[j..].iter_mut().step_by(TWIST).zip(moved) {
            *derivative = dot(moved, &y);
        }
    }
    lost
}

/// The same where the joints are fewer than the rows: least squares.
#[inline(always)]
fn fewer_joints<R: Real, const M: usize>(
    moved: &[[R; M]],
    wanted: &[[R; M]; TWIST],
    derivatives: &mut [R],
) -> u32 {
    let mut a = [[R::zero(); FEW]; FEW];
    for (i, row) in a.iter_mut().enumerate() {
        // Places of joints that there are not.
        row[i] = R::splat(1.0);
        for (j, x) in row.iter_mut().enumerate().take((i + 1).min(moved.len())) {
            if i < moved.len() {
                *x = dot(&moved[i], &moved[j]);
            }
        }
    }
    let (factored, lost) = factored(a);
    for (j, wanted) in wanted.iter().enumerate() {
        let mut b = [R::zero(); FEW];
        for (b, moved) in b.iter_mut().zip(moved) {
            *b = dot(moved, wanted);
        }
        let x = factored.solve(b);
        for (derivative, x) in derivatives[j..].iter_mut().step_by(TWIST).zip(x) {
            *derivative = x;
        }
    }
    lost
}

/// The factors of a matrix, and the lanes in which they are of no use.
#[inline(always)]
fn factored<R: Real, const M: usize>(a: [[R; M]; M]) -> (Factored<R, M>, u32) {
    let factored = Factored::new(a);
    let mut lost = 0;
    for (i, pivot) in factored.pivots.iter().enumerate() {
        lost |= R::bits(pivot.le(a[i][i] * R::splat(LOST)));
    }
    (factored, lost)
}

/// The derivatives of one lane near a singularity: directions that are lost are left out.
#[inline(never)]
fn singular<R: Real, const M: usize>(
    moved: &[[R; M]],
    wanted: &[[R; M]; TWIST],
    lane: usize,
    derivatives: &mut [R],
) {
    let jacobian = DMatrix::from_fn(M, moved.len(), |i, j| moved[j][i].lane(lane));
    let wanted = DMatrix::from_fn(M, TWIST, |i, j| wanted[j][i].lane(lane));
    let svd = jacobian.svd(true, true);
    let least = svd.singular_values.iter().fold(0.0f64, |most, s| most.max(*s)) * STUCK;
    let found = svd.solve(&wanted, least.max(f64::MIN_POSITIVE));
    for (k, derivative) in derivatives.iter_mut().enumerate() {
        // Both factors were asked for, so that it cannot fail.
        derivative.set_lane(lane, found.as_ref().map_or(0.0, |x| x[(k / TWIST, k % TWIST)]));
    }
}
