//! Serial chains: joints, limits, base and tool, from DH rows, URDF or joint lists.

mod compiled;
mod dh;
mod joint;
mod locked;
mod memo;
mod motion;
mod reach;
mod urdf;

use std::any::Any;

use nalgebra::{IsometryMatrix3, Matrix4};

pub use compiled::{Compiled, Link, Tail, Twist};
pub use dh::{DhConvention, DhRow};
pub use joint::{Joint, JointKind, Mimic, MotionLimits, UNLIMITED, hold_a_value, reference};
pub use reach::Reach;
pub use urdf::Ends;

use crate::allowed::{LARGEST, check_measures};
use crate::error::{Error, Result};
use memo::Memo;

/// One independent joint value: an entry of `q`.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Name of the joint that it moves.
    pub name: String,
    /// Revolute, continuous or prismatic.
    pub kind: JointKind,
    /// Smallest value, rad or m.
    pub lower: f64,
    /// Largest value, rad or m.
    pub upper: f64,
    /// How fast it may move: no faster than any joint that follows it can.
    pub motion: MotionLimits,
    /// A whole turn of it leads to the same posture: all that it moves turns, by whole
    /// multiples of it.
    pub periodic: bool,
}

impl Variable {
    /// The value inside the limits that is nearest to zero: what stands for an answer where
    /// there is none.
    pub fn near_zero(&self) -> f64 {
        0.0f64.clamp(self.lower, self.upper)
    }

    /// The middle of the limits; where there are none to speak of, the value nearest to zero.
    pub fn middle(&self) -> f64 {
        let wide = self.upper - self.lower >= 2.0 * UNLIMITED;
        if wide { self.near_zero() } else { 0.5 * (self.lower + self.upper) }
    }

    /// Whether the joint can take every angle, so that its limits hold nothing back.
    pub fn turns(&self) -> bool {
        // Half a step of rounding: limits of plus and minus half a turn are a full one.
        self.periodic && self.upper - self.lower >= std::f64::consts::TAU - 1e-15
    }

    /// The value that answers stay near, for the caller's `about`; no angle beyond `most` where
    /// that can be helped.
    pub fn reference(&self, about: f64, most: f64) -> f64 {
        reference(about, (self.lower, self.upper), self.turns(), most)
    }
}

/// An ordered list of joints from base to tool, checked and compiled.
#[derive(Debug, Clone)]
pub struct Chain {
    name: String,
    base: IsometryMatrix3<f64>,
    joints: Vec<Joint>,
    tool: IsometryMatrix3<f64>,
    variables: Vec<Variable>,
    compiled: Compiled,
    reach: Reach,
    last_joint_reach: Option<Reach>,
    memo: Memo,
}

impl Chain {
    /// A chain from its joints, base (in the world) and tool (in the last link).
    ///
    /// `variable_order` names the entries of `q` in order; without it they stand in the
    /// order in which the joints follow one another.
    pub fn new(
        name: impl Into<String>,
        joints: Vec<Joint>,
        base: IsometryMatrix3<f64>,
        tool: IsometryMatrix3<f64>,
        variable_order: Option<&[String]>,
    ) -> Result<Self> {
        check_joints(&joints)?;
        check_measures("base", numbers(&base))?;
        check_measures("tool", numbers(&tool))?;
        let mut variables = variables_of(&joints)?;
        if variables.is_empty() {
            return Err(Error::argument("joints", "at least one movable joint", "none"));
        }
        if let Some(order) = variable_order {
            variables = reorder(variables, order)?;
        }
        let compiled = Compiled::new(&base, &joints, &tool, &variables)?;
        let reach = Reach::new(&compiled, &variables);
        let last_joint_reach = Reach::of_last_joint(&compiled, &variables);
        Ok(Self {
            name: name.into(),
            base,
            joints,
            tool,
            variables,
            compiled,
            reach,
            last_joint_reach,
            memo: Memo::default(),
        })
    }

    /// A chain from a URDF text; `base_link` and `tip_link` default to the only root and to
    /// the end of the only arm (an error names the candidates where there are several).
    pub fn from_urdf(text: &str, base_link: Option<&str>, tip_link: Option<&str>) -> Result<Self> {
        Ok(Self::from_urdf_with_ends(text, base_link, tip_link)?.0)
    }

    /// A chain from a URDF text, and the links that it lies between.
    pub fn from_urdf_with_ends(
        text: &str,
        base_link: Option<&str>,
        tip_link: Option<&str>,
    ) -> Result<(Self, Ends)> {
        urdf::parse(text, base_link, tip_link)
    }

    /// The same chain with another tool transform (tool in the last link's frame).
    pub fn with_tool(&self, tool: IsometryMatrix3<f64>) -> Result<Self> {
        self.rebuilt(self.base, tool)
    }

