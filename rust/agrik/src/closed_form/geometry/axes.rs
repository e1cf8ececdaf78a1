//! The lines of a chain's axes as Denavit-Hartenberg numbers, with what is almost
//! parallel or almost meeting taken for just that.
//!
//! The numbers are read off the axes at `q = 0`, so that it does not matter how the chain
//! was given. Distances between neighbouring axes and the feet of their common normals do
//! not change with `q`, so what holds here holds everywhere.

use nalgebra::Vector3;

use super::limit::Limit;
use super::turn::{Link, Turn};
use crate::chain::{Chain, Compiled, Variable};
use crate::kinematics::{Workspace, forward};
use crate::lanes::V3;

/// Lengths below this share of the reach count as zero, and sines below it as well.
pub const TOLERANCE: f64 = 1e-6;
/// Cosines below this count as zero.
const RIGHT: f64 = 1e-12;

/// Axes of `n` revolute joints: `n - 1` links between them.
#[derive(Debug, Clone, PartialEq)]
pub struct Geometry {
    /// A point on the first axis, m, world.
    pub origin: [f64; 3],
    /// Columns, world: x at angle zero of the first joint, y, and the first axis as z.
    pub axes: [[f64; 3]; 3],
    /// The links between neighbouring axes.
    pub links: Vec<Link>,
    /// Angle of the last joint's frame against the last common normal at value 0, rad.
    pub last_theta: f64,
    /// Where the last common normal meets the last axis, from the last joint's origin, m.
    pub last_shift: f64,
    /// Which entry of `q` moves each joint.
    pub variables: Vec<usize>,
    /// Limits of each joint.
    pub limits: Vec<Limit>,
    /// Turn of each joint, from its common normal, at the middle of its limits.
    pub middle: Vec<Turn<f64>>,
    /// Length below which a distance counts as zero, m.
    pub tolerance: f64,
    /// How far the chain's frames are from those of these axes at most, for what was taken
    /// for zero.
    pub misfit: Misfit,
}

/// How far two frames are apart at most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Misfit {
    /// Distance, m.
    pub position: f64,
    /// Angle, rad.
    pub orientation: f64,
}

impl Geometry {
    /// The axes of a chain, or why they cannot be taken as such.
    pub fn new(chain: &Chain) -> Result<Self, String> {
        let compiled = chain.compiled();
        if let Some(slide) = compiled.links.iter().find(|link| link.prismatic) {
            let name = &chain.variables()[slide.variable].name;
            return Err(format!("its prismatic joint '{name}' is not locked at a value"));
        }
        let alone = compiled.links.len() == compiled.dof
            && compiled.links.iter().all(|link| link.multiplier == 1.0);
        if !alone {
            return Err("a joint follows another".to_owned());
        }
        Self::of_compiled(compiled, chain.variables(), chain.reach().radius)
    }

    fn of_compiled(
        compiled: &Compiled,
        variables: &[Variable],
        reach: f64,
    ) -> Result<Self, String> {
        let mut workspace = Workspace::<f64>::new(compiled);
        forward(compiled, &vec![0.0; compiled.dof], &mut workspace);
        let lines: Vec<_> =
            workspace.axes.iter().map(|axis| (axis.origin, axis.direction)).collect();
        let [last_x, ..] = workspace.joint_axes();
        let order: Vec<usize> = compiled.links.iter().map(|link| link.variable).collect();
        let limits: Vec<Limit> = order.iter().map(|i| Limit::of(&variables[*i])).collect();
        Self::of(&lines, last_x, reach, order, limits)
    }

    /// The geometry of lines, each a point (m) and a direction, of joints without limits;
    /// `last_x` is a direction across the last one from which its joint is counted, and `reach`
    /// the size that the tolerance is a share of, m.
    pub fn of_lines(
        lines: &[(V3<f64>, V3<f64>)],
        last_x: V3<f64>,
        reach: f64,
    ) -> Result<Self, String> {
        let order = (0..lines.len()).collect();
        Self::of(lines, last_x, reach, order, vec![Limit::FREE; lines.len()])
    }

