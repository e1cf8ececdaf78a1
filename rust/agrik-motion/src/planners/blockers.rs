//! What stands in the way of a path: the fewest removable objects without which there is one.
//!
//! Two families of sets grow. *Ways*: the objects that a path meets which was found without all
//! others' regard. *Cores*: sets of which one object at least has to go, since no path was
//! found with all of them in their places and everything else gone. The fewest objects of which
//! every core has one are what may be enough, and no fewer can be. They are tried: either there
//! is a path, and no set is smaller, or a new core is found that they have nothing of. A core
//! is looked for among few objects of which every known way meets one: with these in their
//! places there is either no path, or a way that is new.

use super::ask::Settings;
use super::cut::cut;
use super::hitting::{Least, Set, few, least};
use super::plan::{Planned, plan};
use super::words::PathStatus;
use crate::edges::{Verdict, check_path};
use crate::{Collider, Result};

/// Questions of all plans together, in those that one plan may ask.
const EFFORT: u64 = 8;
/// Goals of one plan, spread over those that there are.
const GOALS: usize = 96;

/// What is known of the number of objects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Fewest {
    /// It is proven that no smaller set opens a path to the goals.
    Proven = 0,
    /// No path was found without any smaller set, which is no proof.
    Searched = 1,
    /// The effort was spent before all smaller sets were ruled out.
    Stopped = 2,
}

impl Fewest {
    /// Every one, in the order of its codes.
    pub const ALL: [Self; 3] = [Self::Proven, Self::Searched, Self::Stopped];

    /// The name that users and files know it by.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Proven => "PROVEN",
            Self::Searched => "SEARCHED",
            Self::Stopped => "STOPPED",
        }
    }
}

/// Objects to be taken out of the way.
#[derive(Debug, Clone, PartialEq)]
pub struct PathBlockers {
    /// Their indices, in order.
    pub objects: Vec<usize>,
    /// The path that there is without them; its goal is one of all goals given.
    pub path: Planned,
    /// What is known of their number.
    pub fewest: Fewest,
    /// With fewer no path was found.
    pub at_least: usize,
    /// Plans that were made.
    pub plans: u32,
    /// Questions that they asked.
    pub checks: u64,
}

/// Where paths may end.
#[derive(Debug, Clone, Copy)]
pub struct Ends<'a> {
    /// Joint values, one row after the other.
    pub goals: &'a [f64],
    /// The removable objects that have to be gone for each goal, in whatever way it is reached.
    pub needs: &'a [Set],
}

/// The fewest of some removable objects without which a path is found. `without` gives the arm
/// in its scene with some objects gone, `known` is what became of a plan with all in their
/// places: that there is no path, or that none was found. `None` where no path is found without
/// all of them.
///
/// # Errors
///
/// As [`plan`], and those of `without`.
pub fn blockers(
    without: impl Fn(&[usize]) -> Result<Collider>,
    start: &[f64],
    ends: Ends<'_>,
    removable: &[usize],
    known: PathStatus,
    settings: &Settings,
) -> Result<Option<PathBlockers>> {
    let mut search = Search {
        without,
        start,
        ends,
        all: removable.iter().copied().collect(),
        settings,
        checks: 0,
        plans: 0,
    };
    let Look::Way(mut best) = search.look(&search.all.clone())? else { return Ok(None) };
    let mut ways = vec![best.objects.clone()];
    let mut cores: Vec<Core> = Vec::new();
    let mut at_least = usize::from(!best.objects.is_empty());
    let mut stopped = false;
    let known = matches!(
        known,
        PathStatus::PathImpossible | PathStatus::StartInCollision | PathStatus::NoCollisionFree
    );
    while at_least < best.objects.len() {
        // Nothing to be gone was tried before.
        let fewest = match least(&objects(&cores, false), best.objects.len() - 1) {
            Least::Set(fewest) => fewest,
            Least::None => break,
            Least::Unknown => {
                stopped = true;
                break;
            }
        };
        at_least = at_least.max(fewest.len());
        let core = if fewest.is_empty() {
            Some(known)
        } else {
            match search.look_on(&fewest)? {
                None => None,
                Some(Look::Way(way)) => {
                    best = way;
                    break;
                }
                Some(Look::Shut { proven }) => Some(proven),
            }
        };
        let Some(proven) = core else {
            stopped = true;
            break;
        };
        if !search.grow(&fewest, proven, &mut ways, &mut cores, &mut best)? {
            stopped = true;
            break;
        }
    }
    let size = best.objects.len();
    let proven = size == 0
        || match least(&objects(&cores, true), size - 1) {
            // That one has to go at least is known from the plan with all in their places.
            Least::Set(set) => known && size == 1 && set.is_empty(),
            Least::None => true,
            Least::Unknown => false,
        };
    let fewest = match (proven, stopped) {
        (true, _) => Fewest::Proven,
        (_, true) => Fewest::Stopped,
        _ => Fewest::Searched,
    };
    let at_least = if stopped { at_least } else { size };
    search.told(*best, fewest, at_least).map(Some)
}

/// A set of which one object at least has to go.
struct Core {
    objects: Set,
    proven: bool,
}

fn objects(cores: &[Core], proven: bool) -> Vec<&Set> {
    cores.iter().filter(|core| core.proven || !proven).map(|core| &core.objects).collect()
}

