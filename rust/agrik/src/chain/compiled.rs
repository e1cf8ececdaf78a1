//! The form of a chain that the hot loops work on: every motion about or along a local z
//! axis, every constant transform between two motions in four DH numbers where possible.
//!
//! Between the axes of two joints any constant transform is
//! `Rz(phi) Tz(d) Tx(a) Rx(alpha) Rz(psi) Tz(e)`. The outer factors commute with the
//! joints' own motions, so they become offsets of the joint values, and what is left
//! costs 12 multiply-adds instead of 36. Axes that are almost, but not quite, parallel
//! have a common normal far away; there the full transform is kept.

use nalgebra::{IsometryMatrix3, Matrix3, Rotation3, Translation3, Vector3};

use super::{Joint, JointKind, Variable};
use crate::error::{Error, Result};
use crate::lanes::hypotenuse;

/// Below this sine two axes count as parallel: rounding of pi/2 and the like, not a tilt.
const PARALLEL: f64 = 1e-14;
/// Above this sine the common normal of two axes is near enough to be used: its feet lie
/// at most ten times as far away as the axes themselves. Farther ones would cost digits,
/// and make the reach bounds of a calibrated robot useless.
const SKEW: f64 = 0.1;

/// Share of an arm's lengths up to which a tool is a part of the arm like any other, and the
/// share of them at which a farther one is looked at.
const NEAR: f64 = 0.25;
const FLANGE: f64 = 0.05;

/// The twist between a joint's axis and the next one's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Twist {
    /// Parallel, same direction.
    Zero,
    /// Parallel, opposite direction.
    Half,
    /// A right angle about x.
    Quarter,
    /// Any angle: its sine and cosine.
    Angle(f64, f64),
    /// A full rotation (columns x, y, z), after which the next axis is z.
    Full([[f64; 3]; 3]),
}

/// One moving joint and the constant transform to the next one.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Slides along z rather than turning about it.
    pub prismatic: bool,
    /// Which entry of `q` moves it.
    pub variable: usize,
    /// Factor on that entry (1 but for followers).
    pub multiplier: f64,
    /// Added to the angle, rad.
    pub theta: f64,
    /// Sine and cosine of `theta`, used by prismatic joints whose angle is constant.
    pub theta_sin_cos: (f64, f64),
    /// Added to the way along z, m.
    pub d: f64,
    /// Way along the turned x axis to the next joint, m.
    pub a: f64,
    /// Way along the turned y axis; not zero only with [`Twist::Full`], m.
    pub b: f64,
    /// From this joint's axis to the next one's.
    pub twist: Twist,
}

/// The tool in the frame of the last moving joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tail {
    /// Tool point, m.
    pub translation: [f64; 3],
    /// Columns: the tool's axes.
    pub rotation: [[f64; 3]; 3],
}

impl Tail {
    /// A direction given in the tool frame, in the last moving joint's frame.
    pub fn direction(&self, v: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = self.rotation;
        [0, 1, 2].map(|k| x[k] * v[0] + y[k] * v[1] + z[k] * v[2])
    }
}

/// A chain ready for evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct Compiled {
    /// Origin of the first joint's frame in the world, m.
    pub start_position: [f64; 3],
    /// Columns: axes of the first joint's frame in the world.
    pub start_rotation: [[f64; 3]; 3],
    /// The moving joints.
    pub links: Vec<Link>,
    /// The tool in the last joint's moved frame.
    pub tail: Tail,
    /// Number of entries of `q`.
    pub dof: usize,
    /// Each moving joint has an entry of its own, in order, with factor 1.
    pub simple: bool,
    /// [`Compiled::simple`], and all joints turn.
    pub plain: bool,
    /// Ways from joint to joint, added up, m.
    lengths: f64,
}

/// Length of a vector.
fn length(v: [f64; 3]) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