    /// The same chain with another base transform (base in the world).
    pub fn with_base(&self, base: IsometryMatrix3<f64>) -> Result<Self> {
        self.rebuilt(base, self.tool)
    }

    /// True where name, joints, order of the variables, base and tool are the same, number by
    /// number.
    pub fn is_same(&self, other: &Self) -> bool {
        self.name == other.name
            && self.joints == other.joints
            && self.variables == other.variables
            && self.base == other.base
            && self.tool == other.tool
    }

    fn rebuilt(&self, base: IsometryMatrix3<f64>, tool: IsometryMatrix3<f64>) -> Result<Self> {
        let order: Vec<String> = self.variables.iter().map(|v| v.name.clone()).collect();
        Self::new(self.name.clone(), self.joints.clone(), base, tool, Some(&order))
    }

    /// Name of the robot.
    pub fn name(&self) -> &str {
        &self.name
    }
    /// Number of entries of `q`.
    pub fn dof(&self) -> usize {
        self.variables.len()
    }
    /// The joint values inside the limits that are nearest to zero.
    pub fn near_zero(&self) -> Vec<f64> {
        self.variables.iter().map(Variable::near_zero).collect()
    }
    /// All joints, fixed ones and followers included, from base to tool.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }
    /// The entries of `q`, in order.
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }
    /// Base frame in the world.
    pub fn base(&self) -> &IsometryMatrix3<f64> {
        &self.base
    }
    /// Tool frame in the last link.
    pub fn tool(&self) -> &IsometryMatrix3<f64> {
        &self.tool
    }
    /// The form the hot loops work on.
    pub fn compiled(&self) -> &Compiled {
        &self.compiled
    }
    /// Proven bounds of where the tool point can be.
    pub fn reach(&self) -> &Reach {
        &self.reach
    }

    /// Proven bounds of where the last joint can be; `None` for a chain that ends in a slide.
    pub fn last_joint_reach(&self) -> Option<&Reach> {
        self.last_joint_reach.as_ref()
    }

    /// What `make` derives from this chain: made when its type is first asked for, and kept.
    pub fn memo<T: Any + Send + Sync>(&self, make: impl Fn(&Self) -> T) -> &T {
        self.memo.get_or_make(|| make(self))
    }

    /// True where all of `q` lies inside the limits, end points included.
    pub fn within_limits(&self, q: &[f64]) -> bool {
        self.variables.iter().zip(q).all(|(v, &x)| v.lower <= x && x <= v.upper)
    }

    /// Poses of all links in the world, one per joint (fixed ones included), tool last.
    pub fn link_poses(&self, q: &[f64]) -> Vec<Matrix4<f64>> {
        let mut pose = self.base;
        let mut poses = Vec::with_capacity(self.joints.len() + 1);
        let index_of = |name: &str| self.variables.iter().position(|v| v.name == name);
        for joint in &self.joints {
            let value = match (&joint.mimic, joint.kind) {
                (_, JointKind::Fixed) => 0.0,
                (Some(m), _) => index_of(&m.source).map_or(0.0, |i| m.multiplier * q[i] + m.offset),
                (None, _) => index_of(&joint.name).map_or(0.0, |i| q[i]),
            };
            pose = pose * joint.origin * compiled::motion(joint, value) * joint.after;
            poses.push(pose.to_homogeneous());
        }
        poses.push((pose * self.tool).to_homogeneous());
        poses
    }
}

fn check_joints(joints: &[Joint]) -> Result<()> {
    for (i, joint) in joints.iter().enumerate() {
        let place = |what: &str| format!("joint '{}' {what}", joint.name);
        if joints[..i].iter().any(|other| other.name == joint.name) {
            return Err(Error::argument(place("name"), "a unique name", "a second one"));
        }
        if !joint.axis.iter().all(|x| x.is_finite()) {
            return Err(Error::argument(place("axis"), "a direction of non-zero length", "zero"));
        }
        check_measures(&place("origin"), numbers(&joint.origin).chain(numbers(&joint.after)))?;
        let bounded = matches!(joint.kind, JointKind::Revolute | JointKind::Prismatic);
        if bounded && (joint.lower.is_nan() || joint.upper.is_nan()) {
            let got = format!("[{}, {}]", joint.lower, joint.upper);
            return Err(Error::argument(place("limits"), "numbers", got));
        }
        if bounded && joint.lower > joint.upper {
            let got = format!("lower {} > upper {}", joint.lower, joint.upper);
            return Err(Error::argument(place("limits"), "lower <= upper", got));
        }
        if bounded && !hold_a_value(joint.lower, joint.upper) {
            let got = format!("[{:e}, {:e}]", joint.lower, joint.upper);
            let expected = format!("a value of size {LARGEST:e} at most between them");
            return Err(Error::argument(place("limits"), expected, got));
        }
        for (what, limit) in joint.motion.numbers() {
            if limit.is_nan() || limit <= 0.0 {
                return Err(Error::argument(place(what), "a number above 0, or infinity", limit));
            }
        }
        if let Some(mimic) = &joint.mimic {
            check_measures(&place("mimic"), [mimic.multiplier, mimic.offset])?;
        }
    }
    Ok(())
}

