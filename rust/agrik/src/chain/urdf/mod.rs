//! Chains from URDF texts, also from those that other tools wrote loosely.
//!
//! Read are the links, the joints and what moves them; meshes, inertia, transmissions and
//! elements of other vocabularies are passed over. The whole file must be one tree, but
//! the numbers of a joint matter only where it lies between base and tip.

mod joint;
mod limits;
mod text;
mod tip;
mod tree;
mod xml;

use nalgebra::IsometryMatrix3;

pub use tip::Ends;

use super::Chain;
use crate::error::{Error, Result};

/// The chain from `base_link` to `tip_link`, and which links those are; see
/// [`Chain::from_urdf`].
pub(super) fn parse(
    text: &str,
    base_link: Option<&str>,
    tip_link: Option<&str>,
) -> Result<(Chain, Ends)> {
    let root = xml::read(text)?;
    let tree = tree::Tree::new(&root)?;
    let base = tree.base(base_link)?;
    let (tip, leaves) = match tip_link {
        Some(name) => (tree.tip(name)?, Vec::new()),
        None => tip::choose(&tree, base)?,
    };
    let path = tree.path(base, tip)?;
    if path.len() > limits::PATH {
        let (most, count) = (limits::PATH, path.len());
        return Err(fault(format!("{count} joints between base and tip, expected at most {most}")));
    }
    let joints = path
        .into_iter()
        .map(|(declared, against)| {
            let joint = joint::build(&tree, declared)?;
            Ok(if against { joint.reversed(declared.parent) } else { joint })
        })
        .collect::<Result<Vec<_>>>()?;
    if joints.iter().all(|j| j.kind == super::JointKind::Fixed) {
        let names = text::listing(joints.iter().map(|j| j.name.as_str()));
        return Err(fault(format!("no movable joint between base and tip, only {names}")));
    }
    let others: Vec<&str> = leaves.into_iter().filter(|&leaf| leaf != tip).collect();
    let ends = Ends {
        base: base.to_string(),
        tip: tip.to_string(),
        others: tip::few(&others),
        locked: joints.iter().filter(|j| is_locked(j)).map(|j| j.name.clone()).collect(),
    };
    let identity = IsometryMatrix3::identity();
    let chain =
        Chain::new(tree.name, joints, identity, identity, None).map_err(|error| match error {
            Error::Argument { .. } => fault(error.to_string()),
            other => other,
        })?;
    Ok((chain, ends))
}

/// True for a joint that could move but for its limits, both 0: what files say of joints that
/// nobody gave limits.
fn is_locked(joint: &super::Joint) -> bool {
    joint.kind != super::JointKind::Fixed
        && joint.mimic.is_none()
        && (joint.lower, joint.upper) == (0.0, 0.0)
}

/// The error of a URDF text that does not describe a usable chain.
fn fault(message: impl Into<String>) -> Error {
    Error::Description { format: "URDF", message: message.into() }
}