/// Columns of a rotation matrix.
pub(crate) fn columns(m: &Matrix3<f64>) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|j| [m[(0, j)], m[(1, j)], m[(2, j)]])
}

/// The transform of a joint at a value.
pub(super) fn motion(joint: &Joint, value: f64) -> IsometryMatrix3<f64> {
    match joint.kind {
        JointKind::Fixed => IsometryMatrix3::identity(),
        JointKind::Prismatic => IsometryMatrix3::from_parts(
            Translation3::from(joint.axis.into_inner() * value),
            Rotation3::identity(),
        ),
        JointKind::Revolute | JointKind::Continuous => IsometryMatrix3::from_parts(
            Translation3::identity(),
            Rotation3::from_axis_angle(&joint.axis, value),
        ),
    }
}

/// A rotation that takes z to `axis`, a unit vector.
///
/// Written out, since an angle taken from the cosine is lost for axes close to z.
fn alignment(axis: &Vector3<f64>) -> IsometryMatrix3<f64> {
    // Half a turn about x first where the axis points down, so that 1 + z is not small.
    let up = if axis[2] < 0.0 { -axis } else { *axis };
    let [x, y, z] = up.into();
    let k = 1.0 / (1.0 + z);
    let turn = Matrix3::new(
        1.0 - x * x * k,
        -x * y * k,
        x, //
        -x * y * k,
        1.0 - y * y * k,
        y, //
        -x,
        -y,
        z,
    );
    let flip = if axis[2] < 0.0 { -1.0 } else { 1.0 };
    let flip = Matrix3::from_diagonal(&Vector3::new(1.0, flip, flip));
    let rotation = Rotation3::from_matrix_unchecked(turn * flip);
    IsometryMatrix3::from_parts(Translation3::identity(), rotation)
}

impl Compiled {
    pub(super) fn new(
        base: &IsometryMatrix3<f64>,
        joints: &[Joint],
        tool: &IsometryMatrix3<f64>,
        variables: &[Variable],
    ) -> Result<Self> {
        // The constant transform gathered since the last moving joint.
        let mut pending = *base;
        let mut links: Vec<Link> = Vec::new();
        let mut start = IsometryMatrix3::identity();
        for joint in joints {
            pending *= joint.origin;
            if joint.kind == JointKind::Fixed {
                pending *= joint.after;
                continue;
            }
            let align = alignment(&joint.axis);
            let constant = pending * align;
            let mut link = link_of(joint, variables)?;
            match links.last_mut() {
                None => start = constant,
                Some(previous) => connect(previous, &mut link, &constant),
            }
            links.push(link);
            pending = align.inverse() * joint.after;
        }
        // What the last joint adds along its own axis belongs to the tail.
        if let Some(last) = links.last_mut() {
            let along = Translation3::new(0.0, 0.0, std::mem::take(&mut last.d));
            pending = IsometryMatrix3::from_parts(along, Rotation3::identity()) * pending;
        }
        let tail = pending * tool;
        let simple = links.len() == variables.len()
            && links.iter().enumerate().all(|(i, l)| l.variable == i && l.multiplier == 1.0);
        // `connect` may have changed the angle of a link after it was pushed.
        for link in &mut links {
            link.theta_sin_cos = link.theta.sin_cos();
        }
        Ok(Self {
            start_position: start.translation.vector.into(),
            start_rotation: columns(start.rotation.matrix()),
            tail: Tail {
                translation: tail.translation.vector.into(),
                rotation: columns(tail.rotation.matrix()),
            },
            dof: variables.len(),
            plain: simple && links.iter().all(|l| !l.prismatic),
            lengths: links.iter().map(|l| length([l.a, l.b, l.d])).sum(),
            simple,
            links,
        })
    }

