//! Links and joints as one tree, and the path from a base to a tip in it.

use std::collections::{HashMap, HashSet};

use super::text::{listing, quoted, suggestion};
use super::xml::Element;
use super::{fault, limits};
use crate::error::Result;

/// A `<joint>` and the links it connects.
#[derive(Debug)]
pub(super) struct Declared<'a> {
    pub name: &'a str,
    pub child: &'a str,
    pub parent: &'a str,
    pub element: &'a Element,
}

/// The checked structure of a file: one root, and one way from it to every link.
#[derive(Debug)]
pub(super) struct Tree<'a> {
    /// Name of the robot.
    pub name: &'a str,
    links: Vec<&'a str>,
    joints: Vec<Declared<'a>>,
    /// Which joint carries a link.
    carrier: HashMap<&'a str, usize>,
    /// Which joint has a name.
    by_name: HashMap<&'a str, usize>,
}

impl<'a> Tree<'a> {
    pub fn new(robot: &'a Element) -> Result<Self> {
        let links = links_of(robot)?;
        let mut tree = Self {
            name: short(robot, robot.attribute("name").unwrap_or("robot"))?,
            joints: Vec::new(),
            carrier: HashMap::new(),
            by_name: HashMap::new(),
            links,
        };
        let known: HashSet<&str> = tree.links.iter().copied().collect();
        for element in robot.children.iter().filter(|e| e.name == "joint") {
            let joint = tree.declared(element, &known)?;
            let index = tree.joints.len();
            if let Some(other) = tree.carrier.insert(joint.child, index) {
                return Err(fault(format!(
                    "link {} is the child of two joints, {} and {}: not a tree",
                    quoted(joint.child),
                    quoted(tree.joints[other].name),
                    quoted(joint.name),
                )));
            }
            if tree.by_name.insert(joint.name, index).is_some() {
                let (name, line) = (quoted(joint.name), element.line);
                return Err(fault(format!("line {line}: a second joint named {name}")));
            }
            tree.joints.push(joint);
        }
        tree.check_acyclic()?;
        let roots: Vec<&str> = tree.roots().collect();
        if roots.len() > 1 {
            return Err(fault(format!(
                "disconnected: {} links have no parent joint ({}), expected one root",
                roots.len(),
                listing(roots),
            )));
        }
        Ok(tree)
    }

