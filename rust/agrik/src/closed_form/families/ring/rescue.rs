//! Goals at which the polynomial is of no use, or which lack one of a pair of postures.

use super::{NOISY, Ring, Work, is_paired};
use crate::closed_form::families::postures::{FINE, NEAR, Set};
use crate::closed_form::geometry::rigid::{Rigid, turn_about};
use crate::closed_form::geometry::screws::Screws;
use crate::closed_form::geometry::serial::Posture;
use crate::lanes::Level;
use crate::random::Sequence;

/// Goals beside a special one, and how far beside, arm lengths and rad.
const BESIDE: usize = 3;
const ASIDE: f64 = 5e-3;
/// Steps back to the goal, and the longest of them, rad.
const BACK: usize = 25;
const SHORT: f64 = 0.1;
/// Share of the largest singular value below which a posture may have a twin near by.
const FLAT: f64 = 0.03;
/// The same below which a posture is one of a family.
const FAMILY: f64 = 1e-9;
/// Mark of a posture at which the Jacobian is singular.
const GENERAL: u8 = 8;
/// How far the twin is looked for, rad.
const TWINS: [f64; 6] = [1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3];

impl Ring {
    /// Looks for more postures of a goal in arm lengths; `paired` as [`Ring::is_paired`] has it.
    pub(super) fn rescue(
        &self,
        level: Level,
        goal: &Rigid<f64>,
        (set, paired): (&mut Set, bool),
        work: &mut Work,
    ) {
        let special = set.noise > NOISY;
        if special || paired || !set.count.is_multiple_of(2) {
            self.elsewhere(level, goal, set, work);
        }
        if set.noise > NOISY {
            self.beside(level, goal, set, work);
        }
        if !set.count.is_multiple_of(2) {
            self.twins(goal, set);
        }
        if special {
            self.families(goal, set);
        }
    }

    /// Whether postures of a goal without isolated ones belong to families: a joint turns freely
    /// while the others follow.
    fn families(&self, goal: &Rigid<f64>, set: &mut Set) {
        for i in 0..set.count {
            let Some((share, v)) = self.weakest(&set.q[i], goal) else { continue };
            if share < FAMILY {
                set.singular[i] = GENERAL;
                let size = |k: usize| v[k].abs();
                let free = (0..6).max_by(|a, b| size(*a).total_cmp(&size(*b))).unwrap_or(0);
                set.free |= 1 << free;
            }
        }
    }

    /// Smallest singular value of the Jacobian as a share of the largest, and its direction.
    fn weakest(&self, q: &[f64; 6], goal: &Rigid<f64>) -> Option<(f64, [f64; 6])> {
        let (_, _, columns) = self.serial.errors(q, goal);
        let jacobian = nalgebra::Matrix6::from_fn(|row, column| columns[column][row]);
        let svd = nalgebra::SVD::try_new(jacobian, false, true, 1e-14, 200)?;
        let least = svd.singular_values.imin();
        let share = svd.singular_values[least] / svd.singular_values.max();
        svd.v_t.map(|v| (share, std::array::from_fn(|k| v[(least, k)])))
    }

    /// A goal that makes first and last joint meet or parallel is no special one for the ring read
    /// from another joint on: that is an arm of its own for each goal.
    fn elsewhere(&self, level: Level, goal: &Rigid<f64>, set: &mut Set, work: &mut Work) {
        let wanted = goal.after(&self.untool);
        let back = wanted.inverse();
        let ring = |first: usize| {
            let (ahead, behind) = self.axes.joints.split_at(first);
            let behind = behind.iter().copied();
            let joints = behind.chain(ahead.iter().map(|one| one.moved(&back))).collect();
            (first, Screws { joints, tool: Rigid::identity() })
        };
        // Neighbours mostly meet or are parallel: the others first.
        let (paired, generic): (Vec<_>, Vec<_>) =
            (1..6).map(ring).partition(|(_, turned)| is_paired(turned, &wanted));
        for (first, turned) in generic.into_iter().chain(paired) {
            let Some(other) = Ring::new(&turned, Some(self)) else { continue };
            let seen = other.scaled(&wanted);
            for cut in 0..2 {
                let mut found = [Set::EMPTY];
                other.run_cut(level, cut, (&[seen], &[]), &mut found, work);
                if found[0].noise > NOISY {
                    continue;
                }
                set.noise = set.noise.min(found[0].noise);
                for q in found[0].postures() {
                    let mut here = *q;
                    here.rotate_right(first);
                    if let Some(q) = self.walked(&here, goal) {
                        set.add(&q);
                    }
                }
                // What is still odd lacks a posture, whatever the others look like.
                if !other.is_doubtful(&found[0]) && set.count.is_multiple_of(2) {
                    return;
                }
            }
        }
    }

    /// Round angles make both polynomials vanish: goals a little aside do not, and their
    /// postures are walked back.
    fn beside(&self, level: Level, goal: &Rigid<f64>, set: &mut Set, work: &mut Work) {
        let mut random = Sequence::new(11);
        let mut unit = || {
            let v: [f64; 3] = std::array::from_fn(|_| 2.0 * random.uniform() - 1.0);
            let size = v.iter().map(|x| x * x).sum::<f64>().sqrt().max(0.1);
            v.map(|x| x / size)
        };
        for _ in 0..BESIDE {
            let (axis, way) = (unit(), unit());
            let turn = turn_about(axis, goal.shift, ASIDE.sin_cos());
            let mut aside = turn.after(goal);
            for (x, w) in aside.shift.iter_mut().zip(way) {
                *x += ASIDE * w;
            }
            for cut in 0..2 {
                let mut near = [Set::EMPTY];
                self.run_cut(level, cut, (&[aside], &[]), &mut near, work);
                for q in near[0].postures() {
                    if let Some(q) = self.walked(q, goal) {
                        set.add(&q);
                    }
                }
            }
        }
    }

    /// Short steps to a goal from a posture near it.
    fn walked(&self, q: &[f64; 6], goal: &Rigid<f64>) -> Option<[f64; 6]> {
        let mut q = *q;
        for _ in 0..BACK {
            let (error, left, columns) = self.serial.errors(&q, goal);
            if left <= FINE * FINE {
                return Some(q);
            }
            let change = self.serial.step(&error, &columns);
            let longest = change.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
            let factor = SHORT / longest.max(SHORT);
            for (x, d) in q.iter_mut().zip(change) {
                *x += factor * d;
            }
        }
        let (_, left, _) = self.serial.errors(&q, goal);
        (left <= NEAR * NEAR).then_some(q)
    }

    /// Near a fold postures come in pairs: steps from both sides of one may lead to the other.
    fn twins(&self, goal: &Rigid<f64>, set: &mut Set) {
        for i in 0..set.count {
            let q = set.q[i];
            let Some((_, v)) = self.weakest(&q, goal).filter(|(share, _)| *share < FLAT) else {
                continue;
            };
            for far in TWINS {
                for side in [far, -far] {
                    let start: [f64; 6] = std::array::from_fn(|k| q[k] + side * v[k]);
                    let Posture { q, left } = self.serial.approach(start, goal, BACK, FINE);
                    if left <= NEAR * NEAR {
                        set.add(&q);
                    }
                }
            }
        }
    }
}