    /// The point by which a pose with this tool point (in the last joint's frame, m) is best
    /// compared: the tool point itself, or of a tool far out the point on the way to it where
    /// a turn and a way of the arm's size stand beside each other as they do at the flange.
    pub fn pose_point(&self, tool: [f64; 3]) -> [f64; 3] {
        let (lengths, far) = (self.lengths, length(tool));
        if lengths > 0.0 && far > NEAR * lengths {
            tool.map(|x| x * (FLANGE * lengths / far))
        } else {
            tool
        }
    }

    /// The tail with one more transform behind the tool (a tool offset for one call).
    pub fn tail_with(&self, offset: &IsometryMatrix3<f64>) -> Tail {
        let r = Matrix3::from_columns(&self.tail.rotation.map(Vector3::from));
        let t = Vector3::from(self.tail.translation) + r * offset.translation.vector;
        Tail { translation: t.into(), rotation: columns(&(r * offset.rotation.matrix())) }
    }
}

fn link_of(joint: &Joint, variables: &[Variable]) -> Result<Link> {
    let (source, multiplier, offset) = match &joint.mimic {
        None => (&joint.name, 1.0, 0.0),
        Some(m) => (&m.source, m.multiplier, m.offset),
    };
    let variable = variables
        .iter()
        .position(|v| &v.name == source)
        .ok_or_else(|| Error::argument("mimic", "a known joint", source))?;
    let prismatic = joint.kind == JointKind::Prismatic;
    Ok(Link {
        prismatic,
        variable,
        multiplier,
        theta: if prismatic { 0.0 } else { offset },
        theta_sin_cos: (0.0, 1.0),
        d: if prismatic { offset } else { 0.0 },
        a: 0.0,
        b: 0.0,
        twist: Twist::Zero,
    })
}

/// Writes the constant transform between two joints into the links on both sides.
fn connect(previous: &mut Link, next: &mut Link, constant: &IsometryMatrix3<f64>) {
    let r = constant.rotation.matrix();
    let t = constant.translation.vector;
    let axis = r.column(2);
    let sine = hypotenuse(axis[0], axis[1]);
    if sine > SKEW {
        let phi = axis[0].atan2(-axis[1]);
        let (s, c) = phi.sin_cos();
        let normal = Vector3::new(c, s, 0.0);
        let across = Vector3::new(-s, c, 0.0);
        let e = -t.dot(&across) / sine;
        previous.theta += phi;
        previous.a = snap(t.dot(&normal));
        previous.d = snap(previous.d + t[2] - e * axis[2]);
        previous.twist =
            if axis[2].abs() < 1e-15 { Twist::Quarter } else { Twist::Angle(sine, axis[2]) };
        next.d += snap(e);
        let turned = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[
            normal,
            across * axis[2] + Vector3::z() * sine,
            axis.into_owned(),
        ]));
        next.theta += rotation_about_z(&(turned.inverse() * constant.rotation));
    } else if sine < PARALLEL {
        let a = hypotenuse(t[0], t[1]);
        let phi = if snap(a) == 0.0 { 0.0 } else { t[1].atan2(t[0]) };
        previous.theta += phi;
        previous.a = snap(a);
        previous.d = snap(previous.d + t[2]);
        let flip = axis[2] < 0.0;
        previous.twist = if flip { Twist::Half } else { Twist::Zero };
        let mut turned = Rotation3::from_axis_angle(&Vector3::z_axis(), phi);
        if flip {
            turned *= Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
        }
        next.theta += rotation_about_z(&(turned.inverse() * constant.rotation));
    } else {
        previous.a = t[0];
        previous.b = t[1];
        previous.d += t[2];
        previous.twist = Twist::Full(columns(r));
    }
}

/// The angle of a rotation about z.
fn rotation_about_z(r: &Rotation3<f64>) -> f64 {
    let m = r.matrix();
    m[(1, 0)].atan2(m[(0, 0)])
}

/// Lengths below a picometre are rounding errors of the decomposition; zero is cheaper
/// and exact where geometry means zero.
fn snap(length: f64) -> f64 {
    if length.abs() < 1e-15 { 0.0 } else { length }
}