    fn of(
        lines: &[(V3<f64>, V3<f64>)],
        last_x: V3<f64>,
        reach: f64,
        order: Vec<usize>,
        limits: Vec<Limit>,
    ) -> Result<Self, String> {
        let tolerance = TOLERANCE * reach;
        let lines: Vec<_> =
            lines.iter().map(|(p, h)| (Vector3::from(*p), Vector3::from(*h))).collect();
        let (origin, first) = lines[0];
        // Any direction does for x; one that is the same for the same robot.
        let guess = if first.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
        let x = (guess - first * guess.dot(&first)).normalize();
        let mut normal = x;
        let mut foot = origin;
        let mut links: Vec<Link> = Vec::with_capacity(lines.len());
        let mut misfit = Misfit { position: 0.0, orientation: 0.0 };
        for (i, pair) in lines.windows(2).enumerate() {
            let ((p, h), (next_p, next_h)) = (pair[0], pair[1]);
            let between = Between::new(p, h, next_p, next_h, foot, tolerance)
                .ok_or_else(|| format!("axes {} and {} are one line", i + 1, i + 2))?;
            let d = (between.leaves - foot).dot(&h);
            misfit.position += between.lost.position + lost(d, tolerance);
            misfit.orientation += between.lost.orientation;
            links.push(Link {
                theta: angle_about(&h, &normal, &between.normal),
                d: snap(d, tolerance),
                a: between.length,
                sine: between.sine,
                cosine: between.cosine,
            });
            normal = between.normal;
            foot = between.arrives;
        }
        let (last_p, last_h) = lines[lines.len() - 1];
        // An angle moves all that comes after it.
        let size: f64 = links.iter().map(|link| link.a.abs() + link.d.abs()).sum();
        misfit.position += misfit.orientation * size;
        let last_theta = angle_about(&last_h, &normal, &Vector3::from(last_x));
        let offsets = links.iter().map(|link| link.theta).chain([last_theta]);
        let middle = limits.iter().zip(offsets);
        Ok(Self {
            middle: middle.map(|(limit, offset)| (limit.middle + offset).sin_cos()).collect(),
            limits,
            origin: origin.into(),
            axes: [x.into(), first.cross(&x).into(), first.into()],
            links,
            last_theta,
            last_shift: (foot - last_p).dot(&last_h),
            variables: order,
            tolerance,
            misfit,
        })
    }

    /// What a joint's turn is counted from, rad.
    #[inline(always)]
    pub fn offset(&self, joint: usize) -> f64 {
        self.links.get(joint).map_or(self.last_theta, |link| link.theta)
    }

    /// How far three neighbouring axes, the first of them `first` (from 0), are from
    /// meeting in a point, m; infinite where two of them are parallel.
    pub fn gap(&self, first: usize) -> f64 {
        let (one, two) = (&self.links[first], &self.links[first + 1]);
        if one.sine == 0.0 || two.sine == 0.0 {
            return f64::INFINITY;
        }
        one.a.abs().max(two.a.abs()).max(two.d.abs())
    }
}

/// The common normal of two lines.
struct Between {
    normal: Vector3<f64>,
    leaves: Vector3<f64>,
    arrives: Vector3<f64>,
    length: f64,
    sine: f64,
    cosine: f64,
    /// What was taken for zero.
    lost: Misfit,
}

impl Between {
    /// `foot` is the point that a normal of parallel lines leaves from; `None` for lines
    /// that coincide.
    fn new(
        p: Vector3<f64>,
        h: Vector3<f64>,
        next_p: Vector3<f64>,
        next_h: Vector3<f64>,
        foot: Vector3<f64>,
        tolerance: f64,
    ) -> Option<Self> {
        let across = h.cross(&next_h);
        let sine = across.norm();
        let cosine = h.dot(&next_h);
        if sine < TOLERANCE {
            let arrives = next_p + next_h * (foot - next_p).dot(&next_h);
            let way = arrives - foot;
            let way = way - h * way.dot(&h);
            let length = way.norm();
            let cosine = cosine.signum();
            return (length > tolerance).then(|| Self {
                normal: way / length,
                leaves: foot,
                arrives,
                length,
                sine: 0.0,
                cosine,
                lost: Misfit { position: 0.0, orientation: sine },
            });
        }
        let normal = across / sine;
        let way = next_p - p;
        let along = way.cross(&next_h).dot(&normal) / sine;
        let next_along = way.cross(&h).dot(&normal) / sine;
        let length = way.dot(&normal);
        let lost = Misfit { position: lost(length, tolerance), orientation: lost(cosine, RIGHT) };
        let cosine = snap(cosine, RIGHT);
        Some(Self {
            normal,
            leaves: p + h * along,
            arrives: next_p + next_h * next_along,
            length: snap(length, tolerance),
            sine: if cosine == 0.0 { 1.0 } else { sine },
            cosine,
            lost,
        })
    }
}

/// The angle about `axis` that takes `from` to `to`, both at right angles to it.
fn angle_about(axis: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
    from.cross(to).dot(axis).atan2(from.dot(to))
}

fn snap(x: f64, tolerance: f64) -> f64 {
    if x.abs() < tolerance { 0.0 } else { x }
}

/// What [`snap`] takes away.
fn lost(x: f64, tolerance: f64) -> f64 {
    if x.abs() < tolerance { x.abs() } else { 0.0 }
}