/// A path, and the objects that have to be gone for it.
struct Way {
    objects: Set,
    path: Planned,
}

enum Look {
    Way(Box<Way>),
    Shut { proven: bool },
}

struct Search<'a, F> {
    without: F,
    start: &'a [f64],
    ends: Ends<'a>,
    all: Set,
    settings: &'a Settings,
    checks: u64,
    plans: u32,
}

impl<F: Fn(&[usize]) -> Result<Collider>> Search<'_, F> {
    fn is_spent(&self) -> bool {
        self.checks >= EFFORT.saturating_mul(self.settings.max_checks)
    }

    /// [`Search::look`], or nothing where the effort is spent.
    fn look_on(&mut self, gone: &Set) -> Result<Option<Look>> {
        if self.is_spent() { Ok(None) } else { self.look(gone).map(Some) }
    }

    /// Looks for a path with some objects gone.
    fn look(&mut self, gone: &Set) -> Result<Look> {
        let dof = self.start.len();
        let rows: Vec<&[f64]> = self.ends.goals.chunks(dof).collect();
        let free: Vec<usize> =
            (0..rows.len()).filter(|k| self.ends.needs[*k].is_subset(gone)).collect();
        if free.is_empty() {
            return Ok(Look::Shut { proven: true });
        }
        let tried: Vec<usize> = if free.len() <= GOALS {
            free.clone()
        } else {
            (0..GOALS).map(|k| free[k * free.len() / GOALS]).collect()
        };
        let goals: Vec<f64> = tried.iter().flat_map(|k| rows[*k].iter().copied()).collect();
        let settings = Settings { prove: false, ..*self.settings };
        let listed: Vec<usize> = gone.iter().copied().collect();
        let collider = (self.without)(&listed)?;
        let mut path = plan(&collider, self.start, &goals, &settings)?;
        self.checks += path.checks;
        self.plans += 1;
        match path.status {
            PathStatus::Ok => {
                path.goal = path.goal.map(|goal| tried[goal]);
                let mut objects = self.met(&path.path, gone)?;
                if let Some(goal) = path.goal {
                    objects.extend(self.ends.needs[goal].iter());
                }
                Ok(Look::Way(Box::new(Way { objects, path })))
            }
            PathStatus::StartInCollision | PathStatus::StartOutOfLimits => {
                Ok(Look::Shut { proven: true })
            }
            PathStatus::NoCollisionFree | PathStatus::JointLimits => {
                Ok(Look::Shut { proven: tried.len() == free.len() })
            }
            _ => {
                let all: Vec<&[f64]> = free.iter().map(|k| rows[*k]).collect();
                let proven = self.settings.prove && cut(&collider, self.start, &all).is_some();
                Ok(Look::Shut { proven })
            }
        }
    }

    /// Finds a core that has nothing of some objects without which no path was found; false
    /// where the effort is spent before.
    fn grow(
        &mut self,
        gone: &Set,
        proven: bool,
        ways: &mut Vec<Set>,
        cores: &mut Vec<Core>,
        best: &mut Way,
    ) -> Result<bool> {
        loop {
            // No way needs these alone: it would have been the best.
            let rest: Vec<Set> = ways.iter().map(|way| way - gone).collect();
            let core = few(&rest);
            let others: Set = &self.all - &core;
            if others == *gone {
                cores.push(Core { objects: core, proven });
                return Ok(true);
            }
            match self.look_on(&others)? {
                None => return Ok(false),
                Some(Look::Shut { proven }) => {
                    cores.push(Core { objects: core, proven });
                    return Ok(true);
                }
                Some(Look::Way(way)) => {
                    ways.push(way.objects.clone());
                    if way.objects.len() < best.objects.len() {
                        *best = *way;
                        if best.objects.len() <= gone.len().max(1) {
                            return Ok(true);
                        }
                    }
                }
            }
        }
    }

    /// Which of the objects that are gone a path meets.
    fn met(&self, path: &[f64], gone: &Set) -> Result<Set> {
        let keep = self.settings.keep.with_cap(self.settings.keep.clear);
        let mut found = Set::new();
        for object in gone {
            let others: Vec<usize> = gone.iter().copied().filter(|other| other != object).collect();
            let collider = (self.without)(&others)?;
            let checked = check_path(&collider, keep, path, 1, &mut || true)?;
            if !checked.iter().all(Verdict::is_safe) {
                found.insert(*object);
            }
        }
        Ok(found)
    }

    /// The answer, with the distance that the path keeps from all that stays.
    fn told(&self, best: Way, fewest: Fewest, at_least: usize) -> Result<PathBlockers> {
        let Way { objects, mut path } = best;
        let objects: Vec<usize> = objects.into_iter().collect();
        let keep = self.settings.keep;
        let collider = (self.without)(&objects)?;
        let checked = check_path(&collider, keep, &path.path, 1, &mut || true)?;
        for (one, told) in checked.iter().zip(&mut path.clearance) {
            // Proven object by object; a share that is left over may take more questions.
            *told = if one.is_safe() { one.clearance } else { keep.clear.min(keep.own) };
        }
        Ok(PathBlockers { objects, path, fewest, at_least, plans: self.plans, checks: self.checks })
    }
}