    /// The joint of a name; `place` says who asks.
    pub fn joint(&self, name: &str, place: &str) -> Result<&Declared<'a>> {
        self.by_name.get(name).map(|&i| &self.joints[i]).ok_or_else(|| {
            let hint = suggestion(name, self.joints.iter().map(|j| j.name));
            fault(format!("{place}: unknown joint {}{hint}", quoted(name)))
        })
    }

    /// How many joints there are.
    pub fn joint_count(&self) -> usize {
        self.joints.len()
    }

    /// The link of a name, or the only root.
    pub fn base(&self, name: Option<&str>) -> Result<&'a str> {
        match name {
            Some(name) => self.link("base", name),
            // `new` made sure that there is one.
            None => Ok(self.roots().next().unwrap_or_default()),
        }
    }

    /// The link of a name, which is a tip.
    pub fn tip(&self, name: &str) -> Result<&'a str> {
        self.link("tip", name)
    }

    /// Parent, child and whether it moves, of every joint.
    pub fn connections(&self) -> impl Iterator<Item = (&'a str, &'a str, bool)> {
        self.joints.iter().map(|joint| (joint.parent, joint.child, joint.moves()))
    }

    /// The joints from base to tip, in order, and whether the way goes through each of them
    /// against its direction: up to the link that both are below, and down from it.
    pub fn path(&self, base: &'a str, tip: &'a str) -> Result<Vec<(&Declared<'a>, bool)>> {
        if tip == base {
            let name = quoted(base);
            return Err(fault(format!("base link and tip link are both {name}: no joint between")));
        }
        let (mut up, mut down) = (self.ancestry(base), self.ancestry(tip));
        // What both have in common ends at the root.
        while let (Some(a), Some(b)) = (up.last(), down.last())
            && a == b
        {
            up.pop();
            down.pop();
        }
        let up = up.into_iter().map(|index| (&self.joints[index], true));
        let down = down.into_iter().rev().map(|index| (&self.joints[index], false));
        Ok(up.chain(down).collect())
    }

    /// The joints between a link and the root.
    fn ancestry(&self, mut link: &'a str) -> Vec<usize> {
        let mut joints = Vec::new();
        while let Some(&index) = self.carrier.get(link) {
            joints.push(index);
            link = self.joints[index].parent;
        }
        joints
    }

    fn link(&self, role: &str, name: &str) -> Result<&'a str> {
        self.links.iter().copied().find(|&link| link == name).ok_or_else(|| {
            let hint = suggestion(name, self.links.iter().copied());
            let separator = if hint.is_empty() { "." } else { "" };
            let known = listing(self.links.iter().copied());
            fault(format!("unknown {role} link {}{hint}{separator} Links: {known}", quoted(name)))
        })
    }

    fn roots(&self) -> impl Iterator<Item = &'a str> {
        self.links.iter().copied().filter(|link| !self.carrier.contains_key(link))
    }

    fn declared(&self, element: &'a Element, links: &HashSet<&str>) -> Result<Declared<'a>> {
        let line = element.line;
        let name = named(element)?;
        let link_of = |end: &str| {
            let place = format!("joint {} (line {line})", quoted(name));
            let link = element.child(end).and_then(|e| e.attribute("link"));
            let link = link.ok_or_else(|| fault(format!("{place}: no <{end} link=\"...\"/>")))?;
            if links.contains(link) {
                return Ok(link);
            }
            let hint = suggestion(link, self.links.iter().copied());
            Err(fault(format!("{place}: unknown {end} link {}{hint}", quoted(link))))
        };
        Ok(Declared { name, parent: link_of("parent")?, child: link_of("child")?, element })
    }

    /// Every link has at most one carrier, so a link from which the way up does not end
    /// lies on or below a cycle.
    fn check_acyclic(&self) -> Result<()> {
        // The walk that first saw a link.
        let mut seen: HashMap<&str, usize> = HashMap::new();
        for (walk, &start) in self.links.iter().enumerate() {
            let mut link = start;
            loop {
                match seen.insert(link, walk) {
                    Some(earlier) if earlier == walk => {
                        return Err(fault(format!("cyclic: {}", self.cycle(link))));
                    }
                    Some(_) => break,
                    None => {}
                }
                let Some(&index) = self.carrier.get(link) else {
                    break;
                };
                link = self.joints[index].parent;
            }
        }
        Ok(())
    }

    /// The cycle through a link, in words.
    fn cycle(&self, link: &str) -> String {
        let mut names = Vec::new();
        let mut current = link;
        while let Some(&index) = self.carrier.get(current) {
            names.push(self.joints[index].name);
            current = self.joints[index].parent;
            if current == link {
                break;
            }
        }
        names.reverse();
        format!("from link {} joints {} lead back to it", quoted(link), listing(names))
    }
}

fn links_of(robot: &Element) -> Result<Vec<&str>> {
    let mut lines: HashMap<&str, usize> = HashMap::new();
    let mut links = Vec::new();
    for element in robot.children.iter().filter(|e| e.name == "link") {
        let name = named(element)?;
        if let Some(first) = lines.insert(name, element.line) {
            let (name, line) = (quoted(name), element.line);
            return Err(fault(format!(
                "line {line}: a second link named {name}, the first is on line {first}"
            )));
        }
        links.push(name);
    }
    if links.is_empty() {
        let is_macro = robot.children.iter().any(|e| e.name.starts_with("xacro:"));
        let hint = if is_macro { "; this looks like a xacro file, expand it first" } else { "" };
        return Err(fault(format!("no <link> in <robot>{hint}")));
    }
    Ok(links)
}

fn named(element: &Element) -> Result<&str> {
    let (kind, line) = (&element.name, element.line);
    let name = element
        .attribute("name")
        .filter(|name| !name.trim().is_empty())
        .ok_or_else(|| fault(format!("line {line}: <{kind}> without a name")))?;
    short(element, name)
}

/// The name of an element, if it is of a length that messages and headers can bear.
fn short<'a>(element: &Element, name: &'a str) -> Result<&'a str> {
    if name.len() <= limits::NAME {
        return Ok(name);
    }
    let (kind, line) = (&element.name, element.line);
    let (most, size) = (limits::NAME, name.len());
    Err(fault(format!(
        "line {line}: <{kind}> with a name of {size} bytes, expected at most {most}"
    )))
}
