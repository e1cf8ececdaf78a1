//! One `<joint>` with its numbers.

use nalgebra::{IsometryMatrix3, Rotation3, Translation3, Unit, Vector3};

use super::text::quoted;
use super::tree::{Declared, Tree};
use super::xml::Element;
use super::{fault, limits};
use crate::chain::{Joint, JointKind, Mimic};
use crate::error::{Error, Result};

/// Limits of a joint that turns freely.
const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// Limits of a joint that does not move, as everywhere.
const STILL: (f64, f64) = (0.0, 0.0);

/// The joint of a declaration.
pub(super) fn build(tree: &Tree<'_>, declared: &Declared<'_>) -> Result<Joint> {
    let mut kind = declared.kind()?;
    let mut limits = STILL;
    let mut mimic = None;
    let mut velocity = f64::INFINITY;
    if kind != JointKind::Fixed {
        velocity = declared.velocity()?;
        let leader = Leader::of(tree, declared)?;
        limits = match declared.limits(kind)? {
            Some(limits) => limits,
            // A follower needs no limits of its own: its leader's bound it too.
            None => match &leader {
                Some(leader) => image(leader.limits, leader.multiplier, leader.offset),
                None => return Err(declared.without_limits(kind)),
            },
        };
        if kind == JointKind::Revolute && limits == FREE {
            kind = JointKind::Continuous;
        }
        if let Some(leader) = leader {
            limits = (limits.0.max(leader.bounds.0), limits.1.min(leader.bounds.1));
            velocity = velocity.min(leader.velocity);
            mimic = Some(leader.into_mimic());
        }
    }
    let mut joint = Joint::new(declared.name, kind, limits.0, limits.1);
    joint.origin = declared.origin()?;
    joint.motion.velocity = velocity;
    joint.mimic = mimic;
    joint.child_link = declared.child.to_string();
    if kind != JointKind::Fixed {
        joint.axis = declared.axis()?;
    }
    Ok(joint)
}

/// The joint at the end of a row of followers.
struct Leader<'a> {
    name: &'a str,
    multiplier: f64,
    offset: f64,
    limits: (f64, f64),
    /// What the followers in between leave of the follower's own values.
    bounds: (f64, f64),
    /// How fast the follower can be at most, by the joints that it follows.
    velocity: f64,
}

impl<'a> Leader<'a> {
    fn of<'t>(tree: &'t Tree<'a>, follower: &'t Declared<'a>) -> Result<Option<Self>> {
        let mut leader = Self {
            name: follower.name,
            multiplier: 1.0,
            offset: 0.0,
            limits: FREE,
            bounds: FREE,
            velocity: f64::INFINITY,
        };
        let mut current = follower;
        for _ in 0..=limits::FOLLOWERS.min(tree.joint_count()) {
            if !std::ptr::eq(current, follower) && leader.multiplier != 0.0 {
                let fastest = leader.multiplier.abs() * current.velocity()?;
                leader.velocity = leader.velocity.min(fastest);
            }
            let Some(element) = current.element.child("mimic") else {
                if std::ptr::eq(current, follower) {
                    return Ok(None);
                }
                let kind = current.kind()?;
                leader.name = current.name;
                leader.limits =
                    current.limits(kind)?.ok_or_else(|| current.without_limits(kind))?;
                return Ok(Some(leader));
            };
            if !std::ptr::eq(current, follower)
                && let Some(limits) = current.limits(current.kind()?)?
            {
                let (lower, upper) = image(limits, leader.multiplier, leader.offset);
                leader.bounds = (leader.bounds.0.max(lower), leader.bounds.1.min(upper));
            }
            let place = format!("{}: <mimic>", current.place());
            let source = element
                .attribute("joint")
                .ok_or_else(|| fault(format!("{place} names no joint")))?;
            let factor = current.number(element, "multiplier")?.unwrap_or(1.0);
            let offset = current.number(element, "offset")?.unwrap_or(0.0);
            leader.offset += leader.multiplier * offset;
            leader.multiplier *= factor;
            current = tree.joint(source, &place)?;
            if current.kind()? == JointKind::Fixed {
                let source = quoted(source);
                return Err(fault(format!("{place} follows {source}, which does not move")));
            }
        }
        let place = follower.place();
        let most = limits::FOLLOWERS;
        Err(fault(if tree.joint_count() <= most {
            format!("{place}: <mimic> leads back to itself")
        } else {
            format!("{place}: <mimic> leads back to itself or over more than {most} joints")
        }))
    }

    fn into_mimic(self) -> Mimic {
        Mimic {
            source: self.name.to_string(),
            multiplier: self.multiplier,
            offset: self.offset,
            source_limits: Some(self.limits),
        }
    }
}

/// The values `multiplier * x + offset` of an interval.
fn image((lower, upper): (f64, f64), multiplier: f64, offset: f64) -> (f64, f64) {
    if multiplier == 0.0 {
        return (offset, offset);
    }
    let (a, b) = (multiplier * lower + offset, multiplier * upper + offset);
    (a.min(b), a.max(b))
}

