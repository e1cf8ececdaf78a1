//! Chains from what Python describes: Denavit-Hartenberg rows or a list of joints.

use agrik::chain::{Chain, DhConvention, DhRow, Joint, JointKind, Mimic};
use nalgebra::{IsometryMatrix3, Unit, Vector3};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::{Floats, array, real, transform, transform_or_identity, wrong_shape};
use crate::errors;

/// How far the square of a rounded unit vector's length may be from 1.
const UNIT: f64 = 4.0 * f64::EPSILON;

const KINDS: [&str; 4] = ["revolute", "continuous", "prismatic", "fixed"];

fn kind(py: Python<'_>, name: &str) -> PyResult<JointKind> {
    JointKind::from_name(name).ok_or_else(|| errors::unknown_name(py, "joint type", name, &KINDS))
}

/// Limits as the core wants them: none where the joint has none.
fn limits(kind: JointKind, lower: f64, upper: f64) -> (f64, f64) {
    match kind {
        JointKind::Revolute | JointKind::Prismatic => (lower, upper),
        JointKind::Continuous => (f64::NEG_INFINITY, f64::INFINITY),
        JointKind::Fixed => (0.0, 0.0),
    }
}

/// What the constructors share behind their joints.
pub struct Frame<'a, 'py> {
    pub name: &'a str,
    pub base: Option<&'a Bound<'py, PyAny>>,
    pub tool: Option<&'a Bound<'py, PyAny>>,
    pub variable_order: Option<Vec<String>>,
}

impl Frame<'_, '_> {
    fn chain(self, py: Python<'_>, joints: Vec<Joint>) -> PyResult<Chain> {
        let base = transform_or_identity("base", self.base)?;
        let tool = transform_or_identity("tool", self.tool)?;
        Chain::new(self.name, joints, base, tool, self.variable_order.as_deref())
            .map_err(|error| errors::from_core(py, error))
    }
}

/// Arguments that have one entry per row of a DH table.
pub struct DhTable<'a, 'py> {
    pub rows: &'a Bound<'py, PyAny>,
    pub joint_types: Vec<String>,
    pub joint_names: Vec<String>,
    pub lower: &'a Bound<'py, PyAny>,
    pub upper: &'a Bound<'py, PyAny>,
}

/// A chain from DH rows.
pub fn from_dh(
    py: Python<'_>,
    frame: Frame<'_, '_>,
    convention: &str,
    table: DhTable<'_, '_>,
) -> PyResult<(Chain, DhConvention)> {
    let convention = match convention {
        "standard" => DhConvention::Standard,
        "modified" => DhConvention::Modified,
        other => {
            return Err(errors::unknown_name(py, "convention", other, &["standard", "modified"]));
        }
    };
    let rows = Floats::new("rows", table.rows)?;
    let [count, 4] = *rows.shape() else {
        return Err(wrong_shape(py, "rows", rows.shape(), "(n, 4), columns a, alpha, d, theta"));
    };
    for (argument, names) in
        [("joint_types", &table.joint_types), ("joint_names", &table.joint_names)]
    {
        if names.len() != count {
            let received = format!("{} names", names.len());
            return Err(errors::argument(py, argument, &received, &format!("{count}, one a row")));
        }
    }
    let lower = Floats::of_shape("lower", table.lower, &[count])?;
    let upper = Floats::of_shape("upper", table.upper, &[count])?;
    let numbers: &[[f64; 4]] = rows.values()?.as_chunks().0;
    let mut joints = Vec::with_capacity(count);
    for (i, &[a, alpha, d, theta]) in numbers.iter().enumerate() {
        let kind = kind(py, &table.joint_types[i])?;
        let (low, high) = limits(kind, lower.values()?[i], upper.values()?[i]);
        let row = DhRow { a, alpha, d, theta };
        joints.push(row.joint(convention, &table.joint_names[i], kind, low, high));
    }
    Ok((frame.chain(py, joints)?, convention))
}

