//! The tomato pointing arm (Kviesis and Osadcuks): shoulder, elbow and pan, all branches.
//!
//! ```text
//! r = l1 cos(phi1) + l2 cos(phi1 + phi2)
//! e = (r cos(phi3), r sin(phi3), l1 sin(phi1) + l2 sin(phi1 + phi2))
//! ```
//!
//! With `D` the target's distance from the shoulder and `rho` from the pan axis:
//! `cos(phi2) = (D^2 - l1^2 - l2^2) / (2 l1 l2)`, elbow up with a negative and down with a
//! positive sine; `phi3 = atan2(Y, X)` and `phi1 = atan2(z, rho) - atan2(l2 sin(phi2),
//! l1 + l2 cos(phi2))`; or the pan half a turn round and `-rho` in place of `rho`. The
//! paper's (5)-(8) have the elbow's sign wrong for its own (10)-(12), X in place of rho, and
//! an arc cosine that loses the sign of z.

use super::{distance, goes_on};
use crate::call::{Answers, Status};
use crate::error::{Error, Result};
use crate::lanes::{Real, hypotenuse};

/// How far past the ends of the reach a target may be, m.
const EDGE: f64 = 1e-12;
/// Nearer to the pan axis, or to the shoulder, than this a direction means nothing, m.
const AXIS: f64 = 1e-9;
/// How far past a servo's limit counts as on it, rad.
const LIMIT: f64 = 1e-12;

/// Joint values phi1 (shoulder), phi2 (elbow), phi3 (pan), rad.
pub type Joints = [f64; 3];

/// What became of a target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Outcome {
    /// Reached.
    Ok = 0,
    /// Farther from the shoulder than the stretched arm.
    TooFar = 1,
    /// Nearer to the shoulder than the folded arm.
    TooNear = 2,
    /// Reached, on the pan axis: the pan keeps its value.
    OnAxis = 3,
    /// The target is not finite.
    BadInput = 4,
    /// No branch within the servos' limits.
    ServoLimit = 5,
}

impl Outcome {
    /// The status in the record that all solvers share.
    pub fn status(self) -> Status {
        match self {
            Self::Ok | Self::OnAxis => Status::Converged,
            Self::TooFar | Self::TooNear | Self::ServoLimit => Status::OutOfReach,
            Self::BadInput => Status::BadInput,
        }
    }
}

/// All branches of a target: elbow up, elbow down, and both with the pan half a turn round.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Branches {
    /// Joint values, angles in (-pi, pi] or where the servo's limits want them.
    pub q: [Joints; 4],
    /// Within the servos' limits.
    pub valid: [bool; 4],
    /// On the pan axis.
    pub on_axis: bool,
}

/// Answers of a batch.
#[derive(Debug, Clone, Default)]
pub struct Solutions {
    /// The record that all solvers share.
    pub answers: Answers,
    /// Codes of [`Outcome`].
    pub outcome: Vec<u8>,
    /// Number of the branch taken, in the order of [`Branches`]; -1 for none.
    pub branch: Vec<i8>,
}

/// The arm: link lengths (m) and servo limits (rad).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arm {
    links: [f64; 2],
    lower: Joints,
    upper: Joints,
}

impl Arm {
    /// Checked lengths and limits.
    pub fn new(links: [f64; 2], lower: Joints, upper: Joints) -> Result<Self> {
        for (name, length) in [("l1", links[0]), ("l2", links[1])] {
            if !(length.is_finite() && length > 0.0) {
                return Err(Error::argument(name, "a finite number above 0", length));
            }
        }
        if (0..3).any(|i| lower[i] > upper[i] || lower[i].is_nan() || upper[i].is_nan()) {
            let received = format!("{lower:?}, {upper:?}");
            return Err(Error::argument("limits", "lower <= upper", received));
        }
        Ok(Self { links, lower, upper })
    }

