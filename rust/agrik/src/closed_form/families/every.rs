//! What a chain of joints that turn is, joint by joint: for all its branches.

use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

use super::six::{Six, Way};
use crate::chain::{Chain, Link};
use crate::closed_form::geometry::limit::Limit;
use crate::closed_form::geometry::rigid::Rigid;
use crate::closed_form::geometry::screws::{Screw, Screws};
use crate::kinematics::{Workspace, forward};
use crate::lanes::{V3, cross, dot, sub};
use crate::random::Sequence;

/// A chain all of whose joints turn, each by an entry of `q` of its own.
#[derive(Debug)]
pub struct Every {
    /// Its axes; as tool the last joint's frame.
    pub screws: Screws,
    /// Which entry of `q` each joint is.
    pub order: Vec<usize>,
    /// Limits along the chain.
    pub limits: Vec<Limit>,
    /// The arm of six joints.
    six: OnceLock<Result<Six, String>>,
    /// The same where it has a closed form: found without the trials of the general way.
    closed: OnceLock<Option<Six>>,
    /// Of seven joints: the arm with a joint locked at 0 or in the middle of its limits.
    locked: Vec<OnceLock<Result<Six, String>>>,
    /// The three joints that move the tool point best, along the chain.
    pub movers: [usize; 3],
}

/// Random postures that tell which joints move the tool point best.
const TRIALS: usize = 16;

impl Every {
    /// What a chain is, or why it cannot be told; found once for each chain.
    pub fn of(chain: &Chain) -> Result<&Self, &str> {
        chain.memo(Self::recognise).as_ref().map_err(String::as_str)
    }

    fn recognise(chain: &Chain) -> Result<Self, String> {
        let compiled = chain.compiled();
        let variables = chain.variables();
        if let Some(slide) = compiled.links.iter().find(|link| link.prismatic) {
            let name = &variables[slide.variable].name;
            return Err(format!("its joint '{name}' slides"));
        }
        let alone = compiled.links.len() == compiled.dof
            && compiled.links.iter().all(|link| link.multiplier == 1.0);
        if !alone {
            return Err("a joint follows another".to_owned());
        }
        let mut workspace = Workspace::<f64>::new(compiled);
        forward(compiled, &vec![0.0; compiled.dof], &mut workspace);
        let joints = workspace.axes.iter();
        let joints = joints.map(|axis| Screw { axis: axis.direction, point: axis.origin });
        let tool = Rigid { axes: workspace.joint_axes(), shift: workspace.tool_point([0.0; 3]) };
        let order: Vec<usize> = compiled.links.iter().map(|link| link.variable).collect();
        let movers = movers(chain);
        Ok(Self {
            movers,
            screws: Screws { joints: joints.collect(), tool },
            limits: order.iter().map(|i| Limit::of(&variables[*i])).collect(),
            locked: order.iter().map(|_| OnceLock::new()).collect(),
            order,
            six: OnceLock::new(),
            closed: OnceLock::new(),
        })
    }

    /// How many joints.
    pub fn joints(&self) -> usize {
        self.order.len()
    }

    /// The arm of six joints, or why it is none.
    pub fn six(&self) -> Result<&Six, &str> {
        let made = self.six.get_or_init(|| Six::new(&self.screws, None));
        made.as_ref().map_err(String::as_str)
    }

    /// The arm of six joints, if it has a closed form.
    pub fn closed(&self) -> Option<&Six> {
        let made = || if self.joints() == 6 { Six::closed(&self.screws).ok() } else { None };
        self.closed.get_or_init(made).as_ref()
    }

    /// The arm of seven joints with one locked at its [`Self::rest`]: what arms locked at other
    /// values are like.
    pub fn locked(&self, joint: usize) -> Result<&Six, &str> {
        let made = self.locked[joint].get_or_init(|| {
            let at = self.rest(joint);
            Six::new(&self.screws.locked(joint, at), None)
        });
        made.as_ref().map_err(String::as_str)
    }

    /// Value at which a joint is locked when nothing else is said: the middle of its limits; the
    /// first and the last joint at 0 there, since they move the target alone.
    pub fn rest(&self, joint: usize) -> f64 {
        if joint == 0 || joint + 1 == self.joints() { 0.0 } else { self.limits[joint].middle }
    }

    /// The joint of seven that is locked when nothing else is said: the last, which moves the
    /// target alone, so that one arm of six joints serves for all values; the third where what
    /// the last leaves is nearly spherical and slow.
    pub fn default_lock(&self) -> usize {
        let last = self.joints() - 1;
        let slow = match self.locked(last).map(Six::way) {
            Ok(Way::Ring(ring)) => ring.has_idle_roots(),
            Ok(_) => false,
            Err(_) => true,
        };
        if slow { 2 } else { last }
    }
}

/// The three joints whose turns span the largest volume of the tool point's ways, summed over
/// random postures; the first of several. Joints that their limits hold move nothing.
fn movers(chain: &Chain) -> [usize; 3] {
    let compiled = chain.compiled();
    let count = compiled.links.len();
    let mut random = Sequence::new(5);
    let mut workspace = Workspace::<f64>::new(compiled);
    let mut ways = Vec::with_capacity(TRIALS);
    for _ in 0..TRIALS {
        let q: Vec<f64> = (0..compiled.dof).map(|_| TAU * random.uniform() - PI).collect();
        forward(compiled, &q, &mut workspace);
        let tool = workspace.tool_point(compiled.tail.translation);
        let moves = |link: &Link| {
            let joint = &chain.variables()[link.variable];
            if joint.lower < joint.upper { 1.0 } else { 0.0 }
        };
        let axes = workspace.axes.iter().zip(&compiled.links);
        let ways_of = axes.map(|(axis, link)| {
            cross(axis.direction, sub(tool, axis.origin)).map(|x| moves(link) * x)
        });
        ways.push(ways_of.collect::<Vec<_>>());
    }
    let mut best = ([0, 1, 2], 0.0);
    for a in 0..count {
        for b in a + 1..count {
            for c in b + 1..count {
                let volume = |way: &Vec<V3<f64>>| dot(way[a], cross(way[b], way[c])).abs();
                let all: f64 = ways.iter().map(volume).sum();
                // Rounding does not decide.
                if all > best.1 * (1.0 + 1e-9) {
                    best = ([a, b, c], all);
                }
            }
        }
    }
    best.0
}