/// A chain from joints with origins and axes.
pub fn from_joints(
    py: Python<'_>,
    frame: Frame<'_, '_>,
    specs: &[Bound<'_, PyDict>],
) -> PyResult<Chain> {
    let joints = specs.iter().enumerate().map(|(i, spec)| joint(i, spec));
    frame.chain(py, joints.collect::<PyResult<_>>()?)
}

fn joint(index: usize, spec: &Bound<'_, PyDict>) -> PyResult<Joint> {
    let py = spec.py();
    let place = |field: &str| format!("joints[{index}][\"{field}\"]");
    let field = |name: &str| match spec.get_item(name)? {
        Some(value) => Ok(value),
        None => Err(errors::argument(py, &place(name), "nothing", "a value")),
    };
    let text = |name: &str| {
        let value = field(name)?;
        value.extract::<String>().map_err(|_| errors::value(&place(name), &value, "a string"))
    };
    let kind = kind(py, &text("type")?)?;
    let number = |name: &str| real(&place(name), &field(name)?);
    let (lower, upper) = limits(kind, number("lower")?, number("upper")?);
    let mut joint = Joint::new(text("name")?, kind, lower, upper);
    joint.origin = transform(&place("origin"), &field("origin")?)?;
    let axis = field("axis")?;
    let floats = Floats::of_shape(&place("axis"), &axis, &[3])?;
    let vector = Vector3::from_column_slice(floats.values()?);
    joint.axis = match Unit::try_new(vector, 1e-12) {
        // A unit vector stays as it is, to the last bit: files that this program wrote hold such.
        Some(_) if (vector.norm_squared() - 1.0).abs() <= UNIT => Unit::new_unchecked(vector),
        Some(unit) if unit.iter().all(|x| x.is_finite()) => unit,
        // A fixed joint's axis means nothing.
        _ if kind == JointKind::Fixed => Vector3::z_axis(),
        _ => {
            let expected = "a finite direction of non-zero length";
            return Err(errors::value(&place("axis"), &axis, expected));
        }
    };
    if let Some(link) = spec.get_item("link")?.filter(|link| !link.is_none()) {
        joint.child_link = link
            .extract::<String>()
            .map_err(|_| errors::value(&place("link"), &link, "None or a string"))?;
    }
    joint.mimic = match spec.get_item("mimic")? {
        Some(rule) if !rule.is_none() => {
            let (source, multiplier, offset) =
                rule.extract::<(String, f64, f64)>().map_err(|_| {
                    errors::value(&place("mimic"), &rule, "None or (joint, multiplier, offset)")
                })?;
            Some(Mimic { source, multiplier, offset, source_limits: None })
        }
        _ => None,
    };
    Ok(joint)
}

/// The joints of a chain as [`from_joints`] takes them; of those from standard rows the second
/// constant transform is left out.
pub fn specs<'py>(py: Python<'py>, chain: &Chain) -> PyResult<Vec<Bound<'py, PyDict>>> {
    chain.joints().iter().map(|joint| spec(py, joint)).collect()
}

fn spec<'py>(py: Python<'py>, joint: &Joint) -> PyResult<Bound<'py, PyDict>> {
    let fields = PyDict::new(py);
    let rule = joint.mimic.as_ref();
    fields.set_item("name", &joint.name)?;
    fields.set_item("type", joint.kind.as_str())?;
    fields.set_item("origin", array(py, &[4, 4], rows_of(&joint.origin))?)?;
    fields.set_item("axis", array(py, &[3], joint.axis.as_slice().to_vec())?)?;
    fields.set_item("lower", joint.lower)?;
    fields.set_item("upper", joint.upper)?;
    fields.set_item("mimic", rule.map(|m| (m.source.as_str(), m.multiplier, m.offset)))?;
    fields.set_item("link", &joint.child_link)?;
    Ok(fields)
}

/// A transform's rows, one after the other.
pub fn rows_of(transform: &IsometryMatrix3<f64>) -> Vec<f64> {
    transform.to_homogeneous().transpose().as_slice().to_vec()
}