    /// The tool point, m.
    #[inline]
    pub fn fk(&self, q: &Joints) -> [f64; 3] {
        let [l1, l2] = self.links;
        let (s1, c1) = Real::sin_cos(q[0]);
        let (s12, c12) = Real::sin_cos(q[0] + q[1]);
        let (s3, c3) = Real::sin_cos(q[2]);
        let r = l1 * c1 + l2 * c12;
        [r * c3, r * s3, l1 * s1 + l2 * s12]
    }

    /// All branches of a target (m). `pan` is what the pan keeps on its axis.
    #[inline]
    pub fn branches(&self, target: [f64; 3], pan: f64) -> std::result::Result<Branches, Outcome> {
        if !target.iter().all(|x| x.is_finite()) {
            return Err(Outcome::BadInput);
        }
        let [l1, l2] = self.links;
        let [x, y, z] = target;
        let rho = (x * x + y * y).sqrt();
        let distance = (x * x + y * y + z * z).sqrt();
        if distance > l1 + l2 + EDGE {
            return Err(Outcome::TooFar);
        }
        if distance < (l1 - l2).abs() - EDGE || distance < AXIS {
            return Err(Outcome::TooNear);
        }
        let cos = (distance * distance - l1 * l1 - l2 * l2) / (2.0 * l1 * l2);
        // Products, not 1 - cos^2: right to the last digits near the stretched arm too.
        let near = distance * distance - (l1 - l2) * (l1 - l2);
        let far = (l1 + l2) * (l1 + l2) - distance * distance;
        let sin = (near.max(0.0) * far.max(0.0)).sqrt() / (2.0 * l1 * l2);
        let elbow = sin.atan2(cos);
        let lean = (l2 * sin).atan2(l1 + l2 * cos);
        let on_axis = rho < AXIS;
        let ahead = if on_axis { pan } else { y.atan2(x) };
        let front = z.atan2(rho);
        let back = std::f64::consts::PI.copysign(z) - front;
        let behind = if on_axis { pan } else { ahead + std::f64::consts::PI };
        let q = [
            [front + lean, -elbow, ahead],
            [front - lean, elbow, ahead],
            [back + lean, -elbow, behind],
            [back - lean, elbow, behind],
        ];
        let mut made = Branches { q, valid: [false; 4], on_axis };
        for (q, valid) in made.q.iter_mut().zip(&mut made.valid) {
            *valid = self.settle(q);
        }
        Ok(made)
    }

    /// Brings angles into (-pi, pi], or a turn from there where only that is within the
    /// limits; true where all are.
    #[inline]
    fn settle(&self, q: &mut Joints) -> bool {
        use std::f64::consts::{PI, TAU};
        let mut valid = true;
        for ((x, low), high) in q.iter_mut().zip(self.lower).zip(self.upper) {
            if *x > PI {
                *x -= TAU;
            } else if *x <= -PI {
                *x += TAU;
            }
            let inside = |x: f64| x >= low - LIMIT && x <= high + LIMIT;
            if !inside(*x) {
                match [*x - TAU, *x + TAU].into_iter().find(|x| inside(*x)) {
                    Some(turned) => *x = turned,
                    None => valid = false,
                }
            }
            if valid {
                *x = x.max(low).min(high);
            }
        }
        valid
    }

    /// Joint values for a target: the branch at hand if it is still within the limits,
    /// else the first one that is. No joint moves unless the target is reached.
    #[inline]
    pub fn solve(
        &self,
        target: [f64; 3],
        current: &Joints,
        branch: Option<usize>,
    ) -> std::result::Result<(Joints, usize, Outcome), Outcome> {
        let all = self.branches(target, current[2])?;
        let kept = branch.filter(|b| *b < 4 && all.valid[*b]);
        let chosen = kept.or_else(|| all.valid.iter().position(|valid| *valid));
        let b = chosen.ok_or(Outcome::ServoLimit)?;
        Ok((all.q[b], b, if all.on_axis { Outcome::OnAxis } else { Outcome::Ok }))
    }