impl Declared<'_> {
    /// Who it is, for messages.
    fn place(&self) -> String {
        format!("joint {} (line {})", quoted(self.name), self.element.line)
    }

    /// True unless it is fixed; what kinds there are is asked where a joint is used.
    pub(super) fn moves(&self) -> bool {
        self.element.attribute("type") != Some(JointKind::Fixed.as_str())
    }

    fn kind(&self) -> Result<JointKind> {
        let name = self.element.attribute("type").unwrap_or("");
        JointKind::from_name(name).ok_or_else(|| {
            let place = self.place();
            fault(match name {
                "" => format!("{place} has no type"),
                "floating" | "planar" => format!(
                    "{place} is {name}: it has several degrees of freedom and cannot lie between \
                     base and tip; choose a base_link below it"
                ),
                _ => format!(
                    "{place} has the unknown type {}; known are revolute, continuous, prismatic \
                     and fixed",
                    quoted(name)
                ),
            })
        })
    }

    /// Limits of a joint of that kind; `None` where it should state some and does not.
    fn limits(&self, kind: JointKind) -> Result<Option<(f64, f64)>> {
        if matches!(kind, JointKind::Continuous | JointKind::Fixed) {
            return Ok(Some(FREE));
        }
        let Some(element) = self.element.child("limit") else {
            return Ok(None);
        };
        let (lower, upper) = (self.limit(element, "lower")?, self.limit(element, "upper")?);
        if lower.is_none() && upper.is_none() {
            return Ok(None);
        }
        // The format's default; common for grippers, which give the upper limit alone.
        let (lower, upper) = (lower.unwrap_or(0.0), upper.unwrap_or(0.0));
        if lower > upper {
            let place = self.place();
            return Err(fault(format!("{place}: lower limit {lower} > upper limit {upper}")));
        }
        Ok(Some((lower, upper)))
    }

    /// Largest speed; infinite where none is stated. The format asks for the attribute, so that
    /// files of arms of which nobody knows it say 0.
    fn velocity(&self) -> Result<f64> {
        let stated = self.element.child("limit").map(|e| self.limit(e, "velocity"));
        match stated.transpose()?.flatten() {
            None | Some(0.0) => Ok(f64::INFINITY),
            Some(velocity) if velocity > 0.0 => Ok(velocity),
            Some(velocity) => {
                let place = self.place();
                let expected = "expected a number above 0, or 0 where nobody knows it";
                Err(fault(format!("{place}: <limit> velocity: {expected}, got {velocity}")))
            }
        }
    }

    fn without_limits(&self, kind: JointKind) -> Error {
        let or = if kind == JointKind::Revolute { " (or the type continuous)" } else { "" };
        fault(format!(
            "{} is {} and needs <limit lower=\"...\" upper=\"...\"/>{or}",
            self.place(),
            kind.as_str()
        ))
    }

    fn origin(&self) -> Result<IsometryMatrix3<f64>> {
        let Some(element) = self.element.child("origin") else {
            return Ok(IsometryMatrix3::identity());
        };
        let [x, y, z] = self.vector(element, "xyz")?.unwrap_or_default();
        let [roll, pitch, yaw] = self.vector(element, "rpy")?.unwrap_or_default();
        // Turns about fixed axes: Rz(yaw) Ry(pitch) Rx(roll).
        let rotation = Rotation3::from_euler_angles(roll, pitch, yaw);
        Ok(IsometryMatrix3::from_parts(Translation3::new(x, y, z), rotation))
    }

    fn axis(&self) -> Result<Unit<Vector3<f64>>> {
        let element = self.element.child("axis");
        let stated = element.map(|e| self.vector(e, "xyz")).transpose()?.flatten();
        // The format's default is x.
        let axis = Vector3::from(stated.unwrap_or([1.0, 0.0, 0.0]));
        let largest = axis.amax();
        if largest == 0.0 {
            let place = self.place();
            return Err(fault(format!("{place}: the axis is zero, expected a direction")));
        }
        // Scaled first, so that the squares of very short axes do not vanish.
        Ok(Unit::new_normalize(axis / largest))
    }

    fn number(&self, element: &Element, attribute: &str) -> Result<Option<f64>> {
        Ok(self.numbers::<1>(element, attribute)?.map(|[x]| x))
    }

    /// A number that may be infinite.
    fn limit(&self, element: &Element, attribute: &str) -> Result<Option<f64>> {
        let stated = element.attribute(attribute).and_then(|text| text.trim().parse().ok());
        match stated {
            Some(x) if f64::is_infinite(x) => Ok(Some(x)),
            _ => self.number(element, attribute),
        }
    }

    fn vector(&self, element: &Element, attribute: &str) -> Result<Option<[f64; 3]>> {
        self.numbers::<3>(element, attribute)
    }

    fn numbers<const N: usize>(
        &self,
        element: &Element,
        attribute: &str,
    ) -> Result<Option<[f64; N]>> {
        let Some(text) = element.attribute(attribute) else {
            return Ok(None);
        };
        let numbers: Option<Vec<f64>> = text
            .split_whitespace()
            .map(|word| word.parse().ok().filter(|x: &f64| x.is_finite()))
            .collect();
        numbers.and_then(|numbers| numbers.try_into().ok()).map(Some).ok_or_else(|| {
            let is_macro = text.contains("${") || text.contains("$(");
            let hint = if is_macro { " (a xacro expression: expand the file first)" } else { "" };
            let expected = if N == 1 { "a finite number" } else { "three finite numbers" };
            fault(format!(
                "{}: <{}> {attribute}: expected {expected}, got {}{hint}",
                self.place(),
                element.name,
                quoted(text)
            ))
        })
    }
}
