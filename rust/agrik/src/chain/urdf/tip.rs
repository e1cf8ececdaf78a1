//! Which link is meant as the tip where a file has several and nobody names one.
//!
//! The arm is followed from its base along the joints that move. Where it parts, the parts are
//! the fingers of a hand, if they have no more joints than the arm before them, or else all but
//! one are small things that ride along (a camera's tilt, a wheel). A file in which two parts
//! could be arms names no tip by itself.

use std::collections::{HashMap, HashSet};

use super::text::{listing, quoted};
use super::tree::Tree;
use super::{fault, limits};
use crate::error::Result;

/// Links that people name for the tool, the likeliest first; `x`, `left_x`, `link_x`, `x_link`
/// and `x_frame` are all read as `x`.
const NAMES: [&str; 8] =
    ["tool0", "tcp", "tool", "flange", "end_effector", "eef", "ee", "gripper_frame"];
/// Joints of an arm, at least: what parts after as many is a hand.
const ARM: usize = 3;
/// Joints of a thing that rides along, at most.
const SMALL: usize = 2;

/// The links between which a chain lies.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ends {
    /// First link.
    pub base: String,
    /// Last link.
    pub tip: String,
    /// The other leaf links of the file that joints move: what else the tip could be, no more
    /// than a message lists. Empty where the tip was named.
    pub others: Vec<String>,
    /// Joints between the two whose limits are both 0.
    pub locked: Vec<String>,
}

/// What one link carries.
#[derive(Default)]
struct Below<'a> {
    /// Child links, and whether the joint before them moves.
    children: Vec<(&'a str, bool)>,
    /// Moving joints in a row, at most, on the ways down.
    joints: usize,
}

/// The tip below a base, and the leaves it was chosen from.
pub(super) fn choose<'a>(tree: &Tree<'a>, base: &'a str) -> Result<(&'a str, Vec<&'a str>)> {
    let arms = Arms::new(tree, base);
    let leaves: Vec<&str> = arms.order.iter().copied().filter(|l| arms.is_leaf(l)).collect();
    let moved: Vec<&str> = leaves.iter().copied().filter(|l| arms.above[l] > 0).collect();
    match (&leaves[..], &moved[..]) {
        // One link, and one leaf that nothing moves: the caller says what is wrong with them.
        ([only], _) if *only == base => {
            Err(fault(format!("no joint below base link {}", quoted(base))))
        }
        ([only], _) | (_, [only]) => Ok((only, moved)),
        (_, []) => Err(ambiguous(&leaves)),
        _ => match arms.end(base) {
            Some(tip) => Ok((tip, moved)),
            None => Err(ambiguous(&moved)),
        },
    }
}

fn ambiguous(leaves: &[&str]) -> crate::error::Error {
    fault(format!(
        "{} links could be the tip, name one as tip_link: {}",
        leaves.len(),
        listing(leaves.iter().copied()),
    ))
}

/// The tree below a base.
struct Arms<'a> {
    /// The links, each after the one that carries it.
    order: Vec<&'a str>,
    below: HashMap<&'a str, Below<'a>>,
    /// Moving joints between the base and a link.
    above: HashMap<&'a str, usize>,
}

impl<'a> Arms<'a> {
    fn new(tree: &Tree<'a>, base: &'a str) -> Self {
        let mut below: HashMap<&str, Below<'_>> = HashMap::new();
        for (parent, child, moves) in tree.connections() {
            below.entry(parent).or_default().children.push((child, moves));
        }
        let mut order = vec![base];
        let mut above = HashMap::from([(base, 0)]);
        let mut next = 0;
        while let Some(&link) = order.get(next) {
            next += 1;
            let before = above[link];
            for &(child, moves) in below.get(link).map_or(&[][..], |b| &b.children) {
                order.push(child);
                above.insert(child, before + usize::from(moves));
            }
        }
        let mut arms = Self { order, below, above };
        for at in (0..arms.order.len()).rev() {
            let link = arms.order[at];
            let joints = arms.parts(link).map(|(_, joints)| joints).max().unwrap_or(0);
            arms.below.entry(link).or_default().joints = joints;
        }
        arms
    }