    /// Solves a batch of targets (m) from `current`. With `follow`, the targets are a
    /// path: each starts from the joint values and the branch of the one before. `poll` is
    /// asked now and then whether to go on.
    pub fn solve_all(
        &self,
        targets: &[[f64; 3]],
        current: &Joints,
        branch: Option<usize>,
        follow: bool,
        poll: &mut dyn FnMut() -> bool,
    ) -> Result<Solutions> {
        let rows = targets.len();
        let mut out = Solutions {
            answers: Answers::new(rows, 3),
            outcome: vec![Outcome::BadInput as u8; rows],
            branch: vec![-1; rows],
        };
        let (joints, _) = out.answers.q.as_chunks_mut::<3>();
        let (mut at, mut taken) = (*current, branch);
        for (i, (target, q)) in targets.iter().zip(joints).enumerate() {
            goes_on(i, poll)?;
            let outcome = match self.solve(*target, &at, taken) {
                Ok((found, b, outcome)) => {
                    *q = found;
                    out.branch[i] = b as i8;
                    if follow {
                        (at, taken) = (found, Some(b));
                    }
                    outcome
                }
                Err(outcome) => {
                    *q = at;
                    outcome
                }
            };
            if outcome != Outcome::BadInput {
                out.answers.position_error[i] = distance(&self.fk(q), target);
                out.answers.orientation_error[i] = 0.0;
            }
            out.outcome[i] = outcome as u8;
            out.answers.status[i] = outcome.status() as u8;
        }
        Ok(out)
    }

    /// The fixed transpose step length above which the linear iteration diverges at a
    /// posture, 1/m^2: 2 over the largest eigenvalue of `J J^T`.
    pub fn transpose_bound(&self, q: &Joints) -> f64 {
        let [l1, l2] = self.links;
        // The pan's column is orthogonal to the others, whose 2x2 block is in the plane.
        let (s1, c1) = q[0].sin_cos();
        let (s12, c12) = (q[0] + q[1]).sin_cos();
        let r = l1 * c1 + l2 * c12;
        let a = [-(l1 * s1 + l2 * s12), r];
        let b = [-l2 * s12, l2 * c12];
        let (xx, yy) = (a[0] * a[0] + b[0] * b[0], a[1] * a[1] + b[1] * b[1]);
        let xy = a[0] * a[1] + b[0] * b[1];
        let largest = 0.5 * (xx + yy + hypotenuse(xx - yy, 2.0 * xy));
        2.0 / largest.max(r * r)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn free() -> Arm {
        Arm::new([0.16, 0.16], [-PI; 3], [PI; 3]).unwrap()
    }

    /// Reachable targets all around, the same ones every time.
    fn targets(count: usize) -> Vec<[f64; 3]> {
        let mut state = 3u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let arm = free();
        (0..count).map(|_| arm.fk(&[0, 1, 2].map(|_| (next() * 2.0 - 1.0) * 3.1))).collect()
    }

    fn error(arm: &Arm, q: Joints, target: [f64; 3]) -> f64 {
        let p = arm.fk(&q);
        p.iter().zip(target).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
    }

    #[test]
    fn four_branches_reach_every_target() {
        for links in [[0.16, 0.16], [0.2, 0.13]] {
            let arm = Arm::new(links, [-PI; 3], [PI; 3]).unwrap();
            let mut solved = 0;
            for target in targets(20_000) {
                let target = target.map(|x| x * 0.9);
                if let Ok(all) = arm.branches(target, 0.0) {
                    solved += 1;
                    for (q, valid) in all.q.into_iter().zip(all.valid) {
                        assert!(valid && error(&arm, q, target) < 1e-14);
                    }
                }
            }
            assert!(solved > 17_000, "{solved}");
        }
    }

    /// The paper's formulas as printed miss by centimetres: the elbow's sign, the
    /// sign of z lost by an arc cosine, X for the distance from the pan axis.
    #[test]
    fn printed_formulas_miss() {
        let arm = free();
        let [l1, l2] = arm.links;
        let (mut sign, mut below, mut planar) = (Vec::new(), Vec::new(), Vec::new());
        for [x, y, z] in targets(4000) {
            let (rho, d) = (hypotenuse(x, y), (x * x + y * y + z * z).sqrt());
            let acos = |c: f64| c.clamp(-1.0, 1.0).acos();
            let inner = acos((l1 * l1 + d * d - l2 * l2) / (2.0 * l1 * d));
            let elbow = PI - acos((l1 * l1 + l2 * l2 - d * d) / (2.0 * l1 * l2));
            let pan = y.atan2(x);
            // (5) adds two arc cosines, which is elbow up; (7) has phi2 positive.
            sign.push(error(&arm, [z.atan2(rho) + inner, elbow, pan], [x, y, z]));
            if z < 0.0 {
                below.push(error(&arm, [acos(rho / d) + inner, -elbow, pan], [x, y, z]));
            }
            planar.push(error(&arm, [z.atan2(x) + inner, -elbow, pan], [x, y, z]));
        }
        let median = |values: &mut Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values[values.len() / 2]
        };
        assert!(median(&mut sign) > 0.1 && median(&mut below) > 0.1 && median(&mut planar) > 0.02);
    }