fn numbers(t: &IsometryMatrix3<f64>) -> impl Iterator<Item = f64> {
    t.translation.vector.iter().chain(t.rotation.matrix().iter()).copied()
}

/// The independent variables, in order of first use along the chain.
///
/// A follower whose source is not on the chain makes that source a variable. A
/// follower's own limits narrow its source's, since both must hold.
fn variables_of(joints: &[Joint]) -> Result<Vec<Variable>> {
    let mut variables: Vec<Variable> = Vec::new();
    for joint in joints.iter().filter(|j| j.kind != JointKind::Fixed) {
        let source = match &joint.mimic {
            None => Variable {
                name: joint.name.clone(),
                kind: joint.kind,
                lower: joint.lower,
                upper: joint.upper,
                motion: MotionLimits::UNKNOWN,
                periodic: true,
            },
            Some(mimic) => mimic_source(joint, mimic, joints)?,
        };
        if !variables.iter().any(|v| v.name == source.name) {
            variables.push(source);
        }
    }
    for joint in joints.iter().filter(|j| j.kind != JointKind::Fixed) {
        if let Some(mimic) = &joint.mimic
            && mimic.multiplier != 0.0
            && let Some(v) = variables.iter_mut().find(|v| v.name == mimic.source)
        {
            let a = (joint.lower - mimic.offset) / mimic.multiplier;
            let b = (joint.upper - mimic.offset) / mimic.multiplier;
            v.lower = v.lower.max(a.min(b));
            v.upper = v.upper.min(a.max(b));
            if v.lower > v.upper {
                return Err(Error::argument(
                    format!("joint '{}' mimic", joint.name),
                    "limits that overlap those of its source",
                    "none in common",
                ));
            }
            // With a limit on its follower a source that turned freely does so no more.
            if v.lower.is_finite() && v.upper.is_finite() && v.kind == JointKind::Continuous {
                v.kind = JointKind::Revolute;
            }
        }
    }
    for joint in joints.iter().filter(|j| j.kind != JointKind::Fixed) {
        let (source, multiplier) =
            joint.mimic.as_ref().map_or((&joint.name, 1.0), |m| (&m.source, m.multiplier));
        let turns = joint.kind != JointKind::Prismatic && multiplier.fract() == 0.0;
        for v in variables.iter_mut().filter(|v| v.name == *source) {
            v.periodic &= turns;
        }
    }
    motion::spread(&mut variables, joints);
    for v in variables.iter_mut().filter(|v| v.kind == JointKind::Revolute) {
        if v.lower <= -UNLIMITED && v.upper >= UNLIMITED {
            (v.kind, v.lower, v.upper) = (JointKind::Continuous, f64::NEG_INFINITY, f64::INFINITY);
        }
    }
    Ok(variables)
}

fn mimic_source(joint: &Joint, mimic: &Mimic, joints: &[Joint]) -> Result<Variable> {
    let place = format!("joint '{}' mimic", joint.name);
    match joints.iter().find(|j| j.name == mimic.source) {
        Some(source) if source.mimic.is_some() || source.kind == JointKind::Fixed => {
            Err(Error::argument(
                place,
                "a movable source that follows no other joint",
                format!("'{}'", source.name),
            ))
        }
        Some(source) => Ok(Variable {
            name: source.name.clone(),
            kind: source.kind,
            lower: source.lower,
            upper: source.upper,
            motion: MotionLimits::UNKNOWN,
            periodic: true,
        }),
        None => {
            let (lower, upper) = mimic
                .source_limits
                .ok_or_else(|| Error::argument(place, "a known joint", &mimic.source))?;
            let kind = if lower.is_finite() { joint.kind } else { JointKind::Continuous };
            let (name, motion) = (mimic.source.clone(), MotionLimits::UNKNOWN);
            Ok(Variable { name, kind, lower, upper, motion, periodic: true })
        }
    }
}

fn reorder(variables: Vec<Variable>, order: &[String]) -> Result<Vec<Variable>> {
    let names: Vec<&str> = variables.iter().map(|v| v.name.as_str()).collect();
    let refuse = || {
        Error::argument(
            "variable_order",
            format!("each of {} once", names.join(", ")),
            order.join(", "),
        )
    };
    if order.len() != variables.len() {
        return Err(refuse());
    }
    let mut sorted = Vec::with_capacity(order.len());
    for (i, name) in order.iter().enumerate() {
        if order[..i].contains(name) {
            return Err(refuse());
        }
        let found = variables.iter().find(|v| &v.name == name).ok_or_else(refuse)?;
        sorted.push(found.clone());
    }
    Ok(sorted)
}