    fn children(&self, link: &str) -> &[(&'a str, bool)] {
        self.below.get(link).map_or(&[], |b| &b.children)
    }

    fn is_leaf(&self, link: &str) -> bool {
        self.children(link).is_empty()
    }

    /// What a link carries: the first link of each part, and its moving joints in a row.
    fn parts(&self, link: &str) -> impl Iterator<Item = (&'a str, usize)> {
        self.children(link).iter().map(|&(child, moves)| {
            (child, self.below.get(child).map_or(0, |b| b.joints) + usize::from(moves))
        })
    }

    /// The last link of the arm that starts at the base; `None` where there could be two.
    fn end(&self, base: &'a str) -> Option<&'a str> {
        let mut trunk = HashSet::from([base]);
        let mut link = base;
        let mut hand = false;
        loop {
            let mut parts: Vec<_> = self.parts(link).filter(|&(_, joints)| joints > 0).collect();
            parts.sort_by_key(|&(_, joints)| std::cmp::Reverse(joints));
            let before = self.above[link];
            match parts[..] {
                [] => break,
                [_] => {}
                [(_, most), ..] if before >= ARM && most <= before => {
                    hand = true;
                    break;
                }
                [(_, most), (_, next), ..] if most >= ARM && next <= SMALL && next < most => {}
                _ => return None,
            }
            link = parts[0].0;
            trunk.insert(link);
        }
        Some(self.named(base, &trunk, self.above[link]).unwrap_or_else(|| {
            // Behind a hand's palm there is nothing to choose.
            if hand { link } else { self.fixed_end(link) }
        }))
    }

    /// The link with a tool's name that stands on the trunk or is fixed to it, in the half
    /// of the trunk that ends with the hand; of two with one name the later.
    fn named(&self, base: &'a str, trunk: &HashSet<&'a str>, joints: usize) -> Option<&'a str> {
        let mut rigid: HashSet<&str> = HashSet::from([base]);
        let mut best: Option<(usize, &str)> = None;
        for &link in &self.order {
            if !trunk.contains(link) && !rigid.contains(link) {
                continue;
            }
            rigid.extend(self.children(link).iter().filter(|(_, moves)| !moves).map(|(c, _)| c));
            let above = self.above[link];
            if let Some(rank) = rank(link)
                && above > 0
                && 2 * above >= joints
                && best.is_none_or(|(least, _)| rank <= least)
            {
                best = Some((rank, link));
            }
        }
        best.map(|(_, link)| link)
    }

    /// The only leaf that is fixed to a link, or the link.
    fn fixed_end(&self, link: &'a str) -> &'a str {
        let mut ends = Vec::new();
        let mut waiting = vec![link];
        while let Some(link) = waiting.pop() {
            if self.is_leaf(link) {
                ends.push(link);
            }
            waiting.extend(self.children(link).iter().map(|(child, _)| child));
        }
        if let [only] = ends[..] { only } else { link }
    }
}

/// Place in [`NAMES`] of the name that a link has.
fn rank(link: &str) -> Option<usize> {
    let lower = link.to_lowercase();
    let name = lower.rsplit('/').next().unwrap_or_default();
    let name = name.strip_prefix("link_").unwrap_or(name);
    let name = name.strip_suffix("_link").unwrap_or(name);
    let place = |name: &str| {
        NAMES.iter().position(|known| {
            name.strip_suffix(known)
                .is_some_and(|rest| rest.is_empty() || rest.ends_with(['_', '-']))
        })
    };
    place(name).or_else(|| place(name.strip_suffix("_frame")?))
}

/// As many names as a message lists.
pub(super) fn few(names: &[&str]) -> Vec<String> {
    names.iter().take(limits::NAMED).map(|&name| name.to_string()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_tools() {
        let same = ["tool0", "left_tool0", "arm/tool0", "TOOL0", "ur_tool0_link"];
        assert!(same.iter().all(|name| rank(name) == Some(0)));
        assert_eq!(rank("link_eef"), rank("eef"));
        assert_eq!(rank("gripper_frame_link"), Some(7));
        assert_eq!(rank("wrist_frame"), None);
        assert_eq!(rank("knee"), None);
    }
}