    #[test]
    fn outcomes() {
        let arm = free();
        let home = [1.0, -1.5, 0.3];
        let outcome = |t: [f64; 3]| arm.solve(t, &home, None).map_or_else(|o| o, |s| s.2);
        assert_eq!(outcome([0.33, 0.0, 0.0]), Outcome::TooFar);
        assert_eq!(outcome([0.32 + 1e-13, 0.0, 0.0]), Outcome::Ok);
        assert_eq!(outcome([0.0, 0.0, 1e-10]), Outcome::TooNear);
        assert_eq!(outcome([f64::NAN, 0.0, 0.0]), Outcome::BadInput);
        let (q, _, on_axis) = arm.solve([0.0, 0.0, 0.2], &home, None).unwrap();
        assert_eq!((on_axis, q[2]), (Outcome::OnAxis, home[2]));
        let unequal = Arm::new([0.2, 0.1], [-PI; 3], [PI; 3]).unwrap();
        assert_eq!(unequal.branches([0.05, 0.0, 0.0], 0.0), Err(Outcome::TooNear));
        let servo = Arm::new([0.16, 0.16], [0.13, -3.01, -1.0], [3.01, -0.13, 1.0]).unwrap();
        assert_eq!(servo.solve([0.05, 0.0, -0.3], &home, None), Err(Outcome::ServoLimit));
        // Nothing moves unless the target is reached.
        let out = servo
            .solve_all(&[[9.0; 3], [f64::NAN; 3]], &home, None, true, &mut || true)
            .expect("not interrupted");
        assert_eq!(out.answers.q, [home; 2].concat());
        let off = error(&servo, home, [9.0; 3]);
        assert_eq!(out.answers.position_error, [off, f64::INFINITY]);
        assert_eq!(out.answers.orientation_error, [0.0, f64::INFINITY]);
    }

    #[test]
    fn the_branch_is_kept_while_it_is_valid() {
        let arm = free();
        let path: Vec<[f64; 3]> = (0..200).map(|i| [0.2, 0.001 * f64::from(i), 0.1]).collect();
        for b in 0..4 {
            let out = arm
                .solve_all(&path, &[0.0; 3], Some(b), true, &mut || true)
                .expect("not interrupted");
            assert!(out.branch.iter().all(|taken| *taken == b as i8));
            assert!(out.outcome.iter().all(|o| *o == Outcome::Ok as u8));
        }
    }
}
