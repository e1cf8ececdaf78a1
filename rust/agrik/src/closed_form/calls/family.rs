//! What an arm was recognised as, in words.

use super::few_joints::BRANCHES;
use crate::chain::Chain;
use crate::closed_form::families::every::Every;
use crate::closed_form::families::short::{Lines, TURNING};
use crate::closed_form::families::six::{Six, Way};
use crate::closed_form::families::{ClosedForm, Lead};

/// What is known of the branches of an arm.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Family {
    /// Short name, such as "three parallel axes".
    pub name: String,
    /// How its branches are found.
    pub method: &'static str,
    /// Why it was recognised as such, or is not supported.
    pub reason: String,
    /// Most branches of a target, at a value of the locked joint; 0 where none are found.
    pub branches: usize,
    /// Entry of `q` that is locked where nothing is said.
    pub locked: Option<usize>,
}

const CLOSED: &str = "closed form";
const RING: &str = "ring-cut resultant";
const CELLS: &str = "cells of joint values left out by bounds";
const BOTH: &str = "closed form for points; for more, cells of joint values left out by bounds";

impl Family {
    /// The family of a chain.
    pub fn of(chain: &Chain) -> Self {
        if let Ok(form) = ClosedForm::of(chain)
            && !form.is_rough()
        {
            let (method, reason) = match form {
                ClosedForm::Srs(_) => (
                    "closed form at each arm angle",
                    "its first three and its last three axes meet",
                ),
                ClosedForm::SphericalWrist(_) => (CLOSED, "its last three axes meet"),
            };
            return Self {
                name: form.name().to_owned(),
                method,
                reason: reason.to_owned(),
                branches: form.branches(),
                locked: None,
            };
        }
        let unsupported = |reason: String| Self {
            name: "unsupported".to_owned(),
            method: "none",
            reason,
            branches: 0,
            locked: None,
        };
        let every = match Every::of(chain) {
            Ok(every) => every,
            Err(why) => {
                if chain.dof() == 1 && Lines::of(chain).is_ok() {
                    return Self::of_few("a slide", "one joint that slides");
                }
                let lead = Lead::of(chain).ok().filter(|lead| lead.way().is_some());
                let Some(lead) = lead else { return unsupported(why.to_owned()) };
                let rest = Self::of(lead.rest());
                let joints = lead.rest().dof();
                let few = joints <= TURNING && Lines::of(chain).is_ok();
                if rest.branches == 0 || !few && joints != 5 && joints != 6 {
                    return unsupported(why.to_owned());
                }
                let locked = if joints == 5 { "; with the slide locked" } else { "" };
                return Self {
                    name: format!("slide before {}", rest.name),
                    method: if few { CELLS } else { rest.method },
                    reason: format!("its first joint slides; behind it {}{locked}", rest.reason),
                    locked: Some(lead.variable()),
                    ..rest
                };
            }
        };
        match every.joints() {
            6 => every.six().map_or_else(|why| unsupported(why.to_owned()), Self::of_six),
            7 => {
                let joint = every.default_lock();
                let variable = every.order[joint];
                let name = &chain.variables()[variable].name;
                let six = every.locked(joint);
                six.map_or_else(
                    |why| unsupported(why.to_owned()),
                    |six| {
                        let of = Self::of_six(six);
                        Self {
                            name: format!("7R, {} when '{name}' is locked", of.name),
                            locked: Some(variable),
                            ..of
                        }
                    },
                )
            }
            5 => Self {
                name: "5R".to_owned(),
                method: "a joint about the tool axis added, then as six joints",
                reason: "five joints that turn: a point and the direction of the tool axis; a \
                         pose is overdetermined"
                    .to_owned(),
                branches: 16,
                locked: None,
            },
            4 => {
                let spare = (0..4).find(|k| !every.movers.contains(k)).map(|k| every.order[k]);
                let name = spare.map_or("", |variable| &chain.variables()[variable].name);
                Self {
                    name: format!("4R, 3R when '{name}' is locked"),
                    method: BOTH,
                    reason: "four joints that turn: a point, with a self-motion of one dimension; \
                             an axis or a pose is overdetermined"
                        .to_owned(),
                    branches: 8,
                    locked: spare,
                }
            }
            3 => Self {
                name: "3R".to_owned(),
                method: BOTH,
                reason: "three joints that turn: a point; an axis or a pose is overdetermined"
                    .to_owned(),
                branches: 8,
                locked: None,
            },
            2 => Self::of_few("2R", "two joints that turn"),
            1 => Self::of_few("1R", "one joint that turns"),
            n => unsupported(format!("{n} joints that turn")),
        }
    }

    /// Fewer joints than any task needs.
    fn of_few(name: &str, joints: &str) -> Self {
        Self {
            name: name.to_owned(),
            method: CELLS,
            reason: format!("{joints}: points, axes and poses are overdetermined"),
            branches: BRANCHES,
            locked: None,
        }
    }

    fn of_six(six: &Six) -> Self {
        let (method, reason) = match six.way() {
            Way::Meeting(arm) if arm.is_reversed() => {
                (CLOSED, "its first three axes meet".to_owned())
            }
            Way::Meeting(_) => (CLOSED, "its last three axes meet".to_owned()),
            Way::ThreeParallel(_) => {
                (CLOSED, "its axes 2, 3 and 4 are parallel, and 5 and 6 meet".to_owned())
            }
            Way::Ring(_) => (RING, six.why().to_owned()),
        };
        let (name, branches) = (six.name().to_owned(), six.branches());
        Self { name, method, reason, branches, locked: None }
    }
}
